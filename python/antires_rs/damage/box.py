"""Gaussians within bounds: where in the box the peak is, and one coordinate's mean and quantiles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray

__all__ = ["given", "log_between", "peak_in_box", "quantiles"]


def peak_in_box(mean: FloatArray, covariance: FloatArray, low: float, high: float) -> FloatArray:
    """Most probable point of a Gaussian in the box [low, high]^n.

    Coordinates whose peak lies outside are put on their bound one by one, the worst first; given these, the
    others follow.
    """
    best, spread, free = mean.copy(), covariance.copy(), list(range(mean.size))
    while free:
        sd = np.sqrt(np.diag(spread))
        below, above = (low - best) / sd, (best - high) / sd
        worst = max(free, key=lambda i: max(below[i], above[i]))
        if max(below[worst], above[worst]) <= 0.0:
            break
        gain = spread[:, worst] / spread[worst, worst]
        best = best + gain * ((low if below[worst] > above[worst] else high) - best[worst])
        spread = spread - np.outer(gain, spread[worst])
        free.remove(worst)
        spread[worst, worst] = 1.0
    return best


def given(
    mean: FloatArray, covariance: FloatArray, nth: int, known: FloatArray, which: NDArray[np.bool_]
) -> tuple[float, float]:
    """Mean and standard deviation of one coordinate of a Gaussian, given some of the others."""
    at = np.array([k for k in np.flatnonzero(which) if k != nth], dtype=np.intp)
    if not at.size:
        return float(mean[nth]), float(np.sqrt(covariance[nth, nth]))
    gain = np.linalg.solve(covariance[np.ix_(at, at)], covariance[at, nth])
    variance = covariance[nth, nth] - gain @ covariance[at, nth]
    return float(mean[nth] + gain @ (known[at] - mean[at])), float(np.sqrt(variance))


def quantiles(
    mean: float, std: float, low: float, high: float, shares: tuple[float, float]
) -> tuple[float, float]:
    """Quantiles of a Gaussian of which only [low, high] is left."""
    from scipy.special import ndtr, ndtri

    a, b = (low - mean) / std, (high - mean) / std
    if a > 5.0:  # far below the bound: an exponential is left
        first, second = (float(low - np.log1p(-q) * std / a) for q in shares)
        return first, second
    if b < -5.0:  # far above the other one: the same from there
        first, second = quantiles(-mean, std, -high, -low, (1.0 - shares[1], 1.0 - shares[0]))
        return -second, -first
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
