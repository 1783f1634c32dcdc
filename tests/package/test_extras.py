"""Without the optional packages: what needs none works, and the rest says what to install."""

import re
import sys
import tomllib

import numpy as np
import pytest

import antires_rs as ar
from antires_rs import figures as plotting
from antires_rs.app import main as cli
from reference.io_signals import recording
from tests.support.paths import ROOT

PROJECT = ROOT / "pyproject.toml"
#: What each extra brings.
PACKAGES = {
    "plot": ("matplotlib",),
    "report": ("jinja2",),
    "look": ("bokeh",),
    "uff": ("pyuff",),
    "hdf5": ("h5py",),
    "tdms": ("npTDMS",),
    "excel": ("openpyxl",),
    "miniseed": ("obspy",),
    "tables": ("pandas", "xarray"),
    "series": ("pyarrow",),
    "watch": ("watchdog",),
    "ansys": ("ansys-mapdl-reader",),
    "dask": ("dask",),
}
#: Extras that bring so much with them that "all" leaves them out.
LARGE = {"ansys", "dask", "miniseed"}


@pytest.fixture
def bare(monkeypatch):
    """An installation without extras."""
    missing = {package.lower() for packages in PACKAGES.values() for package in packages}
    for name in [name for name in sys.modules if name.split(".")[0] in missing]:
        monkeypatch.delitem(sys.modules, name)
    for package in missing:
        monkeypatch.setitem(sys.modules, package, None)


@pytest.fixture(scope="module")
def study():
    """Results of every kind, of a case that takes a moment."""
    case = ar.cases.chain8()
    record = case.experiment(level=1, noise=0.01, rng=1)
    zeros = ar.identify_antiresonances(record, excitation=0, band_hz=(3, 130), max_order=30)
    frame = ar.FrameModel([(0.0, 0.0), (1.0, 0.0)], [(0, 1)], ar.Tube(0.04, 0.002, 2.1e11, 7800.0))
    search = ar.IslandGA(islands=2, population=10, max_evaluations=200)
    three = ar.MassSpringChain([1.0, 1.2, 1.0], [500.0, 450.0])
    damage = ar.assess_damage(case.model, zeros, optimizer=search, rng=0)
    return {
        "chain": case.model,
        "frame": frame,
        "record": record,
        "zeros": zeros,
        "diagram": zeros.diagrams[0],
        "damage": damage,
        "update": ar.update(case.updating_problem(), optimizer=search, rng=0),
        "table": damage.table,
        "hypotheses": ar.assess_damage(case.model, case.exact(1), baseline=case.exact(0)).hypotheses,
        "plan": ar.plan_test(case.model, n_sensors=2, excitations=0),
        "curves": ar.detectability(three, excitation=0, std=5e-4, n_tests=1, rng=0),
        "watched": ar.monitor([case.exact(0)] * 60, baseline=50),
        "check": ar.check_data(record, excitation=0, band_hz=(3, 130)),
        "lines": ar.transmissibility(record, 0, nperseg=4096),
        "responses": ar.frf(record, nperseg=512),
        "comparison": ar.compare(zeros, zeros),
        "tracks": ar.track([zeros, zeros]),
        "identifiability": ar.identifiability(case.updating_problem(), points=4, forces=[], sensors=[]),
    }


#: What of the study each function of ``figures`` draws.
PICTURES = {
    "plot_chain": "chain",
    "plot_coherence": "lines",
    "plot_comparison": "comparison",
    "plot_convergence": "damage",
    "plot_damage": "damage",
    "plot_damages": "damage",
    "plot_damping_clusters": "diagram",
    "plot_detectability": "curves",
    "plot_differences": "table",
    "plot_frame": "frame",
    "plot_hypotheses": "hypotheses",
    "plot_identifiability": "identifiability",
    "plot_monitor": "watched",
    "plot_plan": "plan",
    "plot_responses": "responses",
    "plot_singular_values": "check",
    "plot_stabilization": "diagram",
    "plot_tracks": "tracks",
    "plot_transmissibility": "lines",
}


