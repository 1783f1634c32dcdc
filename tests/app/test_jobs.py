"""Jobs carried out: every kind of data, model and parameter, and what a run writes."""

import json
import sys
from unittest.mock import ANY

import numpy as np
import pytest
from scipy.io import mmwrite

import antires_rs as ar
from antires_rs.app import main as cli
from antires_rs.app.arguments import model_of, parameters_of
from antires_rs.app.job import read_job
from antires_rs.app.reading import measured_of, read_of
from tests.support.campaign import some_of
from tests.support.job_files import DAMAGE, UPDATE, losses, run, write_measured

pytestmark = pytest.mark.usefixtures("quick_pictures")

FOUND = {"spring 4": 0.55}
FILES = {"antiresonances.json", "result.npz", "run.json", "summary.json"}


def test_damage_from_antiresonances(tmp_path, capsys):
    write_measured(tmp_path)
    summary = run(tmp_path, DAMAGE, "--json", "--workers", "1")
    assert json.loads(capsys.readouterr().out) == summary == run(tmp_path, DAMAGE) | {"seconds": ANY}
    assert losses(summary) == FOUND
    assert summary["damaged"] == [4]
    assert summary["headline"] is summary["hypotheses"] is summary["chi_square"] is None
    assert {row["probability"] for row in summary["elements"]} == {None}
    assert set(summary["inputs"]) == {"job.toml", "measured.json"}
    assert summary["command"] == "antires damage job.toml"
    out, err = capsys.readouterr()
    assert "stiffness loss of spring 4   55.00 %" in out
    assert err == ""  # no terminal, no progress
    results = tmp_path / "job_results"
    assert {path.name for path in results.iterdir()} == FILES
    case = ar.cases.chain8()
    same = ar.assess_damage(case.model, case.exact(1), rng=1)
    loaded = ar.DamageResult.load(results / "result.npz")
    assert loaded.x.tobytes() == same.x.tobytes()
    assert loaded.search.populations.tobytes() == same.search.populations.tobytes()
    assert (loaded.fun, loaded.nfev, loaded.seed) == (same.fun, same.nfev, 1)


@pytest.mark.parametrize("name", ["summary.json", "result.npz", "report.html"])
def test_a_job_replaces_no_result_elsewhere_that_no_job_wrote(tmp_path, capsys, name):
    own, mine = tmp_path / "strange", tmp_path / "mine"
    own.mkdir()
    write_measured(own)
    (own / "job.toml").write_text(DAMAGE.replace("[output]", '[output]\nfolder = "../mine"'))
    mine.mkdir()
    (mine / name).write_text("mine")
    assert cli.main(["damage", str(own / "job.toml")]) == 2
    assert f"'mine', which holds {name} of no job" in capsys.readouterr().err
    assert (mine / name).read_text() == "mine"
    (mine / name).unlink()
    assert cli.main(["damage", str(own / "job.toml")]) == 0
    assert cli.main(["damage", str(own / "job.toml")]) == 0  # its own


def test_an_update_and_then_damage_with_its_result(tmp_path):
    write_measured(tmp_path, level=0, perturbation=0.08)
    quick = UPDATE.replace("seed = 1", "seed = 1\nmax_evaluations = 20_000")
    updated = run(tmp_path, quick, name="update.toml")
    assert updated["largest_after_percent"] < 0.58
    assert [row["name"] for row in updated["parameters"]][:1] == ["mass 0"]
    write_measured(tmp_path, level=1, perturbation=0.08)
    chain = DAMAGE[DAMAGE.index('kind = "chain"') : DAMAGE.index("[damage]")]
    found = run(tmp_path, DAMAGE.replace(chain, 'kind = "result"\nfile = "update_results/result.npz"\n\n'))
    assert found["damaged"] == [4]
    assert set(found["inputs"]) == {"job.toml", "measured.json", "update_results/result.npz"}
    other = DAMAGE.replace("[output]", '[output]\nfolder = "update_results"')
    (tmp_path / "other.toml").write_text(other)
    assert cli.main(["damage", str(tmp_path / "other.toml")]) == 2


