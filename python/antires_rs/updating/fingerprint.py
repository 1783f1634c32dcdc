"""What tells one search from any other."""

from __future__ import annotations

from dataclasses import astuple
from typing import TYPE_CHECKING, Any

from .._core import __version__
from ..optimize.checkpoint import digest_of

if TYPE_CHECKING:
    from ..updating.problem import UpdatingProblem

__all__ = ["fingerprint"]


def fingerprint(problem: UpdatingProblem, options: dict[str, Any], guesses: list[list[float]]) -> bytes:
    """32 bytes that tell this search from any other: model, parameters, data, objective and options."""
    # Inside the bounds every parameter, and all that it acts on, shows in the matrices; what else was
    # measured and how it is weighed shows in the residuals and the cost.
    low, high = problem.bounds.T
    points = (problem.nominal, low + 0.37 * (high - low))
    matrices = (
        array.tobytes()
        for model in (problem.model, problem.model_at(points[1]))
        for matrix in (model._core.stiffness(), model._core.mass())
        for array in matrix
    )
    return digest_of(
        *matrices,
        __version__,
        problem.objective,
        problem.bounds.tobytes(),
        [astuple(p) for p in problem.parameters],
        problem.measured_hz.tobytes(),
        problem.misfit,
        problem.penalty,
        sorted(options.items()),
        guesses,
        *(problem.residuals(x).tobytes() for x in points),
        *(problem.cost(x).hex() for x in points),
    )
