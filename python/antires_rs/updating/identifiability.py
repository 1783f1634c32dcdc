"""What the data can tell about the parameters at the solution, and what they cannot.

Two questions. Which directions of the parameter space leave every measured antiresonance, or mode, where it
is (the null space of the residuals' Jacobian: the common scale of K and M, a mass that no
antiresonance sees)? And how small may a damage be before the penalties outweigh what it explains?
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..support.checks import FloatArray
from ..support.values import Value
from .residuals import STEP_OF_SLOPES, UNSEEN, decided
from .targets import STEP

if TYPE_CHECKING:
    from .problem import UpdatingProblem

#: A value whose standard deviation exceeds this share of the bounds' distance is hardly determined.
_WEAK = 0.1
#: A parameter takes part in an unseen direction from this share of it on.
_SHARE = 0.15


@dataclass(frozen=True, eq=False)
class Identifiability(Value):
    """Rank and null space of the residuals' Jacobian at a solution, scaled by the bounds."""

    names: tuple[str, ...]
    sensitivity: FloatArray  # change of the residuals over the range of each parameter, (n,)
    rank: int  # combinations of parameters that the data determine
    unseen: FloatArray  # orthonormal combinations that they do not, (n - rank, n)
    scale_unseen: bool  # whether a common scale is one of these
    #: Of each value to first order, by the scatter of the residuals, (n,); infinity where not determined, NaN
    #: where it cannot be said: a damage that rests at 0, or no more residuals than parameters.
    std: FloatArray
    weak: NDArray[np.bool_]  # whether it is above a tenth of the bounds' distance
    noun: str = "antiresonance"

    @property
    def notes(self) -> list[str]:
        """Sentences for the reader; none when every parameter is determined."""
        notes = []
        if np.any(self.blind):
            names = self._named(self.blind)
            notes.append(f"Not seen by any measured {self.noun}: {names}. The value found is arbitrary.")
        mixed = len(self.names) - self.rank - int(self.blind.sum())
        if mixed > 0:
            part = (np.sqrt(np.sum(self.unseen**2, axis=0)) > _SHARE) & ~self.blind
            everyone = bool(np.all(part | self.blind))
            names = "all parameters that are seen" if everyone else self._named(part)
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
            names = self._named(self.weak, [f" (\u00b1 {std:.2g})" for std in self.std])
            notes.append(
                f"Hardly determined, by the scatter of the residuals: {names}. What fits as well "
                "lies within these standard deviations."
            )
        return notes

    def _named(self, which: NDArray[np.bool_], endings: Iterable[str] | None = None) -> str:
        labels = zip(self.names, endings or [""] * len(self.names), which, strict=True)
        return ", ".join(name + ending for name, ending, chosen in labels if chosen)

    @property
    def blind(self) -> NDArray[np.bool_]:
        """Whether nothing measured sees the parameter, (n,)."""
        return self.sensitivity <= UNSEEN


def identifiability(problem: UpdatingProblem, x: FloatArray) -> Identifiability:
    """Rank and null space at ``x``, from central differences of the residuals."""
    low, high = problem.bounds.T
    width = np.where(high > low, high - low, 1.0)
    columns = []
    for j in range(len(x)):
        step = np.zeros(len(x))
        step[j] = STEP_OF_SLOPES * width[j]
        # Straight from the core: a step below the snap threshold must not be snapped away.
        change = problem._targets.change(problem._core, x - step, x + step) / (2.0 * STEP_OF_SLOPES)
        columns.append(np.where(np.isfinite(change), change, 0.0))
    jacobian = np.stack(columns, axis=1)
    _, singular, rows = np.linalg.svd(jacobian, full_matrices=True)
    rank = int(np.count_nonzero(singular > UNSEEN))
    # All stiffness and mass up by the same fraction.
    scale = np.array([p.common_scale(value) for p, value in zip(problem.parameters, x, strict=True)]) / width
    length = np.linalg.norm(scale)
    scale_unseen = bool(length > 0 and np.linalg.norm(jacobian @ scale) <= UNSEEN * length)
    std = _standard_deviations(problem, x, jacobian) * width
    sensitivity = np.linalg.norm(jacobian, axis=0)
    weak = np.isfinite(std) & (std > _WEAK * width) & (sensitivity > UNSEEN)
    return Identifiability(
        tuple(problem.names), sensitivity, rank, rows[rank:], scale_unseen, std, weak, problem.noun
    )


def _standard_deviations(problem: UpdatingProblem, x: FloatArray, jacobian: FloatArray) -> FloatArray:
    """Standard deviations over the bounds' distances, (n,): sigma times the rows of the pseudo-inverse."""
    std = np.full(len(x), np.nan)
    free = np.flatnonzero(~decided(problem, x) & (problem.bounds[:, 1] > problem.bounds[:, 0]))
    if free.size == 0:
        return std
    _, singular, rows = np.linalg.svd(jacobian[:, free], full_matrices=True)
    seen = np.append(singular, np.zeros(len(rows) - len(singular))) > UNSEEN
    residuals = problem.residuals(x)[: len(problem.measured_hz)]
    spare = residuals.size - int(seen.sum())
    if spare > 0:
        sigma = np.sqrt(np.sum(residuals**2) / spare)
        std[free] = sigma * np.sqrt(np.sum((rows[seen] / singular[seen[: len(singular)], None]) ** 2, axis=0))
    std[free[np.any(np.abs(rows[~seen]) > _SHARE, axis=0)]] = np.inf
    return std


def smallest_visible(problem: UpdatingProblem) -> list[float]:
    """Smallest value of each stiffness reduction that the objective prefers to no damage, on exact data."""
    loss, element = problem.penalty.prices if problem.penalty else (0.0, 0.0)
    moved = [problem.model_at(STEP * unit) for unit in np.eye(len(problem.parameters))]
    exact = problem._targets.exact(problem.model, problem.paired_hz(problem.nominal), moved)

    def gain(index: int, beta: float) -> float:
        """What the damage explains, less what it costs."""
        x = np.zeros(len(problem.parameters))
        x[index] = beta
        measured = exact(problem.model_at(x))
        if measured is None:
            return -1.0
        sets, weights = measured
        plain = type(problem)(problem.model, problem.parameters, sets, misfit=problem.misfit, weights=weights)
        return plain.cost(np.zeros_like(x)) - (loss * beta + element)

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
