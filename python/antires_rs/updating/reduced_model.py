"""A problem on few dofs: the same parameters, targets and objective, the matrices projected on a basis.

A change of coordinates makes the measured dofs and those of the forces dofs of the reduced model, so that all
that asks for dofs works on it unchanged.
"""

from __future__ import annotations

from copy import copy
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
#: Most starts of a descent.
_STARTS = 8
#: A descent is judged by the residual that this share of the values do not exceed, and explains them up to so
#: much.
_SHARE, _EXPLAINED = 0.8, 1e-3
#: Two descents ended at one place within this part of the box.
_SAME = 0.02
#: A ratio of full to reduced frequency further from one than this is that of another root.
_FARTHEST = 0.05


class ReducedProblem:
    """The objective on a basis, and an estimate of its error.

    ``ratio`` (m,) multiplies its paired frequencies, once it is :meth:`corrected`.
    """

    def __init__(self, affine: Affine, basis: Basis) -> None:
        self._affine, self._basis = affine, basis
        rows = sorted({*affine.sensors, *affine.forces})
        place = {row: number for number, row in enumerate(rows)}
        self.size = basis.vectors.shape[1]
        self._parts = [(place[part[0]], place[part[1]], *part[2:]) for part in affine.parts]
        self._model = _projected(affine, basis.vectors, rows)
        self.ratio = np.ones(affine.problem.measured_hz.size)
        self.is_corrected = False
        self._plain = self.core = self._objective()

    def corrected(self, x: FloatArray, full_hz: FloatArray) -> ReducedProblem:
        """The same, its paired frequencies times what makes them those of the full model at ``x``."""
        new = copy(self)
        ratio = full_hz / self._plain.pairs(x)[0]
        new.ratio = np.where(np.abs(ratio - 1.0) < _FARTHEST, ratio, 1.0)
        new.core, new.is_corrected = new._objective(), True
        return new

    def paired_hz(self, x: FloatArray) -> FloatArray:
        """Frequency paired with each measured one, (m,) Hz; NaN without one."""
        return np.asarray(self.core.pairs(x)[0] * self.ratio)

    def approached(self, x: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Where a descent on aligned values leads from ``x``; if that explains little, from other points.

        Until one explains the values, or two have ended at the best place.
        """
        problem = self._affine.problem
        values = [(nth, freq) for nth, (_, _, freq, *_) in enumerate(self._parts) if freq.size]
        low, high = problem.bounds.T
        best, least = x, np.inf
        for _ in range(_STARTS):
            found = aligned_descent(self.core, values, x, problem.bounds)
            pairs = self.core.pairs(found)[0]
            apart = np.abs(np.where(np.isnan(pairs), 0.0, pairs / problem.measured_hz) ** 2 - 1.0)
            size = float(np.quantile(apart, _SHARE))
            again = bool(np.all(np.abs(found - best) <= _SAME * (high - low))) and np.isfinite(least)
            if size < least:
                best, least = found, size
            if again or least <= _EXPLAINED:
                break
            x = rng.uniform(low, high)
        return best

    def _objective(self) -> _core.Objective:
        problem, penalty = self._affine.problem, self._affine.problem.penalty
        counts = np.cumsum([part[2].size for part in self._parts])[:-1]
        ratios = np.split(self.ratio, counts)
        parts = [(*part[:2], part[2] / r, *part[3:]) for part, r in zip(self._parts, ratios, strict=True)]
        return _core.Objective.antiresonance(
            *self._model,
            parts,
            problem.misfit,
            (penalty.gamma1, penalty.gamma2) if penalty else None,
            penalty.snap if penalty else 0.0,
            problem.weights,
        )

    def estimate(self, x: FloatArray) -> float:
        """Error to be expected of the paired frequencies at ``x``, relative, the largest."""
        return estimated_error(self._affine, self._basis, x, self._plain.pairs(x)[0])


def largest_difference(one: FloatArray, other: FloatArray) -> float:
    """Largest relative difference of paired frequencies; infinity where only one has a partner."""
    alone = np.isnan(one) != np.isnan(other)
    if alone.any():
        return float("inf")
    return float(np.nanmax(np.abs(one / other - 1.0), initial=0.0))


def _projected(affine: Affine, vectors: FloatArray, rows: list[int]) -> tuple[_core.Model, list[Any]]:
    """The model on the basis, measured dofs first, and its parameters: each has a term of its own."""
    change = coordinates(vectors[rows])

    turned = vectors @ change

    def entries(of: FloatArray, product: Any) -> Entries:
        small = of.T @ np.asarray(product)
        return Entries.of(0.5 * (small + small.T))

    sides: tuple[list[Entries], list[Entries]] = ([], [])
    parameters = []
    for nth, (parameter, places) in enumerate(zip(affine.problem.parameters, affine.places, strict=True)):
        side = sides[0 if affine.terms[nth][0] is not None else 1]
        parameters.append((parameter.quantity, [len(side)], False, None))
        side.append(entries(turned[places], affine.times(nth, turned)))
    stiffness, mass = (entries(turned, matrix @ turned) for matrix in (affine.stiffness, affine.mass))
    return _core.Model.from_matrices(change.shape[1], stiffness, mass, *sides), parameters


def coordinates(rows: FloatArray) -> FloatArray:
    """T with ``rows @ T = [1 0]``: measured dofs first, then what moves none of them, orthonormal."""
    _, sizes, directions = np.linalg.svd(rows, full_matrices=True)
    if rows.shape[1] < rows.shape[0] or sizes[-1] < _INDEPENDENT * sizes[0]:
        raise NumericalError(
            "measured dofs as coordinates of a reduced model",
            "some of them move as one, or the basis has fewer vectors than there are. Use reduction=False.",
        )
    return np.hstack([np.linalg.pinv(rows), directions[sizes.size :].T])
