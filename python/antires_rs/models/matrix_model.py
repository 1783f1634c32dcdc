"""Models from stiffness and mass matrices of any finite-element program."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..support.validation import part
from .description import ModelDescription
from .matrices import as_sparse, as_square, as_term
from .penalties import warn_penalties
from .recipes import MatrixRecipe
from .structural_model import StructuralModel

__all__ = ["MatrixModel"]


class MatrixModel(StructuralModel):
    """Stiffness and mass from any finite-element code, with the terms that parameters may scale.

    Parameters
    ----------
    stiffness, mass : array_like or scipy.sparse, (n, n)
        Symmetric nominal matrices; the mass may be singular (massless dofs). Sparse ones stay sparse: memory
        and time go with their entries.
    stiffness_terms, mass_terms : sequence of array_like or scipy.sparse, (n, n)
        Contribution of each element (or group) to the matrix. A parameter with factor s turns K into
        ``K + (s - 1) K_i``; the terms need not add up to K.

    Raises
    ------
    InvalidInputError
        A matrix that is not square, symmetric and finite, of another size, or a negative mass.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> spring = 500.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    >>> model = ar.MatrixModel(spring, np.eye(2), stiffness_terms=[spring])
    >>> model.antiresonances(0, 0).round(3)
    array([3.559])
    """

    _recipe_type = MatrixRecipe

    def __init__(
        self,
        stiffness: Any,
        mass: Any,
        *,
        stiffness_terms: Iterable[Any] = (),
        mass_terms: Iterable[Any] = (),
    ) -> None:
        n, k = as_square("stiffness", stiffness)
        recipe = MatrixRecipe(
            n,
            k,
            as_square("mass", mass, n)[1],
            tuple(as_term(part("stiffness_terms", i), t, n) for i, t in enumerate(stiffness_terms)),
            tuple(as_term(part("mass_terms", i), t, n) for i, t in enumerate(mass_terms)),
        )
        self._build(ModelDescription(recipe))
        warn_penalties(
            self,
            self.stiffness(),
            "Take ties and supports out with eliminate_constraints, or use penalties a million times softer.",
            stacklevel=2,
        )

    def stiffness(self) -> Any:
        """Stiffness matrix as ``scipy.sparse.csc_array``, (n, n), N/m."""
        return as_sparse(self._core.stiffness())

    def mass(self) -> Any:
        """Mass matrix as ``scipy.sparse.csc_array``, (n, n), kg."""
        return as_sparse(self._core.mass())

    def __repr__(self) -> str:
        return (
            f"MatrixModel({self.n_dof} dofs, {self._core.n_stiffness_terms} stiffness terms, "
            f"{self._core.n_mass_terms} mass terms)"
        )
