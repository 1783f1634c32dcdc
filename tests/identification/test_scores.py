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


def test_a_plain_stretch_has_no_prominence_and_a_dip_a_negative_one():
    flat = np.ones(FREQ.size)
    assert prominence_db(FREQ, flat, np.array([10.0]), np.array([0.01])) == pytest.approx([0.0], abs=1e-12)
    dip = 1.0 / np.abs(peak(10.0, 0.01))
    assert prominence_db(FREQ, dip, np.array([10.0]), np.array([0.01]))[0] < -10.0


def test_prominence_has_no_unit():
    curve = np.abs(peak(10.0, 0.01))
    at = (np.array([10.0]), np.array([0.01]))
    np.testing.assert_allclose(
        prominence_db(FREQ, 1e6 * curve, *at), prominence_db(FREQ, curve, *at), atol=1e-9
    )


def test_misfit_is_that_around_the_value_only():
    t = np.stack([peak(5.0, 0.01) + peak(15.0, 0.01), peak(5.0, 0.01) - peak(15.0, 0.01)])
    wrong = np.where(FREQ > 10.0, 1.2, 1.0) * t
    got = local_misfit(FREQ, wrong, t, np.array([5.0, 15.0]), np.array([0.01, 0.01]))
    np.testing.assert_allclose(got, [0.0, 0.2], atol=1e-12)


def test_misfit_of_noise_is_the_noise():
    rng = np.random.default_rng(13)
    t = peak(10.0, 0.02)[None, :].repeat(3, axis=0)
    noise = 0.05 * np.abs(t) * (rng.standard_normal(t.shape) + 1j * rng.standard_normal(t.shape)) / np.sqrt(2)
    got = local_misfit(FREQ, t + noise, t, np.array([10.0]), np.array([0.02]))
    assert got == pytest.approx([0.05], rel=0.1)


def test_a_sharp_value_is_judged_by_a_few_lines_at_least():
    got = local_misfit(
        FREQ, peak(10.0, 0.01)[None, :], peak(10.0, 0.01)[None, :], np.array([10.0]), np.array([0.0])
    )
    assert got.tolist() == [0.0]


def test_outside_the_data_nothing_is_known():
    at = (np.array([50.0]), np.array([0.01]))
    assert np.isnan(prominence_db(FREQ, np.ones(FREQ.size), *at)[0])
    assert np.isnan(local_misfit(FREQ, np.ones((1, FREQ.size)), np.ones((1, FREQ.size)), *at)[0])


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
