"""What a watch says: alarms, charts, faults, and the damage behind them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..damage.assess import assess_damage
from ..damage.assessor import AssessedTest, Assessor
from ..damage.options import SearchOptions, sorted_out
from ..damage.result import DamageResult
from ..exceptions import reject
from ..io.data_frames import frame_of
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.structural_model import StructuralModel
from ..support.checks import FloatArray
from ..support.values import ReadOnly
from ..views import Viewed
from .association import Places, Values
from .baseline import Learned, directions
from .charts import Chart
from .faults import Fault

# -- What is known of each test of a watch, without the views on it


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


# -- A watch as text: the rate and how it was checked, alarms, damage, faults


#: So many runs and faults are listed; the others are counted.
_LISTED = 8


def printed(watched: JudgedTests) -> str:
    """The summary."""
    count = int(watched.outside_baseline.sum())
    alarms = int(watched.alarm[watched.outside_baseline].sum())
    title = (
        f"{len(watched):,} tests watched, {watched.baseline.size} of them the baseline, "
        f"by {watched.dof.size} antiresonances"
    )
    found = (
        f"{alarms} of {count:,} tests outside the baseline alarm" if count else "no test outside the baseline"
    )
    lines = [title, found, *rate_lines(watched), *alarm_lines(watched), *fault_lines(watched)]
    unjudged = int(watched.unjudged.sum())
    if unjudged:
        lines.append(f"not judged, most responses being at fault: {unjudged} tests, see .unjudged")
    if watched.failed:
        lines.append(f"failed, not judged: {len(watched.failed)} tests, see .failed")
    return "\n".join(lines)


def rate_lines(watched: JudgedTests) -> list[str]:
    """The rate, how it was checked, and what it was learned on."""
    rate, base = 100.0 * watched.false_alarm_rate, watched.baseline
    hits = int(watched.alarm[base].sum())
    lines = [
        f"false alarms: {rate:g} % of intact tests stated; {hits} of {base.size} baseline tests "
        f"({100.0 * hits / base.size:.1f} %) alarm when left out"
    ]
    if base.size < watched.needed:
        lines.append(
            f"the baseline is short for this rate: {base.size} tests, "
            f"{watched.needed} are needed to rely on it"
        )
    if watched.used:
        told = [
            name + (f" (bent at {watched.bends[name]:.3g})" if name in watched.bends else "")
            for name in watched.used
        ]
        lines.append(f"corrected for {', '.join(told)}")
        out = int(np.sum(watched.outside & watched.outside_baseline))
        if out:
            lines.append(
                f"{out:,} tests at conditions that the baseline does not have: lines go on, "
                "their uncertainty counted"
            )
    else:
        lines.append(
            "corrected for what the baseline's antiresonances do together, no condition being of use"
        )
    if watched.clocks:
        lines.append(f"not used, since it only grows or falls with the tests: {', '.join(watched.clocks)}")
    return lines


def alarm_lines(watched: JudgedTests) -> list[str]:
    """Runs of alarms outside the baseline, with their damage."""
    inside = set(watched.baseline.tolist())
    runs = [run for run in watched.runs if run[1] not in inside]
    # Those that say most first to be listed, then in order.
    longest = sorted(sorted(runs, key=lambda run: run[0] - run[1])[:_LISTED])
    lines = []
    for first, last in longest:
        hits = int(watched.alarm[first : last + 1].sum())
        why = Counter(name for i in range(first, last + 1) if watched.alarm[i] for name in watched.why(i))
        names = watched.names[first] if first == last else f"{watched.names[first]} to {watched.names[last]}"
        text = f"alarm: test {names}, " if first == last else f"alarm: tests {names}, {hits} alarms, "
        lines.append(text + ", ".join(name for name, _ in why.most_common()))
        if first in watched.assessments:
            lines.append("  " + watched.assessments[first].headline.replace("\n", "\n  "))
    if len(runs) > len(longest):
        lines.append(f"and {len(runs) - len(longest)} shorter runs of alarms, see .runs")
    return lines


def fault_lines(watched: JudgedTests) -> list[str]:
    """Responses at fault, counted."""
    told = Counter((str(f.dof), f.text) for here in watched.faults.values() for f in here)
    lines = [
        f"sensor fault: dof {dof}, {text}" + (f" ({count} tests)" if count > 1 else "")
        for (dof, text), count in told.most_common(_LISTED)
    ]
    if len(told) > _LISTED:
        lines.append(f"and {len(told) - _LISTED} other faults, see .faults")
    return lines


# -- A watch for pandas


def watched_frame(watched: JudgedTests) -> Any:
    """A pandas.DataFrame, one row a test."""
    inside = set(watched.baseline.tolist())
    rows: list[dict[str, Any]] = []
    for i, name in enumerate(watched.names):
        row: dict[str, Any] = {"test": i, "name": name}
        if watched.times is not None:
            row["time"] = watched.times[i]
        row |= {key: float(column[i]) for key, column in watched.conditions.items()}
        row |= {
            "baseline": i in inside,
            "alarm": bool(watched.alarm[i]),
            "statistic": float(watched.statistic[i]),
        }
        for key, chart in watched.charts.items():
            row |= {key: float(chart.statistic[i]), f"{key}_limit": float(chart.limit[i])}
        row |= {
            "why": ", ".join(watched.why(i)) if watched.alarm[i] else "",
            "outside_range": bool(watched.outside[i]),
            "faults": "; ".join(f"{fault.dof}: {fault.text}" for fault in watched.faults.get(i, ())),
            "failed": watched.failed.get(i, ""),
        }
        rows.append(row)
    return frame_of(rows, list(rows[0]) if rows else ["test"])


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Watched(JudgedTests, Viewed):
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
        """Draw charts and conditions; see :func:`~antires_rs.figures.plot_monitor`."""
        return self._view("plot")(self, panel=panel, ax=ax)

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
        self._view("report")(self, path)


# -- Damage assessed where alarms stand together: tests of a run against the baseline, at one condition


#: Alarms with so many quiet tests between them, at most, are of one run.
_QUIET = 5
#: Tests of a run that are put together, the latest.
_MOST = 50
#: Strange values of several tests are one if they are this near.
_SAME = 0.01
#: What moves all values alike between two tests, relative, at least; as for ``assess_damage``.
_COMMON = 5e-4


def runs_of(alarm: NDArray[np.bool_], judged: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last test of each run of alarms; tests that could not be judged do not end one."""
    found: list[tuple[int, int]] = []
    quiet = 0
    for i in range(alarm.size):
        if alarm[i]:
            if found and quiet <= _QUIET:
                found[-1] = (found[-1][0], i)
            else:
                found.append((i, i))
            quiet = 0
        else:
            quiet += int(judged[i])
    return found


