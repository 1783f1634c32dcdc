"""Gaussians within bounds: the probability of a box, where in it the peak is, and quantiles."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.validation import FloatArray

__all__ = ["in_box", "log_between", "quantiles"]


def in_box(mean: FloatArray, covariance: FloatArray, low: float, high: float) -> tuple[FloatArray, float]:
    """Most probable point of a Gaussian in the box [low, high]^n, and about ln of the probability of the box.

    Coordinates whose peak lies outside are taken one by one, the worst first, and put on their bound; given
    these, the others follow. Exact for one coordinate, and where the others are far from their bounds.
    """
    best, spread, free = mean.copy(), covariance.copy(), list(range(mean.size))
    log_p = 0.0
    while free:
        sd = np.sqrt(np.diag(spread))
        below, above = (low - best) / sd, (best - high) / sd
        worst = max(free, key=lambda i: max(below[i], above[i]))
        if max(below[worst], above[worst]) <= 0.0:
            return best, log_p + sum(float(log_between(below[i], -above[i])) for i in free)
        log_p += float(log_between(below[worst], -above[worst]))
        gain = spread[:, worst] / spread[worst, worst]
        best = best + gain * ((low if below[worst] > above[worst] else high) - best[worst])
        spread = spread - np.outer(gain, spread[worst])
        free.remove(worst)
        spread[worst, worst] = 1.0
    return best, log_p


def quantiles(
    mean: float, std: float, low: float, high: float, shares: tuple[float, float]
) -> tuple[float, float]:
    """Quantiles of a Gaussian of which only [low, high] is left."""
    from scipy.special import ndtr, ndtri

    a, b = (low - mean) / std, (high - mean) / std
    if a > 5.0:  # far below the bound: an exponential is left
        first, second = (float(low - np.log1p(-q) * std / a) for q in shares)
        return first, second
    bottom, top = ndtr(a), ndtr(b)
    first, second = (
        float(np.clip(mean + std * ndtri(bottom + q * (top - bottom)), low, high)) for q in shares
    )
    return first, second


def log_between(low: Any, high: Any) -> FloatArray:
    """ln of the standard normal probability between two limits, element by element."""
    from scipy.special import log_ndtr

    flip = np.asarray(low) > 0.0  # the tail is resolved on the negative side
    low, high = np.where(flip, -high, low), np.where(flip, -low, high)
    top, bottom = log_ndtr(high), log_ndtr(low)
    return np.asarray(top + np.log1p(-np.exp(np.minimum(bottom - top, -1e-15))))
