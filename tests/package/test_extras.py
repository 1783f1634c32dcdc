"""Without the optional packages: what needs none works, and the rest says what to install."""

import re
import sys
import tomllib
from functools import partial

import numpy as np
import pytest

import antires_rs as ar
from antires_rs import figures as plotting
from antires_rs.app import main as cli
from reference.io_signals import recording
from tests.support import every_picture
from tests.support.four_masses import BAND, chain, identified as found_in_record, record
from tests.support.paths import ROOT

PROJECT = ROOT / "pyproject.toml"
PACKAGES = {"plot": ["matplotlib"], "report": ["jinja2"], "look": ["bokeh"], "hdf5": ["h5py"]}
PACKAGES |= {"tdms": ["npTDMS"], "excel": ["openpyxl"], "miniseed": ["obspy"], "dask": ["dask"]}
PACKAGES |= {"tables": ["pandas", "xarray"], "series": ["pyarrow"]}
PACKAGES |= {"ansys": ["ansys-mapdl-reader"], "mesh": ["meshio"], "watch": []}
LARGE = {"ansys", "dask", "miniseed"}  #: Extras that bring so much with them that "all" leaves them out.


@pytest.fixture
def bare(monkeypatch):
    missing = {package.lower() for packages in PACKAGES.values() for package in packages}
    for name in [name for name in sys.modules if name.split(".")[0] in missing]:
        monkeypatch.delitem(sys.modules, name)
    for package in missing:
        monkeypatch.setitem(sys.modules, package, None)


@pytest.fixture(scope="module")
def study():
    lines = ar.transmissibility(record(), 0, nperseg=4096)
    made = {"record": record(), "zeros": found_in_record(), "lines": lines, "damage": every_picture.damage()}
    return made | {"pictures": every_picture.given()}


def test_pictures_say_what_to_install(bare, study):
    pictures = study["pictures"]
    assert {f"plot_{name}" for name in pictures} == {n for n in plotting.__all__ if n.startswith("plot_")}
    drawn = [partial(getattr(plotting, f"plot_{name}"), *a, **more) for name, (*a, more) in pictures.items()]
    things = [study["zeros"], every_picture.updated(), *(first for first, *_ in pictures.values())]
    methods = {type(thing).__name__: thing.plot for thing in things if hasattr(thing, "plot")}
    assert set(methods) >= {name for name in ar.__all__ if hasattr(getattr(ar, name), "plot")}
    methods["AntiresonanceSet"] = lambda: study["zeros"].plot(0)
    for call in (*drawn, *methods.values()):
        with pytest.raises(ar.MissingDependencyError, match=r'pip install "antires-rs\[plot\]"'):
            call()


HEADS = {  #: Files of other programs, with what a reader meets first in them.
    "a.tdms": b"TDSm" + bytes(24),  # a segment without anything in it
    "a.xlsx": b"PK",
    "a.parquet": b"PAR1",
    "a.vtk": b"# vtk DataFile",
    "a.mseed": b"000001D",
    "a.h5": b"\x89HDF\r\n\x1a\n" + bytes(64),
    "a.mat": b"MATLAB 7.3 MAT-file" + 493 * b" " + b"\x89HDF\r\n\x1a\n" + bytes(64),
}


def identified(study, **options):
    return ar.identify_series([study["record"]], excitation=0, band_hz=BAND, **options)


ASKING = [  #: What asks for an extra, by that extra: of the study and a folder with such files.
    ("report", lambda study, folder: study["damage"].report(folder / "run.html")),
    ("look", lambda study, folder: study["zeros"].look()),
    ("tdms", lambda study, folder: ar.read_tdms(folder / "a.tdms")),
    ("excel", lambda study, folder: ar.read_excel(folder / "a.xlsx")),
    ("mesh", lambda study, folder: ar.io.read_mesh(folder / "a.vtk")),
    ("series", lambda study, folder: ar.read_parquet(folder / "a.parquet")),
    ("miniseed", lambda study, folder: ar.read_miniseed(folder / "a.mseed")),
    ("hdf5", lambda study, folder: ar.read_hdf5(folder / "a.h5")),
    ("hdf5", lambda study, folder: ar.read_mat(folder / "a.mat")),
    ("hdf5", lambda study, folder: ar.write_hdf5(folder / "b.h5", recording())),
    *(
        ("tables", lambda study, folder, thing=thing, method=method: getattr(study[thing], method)())
        for thing in ("record", "lines", "zeros")
        for method in ("to_dataframe", "to_xarray")
    ),
    ("tables", lambda study, folder: ar.Series.from_sets([study["zeros"]]).to_dataframe()),
    ("series", lambda study, folder: ar.Series.from_sets([study["zeros"]]).save(folder / "b.parquet")),
    ("series", lambda study, folder: identified(study, store=folder / "b.parquet")),
]


