"""A chain of masses and springs."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.checks import finite_scalar, real_array
from .matrices import Columns
from .penalties import lost_beside, warn_penalties, warn_softly_held
from .recipes import ChainRecipe
from .structural_model import ModelDescription, StructuralModel


class MassSpringChain(StructuralModel):
    """Masses in a row, joined by springs, optionally with a spring to ground at either end.

    Parameters
    ----------
    masses_kg : array_like, (n,)
        Positive masses.
    springs_n_per_m : array_like, (n - 1,)
        Positive stiffnesses of the springs between neighbours.
    ground_first_n_per_m, ground_last_n_per_m : float
        Springs from the first and the last mass to ground; 0 leaves that end free.

    Notes
    -----
    Elements 0 to n - 2 are the springs between the masses; the ground springs are elements n - 1 and n.
    Matrices are dense ``ndarray``. The eight-mass chain of Meruane, J. Sound Vib. 332 (2013) 807-820, is
    :func:`antires_rs.cases.chain8`.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.MassSpringChain([1.0, 2.0], [500.0]).stiffness()
    array([[ 500., -500.],
           [-500.,  500.]])
    """

    _recipe_type = ChainRecipe
    _recipe: ChainRecipe

    def __init__(
        self,
        masses_kg: Any,
        springs_n_per_m: Any,
        *,
        ground_first_n_per_m: float = 0.0,
        ground_last_n_per_m: float = 0.0,
    ) -> None:
        masses = real_array("masses_kg", masses_kg, ndim=1, wanted="an array (n,) of masses in kg")
        springs = np.zeros(0)
        if np.size(springs_n_per_m) > 0:
            wanted = "an array (n - 1,) of stiffnesses in N/m"
            springs = real_array("springs_n_per_m", springs_n_per_m, ndim=1, wanted=wanted)
        first = finite_scalar("ground_first_n_per_m", ground_first_n_per_m)
        last = finite_scalar("ground_last_n_per_m", ground_last_n_per_m)
        self._build(ModelDescription(ChainRecipe(masses, springs, first, last)))
        lost = lost_beside(first + last, springs)
        if lost is not None:
            warn_softly_held(self.dof_label, range(self.n_dof), lost)
            return
        remedy = "Leave out masses that are held, and join masses that move as one."
        warn_penalties(self.dof_label, self.stiffness(), remedy)

    def element_label(self, element: int) -> str:
        """``spring 0`` to ``spring n-2`` between the masses, then the two ground springs."""
        to_ground = {self.n_dof - 1: "first ground spring", self.n_dof: "last ground spring"}
        return to_ground.get(element, f"spring {element}")

    def dof_label(self, dof: int) -> str:
        """``mass 0`` for dof 0 and on, counted from 0 like the springs."""
        return self.mass_label(dof)

    @property
    def default_elements(self) -> list[int]:
        """The springs between the masses; ground springs only on request."""
        return list(range(self.n_dof - 1))

    @property
    def _springs(self) -> list[int]:
        """Without those to ground that are not there: a free end is a spring of zero."""
        ends = self._recipe.ground_first_n_per_m, self._recipe.ground_last_n_per_m
        to_ground = enumerate(ends, start=self.n_dof - 1)
        return self.default_elements + [term for term, stiffness in to_ground if stiffness != 0.0]

    def _matrix(self, columns: Columns) -> Any:
        starts, rows, values = columns
        dense = np.zeros((self.n_dof, self.n_dof))
        dense[rows, np.repeat(np.arange(self.n_dof), np.diff(starts))] = values
        return dense

    def __repr__(self) -> str:
        return f"MassSpringChain({self.n_dof} masses)"
