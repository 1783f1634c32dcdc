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

from collections import defaultdict
from decimal import Decimal, localcontext
from typing import NamedTuple

import numpy as np

from .entries import Entries
from .penalty_signs import STIFF, Bars, penalty_groups
from .stiff_cluster import DIGITS, Cluster, Row
from .stiff_entries import Exact, transformed_terms, with_added

__all__ = ["StiffParts", "stiff_parts"]


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
