"""A hammer that roved: all hits in one universal file, or a file for each."""

import json

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.app import main as cli

pytest.importorskip("pyuff")
SENSORS, HITS, BAND = ("3+Y", "5+Y"), ("1+Y", "2+Y", "3+Y", "4+Y", "5+Y"), ("2", "390")
FREQ = np.arange(1.0, 400.0, 0.25)


def frame():
    rod = ar.Tube(0.02, 0.01, 2.1e11, 7850.0)
    return ar.FrameModel([(0.2 * i, 0.0) for i in range(6)], [(i, i + 1) for i in range(5)], rod, fixed=[0])


def at(point):
    return frame().dof(int(point[0]), "v")


def hit(place, seed):
    """FRFs of the sensors to a force at that place, with a little noise."""
    values = frame().frf([at(s) for s in SENSORS], at(place), FREQ, damping_ratio=0.01)
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal(values.shape) + 1j * rng.standard_normal(values.shape)
    return ar.FrequencyResponse(FREQ, values + 1e-6 * np.abs(values).max() * noise, dofs=list(SENSORS))


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("roving")
    single = [
        ar.write_uff(folder / f"hit_{place[0]}.uff", hit(place, i), excitation=place)
        for i, place in enumerate(HITS)
    ]
    (folder / "all.uff").write_bytes(b"".join(file.read_bytes() for file in single))
    return folder / "all.uff", single


def test_reciprocity_reads_all_hits_as_one_response(files):
    read = ar.read_uff(files[0], roving="3+Y")
    assert read.dofs == HITS
    for i, place in enumerate(HITS):
        np.testing.assert_array_equal(read.values[i], hit(place, i).values[0])
    with pytest.raises(ar.UnsuitableDataError, match=r"FRFs at the responses 3\+Y, 5\+Y"):
        ar.read_uff(files[0], roving="2+Y")
    with pytest.raises(ar.InvalidInputError, match="roving: got 'tip'"):
        ar.read_uff(files[0], roving="tip")


def identified(out, *args):
    assert cli.main(["identify", *map(str, args), "--band", *BAND, "--out", str(out)]) == 0
    return ar.AntiresonanceSet.load(out)


@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")
def test_the_command_line_takes_both(files, tmp_path, capsys):
    truth = {p: frame().antiresonances(at(p), at("3+Y")) for p in HITS}
    for name, given in (("one", files[:1]), ("many", files[1])):
        found = identified(tmp_path / f"{name}.json", *given, "--roving", "3+Y")
        assert found.excitation == "3+Y"
        assert set(found) == set(HITS)
        seen = 0
        for place in HITS:
            there = truth[place][(truth[place] > 5.0) & (truth[place] < 380.0)]
            for value in found[place]:
                seen += 1
                assert np.abs(there / value - 1.0).min() < 2e-3, (name, place, value, there)
        assert seen >= 5
    assert json.loads((tmp_path / "one.json").read_text())
    assert "none of the channels" not in capsys.readouterr().err  # a hammer that roves hits other places


@pytest.mark.filterwarnings("ignore::antires_rs.AntiresWarning")
def test_the_page_shows_what_identify_finds(files, tmp_path):
    pytest.importorskip("bokeh", reason="the page needs bokeh")
    from antires_rs.app.look_view import view_of
    from antires_rs.app.parser import parser

    for given in (files[:1], files[1]):
        found = identified(tmp_path / "found.json", *given, "--roving", "3+Y")
        call = ["look", *map(str, given), "--roving", "3+Y", "--band", *BAND]
        view = view_of(parser().parse_args([*call, "--out", str(tmp_path / "z.json")]))
        assert not view.state(0)["identified"]
        assert view.state(0)["dofs"] == list(found)
        view.do("identify", {})
        session = view.session
        assert session.zeros == found
        assert list(session.zeros.diagrams) == [dof for dof in found if dof in session.zeros.diagrams] != []
        for number, dof in enumerate(session.zeros):
            assert view.figure(number)["doc"]
            curve = session.curve(dof)
            for value in session.zeros[dof]:  # a dip of that curve
                near = np.abs(curve.freq_hz / value - 1.0) < 0.02
                assert curve.size[near].min() < 0.2 * np.median(curve.size)
        band = (20.0, 300.0)
        view.do("identify", {"low_hz": band[0], "high_hz": band[1]})
        assert session.now.band_hz == band
        assert all(band[0] <= f <= band[1] for each in session.zeros.values() for f in each)
    assert view.title == "hit_1.uff and 4 more"


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--roving", "2+Y"], "--roving: got '2+Y'"),
        (["--roving", "3+Y", "--hit", "1+Y"], "--hit: got 1 places"),
        (["--roving", "3+Y", "--excitation", "1+Y"], "--excitation: got it beside --roving"),
    ],
)
def test_wrong_hits_are_named(files, capsys, more, said):
    assert cli.main(["identify", *map(str, files[1]), "--band", *BAND, *more]) != 0
    assert said in capsys.readouterr().err
