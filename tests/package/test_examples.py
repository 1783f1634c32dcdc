"""The examples end in values known from elsewhere."""

import importlib.util

import numpy as np
import pytest

from tests.support.campaign import campaign
from tests.support.paths import EXAMPLES

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
    """Is it damaged, where, how sure: told right from the first line; two of the six cannot be decided."""
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


@campaign
def test_from_file_to_report(tmp_path, capsys):
    """A newcomer's path: the damaged spring at the end, in a report that says what repeats it."""
    report = load("from_file_to_report").main(tmp_path / "study")
    text = report.read_text(encoding="utf-8")
    assert "Spring 4 has lost 55." in text
    assert "antires damage damage.toml" in text
    assert "test.uff  " in text
    assert report.stat().st_size < 3_000_000
    out, err = capsys.readouterr()
    assert "stiffness loss of spring 4" in out
    assert err == ""
    assert len(list((report.parent / "pictures").glob("*.png"))) == 13
