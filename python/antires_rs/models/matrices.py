"""Matrices as users have them, dense or scipy.sparse, in the form the core takes and back."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray, real_array, reject

__all__ = ["as_dense", "as_sparse", "as_term"]


def as_sparse(dense: FloatArray) -> Any:
    """Dense to ``scipy.sparse.csc_array``."""
    from scipy.sparse import csc_array

    return csc_array(dense)


def as_dense(name: str, matrix: Any) -> FloatArray:
    """A finite float64 matrix."""
    array = matrix.toarray() if hasattr(matrix, "toarray") else matrix
    return real_array(name, array, ndim=2, wanted="a square matrix (n, n), dense or scipy.sparse")


def as_term(name: str, matrix: Any, n: int) -> tuple[NDArray[np.uint32], NDArray[np.uint32], FloatArray]:
    """Entries (rows, columns, values) of a symmetric (n, n) matrix."""
    dense = as_dense(name, matrix)
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
    rows, cols = np.nonzero(dense)
    return rows.astype(np.uint32), cols.astype(np.uint32), np.ascontiguousarray(dense[rows, cols])
