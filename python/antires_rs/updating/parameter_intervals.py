"""Intervals of parameters as a value: ends, draws, and a word on each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..support.pickling import FrozenDict
from ..support.validation import FloatArray, reject
from ..support.values import Value

__all__ = ["Method", "ParameterIntervals"]

Method = Literal["laplace", "ensemble"]


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

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> zeros = case.exact()
    >>> stated = {dof: 1e-3 * freq for dof, freq in zeros.items()}
    >>> zeros = ar.AntiresonanceSet(0, dict(zeros.items()), std_hz=stated)
    >>> problem = ar.UpdatingProblem(case.model, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), zeros)
    >>> found = ar.update(problem, rng=0).intervals()
    >>> found.words, found.draws.shape
    (('two-sided', 'two-sided'), (1000, 2))
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
        """One row a parameter; needs pandas."""
        from ..io.compared import intervals_frame

        return intervals_frame(self)

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
