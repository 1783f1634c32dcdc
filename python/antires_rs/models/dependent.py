r"""Rows of matrices that are no dofs of their own: what follows from others by an equation, and multipliers.

.. math:: u = T q, \qquad K_q = T^T K T, \quad M_q = T^T M T

Every dof keeps its number; which row of the core's matrices it is follows from what was taken out.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .entries import Entries

__all__ = ["CONSTRAINT", "MULTIPLIER", "RIGID", "STIFF", "Dependent", "TakenOut", "congruent", "without"]

MULTIPLIER, CONSTRAINT, STIFF, RIGID = range(4)
#: Of what a dof is made, shares below this are those of a stiff spring and its neighbours.
_SHARE = 1e-8


class TakenOut(NamedTuple):
    """A dof taken out: why, and its motion by rows that remain; its own may hold a difference."""

    reason: int
    by: Mapping[int, float]


class Dependent(NamedTuple):
    """All that are taken out: ascending, why, and their motion."""

    dofs: NDArray[np.uint32]
    reasons: NDArray[np.uint8]
    by: Entries

    @classmethod
    def of(cls, taken: Mapping[int, TakenOut]) -> Dependent:
        """In order."""
        dofs = sorted(taken)
        parts = [(dof, q, value) for dof in dofs for q, value in sorted(taken[dof].by.items())]
        by = zip(*parts, strict=True) if parts else ((), (), ())
        reasons = np.array([taken[dof].reason for dof in dofs], dtype=np.uint8)
        return cls(np.array(dofs, dtype=np.uint32), reasons, Entries.joined(*map(np.array, by)))

    def transformation(self, n: int) -> Any:
        """T (n, n), ``scipy.sparse``: columns of dofs taken out are empty, or hold a difference."""
        own = np.setdiff1d(np.arange(n), self.dofs)
        rows, columns = np.concatenate([own, self.by.rows]), np.concatenate([own, self.by.columns])
        return Entries(rows, columns, np.concatenate([np.ones(own.size), self.by.values])).sparse(n)

    def rows(self, n: int) -> NDArray[np.intp]:
        """Row of each of ``n`` dofs in matrices without those that hold nothing; -1 for these."""
        there = np.ones(n, dtype=bool)
        there[self.dofs] = False
        there[self.by.columns] = True
        return np.where(there, np.cumsum(there) - 1, -1)

    def reason(self, dof: int) -> int | None:
        """Why a dof is taken out; None if it is not."""
        at = int(np.searchsorted(self.dofs, dof))
        return int(self.reasons[at]) if at < self.dofs.size and self.dofs[at] == dof else None

    def moving_as(self, dof: int) -> int | None:
        """The dof that moves as ``dof`` does: itself, or the one that it follows; None without one."""
        if self.reason(dof) is None:
            return dof
        mine = self.by.rows == dof
        masters, shares = self.by.columns[mine], self.by.values[mine]
        if not shares.size:
            return None
        first = int(np.argmax(np.abs(shares)))
        others = np.abs(np.delete(shares, first)).sum()
        return int(masters[first]) if abs(shares[first] - 1.0) + others <= _SHARE else None

    def masters(self, dof: int) -> set[int]:
        """The dofs by which ``dof`` moves, if it is taken out."""
        return {*self.by.columns[self.by.rows == dof].tolist()} if self.reason(dof) is not None else set()


def without(entries: Entries, rows: NDArray[np.intp]) -> Entries:
    """Entries at their rows among those that are left."""
    return Entries(
        rows[entries.rows].astype(np.uint32), rows[entries.columns].astype(np.uint32), entries.values
    )


def congruent(n: int, entries: Entries, t: Any) -> Entries:
    """Entries of T' A T."""
    product = t.T @ entries.sparse(n) @ t
    return Entries.of_sparse(0.5 * (product + product.T))  # the products round differently above and below