def test_pictures_say_what_to_install(bare, study):
    drawn = {name: lambda name=name: getattr(plotting, name)(study[PICTURES[name]]) for name in PICTURES}
    drawn["plot_damages"] = lambda: plotting.plot_damages(dict.fromkeys("ab", study["damage"]))
    drawn["plot_transmissibility"] = lambda: plotting.plot_transmissibility(
        study["lines"], study["chain"], dof=1, excitation=0
    )
    drawn["plot_responses"] = lambda: plotting.plot_responses(
        study["responses"], study["chain"], excitation=0
    )
    assert set(drawn) == {name for name in plotting.__all__ if name.startswith("plot_")}
    methods = {type(thing).__name__: thing.plot for thing in study.values() if hasattr(thing, "plot")}
    assert set(methods) >= {name for name in ar.__all__ if hasattr(getattr(ar, name), "plot")}
    methods["AntiresonanceSet"] = lambda: study["zeros"].plot(0)
    for call in (*drawn.values(), *methods.values()):
        with pytest.raises(ar.MissingDependencyError, match=r'pip install "antires-rs\[plot\]"'):
            call()


def test_reports_say_what_to_install(bare, study, monkeypatch, tmp_path):
    for package in ("jinja2", "matplotlib"):
        with pytest.raises(ar.MissingDependencyError, match=r'pip install "antires-rs\[report\]"'):
            study["damage"].report(tmp_path / "run.html")
        monkeypatch.delitem(sys.modules, package)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("read", "package", "extra"),
    [
        ("read_tdms", "nptdms", "tdms"),
        ("read_excel", "openpyxl", "excel"),
        ("read_parquet", "pyarrow", "series"),
        ("read_miniseed", "obspy", "miniseed"),
    ],
)
def test_readers_in_a_child_say_what_to_install(bare, tmp_path, read, package, extra):
    (tmp_path / "a").write_bytes(b"TDSm" + bytes(24))  # a segment without anything in it
    with pytest.raises(ar.MissingDependencyError, match=rf'{package}.*pip install "antires-rs\[{extra}\]"'):
        getattr(ar, read)(tmp_path / "a")


@pytest.mark.parametrize(("name", "extra"), [("a.uff", "uff"), ("a.h5", "hdf5"), ("a.mat", "hdf5")])
def test_readers_say_what_to_install(bare, tmp_path, name, extra):
    path = tmp_path / name
    if extra == "uff":
        ar.write_uff(path, recording())  # writing needs no package
    else:
        path.write_bytes(
            (b"MATLAB 7.3 MAT-file" + 493 * b" " if name == "a.mat" else b"")
            + b"\x89HDF\r\n\x1a\n"
            + bytes(64)
        )
    said = rf'{PACKAGES[extra][0]}.*pip install "antires-rs\[{extra}\]"'
    for read in {
        "a.uff": (ar.read_uff, ar.io.list_uff),
        "a.h5": (ar.read_hdf5,),
        "a.mat": (ar.read_mat, ar.io.mat_arrays),
    }[name]:
        with pytest.raises(ar.MissingDependencyError, match=said):
            read(path)


def test_writers_say_what_to_install(bare, tmp_path):
    with pytest.raises(ar.MissingDependencyError, match=r'pip install "antires-rs\[hdf5\]"'):
        ar.write_hdf5(tmp_path / "a.h5", recording())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("method", ["to_dataframe", "to_xarray"])
def test_tables_say_what_to_install(bare, study, method):
    for thing in (study["record"], study["lines"], study["zeros"]):
        with pytest.raises(ar.MissingDependencyError, match=r'pip install "antires-rs\[tables\]"'):
            getattr(thing, method)()