NAMED = "dofs = { " + ", ".join(f"a{i} = {i}" for i in range(8)) + " }"
POINTS = "dofs = { " + ", ".join(f'"{i + 1}+Z" = {i}' for i in range(8)) + " }"
SIGNALS = {"names in the job": ("named.npz", NAMED), "points of a universal file": ("points.uff", POINTS)}
SIGNALS |= {"one left out": ("named.npz", "dofs = [0, 1, 2, 3, 4, 5, 6, false]"), "CSV": ("named.csv", NAMED)}


def with_data(data):
    return DAMAGE.replace('file = "measured.json"', data)


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    folder = tmp_path_factory.mktemp("records")
    record = ar.cases.chain8().experiment(1, noise=0.01, duration_s=128.0, rng=1)
    named = ar.Recording(record.responses, record.fs_hz, [f"a{dof}" for dof in record.dofs], record.force)
    ar.write_npz(folder / "named.npz", named)
    ar.write_csv(folder / "named.csv", named)
    ar.write_uff(folder / "points.uff", record, dofs={dof: (dof + 1, "+Z") for dof in record.dofs})
    return folder


@pytest.mark.parametrize("kind", some_of(SIGNALS, ["points of a universal file"]))
def test_damage_from_records(records, tmp_path, kind):
    file, dofs = SIGNALS[kind]
    force = '"a0"' if dofs == NAMED else "0"
    (tmp_path / file).write_bytes((records / file).read_bytes())
    data = f'file = "{file}"\nexcitation = {force}\nband_hz = [3, 130]\n{dofs}\n'
    summary = run(tmp_path, with_data(f"{data}[identification]\nmax_order = 30\npersistent = true"))
    assert summary["damaged"] == [4]
    assert {name: pytest.approx(beta.expected, abs=0.02) for name, beta in losses(summary).items()} == FOUND


def test_names_in_a_set_are_mapped_and_left_out_and_its_edits_move_with_them(tmp_path):
    exact = ar.cases.chain8().exact(1)
    named = ar.AntiresonanceSet("m0", {f"m{dof}": exact[dof] for dof in exact})
    named.drop("m1", exact[1][-1], reason="hum").add("m0", 140.0).save(tmp_path / "measured.json")
    names = ", ".join(f"m{dof} = {dof}" for dof in range(7))
    job = job_of(tmp_path, with_data(f'file = "measured.json"\ndofs = {{ {names}, m7 = false }}'))
    (measured,) = measured_of(job, model_of(job))
    found = measured.found
    assert [(e.action, e.dof, e.reason) for e in found.edits] == [("drop", 1, "hum"), ("add", 0, "")]
    assert found.by_hand() == {(0, 140.0)}
    assert found.original() == ar.AntiresonanceSet(0, {dof: exact[dof] for dof in range(7)})


FRAME = """[model]
kind = "frame"
nodes_m = [[0.0, 0.0], [0.25, 0.0], [0.5, 0.0], [0.75, 0.0], [1.0, 0.0]]
elements = [[0, 1, "bar"], [1, 2, "bar"], [2, 3, "bar"], [3, 4, "thin"]]
point_masses = [[4, 0.2, 1e-4]]
ground_springs = [[2, "v", 5e3]]
node_springs = [[0, 4, 1e3]]
fixed = [[0, "v"], [0, "u"]]
[model.sections]
bar = { shape = "rectangle", width_m = 0.03, height_m = 0.01, youngs_modulus_pa = 7e10, \
density_kg_per_m3 = 2700 }
thin = { shape = "tube", outer_diameter_m = 0.02, thickness_m = 0.002, youngs_modulus_pa = 7e10, \
density_kg_per_m3 = 2700, poisson = 0.33 }
"""


def frame_model():
    bar, thin = ar.Rectangle(0.03, 0.01, 7e10, 2700), ar.Tube(0.02, 0.002, 7e10, 2700, poisson=0.33)
    carried = {"point_masses": [ar.PointMass(4, 0.2, 1e-4)], "node_springs": [ar.NodeSpring(0, 4, 1e3)]}
    carried |= {"ground_springs": [ar.GroundSpring(2, "v", 5e3)], "fixed": [(0, ("u", "v"))]}
    lines = [(0, 1, "bar"), (1, 2, "bar"), (2, 3, "bar"), (3, 4, "thin")]
    return ar.FrameModel([[0.25 * i, 0] for i in range(5)], lines, {"bar": bar, "thin": thin}, **carried)


