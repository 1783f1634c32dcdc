"""Every script of the gallery runs, draws or prints what it promises, and stays short."""

import importlib.util
import runpy

import numpy as np
import pytest

from tests.support.campaign import some_of
from tests.support.measured_data import DATA
from tests.support.paths import EXAMPLES, GALLERY

SCRIPTS = sorted(GALLERY.glob("plot_*.py"))
MEASURED = {
    "plot_southampton_frame": "southampton_3storey",
    "plot_brake_reuss_beam": "brake_reuss_beam",
    "plot_shaker_table": "shake_table",
}
#: These take longest, or repeat an example below or the page that starts; `make docs` runs every one.
LONG = {"chain8_update", "exhaust_damage", "exhaust_update", "two_objectives", "uncertainty"}
LONG |= {"southampton_frame", "brake_reuss_beam", "chain8_damage"}
QUICK = [path for path in SCRIPTS if path.stem.removeprefix("plot_") not in LONG]


@pytest.fixture
def pyplot():
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.close("all")
    yield pyplot
    pyplot.close("all")


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


FOUND = {
    "plot_chain8_damage": lambda n: n["damage"].damaged == [4] and abs(n["damage"].severity[4] - 0.55) < 0.01,
    "plot_chain8_update": lambda n: n["result"].table.largest_after_percent < 0.2,
    "plot_exhaust_update": lambda n: n["result"].table.largest_after_percent < 1.5,
    "plot_exhaust_damage": lambda n: n["damage"].damaged == [30],
    "plot_southampton_frame": lambda n: 1.1 < n["result"].table.largest_after_percent < 2.0,
    "plot_shaker_table": lambda n: (
        abs(n["found"]["floor 1"] - 5.2).min() < 0.15
        and abs(n["found"]["floor 2"] - 9.3).min() < 0.4
        and n["found"]["floor 3"].size == 0
    ),
    "plot_brake_reuss_beam": lambda n: abs(n["found"]["acc2"] / 326.2 - 1.0).min() < 0.01,
    "plot_data_check": lambda n: n["checked"].fatal,
    "plot_stabilization": lambda n: abs(n["zeros"][0] - 12.23).min() > 1.0 and 12.0 in n["edited"][0],
    "plot_own_matrices": lambda n: n["damage"].damaged == [6],
    "plot_frame_model": lambda n: abs(n["result"].x - [0.0018, 0.9, 3.0]).max() < 1e-3,
    "plot_two_forces": lambda n: (
        abs(n["result"].x - [0.95, 1.06, 0.92, 1.04]).max() < 0.005
        and n["damage"].damaged == [7]
        and abs(n["damage"].severity[7] - 0.2) < 0.03
    ),
    "plot_two_objectives": lambda n: all(d.damaged == [4] for d in n["damages"].values()),
    "plot_optimizer": lambda n: n["result"].fun < 1e-2,
    "plot_uncertainty": lambda n: n["problem"].weights.min() < 0.6,
}


# -- Examples that end in values known from elsewhere


pytestmark = pytest.mark.usefixtures("quick_pictures")


def load(name):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_southampton_frame():
    """At most 2 %; no chain of three masses can fit these zeros below 1.1 %."""
    example = load("southampton_frame")
    if example.data_folder() is None:
        pytest.skip("Southampton data absent; set ANTIRES_DATA to the folder that holds them")
    _, result = example.main()
    assert result.table.measured_hz.size == 8
    assert 1.1 < result.table.largest_after_percent <= 2.0 < result.table.largest_before_percent


def test_brake_reuss_beam():
    example = load("brake_reuss_beam")
    if not example.data_file().is_file():
        pytest.skip(f"record absent: {example.data_file()}; set ANTIRES_DATA")
    found = example.main()
    for dof, aims in (
        ("acc1", [222.7, 556.0, 666.4, 1071.9]),
        ("acc2", [78.9, 326.2, 568.0, 776.0]),
        ("acc3", [291.0, 816.0]),
    ):
        for value in aims:
            assert np.abs(found[dof] / value - 1.0).min() < 0.01, (dof, value)


@pytest.mark.parametrize("example", ["southampton_frame", "brake_reuss_beam"])
def test_an_example_without_its_data_says_so(monkeypatch, tmp_path, capsys, example):
    monkeypatch.setenv("ANTIRES_DATA", str(tmp_path))
    assert load(example).main() is None
    assert "ANTIRES_DATA" in capsys.readouterr().out


def test_six_damage_reports():
    example = load("six_damage_reports")
    first = {case.name: example.assessed(case) for case in example.CASES}
    said = {name: result.headline for name, result in first.items()}
    assert said["clear"].startswith("Damage: spring 4 has lost 40.0 % of its stiffness. Probability above 99")
    assert said["none"].startswith("No damage found: nothing has changed (probability above 99")
    assert said["two"].startswith("Damage: spring 1 has lost 30.0 % of its stiffness and spring 4 20.0 %.")
    assert said["elsewhere"].startswith("Something has changed that none of the candidates explains (probab")
    assert "was no candidate: spring 4 has lost 40.0 %" in said["elsewhere"]
    assert "element 2 or element 3. The values cannot tell which." in said["alike"]
    assert said["small"].startswith("It cannot be told whether there is damage")
    for element in (2, 3):
        assert 0.45 < first["alike"].probability[element] < 0.55
