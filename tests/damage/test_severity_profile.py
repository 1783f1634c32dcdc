"""Profile of a severity against a baseline: the likelihood of the assessment, others fitted again."""

from __future__ import annotations

import numpy as np
import pytest

import antires_rs as ar
from tests.support.wrong_chains import assessed


@pytest.fixture(scope="module")
def two():
    return assessed(40, [0, 0.3, 0, 0.2, 0])


def test_it_agrees_with_the_interval_where_the_likelihood_is_a_parabola(two):
    assert two.damaged == [1, 3]
    for e in (1, 3):
        found = two.profile(two.problem.names[e])
        low, high = two.interval[e]
        assert found.kind == "two-sided"
        assert np.allclose([found.low, found.high], [low, high], atol=0.1 * (high - low))
        inside = found.rise <= found.threshold
        assert found.values[inside].min() >= found.low
        assert found.values[inside].max() <= found.high
        assert found.rise.min() < 0.1
        assert (found.values[0], found.values[-1]) == (0.0, pytest.approx(0.99))


def test_the_others_are_fitted_again(two):
    """Held where it is not, the other severity gives way: the rise is below that with the other as it was."""
    found = two.profile(two.problem.names[1])
    likelihood = two._question.prepared(1).likelihood
    at = int(np.argmin(np.abs(found.values - found.high)))
    betas = np.zeros((2, likelihood.n))
    betas[:, 3] = two.severity[3]
    betas[:, 1] = two.severity[1], found.values[at]
    best, alone = (view.log_likelihood for view in likelihood.views(betas))
    assert found.rise[at] < 2.0 * (best - alone) + 0.05


def test_other_elements_have_none(two):
    with pytest.raises(ar.InvalidInputError, match="element declared damaged"):
        two.profile(two.problem.names[0])
    with pytest.raises(ar.InvalidInputError, match="a severity of the result"):
        two.profile("nothing")
