r"""Penalties: ties, rigid links and stiff supports inside a stiffness matrix, taken out of it.

.. math:: u_d = -K_{dd}^{-1} K_{dr} u_r + \delta, \qquad K_q = K_{rr} - K_{rd} K_{dd}^{-1} K_{dr}

for the dofs d that a penalty makes stiff. K_q is small beside the penalties it is the difference of, and is
therefore formed with 60 digits: it is that of the matrices as they were given. The row of d holds δ, the
motion over the penalty, unless it moves no mass. Where K_dd / M_dd is 1e8 times that of the softer dofs, δ
may be left out, which moves a root by the share of λ M_dd / K_dd, 1e-8 at their K / M, and takes out those
that are 1e4 times as high in Hz. What is only stiff, as in a graded matrix D K D, is left to the solvers,
which scale by powers of two.

Reference: R. J. Guyan, Reduction of stiffness and mass matrices, AIAA J. 3 (1965) 380.
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Iterable, Mapping
from decimal import Context, Decimal, localcontext
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..support.checks import FloatArray
from .constraints import congruent
from .matrices import Entries

# -- How stiff a dof is without the ties it is in
#
# Scaled to a diagonal of ones, :math:`|k_{ij}| / \sqrt{k_{ii} k_{jj}}`, dofs of a tie are joined by couplings
# of the order of one, and to its neighbours by those that a penalty leaves, 2e-3 and less. Where what is
# joined can move as a rigid body, these neighbours alone are what holds it. None of this depends on the units
# of a dof, nor on how many of the dofs are soft.


#: Part of its stiffness that a tie leaves, at most.
_LEFT = 1.0 / 3e5
#: Largest scaled coupling of a tie to soft neighbours.
_WEAK = float(np.sqrt(_LEFT))
#: Couplings so small may be the rounding of an angle; they count for ties of two nodes only.
_ROUNDING = 1e-14
#: Most dofs of one tie, and of one between two nodes.
_MOST, _TWO_NODES = 300, 12


def without_ties(n: int, stiffness: Entries) -> FloatArray:
    """Diagonal of the stiffness (n,); of tied dofs twice their stiffest coupling to others, as in a chain."""
    from scipy.sparse.csgraph import connected_components

    k = stiffness.diagonal(n)
    size = np.sqrt(np.where(k > 0.0, k, 1.0))
    scaled = stiffness._replace(values=stiffness.values / size[stiffness.rows] / size[stiffness.columns])
    weak = np.abs(scaled.values) <= _WEAK
    if not weak.any():
        return k
    count, group = connected_components(scaled.those(~weak).sparse(n), directed=False)
    number, at = np.bincount(group), group[stiffness.rows]
    least = np.where(number[at] <= _TWO_NODES, 0.0, _ROUNDING)
    between = weak & (np.abs(scaled.values) > least) & (at != group[stiffness.columns])
    outward = np.zeros(count)
    np.maximum.at(outward, at[between], np.abs(stiffness.values[between]))
    tied = (outward > 0.0) & (number > 1) & (number <= _MOST)
    if not tied.any():
        return k
    place = np.empty(n, dtype=np.intp)  # of each dof in its group
    place[np.argsort(group, kind="stable")] = np.arange(n) - np.repeat(np.cumsum(number) - number, number)
    inside = scaled.those(tied[at] & (at == group[stiffness.columns]))
    held = group[inside.rows]
    for size_of in np.unique(number[tied]):
        these = np.flatnonzero(tied & (number == size_of))
        own, chosen = np.zeros((these.size, size_of, size_of)), number[held] == size_of
        part = inside.those(chosen)
        own[np.searchsorted(these, held[chosen]), place[part.rows], place[part.columns]] = part.values
        tied[these] = np.linalg.eigvalsh(own)[:, 0] <= _LEFT
    return np.where(tied[group], np.minimum(k, 2.0 * outward[group]), k)


# -- Which stiff dofs hold a penalty, and which are only stiff
#
# A tie or a rigid link leaves a difference: through the elimination of the stiff dofs d the stiffness of
# another one falls by 3e5 and more,
#
# .. math:: k_{jj} - K_{jd} K_{dd}^{-1} K_{dj} \le k_{jj} / 3 \cdot 10^5,
#
# whatever the units of the dofs are, and rounding takes as many digits. Of a support the couplings to its
# neighbours, :math:`|k_{dj}| / \sqrt{k_{dd} k_{jj}}`, are tiny. A graded matrix D K D has neither.


#: Stiffness, and stiffness over mass, over those of the softer dofs from which on a penalty is looked for.
STIFF = (3e5, 3e5)
#: The same from which on it is rigid.
RIGID = (1e7, 1e8)
#: Part of its stiffness that a dof keeps beside a penalty, at most: the digits that rounding would take.
FALLEN = 1.0 / STIFF[0]
#: Which dof is the softer one: below it is this part of all.
_SOFTER = 0.25
#: Largest coupling of a support to its neighbours.
_LOOSE = 1e-3
#: What is estimated in double precision may be that many times off.
_SAFETY = 10.0
#: Most dofs of a group whose inverse is formed; columns solved for at a time.
_DENSE, _BLOCK = 300, 128


class Bars(NamedTuple):
    """What counts as stiff: the softer stiffness (N/m), stiffness over mass (1/s2), and the masses (n,).

    Rigid is what is stiff beside the softer diagonals with the ties in them: where ties are on most dofs, no
    motion over them is left out.
    """

    stiffness: float
    rate: float
    rigid: tuple[float, float]
    mass: Any

    @classmethod
    def of(cls, n: int, stiffness: Entries, m: Any) -> Bars:
        """Of stiffness, some of its diagonal positive, and the diagonal of the mass."""
        given = _softer(stiffness.diagonal(n), m)
        softer = _softer(without_ties(n, stiffness), m)
        return cls(min(softer[0], given[0]), min(softer[1], given[1]), given, m)

    def are_stiff(self, value: Any, dof: Any) -> Any:
        """Whether a stiffness may be that of a penalty."""
        return (value >= STIFF[0] * self.stiffness) & (value >= STIFF[1] * self.rate * self.mass[dof])

    def are_rigid(self, value: Any, dof: Any) -> Any:
        """Whether it is so stiff that the motion over it may be left out."""
        return (value >= RIGID[0] * self.rigid[0]) & (value >= RIGID[1] * self.rigid[1] * self.mass[dof])


def _softer(k: Any, m: Any) -> tuple[float, float]:
    """The lower quartile of stiffness, and of stiffness over mass."""
    moving = (m > 0.0) & (k > 0.0)
    rate = float(np.quantile(k[moving] / m[moving], _SOFTER)) if moving.any() else 0.0
    return float(np.quantile(k[k > 0.0], _SOFTER)), rate


def penalty_groups(n: int, stiffness: Entries, bars: Bars) -> list[tuple[NDArray[np.intp], bool]]:
    """Stiff dofs that are joined, where they may hold a penalty, and whether a support is among them."""
    from scipy.sparse.csgraph import connected_components

    k = stiffness.diagonal(n)
    stiff = bars.are_stiff(k, slice(None))
    if not stiff.any():
        return []
    chosen = np.flatnonzero(stiff)
    # Of what is heavy too the stiffness falls all the same.
    watched = np.flatnonzero((k >= STIFF[0] * bars.stiffness) & ~stiff)
    size = np.sqrt(np.where(k > 0.0, k, 1.0))
    near = stiffness.those(stiff[stiffness.rows] & (stiffness.rows != stiffness.columns))
    coupling = np.abs(near.values / size[near.rows] / size[near.columns])
    largest = np.zeros(n)
    np.maximum.at(largest, near.rows, coupling)
    held = (largest > 0.0) & (largest <= _LOOSE) & bars.are_rigid(k, slice(None))
    scaled = stiffness._replace(values=stiffness.values / size[stiffness.rows] / size[stiffness.columns])
    matrix = scaled.sparse(n)[chosen]
    own, beside = matrix[:, chosen], matrix[:, watched]
    count, group = connected_components(own, directed=False)
    supported = np.zeros(count, dtype=bool)
    supported[group[held[chosen]]] = True
    suspect = supported.copy()
    if _may_fall(own, beside):
        order = np.argsort(group, kind="stable")
        for each, at in enumerate(np.split(order, np.cumsum(np.bincount(group))[:-1])):
            suspect[each] = suspect[each] or _may_fall(own[at][:, at], beside[at])
    return [(chosen[group == each], bool(supported[each])) for each in np.flatnonzero(suspect)]


def _may_fall(own: Any, beside: Any) -> bool:
    """Whether the stiffness of one of these dofs, or of those beside them, may fall by elimination.

    Both scaled to a diagonal of ones, so that the share that is left is a pivot.
    """
    from scipy.sparse.linalg import LinearOperator, onenormest, splu

    n = own.shape[0]
    near = np.flatnonzero(np.diff(beside.tocsc().indptr))
    bar = _SAFETY * FALLEN
    if n == 1 and not near.size:
        return False
    if n <= _DENSE:
        try:
            inverse = np.linalg.inv(own.toarray())
        except np.linalg.LinAlgError:
            return True
        columns = beside[:, near].toarray()
        own_share = np.diag(inverse)  # of which each is 1 / what is left
        falls = 1.0 - np.sum(columns * (inverse @ columns), axis=0)
        return not bool(np.all((own_share > 0.0) & (own_share < 1.0 / bar)) and np.all(falls > bar))
    try:
        factors = splu(own.tocsc())
    except RuntimeError:  # exactly singular
        return True
    solve = LinearOperator((n, n), matvec=factors.solve, rmatvec=lambda b: factors.solve(b, "T"))
    if not onenormest(solve) < 1.0 / bar:
        return True
    for first in range(0, near.size, _BLOCK):
        columns = beside[:, near[first : first + _BLOCK]].toarray()
        if not bool(np.all(1.0 - np.sum(columns * factors.solve(columns), axis=0) > bar)):
            return True
    return False


# -- Elimination of stiff dofs that are joined, with 60 digits
#
# .. math:: u_d = -K_{dd}^{-1} K_{dr} u_r + \delta, \qquad K_q = K_{rr} - K_{rd} K_{dd}^{-1} K_{dr}


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


# -- Stiffness with stiff dofs taken out: what cancels is summed with many digits, the rest as doubles


class Exact(NamedTuple):
    """Each dof taken out by rows that remain and its own, and which of them are rigid."""

    gone: dict[int, Row]
    rigid: set[int]

    def transformation(self, n: int) -> Entries:
        """T (n, n) in double precision."""
        own = np.setdiff1d(np.arange(n), list(self.gone))
        parts = [(dof, q, float(value)) for dof, by in self.gone.items() for q, value in by.items()]
        rows, columns, values = (np.array(each) for each in zip(*parts, strict=True))
        return Entries.joined(
            np.concatenate([own, rows]),
            np.concatenate([own, columns]),
            np.concatenate([np.ones(own.size), values]),
        )


def with_added(
    n: int, stiffness: Entries, gone: Iterable[int], added: Mapping[tuple[int, int], Decimal]
) -> Entries:
    """The stiffness without the dofs taken out, with what the others gain."""
    out = _mask(n, gone)
    rest = stiffness.those(~(out[stiffness.rows] | out[stiffness.columns]))
    touched = _mask(n, (i for pair in added for i in pair))
    inside = touched[rest.rows] & touched[rest.columns]
    whole = dict(added)
    for i, j, value in zip(*(each.tolist() for each in rest.those(inside)), strict=True):
        whole[i, j] = whole.get((i, j), Decimal(0)) + Decimal(value)
    return _joined(rest.those(~inside), whole)


def transformed_terms(n: int, terms: Iterable[Entries], exact: Exact, bar: float) -> list[Entries]:
    """T' A T of terms; entries from ``bar`` (N/m) on are those of a penalty, and cancel."""
    out, t = _mask(n, exact.gone), exact.transformation(n).sparse(n)
    reached = _mask(n, (q for by in exact.gone.values() for q in by)) | out
    found = []
    for term in terms:
        if not np.any(out[term.rows] | out[term.columns]):
            found.append(term)
            continue
        cancels = (np.abs(term.values) >= bar) & reached[term.rows] & reached[term.columns]
        whole = congruent(n, term.those(~cancels), t)
        if cancels.any():
            whole = _sum(n, whole, _exactly(term.those(cancels), exact.gone))
        found.append(whole)
    return found


