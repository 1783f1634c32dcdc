"""Eigenvalues of spectral matrices, line by line, with the channels scaled to equal noise."""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray

__all__ = ["dominant", "scaled_eigh"]


def scaled_eigh(matrix: ComplexArray, scale: FloatArray) -> tuple[FloatArray, ComplexArray]:
    """Eigenvalues and eigenvectors line by line, channels divided by the roots of ``scale``.

    ``matrix`` holds averages of conj(A) B, shape (n_freq, n, n); eigenvalues ascend.
    """
    values, vectors = np.linalg.eigh(_scaled(matrix, scale))
    return values, vectors


def dominant(matrix: ComplexArray, scale: FloatArray) -> tuple[FloatArray, FloatArray, ComplexArray]:
    """The largest eigenvalue, the mean of the others, (n_freq,) each, and its vectors, (n_freq, n)."""
    values, vectors = scaled_eigh(matrix, scale)
    rest = values[:, :-1].mean(axis=1) if values.shape[1] > 1 else np.zeros(values.shape[0])
    return values[:, -1], rest, vectors[:, :, -1]


def _scaled(matrix: ComplexArray, scale: FloatArray) -> ComplexArray:
    # conj(A) B is the transpose of the covariance whose eigenvectors are wanted.
    root = np.sqrt(scale)
    return np.asarray((matrix / (root[:, None] * root)).transpose(0, 2, 1))
