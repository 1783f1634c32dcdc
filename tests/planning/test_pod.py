"""Curves of detection: known ones are found again, with their bounds."""

import numpy as np
import pytest

from antires_rs.planning.detection_curves import crossing, fit_logit, rising


def draw(rng, n, a90=0.05, slope=4.0):
    severity = np.geomspace(0.01, 0.3, n)
    share = 1.0 / (1.0 + np.exp(-np.log(9.0) - slope * np.log(severity / a90)))
    return severity, rng.uniform(size=n) < share


def test_a_known_curve_is_found_again():
    curve = fit_logit(*draw(np.random.default_rng(0), 4000))
    assert curve.a90 == pytest.approx(0.05, rel=0.06)
    assert curve.slope == pytest.approx(4.0, rel=0.06)
    assert curve.a50 == pytest.approx(0.05 * 9.0 ** (-1 / 4.0), rel=0.06)
    assert curve.at(np.array([curve.a90, curve.a50])) == pytest.approx([0.9, 0.5])


def test_the_bound_holds_in_95_of_100_studies():
    rng = np.random.default_rng(1)
    held = sum(fit_logit(*draw(rng, 60)).bound >= 0.05 for _ in range(150))
    assert 0.90 * 150 <= held <= 0.995 * 150


def test_found_and_missed_with_a_gap_between():
    severity = np.geomspace(0.01, 0.3, 30)
    curve = fit_logit(severity, severity > 0.06)
    assert 0.05 < curve.a90 < 0.075
    assert curve.a90 < curve.bound < 0.12


@pytest.mark.parametrize("hits", [0, 2])
def test_what_is_hardly_ever_found_is_never_found_surely(hits):
    severity = np.geomspace(0.01, 0.9, 40)
    found = np.zeros(40, dtype=bool)
    found[5 : 5 + hits] = True
    curve = fit_logit(severity, found)
    assert curve.a90 > 0.99
    assert curve.bound == np.inf


def test_a_predicted_curve_does_not_fall_and_is_read_between_its_points():
    share = rising(np.array([0.0, 0.5, 0.3, 0.8, 1.0, 0.9]))
    np.testing.assert_allclose(share, [0.0, 0.4, 0.4, 0.8, 0.95, 0.95])
    severity = np.geomspace(0.01, 0.32, 6)
    assert crossing(severity, share, 0.8) == pytest.approx(0.08)
    assert crossing(severity, share, 0.6) == pytest.approx(0.04 * 2**0.5)
    assert crossing(severity, share, 0.99) == np.inf
    assert crossing(severity, np.ones(6), 0.9) == severity[0]
