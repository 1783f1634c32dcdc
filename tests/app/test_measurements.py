"""What jobs and commands read: repeats, folders, files that state the force, roving hammers, edits."""

import json
import tomllib
from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app import main as cli
from antires_rs.app.arguments import dof_finder
from antires_rs.app.job import read_job
from antires_rs.app.reading import measured_of
from antires_rs.app.run import measurement_of
from reference.several_forces import record_of
from reference.virtual_records import accelerance, chain8_matrices, hit_record
from tests.support.four_masses import chain, exact
from tests.support.job_files import DAMAGE

pytestmark = pytest.mark.usefixtures("quick_pictures")


def measured(folder, data):
    path = folder / "job.toml"
    path.write_text(DAMAGE.replace('file = "measured.json"\n', data), encoding="utf-8")
    return measured_of(read_job(path), None)


# -- Impacts in a file each
@pytest.fixture
def impacts(tmp_path):
    matrices = chain8_matrices()
    hits = [hit_record(*matrices, duration_s=16.0, noise=0.01, seed=seed)[0][:4] for seed in range(4)]
    records = [ar.Recording(hit, 512.0) for hit in hits]
    for i, rec in enumerate(records):
        ar.write_npz(tmp_path / f"hit_{i}.npz", rec)
    return records


def repeated(folder, repeats):
    data = f'file = "hit_0.npz"\nrepeats = {json.dumps(repeats)}\nexcitation = 0\nband_hz = [3.0, 130.0]\n'
    (one,) = measured(folder, data)
    return one


def test_repeats_of_a_job_and_files_of_one_command(tmp_path, impacts, monkeypatch, capsys):
    wanted = ar.identify_antiresonances(impacts, excitation=0, band_hz=(3, 130))
    one = repeated(tmp_path, ["hit_*.npz"])  # takes the first file up too, which is not read twice
    assert one.found == wanted
    assert [path.name for path in one.repeats] == ["hit_1.npz", "hit_2.npz", "hit_3.npz"]
    (facts,) = measurement_of([one])
    assert facts["File"] == [f"hit_{i}.npz" for i in range(4)]
    assert facts["Record"][0].startswith("4 records of one test, together 64 s at 512 Hz")
    assert repeated(tmp_path, ["hit_1.npz", "hit_2.npz", "hit_3.npz"]).found == wanted
    two = ar.identify_antiresonances(impacts[:2], excitation=0, band_hz=(3, 130))
    assert repeated(tmp_path, "hit_1.npz").found == two
    monkeypatch.chdir(tmp_path)
    files, options = [f"hit_{i}.npz" for i in range(4)], ["--band", "3", "130", "--excitation", "0"]
    assert cli.main(["identify", *files, *options]) == 0
    assert capsys.readouterr().out.rstrip("\n") == str(wanted)
    assert cli.main(["identify", files[0], "job.toml", *options]) == 2
    assert "FILE: got 'job.toml' among several" in capsys.readouterr().err


def test_a_pattern_stands_for_files_and_a_folder_of_records_does_not(tmp_path, impacts, monkeypatch, capsys):
    wanted = ar.identify_antiresonances(impacts, excitation=0, band_hz=(3, 130))
    (one,) = measured(tmp_path, 'file = "hit_*.npz"\nexcitation = 0\nband_hz = [3.0, 130.0]\n')
    assert one.found == wanted
    folder, options = tmp_path / "hits", ["--band", "3", "130", "--excitation", "0"]
    folder.mkdir()
    for i, rec in enumerate(impacts):
        ar.write_npz(folder / f"hit_{i}.npz", rec)
    monkeypatch.chdir(tmp_path)
    assert cli.main(["identify", "hits/hit_*.npz", *options]) == 0  # in quotes
    assert capsys.readouterr().out.rstrip("\n") == str(wanted)
    assert cli.main(["identify", "hits", *options]) == 1
    said = capsys.readouterr().err
    assert "with a record over time" in said
    assert "Name the records, as in hits/*.npz, and not their folder" in said
    assert cli.main(["watch", "hits/hit_0.npz", *options]) == 2
    said = capsys.readouterr().err
    assert said.startswith("antires: error: FOLDER: got 'hits/hit_0.npz', which is a file; wanted the folder")
    assert "Name its folder, 'hits'; 'antires identify' takes files." in said


