"""The noise of channels and of lines, as averaged spectra tell it.

- :func:`noise_power`: each channel's own noise, whatever number of forces acts on the structure;
- :func:`channel_noise`: relative noise of the channels under one force;
- :func:`noise_floor`, :func:`floors`: the level of the matrix, for all lines and by line.
"""

from __future__ import annotations

import numpy as np

from .. import _core
from ..support.checks import ComplexArray, FloatArray
from .segments import pieces

# -- Eigenvalues of spectral matrices, line by line, with the channels scaled to equal noise


def scaled_eigh(matrix: ComplexArray, scale: FloatArray) -> tuple[FloatArray, ComplexArray]:
    """Eigenvalues and eigenvectors line by line, channels divided by the roots of ``scale``.

    ``matrix`` holds averages of conj(A) B, shape (n_freq, n, n); eigenvalues ascend.
    """
    # conj(A) B is the transpose of the covariance whose eigenvectors are wanted.
    root = np.sqrt(scale)
    values, vectors = np.linalg.eigh((matrix / (root[:, None] * root)).transpose(0, 2, 1))
    return values, vectors


def spectrum(matrix: ComplexArray, scale: FloatArray) -> tuple[FloatArray, ComplexArray]:
    """All eigenvalues, largest first, (n_freq, n), and the vectors of the largest, (n_freq, n)."""
    values = _core.hermitian_values(matrix, scale)[:, ::-1]
    return np.ascontiguousarray(values), dominant(matrix, scale)[2]


def dominant(matrix: ComplexArray, scale: FloatArray) -> tuple[FloatArray, FloatArray, ComplexArray]:
    """The largest eigenvalue, the mean of the others, (n_freq,) each, and its vectors, (n_freq, n)."""
    return _core.dominant_pairs(matrix, scale)


# Keeps the inverse of exact data, whose matrices are of rank one, within rounding.
RIDGE = 1e-13
# Independent averages needed per channel before the inverse of an averaged matrix means something.
AVERAGES_PER_CHANNEL = 1.5
# Passes of "eigenvector, residual noise of each channel, scale".
PASSES = 4
# The scales are medians over lines: so many lines tell them.
LINES = 500
# No channel is taken to have less than this share of the noise that the passes start from: with next to no
# noise they would end by calling a single channel perfect.
LEAST_NOISE = 0.1
# Mean of the other eigenvalues over the first of a matrix that holds nothing but rounding beside its vector.
EXACT = 1e-13
# Share of the largest eigenvalue below which a floor is rounding.
ROUNDING = 1e-15
# Lines over which the noise of averaged spectra is taken to be constant.
FLOOR_LINES = 101


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
    auto = np.einsum("fii->fi", matrix).real / root**2
    left = np.empty(auto.shape)
    if n_averages >= AVERAGES_PER_CHANNEL * n:
        for some in pieces(len(matrix), n * n):
            part = matrix[some] * (1.0 / (root[:, None] * root))
            part[:, np.arange(n), np.arange(n)] += (
                RIDGE * np.maximum(auto[some].mean(axis=1), 1e-300)[:, None]
            )
            left[some] = 1.0 / np.einsum("fii->fi", np.linalg.inv(part)).real
        left *= n_averages / (n_averages - n + 1.0)
    else:
        scaled = matrix * (1.0 / (root[:, None] * root))
        scale = channel_noise(scaled)
        unit = dominant(scaled, scale)[2] * np.sqrt(scale)
        unit = unit / np.linalg.norm(unit, axis=1, keepdims=True)
        along = np.einsum("fi,fji,fj->f", unit, scaled, unit.conj(), optimize=True).real
        left = auto - along[:, None] * np.abs(unit) ** 2
    # The median, because near a resonance leakage looks like noise.
    level = np.median(left, axis=0)
    return np.asarray(np.maximum(level, RIDGE * np.maximum(auto.mean(axis=0), 1e-300)) * root**2)


