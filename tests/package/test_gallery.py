"""Every script of the gallery runs, draws or prints what it promises, and stays short."""

import runpy

import pytest

from tests.support.campaign import some_of
from tests.support.measured_data import DATA
from tests.support.paths import GALLERY

SCRIPTS = sorted(GALLERY.glob("plot_*.py"))
#: Scripts on measured structures, and the folder of their data.
MEASURED = {"plot_southampton_frame": "southampton_3storey", "plot_brake_reuss_beam": "brake_reuss_beam"}
LONGEST = 60
#: These take longer than the others together; `make docs` runs every one.
LONG = {
    "plot_chain8_update",
    "plot_exhaust_damage",
    "plot_exhaust_update",
    "plot_two_objectives",
    "plot_uncertainty",
}
QUICK = [path for path in SCRIPTS if path.stem not in LONG]


@pytest.fixture
def pyplot():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.close("all")
    yield pyplot
    pyplot.close("all")


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_it_is_short_and_opens_with_a_title(path):
    lines = path.read_text(encoding="utf-8").splitlines()
    assert len(lines) < LONGEST
    assert lines[0] == '"""'
    assert lines[2] == "=" * len(lines[1])


@pytest.mark.parametrize("path", some_of(SCRIPTS, QUICK), ids=lambda path: path.stem)
def test_it_runs_and_draws(path, pyplot, capsys, monkeypatch):
    monkeypatch.setenv("ANTIRES_DATA", str(DATA))
    names = runpy.run_path(str(path), run_name="__main__")
    printed = capsys.readouterr().out
    folder = MEASURED.get(path.stem)
    if folder and not (DATA / folder).is_dir():
        assert "ANTIRES_DATA" in printed
        pytest.skip(f"measurement absent: {folder}; set ANTIRES_DATA to the folder that holds it")
    figures = [pyplot.figure(number) for number in pyplot.get_fignums()]
    assert figures
    for figure in figures:
        figure.canvas.draw()
    assert all(figure.axes[0].has_data() for figure in figures)
    if path.stem in FOUND:
        assert FOUND[path.stem](names)


#: What the text beside the pictures says was found.
FOUND = {
    "plot_chain8_damage": lambda n: n["damage"].damaged == [4] and abs(n["damage"].severity[4] - 0.55) < 0.01,
    "plot_chain8_update": lambda n: n["result"].table.largest_after_percent < 0.2,
    "plot_exhaust_update": lambda n: n["result"].table.largest_after_percent < 1.5,
    "plot_exhaust_damage": lambda n: n["damage"].damaged == [30],
    "plot_southampton_frame": lambda n: 1.1 < n["result"].table.largest_after_percent < 2.0,
    "plot_brake_reuss_beam": lambda n: abs(n["found"]["acc2"] / 326.2 - 1.0).min() < 0.01,
    "plot_data_check": lambda n: n["checked"].fatal,
    "plot_stabilization": lambda n: abs(n["zeros"][0] - 12.23).min() > 1.0 and 12.0 in n["edited"][0],
    "plot_own_matrices": lambda n: n["damage"].damaged == [6],
    "plot_frame_model": lambda n: abs(n["result"].x - [0.0018, 0.9, 3.0]).max() < 1e-3,
    "plot_two_objectives": lambda n: all(d.damaged == [4] for d in n["damages"].values()),
    "plot_optimizer": lambda n: n["result"].fun < 1e-2,
    "plot_uncertainty": lambda n: n["problem"].weights.min() < 0.6,
}
