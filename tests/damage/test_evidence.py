"""Gaussians within a box against other methods, draws against rejection, the sampler and the threshold of a
rate of false alarms against integrals that are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import kstest, multivariate_normal, norm

import antires_rs as ar
from antires_rs.damage.evidence import FURTHEST, log_inside, truncated
from antires_rs.damage.inference import log_odds_threshold
from antires_rs.damage.options import SearchOptions
from antires_rs.updating.posterior import stepwise


def correlated(rng, n):
    """Means and covariances as severities have them: some near a bound, some strongly correlated."""
    rows = rng.standard_normal((n, n + 1))
    spread = rows @ rows.T
    sd = 10.0 ** rng.uniform(-2.5, 0.0, n)
    spread *= np.outer(sd, sd) / np.sqrt(np.outer(np.diag(spread), np.diag(spread)))
    return rng.uniform(-2.0, 3.0, n) * sd, spread


@pytest.mark.parametrize("n", [1, 2, 3])
def test_the_probability_of_a_box(n):
    rng = np.random.default_rng(n)
    compared = 0
    for _ in range(60):
        mean, spread = correlated(rng, n)
        exact = multivariate_normal(
            mean, spread, allow_singular=True, maxpts=200_000, abseps=1e-9, releps=1e-5, seed=1
        ).cdf(np.full(n, FURTHEST), lower_limit=np.zeros(n))
        if exact > 1e-4:  # the other method is exact to about 1e-9
            compared += 1
            assert abs(log_inside(mean[None], spread[None])[0] - np.log(exact)) < 0.02
    assert compared > 30


def test_weighted_draws_are_those_of_rejection():
    mean = np.array([0.05, 0.1, 0.3])
    spread = np.array([[0.04, -0.035, 0.0], [-0.035, 0.04, 0.01], [0.0, 0.01, 0.02]])
    rng = np.random.default_rng(3)
    free = rng.multivariate_normal(mean, spread, 80_000)
    wanted = free[np.all(free > 0.0, axis=1)]
    gaussian = truncated(mean, spread)
    u, log_weight = gaussian.draws(rng.random((20_000, 3)))
    weight = np.exp(log_weight)
    chosen = rng.choice(len(u), 2000, p=weight / weight.sum())
    for nth in range(3):
        assert kstest(u[chosen, nth], wanted[:, nth]).pvalue > 0.01
    # Where the draws come from, times their weight, is the Gaussian itself.
    whole = multivariate_normal(mean, spread).logpdf(u)
    assert np.allclose(gaussian.log_density(u) + log_weight, whole, atol=1e-8)


def test_particles_find_both_peaks_and_their_integral():
    """Two narrow peaks, one with three times the weight; the start covers both with little of it."""
    peaks = ((1.0, 0.01, 3.0), (1.4, 0.02, 1.0))

    def log_density(u):
        return np.log(sum(w * norm.pdf(u[:, 0], m, s) for m, s, w in peaks) + 1e-300)

    start = truncated(np.array([1.2]), np.array([[0.3**2]]))
    rng = np.random.default_rng(0)
    u = start.draws(rng.random((2000, 1)))[0]
    u, log_integral, _ = stepwise(u, start.log_density, log_density, FURTHEST, rng)
    assert abs(log_integral - np.log(4.0)) < 0.15
    assert abs(np.mean(u < 1.2) - 0.75) < 0.06
    assert abs(np.std(u[u < 1.2]) - 0.01) < 0.002


def test_the_threshold_is_the_quantile_of_integrated_evidence():
    """Elements from well seen to hardly seen at all: a severity that nothing shows gains no evidence."""
    rng, prior = np.random.default_rng(0), ar.DamagePrior()
    slopes = np.linalg.qr(rng.standard_normal((6, 6)))[0] * [100.0, 10.0, 3.0, 1.0, 0.1, 1e-3]
    beta = np.linspace(0.0, 0.99, 4001)
    values = np.random.default_rng(1).standard_normal((4000, 6))
    odds = np.zeros(4000)
    for own in slopes.T:
        gain = np.outer(values @ own, beta) - 0.5 * (own @ own) * beta**2
        odds += np.trapezoid(np.exp(gain), beta, axis=1) / 0.99
    for rate in (0.3, 0.05):
        wanted = np.log(np.quantile(odds, 1.0 - rate)) + prior.log_of(1, 6) - prior.log_of(0, 6)
        found = log_odds_threshold(
            slopes, prior, SearchOptions(false_alarm_rate=rate), np.random.default_rng(1)
        )
        assert abs(found - wanted) < 1e-3
