"""Matrices without what is no dof of its own: Lagrange multipliers, constraints."""

from __future__ import annotations

from collections.abc import Callable
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
    multipliers,
    solved,
    without,
)  # fmt: skip
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

    def each(self, n: int, change: Callable[[Entries], Entries]) -> Matrices:
        """All of them changed, of ``n`` dofs then."""
        terms = (tuple(map(change, each)) for each in (self.stiffness_terms, self.mass_terms))
        return Matrices(n, change(self.stiffness), change(self.mass), *terms)


class Independent(NamedTuple):
    """Matrices without rows that hold nothing, what was taken out, and the row of each dof (n,) or -1."""

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
            t = Dependent.of(gone).transformation(n)
            left = left.each(n, lambda entries: congruent(n, entries, t))
            taken |= gone
    if not taken:
        return Independent(left, None, None)
    dependent = Dependent.of(taken)
    rows = dependent.rows(n)
    return Independent(left.each(int(rows.max()) + 1, lambda own: without(own, rows)), dependent, rows)


def _without_multipliers(given: Matrices, taken: dict[int, TakenOut]) -> tuple[Matrices, list[Equation]]:
    """The matrices without the rows of Lagrange multipliers, and the equations that these are."""
    k = given.stiffness
    multiplier = multipliers(given.n, k, given.mass)
    if not multiplier.any():
        return given, []
    for name, terms in (("stiffness_terms", given.stiffness_terms), ("mass_terms", given.mass_terms)):
        for i, term in enumerate(terms):
            touched = term.rows[multiplier[term.rows]]
            if touched.size:
                got = f"an entry in row {int(touched[0])}, which is a Lagrange multiplier"
                wanted = "terms of the structure: an equation has no stiffness that a parameter could scale"
                reject(part(name, i), got, wanted, "Leave the rows of the equations out of the term.")
    equations: dict[int, Equation] = {int(row): {} for row in np.flatnonzero(multiplier)}
    of_rows = k.those(multiplier[k.rows])
    for row, column, value in zip(*(each.tolist() for each in of_rows), strict=True):
        equations[row][column] = value
    taken |= {row: TakenOut(MULTIPLIER, {}) for row in equations}
    left = k.those(~(multiplier[k.rows] | multiplier[k.columns]))
    return given._replace(stiffness=left), list(equations.values())