def test_a_file_with_channels_exchanged_is_named(tmp_path, impacts, monkeypatch, capsys):
    swapped = ar.Recording(impacts[2].responses[[0, 2, 1, 3]], 512.0)
    ar.write_npz(tmp_path / "hit_2.npz", swapped)
    monkeypatch.chdir(tmp_path)
    files = [f"hit_{i}.npz" for i in range(4)]
    assert cli.main(["identify", *files, "--band", "3", "130", "--excitation", "0"]) == 0
    told = (
        "antires: warning: data check: records_differ: Record hit_2.npz: channels 1 and 2 look swapped (mean"
    )
    assert capsys.readouterr().err.startswith(told)
    # A job calls the channels by the names that it gives them.
    data = 'file = "hit_0.npz"\nrepeats = "hit_*.npz"\nexcitation = 0\nband_hz = [3.0, 130.0]\n'
    data += "dofs = {0 = 0, 1 = 2, 2 = 4, 3 = 6}\n"
    with pytest.warns(ar.exceptions.AntiresWarning, match="hit_2.npz: channels '1' and '2' look swapped"):
        measured(tmp_path, data)


def test_seconds_to_record_are_no_number_of_a_record(tmp_path, monkeypatch, capsys):
    model = ar.cases.chain8().model
    given = {"excitation": 0, "fs_hz": 250.0, "duration_s": 8.0, "damping_ratio": 0.01}
    for seed in (0, 1):
        ar.write_npz(tmp_path / f"run_{seed}.npz", model.simulate(**given, rng=seed))
    monkeypatch.chdir(tmp_path)
    call = ["identify", "run_0.npz", "run_1.npz", "--band", "3", "100", "--excitation", "0"]
    assert cli.main(call) == 0
    assert "Record 36 s, better 290 s." in capsys.readouterr().err


