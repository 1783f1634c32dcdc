"""Roots that the model loses on the way to a damage, and those that go far while others are lost."""

from __future__ import annotations

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.damage.likelihood import Foreseen, and_vanished
from antires_rs.damage.measured_states import Roots, follow

#: The cracked element of the exhaust, and the stiffness losses of a beam that its cracks come to.
CRACKED, EQUIVALENT = 30, {1: 0.881, 2: 0.934}


def roots(places):
    return Roots(np.zeros(len(places), dtype=np.intp), np.array(places), np.empty((len(places), 0)))


def test_what_moves_far_is_followed_while_a_pair_vanishes():
    """Large damage lowers all of a response, and two have met."""
    before = roots([1.0, 1.6, 2.0, 2.3, 2.35])
    assert follow(before, roots([0.9, 1.45, 1.78])).tolist() == [0, 1, 2]


def test_what_is_gone_takes_its_place_with_little_to_say():
    there = Foreseen(
        response=np.array([0, 0, 2]),
        place=np.array([1.0, 3.0, 1.5]),
        beside=np.array([0.1, 0.2, 0.3]),
        spread=np.diag([1.0, 2.0, 3.0]),
        change=np.array([0.01, 0.02, 0.03]),
        slopes=np.arange(6.0).reshape(3, 2),
        seen=np.array([True, True, True]),
    )
    both = and_vanished(there, (np.array([0, 1]), np.array([2.0, 0.5])))
    assert both.response.tolist() == [0, 0, 0, 1, 2]
    assert both.place.tolist() == [1.0, 2.0, 3.0, 0.5, 1.5]
    assert both.seen.tolist() == [True, False, True, False, True]
    assert both.slopes.tolist() == [[0, 1], [0, 0], [2, 3], [0, 0], [4, 5]]
    assert np.diag(both.spread)[[0, 2, 4]].tolist() == [1.0, 2.0, 3.0]
    assert np.allclose(both.spread, np.diag(np.diag(both.spread)))
    assert and_vanished(there, (np.empty(0, dtype=np.intp), np.empty(0))) is there


def exhaust_set(case, level, std=5e-4):
    rng = np.random.default_rng(50 + level)
    exact = case.exact(level=level)
    freq = {dof: f * (1.0 + std * rng.standard_normal(len(f))) for dof, f in exact.items()}
    return ar.AntiresonanceSet(exact.excitation, freq, std_hz={dof: std * f for dof, f in freq.items()})


@pytest.mark.parametrize("level", [1, 2])
def test_the_likelihood_has_no_cliff_where_two_roots_of_the_model_meet(level):
    """At 85.8 % two roots of the model, never updated, vanish whose values are still measured."""
    case = ar.cases.exhaust()
    result = ar.assess_damage(
        case.model, exhaust_set(case, level), baseline=exhaust_set(case, 0), elements=[CRACKED]
    )
    likelihood = result._question.prepared(1).likelihood
    grid = np.arange(0.80, 0.94, 0.005)
    betas = np.zeros((grid.size, likelihood.n))
    betas[:, 0] = grid
    found = np.array([view.log_likelihood for view in likelihood.views(betas)])
    assert np.abs(np.diff(found)).max() < 3.5  # 13 and more where values of lost roots were false ones
    assert found.max() - np.interp(EQUIVALENT[level], grid, found) < 5.5
