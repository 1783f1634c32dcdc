"""The threshold at which damage is declared, for a wanted rate of false alarms.

Intact tests are simulated from what is known after the baseline: the values of the roots that it shows, with
noise and with the errors that are left. Each is judged as a real one is, by the sum of prior times evidence
of all single elements over that of no damage, with the linear model at no damage, where small evidence is
decided.
"""

from __future__ import annotations

import numpy as np

from ..support.checks import FloatArray
from .evidence import HIGHEST, log_between
from .likelihood import Likelihood
from .question import DamagePrior

_DRAWS = 4000


def log_odds_threshold(
    slopes: FloatArray, prior: DamagePrior, rate: float, rng: np.random.Generator
) -> float:
    """Log odds of damage that this share of intact tests exceeds; ``slopes`` are ``intact_slopes``."""
    from scipy.special import logsumexp

    n = slopes.shape[1]
    size = np.maximum(np.linalg.norm(slopes, axis=0), 1e-6)
    # Height of each severity's peak over its standard deviation, and the room that it has from 0 on.
    height = rng.standard_normal((_DRAWS, slopes.shape[0])) @ slopes / size
    room = size * HIGHEST
    evidence = 0.5 * height**2 + log_between(-height, room - height) + np.log(np.sqrt(2.0 * np.pi) / room)
    odds = logsumexp(evidence, axis=1)
    return float(np.quantile(odds, 1.0 - rate)) + prior.log_of(1, n) - prior.log_of(0, n)


# -- The smallest severity of each element that a pair of tests would show
#
# Damage of one element is found where its evidence outweighs no damage: with sigma the standard deviation of
# its severity (errors of values and of the model, after the baseline) and z = beta / sigma,
#
# .. math:: \tfrac{1}{2} z^2 + \ln\frac{\sqrt{2 \pi} \sigma p_1}{0.99 \, p_0} > 0,
#
# which holds in nine of ten tests from 1.28 sigma above the beta of equality on.


#: Share of tests in which a severity is found.
_SHARE = 0.9


def intact_slopes(likelihood: Likelihood, n_candidates: int) -> FloatArray:
    """Changes of the baseline's values by each severity, over the errors they will have, made independent."""
    from scipy.linalg import solve_triangular

    error, n, now = likelihood.error, likelihood.n, likelihood.now
    root = np.unique(error.partner[error.partner >= 0])
    if not root.size:
        root = np.arange(error.intact.size)
    slopes = error.intact.slopes[root]
    kind = error.intact.kind[root]
    _, spread = error.predicted(slopes[:, n:] * np.exp(error.theta), root, kind)
    usual = float(np.median(now.std))
    # Values of now have about the errors of those of the same response.
    own = [now.std[now.response == error.intact.response[r]] for r in root]
    std = np.array([float(np.median(each)) if each.size else usual for each in own])
    alike = likelihood.common * (kind == 0)
    triangle = np.linalg.cholesky(spread + np.diag(std**2) + np.outer(alike, alike))
    return np.asarray(solve_triangular(triangle, slopes[:, :n_candidates], lower=True))


def smallest_found(slopes: FloatArray, prior: DamagePrior, threshold: float | None = None) -> FloatArray:
    """Severity of each candidate that is found in nine of ten tests; infinity where none would be."""
    from scipy.special import ndtri

    n = slopes.shape[1]
    sigma = 1.0 / np.maximum(np.linalg.norm(slopes, axis=0), 1e-12)
    against = prior.log_of(0, n) - prior.log_of(1, n) + (0.0 if threshold is None else threshold)
    height = np.sqrt(2.0 * np.maximum(against - np.log(np.sqrt(2.0 * np.pi) * sigma / HIGHEST), 0.0))
    found = sigma * (height + ndtri(_SHARE))
    return np.where(found <= HIGHEST, found, np.inf)
