r"""One force acts: the responses as one vector a line.

Under a single force at k the spectral matrix of the responses is S = s s^H + diag(noise), where the
vector s is proportional to the FRFs H_pk. With the channels scaled to equal noise its dominant eigenvector
is the maximum-likelihood estimate of s up to a complex factor, and every transmissibility is a ratio of two
of its entries. The factor, and with it the resonances, cancels.
"""

from __future__ import annotations

import numpy as np

from ._validation import ComplexArray, FloatArray

# Passes of "eigenvector, residual noise of each channel, scale"; the scales settle within three.
NOISE_PASSES = 4
# No channel is taken to have less than this share of the mean noise: exact data have none at all.
LEAST_NOISE = 1e-6


def response_vectors(
    matrix: ComplexArray, noise: FloatArray | None = None
) -> tuple[ComplexArray, FloatArray]:
    """Dominant vectors, (n_channels, n_freq) in the channels' units, and signal-to-noise power, (n_freq,).

    ``matrix`` holds averages of conj(A) B, shape (n_freq, n, n). ``noise`` is each channel's noise power in
    the same units; where it is not known it is estimated from what the vector leaves of the diagonal.
    """
    n = matrix.shape[1]
    auto = np.einsum("fii->fi", matrix).real
    known = noise is not None and noise.min() > 0.0
    scale = np.array(noise if noise is not None and known else auto.mean(axis=0))
    scale[scale <= 0.0] = 1.0
    for _ in range(1 if known else NOISE_PASSES):
        root = np.sqrt(scale)
        # conj(A) B is the transpose of the covariance whose eigenvectors are wanted.
        values, vectors = np.linalg.eigh((matrix / (root[:, None] * root)).transpose(0, 2, 1))
        used = scale
        if not known:
            left = auto / scale - values[:, -1:] * np.abs(vectors[:, :, -1])**2
            share = np.median(left, axis=0)
            scale = scale * np.maximum(share / max(float(share.mean()), 1e-300), LEAST_NOISE)
    floor = 1.0 if known else 0.0
    if not known and n > 1:
        floor = float(np.median(values[:, :-1].mean(axis=1)))
    # Exact rank one leaves rounding only.
    floor = max(floor, 1e-15 * float(values[:, -1].max()), 1e-300)
    return np.ascontiguousarray((vectors[:, :, -1] * np.sqrt(used)).T), values[:, -1] / floor
