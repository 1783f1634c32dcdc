"""Scores of accepted values on curves whose answer is known."""

import numpy as np
import pytest

from antires_rs.identification.scores import grades, local_misfit, prominence_db

FREQ = np.linspace(1.0, 20.0, 4000)


def peak(at_hz, damping, size=1.0):
    return size * at_hz**2 / (at_hz**2 - FREQ**2 + 2j * damping * at_hz * FREQ)


def test_a_lone_peak_stands_as_high_as_theory_says():
    # Mean of 1 / (1 + u^2) over -1 to 1 is pi / 4; five bandwidths away, in the middle of the foot, 1 / 101.
    want = 10 * np.log10(np.pi / 4 * 101)
    got = prominence_db(FREQ, np.abs(peak(10.0, 0.01)), np.array([10.0]), np.array([0.01]))
    assert got == pytest.approx([want], abs=0.3)


def test_misfit_is_that_around_the_value_only():
    t = np.stack([peak(5.0, 0.01) + peak(15.0, 0.01), peak(5.0, 0.01) - peak(15.0, 0.01)])
    wrong = np.where(FREQ > 10.0, 1.2, 1.0) * t
    got = local_misfit(FREQ, wrong, t, np.array([5.0, 15.0]), np.array([0.01, 0.01]))
    np.testing.assert_allclose(got, [0.0, 0.2], atol=1e-12)


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
