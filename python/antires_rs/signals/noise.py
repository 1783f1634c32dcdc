"""Each channel's own noise, whatever number of forces acts on the structure."""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray
from .rankone import response_vectors

# Keeps the inverse of exact data, whose matrices are of rank one, within rounding.
RIDGE = 1e-13
# Independent averages needed per channel before the inverse of an averaged matrix means something.
AVERAGES_PER_CHANNEL = 1.5


def noise_power(matrix: ComplexArray, n_averages: float) -> FloatArray:
    """Noise power of each channel at the median line, (n_channels,), units of the diagonal.

    What the other channels together do not tell of a channel is its noise: ``1 / inv(S)_pp``, the variance of
    p given all others, corrected for the averages that the regression uses up. No assumption on the number
    of forces enters, as long as there are fewer than channels. With too few averages for an inverse, what the
    dominant eigenvector leaves of the diagonal is taken.
    """
    n = matrix.shape[1]
    mean = np.einsum("fii->fi", matrix).real.mean(axis=0)
    root = np.sqrt(np.where(mean > 0.0, mean, 1.0))
    scaled = matrix / (root[:, None] * root)
    auto = np.einsum("fii->fi", scaled).real
    if n_averages >= AVERAGES_PER_CHANNEL * n:
        ridge = RIDGE * np.maximum(auto.mean(axis=1), 1e-300)
        inverse = np.linalg.inv(scaled + ridge[:, None, None] * np.eye(n))
        left = 1.0 / np.einsum("fii->fi", inverse).real * (n_averages / (n_averages - n + 1.0))
    else:
        unit = response_vectors(scaled)[0].T
        unit = unit / np.linalg.norm(unit, axis=1, keepdims=True)
        along = np.einsum("fi,fji,fj->f", unit, scaled, unit.conj(), optimize=True).real
        left = auto - along[:, None] * np.abs(unit) ** 2
    # The median, because near a resonance leakage looks like noise.
    level = np.median(left, axis=0)
    return np.asarray(np.maximum(level, RIDGE * np.maximum(auto.mean(axis=0), 1e-300)) * root**2)
