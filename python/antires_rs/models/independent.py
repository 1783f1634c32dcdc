"""Matrices without what is no dof of its own: Lagrange multipliers, constraints."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..exceptions import part, reject
from .constraints import (
    CONSTRAINT,
    MULTIPLIER,
    Dependent,
    Equation,
    TakenOut,
    congruent,
    equations_of,
    solved,
    without,
)
from .matrices import Entries

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
    """

    matrices: Matrices
    dependent: Dependent | None
    rows: NDArray[np.intp] | None

    def core(self) -> CoreModel:
        """The core's model."""
        return _core.Model.from_matrices(*self.matrices)


def independent_of(given: Matrices, constraints: Entries | None, kept: set[int]) -> Independent:
    """Of what a recipe holds; no dof of ``kept`` is taken out."""
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
    if not taken:
        return Independent(left, None, None)
    dependent = Dependent.of(taken)
    rows = dependent.rows(n)
    kept_rows = Matrices(
        int(rows.max()) + 1,
        without(left.stiffness, rows),
        without(left.mass, rows),
        tuple(without(term, rows) for term in left.stiffness_terms),
        tuple(without(term, rows) for term in left.mass_terms),
    )
    return Independent(kept_rows, dependent, rows)


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