def job_of(folder, text):
    (folder / "job.toml").write_text(text, encoding="utf-8")
    return read_job(folder / "job.toml")


def with_model(base, model):
    start, end = base.index("[model]"), base.index("[damage]" if "[damage]" in base else "[[parameters]]")
    return base[:start] + model + base[end:]


OTHERS = (
    '"thickness"\nsections = ["thin"]\nbounds = [0.0015, 0.0025]',
    '"diameter"\nsections = "thin"\nbounds = [0.018, 0.022]',
    '"angle"\nelements = [3]\npivot = 3\nbounds = [-5, 5]\naxis = [0, 0, 1]',
    '"length"\nelements = [2, 3]\npivot = 2\nbounds = [0.9, 1.1]',
    '"position"\nnodes = [3, 4]\ndirection = [0, 1, 0]\ntogether = true\nbounds = [-0.05, 0.05]',
)


def test_a_frame_and_every_kind_of_parameter(tmp_path):
    kinds = {"stiffness_factor": "elements", "mass_factor": "terms", "youngs_modulus": "sections"}
    kinds |= {"density": "sections", "point_mass": "masses", "inertia": "masses"}
    kinds |= {"support_stiffness": "springs"}
    text = with_model(UPDATE, FRAME)
    text = text[: text.index("[[parameters]]")]
    for kind, on in kinds.items():
        how = "together" if on in ("elements", "terms") else "relative"
        text += f'[[parameters]]\nkind = "{kind}"\n{on} = "all"\nbounds = [0.8, 1.2]\n{how} = true\n'
    job = job_of(tmp_path, text + "".join(f"[[parameters]]\nkind = {one}\n" for one in OTHERS))
    model = model_of(job)
    assert np.array_equal(model.stiffness().toarray(), frame_model().stiffness().toarray())
    assert np.array_equal(model.mass().toarray(), frame_model().mass().toarray())
    parameters, places = parameters_of(job, model)
    both = {"bounds": (0.8, 1.2), "relative": True}
    assert parameters == [
        ar.stiffness_factor(range(4), bounds=(0.8, 1.2), together=True),
        ar.mass_factor(range(5), bounds=(0.8, 1.2), together=True),
        *ar.youngs_modulus(["bar", "thin"], **both),
        *ar.density(["bar", "thin"], **both),
        *ar.point_mass([0], **both),
        *ar.inertia([0], **both),
        *ar.support_stiffness([0], **both),
        *ar.thickness(["thin"], bounds=(0.0015, 0.0025)),
        ar.diameter("thin", bounds=(0.018, 0.022)),
        ar.angle([3], 3, bounds_deg=(-5, 5)),
        ar.length([2, 3], 2, bounds=(0.9, 1.1)),
        ar.position([3, 4], "y", bounds_m=(-0.05, 0.05), together=True),
    ]
    assert len(places) == len(parameters)


def test_dofs_of_a_frame_by_node_and_direction(tmp_path):
    model = frame_model()
    dofs = {f"{node} v": model.dof(node, "v") for node in (1, 2, 3, 4)}
    damaged = model.with_parameters(ar.stiffness_reduction(1), 0.4)
    zeros = damaged.antiresonances(list(dofs.values()), dofs["4 v"], f_max_hz=600.0)
    ar.AntiresonanceSet("node 4 v", dict(zip(dofs, zeros, strict=True))).save(tmp_path / "measured.json")
    job = with_model(DAMAGE, FRAME).replace("[damage]", "[damage]\nelements = [0, 1, 2, 3]")
    assert losses(run(tmp_path, job)) == {"element 1": 0.4}


POINTS = """name;x [mm];y [mm];z [mm];direction
near;250;1;0;+Y
mid;500;0;0;-Y
far;748;0;0;y
tip;1000;0;0;+Y
loose;600;400;0;+Y
"""


