r"""One force acts: the responses as one vector a line.

Under a single force at k the spectral matrix of the responses is S = s s^H + diag(noise), where the
vector s is proportional to the FRFs H_pk. With the channels scaled to equal noise its dominant eigenvector
is the maximum-likelihood estimate of s up to a complex factor, and every transmissibility is a ratio of two
of its entries. The factor, and with it the resonances, cancels.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray

# Passes of "eigenvector, residual noise of each channel, scale".
NOISE_PASSES = 4
# The scales are medians over lines: so many lines tell them.
NOISE_LINES = 500
# No channel is taken to have less than this share of the noise that the passes start from: with next to no
# noise they would end by calling a single channel perfect.
LEAST_NOISE = 0.1
# Second eigenvalue over the first of a matrix that holds nothing but rounding beside its vector.
EXACT = 1e-13


def channel_noise(matrix: ComplexArray, start: FloatArray | None = None) -> FloatArray:
    """Relative noise power of every channel: what the dominant vector leaves of the diagonal, (n_channels,).

    ``matrix`` holds averages of conj(A) B, shape (n_freq, n, n); ``start`` is a first estimate, by default
    the same share of every channel's power.
    """
    some = matrix[:: max(1, matrix.shape[0] // NOISE_LINES)]
    auto = np.einsum("fii->fi", some).real
    first = auto.mean(axis=0) if start is None else start
    first = np.where(first > 0.0, first, 1.0)
    scale = first
    for _ in range(NOISE_PASSES):
        values, vectors = scaled_eigh(some, scale)
        if values.shape[1] > 1 and np.median(values[:, -2] / np.maximum(values[:, -1], 1e-300)) < EXACT:
            break  # of rank one but for rounding: there is no noise to tell
        # The noise is in the largest eigenvalue as well.
        floor = values[:, :-1].mean(axis=1, keepdims=True) if auto.shape[1] > 1 else 0.0
        left = auto / scale - (values[:, -1:] - floor) * np.abs(vectors[:, :, -1]) ** 2
        # By line, since otherwise coloured noise would let the quiet lines decide, where leakage counts.
        share = np.median(left / np.maximum(np.abs(left).mean(axis=1, keepdims=True), 1e-300), axis=0)
        scale = scale * share / max(float(share.mean()), 1e-300)
        scale = np.maximum(scale, LEAST_NOISE * first * float(np.median(scale / first)))
    return np.asarray(scale)


def response_vectors(
    matrix: ComplexArray, noise: FloatArray | None = None
) -> tuple[ComplexArray, FloatArray]:
    """Dominant vectors, (n_channels, n_freq) in the channels' units, and signal-to-noise power, (n_freq,).

    ``matrix`` holds averages of conj(A) B, shape (n_freq, n, n). ``noise`` is each channel's noise power in
    the same units; where it is not known it is estimated.
    """
    known = noise is not None and noise.min() > 0.0
    scale = noise if noise is not None and known else channel_noise(matrix)
    values, vectors = scaled_eigh(matrix, scale)
    floor = 1.0 if known else noise_floor(values)
    return np.ascontiguousarray((vectors[:, :, -1] * np.sqrt(scale)).T), values[:, -1] / floor


def noise_floor(values: FloatArray) -> float:
    """Noise level of eigenvalues (n_freq, n), ascending: the typical mean of all but the largest."""
    floor = float(np.median(values[:, :-1].mean(axis=1))) if values.shape[1] > 1 else 0.0
    # Exact rank one leaves rounding only.
    return max(floor, 1e-15 * float(values[:, -1].max()), 1e-300)


def scaled_eigh(matrix: ComplexArray, scale: FloatArray) -> tuple[FloatArray, ComplexArray]:
    """Eigenvalues and eigenvectors line by line, channels divided by the roots of ``scale``."""
    root = np.sqrt(scale)
    # conj(A) B is the transpose of the covariance whose eigenvectors are wanted.
    values, vectors = np.linalg.eigh((matrix / (root[:, None] * root)).transpose(0, 2, 1))
    return values, vectors
