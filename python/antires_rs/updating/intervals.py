"""Intervals of parameters from draws of their posterior: within the bounds, with the error of the model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from ..optimize.arguments import seed_of, thread_count
from ..support.one_thread import one_blas_thread
from ..support.pickling import FrozenDict
from ..support.progress import patient, step
from ..support.validation import FloatArray, choice, finite_scalar, integer, reject
from ..support.values import Value
from .ensemble import ensemble_draws
from .error_rows import error_rows
from .fit import Fit, fitted
from .posterior import linear_draws
from .profile import open_sides, words_of

if TYPE_CHECKING:
    from .problem import UpdatingProblem

__all__ = ["Method", "ParameterIntervals", "intervals"]

Method = Literal["laplace", "ensemble"]

#: The least-squares solution is another than the one found if a value differs by more than this many standard
#: deviations and by more than this share of omega squared.
_FAR, _SAME = 4.0, 2e-3
#: Residuals beyond this many standard deviations are named.
_ODD = 4.0


@dataclass(frozen=True, eq=False)
class ParameterIntervals(Value):
    """Intervals of updated parameters, from draws of their posterior. ``intervals[name]`` is one of them.

    Attributes
    ----------
    names : tuple of str, (n,)
    method : {'laplace', 'ensemble'}
    level : float
        Probability of each interval.
    low, high : ndarray, (n,)
        Ends of the intervals, in the parameters' units.
    center, std : ndarray, (n,)
        Median and standard deviation of the draws.
    words : tuple of str, (n,)
        "two-sided"; "two-sided, through the bounds of others"; "one-sided: its lower bound fits as well" (or
        upper: the interval then begins at that bound); "flat": any value within the bounds fits, and
        the interval is the bounds; "fixed": not estimated.
    draws : ndarray, (k, n)
        Independent draws (of an ensemble nearly independent), rows in no order.
    chi_square : float
        Reduced chi-square of the residuals by the stated errors alone; NaN where none are stated.
    model_error : float
        Standard deviation of what the model leaves unexplained, relative to omega squared: median of the
        draws. 0 where the stated errors explain the residuals; all of the error where none are stated.
    notes : tuple of str
        What was assumed, and what speaks against it.
    """

    names: tuple[str, ...]
    method: Method
    level: float
    low: FloatArray
    high: FloatArray
    center: FloatArray
    std: FloatArray
    words: tuple[str, ...]
    draws: FloatArray
    chi_square: float
    model_error: float
    notes: tuple[str, ...]

    def __getitem__(self, name: str) -> tuple[float, float]:
        if name not in self.names:
            reject("name", repr(name), "a parameter of the problem", f"One of {', '.join(self.names)}.")
        return self.interval[name]

    @property
    def interval(self) -> dict[str, tuple[float, float]]:
        """``(low, high)`` by name."""
        return FrozenDict(
            zip(self.names, zip(self.low.tolist(), self.high.tolist(), strict=True), strict=True)
        )

    def to_dataframe(self) -> Any:
        """One row a parameter, as a pandas ``DataFrame`` (extra "tables")."""
        import pandas as pd

        columns = ("low", "high", "center", "std", "words")
        table = {name: getattr(self, name) for name in columns}
        return pd.DataFrame(table, index=pd.Index(self.names, name="parameter"))

    def __str__(self) -> str:
        width = max(len(name) for name in self.names)
        lines = [f"intervals at {100 * self.level:g} %, {self.method}, {len(self.draws)} draws"]
        lines += [
            f"{name:<{width}}  {low:#10.5g} to {high:#10.5g}  {words}"
            for name, low, high, words in zip(self.names, self.low, self.high, self.words, strict=True)
        ]
        if np.isfinite(self.chi_square):
            lines.append(f"reduced chi-square by the stated errors: {self.chi_square:.3g}")
        lines.append(f"error that the model leaves, of frequencies: {50 * self.model_error:.2g} %")
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])


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
    if np.any(apart > np.maximum(_FAR * fit.sigma, _SAME)):
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