def test_channels_are_at_the_nodes_of_their_points(tmp_path):
    """Backwards in one, far from the model in another, not in the table in a third; a set has no sign."""
    model, rng = frame_model(), np.random.default_rng(0)
    names = ["near", "mid", "far", "tip", "loose", "spare"]
    record = ar.Recording(rng.standard_normal((6, 64)), 1000.0, dofs=names)
    ar.write_npz(tmp_path / "record.npz", record)
    (tmp_path / "points.csv").write_text(POINTS)
    given = '[data]\nfile = "record.npz"\npoints = "points.csv"\nexcitation = "mid"\nband_hz = [3, 400]\n'
    job = with_model(DAMAGE, FRAME)
    text = given + job[job.index("[model]") :]
    with pytest.warns(ar.AntiresWarning, match="'?loose'?.* m away|no row of spare"):
        (measured,) = read_of(job_of(tmp_path, text), model)
    assert list(measured.signal.dofs) == [model.dof(node, "v") for node in (1, 2, 3, 4)]
    assert measured.force == model.dof(2, "v")
    np.testing.assert_array_equal(measured.signal.responses, record.responses[:4] * [[1], [-1], [1], [1]])
    ar.AntiresonanceSet("mid", {name: [10.0] for name in names[:5]}).save(tmp_path / "set.json")
    text = text.replace("record.npz", "set.json").replace('excitation = "mid"\nband_hz = [3, 400]\n', "")
    with pytest.warns(ar.AntiresWarning, match="loose"):
        (measured,) = measured_of(job_of(tmp_path, text), model)
    assert list(measured.found) == [model.dof(node, "v") for node in (1, 2, 3, 4)]
    (tmp_path / "points.csv").write_text(POINTS.replace(" [mm]", "").rpartition("loose")[0])
    with pytest.raises(ar.UnsuitableDataError, match="are in mm"):
        measured_of(job_of(tmp_path, text), model)


def test_matrices_of_other_programs(tmp_path):
    case = ar.cases.chain8()
    chain = case.model
    mmwrite(tmp_path / "K.mtx", chain.stiffness(), symmetry="symmetric", precision=17)
    mmwrite(tmp_path / "M.mtx", chain.mass(), symmetry="symmetric", precision=17)
    for i in range(7):
        term = np.zeros((8, 8))
        term[i : i + 2, i : i + 2] = 56.7e3 * np.array([[1, -1], [-1, 1]])
        mmwrite(tmp_path / f"K_{i + 5}.mtx", term, symmetry="symmetric")
    (tmp_path / "K.mapping").write_text("".join(f"{i + 1} {i + 101} UZ\n" for i in range(8)))
    exact = case.exact(1)
    named = {f"{dof + 101}+Z": exact[dof] for dof in exact}
    ar.AntiresonanceSet("101+Z", named).save(tmp_path / "measured.json")
    files = 'stiffness = "K.mtx"\nmass = "M.mtx"\nstiffness_terms = "K_*.mtx"\ndof_map = "K.mapping"\n'
    assert run(tmp_path, with_model(DAMAGE, f'[model]\nkind = "matrices"\n{files}'))["damaged"] == [4]
    terms = [tmp_path / f"K_{i + 5}.mtx" for i in range(7)]
    model = ar.read_matrices(tmp_path / "K.mtx", tmp_path / "M.mtx", stiffness_terms=terms)
    ar.write_matrices(tmp_path / "model.npz", model)
    write_measured(tmp_path)
    again = run(tmp_path, with_model(DAMAGE, '[model]\nkind = "matrices"\nfile = "model.npz"\n'))
    assert again["damaged"] == [4]


def test_transmissibilities_with_names(tmp_path):
    record = ar.cases.chain8().experiment(1, noise=0.01, duration_s=128.0, rng=1)
    t = ar.transmissibility(record, 3, nperseg=8192, estimator="rank1")
    names = [f"m{dof}" for dof in t.dofs]
    ar.write_npz(tmp_path / "t.npz", ar.FrequencyResponse(t.freq_hz, t.values, names, t.kind, "m3"))
    dofs = ", ".join(f"{name} = {dof}" for dof, name in enumerate(names))
    data = f'file = "t.npz"\nexcitation = "m0"\nband_hz = [3, 130]\ndofs = {{ {dofs} }}\n'
    summary = run(tmp_path, with_data(f"{data}[identification]\nmax_order = 30\ndofs = [3, 4]"))
    assert {row["dof"] for row in summary["antiresonances"]} == {3, 4}
    assert 4 in summary["damaged"]
    about = json.loads((tmp_path / "job_results" / "run.json").read_text())["measurement"][0]
    assert about["Dofs"] == [f"{name} = {dof}" for dof, name in enumerate(names)]