def test_a_folder_of_frfs_is_identified_on_the_command_line_and_in_a_job(tmp_path, capsys):
    folder, freq = tmp_path / "frfs", np.arange(1, 1120) / 8
    folder.mkdir()
    for dof, h in enumerate(accelerance(*chain8_matrices(), 0, freq, 0.01)[:4]):
        columns = np.c_[freq, 20 * np.log10(np.abs(h)), np.degrees(np.angle(h))]
        np.savetxt(folder / f"H_{dof}_0.csv", columns, delimiter=",")
    call = ["identify", str(folder), "--band", "3", "130", "--excitation", "0", "--json"]
    assert cli.main([*call, "--pairs", "db_deg", "--max-order", "16"]) == 0
    found = json.loads(capsys.readouterr().out)["antiresonances"]
    assert [row["dof"] for row in found] == list(range(4))
    assert cli.main(call) == 1
    assert "--first freq" in capsys.readouterr().err
    data = 'file = "frfs"\npairs = "db_deg"\nexcitation = 0\nband_hz = [3.0, 130.0]\n'
    data += "[identification]\nmax_order = 16\n"
    (tmp_path / "job.toml").write_text(DAMAGE.replace('file = "measured.json"\n', data))
    assert cli.main(["identify", str(tmp_path / "job.toml"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["antiresonances"] == found


# -- Files that name channels, and state the force
def test_init_lists_the_channels_of_a_measurement(tmp_path, capsys):
    noise = np.random.default_rng(0).standard_normal((2, 64))
    (tmp_path / "data").mkdir()
    named = ar.write_npz(tmp_path / "data" / "named.npz", ar.Recording(noise, 32.0, ["tip [g]", 'a"b']))
    job = tmp_path / "job.toml"
    assert cli.main(["init", str(job), "--data", str(named)]) == 0
    assert f"antires damage {job}" in capsys.readouterr().out
    data = tomllib.loads(job.read_text())["data"]
    assert (data["file"], data["dofs"]) == ("data/named.npz", {"tip [g]": "?", 'a"b': "?"})
    assert data["excitation"] == "?"
    assert cli.main(["damage", str(job)]) == 2
    assert 'got "?"; wanted a dof of the model in place of each "?"' in capsys.readouterr().err
    numbered = ar.write_npz(tmp_path / "record.npz", ar.Recording(noise, 32.0))
    assert cli.main(["init", str(job), "--data", str(numbered), "--overwrite"]) == 0
    assert "dofs" not in tomllib.loads(job.read_text())["data"]
    for place, written in (("1", 1), ("tip [g]", "tip [g]"), ("0,1", "0,1")):  # a number is a dof, no name
        assert cli.main(["init", str(job), "--data", str(named), "--overwrite", "--excitation", place]) == 0
        assert tomllib.loads(job.read_text())["data"]["excitation"] == written
    rounded = tmp_path / "rounded.csv"  # six digits of a time that has more
    rows = (f"{99.985 + i / 2048.0:.6g};{a:.4f};{b:.4f}" for i, (a, b) in enumerate(noise.T))
    rounded.write_text("\n".join(["time [s];a [m/s2];b [m/s2];CH8 [V]", *(f"{row};0" for row in rows), ""]))
    call = ["init", str(job), "--overwrite", "--data", str(rounded)]
    for flags, said in (((), "give the rate by --fs"), (("--fs", "2048"), "hammer by --force")):
        assert cli.main([*call, *flags]) == 1
        assert said in capsys.readouterr().err
    assert cli.main([*call, "--force", "CH8", "--fs", "2048"]) == 0
    data = tomllib.loads(job.read_text())["data"]
    assert (data["fs_hz"], data["force"], data["dofs"]) == (2048.0, "CH8", {"a": "?", "b": "?"})


def test_dofs_of_a_frame_in_every_spelling(tmp_path, capsys):
    steel = {"youngs_modulus_pa": 2.1e11, "density_kg_per_m3": 7850.0}
    tube = {"tube": ar.Tube(0.030, 0.0015, **steel)}
    frame = ar.FrameModel(
        [(0.0, 0.3 * i) for i in range(4)], [(i, i + 1, "tube") for i in range(3)], tube, fixed=[0]
    )
    job: Any = SimpleNamespace(sections={"model": {}}, blame=lambda *_: nullcontext())
    find = dof_finder(job, frame)
    for name in ("node 2 u", "2 u", "2:u", "2u", "2.u", "2_u", "node2u", "node 2 direction u"):
        assert (frame.antiresonances([3], name)[0] == frame.antiresonances([3], frame.dof(2, "u"))[0]).all()
        assert find((), name) == frame.dof(2, "u")
    assert [find((), name) for name in ("CH2", "3rd floor", "2a", "1204+Z")] == [
        "CH2",
        "3rd floor",
        "2a",
        "1204+Z",
    ]
    record = np.random.default_rng(0).standard_normal((4, 500))
    ar.write_csv(
        tmp_path / "run.csv", ar.Recording(record, 100.0, dofs=["2:u", "1 v", "node 3 theta", "mic"])
    )
    job = tmp_path / "job.toml"
    assert cli.main(["init", str(job), "--data", str(tmp_path / "run.csv"), "--model", "frame"]) == 0
    dofs = tomllib.loads(job.read_text(encoding="utf-8"))["data"]["dofs"]
    assert dofs == {"2:u": "node 2 u", "1 v": "node 1 v", "node 3 theta": "node 3 theta", "mic": "?"}


def test_a_job_of_init_reads_names_of_a_frame_and_says_them_again(tmp_path):
    tube = ar.Tube(0.030, 0.0015, 2.1e11, 7850.0)
    ends = [(i, i + 1) for i in range(6)]
    frame = ar.FrameModel([(0.0, 0.3 * i) for i in range(7)], ends, tube, fixed=[0])
    names = [f"node {node} u" for node in range(2, 7)]
    how: Any = {"fs_hz": 2048.0, "duration_s": 30.0, "damping_ratio": 0.01, "noise": 0.01, "rng": 1}
    made = frame.simulate(excitation="node 6 u", responses=names, **how)
    file, job = tmp_path / "now.uff", tmp_path / "job.toml"
    ar.write_uff(file, ar.Recording(made.responses, 2048.0, names))
    call = ["init", str(job), "--data", str(file), "--model", "frame"]
    assert cli.main([*call, "--excitation", "node 3 u", "--band", "5", "700"]) == 0
    text = job.read_text(encoding="utf-8")
    assert tomllib.loads(text)["data"]["dofs"] == dict(zip(names, names, strict=True))
    table = next(line for line in text.splitlines() if line.startswith("dofs = {"))
    for written in (text, text.replace(table, "")):  # channels may have names of the model without a table
        job.write_text(written, encoding="utf-8")
        with pytest.warns(ar.AntiresWarning, match="not seem to act at dof 'node 3 u'.* Dof 'node 6 u'"):
            (one,) = measured_of(read_job(job), frame)
        assert list(one.found) == [frame.dof(node, "u") for node in range(2, 7)]
        (finding,) = one.found.data_check.named("force_location")
        assert "dof 'node 3 u'" in finding.text


def test_init_with_the_file_of_a_model_leaves_nothing_to_fill_in(tmp_path, capsys):
    springs = [np.diag([1.0, 0.0, 0.0]), np.diag([1.0, 1.0, 0.0]), np.diag([0.0, 1.0, 1.0])]
    springs[1][0, 1] = springs[1][1, 0] = springs[2][1, 2] = springs[2][2, 1] = -1.0
    names = ["1:Z", "2:Z", "3:Z"]
    terms = dict(zip(("foot", "web", "tip"), 1e5 * np.array(springs), strict=True))
    model = ar.MatrixModel(sum(terms.values()), np.eye(3), stiffness_terms=terms, dofs=names)
    ar.write_matrices(tmp_path / "model.npz", model)
    for state, loss in (("intact", 0.0), ("now", 0.4)):
        worn = model.with_parameters(ar.stiffness_reduction("web"), loss)
        zeros = {name: worn.antiresonances(name, "3:Z") for name in names[1:]}
        ar.AntiresonanceSet("3:Z", zeros).save(tmp_path / f"{state}.json")
    job = tmp_path / "job.toml"
    files = ["--data", str(tmp_path / "now.json"), "--baseline", str(tmp_path / "intact.json")]
    call = ["init", str(job), *files, "--excitation", "3:Z", "--band", "15", "330"]
    assert cli.main([*call, "--model", str(tmp_path / "model.npz")]) == 0
    assert "Now: antires damage" in capsys.readouterr().out
    written = tomllib.loads(job.read_text())
    assert written["model"] == {"kind": "matrices", "file": "model.npz"}
    assert written["damage"] == {"baseline": "intact.json"}
    assert written["data"] == {"file": "now.json"}
    assert cli.main([*call, "--overwrite", "--model", "matrixes"]) == 2
    assert "Give chain, frame, matrices, result, or the .npz" in capsys.readouterr().err
    assert cli.main(["damage", str(job)]) == 0
    assert "web has lost 40" in capsys.readouterr().out


def test_the_force_that_a_file_states(tmp_path, capsys):
    places = [f"{node}+Y" for node in (1, 2, 3, 4, 5)]
    values = frame().frf([at(place) for place in places], at("3+Y"), FREQ, damping_ratio=0.01)
    response = ar.FrequencyResponse(FREQ, values, dofs=places)
    file, job = ar.write_uff(tmp_path / "a.uff", response, excitation="3+Y"), tmp_path / "job.toml"
    assert cli.main(["init", str(job), "--model", "frame", "--data", str(file)]) == 0
    data = tomllib.loads(job.read_text())["data"]
    assert data["excitation"] == "3+Y"
    assert data["dofs"] == dict.fromkeys(places, "?")
    capsys.readouterr()
    assert cli.main(["damage", str(job)]) == 2
    assert 'got {"1+Y": "?", "2+Y": "?"' in capsys.readouterr().err
    assert cli.main(["identify", str(file), "--band", "5", "350", "--max-order", "12", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["excitation"] == "3+Y"


# -- Values that a job drops and adds
@pytest.fixture
def saved(tmp_path):
    zeros = exact(chain())
    zeros.save(tmp_path / "measured.json")
    return zeros


def edited(folder, more):
    (one,) = measured(folder, f'file = "measured.json"\n{more}\n')
    return one.found


def test_values_are_dropped_and_added_with_their_reasons(tmp_path, saved):
    value = float(saved[1][0])
    drop, add = json.dumps([f"1={value:.3f} mains hum"]), json.dumps("0 = 3.21 clear in the phase")
    found = edited(tmp_path, f"drop = {drop}\nadd = {add}")
    dropped, added = map(str, found.edits)
    assert dropped == f"dropped {value:.2f} Hz at dof 1 (mains hum)"
    assert added == "added 3.21 Hz at dof 0 (clear in the phase)"
    assert found.edits[0].freq_hz == value
    assert found.original() == saved == edited(tmp_path, "")


SENSORS, HITS, ROVED = ("3+Y", "5+Y"), ("1+Y", "2+Y", "3+Y", "4+Y", "5+Y"), ("2", "390")
FREQ = np.arange(1.0, 400.0, 0.5)


def frame():
    rod = ar.Tube(0.02, 0.01, 2.1e11, 7850.0)
    return ar.FrameModel([(0.2 * i, 0.0) for i in range(6)], [(i, i + 1) for i in range(5)], rod, fixed=[0])


def at(point):
    return frame().dof(int(point[0]), "v")


def hit(place, seed):
    values = frame().frf([at(s) for s in SENSORS], at(place), FREQ, damping_ratio=0.01)
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape)
    return ar.FrequencyResponse(FREQ, values + 1e-6 * np.abs(values).max() * noise, dofs=list(SENSORS))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("roving")
    files = {place: folder / f"hit_{place[0]}.uff" for place in HITS}
    single = [ar.write_uff(files[own], hit(own, i), excitation=own) for i, own in enumerate(HITS)]
    (folder / "all.uff").write_bytes(b"".join(file.read_bytes() for file in single))
    return folder / "all.uff", single


CALL = ["--band", *ROVED, "--roving", "3+Y", "--max-order", "24"]


@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")
def test_the_command_line_and_the_page_take_one_file_and_many(files, tmp_path, capsys):
    pytest.importorskip("bokeh", reason="the page needs bokeh")
    from antires_rs.app.look_view import view_of
    from antires_rs.app.parser import parser

    truth = {p: frame().antiresonances(at(p), at("3+Y")) for p in HITS}
    for given, title in ((files[:1], "all.uff"), (files[1], "hit_1.uff and 4 more")):
        call, out = [*map(str, given), *CALL, "--out"], str(tmp_path / "found.json")
        assert cli.main(["identify", *call, out]) == 0
        found = ar.AntiresonanceSet.load(out)
        assert found.excitation == "3+Y"
        assert set(found) == set(HITS)
        seen = 0
        for place in HITS:
            there = truth[place][(truth[place] > 5.0) & (truth[place] < 380.0)]
            for value in found[place]:
                seen += 1
                assert np.abs(there / value - 1.0).min() < 2e-3, (title, place, value, there)
        assert seen >= 5
        view = view_of(parser().parse_args(["look", *call, str(tmp_path / "z.json")]))
        assert view.title == title
        assert view.state(0)["dofs"] == list(found)
    assert "none of the channels" not in capsys.readouterr().err  # a hammer that roves hits other places
    view.do("identify", {})
    assert view.session.zeros == found
    assert view.figure(0)["doc"]
    for dof in found:
        curve = view.session.curve(dof)
        for value in found[dof]:  # a dip of that curve
            near = np.abs(curve.freq_hz / value - 1.0) < 0.02
            assert curve.size[near].min() < 0.2 * np.median(curve.size)
    view.do("identify", {"low_hz": 20.0, "high_hz": 100.0, "max_order": 12})
    assert all(20.0 <= f <= 100.0 for each in view.session.zeros.values() for f in each)


def test_wrong_hits_are_named(files, capsys):
    for more, said in (
        (["--roving", "2+Y"], "--roving: got '2+Y'"),
        (["--roving", "3+Y", "--hit", "1+Y"], "--hit: got 1 places"),
        (["--roving", "3+Y", "--excitation", "1+Y"], "--excitation: got it beside --roving"),
    ):
        assert cli.main(["identify", *map(str, files[1]), "--band", *ROVED, *more]) != 0
        assert said in capsys.readouterr().err


# -- Several forces


def test_several_places_in_a_job_and_on_the_command_line(tmp_path, capsys):
    model = ar.cases.chain8().model
    record = record_of(model, (0, 4), 60.0, 0.01, 1)
    ar.write_npz(tmp_path / "rec.npz", ar.Recording(record.responses, record.fs_hz, list("abcdefgh")))
    data = 'file = "rec.npz"\nband_hz = [3.0, 130.0]\nadd = "b, f = 20.0 by eye"\n'
    (by_name,) = measured(tmp_path, f'{data}excitation = ["e", "a"]\n')
    named = ar.read_npz(tmp_path / "rec.npz")
    wanted = ar.identify_antiresonances(named, excitation=["a", "e"], band_hz=(3, 130))
    assert by_name.found == wanted.add(("b", "f"), 20.0)
    numbered = data.replace("b, f", "1,5") + "dofs = [0, 1, 2, 3, 4, 5, 6, 7]\n"
    (by_number,) = measured(tmp_path, f"{numbered}excitation = [0, 4]\n")
    assert by_number.found.excitation == (0, 4)
    assert by_number.found[1, 5].tolist() == by_name.found["b", "f"].tolist()
    call = ["identify", str(tmp_path / "rec.npz"), "--band", "3", "130", "--excitation", "a,e", "--json"]
    assert cli.main([*call, "--out", str(tmp_path / "z.json")]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["excitation"] == ["a", "e"]
    assert told["antiresonances"][0]["dof"] == ["a", "b"]
    assert ar.AntiresonanceSet.load(tmp_path / "z.json") == wanted
    drop = ["--drop", f"a,b={wanted['a', 'b'][0]:.3f} hum"]
    assert cli.main(["identify", str(tmp_path / "z.json"), *drop]) == 0
    assert "at dof a, b (hum)" in capsys.readouterr().out


def test_damage_by_two_forces_in_a_job_and_its_report_again(tmp_path, capsys):
    model = ar.cases.chain8().model
    damaged = model.with_parameters(ar.stiffness_reduction([4]), [0.3])
    for name, one in (("intact", model), ("now", damaged)):
        ar.write_npz(tmp_path / f"{name}.npz", record_of(one, (0, 4), 120.0, 0.01, 1))
    data = 'file = "now.npz"\nexcitation = [0, 4]\nband_hz = [3.0, 130.0]\n[identification]\n'
    job = DAMAGE.replace('file = "measured.json"', f"{data}dofs = [[0, 1], [1, 2], [2, 3], [3, 4], [0, 5]]")
    job = job.replace("[damage]", '[damage]\nbaseline = "intact.npz"').replace("report = false\n", "")
    (tmp_path / "job.toml").write_text(job)
    assert cli.main(["damage", str(tmp_path / "job.toml")]) == 0
    assert "spring 4" in capsys.readouterr().out
    out = tmp_path / "job_results"
    assert json.loads((out / "summary.json").read_text())["antiresonances"][0]["excitation"] == [0, 4]
    assert cli.main(["report", str(out), "--out", str(tmp_path / "again.html")]) == 0
