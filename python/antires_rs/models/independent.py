"""Matrices without what is no dof of its own: Lagrange multipliers, constraints, penalties, in this order."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..exceptions import part, reject
from .constraints import (
    CONSTRAINT,
    MULTIPLIER,
    RIGID,
    STIFF,
    Dependent,
    Equation,
    TakenOut,
    congruent,
    equations_of,
    solved,
    without,
)
from .matrices import Entries
from .stiff_parts import stiff_parts

if TYPE_CHECKING:
    from .._core import Model as CoreModel


class Matrices(NamedTuple):
    """Stiffness, mass and their terms, of ``n`` dofs."""

    n: int
    stiffness: Entries
    mass: Entries
    stiffness_terms: tuple[Entries, ...]
    mass_terms: tuple[Entries, ...]

    def transformed(self, t: object) -> Matrices:
        """T' A T of all."""
        n = self.n
        return Matrices(
            n,
            congruent(n, self.stiffness, t),
            congruent(n, self.mass, t),
            tuple(congruent(n, term, t) for term in self.stiffness_terms),
            tuple(congruent(n, term, t) for term in self.mass_terms),
        )


class Independent(NamedTuple):
    """What is left.

    Attributes
    ----------
    matrices : Matrices
        Without rows that hold nothing.
    dependent : Dependent or None
        What was taken out.
    rows : ndarray of int, (n,), or None
        Row of each dof in the matrices, -1 where it has none.
    rounded : dict of int to float
        As of :class:`StiffParts`.
    """

    matrices: Matrices
    dependent: Dependent | None
    rows: NDArray[np.intp] | None
    rounded: Mapping[int, float]

    def core(self) -> CoreModel:
        """The core's model."""
        return _core.Model.from_matrices(*self.matrices)


def independent_of(
    given: Matrices,
    constraints: Entries | None,
    kept: set[int],
    *,
    penalties: bool = True,
    whole: bool = False,
) -> Independent:
    """Of what a recipe holds; no dof of ``kept`` is taken out, ``penalties`` if so wanted.

    With the motion over penalties where ``whole``, so that none of the highest roots is lost.
    """
    n = given.n
    taken: dict[int, TakenOut] = {}
    left, equations = _without_multipliers(given, taken)
    if constraints is not None:
        count = int(constraints.rows.max()) + 1
        equations = equations_of(constraints.sparse(count, n), n) + equations
    if equations:
        gone = {dof: TakenOut(CONSTRAINT, by) for dof, by in solved(equations, kept).items()}
        if gone:
            left = left.transformed(Dependent.of(gone).transformation(n))
            taken |= gone
    found = stiff_parts(*left, kept, whole=whole) if penalties else None
    if found is not None:
        gone = {dof: TakenOut(RIGID if dof in found.rigid else STIFF, by) for dof, by in found.gone.items()}
        t = Dependent.of(gone).transformation(n)
        left = Matrices(
            n,
            found.stiffness,
            congruent(n, left.mass, t),
            tuple(found.stiffness_terms),
            tuple(congruent(n, term, t) for term in left.mass_terms),
        )
        taken = {dof: TakenOut(each.reason, _through(each.by, found.gone)) for dof, each in taken.items()}
        taken |= gone
    if not taken:
        return Independent(left, None, None, {})
    dependent = Dependent.of(taken)
    rows = dependent.rows(n)
    kept_rows = Matrices(
        int(rows.max()) + 1,
        without(left.stiffness, rows),
        without(left.mass, rows),
        tuple(without(term, rows) for term in left.stiffness_terms),
        tuple(without(term, rows) for term in left.mass_terms),
    )
    return Independent(kept_rows, dependent, rows, {} if found is None else found.rounded)


def _without_multipliers(given: Matrices, taken: dict[int, TakenOut]) -> tuple[Matrices, list[Equation]]:
    """The matrices without the rows of Lagrange multipliers, and the equations that these are."""
    k, m = given.stiffness, given.mass
    alone = np.bincount(k.rows, minlength=given.n) > 0
    alone[k.rows[k.rows == k.columns]] = False
    alone[m.rows] = False
    # A multiplier has nothing with other multipliers; of two massless dofs that are joined neither is one.
    multiplier = alone.copy()
    multiplier[k.rows[alone[k.rows] & alone[k.columns]]] = False
    if not multiplier.any():
        return given, []
    for name, terms in (("stiffness_terms", given.stiffness_terms), ("mass_terms", given.mass_terms)):
        for i, term in enumerate(terms):
            touched = term.rows[multiplier[term.rows]]
            if touched.size:
                reject(
                    part(name, i),
                    f"an entry in row {int(touched[0])}, which is a Lagrange multiplier",
                    "terms of the structure: an equation has no stiffness that a parameter could scale",
                    "Leave the rows of the equations out of the term.",
                )
    equations: dict[int, Equation] = {int(row): {} for row in np.flatnonzero(multiplier)}
    of_rows = k.those(multiplier[k.rows])
    for row, column, value in zip(*(each.tolist() for each in of_rows), strict=True):
        equations[row][column] = value
    taken |= {row: TakenOut(MULTIPLIER, {}) for row in equations}
    return given._replace(stiffness=k.those(~(multiplier[k.rows] | multiplier[k.columns]))), list(
        equations.values()
    )


def _through(by: Mapping[int, float], gone: Mapping[int, Mapping[int, float]]) -> dict[int, float]:
    """A motion by dofs of which some are gone too."""
    whole: dict[int, float] = {}
    for dof, value in by.items():
        for q, share in gone.get(dof, {dof: 1.0}).items():
            whole[q] = whole.get(q, 0.0) + value * share
    return whole
