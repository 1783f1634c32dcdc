"""What the antiresonances depend on: each condition as a straight line, or one with a bend, or not at all.

A condition is kept where tests that are left out are predicted better with it, and bends where that predicts
them better again by more than its standard error. Beyond the baseline's range the line goes on, with what is
not known of it as a standard deviation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .regression import fitted

__all__ = ["Basis", "Column", "basis_of", "folds_of"]

#: Parts in which the baseline is left out in turn, at most.
FOLDS = 20
#: Where a line may bend: these shares of the baseline are below.
BENDS = (0.25, 0.5, 0.75)
#: Tests on either side of a bend, at least.
_SIDE = 10
#: A condition that varies less than this share of its own size does not vary.
_STILL = 1e-9


@dataclass(frozen=True)
class Column:
    """One condition: where its line bends (None: nowhere), and its middle, low and high in the baseline."""

    name: str
    bend: float | None
    middle: float
    std: float
    low: float
    high: float


@dataclass(frozen=True)
class Basis:
    """The columns that are used; what was given and is not, in ``unused``."""

    columns: tuple[Column, ...]
    unused: tuple[str, ...] = ()

    @property
    def size(self) -> int:
        """Number of functions, with the constant."""
        return 1 + sum(1 if one.bend is None else 2 for one in self.columns)

    def rows(self, conditions: Mapping[str, FloatArray], n: int) -> FloatArray:
        """The functions at some tests, (n, size); a condition that is not known is taken at its middle."""
        made = [np.ones(n)]
        for one in self.columns:
            value = np.where(np.isnan(conditions[one.name]), one.middle, conditions[one.name]) - one.middle
            made.append(value / one.std)
            if one.bend is not None:
                made.append(np.maximum(value - (one.bend - one.middle), 0.0) / one.std)
        return np.stack(made, axis=1)

    def slopes(self, coefficients: FloatArray, name: str, above: bool) -> FloatArray:
        """Change of each value with one condition, (m,), at its high or its low end."""
        place = 1
        for one in self.columns:
            if one.name == name:
                slope = coefficients[place] / one.std
                if one.bend is not None and above:
                    slope = slope + coefficients[place + 1] / one.std
                return np.asarray(slope)
            place += 1 if one.bend is None else 2
        raise KeyError(name)

    def outside(self, conditions: Mapping[str, FloatArray], n: int) -> NDArray[np.bool_]:
        """Tests at a condition that the baseline does not have, (n,)."""
        out = np.zeros(n, dtype=bool)
        for one in self.columns:
            value = conditions[one.name]
            with np.errstate(invalid="ignore"):
                out |= (value < one.low) | (value > one.high)
        return out


def folds_of(n: int) -> NDArray[np.intp]:
    """Part to which each baseline test belongs, (n,): every k-th test, so that all parts span all times."""
    return np.arange(n) % min(n, FOLDS)


def basis_of(y: FloatArray, conditions: Mapping[str, FloatArray]) -> Basis:
    """The basis that the baseline supports.

    Parameters
    ----------
    y : (n, m)
        Values with NaN.
    conditions : mapping of str to (n,)
    """
    if not conditions:
        return Basis(())
    used: tuple[Column, ...] = ()
    unused: list[str] = []
    error = _left_out(y, Basis(()), conditions)
    for name, values in conditions.items():
        known = values[~np.isnan(values)]
        if known.size < _SIDE or np.std(known) <= _STILL * max(np.abs(known).max(), 1e-300):
            unused.append(name)
            continue
        line = Column(
            name, None, float(known.mean()), float(known.std()), float(known.min()), float(known.max())
        )
        best, best_error = line, _left_out(y, Basis((*used, line)), conditions)
        if np.nanmean(best_error) >= np.nanmean(error):
            unused.append(name)
            continue
        for share in BENDS:
            at = float(np.quantile(known, share))
            if min(np.sum(known < at), np.sum(known > at)) < _SIDE:
                continue
            bent = Column(name, at, line.middle, line.std, line.low, line.high)
            bent_error = _left_out(y, Basis((*used, bent)), conditions)
            gain = best_error - bent_error
            if np.nanmean(gain) > 2.0 * np.nanstd(gain) / np.sqrt(np.sum(~np.isnan(gain))):
                best, best_error = bent, bent_error
        used, error = (*used, best), best_error
    return Basis(used, tuple(unused))


def _left_out(y: FloatArray, basis: Basis, conditions: Mapping[str, FloatArray]) -> FloatArray:
    """Squared errors of tests left out in turn, by test, each value in units of its own spread."""
    x = basis.rows(conditions, len(y))
    folds, rest = folds_of(len(y)), np.full(y.shape, np.nan)
    for fold in range(int(folds.max()) + 1):
        out = folds == fold
        rest[out] = y[out] - fitted(y[~out], x[~out]).at(x[out])
    middle = np.nanmedian(y, axis=0)
    size = np.nanmedian(np.abs(y - middle), axis=0)
    # Wild values would decide; they tell nothing of conditions.
    bounded = np.minimum((rest / np.maximum(size, 1e-12)) ** 2, 9.0)
    count = np.sum(~np.isnan(bounded), axis=1)
    return np.asarray(np.where(count > 0, np.nansum(bounded, axis=1) / np.maximum(count, 1), np.nan))
