"""The direction of the responses at each line, and its noise.

Under one force the responses at a line are a vector known up to a factor: of measured FRFs and of the
transmissibilities made of them the factor differs, the direction does not. So the noise of given curves is
taken from their directions, and is the same for both: what is rough from line to line in curves that turn
smoothly.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray
from .roughness import local_noise

__all__ = ["ROUNDING", "aligned", "direction_noise", "noise_shares"]

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
