"""Constraints as a user gives them, by numbers or names of dofs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..support.validation import integer, reject
from .dof_names import DofNames
from .entries import Entries
from .equations import dofs_to_keep, equations_of

__all__ = ["equations_by_number"]


def equations_by_number(
    names: tuple[str, ...], n: int, constraints: Any, keep: Sequence[int | str]
) -> tuple[Entries | None, tuple[int, ...]]:
    """Equations, a row each, and dofs to keep; ``names`` are those of ``n`` dofs, if they have any."""
    known = DofNames(names)

    def number(name: str, dof: Any) -> int:
        if isinstance(dof, str):
            if names:
                return known.find(name, dof)
            wanted = f"a zero-based number, 0 to {n - 1}: the dofs have no names"
            reject(name, repr(dof), wanted, "Give the names of all rows: dofs=.")
        return integer(name, dof, low=0, high=n - 1)

    kept = tuple(sorted(dofs_to_keep(keep, n, number)))
    equations = [] if constraints is None else equations_of(constraints, n, number)
    entries = [(row, dof, value) for row, each in enumerate(equations) for dof, value in each.items()]
    return (Entries.joined(*map(np.array, zip(*entries, strict=True))) if entries else None), kept
