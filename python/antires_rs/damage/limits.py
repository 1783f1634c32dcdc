r"""The smallest severity of each element that a pair of tests would show.

Damage of one element is found where its evidence outweighs no damage: with sigma the standard deviation of
its severity (errors of values and of the model, after the baseline) and z = beta / sigma,

.. math:: \tfrac{1}{2} z^2 + \ln\frac{\sqrt{2 \pi} \sigma p_1}{0.99 \, p_0} > 0,

which holds in nine of ten tests from 1.28 sigma above the beta of equality on.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import FloatArray
from .evidence import HIGHEST
from .likelihood import Likelihood
from .prior import DamagePrior

__all__ = ["intact_slopes", "smallest_found"]

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
