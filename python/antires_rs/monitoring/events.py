r"""Antiresonances that vanish, merge or appear: how surprising the pattern of a test is.

A place that a share q of the baseline's tests has costs :math:`-\ln q` where a test has it and
:math:`-\ln(1 - q)` where not, less what it costs on average; a value at no place costs as the baseline has
such values rarely. Shares are those of n tests plus one half. What the test before showed as well counts
twice: chance does not do the same again. The limit for a rate goes beyond the baseline by an exponential
tail, whose scale is at least that of one place that was never missed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .association import Values

__all__ = ["event_limit", "events", "left_out_events"]

#: Strange values of two tests are one if they are this near.
_SAME = 0.01


class _Costs:
    """Costs learned from presence (n, m) with what was looked at (n, m), and strange values by test."""

    def __init__(
        self,
        there: NDArray[np.bool_],
        looked: NDArray[np.bool_],
        strange: Sequence[Sequence[tuple[Any, float]]],
    ) -> None:
        tests = looked.sum(axis=0)
        share = (np.sum(there & looked, axis=0) + 0.5) / (tests + 1.0)
        self.present, self.absent = -np.log(share), -np.log(1.0 - share)
        self.usual = share * self.present + (1.0 - share) * self.absent
        # A new value is as rare as there are tests without one, and costs more the fewer there were.
        self.strange = np.log((len(strange) + 1.0) / (sum(map(len, strange)) + 0.5))
        self.strange = max(float(self.strange), 0.0) + 1.0

    def of(
        self, there: NDArray[np.bool_], looked: NDArray[np.bool_], strange: Sequence[tuple[Any, float]]
    ) -> tuple[FloatArray, float]:
        """By place, and of all strange values."""
        cost = np.where(there, self.present, self.absent) - self.usual
        return np.where(looked, cost, 0.0), self.strange * len(strange)


def events(values: Values, baseline: Values) -> FloatArray:
    """The chart of tests, (n,)."""
    costs = _Costs(~np.isnan(baseline.log_hz), baseline.looked, baseline.strange)
    return _chart(values, [costs] * len(values.strange))


def left_out_events(baseline: Values, folds: NDArray[np.intp]) -> FloatArray:
    """The chart of the baseline (n,), each part judged by the others."""
    parts = []
    for fold in range(int(folds.max()) + 1):
        kept = baseline.take(np.flatnonzero(folds != fold))
        parts.append(_Costs(~np.isnan(kept.log_hz), kept.looked, kept.strange))
    return _chart(baseline, [parts[fold] for fold in folds.tolist()])


def _chart(values: Values, costs: Sequence[_Costs]) -> FloatArray:
    chart = np.zeros(len(values.strange))
    before: tuple[FloatArray, Sequence[tuple[Any, float]]] | None = None
    for i, cost in enumerate(costs):
        there, looked = ~np.isnan(values.log_hz[i]), values.looked[i]
        strange = values.strange[i]
        place, new = cost.of(there, looked, strange)
        chart[i] = float(place.sum()) + new
        if before is not None:
            chart[i] += float(np.minimum(np.maximum(place, 0.0), np.maximum(before[0], 0.0)).sum())
            again = sum(
                any(dof == d and abs(f / g - 1.0) < _SAME for d, g in before[1]) for dof, f in strange
            )
            chart[i] += cost.strange * again
        before = (place, strange)
    return chart


def event_limit(chart: FloatArray, tests: int, rate: float) -> float:
    """What a further test exceeds with at most ``rate``."""
    one = np.log(tests + 1.0)
    highest = float(np.max(chart))
    if tests * rate > 3.0:
        highest = float(np.quantile(chart, 1.0 - rate))
    scale = max(one, float(np.std(chart)))
    return float(highest + scale * max(0.25, float(np.log(1.0 / (tests * rate)))))