def channel_noise(matrix: ComplexArray, start: FloatArray | None = None) -> FloatArray:
    """Relative noise power of every channel: what the dominant vector leaves of the diagonal, (n_channels,).

    ``matrix`` holds averages of conj(A) B, shape (n_freq, n, n); ``start`` is a first estimate, by default
    the same share of every channel's power.
    """
    some = matrix[:: max(1, matrix.shape[0] // LINES)]
    auto = np.einsum("fii->fi", some).real
    first = auto.mean(axis=0) if start is None else start
    first = np.where(first > 0.0, first, 1.0)
    scale = first
    for _ in range(PASSES):
        largest, rest, vectors = dominant(some, scale)
        if scale.size > 1 and np.median(rest / np.maximum(largest, 1e-300)) < EXACT:
            break  # of rank one but for rounding: there is no noise to tell
        # The noise is in the largest eigenvalue as well.
        left = auto / scale - (largest - rest)[:, None] * np.abs(vectors) ** 2
        # By line, since otherwise coloured noise would let the quiet lines decide, where leakage counts.
        share = np.median(left / np.maximum(np.abs(left).mean(axis=1, keepdims=True), 1e-300), axis=0)
        scale = scale * share / max(float(share.mean()), 1e-300)
        scale = np.maximum(scale, LEAST_NOISE * first * float(np.median(scale / first)))
    return np.asarray(scale)


def noise_floor(largest: FloatArray, rest: FloatArray) -> float:
    """Noise level of all lines: the typical mean of all eigenvalues but the largest."""
    return max(float(np.median(rest)), _rounding(largest))


def floors(largest: FloatArray, rest: FloatArray) -> FloatArray:
    """Noise level of every line: running median of the mean of all eigenvalues but the largest.

    Noise that is not white would otherwise bias the eigenvector of smallest misfit, which takes it for even.
    """
    from scipy.ndimage import median_filter  # slow to import

    return np.asarray(np.maximum(median_filter(rest, size=FLOOR_LINES, mode="nearest"), _rounding(largest)))


def _rounding(largest: FloatArray) -> float:
    """Exact rank one leaves rounding only."""
    return max(ROUNDING * float(largest.max()), 1e-300)


# -- What is rough from line to line is noise: second differences of curves that are smooth without it


# Lines over which the noise of measured curves is taken to be constant.
NOISE_LINES = 31
# With fewer lines nothing tells noise from curve.
LEAST_LINES = 12
# No curve is taken to have less noise than this share of its power.
LEAST_NOISE_ROUGHNESS = 1e-12
# Second differences of white noise over the noise itself, in power.
GAIN = 6.0
# The median of abs()**2 of complex Gaussian noise over its mean.
MEDIAN = np.log(2.0)


def second_differences(values: ComplexArray) -> FloatArray:
    """Squared second differences along the last axis: ``GAIN`` times the power of white noise."""
    return np.abs(values[..., 2:] - 2.0 * values[..., 1:-1] + values[..., :-2]) ** 2


def typical_noise(values: ComplexArray) -> FloatArray:
    """Noise power of every curve (n_outputs, n_freq) at its median line, (n_outputs,)."""
    noise = np.median(second_differences(values), axis=1) / (GAIN * MEDIAN)
    return np.asarray(np.maximum(noise, LEAST_NOISE_ROUGHNESS * np.mean(np.abs(values) ** 2, axis=1)))


def local_noise(values: ComplexArray) -> FloatArray:
    """Noise power of every curve around every line, (n_outputs, n_freq).

    At a sharp resonance the curve itself bends within a line; there the noise comes out too high, which only
    keeps the few lines of the peak from ruling the fit.
    """
    from scipy.ndimage import median_filter  # slow to import

    power = np.mean(np.abs(values) ** 2, axis=1)[:, None]
    if values.shape[1] < LEAST_LINES:
        return np.repeat(power, values.shape[1], axis=1)
    second = second_differences(values)
    second = np.concatenate([second[:, :1], second, second[:, -1:]], axis=1)
    noise = median_filter(second, size=(1, NOISE_LINES), mode="nearest") / (GAIN * MEDIAN)
    return np.asarray(np.maximum(noise, LEAST_NOISE_ROUGHNESS * power))


def roughness(curve: ComplexArray) -> float:
    """Noise over power of one curve, by medians: the few lines of a sharp resonance are rough too."""
    power = float(np.median(np.abs(curve) ** 2))
    return float(np.median(second_differences(curve))) / GAIN / power if power > 0.0 else 0.0
