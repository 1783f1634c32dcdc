"""Linear equations between dofs as users give them: dicts, rows, arrays dense or sparse."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ..support.validation import finite_scalar, integer, part, real_array, reject

__all__ = ["Equation", "dofs_to_keep", "equations_of", "square"]

Equation = dict[int, float]
Number = Callable[[str, Any], int]


def equations_of(constraints: Any, n: int, number: Number | None = None) -> list[Equation]:
    """Each equation by its dofs; ``number`` finds those that are called by a name."""
    wanted = f"a list of equations, each a dict such as {{2: 1.0, 1: -1.0}}, or an array (c, {n})"
    if isinstance(constraints, Mapping):
        reject("constraints", "one dict", wanted, "Put it in a list: [{2: 1.0, 1: -1.0}].")
    if hasattr(constraints, "tocsr"):
        return _of_sparse(constraints, n, wanted)
    if (
        isinstance(constraints, str | bytes)
        or not isinstance(constraints, Iterable)
        or not _shape(constraints)
    ):
        reject("constraints", repr(constraints), wanted, "Put the equations in a list, also where it is one.")
    find = number or _numbers(n)
    return [_equation(part("constraints", i), each, n, find) for i, each in enumerate(constraints)]


def dofs_to_keep(keep: Any, n: int, number: Number | None = None) -> set[int]:
    """Numbers of the dofs that must remain."""
    if isinstance(keep, str | bytes) or not isinstance(keep, Iterable) or not _shape(keep):
        reject("keep", repr(keep), "a sequence of dofs", "Put it in a list, also where it is one.")
    find = number or _numbers(n)
    return {find(part("keep", i), dof) for i, dof in enumerate(keep)}


def square(name: str, matrix: Any, n: int | None = None) -> Any:
    """A square matrix, (n, n) where n is known, as ``scipy.sparse.csr_array``."""
    from scipy.sparse import csr_array

    given = matrix if hasattr(matrix, "tocsr") else np.asarray(matrix)
    shape = given.shape
    if len(shape) != 2 or shape != (n or shape[0],) * 2 or given.dtype.kind not in "biufc":
        size = "" if n is None else f", ({n}, {n}) as the stiffness"
        got = f"a matrix of shape {shape}" if given.dtype.kind in "biufc" else repr(matrix)
        reject(name, got, f"a square matrix of numbers{size}", "Pass both after the same dofs were removed.")
    return csr_array(given)


def _shape(given: Any) -> bool:
    """Whether it has items: an array of no axis has none."""
    return not isinstance(given, np.ndarray) or given.ndim > 0


def _numbers(n: int) -> Number:
    return lambda name, dof: integer(name, dof, low=0, high=n - 1)


def _of_sparse(constraints: Any, n: int, wanted: str) -> list[Equation]:
    shape = constraints.shape
    if len(shape) != 2 or shape[1] != n:
        reject("constraints", f"a sparse array of shape {shape}", wanted, "One column a dof, a row each.")
    table = constraints.tocsr(copy=True)
    table.sum_duplicates()
    # An array of no entry is in order, and not for real_array.
    values = real_array("constraints", table.data, ndim=1, wanted=wanted) if table.nnz else table.data
    columns, starts = table.indices.tolist(), table.indptr.tolist()
    numbers = values.tolist()
    return [
        dict(zip(columns[first:end], numbers[first:end], strict=True))
        for first, end in zip(starts[:-1], starts[1:], strict=True)
    ]


def _equation(name: str, given: Any, n: int, find: Number) -> Equation:
    if not isinstance(given, Mapping):
        wanted = f"a row ({n},) of finite numbers, or a dict of dofs"
        row = real_array(name, given, ndim=None, wanted=wanted)
        if row.shape != (n,):
            reject(name, f"a row of shape {row.shape}", wanted, "One number a dof.")
        return {int(dof): float(row[dof]) for dof in np.flatnonzero(row)}
    return {find(name, dof): finite_scalar(name, value) for dof, value in given.items()}