def test_without_matplotlib_the_numbers_are_there_and_it_says_what_is_missing(tmp_path, monkeypatch, capsys):
    write_measured(tmp_path)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert run(tmp_path, DAMAGE.replace("report = false\npictures = false\n", ""))["damaged"] == [4]
    assert 'pip install "antires-rs[report]"' in capsys.readouterr().err
    assert not (tmp_path / "job_results" / "report.html").exists()
    monkeypatch.undo()
    assert cli.main(["resume", str(tmp_path / "job.toml")]) == 0
    assert "antires report" in capsys.readouterr().err
    assert cli.main(["report", str(tmp_path / "job_results")]) == 0
    assert "antires damage job.toml" in (tmp_path / "job_results" / "report.html").read_text()


def test_a_new_run_replaces_the_pictures_of_the_one_before_and_nothing_else(tmp_path):
    write_measured(tmp_path)
    run(tmp_path, DAMAGE.replace("report = false\npictures = false\n", ""))
    results = tmp_path / "job_results"
    (results / "pictures" / "photo.png").write_bytes(b"of the test")
    (results / "notes.txt").write_text("mine")
    (results / ".result.npz.4711.tmp").write_bytes(b"half of a killed run")
    run(tmp_path, DAMAGE)
    assert {path.name for path in results.rglob("*")} == FILES | {"notes.txt", "photo.png", "pictures"}


def test_damage_by_modes_with_and_without_a_baseline(tmp_path):
    case = ar.cases.chain8()
    case.exact_modes(level=1).save(tmp_path / "now.json")
    case.exact_modes(level=0).save(tmp_path / "intact.json")
    modal = DAMAGE.replace('[data]\nfile = "measured.json"', '[measured]\nmodes = "now.json"')
    assert losses(run(tmp_path, modal)) == FOUND
    judged = run(tmp_path, modal.replace("[damage]", '[damage]\nbaseline = "intact.json"'))
    assert judged["damaged"] == [4]
    assert judged["probability_of_damage"] > 0.99
    assert set(judged["inputs"]) == {"job.toml", "now.json", "intact.json"}


def test_modes_are_identified_saved_read_back_fitted_or_compared(tmp_path, capsys):
    case = ar.cases.chain8(perturbation=0.05, rng=3)
    record = case.experiment(noise=0.01, duration_s=128.0, rng=1)
    ar.write_npz(tmp_path / "record.npz", ar.Recording(record.responses, record.fs_hz))
    call = ["identify", str(tmp_path / "record.npz"), "--band", "15", "130", "--modes"]
    assert cli.main([*call, "--out", str(tmp_path / "modes.json"), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    found = ar.ModalSet.load(tmp_path / "modes.json")
    assert [row["freq_hz"] for row in shown["modes"]] == found.freq_hz.tolist()
    assert cli.main([*call, "--drop", "3=31"]) == 2
    write_measured(tmp_path, level=0, perturbation=0.05)
    quick = UPDATE.replace("seed = 1", "seed = 1\nmax_evaluations = 3000")
    section = '[measured]\nmodes = "modes.json"\ndofs = [0, 1, 2, 3, 4, 5, 6, false]\n\n'
    data = '[data]\nfile = "measured.json"\n\n'
    fitted = run(tmp_path, quick.replace(data, section + '[updating]\nobjective = "modal"\n\n'))
    assert [row["after_mode"] for row in fitted["modes"]] == [1, 2, 3, 4, 5, 6, 7]
    assert fitted["largest_after_percent"] < 0.02 < 0.5 < fitted["largest_before_percent"]
    assert set(fitted["inputs"]) == {"job.toml", "modes.json"}
    kept = ar.ModalSet.load(tmp_path / "job_results" / "modes.json")
    assert kept.dofs == tuple(range(7))
    assert kept.shapes.tobytes() == found.shapes[:, :7].tobytes()
    beside = run(tmp_path, quick.replace(data, data + section), name="both.toml")
    assert len(beside["antiresonances"]) == 28
    assert max(abs(row["after_hz"] / row["measured_hz"] - 1.0) for row in beside["modes"]) < 0.05
    assert cli.main(["report", str(tmp_path / "both_results")]) == 0
    page = (tmp_path / "both_results" / "report.html").read_text()
    assert "Measured modes, which were not fitted" in page
    assert "paired with mode" in page
