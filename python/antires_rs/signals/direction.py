"""The direction of the responses at each line, and its noise.

Under one force the responses at a line are a vector known up to a factor: of measured FRFs and of the
transmissibilities made of them the factor differs, the direction does not. So the noise of given curves is
taken from their directions, and is the same for both: what is rough from line to line in curves that turn
smoothly.
"""

from __future__ import annotations

import numpy as np

from ..support.checks import ComplexArray, FloatArray
from .noise import channel_noise, dominant, local_noise, noise_floor

# No channel is taken to have less noise than this share of the typical one.
LEAST_SHARE = 1e-2
#: No direction is taken to have less noise power than this.
ROUNDING = 1e-12


def aligned(vectors: ComplexArray) -> ComplexArray:
    """Vectors (n_rows, n_freq) of unit norm, each line's free phase turned to that of its neighbour."""
    norm = np.linalg.norm(vectors, axis=0)
    unit = vectors / np.where(norm > 0.0, norm, 1.0)
    step = np.angle(np.sum(unit[:, :-1].conj() * unit[:, 1:], axis=0))
    return np.asarray(unit * np.exp(-1j * np.concatenate([[0.0], np.cumsum(step)])))


def direction_noise(directions: ComplexArray) -> FloatArray:
    """Noise power of :func:`aligned` directions around every line, (n_rows, n_freq), from roughness."""
    return np.maximum(local_noise(directions), ROUNDING)


def noise_shares(noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A noise power (n_rows, n_freq) as the product of one of the row and one of the line.

    Rows by medians, since a few lines of a sharp resonance look noisy in all; lines by means.
    """
    row = np.median(noise, axis=1)
    row = np.maximum(row, LEAST_SHARE * float(np.median(row)))
    return row, np.mean(noise / row[:, None], axis=0)


# -- One force acts: the responses as one vector a line
#
# Under a single force at k the spectral matrix of the responses is S = s s^H + diag(noise), where the
# vector s is proportional to the FRFs H_pk. With the channels scaled to equal noise its dominant eigenvector
# is the maximum-likelihood estimate of s up to a complex factor, and every transmissibility is a ratio of two
# of its entries. The factor, and with it the resonances, cancels.


def response_vectors(
    matrix: ComplexArray, noise: FloatArray | None = None
) -> tuple[ComplexArray, FloatArray]:
    """Dominant vectors, (n_channels, n_freq) in the channels' units, and signal-to-noise power, (n_freq,).

    ``matrix`` holds averages of conj(A) B, shape (n_freq, n, n). ``noise`` is each channel's noise power in
    the same units; where it is not known it is estimated.
    """
    known = noise is not None and noise.min() > 0.0
    scale = noise if noise is not None and known else channel_noise(matrix)
    largest, rest, vectors = dominant(matrix, scale)
    floor = 1.0 if known else noise_floor(largest, rest)
    return np.ascontiguousarray((vectors * np.sqrt(scale)).T), largest / floor
