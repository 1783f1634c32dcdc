"""A problem on few dofs: the same parameters, targets and objective, the matrices projected on a basis.

A change of coordinates makes the measured dofs and those of the forces dofs of the reduced model, so that all
that asks for dofs works on it unchanged.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from ..exceptions import NumericalError
from ..models.entries import Entries
from .affine import Affine
from .aligned_descent import aligned_descent
from .reduced_basis import Basis
from .reduced_error import estimated_error

if TYPE_CHECKING:
    from ..support.validation import FloatArray

__all__ = ["ReducedProblem", "coordinates", "largest_difference"]

#: Measured dofs whose least motion apart is below this part of the largest move as one.
_INDEPENDENT = 1e-6
#: Most starts of a descent, and the mean residual from which on no other is tried.
_STARTS, _EXPLAINED = 8, 0.01


class ReducedProblem:
    """The objective on a basis, and an estimate of its error."""

    def __init__(self, affine: Affine, basis: Basis) -> None:
        self._affine, self._basis = affine, basis
        rows = sorted({*affine.sensors, *affine.forces})
        place = {row: number for number, row in enumerate(rows)}
        self.size, problem = basis.vectors.shape[1], affine.problem
        self._parts = [(place[part[0]], place[part[1]], *part[2:]) for part in affine.parts]
        model, parameters = _projected(affine, basis.vectors, rows)
        penalty = problem.penalty
        self.core = _core.Objective.antiresonance(
            model,
            parameters,
            self._parts,
            problem.misfit,
            (penalty.gamma1, penalty.gamma2) if penalty else None,
            penalty.snap if penalty else 0.0,
            problem.weights,
        )

    def approached(self, x: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Where a descent on aligned values leads from ``x``; if that explains little, from other points."""
        problem = self._affine.problem
        values = [(nth, freq) for nth, (_, _, freq, *_) in enumerate(self._parts) if freq.size]
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
        return estimated_error(self._affine, self._basis, x, self.core.pairs(x)[0])


def largest_difference(one: FloatArray, other: FloatArray) -> float:
    """Largest relative difference of paired frequencies; infinity where only one has a partner."""
    alone = np.isnan(one) != np.isnan(other)
    if alone.any():
        return float("inf")
    return float(np.nanmax(np.abs(one / other - 1.0), initial=0.0))


def _projected(affine: Affine, vectors: FloatArray, rows: list[int]) -> tuple[_core.Model, list[Any]]:
    """The model on the basis, measured dofs first, and its parameters: each has a term of its own."""
    change = coordinates(vectors[rows])

    def entries(matrix: Any) -> Entries:
        small = change.T @ (vectors.T @ (matrix @ vectors)) @ change
        return Entries.of(0.5 * (small + small.T))

    sides: tuple[list[Entries], list[Entries]] = ([], [])
    parameters = []
    for parameter, (k, m) in zip(affine.problem.parameters, affine.terms, strict=True):
        side = sides[0 if k is not None else 1]
        parameters.append((parameter.quantity, [len(side)], False, None))
        side.append(entries(k if k is not None else m))
    nominal = entries(affine.stiffness), entries(affine.mass)
    return _core.Model.from_matrices(change.shape[1], *nominal, *sides), parameters


def coordinates(rows: FloatArray) -> FloatArray:
    """T with ``rows @ T = [1 0]``: measured dofs first, then what moves none of them, orthonormal."""
    _, sizes, directions = np.linalg.svd(rows, full_matrices=True)
    if rows.shape[1] < rows.shape[0] or sizes[-1] < _INDEPENDENT * sizes[0]:
        raise NumericalError(
            "measured dofs as coordinates of a reduced model",
            "some of them move as one, or the basis has fewer vectors than there are. Use reduction=False.",
        )
    return np.hstack([np.linalg.pinv(rows), directions[sizes.size :].T])
