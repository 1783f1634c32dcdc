"""The threshold for a rate of false alarms, against direct integration of the evidence."""

import numpy as np

import antires_rs as ar
from antires_rs.damage.inference import log_odds_threshold


def test_threshold_is_the_quantile_of_integrated_evidence():
    """Elements from well seen to hardly seen at all: a severity that nothing shows gains no evidence."""
    rng, prior = np.random.default_rng(0), ar.DamagePrior()
    slopes = np.linalg.qr(rng.standard_normal((6, 6)))[0] * [100.0, 10.0, 3.0, 1.0, 0.1, 1e-3]
    beta = np.linspace(0.0, 0.99, 4001)
    values = np.random.default_rng(1).standard_normal((4000, 6))
    odds = np.zeros(4000)
    for element in range(6):
        gain = np.outer(values @ slopes[:, element], beta)
        gain -= 0.5 * (slopes[:, element] @ slopes[:, element]) * beta**2
        odds += np.trapezoid(np.exp(gain), beta, axis=1) / 0.99
    for rate in (0.3, 0.05):
        wanted = np.log(np.quantile(odds, 1.0 - rate)) + prior.log_of(1, 6) - prior.log_of(0, 6)
        found = log_odds_threshold(slopes, prior, rate, np.random.default_rng(1))
        assert abs(found - wanted) < 1e-3
