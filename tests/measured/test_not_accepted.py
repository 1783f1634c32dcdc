"""What was seen and not accepted goes with a set: through files, edits, other names and problems."""

import numpy as np
import pytest

import antires_rs as ar
from tests.measured.test_files_of_before import FILE

BAND = (8.0, 60.0)


@pytest.fixture(scope="module")
def identified():
    """Of three masses of a free chain of seven, inverted line by line; two sit on nodes of modes."""
    stiffness = 5e4 * (2 * np.eye(7) - np.eye(7, k=1) - np.eye(7, k=-1))
    stiffness[0, 0] = stiffness[-1, -1] = 5e4
    freq = np.arange(5.0, 75.0, 0.05)
    dynamic = stiffness * (1.0 + 0.02j) - ((2 * np.pi * freq) ** 2)[:, None, None] * np.eye(7)
    column = np.linalg.inv(dynamic)[:, [0, 3, 4], 0].T
    rng = np.random.default_rng(1)
    rough = rng.standard_normal(column.shape) + 1j * rng.standard_normal(column.shape)
    column = column + 1e-3 * np.sqrt(np.mean(np.abs(column) ** 2)) * rough
    source = ar.FrequencyResponse(freq, column, dofs=[0, 3, 4])
    return ar.identify_antiresonances(source, excitation=0, band_hz=BAND, check="off")


def assert_same(one, other):
    assert list(one.left_out) == list(other.left_out)
    assert sum(len(table) for table in one.left_out.values()) > 0
    for dof, table in one.left_out.items():
        assert table.same_as(other.left_out[dof])
        assert table.scores.keys() == other.left_out[dof].scores.keys()
        for name, values in table.scores.items():
            assert values.tolist() == pytest.approx(other.left_out[dof].scores[name].tolist(), nan_ok=True)
    assert list(one.unexplained_hz) == list(other.unexplained_hz)
    for dof, values in one.unexplained_hz.items():
        assert np.array_equal(values, other.unexplained_hz[dof])


@pytest.fixture(scope="module")
def found(identified):
    """With a peak that nothing explains at one dof, to the last bit."""
    peaks = {dof: np.array([33.3 + 1e-13]) if dof == 3 else np.empty(0) for dof in identified}
    return type(identified).from_tables(
        0, identified.tables, left_out=identified.left_out, unexplained_hz=peaks, sees="frf"
    )


def test_files_hold_it(identified, found, tmp_path):
    for one in (identified, found, found.drop(0, found[0][0], reason="to see").add(3, 50.0)):
        one.save(tmp_path / "set.json")
        back = ar.AntiresonanceSet.load(tmp_path / "set.json")
        assert_same(one, back)
        assert_same(one.original(), back.original())
        assert str(back).split("left out")[1:] == str(one).split("left out")[1:]
        assert "why" in next(table for table in back.left_out.values() if len(table)).scores


def test_other_names_and_problems_hold_it(found, tmp_path):
    named = found.relabelled("a", {0: "a", 3: "b", 4: "c"})
    assert_same(named.relabelled(0, {"a": 0, "b": 3, "c": 4}), found)
    model = ar.MassSpringChain(np.full(7, 1.0), np.full(6, 5e4))
    problem = ar.UpdatingProblem(model, ar.stiffness_factor([0], bounds=(0.5, 1.5)), found)
    result = ar.update(problem, rng=0, optimizer=ar.IslandGA(max_evaluations=500))
    result.save(tmp_path / "result.npz")
    (back,) = ar.UpdateResult.load(tmp_path / "result.npz").problem.measured
    assert_same(found, back)


def test_older_files_have_none():
    old = ar.AntiresonanceSet.load(FILE)
    assert dict(old.left_out) == {} == dict(old.unexplained_hz)
    made = ar.AntiresonanceSet(0, {0: [8.7]})
    assert "left_out" not in made.to_json()
    assert "unexplained" not in made.to_json()
