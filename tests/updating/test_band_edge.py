"""At the edge of the band in which the model is asked for antiresonances, J does not jump."""

import numpy as np
import pytest

import antires_rs as ar


def leaving(measured, springs):
    """J and its residuals while a spring grows, which takes the one antiresonance of mass 0 away."""
    chain = ar.MassSpringChain([1.0, 1.0], [400.0], ground_last_n_per_m=400.0)
    zeros = ar.AntiresonanceSet(0, {0: measured})
    problem = ar.UpdatingProblem(chain, ar.stiffness_factor([0], bounds=(0.5, 10.0)), zeros)
    x = springs[:, None]
    return problem, problem.evaluate_many(x), np.array([problem.residuals(row) for row in x])


def hz(factor):
    """The antiresonance of mass 0: mass 1 on both its springs."""
    return np.sqrt(400.0 * (1.0 + factor)) / (2 * np.pi)


@pytest.mark.parametrize("others", [[], [1.0]])
def test_nothing_jumps_where_an_antiresonance_leaves_the_band(others):
    highest = hz(1.0)
    measured = [*others, highest]
    factors = np.linspace(1.0, 4.0, 6001)
    problem, costs, residuals = leaving(measured, factors)
    ratio = hz(factors) / highest
    assert ratio[0] == 1.0
    assert ratio[-1] > 1.55
    # Beyond the limit there is no partner and each value counts as one.
    assert np.isnan(problem.paired_hz([factors[-1]])).all()
    np.testing.assert_array_equal(residuals[-1], 1.0)
    # Below 1.49 times the highest it is the documented e.
    plain = ratio < 1.49
    wanted = (hz(factors[plain])[:, None] / np.array(measured)) ** 2 - 1.0
    np.testing.assert_allclose(residuals[plain], wanted, rtol=1e-9, atol=1e-12)
    # In between J falls from there to what is left, evenly: no step is more than a few of the mean slope.
    np.testing.assert_allclose(np.abs(residuals).sum(axis=1), costs, rtol=1e-12)
    steps = np.abs(np.diff(costs))
    fading = np.count_nonzero((ratio > 1.49) & (ratio < 1.5))
    assert steps.max() < 3.0 * np.ptp(costs) / fading
