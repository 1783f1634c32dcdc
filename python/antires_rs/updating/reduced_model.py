"""A problem on few dofs: the same parameters, targets and objective, the matrices projected on a basis.

A change of coordinates makes the measured dofs and those of the forces dofs of the reduced model, so that all
that asks for dofs works on it unchanged.
"""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import NumericalError
from ..models.description import ModelDescription
from ..models.matrix_model import MatrixModel
from ..models.recipes import Entries, MatrixRecipe
from .affine import AffineParts, projected
from .aligned_descent import aligned_descent
from .antiresonance_targets import AntiresonanceTargets
from .reduced_basis import Basis
from .reduced_error import estimated_error

if TYPE_CHECKING:
    from .. import _core
    from ..models.parameter import Parameter
    from ..support.validation import FloatArray
    from .problem import UpdatingProblem

__all__ = ["ReducedProblem", "measured_dofs", "reduced_problem"]


#: Measured dofs whose least motion apart is below this part of the largest move as one.
_INDEPENDENT = 1e-6
#: Most starts of a descent, and the mean residual from which on no other is tried.
_STARTS, _EXPLAINED = 8, 0.01


class ReducedProblem:
    """The objective on a basis, and an estimate of its error."""

    def __init__(
        self, problem: UpdatingProblem, parameters: tuple[Parameter, ...], projected: _Projected, basis: Basis
    ) -> None:
        self._problem, self._projected, self._basis = problem, projected, basis
        self.parameters = parameters
        self.model = projected.model()
        self.core = self._objective(self.model)

    def _objective(self, model: MatrixModel) -> _core.Objective:
        problem = self._problem
        targets: Any = copy.copy(problem._targets)
        place = {dof: number for number, dof in enumerate(self._projected.dofs)}
        targets.parts = [(place[dof], place[force], *rest) for dof, force, *rest in targets.parts]
        penalty = problem.penalty
        objective: _core.Objective = targets.core(
            model._core,
            model.description.core_parameters(self.parameters),
            problem.misfit,
            (penalty.gamma1, penalty.gamma2) if penalty else None,
            penalty.snap if penalty else 0.0,
            problem.weights,
        )
        return objective

    def approached(self, x: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Where a descent on aligned values leads from ``x``; if that explains little, from other points."""
        problem = self._problem
        parts: Any = problem._targets.parts  # type: ignore[attr-defined]
        values = [(nth, freq) for nth, (_, _, freq, *_) in enumerate(parts) if freq.size]
        low, high = problem.bounds.T
        best, least = x, np.inf
        for _ in range(_STARTS):
            found = aligned_descent(self.core, values, x, problem.bounds)
            pairs = self.core.pairs(found)[0]
            apart = np.abs(np.where(np.isnan(pairs), 0.0, pairs / problem.measured_hz) ** 2 - 1.0)
            if apart.mean() < least:
                best, least = found, float(apart.mean())
            if least <= _EXPLAINED:
                break
            x = rng.uniform(low, high)
        return best

    def estimate(self, x: FloatArray) -> float:
        """Error to be expected of the paired frequencies at ``x``, relative, the largest."""
        return estimated_error(self._problem, self._basis, x, self.core.pairs(x)[0])


def largest_difference(one: FloatArray, other: FloatArray) -> float:
    """Largest relative difference of paired frequencies; infinity where only one has a partner."""
    alone = np.isnan(one) != np.isnan(other)
    if alone.any():
        return float("inf")
    return float(np.nanmax(np.abs(one / other - 1.0), initial=0.0))


def measured_dofs(targets: AntiresonanceTargets) -> list[int]:
    """Dofs of responses and forces, ascending."""
    return sorted({int(dof) for part in targets.parts for dof in part[:2]})


def reduced_problem(problem: UpdatingProblem, parts: AffineParts, basis: Basis) -> ReducedProblem:
    """The problem projected on a basis."""
    targets: Any = problem._targets
    small = _Projected(parts, basis.vectors, measured_dofs(targets))
    parameters = tuple(
        replace(p, terms=(number,)) for p, number in zip(problem.parameters, small.numbers, strict=True)
    )
    return ReducedProblem(problem, parameters, small, basis)


class _Projected:
    """Matrices on the basis, and the model that they are."""

    def __init__(self, parts: AffineParts, vectors: FloatArray, dofs: list[int]) -> None:
        self.dofs, self._rows = dofs, vectors[dofs]
        self._nominal = projected(parts.stiffness, vectors), projected(parts.mass, vectors)
        self._terms: tuple[list[FloatArray], list[FloatArray]] = ([], [])
        #: Number of each parameter's term among those of its matrix.
        self.numbers = []
        for k, m in parts.terms:
            side = self._terms[0 if k is not None else 1]
            self.numbers.append(len(side))
            side.append(projected(k if k is not None else m, vectors))

    def model(self) -> MatrixModel:
        """The model, measured dofs first."""
        change = _coordinates(self._rows)

        def entries(matrix: FloatArray) -> Entries:
            moved = change.T @ matrix @ change
            return Entries.of(0.5 * (moved + moved.T))

        stiffness, mass = self._terms
        recipe = MatrixRecipe(
            self._rows.shape[1],
            entries(self._nominal[0]),
            entries(self._nominal[1]),
            tuple(map(entries, stiffness)),
            tuple(map(entries, mass)),
        )
        # Not by its constructor, which would look for penalties of dofs that the user does not know.
        return MatrixModel.from_description(ModelDescription(recipe))


def _coordinates(rows: FloatArray) -> FloatArray:
    """T with ``rows @ T = [1 0]``: measured dofs first, then what moves none of them, orthonormal."""
    _, sizes, directions = np.linalg.svd(rows, full_matrices=True)
    if rows.shape[1] < rows.shape[0] or sizes[-1] < _INDEPENDENT * sizes[0]:
        raise NumericalError(
            "measured dofs as coordinates of a reduced model",
            "some of them move as one, or the basis has fewer vectors than there are. Use reduction=False.",
        )
    return np.hstack([np.linalg.pinv(rows), directions[sizes.size :].T])