def test_a_series_in_a_file_says_what_to_install(bare, study, tmp_path):
    series = ar.Series.from_sets([study["zeros"]])
    for call in (
        lambda: series.save(tmp_path / "a.parquet"),
        lambda: ar.identify_series(
            [study["record"]], excitation=0, band_hz=(3, 130), store=tmp_path / "a.parquet"
        ),
    ):
        with pytest.raises(ar.MissingDependencyError, match=r'pyarrow.*pip install "antires-rs\[series\]"'):
            call()
    assert list(tmp_path.iterdir()) == []
    with pytest.raises(ar.MissingDependencyError, match=r'pip install "antires-rs\[tables\]"'):
        series.to_dataframe()


def test_everything_else_needs_no_extra(bare, study, tmp_path, capsys):
    for read, write, name in (
        (ar.read_csv, ar.write_csv, "a.csv"),
        (ar.read_npz, ar.write_npz, "a.npz"),
        (ar.read_mat, ar.write_mat, "a.mat"),
    ):
        write(tmp_path / name, recording())
        np.testing.assert_allclose(read(tmp_path / name).responses, recording().responses, rtol=1e-12)
    assert ar.from_sep005(ar.to_sep005(recording())).n_samples == recording().n_samples
    model = ar.MatrixModel(study["chain"].stiffness(), study["chain"].mass())
    ar.write_matrices(tmp_path / "model.npz", model)
    np.testing.assert_array_equal(
        ar.read_matrices(tmp_path / "model.npz").modes().freq_hz, model.modes().freq_hz
    )
    study["zeros"].save(tmp_path / "zeros.json")
    assert ar.AntiresonanceSet.load(tmp_path / "zeros.json").excitation == 0
    study["damage"].save(tmp_path / "damage.npz")
    assert ar.DamageResult.load(tmp_path / "damage.npz").fun == study["damage"].fun
    table = str(ar.write_csv(tmp_path / "record.csv", study["record"]))
    assert cli.main(["identify", table, "--band", "3", "130", "--excitation", "0"]) == 0
    assert "  0   11.570" in capsys.readouterr().out


def test_the_command_line_says_what_to_install(bare, study, tmp_path, capsys):
    ar.write_uff(tmp_path / "a.uff", recording())
    assert cli.main(["identify", str(tmp_path / "a.uff"), "--band", "3", "9", "--excitation", "0"]) == 1
    assert 'pip install "antires-rs[uff]"' in capsys.readouterr().err
    study["damage"].save(tmp_path / "result.npz")
    assert cli.main(["report", str(tmp_path)]) == 1
    assert 'pip install "antires-rs[report]"' in capsys.readouterr().err


def test_the_page_says_what_to_install(bare, study, tmp_path, capsys):
    study["zeros"].save(tmp_path / "zeros.json")
    assert cli.main(["look", str(tmp_path / "zeros.json")]) == 1
    assert 'pip install "antires-rs[look]"' in capsys.readouterr().err
    with pytest.raises(ar.MissingDependencyError, match=r'pip install "antires-rs\[look\]"'):
        study["zeros"].look()


@pytest.mark.skipif(not PROJECT.is_file(), reason="needs the source tree")
def test_the_extras_bring_what_the_messages_promise():
    extras = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    for extra, packages in PACKAGES.items():
        assert set(packages) <= {re.split(r"[<>=[]", wanted)[0] for wanted in extras[extra]}
    assert set(extras) == {*PACKAGES, "all"}
    assert set(re.findall(r"\w+", extras["all"][0].partition("[")[2])) == set(PACKAGES) - LARGE
    sources = [file.read_text(encoding="utf-8") for file in (PROJECT.parent / "python").rglob("*.py")]
    promises = (
        r"antires-rs\[(\w+)\]",
        r'missing_package\([^)]*"(\w+)", (?:exc|ImportError)\b',
        r'require\((?:"[^"]+"|reader), "[^"]+", "(\w+)"',  # which read in a child process
    )
    named = {extra for source in sources for promise in promises for extra in re.findall(promise, source)}
    assert named == set(PACKAGES)
