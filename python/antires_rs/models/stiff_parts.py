r"""Penalties: stiff springs, ties and rigid links inside a stiffness matrix, taken out of it.

.. math:: u_d = -K_{dd}^{-1} K_{dr} u_r + \delta, \qquad K_q = K_{rr} - K_{rd} K_{dd}^{-1} K_{dr}

for the dofs d that a penalty makes stiff. K_q is small beside the penalties it is the difference of, and is
therefore formed with 60 digits: it is that of the matrices as they were given. Where K_dd / M_dd is 1e8 times
that of the softer dofs, δ is left out, which moves a root by the share of λ M_dd / K_dd: 1e-8 at their K / M;
elsewhere the row of d holds δ, and nothing is left out.

Reference: R. J. Guyan, Reduction of stiffness and mass matrices, AIAA J. 3 (1965) 380.
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from decimal import Context, Decimal, localcontext
from typing import Any, NamedTuple

import numpy as np

from .entries import Entries

__all__ = ["StiffParts", "stiff_parts"]

#: Stiffness, and stiffness over mass, over those of the softer dofs from which on a penalty is looked for.
_STIFF = 3e5
#: Stiffness, and stiffness over mass, from which on it is rigid.
_RIGID, _AT_REST = 1e7, 1e8
#: Part of its stiffness that a dof loses with a penalty: the digits that rounding would take.
_FALLEN = 1.0 / _STIFF
#: Which dof is the softer one: below it is this part of all.
_SOFTER = 0.25
#: Most operations on the dofs of one penalty: some seconds.
_MOST_WORK = 3_000_000
_DIGITS = Context(prec=60)

Row = dict[int, Decimal]


class StiffParts(NamedTuple):
    """The dofs that penalties hold, and the stiffness without them.

    Attributes
    ----------
    gone : dict of int to dict
        Each dof taken out by rows that remain.
    stiffness : Entries
    stiffness_terms : list of Entries
    rounded : dict of int to float
        Dofs whose stiffness is the difference of penalties, and how much of it, relatively, an assembly in
        double precision rounds.
    """

    gone: dict[int, dict[int, float]]
    stiffness: Entries
    stiffness_terms: list[Entries]
    rounded: dict[int, float]


class _Bars(NamedTuple):
    """What counts as stiff: of the stiffness, and of the stiffness over mass."""

    stiffness: float
    rate: float
    mass: Any

    def pass_(self, value: Any, dof: Any, stiff: float, quick: float) -> Any:
        """Whether a stiffness is so many times the softer ones."""
        return (value >= stiff * self.stiffness) & (value >= quick * self.rate * self.mass[dof])


def stiff_parts(
    n: int, stiffness: Entries, mass: Entries, terms: tuple[Entries, ...], kept: set[int]
) -> StiffParts | None:
    """Those of matrices of ``n`` dofs, none where there are no penalties."""
    from scipy.sparse.csgraph import connected_components

    k, m = stiffness.diagonal(n), mass.diagonal(n)
    if not (k > 0.0).any():
        return None
    moving = (m > 0.0) & (k > 0.0)
    rate = float(np.quantile(k[moving] / m[moving], _SOFTER)) if moving.any() else 0.0
    bars = _Bars(float(np.quantile(k[k > 0.0], _SOFTER)), rate, m)
    chosen = np.flatnonzero(bars.pass_(k, slice(None), _STIFF, _STIFF))
    if not chosen.size:
        return None
    matrix = stiffness.sparse(n)
    count, group = connected_components(matrix[chosen][:, chosen], directed=False)
    gone: dict[int, Row] = {}
    added: defaultdict[tuple[int, int], Decimal] = defaultdict(Decimal)
    left: dict[int, float] = {}
    with localcontext(_DIGITS):
        for each in range(count):
            made = _Cluster(matrix, chosen[group == each], kept, bars)
            if made.eliminate():
                gone |= made.gone
                left |= made.left
                for pair, value in made.added().items():
                    added[pair] += value
        if not gone:
            return None
        own = _with(stiffness, gone, added)
        changed = [_transformed(term, gone) for term in terms]
    eps = float(np.finfo(np.float64).eps)
    rounded = {dof: eps * float(k[dof]) / max(abs(now), eps * float(k[dof])) for dof, now in left.items()}
    by = {dof: {q: float(value) for q, value in each.items()} for dof, each in gone.items()}
    return StiffParts(by, own, changed, rounded)


class _Cluster:
    """Stiff dofs that are joined, with their neighbours."""

    def __init__(self, matrix: Any, dofs: Any, kept: set[int], bars: _Bars) -> None:
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
        #: What is left of the stiffness of the stiff dofs that remain.
        self.left: dict[int, float] = {}

    def eliminate(self) -> bool:
        """Whether a penalty was found and taken out."""
        pivots = self._pivots()
        if not pivots:
            return False
        done = {dof for dof, _, _ in pivots}
        self.left = {dof: float(self._rows[dof].get(dof, 0)) for dof in self._dofs if dof not in done}
        fallen = any(now <= _FALLEN * float(self._given[dof][dof]) for dof, now in self.left.items())
        rigid = {dof for dof, pivot, _ in pivots if self._bars.pass_(float(pivot), dof, _RIGID, _AT_REST)}
        if not fallen and not rigid:
            return False
        for dof, pivot, by in reversed(pivots):
            whole: defaultdict[int, Decimal] = defaultdict(Decimal)
            if dof not in rigid:
                self._held[dof] = pivot
                whole[dof] = Decimal(1)
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
            if not self._bars.pass_(float(pivot), dof, _STIFF, _STIFF):
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
        """What the stiffness of rows that remain gains, and the pivots of those that hold a difference."""
        gained = {
            (i, j): value - self._given[i].get(j, Decimal(0))
            for i, row in self._rows.items()
            for j, value in row.items()
        }
        return gained | {(dof, dof): pivot for dof, pivot in self._held.items()}


def _with(stiffness: Entries, gone: dict[int, Row], added: dict[tuple[int, int], Decimal]) -> Entries:
    """The stiffness without the dofs taken out, with what the others gain."""
    out = np.array(list(gone))
    rest = stiffness.those(~(np.isin(stiffness.rows, out) | np.isin(stiffness.columns, out)))
    touched = {i for pair in added for i in pair}
    inside = np.isin(rest.rows, list(touched)) & np.isin(rest.columns, list(touched))
    whole: dict[tuple[int, int], Decimal] = dict(added)
    for i, j, value in zip(*(each.tolist() for each in rest.those(inside)), strict=True):
        whole[i, j] = whole.get((i, j), Decimal(0)) + Decimal(value)
    return _joined(rest.those(~inside), whole)


def _transformed(term: Entries, gone: dict[int, Row]) -> Entries:
    """T' A T of a term."""
    reached = list({*gone, *(q for by in gone.values() for q in by)})
    inside = np.isin(term.rows, reached) & np.isin(term.columns, reached)
    inside |= np.isin(term.rows, list(gone)) | np.isin(term.columns, list(gone))
    whole: defaultdict[tuple[int, int], Decimal] = defaultdict(Decimal)
    for i, j, value in zip(*(each.tolist() for each in term.those(inside)), strict=True):
        exact = Decimal(value)
        for p, left in gone.get(i, {i: Decimal(1)}).items():
            for q, right in gone.get(j, {j: Decimal(1)}).items():
                whole[p, q] += left * exact * right
    mean = {(p, q): (value + whole.get((q, p), value)) / 2 for (p, q), value in whole.items()}
    return _joined(term.those(~inside), mean)


def _joined(rest: Entries, exact: dict[tuple[int, int], Decimal]) -> Entries:
    """Entries with those of many digits, in double precision again."""
    found = [(i, j, float(value)) for (i, j), value in exact.items() if float(value) != 0.0]
    i, j, values = zip(*found, strict=True) if found else ((), (), ())
    return Entries.joined(
        np.concatenate([rest.rows, np.array(i, dtype=np.uint32)]),
        np.concatenate([rest.columns, np.array(j, dtype=np.uint32)]),
        np.concatenate([rest.values, np.array(values, dtype=np.float64)]),
    )
