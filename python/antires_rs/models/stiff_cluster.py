r"""Elimination of stiff dofs that are joined, with 60 digits.

.. math:: u_d = -K_{dd}^{-1} K_{dr} u_r + \delta, \qquad K_q = K_{rr} - K_{rd} K_{dd}^{-1} K_{dr}
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from decimal import Context, Decimal
from typing import Any

from .penalty_signs import FALLEN, STIFF, Bars

__all__ = ["DIGITS", "Cluster", "Row"]

#: Most operations on the dofs of one penalty: some seconds.
_MOST_WORK = 3_000_000
DIGITS = Context(prec=60)

Row = dict[int, Decimal]


class Cluster:
    """Stiff dofs that are joined, with their neighbours."""

    def __init__(self, matrix: Any, dofs: Any, kept: set[int], bars: Bars) -> None:
        self._dofs, self._bars = [int(dof) for dof in dofs], bars
        self._candidates = [dof for dof in self._dofs if dof not in kept]
        near = {int(j) for i in self._dofs for j in matrix.indices[matrix.indptr[i] : matrix.indptr[i + 1]]}
        self._rows: dict[int, Row] = {}
        for i in near:
            part = slice(matrix.indptr[i], matrix.indptr[i + 1])
            row = zip(matrix.indices[part].tolist(), matrix.data[part].tolist(), strict=True)
            self._rows[i] = {j: Decimal(value) for j, value in row if j in near}
        for i, own in self._rows.items():
            for j in [j for j in own if j < i]:  # assembly elsewhere may have rounded the triangles apart
                own[j] = self._rows[j][i] = (own[j] + self._rows[j].get(i, own[j])) / 2
        self._given = {i: dict(row) for i, row in self._rows.items()}
        #: Each dof taken out by rows that remain, and what its own row holds.
        self.gone: dict[int, Row] = {}
        self._held: dict[int, Decimal] = {}
        #: Those of them that move with others but for a penalty's own, far higher, roots.
        self.rigid: set[int] = set()
        #: What is left of the stiffness of the dofs that remain, where they have been as stiff.
        self.left: dict[int, float] = {}

    def eliminate(self, *, supported: bool) -> bool:
        """Whether a penalty was found and taken out: a support is known, a tie leaves a difference."""
        pivots = self._pivots()
        if not pivots:
            return False
        self.left = {
            dof: float(row.get(dof, 0))
            for dof, row in self._rows.items()
            if float(self._given[dof].get(dof, 0)) >= STIFF[0] * self._bars.stiffness
        }
        fallen = any(now <= FALLEN * float(self._given[dof][dof]) for dof, now in self.left.items())
        self.rigid = {dof for dof, pivot, _ in pivots if self._bars.are_rigid(float(pivot), dof)}
        if not fallen and not (supported and self.rigid):
            return False
        for dof, pivot, by in reversed(pivots):
            whole = defaultdict(Decimal, {dof: Decimal(1)})
            self._held[dof] = pivot
            for j, value in by.items():
                for q, share in self.gone.get(j, {j: Decimal(1)}).items():
                    whole[q] += value * share
            self.gone[dof] = dict(whole)
        return True

    def _pivots(self) -> list[tuple[int, Decimal, Row]]:
        """Stiff dofs, those with the fewest neighbours first, their pivots, and each by those still there."""
        rows, found, work = self._rows, list[tuple[int, Decimal, Row]](), 0
        heap = [(len(rows[dof]), dof) for dof in self._candidates]
        heapq.heapify(heap)
        while heap:
            count, dof = heapq.heappop(heap)
            if len(rows[dof]) > count:
                heapq.heappush(heap, (len(rows[dof]), dof))
                continue
            pivot = rows[dof].get(dof, Decimal(0))
            if not self._bars.are_stiff(float(pivot), dof):
                continue
            work += count * count
            if work > _MOST_WORK:
                return []
            column = rows.pop(dof)
            del column[dof]
            others = sorted(column)
            for nth, i in enumerate(others):
                row, share = rows[i], column[i] / pivot
                del row[dof]
                for j in others[nth:]:
                    row[j] = rows[j][i] = row.get(j, Decimal(0)) - share * column[j]
            found.append((dof, pivot, {j: -value / pivot for j, value in column.items()}))
        return found

    def added(self) -> dict[tuple[int, int], Decimal]:
        """What the stiffness of rows that remain gains, and the pivots of those taken out."""
        gained = {
            (i, j): value - self._given[i].get(j, Decimal(0))
            for i, row in self._rows.items()
            for j, value in row.items()
        }
        return gained | {(dof, dof): pivot for dof, pivot in self._held.items()}
