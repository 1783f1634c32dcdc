"""Matrices as users have them, dense or scipy.sparse, in the form the core takes and back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..exceptions import OutOfMemoryError, part, reject
from ..support.checks import FloatArray, real_array
from ..support.messages import some, warn

# -- Matrices by their entries, as recipes hold them and as the core takes them

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
        i, k = (np.asarray(each)[order].astype(np.uint32) for each in (rows, columns))
        return cls(i, k, np.asarray(values, dtype=np.float64)[order])

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


WANTED = "a square matrix (n, n), dense or scipy.sparse"  # what the messages call a matrix

#: Relative asymmetry up to which a matrix counts as symmetric: assembly in another program rounds.
SYMMETRY = 1e-9
ROUNDING = 1e-12  # masses below zero by less than this share of the middle one are rounding


def as_sparse(columns: Columns) -> Any:
    """A matrix of the core as ``scipy.sparse.csc_array``."""
    from scipy.sparse import csc_array

    starts, rows, values = columns
    n = len(starts) - 1
    return csc_array((values, rows, starts), shape=(n, n))


def as_square(name: str, matrix: Any, n: int | None = None) -> tuple[int, Entries]:
    """Size and entries of a finite square matrix, (n, n) where n is known."""
    shape, entries = _entries(name, matrix)
    if shape != (n or shape[0],) * 2:
        wanted = "a non-empty square matrix, stiffness and mass of one size"
        reject(name, f"a matrix of shape {shape}", wanted, "Pass both after the same dofs were removed.")
    return shape[0], entries


def as_masses(mass: Entries, n: int, label: Callable[[int], str]) -> Entries:
    """A mass without what is below zero by rounding; real negative masses are refused, by name."""
    own = mass.diagonal(n)
    negative = np.flatnonzero(own < 0.0)
    if not negative.size:
        return mass
    positive = own[own > 0.0]
    least = ROUNDING * float(np.median(positive)) if positive.size else 0.0
    size = np.zeros(n)
    np.maximum.at(size, mass.rows, np.abs(mass.values))
    real = negative[size[negative] > least]
    if real.size:
        more = f" and {real.size - 1} more" if real.size > 1 else ""
        got = f"{own[real[0]]:.4g} kg at {label(int(real[0]))}{more}"
        remedy = "Check its signs, and that stiffness and mass are not exchanged."
        reject(part("mass", int(real[0])), got, "no negative mass", remedy)
    named = some((label(int(dof)) for dof in negative), 6)
    said = f"mass: negative by rounding at {named}, {own[negative].min():.2g}: counted as none."
    warn("negative_mass", said)
    gone = np.isin(np.arange(n), negative)
    return mass.those(~(gone[mass.rows] | gone[mass.columns]))


def as_term(name: str, matrix: Any, n: int) -> Entries:
    """Entries of a symmetric (n, n) matrix."""
    entries = as_square(name, matrix, n)[1]
    own = entries.sparse(n)
    if abs(own - own.T).max() > SYMMETRY * abs(own).max():
        remedy = "Pass (A + A.T) / 2 if the difference is rounding."
        reject(name, "a matrix that is not symmetric", "a symmetric term", remedy)
    return entries


def _entries(name: str, matrix: Any) -> tuple[tuple[int, ...], Entries]:
    """Shape and finite entries of a matrix; of a damped one the real part, as no antiresonance knows more."""
    if hasattr(matrix, "check_format"):  # SciPy's C code trusts the places
        try:
            matrix.check_format(full_check=True)
        except (ValueError, IndexError) as exc:
            reject(name, f"places outside of the matrix ({exc})", WANTED, "Make it anew from its entries.")
    shape, entries = _given(name, _undamped(name, matrix))
    above, below = (entries.rows < entries.columns).any(), (entries.rows > entries.columns).any()
    if shape[0] == shape[-1] and above != below:  # its mean with the mirror image would be wrong
        remedy = "Pass A + A.T - diag(A): scipy.sparse.diags_array(A.diagonal()) is diag(A)."
        got = f"the {'upper' if above else 'lower'} triangle only"
        reject(name, got, "a symmetric matrix, both triangles of it", remedy)
    return shape, entries


def _undamped(name: str, matrix: Any) -> Any:
    """The real part of a matrix: hysteretic damping moves no antiresonance of the undamped structure."""
    own = matrix if hasattr(matrix, "tocsr") else np.asarray(matrix)
    if not (hasattr(own, "dtype") and np.issubdtype(own.dtype, np.complexfloating)):
        return matrix
    size = abs(own.real).max()
    loss = float(abs(own.imag).max() / size) if size else 0.0
    if loss > 0.0:
        said = f"{name}: its imaginary part, {loss:.2g} of the real one, is left out: antiresonances are"
        said += " those of the undamped structure. Give damping_ratio= to frf and simulate."
        warn("complex_matrix", said)
    return own.real


def _given(name: str, matrix: Any) -> tuple[tuple[int, ...], Entries]:
    """Shape and finite entries of a matrix; a sparse one is never made dense."""
    if not hasattr(matrix, "tocsr"):
        array = matrix.toarray() if hasattr(matrix, "toarray") else matrix
        dense = real_array(name, array, ndim=2, wanted=WANTED)
        return dense.shape, Entries.of(dense)
    rows = matrix.tocsr(copy=True)
    if rows.ndim != 2 or 0 in rows.shape:
        return rows.shape, Entries.of(real_array(name, rows.toarray(), ndim=2, wanted=WANTED))
    rows.sum_duplicates()
    rows.data = real_array(name, rows.data, ndim=1, wanted=WANTED) if rows.nnz else np.zeros(0)
    return rows.shape, Entries.of_sparse(rows)


#: Dense matrices (n, n) that all modes take: K, M, a factor, the standard problem, its vectors, the shapes.
MATRICES = 6


def check_room_for_all_modes(n_dof: int) -> None:
    """Refuse all modes where the memory cannot hold their dense matrices; say how much they take."""
    try:
        np.empty(MATRICES * n_dof * n_dof)
    except MemoryError:
        why = "All modes need dense matrices. Ask for the modes up to f_max_hz, or for the lowest n_modes."
        raise OutOfMemoryError(f"all modes of {n_dof} dofs", 8 * MATRICES * n_dof**2, why) from None
