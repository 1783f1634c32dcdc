"""Severity intervals and profiles against a baseline: the quick ones are those of the assessment, the sure
ones exact."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad, trapezoid

import antires_rs as ar
from antires_rs.damage.inference import HIGHEST, log_odds_threshold, refitted
from antires_rs.damage.options import SearchOptions
from antires_rs.damage.severity_intervals import sampled
from reference.wrong_chains import N, assessed


@pytest.fixture(scope="module")
def one():
    return assessed(40, [0, 0.3, 0, 0, 0])


def logs_of(result, rows):
    likelihood = result._question.prepared(1).likelihood
    betas = np.zeros((len(rows), likelihood.n))
    for beta, row in zip(betas, rows, strict=True):
        beta[list(row)] = list(row.values())
    return np.array([view.log_likelihood for view in likelihood.views(betas)])


def test_quick_intervals_are_those_of_the_assessment(one):
    quick = one.intervals()
    assert {e: quick[e] for e in quick.elements} == one.interval
    assert quick.words == ("not damaged", "two-sided", *3 * ("not damaged",))
    assert quick.draws.shape == quick.mixture.shape == (1000, N - 1)
    assert not quick.draws[:, [0, 2, 3, 4]].any()
    for level, wanted in ((0.9001, 1.0), (0.99, 2.5758 / 1.6449)):
        low, high = one.intervals(level=level)[1]
        assert np.isclose((high - low) / (one.interval[1][1] - one.interval[1][0]), wanted, rtol=0.03)
    low, high = np.quantile(quick.draws[:, 1], [0.05, 0.95])
    assert np.allclose([low, high], one.interval[1], atol=0.2 * (high - low))


def test_the_sampler_is_exact_against_quadrature(one):
    likelihood = one._question.prepared(1).likelihood
    beta = np.zeros((1, likelihood.n))
    beta[0, 1] = one.severity[1]
    found = sampled(likelihood, refitted(likelihood.views(beta)[0], (1,)), 400, np.random.default_rng(0))
    low, high = one.interval[1]
    grid = np.linspace(2.5 * low - 1.5 * high, 2.5 * high - 1.5 * low, 161)
    log_p = logs_of(one, [{1: b} for b in grid])
    log_p -= (top := log_p.max())
    exact, _ = quad(lambda b: np.exp(np.interp(b, grid, log_p)) / HIGHEST, *grid[[0, -1]], limit=400)
    assert abs(found.log_evidence - np.log(exact) - top) < 0.05
    share = np.cumsum(np.exp(log_p))
    share /= share[-1]
    for q in (0.05, 0.5, 0.95):
        assert abs(found.quantiles(0, (q, q))[0] - np.interp(q, share, grid)) < 0.06 * (high - low)


def test_sure_intervals_confirm_where_the_model_is_nearly_linear(one):
    sure = one.intervals("ensemble", rng=3)
    quick = one.interval[1]
    assert np.allclose(sure[1], quick, atol=0.1 * (quick[1] - quick[0]))
    assert sure["stiffness loss of spring 2"] == (0.0, 0.0)
    first = sure.sets[0]
    assert first.elements == (1,)
    assert first.effective > 100.0
    assert abs(first.confirmed - first.probability) < 0.02
    assert sure.notes[0].startswith("Sampling confirms the probabilities to within 0.0")
    assert np.isclose(sure.std[1], sure.draws[:, 1].std())


def test_same_bits_for_any_number_of_workers_and_others_for_another_seed(one):
    first, second, other = (
        one.intervals("ensemble", draws=100, rng=seed, workers=workers)
        for seed, workers in ((1, 1), (1, 2), (2, 1))
    )
    assert first == second
    assert first != other


def test_the_mixture_holds_every_near_set_and_nothing_where_nothing_is_declared():
    sure = assessed(46, [0.003, 0, 0, 0, 0]).intervals("ensemble", draws=400)
    assert 0.3 < sure.sets[0].confirmed < 0.9
    drawn = {tuple(np.flatnonzero(row).tolist()) for row in sure.mixture}
    assert drawn <= {each.elements for each in sure.sets} | {()}
    for each in sure.sets:
        own = (sure.mixture > 0.0) == np.isin(np.arange(N - 1), each.elements)
        assert abs(own.all(axis=1).mean() - each.confirmed) < 0.1
    sure = assessed(42, np.zeros(N - 1)).intervals("ensemble", draws=50)
    assert set(sure.words) == {"not damaged"}
    assert not sure.draws.any()
    assert not sure.high.any()


def test_a_profile_agrees_with_the_interval_where_the_likelihood_is_a_parabola():
    two = assessed(40, [0, 0.3, 0, 0.2, 0])
    assert two.damaged == [1, 3]
    for e in (1, 3):
        found = two.profile(two.problem.names[e])
        low, high = two.interval[e]
        assert found.kind == "two-sided"
        assert np.allclose([found.low, found.high], [low, high], atol=0.1 * (high - low))
        inside = found.rise <= found.threshold
        assert found.low <= found.values[inside].min() <= found.values[inside].max() <= found.high
        assert found.rise.min() < 0.1
        assert (found.values[0], found.values[-1]) == (0.0, pytest.approx(0.99))


WRONG = [("method", lambda one: one.intervals("sure")), ("draws", lambda one: one.intervals(draws=10))]
WRONG += [("element", lambda one: one.intervals()[17])]
WRONG += [("element declared damaged", lambda one: one.profile(one.problem.names[0]))]
WRONG += [("a parameter of the result", lambda one: one.profile("nothing"))]


@pytest.mark.parametrize(("wrong", "asked"), WRONG)
def test_wrong_arguments_are_refused(one, wrong, asked):
    with pytest.raises(ar.InvalidInputError, match=wrong):
        asked(one)


# ---- Gaussians within a box, their draws, the sampler and the threshold, against integrals that are known


def test_the_threshold_is_the_quantile_of_integrated_evidence():
    """Elements from well seen to hardly seen at all: a severity that nothing shows gains no evidence."""
    rng, prior = np.random.default_rng(0), ar.DamagePrior()
    slopes = np.linalg.qr(rng.standard_normal((6, 6)))[0] * [100.0, 10.0, 3.0, 1.0, 0.1, 1e-3]
    beta = np.linspace(0.0, 0.99, 2001)
    values = np.random.default_rng(1).standard_normal((4000, 6))
    odds = np.zeros(4000)
    for own in slopes.T:
        gain = np.outer(values @ own, beta) - 0.5 * (own @ own) * beta**2
        odds += trapezoid(np.exp(gain), beta, axis=1) / 0.99
    for rate in (0.3, 0.05):
        wanted = np.log(np.quantile(odds, 1.0 - rate)) + prior.log_of(1, 6) - prior.log_of(0, 6)
        options = SearchOptions(false_alarm_rate=rate)
        found = log_odds_threshold(slopes, prior, options, np.random.default_rng(1))
        assert abs(found - wanted) < 1e-3
