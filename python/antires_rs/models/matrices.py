"""Matrices as users have them, dense or scipy.sparse, in the form the core takes and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.validation import FloatArray, real_array, reject
from .recipes import Entries

__all__ = ["as_sparse", "as_square", "as_term"]


def as_sparse(dense: FloatArray) -> Any:
    """Dense to ``scipy.sparse.csc_array``."""
    from scipy.sparse import csc_array

    return csc_array(dense)


def as_square(name: str, matrix: Any, n: int | None = None) -> FloatArray:
    """A finite square matrix, (n, n) where n is known."""
    dense = _as_dense(name, matrix)
    if dense.shape != (n or len(dense),) * 2:
        reject(
            name,
            f"a matrix of shape {dense.shape}",
            "a non-empty square matrix, stiffness and mass of one size",
            "Pass both after the same dofs were removed.",
        )
    return dense


def as_term(name: str, matrix: Any, n: int) -> Entries:
    """Entries of a symmetric (n, n) matrix."""
    dense = _as_dense(name, matrix)
    if dense.shape != (n, n):
        reject(
            name,
            f"a matrix of shape {dense.shape}",
            f"shape ({n}, {n}), as the stiffness",
            "Expand it to all dofs of the model, with zeros elsewhere.",
        )
    if not np.allclose(dense, dense.T, rtol=0, atol=1e-9 * np.abs(dense).max()):
        reject(
            name,
            "a matrix that is not symmetric",
            "a symmetric term",
            "Pass (A + A.T) / 2 if the difference is rounding.",
        )
    return Entries.of(dense)


def _as_dense(name: str, matrix: Any) -> FloatArray:
    """A finite float64 matrix."""
    array = matrix.toarray() if hasattr(matrix, "toarray") else matrix
    return real_array(name, array, ndim=2, wanted="a square matrix (n, n), dense or scipy.sparse")
