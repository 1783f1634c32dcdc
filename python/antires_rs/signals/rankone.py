r"""One force acts: the responses as one vector a line.

Under a single force at k the spectral matrix of the responses is S = s s^H + diag(noise), where the
vector s is proportional to the FRFs H_pk. With the channels scaled to equal noise its dominant eigenvector
is the maximum-likelihood estimate of s up to a complex factor, and every transmissibility is a ratio of two
of its entries. The factor, and with it the resonances, cancels.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray
from .eigen import dominant
from .noise import channel_noise, noise_floor

__all__ = ["response_vectors"]


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
