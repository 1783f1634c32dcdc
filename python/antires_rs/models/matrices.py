"""Matrices as users have them, dense or scipy.sparse, in the form the core takes and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.validation import FloatArray, real_array, reject
from .entries import Columns, Entries

__all__ = ["as_dense", "as_sparse", "as_square", "as_term"]

WANTED = "a square matrix (n, n), dense or scipy.sparse"

#: Relative asymmetry up to which a matrix counts as symmetric: assembly in another program rounds.
SYMMETRY = 1e-9


def as_sparse(columns: Columns) -> Any:
    """A matrix of the core as ``scipy.sparse.csc_array``."""
    from scipy.sparse import csc_array

    starts, rows, values = columns
    n = len(starts) - 1
    return csc_array((values, rows, starts), shape=(n, n))


def as_dense(columns: Columns) -> FloatArray:
    """A matrix of the core as a dense array."""
    starts, rows, values = columns
    n = len(starts) - 1
    dense = np.zeros((n, n))
    dense[rows, np.repeat(np.arange(n), np.diff(starts))] = values
    return dense


def as_square(name: str, matrix: Any, n: int | None = None) -> tuple[int, Entries]:
    """Size and entries of a finite square matrix, (n, n) where n is known."""
    shape, entries = _entries(name, matrix)
    if shape != (n or shape[0],) * 2:
        reject(
            name,
            f"a matrix of shape {shape}",
            "a non-empty square matrix, stiffness and mass of one size",
            "Pass both after the same dofs were removed.",
        )
    return shape[0], entries


def as_term(name: str, matrix: Any, n: int) -> Entries:
    """Entries of a symmetric (n, n) matrix."""
    shape, entries = _entries(name, matrix)
    if shape != (n, n):
        reject(
            name,
            f"a matrix of shape {shape}",
            f"shape ({n}, {n}), as the stiffness",
            "Expand it to all dofs of the model, with zeros elsewhere.",
        )
    if not _is_symmetric(entries, n):
        reject(
            name,
            "a matrix that is not symmetric",
            "a symmetric term",
            "Pass (A + A.T) / 2 if the difference is rounding.",
        )
    return entries


def _is_symmetric(entries: Entries, n: int) -> bool:
    """Whether each entry and its mirror image differ by rounding of the largest at most."""
    if not entries.values.size:
        return True
    places = entries.rows.astype(np.int64) * n + entries.columns  # ascending, row by row
    mirrored = entries.columns.astype(np.int64) * n + entries.rows
    at = np.searchsorted(places, mirrored).clip(max=places.size - 1)
    image = np.where(places[at] == mirrored, entries.values[at], 0.0)
    difference = np.abs(entries.values - image).max()
    return bool(difference <= SYMMETRY * np.abs(entries.values).max())


def _entries(name: str, matrix: Any) -> tuple[tuple[int, ...], Entries]:
    """Shape and finite entries of a matrix; a sparse one is never made dense."""
    if not hasattr(matrix, "tocsr"):
        array = matrix.toarray() if hasattr(matrix, "toarray") else matrix
        dense = real_array(name, array, ndim=2, wanted=WANTED)
        return dense.shape, Entries.of(dense)
    rows = matrix.tocsr(copy=True)
    if rows.ndim != 2 or 0 in rows.shape:
        return rows.shape, Entries.of(real_array(name, rows.toarray(), ndim=2, wanted=WANTED))
    rows.sum_duplicates()
    values = real_array(name, rows.data, ndim=1, wanted=WANTED) if rows.nnz else np.zeros(0)
    numbers = np.repeat(np.arange(rows.shape[0], dtype=np.uint32), np.diff(rows.indptr))
    kept = values != 0.0
    return rows.shape, Entries(numbers[kept], rows.indices[kept].astype(np.uint32), values[kept])