def _exactly(term: Entries, gone: Mapping[int, Row]) -> Entries:
    """T' A T with many digits."""
    whole: defaultdict[tuple[int, int], Decimal] = defaultdict(Decimal)
    for i, j, value in zip(*(each.tolist() for each in term), strict=True):
        given = Decimal(value)
        for p, left in gone.get(i, {i: Decimal(1)}).items():
            for q, right in gone.get(j, {j: Decimal(1)}).items():
                whole[p, q] += left * given * right
    nothing = term.those(np.zeros(term.values.size, dtype=bool))
    return _joined(nothing, {(p, q): (v + whole.get((q, p), v)) / 2 for (p, q), v in whole.items()})


def _sum(n: int, one: Entries, other: Entries) -> Entries:
    return Entries.of_sparse(one.sparse(n) + other.sparse(n))


def _mask(n: int, dofs: Iterable[int]) -> NDArray[np.bool_]:
    which = np.zeros(n, dtype=bool)
    which[list(dofs)] = True
    return which


def _joined(rest: Entries, exact: Mapping[tuple[int, int], Decimal]) -> Entries:
    """Entries with those of many digits, in double precision again."""
    found = [(i, j, float(value)) for (i, j), value in exact.items() if float(value) != 0.0]
    i, j, values = zip(*found, strict=True) if found else ((), (), ())
    return Entries.joined(
        np.concatenate([rest.rows, np.array(i, dtype=np.uint32)]),
        np.concatenate([rest.columns, np.array(j, dtype=np.uint32)]),
        np.concatenate([rest.values, np.array(values, dtype=np.float64)]),
    )


