"""Scores of accepted values on curves whose answer is known."""

import numpy as np

from antires_rs.identification.scores import grades

FREQ = np.linspace(1.0, 20.0, 4000)


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
