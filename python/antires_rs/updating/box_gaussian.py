"""Draws of a Gaussian that is cut off by the unit box, for many chains at once.

Hit-and-run along the principal axes of the Gaussian and along the edges of the box: along any line the cut
Gaussian is a normal distribution between two ends, drawn exactly. Without the box one sweep gives independent
draws; directions that the data do not see are uniform between the ends.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray

__all__ = ["axes_of", "sweep"]

#: A normal distribution this much wider than the line is drawn as uniform.
_WIDE = 1e4
#: Beyond so many standard deviations the tail is drawn as an exponential distribution.
_FAR = 30.0


def axes_of(precision: FloatArray) -> FloatArray:
    """Directions of the sweeps, (2n, n): principal axes of the Gaussian, then the edges of the box."""
    return np.vstack([np.linalg.eigh(precision)[1].T, np.eye(len(precision))])


def sweep(
    u: FloatArray,
    center: FloatArray,
    precisions: FloatArray,
    slopes: FloatArray,
    which: NDArray[np.intp],
    axes: FloatArray,
    rng: np.random.Generator,
) -> FloatArray:
    """Every chain ``u`` (k, n) moved once along each axis.

    Chain c has the density ``exp(-v' P v / 2 - b' v)`` with v = u - center, P and b those number ``which[c]``
    of ``precisions`` (G, n, n) and ``slopes`` (G, n).
    """
    v = np.ascontiguousarray((u - center).T)  # (n, k)
    low_edge, high_edge = -center[:, None], 1.0 - center[:, None]
    for axis in axes:
        on = np.flatnonzero(np.abs(axis) > 1e-12)
        inverse = 1.0 / axis[on, None]
        up = inverse > 0.0
        ahead = (np.where(up, high_edge[on], low_edge[on]) - v[on]) * inverse
        behind = (np.where(up, low_edge[on], high_edge[on]) - v[on]) * inverse
        high = np.maximum(ahead.min(axis=0), 0.0)
        low = np.minimum(behind.max(axis=0), 0.0)
        forward = precisions @ axis  # (G, n)
        stiff = np.maximum(forward @ axis, 0.0)[which]
        pull = np.einsum("nk,nk->k", forward.T[:, which], v) + (slopes @ axis)[which]
        v[on] += _between(pull, stiff, low, high, rng.random(np.shape(pull))) * axis[on, None]
    return np.clip(v.T + center, 0.0, 1.0)


def _between(
    pull: FloatArray, stiff: FloatArray, low: FloatArray, high: FloatArray, p: FloatArray
) -> FloatArray:
    """Draws of ``exp(-stiff t**2 / 2 - pull t)`` within [low, high], by uniform numbers p."""
    from scipy.special import ndtr, ndtri

    span = high - low
    std = 1.0 / np.sqrt(np.maximum(stiff, 1e-300))
    flat = ~(std < _WIDE * span) & (np.abs(pull) * span < 1e-3)
    std = np.where(flat, 1.0, np.minimum(std, _WIDE * np.maximum(span, 1e-300)))
    mean = -pull * std**2
    a, b = (low - mean) / std, (high - mean) / std
    flip = a + b > 0.0  # the tail is resolved on the negative side
    a, b = np.where(flip, -b, a), np.where(flip, -a, b)
    below, above = ndtr(np.maximum(a, -_FAR)), ndtr(np.maximum(b, -_FAR))
    with np.errstate(divide="ignore"):
        z = ndtri(below + p * (above - below))
    tail = b < -_FAR + 1.0
    reach = -np.expm1(np.clip(-np.abs(b) * (b - a), -700.0, 0.0))
    z = np.where(tail, b + np.log1p(-p * reach) / np.maximum(np.abs(b), 1.0), z)
    z = np.clip(z, a, b)
    t = np.where(flat, low + p * span, mean + std * np.where(flip, -z, z))
    return np.asarray(np.clip(t, low, high))
