"""Eigenvalues of spectral matrices, line by line, with the channels scaled to equal noise."""

from __future__ import annotations

import numpy as np

from .. import _core
from ..support.validation import ComplexArray, FloatArray

__all__ = ["dominant", "scaled_eigh", "spectrum"]


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
