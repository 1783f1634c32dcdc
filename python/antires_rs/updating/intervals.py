"""Intervals of parameters from draws of their posterior: within the bounds, with the error of the model."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..optimize.arguments import seed_of, thread_count
from ..support.one_thread import one_blas_thread
from ..support.progress import patient, step
from ..support.validation import FloatArray, choice, finite_scalar, integer
from .ensemble import ensemble_draws
from .error_rows import error_rows
from .fit import FAR, SAME, Fit, fitted
from .parameter_intervals import Method, ParameterIntervals
from .posterior import linear_draws
from .sides import open_sides, words_of

if TYPE_CHECKING:
    from .problem import UpdatingProblem

__all__ = ["intervals"]

#: Residuals beyond this many standard deviations are named.
_ODD = 4.0


@patient("intervals")
@one_blas_thread
def intervals(
    problem: UpdatingProblem,
    x: FloatArray,
    *,
    method: Method = "laplace",
    level: float = 0.9,
    draws: int = 1000,
    rng: int | np.random.Generator | None = 0,
    workers: int | None = None,
    progress: bool | None = None,
) -> ParameterIntervals:
    """Intervals around the least-squares solution near ``x``; see ``UpdateResult.intervals``."""
    choice("method", method, ("laplace", "ensemble"))
    finite_scalar("level", level, low=0.5, high=0.999)
    integer("draws", draws, low=50, high=1_000_000)
    generator = np.random.default_rng(seed_of(rng))
    threads = thread_count(workers)
    fit = fitted(problem, x)
    notes = [*fit.residuals.assumed, *_doubts(fit, x)]
    if method == "laplace":
        u, which = linear_draws(fit, draws, generator)
    else:
        found = ensemble_draws(fit, draws, generator, threads)
        u, which = found.u, found.which
        if found.accepted < 0.1:
            notes.append(
                f"Hardly a move of the ensemble was accepted ({100 * found.accepted:.0f} %): take more draws."
            )
    step("sides that the data leave open")
    sides = open_sides(fit, level, refit=method == "ensemble")
    return _told(fit, method, level, fit.residuals.vector(u), fit.errors.tau[which], sides, notes)


def _told(
    fit: Fit,
    method: Method,
    level: float,
    x: FloatArray,
    tau: FloatArray,
    sides: list[tuple[bool, bool, bool]],
    notes: list[str],
) -> ParameterIntervals:
    problem, rest = fit.residuals.problem, 1.0 - level
    low, high = np.quantile(x, [rest / 2.0, 1.0 - rest / 2.0], axis=0)
    words = ["fixed"] * len(problem.names)
    for j, (below, above, by_others) in zip(fit.residuals.free, sides, strict=True):
        words[j] = words_of(below, above, by_others)
        if below:
            low[j] = problem.bounds[j, 0]
            high[j] = np.quantile(x[:, j], level)
        if above:
            high[j] = problem.bounds[j, 1]
            low[j] = low[j] if below else np.quantile(x[:, j], rest)
    return ParameterIntervals(
        tuple(problem.names),
        method,
        float(level),
        low,
        high,
        np.median(x, axis=0),
        np.std(x, axis=0),
        tuple(words),
        x,
        fit.chi_square,
        float(np.median(tau)),
        tuple(notes),
    )


def _doubts(fit: Fit, x: FloatArray) -> list[str]:
    """What speaks against a Gaussian around the solution found."""
    notes = []
    residuals = fit.residuals
    if not fit.errors.learned:
        notes.append(
            "As many parameters as values: nothing is left over to tell the error of the model from."
        )
    apart = np.abs(fit.jacobian @ (residuals.place(x) - fit.u))
    if np.any(apart > np.maximum(FAR * fit.sigma, SAME)):
        notes.append(
            "Least squares lead far from the solution of the search: some values contradict the others."
        )
    odd = np.abs(fit.e) > _ODD * fit.sigma
    if odd.any():
        value = _values(fit)[odd]
        named = ", ".join(f"{hz:.4g} Hz" for hz in value[:4])
        notes.append(f"Far from the model even so: {named}. Leave them out if they are wrong.")
    return notes


def _values(fit: Fit) -> FloatArray:
    """Measured frequency that each residual belongs to, (m,)."""
    residuals = fit.residuals
    value = error_rows(residuals.problem._targets)[0]
    return np.asarray(residuals.problem.measured_hz[value][residuals.kept])