@pytest.mark.parametrize(("extra", "ask"), ASKING)
def test_what_needs_an_extra_says_what_to_install(bare, study, tmp_path, extra, ask):
    ar.read_uff(ar.write_uff(tmp_path / "a.uff", recording()))  # which needs no package
    for name, head in HEADS.items():
        (tmp_path / name).write_bytes(head)
    with pytest.raises(ar.MissingDependencyError, match=rf'pip install "antires-rs\[{extra}\]"') as caught:
        ask(study, tmp_path)
    assert any(package.lower() in str(caught.value).lower() for package in (*PACKAGES[extra], "matplotlib"))
    assert {path.name for path in tmp_path.iterdir()} == {"a.uff", *HEADS}


def test_everything_else_needs_no_extra(bare, study, tmp_path, capsys):
    for kind in ("csv", "npz", "mat"):
        file = getattr(ar, f"write_{kind}")(tmp_path / f"a.{kind}", recording())
        again = getattr(ar, f"read_{kind}")(file)
        np.testing.assert_allclose(again.responses, recording().responses, rtol=1e-12)
    assert ar.from_sep005(ar.to_sep005(recording())).n_samples == recording().n_samples
    model = ar.MatrixModel(chain().stiffness(), chain().mass())
    ar.write_matrices(tmp_path / "model.npz", model)
    np.testing.assert_array_equal(
        ar.read_matrices(tmp_path / "model.npz").modes().freq_hz, model.modes().freq_hz
    )
    study["zeros"].save(tmp_path / "zeros.json")
    assert ar.AntiresonanceSet.load(tmp_path / "zeros.json").excitation == 0
    study["damage"].save(tmp_path / "damage.npz")
    assert ar.DamageResult.load(tmp_path / "damage.npz").fun == study["damage"].fun
    table = str(ar.write_csv(tmp_path / "record.csv", study["record"]))
    call = ["identify", table, "--band", *map(str, BAND), "--excitation", "0", "--max-order", "30"]
    assert cli.main(call) == 0
    assert f"  0  {study['zeros'][0][0]:.5f}" in capsys.readouterr().out


def test_the_command_line_says_what_to_install(bare, study, tmp_path, capsys):
    study["damage"].save(tmp_path / "result.npz")
    study["zeros"].save(tmp_path / "zeros.json")
    for extra, *call in (("report", "report", tmp_path), ("look", "look", tmp_path / "zeros.json")):
        assert cli.main([str(word) for word in call]) == 1
        assert f'pip install "antires-rs[{extra}]"' in capsys.readouterr().err


@pytest.mark.skipif(not PROJECT.is_file(), reason="needs the source tree")
def test_the_extras_bring_what_the_messages_promise():
    extras = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    for extra, packages in PACKAGES.items():
        assert set(packages) <= {re.split(r"[<>=[]", wanted)[0] for wanted in extras[extra]}
    assert set(extras) == {*PACKAGES, "uff", "all"}
    assert set(re.findall(r"\w+", extras["all"][0].partition("[")[2])) == set(PACKAGES) - LARGE
    sources = [file.read_text(encoding="utf-8") for file in (PROJECT.parent / "python").rglob("*.py")]
    promises = (r"antires-rs\[(\w+)\]", r'require\((?:"[^"]+"|\w+), (?:"[^"]+"|\w+), "(\w+)"')
    named = {extra for source in sources for promise in promises for extra in re.findall(promise, source)}
    assert named == {extra for extra, packages in PACKAGES.items() if packages}
