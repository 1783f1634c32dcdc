"""The charts of a series and their limits, from a baseline of which parts are left out in turn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..support.pickling import ReadOnly, frozen
from ..support.validation import FloatArray
from .association import Values
from .basis import basis_of, folds_of
from .distance import Distances, Inverses, distances
from .events import event_limit, events, left_out_events
from .ewma import autocorrelation, drawn, means
from .learned import Learned, learned
from .limits import chi_square, upper_limit, wilson_hilferty
from .normal import degrees_of

__all__ = ["Chart", "Charts", "charts_of"]

#: How the rate of false alarms is shared out.
SHARES = {"T2": 0.6, "EWMA": 0.2, "events": 0.2}


@dataclass(frozen=True, eq=False, repr=False)
class Chart(ReadOnly):
    """One control chart.

    Attributes
    ----------
    statistic : (n,)
        NaN where a test has nothing to judge it by.
    limit : (n,)
        A test alarms above it.
    rate : float
        Its share of the rate of false alarms.

    Examples
    --------
    >>> import numpy as np
    >>> import antires_rs as ar
    >>> ar.Chart(np.array([12.0, 31.0]), np.array([25.0, 25.0]), 0.006)
    Chart(1 of 2 above the limit, rate 0.006)
    """

    statistic: FloatArray
    limit: FloatArray
    rate: float

    @property
    def ratio(self) -> FloatArray:
        """Statistic over limit, 0 where there is none, (n,)."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(np.nan_to_num(self.statistic / self.limit))

    def __repr__(self) -> str:
        return (
            f"Chart({np.sum(self.ratio > 1.0)} of {self.statistic.size} above the limit, rate {self.rate:g})"
        )


@dataclass(frozen=True)
class Charts:
    """All charts of n tests by name, what the baseline taught, and the distances behind them."""

    charts: Mapping[str, Chart]
    learned: Learned
    distances: Distances
    free: bool
    limit_w: float
    inverses: Inverses


def charts_of(
    values: Values,
    regular: NDArray[np.bool_],
    baseline: NDArray[np.intp],
    conditions: Mapping[str, FloatArray],
    rate: float,
) -> Charts:
    """Charts of all tests.

    Parameters
    ----------
    values : Values
        Of n tests, without the responses that are at fault.
    regular : (m,) bool
        Places that are followed.
    baseline : (k,) int
        Tests of the baseline that have a set.
    conditions : mapping of str to (n,)
    rate : float
        Of false alarms of all charts together.
    """
    y, std = values.log_hz[:, regular], values.std[:, regular]
    own = {name: column[baseline] for name, column in conditions.items()}
    basis = basis_of(y[baseline], own)
    x = basis.rows(own, baseline.size)
    degrees = degrees_of(
        y[baseline] - learned(y[baseline], std[baseline], own, basis, np.inf).regression.at(x)
    )
    whole = learned(y[baseline], std[baseline], own, basis, degrees)
    free = not basis.columns
    inverses = Inverses(whole.correlation)
    found = distances(whole, y, std, conditions, free=free, inverses=inverses)
    # The baseline's tests as what they would be if they came later.
    folds, z, t2 = folds_of(baseline.size), found.z.copy(), found.t2.copy()
    for fold in range(int(folds.max()) + 1):
        out, kept = baseline[folds == fold], folds != fold
        rest = {name: column[kept] for name, column in own.items()}
        part = learned(y[baseline][kept], std[baseline][kept], rest, basis, degrees)
        there = {name: column[out] for name, column in conditions.items()}
        seen = distances(part, y[out], std[out], there, free=free)
        z[out], t2[out] = seen.z, seen.t2
    found = Distances(z, t2, found.count)
    w = wilson_hilferty(t2[baseline], found.count[baseline])
    limit_w = upper_limit(w, SHARES["T2"] * rate)
    hotelling = Chart(
        frozen(np.where(found.count > 0, t2, np.nan)),
        frozen(chi_square(limit_w, found.count)),
        SHARES["T2"] * rate,
    )
    unsure = whole.beyond(conditions, len(y)) / whole.deviation(std, conditions)
    slow = _ewma(found, hotelling, baseline, whole, inverses, rate, basis.rows(conditions, len(y)), unsure)
    learned_events = values.take(baseline)
    chart = events(values, learned_events)
    chart[baseline] = left_out_events(learned_events, folds)
    limit = event_limit(chart[baseline], baseline.size, SHARES["events"] * rate)
    judged = np.any(values.looked, axis=1)
    vanished = Chart(
        frozen(np.where(judged, chart, np.nan)), frozen(np.full(chart.size, limit)), SHARES["events"] * rate
    )
    return Charts({"T2": hotelling, "EWMA": slow, "events": vanished}, whole, found, free, limit_w, inverses)


def _ewma(
    found: Distances,
    hotelling: Chart,
    baseline: NDArray[np.intp],
    whole: Learned,
    inverses: Inverses,
    rate: float,
    x: FloatArray,
    beyond: FloatArray,
) -> Chart:
    """The chart of slow changes."""
    bounds = np.sqrt(1.0 / np.maximum(hotelling.ratio, 1.0))
    error = whole.basis.size / baseline.size
    slow = means(found.z, bounds, inverses, x, whole.regression.inverse, beyond)
    share = SHARES["EWMA"] * rate
    limit_w, usual = drawn(found.z[baseline], whole.correlation, error, share)
    first = np.sort(baseline)
    t2 = slow.t2 / autocorrelation(slow.t2[first], slow.count[first], usual)
    limit = chi_square(limit_w, slow.count)
    t2 = np.where(slow.agrees, t2, np.minimum(t2, limit))
    judged = (found.count > 0) & (slow.count > 0)
    return Chart(frozen(np.where(judged, t2, np.nan)), frozen(limit), share)