def assessed(
    by: StructuralModel | Assessor,
    run: tuple[int, int],
    learned: Learned,
    values: Values,
    places: Places,
    sets: Sequence[AntiresonanceSet | None],
    conditions: Mapping[str, FloatArray],
    options: Mapping[str, Any],
) -> DamageResult | AssessedTest | None:
    """``assess_damage`` of the tests of a run against the baseline, or an assessor's answer; None if they
    have no antiresonance."""
    first = next(one for one in sets if one is not None)
    tests = np.array([i for i in range(run[0], run[1] + 1) if values.looked[i].any()][-_MOST:])
    regular = places.regular
    own = {name: column[tests] for name, column in conditions.items()}
    middle = {name: np.array([np.nan]) for name in conditions}  # not known: at its middle
    reference = learned.expected(middle, 1)[0]
    rest = values.log_hz[tests][:, regular] - learned.expected(own, len(tests))
    seen, looked = ~np.isnan(rest), values.looked[tests][:, regular]
    count = seen.sum(axis=0)
    kept = count >= np.maximum(1, 0.5 * looked.sum(axis=0))
    moved = np.array([np.median(rest[seen[:, k], k]) if kept[k] else np.nan for k in range(count.size)])
    std = np.sqrt(learned.variance * np.pi / 2.0 / np.maximum(count, 1))  # of a median
    base_std = np.sqrt(learned.variance * learned.regression.inverse[0, 0])
    new = _again([values.strange[i] for i in tests.tolist()])
    dofs = [dof for dof in places.dofs if np.any(looked[:, places.dof[regular] == dof]) or dof in new]
    now: dict[Any, tuple[list[float], list[float]]] = {dof: ([], []) for dof in dofs}
    for k in np.flatnonzero(kept).tolist():
        dof = places.dof[regular][k]
        freq = float(np.exp(reference[k] + moved[k]))
        now[dof][0].append(freq)
        now[dof][1].append(freq * float(std[k]))
    usual = float(np.median(np.sqrt(learned.variance)))
    for dof, freqs in new.items():
        now[dof][0].extend(freqs)
        now[dof][1].extend(f * usual / np.sqrt(len(tests)) for f in freqs)
    if not any(freqs for freqs, _ in now.values()):
        return None
    sight: dict[str, Any] = {"sees": first.sees, "channels": first.channels or None}
    measured = AntiresonanceSet(
        first.excitation,
        {d: f for d, (f, _) in now.items()},
        std_hz={d: s for d, (_, s) in now.items()},
        **sight,
    )
    if isinstance(by, Assessor):
        return by.assess(measured)
    at = {dof: places.dof[regular] == dof for dof in dofs}
    hz = np.exp(reference)
    baseline = AntiresonanceSet(
        first.excitation,
        {dof: hz[rows] for dof, rows in at.items()},
        std_hz={dof: (hz * base_std)[rows] for dof, rows in at.items()},
        **sight,
    )
    unsure = [directions(learned, own, i, free=False) for i in range(len(tests))]
    common = max([_COMMON] + [float(np.sqrt(np.mean(g**2)) * np.sqrt(g.shape[1])) for g in unsure if g.size])
    given = sorted_out({"search": None, "progress": False} | dict(options))
    search = given["search"] or SearchOptions()
    if "std_common" not in search.given:
        given["search"] = search.joined({"std_common": min(common, 0.1)})
    return assess_damage(by, measured, baseline=baseline, **given)


def _again(strange: Sequence[Sequence[tuple[Any, float]]]) -> dict[Any, list[float]]:
    """Values at no place that at least half of the tests have, by response."""
    groups: list[tuple[Any, list[float]]] = []
    for own in strange:
        for dof, freq in own:
            near = [g for d, g in groups if d == dof and abs(freq / float(np.median(g)) - 1.0) < _SAME]
            if near:
                near[0].append(freq)
            else:
                groups.append((dof, [freq]))
    found: dict[Any, list[float]] = {}
    for dof, group in groups:
        if 2 * len(group) >= len(strange):
            found.setdefault(dof, []).append(float(np.median(group)))
    return found