class StiffParts(NamedTuple):
    """The dofs that penalties hold, and the stiffness without them.

    Attributes
    ----------
    gone : dict of int to dict
        Each dof taken out by rows that remain, its own among them where it holds the motion over the penalty.
    rigid : frozenset of int
        Those of which that motion is left out though it moves a mass.
    stiffness : Entries
    stiffness_terms : list of Entries
    rounded : dict of int to float
        Dofs whose stiffness is the difference of penalties, and how much of it, relatively, an assembly in
        double precision rounds.
    """

    gone: dict[int, dict[int, float]]
    rigid: frozenset[int]
    stiffness: Entries
    stiffness_terms: list[Entries]
    rounded: dict[int, float]


def stiff_parts(
    n: int,
    stiffness: Entries,
    mass: Entries,
    terms: tuple[Entries, ...],
    mass_terms: tuple[Entries, ...],
    kept: set[int],
    *,
    whole: bool,
) -> StiffParts | None:
    """Those of matrices of ``n`` dofs, None where there are none; δ is held everywhere if ``whole``."""
    k, m = stiffness.diagonal(n), mass.diagonal(n)
    if not (k > 0.0).any():
        return None
    bars = Bars.of(n, stiffness, m)
    groups = penalty_groups(n, stiffness, bars)
    if not groups:
        return None
    matrix = stiffness.sparse(n)
    exact = Exact({}, set())
    added: defaultdict[tuple[int, int], Decimal] = defaultdict(Decimal)
    left: dict[int, float] = {}
    with localcontext(DIGITS):
        for dofs, supported in groups:
            made = Cluster(matrix, dofs, kept, bars)
            if made.eliminate(supported=supported):
                exact.gone.update(made.gone)
                exact.rigid.update(made.rigid)
                left |= made.left
                for pair, value in made.added().items():
                    added[pair] += value
        if not exact.gone:
            return None
        idle = _idle(n, (mass, *terms, *mass_terms), exact.gone)
        rigid = frozenset() if whole else frozenset(exact.rigid - idle)
        free = idle | rigid
        for by in exact.gone.values():
            for dof in free & by.keys():
                del by[dof]
        added = defaultdict(Decimal, {pair: v for pair, v in added.items() if not free & {*pair}})
        own = with_added(n, stiffness, exact.gone, added)
        changed = transformed_terms(n, terms, exact, STIFF[0] * bars.stiffness)
    eps = float(np.finfo(np.float64).eps)
    rounded = {dof: eps * float(k[dof]) / max(abs(now), eps * float(k[dof])) for dof, now in left.items()}
    shares = {dof: {q: float(value) for q, value in each.items()} for dof, each in exact.gone.items()}
    return StiffParts(shares, rigid, own, changed, rounded)


def _idle(n: int, matrices: tuple[Entries, ...], gone: dict[int, Row]) -> set[int]:
    """Dofs taken out whose own motion, over the penalty, reaches no mass and no term: it is zero."""
    moved = np.zeros(n, dtype=bool)
    for matrix in matrices:
        moved[matrix.rows] = True
    held = {q for dof, by in gone.items() if moved[dof] for q in by}
    return {dof for dof in gone if dof not in held}
