"""Matrices by their entries, as recipes hold them and as the core takes them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray

__all__ = ["Columns", "Entries"]

#: A matrix of the core by columns: starts, rows, values.
Columns = tuple[NDArray[np.int64], NDArray[np.int64], FloatArray]


class Entries(NamedTuple):
    """The entries of a matrix that are not zero."""

    rows: NDArray[np.uint32]
    columns: NDArray[np.uint32]
    values: FloatArray

    @classmethod
    def of(cls, dense: FloatArray) -> Entries:
        """Those of a dense matrix, row by row."""
        rows, columns = np.nonzero(dense)
        values = np.ascontiguousarray(dense[rows, columns])
        return cls(rows.astype(np.uint32), columns.astype(np.uint32), values)

    @classmethod
    def of_sparse(cls, matrix: Any) -> Entries:
        """Those of a sparse matrix, row by row."""
        rows = matrix.tocsr()
        rows.sum_duplicates()
        numbers = np.repeat(np.arange(rows.shape[0], dtype=np.uint32), np.diff(rows.indptr))
        kept = rows.data != 0.0
        return cls(numbers[kept], rows.indices[kept].astype(np.uint32), np.array(rows.data[kept]))

    @classmethod
    def joined(cls, rows: Any, columns: Any, values: Any) -> Entries:
        """Of arrays in any order; row by row."""
        order = np.lexsort((columns, rows))
        return cls(
            np.asarray(rows)[order].astype(np.uint32),
            np.asarray(columns)[order].astype(np.uint32),
            np.asarray(values, dtype=np.float64)[order],
        )

    def sparse(self, n: int, n_columns: int | None = None) -> Any:
        """As ``scipy.sparse.csr_array``."""
        from scipy.sparse import coo_array, csr_array

        shape = (n, n if n_columns is None else n_columns)
        return csr_array(coo_array((self.values, (self.rows, self.columns)), shape=shape))

    def diagonal(self, n: int) -> FloatArray:
        """Of an (n, n) matrix."""
        on = self.rows == self.columns
        return np.bincount(self.rows[on], self.values[on], minlength=n).astype(np.float64)

    def those(self, kept: NDArray[np.bool_]) -> Entries:
        """Some of them."""
        return Entries(self.rows[kept], self.columns[kept], self.values[kept])
