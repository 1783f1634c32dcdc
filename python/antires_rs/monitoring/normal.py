"""Scatter of single values: their variances, and how heavy the tails are.

Residuals over their standard deviation follow Student's t with nu degrees of freedom, one nu for all values,
so that a wild value counts for as much as it is rare: it is replaced by the normal deviate of its
probability. Scales are the likeliest under that t.

Reference: K. L. Lange, R. J. A. Little, J. M. G. Taylor, J. Am. Stat. Assoc. 84 (1989) 881-896.
"""

from __future__ import annotations

from math import lgamma

import numpy as np

from ..support.validation import FloatArray

__all__ = ["degrees_of", "scores", "variances"]

#: Degrees of freedom that are tried, from heavy tails to the normal law.
DEGREES = (2.5, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, np.inf)
#: What is told by a stated standard deviation counts as so many tests.
STATED = 5.0
ROUNDS = 30
_LARGEST = 30.0


def variances(rest: FloatArray, stated: FloatArray, degrees: float, lost: float) -> FloatArray:
    """Variance of each column of residuals (n, m) with NaN.

    Parameters
    ----------
    rest : (n, m)
    stated : (m,)
        Standard deviation that identification states, NaN where not known: it counts as some more tests.
    degrees : float
    lost : float
        Parameters that were fitted to each column.
    """
    there = ~np.isnan(rest)
    count = there.sum(axis=0)
    squares = np.where(there, rest, 0.0) ** 2
    variance = np.maximum(squares.sum(axis=0) / np.maximum(count, 1), 1e-300)
    for _ in range(ROUNDS if np.isfinite(degrees) else 1):
        weight = 1.0 if np.isinf(degrees) else (degrees + 1.0) / (degrees + squares / variance)
        variance = np.maximum(np.sum(weight * squares, axis=0) / np.maximum(count - lost, 1.0), 1e-300)
    own = np.isnan(stated)
    share = np.where(own, 0.0, STATED)
    free = np.maximum(count - lost, 1.0)
    mixed = (free * variance + share * np.where(own, 0.0, stated) ** 2) / (free + share)
    return np.asarray(np.maximum(mixed, 1e-18))


def degrees_of(rest: FloatArray) -> float:
    """Likeliest degrees of freedom of residuals (n, m), each column with a scale of its own."""
    enough = np.sum(~np.isnan(rest), axis=0) >= 8
    if not enough.any():
        return float("inf")
    rest = rest[:, enough]
    none = np.full(rest.shape[1], np.nan)
    best = (-np.inf, np.inf)
    for degrees in DEGREES:
        scale = np.sqrt(variances(rest, none, degrees, 0.0))
        law = np.nansum(_log_density(rest / scale, degrees) - np.log(scale))
        best = max(best, (float(law), degrees))
    return best[1]


def scores(scaled: FloatArray, degrees: float) -> FloatArray:
    """Normal deviates of residuals over their standard deviation."""
    if np.isinf(degrees):
        return np.clip(scaled, -_LARGEST, _LARGEST)
    from scipy.special import ndtri, stdtr

    tail = np.maximum(stdtr(degrees, -np.abs(scaled)), 1e-200)
    return np.asarray(np.clip(-np.sign(scaled) * ndtri(tail), -_LARGEST, _LARGEST))


def _log_density(x: FloatArray, degrees: float) -> FloatArray:
    """Of Student's t, less what is the same for all degrees of freedom."""
    if np.isinf(degrees):
        return np.asarray(-0.5 * x**2 - 0.5 * np.log(2.0))
    half = lgamma((degrees + 1.0) / 2.0) - lgamma(degrees / 2.0) - 0.5 * np.log(degrees)
    return np.asarray(half - 0.5 * (degrees + 1.0) * np.log1p(x**2 / degrees))
