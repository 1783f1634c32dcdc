"""Severity intervals against a baseline: the quick ones are those of the assessment, the sure ones exact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import kstest

import antires_rs as ar
from antires_rs.damage import question
from antires_rs.damage.evidence import HIGHEST, refitted
from antires_rs.damage.severity_intervals import sampled
from tests.support.campaign import some_of
from tests.support.wrong_chains import N, assessed


@pytest.fixture(scope="module")
def one():
    return assessed(40, [0, 0.3, 0, 0, 0])


def test_quick_intervals_are_those_of_the_assessment(one):
    quick = one.intervals()
    assert {e: quick[e] for e in quick.elements} == one.interval
    assert quick.words == ("not damaged", "two-sided", *3 * ("not damaged",))
    assert quick.draws.shape == quick.mixture.shape == (1000, N - 1)
    assert not quick.draws[:, [0, 2, 3, 4]].any()
    # Wider at a higher level, and at that of the assessment but for the last digits the same.
    for level, wanted in ((0.9001, 1.0), (0.99, 2.5758 / 1.6449)):
        low, high = one.intervals(level=level)[1]
        assert np.isclose((high - low) / (one.interval[1][1] - one.interval[1][0]), wanted, rtol=0.03)
    low, high = np.quantile(quick.draws[:, 1], [0.05, 0.95])
    assert np.allclose([low, high], one.interval[1], atol=0.2 * (high - low))


def test_what_the_baseline_taught_is_kept(one, monkeypatch):
    kept = one.intervals(method="ensemble", draws=60, rng=1)

    def again(*_):
        raise AssertionError("the baseline is learned again")

    monkeypatch.setattr(question, "learned", again)
    same = one.intervals(method="ensemble", draws=60, rng=1)
    np.testing.assert_array_equal(same.draws, kept.draws)
    other = replace(
        one._question, options=ar.SearchOptions(std_common=1e-3)
    )  # another question has to ask for itself
    with pytest.raises(AssertionError, match="learned again"):
        other.prepared(1)


def test_the_sampler_is_exact_against_quadrature(one):
    """Evidence and distribution of one severity, from the likelihood on a fine grid."""
    prepared = one._question.prepared(1)
    likelihood = prepared.likelihood
    beta = np.zeros((1, likelihood.n))
    beta[0, 1] = one.severity[1]
    fit = refitted(likelihood.views(beta)[0], (1,))
    found = sampled(likelihood, fit, 400, np.random.default_rng(0))
    low, high = one.interval[1]
    grid = np.linspace(2.5 * low - 1.5 * high, 2.5 * high - 1.5 * low, 161)
    rows = np.zeros((grid.size, likelihood.n))
    rows[:, 1] = grid
    log_p = np.array([view.log_likelihood for view in likelihood.views(rows)])
    exact, _ = quad(
        lambda b: np.exp(np.interp(b, grid, log_p) - log_p.max()) / HIGHEST, grid[0], grid[-1], limit=400
    )
    assert abs(found.log_evidence - np.log(exact) - log_p.max()) < 0.05
    share = np.cumsum(np.exp(log_p - log_p.max()))
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


def test_the_mixture_holds_every_near_set():
    """Two springs, one with so little damage that it may be none."""
    result = assessed(44, [0, 0.3, 0, 0.002, 0])
    sure = result.intervals("ensemble", draws=400)
    assert len(sure.sets) > 1
    drawn = {tuple(np.flatnonzero(row).tolist()) for row in sure.mixture}
    assert drawn <= {one.elements for one in sure.sets} | {()}
    for one in sure.sets:
        others = [e for e in range(N - 1) if e not in one.elements]
        own = sure.mixture[:, list(one.elements)].all(axis=1) & ~sure.mixture[:, others].any(axis=1)
        assert abs(own.mean() - one.confirmed) < 0.1


def test_nothing_declared_is_nothing():
    result = assessed(42, np.zeros(N - 1))
    sure = result.intervals("ensemble", draws=50)
    assert set(sure.words) == {"not damaged"}
    assert not sure.draws.any()
    assert not sure.high.any()


@pytest.mark.parametrize("tests", some_of([12, 24]))
def test_ranks_of_true_severities_are_uniform(tests):
    """The error of the model counts: without it ranks would gather at both ends."""
    ranks = []
    for seed in range(tests):
        rng = np.random.default_rng(3000 + seed)
        element, loss = seed % 5, rng.uniform(0.05, 0.9)
        losses = np.zeros(N - 1)
        losses[element] = loss
        result = assessed(3000 + seed, losses)
        sure = result.intervals("ensemble", draws=200, rng=seed)
        assert result.damaged == [element]
        ranks.append(np.mean(sure.draws[:, element] < loss))
    assert kstest(ranks, "uniform").pvalue > 0.01


def test_wrong_arguments_are_refused(one):
    with pytest.raises(ar.InvalidInputError, match="method"):
        one.intervals("sure")
    with pytest.raises(ar.InvalidInputError, match="draws"):
        one.intervals(draws=10)
    with pytest.raises(ar.InvalidInputError, match="element"):
        one.intervals()[17]
