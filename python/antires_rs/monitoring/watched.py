"""What a watch says: alarms, charts, faults, and the damage behind them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

from .frames import watched_frame
from .judged_tests import JudgedTests
from .printed import printed

__all__ = ["Watched"]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Watched(JudgedTests):
    """What :func:`~antires_rs.monitor` found in n tests; print it for a summary.

    Attributes
    ----------
    alarm : (n,) bool
        Of each test by itself, the baseline's included; False where a test failed or could not be judged,
        see ``unjudged``.
    statistic : (n,)
        The largest of its charts, each over its limit; NaN where it could not be judged. Tests of the
        baseline are judged as if they came later, by the others.
    charts : dict of str to Chart
        "T2", "EWMA" and "events".
    false_alarm_rate : float
        Share of intact tests outside the baseline that alarm, at most about.
    baseline : (k,) int
        Its tests that have a set.
    names, times, conditions, failed
        Of the tests, as in the :class:`~antires_rs.Series`.
    used : tuple of str
        Conditions that the antiresonances were found to depend on.
    bends : dict of str to float
        Where the line over a condition bends, of those whose line does.
    clocks : tuple of str
        Conditions that only grow or only fall from test to test, and are not used.
    outside : (n,) bool
        Tests at conditions that the baseline does not have.
    faults : dict of int to tuple of Fault
        Responses that a test was judged without, and why.
    runs : tuple of (first, last)
        Alarms that stand together.
    assessments : dict of int to DamageResult or AssessedTest
        Damage of each run, by its first test; empty without a model or an assessor.
    needed : int
        Baseline tests from which on the rate can be relied on.
    dof : (m,)
        Responses of the antiresonances that are followed.
    freq_hz, expected_hz, std_hz : (n, m)
        As measured (NaN where a test does not have it), as expected at the test's conditions, and the
        standard deviation of their difference.

    Examples
    --------
    >>> import antires_rs as ar
    >>> import numpy as np
    >>> rng = np.random.default_rng(0)
    >>> sets = [ar.AntiresonanceSet(0, {0: [8.7, 23.9] + 0.01 * rng.standard_normal(2)}) for _ in range(60)]
    >>> ar.monitor(sets, baseline=50)
    Watched(60 tests, 0 alarms outside the baseline, rate 0.01)
    """

    def __repr__(self) -> str:
        alarms = int(self.alarm[self.outside_baseline].sum())
        rate = self.false_alarm_rate
        return f"Watched({len(self)} tests, {alarms} alarms outside the baseline, rate {rate:g})"

    def __str__(self) -> str:
        return printed(self)

    def plot(self, panel: str = "charts", ax: Any = None) -> Any:
        """Draw charts and conditions; see :func:`~antires_rs.plotting.plot_monitor`."""
        from ..plotting.monitor import plot_monitor

        return plot_monitor(self, panel=panel, ax=ax)

    def to_dataframe(self) -> Any:
        """One row a test: name, time, conditions, charts with their limits, alarm, faults, reason.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        MissingDependencyError
            pandas is not installed.
        """
        return watched_frame(self)

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write one page of HTML: summary, charts, alarms, faults and damage; an older one is replaced.

        Raises
        ------
        InvalidInputError
            No path, or one in a folder that does not exist.
        MissingDependencyError
            matplotlib is not installed.
        """
        from ..report.monitor import write_monitor_report

        write_monitor_report(self, path)
