"""The one table of a response: order, columns, rows taken and joined, and that nobody changes it."""

import copy
import pickle
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from antires_rs.exceptions import InvalidInputError
from antires_rs.identification.scores import grades
from antires_rs.measured.response_table import ResponseTable


def example():
    return ResponseTable.of_sweep(
        [36.2, 12.2, 20.0],
        [0.02, 0.01, 0.03],
        rows=[30, 11, 25],
        spread=[1e-4, 2e-4, 3e-4],
        dominance=[1.0, 0.9, 0.8],
        how=["chain", "persistent", "chain"],
    )


def test_columns_follow_the_frequencies():
    table = example()
    assert table.freq_hz.tolist() == [12.2, 20.0, 36.2]
    assert table.damping_ratio.tolist() == [0.01, 0.03, 0.02]
    assert table.rows.tolist() == table.orders.tolist() == [11, 25, 30]
    assert table.rows.dtype == np.int64
    assert table.how.tolist() == ["persistent", "chain", "chain"]
    assert np.isnan(table.std_hz).all()
    assert np.isnan(table.residual).all()
    assert not table.by_hand.any()
    assert len(table) == 3


def test_rows_are_taken_with_all_their_columns():
    for chosen in ([0, 2], np.array([True, False, True])):
        some = example().take(chosen)
        assert some.freq_hz.tolist() == [12.2, 36.2]
        assert some.how.tolist() == ["persistent", "chain"]
    none = example().take([])
    assert len(none) == 0
    assert list(none.scores) == list(example().scores)
    assert none.rows.dtype == np.int64


def test_columns_of_another_length_are_named():
    with pytest.raises(InvalidInputError, match=r"^std_hz: got an array of shape \(1,\); wanted 2"):
        ResponseTable([1.0, 2.0], std_hz=[0.1])


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda t: pickle.loads(pickle.dumps(t))])
def test_nothing_of_it_can_be_changed(copied):
    table = copied(example())
    assert table.same_as(example())
    with pytest.raises(FrozenInstanceError):
        table.freq_hz = np.zeros(3)
    with pytest.raises(TypeError, match="read-only"):
        table.scores["how"] = ["chain"] * 3
    for array in (table.freq_hz, table.damping_ratio, table.std_hz, table.by_hand, *table.scores.values()):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = array[1]


def test_grades_count_what_is_passed():
    good = (30, 1e-4, 0.95, 0.05, 10.0)
    bad = (12, 1e-2, 0.50, 0.50, 1.0)
    for passed, word in enumerate(["weak", "weak", "weak", "fair", "sure", "sure"]):
        mixed = [np.array([g if i < passed else b]) for i, (g, b) in enumerate(zip(good, bad, strict=True))]
        assert grades(*mixed).tolist() == [word]


def test_what_is_not_known_is_not_passed():
    unknown = [np.array([value]) for value in (30, 1e-4, np.nan, np.nan, 10.0)]
    assert grades(*unknown).tolist() == ["fair"]
    assert grades(*[np.empty(0)] * 5).size == 0
