"""What is known of each test of a watch, without the views on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assessor.answer import AssessedTest
from ..damage.result import DamageResult
from ..support.pickling import ReadOnly
from ..support.validation import FloatArray, reject
from .charts import Chart
from .faults import Fault

__all__ = ["JudgedTests"]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class JudgedTests(ReadOnly):
    """Alarms, charts and faults of n tests, see :class:`antires_rs.Watched`."""

    alarm: NDArray[np.bool_]
    statistic: FloatArray
    charts: Mapping[str, Chart]
    false_alarm_rate: float
    baseline: NDArray[np.intp]
    names: tuple[str, ...]
    times: NDArray[np.datetime64] | None
    conditions: Mapping[str, FloatArray]
    used: tuple[str, ...]
    bends: Mapping[str, float]
    clocks: tuple[str, ...]
    outside: NDArray[np.bool_]
    faults: Mapping[int, tuple[Fault, ...]]
    failed: Mapping[int, str]
    runs: tuple[tuple[int, int], ...]
    assessments: Mapping[int, DamageResult | AssessedTest]
    needed: int
    dof: NDArray[Any]
    freq_hz: FloatArray
    expected_hz: FloatArray
    std_hz: FloatArray

    @property
    def limit(self) -> float:
        """What ``statistic`` alarms above: 1, since each chart is divided by its own limit."""
        return 1.0

    @property
    def outside_baseline(self) -> NDArray[np.bool_]:
        """Tests after or beside the baseline that could be judged, (n,)."""
        rest = ~np.isnan(self.statistic)
        rest[self.baseline] = False
        return rest

    @property
    def unjudged(self) -> NDArray[np.bool_]:
        """Tests with a set that could not be judged, most of their responses being at fault, (n,)."""
        rest = np.isnan(self.statistic)
        rest[list(self.failed)] = False
        return rest

    def why(self, test: int) -> tuple[str, ...]:
        """Names of the charts in which a test is above the limit."""
        if (
            isinstance(test, bool)
            or not isinstance(test, int | np.integer)
            or not -len(self) <= test < len(self)
        ):
            reject("test", test, f"the number of a test, 0 to {len(self) - 1}", "Tests are counted from 0.")
        return tuple(name for name, chart in self.charts.items() if chart.ratio[test] > 1.0)

    def __len__(self) -> int:
        return int(self.alarm.size)
