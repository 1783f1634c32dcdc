"""What the data can tell about the parameters, and what they cannot.

Two questions. Which directions of the parameter space leave every measured antiresonance, or mode, where it
is (the null space of the residuals' Jacobian: the common scale of K and M, a mass that no
antiresonance sees)? And how small may a damage be before the penalties outweigh what it explains?
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from ..support.values import Value
from .steady_roots import STEP

if TYPE_CHECKING:
    from .problem import UpdatingProblem

__all__ = ["Identifiability", "identifiability", "smallest_visible"]

#: Step of the central differences, relative to the range of a parameter: the residuals carry
#: rounding of about 1e-13, so this leaves some 1e-8 of error.
_STEP = 1e-5
#: A direction whose residuals move less than this per unit of bound range is not seen.
_UNSEEN = 1e-5
#: A value whose standard deviation exceeds this share of the bounds' distance is hardly determined.
_WEAK = 0.1
#: A parameter takes part in an unseen direction from this share of it on.
_SHARE = 0.15


@dataclass(frozen=True, eq=False)
class Identifiability(Value):
    """Rank and null space of the residuals' Jacobian at a solution, scaled by the bounds.

    Attributes
    ----------
    names : tuple of str
        Parameters.
    sensitivity : ndarray, (n,)
        Norm of each parameter's column: change of the residuals over its bound range.
    rank : int
        Number of parameter combinations that the data determine.
    unseen : ndarray, (n - rank, n)
        Orthonormal combinations that they do not.
    scale_unseen : bool
        Whether scaling all parameters together is one of these.
    weak : ndarray of bool, (n,)
        Seen, but with a standard deviation above a tenth of the bounds' distance.
    std : ndarray, (n,)
        Standard deviation of each value to first order, from the scatter of the residuals, in the parameter's
        unit; infinity where it is not determined, NaN where it cannot be said: a damage that rests at 0, or
        no more residuals than parameters. Errors of the model count as far as they show in the residuals.
    noun : str
        What was measured.
    """

    names: tuple[str, ...]
    sensitivity: FloatArray
    rank: int
    unseen: FloatArray
    scale_unseen: bool
    std: FloatArray
    weak: NDArray[np.bool_]
    noun: str = "antiresonance"

    @property
    def notes(self) -> list[str]:
        """Sentences for the reader; none when every parameter is determined."""
        notes = []
        if np.any(self.blind):
            names = ", ".join(name for name, b in zip(self.names, self.blind, strict=True) if b)
            notes.append(f"Not seen by any measured {self.noun}: {names}. The value found is arbitrary.")
        mixed = len(self.names) - self.rank - int(self.blind.sum())
        if mixed > 0:
            share = np.sqrt(np.sum(self.unseen**2, axis=0))
            taking_part = (share > _SHARE) & ~self.blind
            everyone = bool(np.all(taking_part | self.blind))
            names = (
                "all parameters that are seen"
                if everyone
                else ", ".join(name for name, t in zip(self.names, taking_part, strict=True) if t)
            )
            combinations = "One combination" if mixed == 1 else f"{mixed} combinations"
            why = f"no measured {self.noun} moves with them"
            if self.scale_unseen and mixed == 1:
                why = f"a common scale moves no {self.noun}, only ratios are known"
            elif self.scale_unseen:
                why += ", a common scale among them"
            notes.append(
                f"{combinations} of {names} cannot be told: {why} "
                f"({self.rank} of {len(self.names)} combinations are)."
            )
        if np.any(self.weak):
            names = ", ".join(
                f"{name} (\u00b1 {std:.2g})"
                for name, std, weak in zip(self.names, self.std, self.weak, strict=True)
                if weak
            )
            notes.append(
                f"Hardly determined, by the scatter of the residuals: {names}. What fits as well "
                "lies within these standard deviations."
            )
        return notes

    @property
    def blind(self) -> NDArray[np.bool_]:
        """Whether nothing measured sees the parameter, (n,)."""
        return self.sensitivity <= _UNSEEN


def identifiability(problem: UpdatingProblem, x: FloatArray) -> Identifiability:
    """Rank and null space at ``x``, from central differences of the residuals."""
    low, high = problem.bounds.T
    width = np.where(high > low, high - low, 1.0)
    columns = []
    for j in range(len(x)):
        step = np.zeros(len(x))
        step[j] = _STEP * width[j]
        # Straight from the core: a step below the snap threshold must not be snapped away.
        change = problem._targets.change(problem._core, x - step, x + step) / (2.0 * _STEP)
        columns.append(np.where(np.isfinite(change), change, 0.0))
    jacobian = np.stack(columns, axis=1)
    _, singular, rows = np.linalg.svd(jacobian, full_matrices=True)
    rank = int(np.count_nonzero(singular > _UNSEEN))
    # All stiffness and mass up by the same fraction.
    scale = np.array([p.common_scale(value) for p, value in zip(problem.parameters, x, strict=True)]) / width
    length = np.linalg.norm(scale)
    scale_unseen = bool(length > 0 and np.linalg.norm(jacobian @ scale) <= _UNSEEN * length)
    std = _standard_deviations(problem, x, jacobian) * width
    sensitivity = np.linalg.norm(jacobian, axis=0)
    weak = np.isfinite(std) & (std > _WEAK * width) & (sensitivity > _UNSEEN)
    return Identifiability(
        tuple(problem.names), sensitivity, rank, rows[rank:], scale_unseen, std, weak, problem.noun
    )


def _standard_deviations(problem: UpdatingProblem, x: FloatArray, jacobian: FloatArray) -> FloatArray:
    """Standard deviations over the bounds' distances, (n,): sigma times the rows of the pseudo-inverse.

    ``sigma**2 = sum(e**2) / (m - rank)``. A damage at exactly 0 is decided, not estimated.
    """
    resting = np.array(
        [
            p.quantity == "stiffness_reduction" and value == 0.0 and problem.penalty is not None
            for p, value in zip(problem.parameters, x, strict=True)
        ]
    )
    std = np.full(len(x), np.nan)
    free = np.flatnonzero(~resting & (problem.bounds[:, 1] > problem.bounds[:, 0]))
    if free.size == 0:
        return std
    _, singular, rows = np.linalg.svd(jacobian[:, free], full_matrices=True)
    seen = np.append(singular, np.zeros(len(rows) - len(singular))) > _UNSEEN
    residuals = problem.residuals(x)[: len(problem.measured_hz)]
    spare = residuals.size - int(seen.sum())
    if spare > 0:
        sigma = np.sqrt(np.sum(residuals**2) / spare)
        std[free] = sigma * np.sqrt(np.sum((rows[seen] / singular[seen[: len(singular)], None]) ** 2, axis=0))
    std[free[np.any(np.abs(rows[~seen]) > _SHARE, axis=0)]] = np.inf
    return std


def smallest_visible(problem: UpdatingProblem) -> list[float]:
    """Smallest value of each stiffness reduction that the objective prefers to no damage.

    The structure is taken to be the nominal model with that one reduction, measured exactly at the
    same dofs and in the same band; how far each antiresonance counts is told by
    ``updating.steady_roots``. Infinity where no value up to the bound is preferred.
    """
    penalty = problem.penalty
    nominal_hz = problem.paired_hz(problem.nominal)
    moved = [problem.model_at(STEP * unit) for unit in np.eye(len(problem.parameters))]

    def gain(index: int, beta: float) -> float:
        """What the damage explains, less what it costs."""
        x = np.zeros(len(problem.parameters))
        x[index] = beta
        damaged = problem.model_at(x)
        exact = problem._targets.exact(damaged, problem.model, nominal_hz, moved)
        if exact is None:
            return -1.0
        sets, weights = exact
        plain = type(problem)(problem.model, problem.parameters, sets, misfit=problem.misfit, weights=weights)
        undamaged = plain.cost(np.zeros_like(x))
        return undamaged - (penalty.gamma1 * beta + penalty.gamma2 if penalty else 0.0)

    visible = []
    for index, (_, high) in enumerate(problem.bounds):
        grid = np.linspace(0.01, high, 40)
        first = next((i for i, beta in enumerate(grid) if gain(index, beta) > 0), None)
        if first is None:
            visible.append(float("inf"))
            continue
        low, top = (grid[first - 1] if first else 0.0), grid[first]
        while top - low > 1e-3:
            middle = 0.5 * (low + top)
            low, top = (low, middle) if gain(index, middle) > 0 else (middle, top)
        visible.append(float(top))
    return visible
