r"""Which stiff dofs hold a penalty, and which are only stiff.

A tie or a rigid link leaves a difference: through the elimination of the stiff dofs d the stiffness of
another one falls by 3e5 and more,

.. math:: k_{jj} - K_{jd} K_{dd}^{-1} K_{dj} \le k_{jj} / 3 \cdot 10^5,

whatever the units of the dofs are, and rounding takes as many digits. Of a support the couplings to its
neighbours, :math:`|k_{dj}| / \sqrt{k_{dd} k_{jj}}`, are tiny. A graded matrix D K D has neither.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .entries import Entries
from .stiff_softness import without_ties

__all__ = ["FALLEN", "RIGID", "STIFF", "Bars", "penalty_groups"]

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
