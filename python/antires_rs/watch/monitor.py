"""Watch a structure: which tests of a series differ from its baseline."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from inspect import signature
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..damage.assess import AssessedTest, Assessor, DamageResult, assess_damage, elements_of
from ..damage.options import SearchOptions, sorted_out
from ..exceptions import reject
from ..io.data_frames import frame_of
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.matching import MAX_SHIFT, within
from ..measured.response_table import rows_with
from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..support.checks import FloatArray, finite_scalar
from ..support.messages import keywords_left, warn
from ..support.progress import patient, step
from ..support.values import FrozenDict, ReadOnly, frozen
from ..updating.problem import UpdatingProblem
from ..views import Viewed
from .association import Fault, Places, Values, lost_alone, obvious, places_of, values_of
from .baseline import Learned
from .charts import Chart, Charts, charts_of, needed, wilson_hilferty
from .conditions import condition_table
from .series import Series

# -- A watch as text: the rate and how it was checked, alarms, damage, faults

_LISTED = 8  # so many runs and faults are listed; the others are counted


def rate_lines(watched: Watched) -> list[str]:
    """The rate, how it was checked, and what it was learned on."""
    rate, base = 100.0 * watched.false_alarm_rate, watched.baseline
    hits = int(watched.alarm[base].sum())
    checked = f"{hits} of {base.size} baseline tests ({100.0 * hits / base.size:.1f} %) alarm when left out"
    lines = [f"false alarms: {rate:g} % of intact tests stated; {checked}"]
    if base.size < watched.needed:
        short = f"{base.size} tests, {watched.needed} are needed to rely on it"
        lines.append(f"the baseline is short for this rate: {short}")
    bends = {name: f" (bent at {at:.3g})" for name, at in watched.bends.items()}
    used = ", ".join(name + bends.get(name, "") for name in watched.used)
    used = used or "what the baseline's antiresonances do together, no condition being of use"
    lines.append(f"corrected for {used}")
    if out := int(np.sum(watched.outside & watched.outside_baseline)):
        lines.append(f"{out:,} tests at conditions that the baseline does not have, which counts as error")
    if watched.clocks:
        lines.append(f"not used, since it only grows or falls with the tests: {', '.join(watched.clocks)}")
    return lines


def alarm_lines(watched: Watched) -> list[str]:
    """Runs of alarms outside the baseline, with their damage."""
    inside = set(watched.baseline.tolist())
    runs = [run for run in watched.runs if run[1] not in inside]
    lines = []
    # Those that say most first to be listed, then in order.
    for first, last in sorted(sorted(runs, key=lambda run: run[0] - run[1])[:_LISTED]):
        hits = np.flatnonzero(watched.alarm[first : last + 1]) + first
        why = Counter(name for i in hits.tolist() for name in watched.why(i))
        tests = f"test {watched.names[first]}"
        if first != last:
            tests = f"tests {watched.names[first]} to {watched.names[last]}, {hits.size} alarms"
        lines.append(f"alarm: {tests}, {', '.join(name for name, _ in why.most_common())}")
        if first in watched.assessments:
            lines.append("  " + watched.assessments[first].headline.replace("\n", "\n  "))
    if len(runs) > _LISTED:
        lines.append(f"and {len(runs) - _LISTED} shorter runs of alarms, see .runs")
    return lines


def fault_lines(watched: Watched) -> list[str]:
    """Responses at fault, counted."""
    counts = Counter(f"dof {f.dof}, {f.text}" for here in watched.faults.values() for f in here)
    shown = [f"sensor fault: {fault}{f' ({n} tests)' * (n > 1)}" for fault, n in counts.most_common(_LISTED)]
    return shown + [f"and {len(counts) - _LISTED} other faults, see .faults"] * (len(counts) > _LISTED)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Watched(ReadOnly, Viewed):
    """What :func:`~antires_rs.monitor` found in n tests; print it for a summary.

    Attributes
    ----------
    alarm : (n,) bool
        Of each test by itself; False also where a test failed or cannot be judged, see ``unjudged``.
    statistic, charts : (n,), and dict of str to Chart
        The largest of the charts "T2", "EWMA" and "events", each over its limit; NaN where it could not be
        judged. Tests of the baseline are judged by the others.
    false_alarm_rate, baseline, needed : float, (k,) int and int
        Share of intact tests outside the baseline that alarm, at most about; the baseline's tests that have a
        set; how many are enough to rely on the rate.
    names, times, conditions, failed
        Of the tests, as in the :class:`~antires_rs.Series`.
    used, bends, clocks : tuple of str, dict of str to float, tuple of str
        Conditions that the antiresonances were found to depend on, where the lines over them bend, and those
        that are not used since they only grow or only fall from test to test.
    outside : (n,) bool
        Tests at conditions that the baseline does not have.
    faults : dict of int to tuple of Fault
        Responses that a test was judged without, and why.
    runs : tuple of (first, last)
        Alarms that stand together.
    assessments : dict of int to DamageResult or AssessedTest
        Damage of each run, by its first test; empty without a model or an assessor.
    dof : (m,)
        Responses of the antiresonances that are followed.
    freq_hz, expected_hz, std_hz : (n, m)
        As measured (NaN where a test does not have it), as expected at the test's conditions, and the
        standard deviation of their difference.

    Examples
    --------
    >>> import antires_rs as ar, numpy as np
    >>> rng = np.random.default_rng(0)
    >>> sets = [ar.AntiresonanceSet(0, {0: rng.normal([8.7, 23.9], 0.01)}) for _ in range(60)]
    >>> ar.monitor(sets, baseline=50)
    Watched(60 tests, 0 alarms outside the baseline, rate 0.01)
    """

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
        """Tests that cannot be judged, (n,): none of what is followed seen, or most responses at fault."""
        rest = np.isnan(self.statistic)
        rest[list(self.failed)] = False
        return rest

    def why(self, test: int) -> tuple[str, ...]:
        """Names of the charts in which a test is above the limit."""
        whole = isinstance(test, int | np.integer) and not isinstance(test, bool)
        if not whole or not -len(self) <= test < len(self):
            reject("test", test, f"the number of a test, 0 to {len(self) - 1}", "Tests are counted from 0.")
        return tuple(name for name, chart in self.charts.items() if chart.ratio[test] > 1.0)

    def __len__(self) -> int:
        return int(self.alarm.size)

    def __repr__(self) -> str:
        alarms = int(self.alarm[self.outside_baseline].sum())
        rate = self.false_alarm_rate
        return f"Watched({len(self)} tests, {alarms} alarms outside the baseline, rate {rate:g})"

    def __str__(self) -> str:
        rest = self.outside_baseline
        count, alarms = int(rest.sum()), int(self.alarm[rest].sum())
        base = f"{self.baseline.size} of them the baseline, by {self.dof.size} antiresonances"
        answer = f"{alarms} of {count:,} tests outside the baseline alarm"
        lines = [f"{len(self):,} tests watched, {base}", answer if count else "no test outside the baseline"]
        lines += [*rate_lines(self), *alarm_lines(self), *fault_lines(self)]
        if self.unjudged.any():
            why = "none of these antiresonances seen, or most responses at fault"
            lines.append(f"cannot judge {self.unjudged.sum()} tests: {why}, see .unjudged")
        if self.failed:
            lines.append(f"failed, not judged: {len(self.failed)} tests, see .failed")
        return "\n".join(lines)

    @keywords_left(panel="all charts are drawn; single tests into ax")
    def plot(self, ax: Any = None) -> Any:
        """Draw charts and conditions; see :func:`~antires_rs.figures.plot_monitor`."""
        return self._view("plot")(self, ax=ax)

    def to_dataframe(self) -> Any:
        """A ``pandas.DataFrame``, a row a test: name, time, conditions, charts, limits, alarm, faults."""
        tests = range(len(self))
        columns: dict[str, Any] = {"test": tests, "name": self.names}
        columns |= {} if self.times is None else {"time": list(self.times)}
        columns |= dict(self.conditions)
        columns |= {"baseline": np.isin(tests, self.baseline), "alarm": self.alarm}
        columns |= {"judged": ~np.isnan(self.statistic), "statistic": self.statistic}
        for key, chart in self.charts.items():
            columns |= {key: chart.statistic, f"{key}_limit": chart.limit}
        columns["why"] = [", ".join(self.why(i)) if self.alarm[i] else "" for i in tests]
        faults = [self.faults.get(i, ()) for i in tests]
        columns |= {"outside_range": self.outside}
        columns["faults"] = ["; ".join(f"{fault.dof}: {fault.text}" for fault in here) for here in faults]
        columns["failed"] = [self.failed.get(i, "") for i in tests]
        return frame_of(columns, list(columns))

    def report(self, path: str | os.PathLike[str]) -> None:
        """Write one page of HTML: summary, charts, alarms, faults and damage; needs matplotlib."""
        self._view("report")(self, path)


# -- Damage assessed where alarms stand together: tests of a run against the baseline, at one condition

_QUIET = 5  # alarms with so many quiet tests between them, at most, are of one run
_MOST = 50  # tests of a run that are put together, the latest
_SAME = 0.01  # strange values of several tests are one if they are this near
_COMMON = 5e-4  # what moves all values alike between two tests, relative, at least; as for ``assess_damage``


def _assessed(
    by: StructuralModel | Assessor,
    run: tuple[int, int],
    learned: Learned,
    values: Values,
    places: Places,
    first: AntiresonanceSet,
    conditions: Mapping[str, FloatArray],
    options: Mapping[str, Any],
) -> DamageResult | AssessedTest | None:
    """Damage of the tests of a run, which see as the ``first`` does; None if they have no antiresonance."""
    tests = np.array([i for i in range(run[0], run[1] + 1) if values.looked[i].any()][-_MOST:])
    regular = places.regular
    own = {name: column[tests] for name, column in conditions.items()}
    middle = {name: np.array([np.nan]) for name in conditions}  # not known: at its middle
    reference = learned.expected(middle, 1)[0]
    hz = np.exp(reference)
    rest = values.log_hz[tests][:, regular] - learned.expected(own, len(tests))
    seen, looked = ~np.isnan(rest), values.looked[tests][:, regular]
    count = seen.sum(axis=0)
    kept = count >= np.maximum(1, 0.5 * looked.sum(axis=0))
    std = np.sqrt(learned.variance * np.pi / 2.0 / np.maximum(count, 1))  # of a median
    usual = float(np.median(np.sqrt(learned.variance))) / np.sqrt(len(tests))
    groups: list[tuple[Any, list[float]]] = []  # Values at no place that at least half of the tests have.
    for dof, freq in (one for i in tests.tolist() for one in values.strange[i]):
        near = (g for d, g in groups if d == dof and abs(freq / float(np.median(g)) - 1.0) < _SAME)
        if (group := next(near, None)) is None:
            groups.append((dof, group := []))
        group.append(freq)
    new = [(dof, float(np.median(group))) for dof, group in groups if 2 * len(group) >= len(tests)]
    at = {dof: rows_with(places.dof[regular], dof) for dof in places.dofs}
    at = {dof: rows for dof, rows in at.items() if looked[:, rows].any() or dof in dict(new)}
    now: dict[Any, list[tuple[float, float]]] = {}
    for dof, rows in at.items():
        medians = {k: float(np.median(rest[seen[:, k], k])) for k in np.flatnonzero(kept & rows).tolist()}
        freqs = {k: float(np.exp(reference[k] + median)) for k, median in medians.items()}
        now[dof] = [(freq, freq * float(std[k])) for k, freq in freqs.items()]
        now[dof] += [(freq, freq * usual) for d, freq in new if d == dof]
    if not any(now.values()):
        return None
    sight: dict[str, Any] = {"sees": first.sees, "channels": first.channels or None}

    def set_of(rows: Mapping[Any, Any]) -> AntiresonanceSet:
        freq, stds = ({dof: [one[i] for one in own] for dof, own in rows.items()} for i in (0, 1))
        return AntiresonanceSet(first.excitation, freq, std_hz=stds, **sight)

    if isinstance(by, Assessor):
        return by.assess(set_of(now))
    base_std = hz * np.sqrt(learned.variance * learned.regression.inverse[0, 0])
    baseline = {dof: list(zip(hz[rows], base_std[rows], strict=True)) for dof, rows in at.items()}
    unsure = [learned.directions(own, i, free=False) for i in range(len(tests))]
    common = max([_COMMON] + [float(np.sqrt(np.mean(g**2)) * np.sqrt(g.shape[1])) for g in unsure if g.size])
    given = sorted_out({"search": None, "progress": False} | dict(options))
    search = given["search"] or SearchOptions()
    if "std_common" not in search.given:
        given["search"] = search.joined({"std_common": min(common, 0.1)})
    return assess_damage(by, set_of(now), baseline=set_of(baseline), **given)


# -- What may be given to the watch: a series or sets, its baseline, conditions, options of damage

LEAST = 8  # fewer tests than this are no baseline
_ABSURD = 10.0  # so many times its range outside the baseline, a condition is an error of its logger


def _series_of(given: Any) -> Series:
    if isinstance(given, Series):
        return given
    if not isinstance(given, Sequence) or isinstance(given, str | Mapping):
        wanted = "a Series or a list of AntiresonanceSets"
        reject("series", type(given).__name__, wanted, "Put them in a list.")
    return Series.from_sets(list(given))


def _baseline_tests(given: Any, series: Series) -> NDArray[np.intp]:
    """Indices of the baseline's tests that have a set."""
    n, chosen = len(series), given
    wanted = f"a slice, a number of first tests, indices or a mask of the {n} tests"
    if isinstance(given, int | np.integer) and not isinstance(given, bool):
        chosen = slice(0, int(given)) if 0 < given <= n else None
    try:
        if chosen is None or isinstance(chosen, bool | np.bool_):
            raise TypeError
        chosen = np.unique(np.arange(n)[chosen if isinstance(chosen, slice) else np.asarray(chosen)])
    except (IndexError, TypeError, ValueError):
        reject("baseline", given, wanted, f"As in baseline=slice(0, 100); a number is from {LEAST} to {n}.")
    sound = np.array([i for i in chosen.tolist() if i not in series.failed], dtype=np.intp)
    if sound.size < LEAST:
        wanted = f"at least {LEAST}, from which limits can be learned"
        remedy = "Take more tests of the intact structure; a rate of 1 % wants 50."
        got = f"{sound.size} tests with antiresonances"
        if sound.size < chosen.size:
            first = next(i for i in chosen.tolist() if i in series.failed)
            why = series.failed[first]
            got = f"{chosen.size - sound.size} of {chosen.size} tests that failed, the first: {why}"
        reject("baseline", got, wanted, remedy)
    return sound


def _is_clock(column: FloatArray) -> bool:
    """Whether it only counts the tests: a line over time would take damage that grows for weather."""
    known = column[~np.isnan(column)]
    if known.size <= 2 or known[0] == known[-1]:
        return False
    return bool(np.all(np.diff(known) * np.sign(known[-1] - known[0]) >= 0.0))


def _believed(column: FloatArray, baseline: NDArray[np.intp]) -> FloatArray:
    """A condition without what no weather makes, NaN there."""
    own = column[baseline][~np.isnan(column[baseline])]
    if not own.size or own.min() == own.max():
        return column
    reach = _ABSURD * (own.max() - own.min())
    return np.where((column < own.min() - reach) | (column > own.max() + reach), np.nan, column)


def _check_judge(model: Any, assessor: Any, one: AntiresonanceSet, options: Mapping[str, Any]) -> None:
    """Refuse what cannot assess damage, and options that have no effect: now, not at the first alarm."""
    if model is not None and not isinstance(model, StructuralModel):
        wanted = "a MassSpringChain, FrameModel or MatrixModel"
        reject("model", model, wanted, "Leave it out to have alarms only.")
    if assessor is not None and not isinstance(assessor, Assessor):
        reject("assessor", assessor, "an Assessor", "Load it first: Assessor.load(path).")
    if (options and model is None) or (model is not None and assessor is not None):
        name = next(iter(options), "model")
        reject(name, "it without a model, or beside an assessor", "it with a model alone", "Leave one out.")
    known = {*signature(assess_damage).parameters, *SearchOptions.declared()}
    if unknown := next((name for name in options if name not in known), None):
        wanted = f"one of assess_damage: {', '.join(sorted(known))}"
        reject(unknown, "an unknown option", wanted, "Look for a typo.")
    if model is not None and (options.get("elements") is not None or model.default_elements):
        UpdatingProblem(model, stiffness_reduction(elements_of(model, options.get("elements"))), [one])
    if assessor is not None:
        own = {each.excitation: tuple(each) for each in assessor.baseline}
        if not set(own.get(one.excitation, ())) & set(one):
            wanted = f"one for the force at {one.excitation!r} and dofs of these tests, {tuple(one)}"
            sees = (f"the force at {at!r} and the dofs {dofs}" for at, dofs in own.items())
            reject("assessor", f"one for {', '.join(sees)}", wanted, "Make it from some of their baseline.")


_FEWEST = 6  # places that so many tests of the baseline have are followed, at least
_USUAL_W = 1.645  # without a response at fault, a test is no further out than one of twenty
_MOST_FAULTS = 0.5  # a test of which more responses are at fault is not judged


@patient("watching the series")
def monitor(
    series: Series | Sequence[AntiresonanceSet | None],
    baseline: Any,
    false_alarm_rate: float = 0.01,
    *,
    conditions: Any = None,
    model: StructuralModel | None = None,
    assessor: Assessor | None = None,
    max_shift: float = MAX_SHIFT,
    progress: bool | None = None,
    **assessment: Any,
) -> Watched:
    """Tell which tests differ from the baseline, at a stated rate of false alarms.

    Parameters
    ----------
    series : Series or list of AntiresonanceSet
        Tests of one structure in their order; None where a test failed.
    baseline : slice, int, sequence of int or mask
        The tests of the intact structure, under all conditions that are to come; an int: the first so many.
    false_alarm_rate : float
        Share of intact tests outside the baseline that alarm, all charts together, at most about, in
        (0, 0.2].
    conditions : mapping of str to (n,), table or path, optional
        What the antiresonances depend on, such as the temperature, as for
        :func:`~antires_rs.identify_series`; by default those of the series. With ``{}``, for none, what the
        baseline's values do together is taken for weather.
    model, assessor : MassSpringChain, FrameModel or MatrixModel; Assessor, optional
        With one of them the damage of each run of alarms is assessed against the baseline, see
        ``.assessments``; an assessor, of the same sensors, is much faster.
    max_shift, progress : float and bool, optional
        Largest relative difference of a value from the baseline's, beside what all do; as of ``update``.
    **assessment
        Options of :func:`~antires_rs.assess_damage`: ``elements``, ``prior``, ``search``, ...

    Returns
    -------
    Watched

    Raises
    ------
    InvalidInputError
        Fewer than 8 baseline tests, none with antiresonances in common, or a malformed argument.

    Notes
    -----
    Hotelling's :math:`T^2` of single tests, an exponentially weighted mean for small and slow changes, and a
    chart of antiresonances that vanish or appear share the rate as 3 : 1 : 1; it holds for tests that are
    independent, given their conditions. When a change is over, alarms end. Limits come from tests of the
    baseline left out in turn. A test that shows none of the antiresonances cannot be judged.

    A condition that only grows or falls from test to test is a clock and not used. Outside the baseline's
    range lines go on with a slope known to 30 %; beyond ten times that range a value counts as not known.

    Examples
    --------
    >>> import antires_rs as ar
    >>> import numpy as np
    >>> rng = np.random.default_rng(0)
    >>> def test(loss):
    ...     chain = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 500.0 * (1 - loss), 500.0])
    ...     exact = enumerate(chain.antiresonances([0, 1, 2, 3], 0))
    ...     return ar.AntiresonanceSet(0, {dof: f * rng.normal(1.0, 5e-4, f.size) for dof, f in exact})
    >>> watched = ar.monitor([test(0.0) for _ in range(60)] + [test(0.02)], baseline=slice(0, 50))
    >>> bool(watched.alarm[60]), int(watched.alarm[50:60].sum())
    (True, 0)
    """
    tests = _series_of(series)
    rate = finite_scalar("false_alarm_rate", false_alarm_rate, low=0.0, high=0.2, low_open=True)
    shift = within("max_shift", max_shift)
    own = _baseline_tests(baseline, tests)
    sets = list(tests.sets)
    first = next(one for one in sets if one is not None)
    _check_judge(model, assessor, first, assessment)
    given: Mapping[str, FloatArray] = tests.conditions
    if conditions is not None:
        given, _ = condition_table(conditions)[0].in_order(tests.names)
    clocks = tuple(name for name, column in given.items() if _is_clock(column))
    used = {name: _believed(column, own) for name, column in given.items() if name not in clocks}
    step("matching antiresonances")
    places = places_of([one for i in own.tolist() if (one := sets[i]) is not None], shift)
    values = values_of(sets, places, shift)
    faults = obvious(sets, values, places, own.tolist())
    for here in faults.values():  # where most responses are at fault, none can be judged
        if len(here) > _MOST_FAULTS * len(places.dofs):
            known = {fault.dof for fault in here}
            left = [dof for dof in places.dofs if dof not in known]
            here += [Fault(dof, "most other responses are at fault") for dof in left]
    sound = values.without(faults, places)
    regular = places.regular & (np.sum(~np.isnan(sound.log_hz[own]), axis=0) >= _FEWEST)
    if not regular.any():
        got = f"no antiresonance that half of its {own.size} tests have"
        remedy = "Look at ar.track(sets) to see what comes and goes."
        reject("baseline", got, "antiresonances in common", remedy)
    step("charts")
    charts = charts_of(sound, regular, own, used, rate)
    if more := _lost(charts, sound, regular, places):
        for i, fault in more.items():
            faults.setdefault(i, []).append(fault)
        sound = values.without(faults, places)
        charts = charts_of(sound, regular, own, used, rate)
    # Without any value at a place there is nothing to judge, unless what vanished or appeared alarms.
    judged = ~np.isnan(charts.charts["T2"].statistic) | (charts.charts["events"].ratio > 1.0)
    statistic = np.where(judged, np.max([chart.ratio for chart in charts.charts.values()], axis=0), np.nan)
    alarm = judged & (np.nan_to_num(statistic) > 1.0)
    at = np.flatnonzero(alarm)  # Runs of alarms, which tests that could not be judged do not end.
    gaps = np.flatnonzero(np.diff(np.cumsum(judged)[at]) > _QUIET + 1)
    runs = [(int(run[0]), int(run[-1])) for run in np.split(at, gaps + 1) if run.size]
    learned, assessments = charts.learned, {}
    by = model if assessor is None else assessor
    for run in runs:
        if by is not None and run[1] not in own:
            step(f"assessing test {run[0]}")
            assessments[run[0]] = _assessed(by, run, learned, sound, places, first, used, assessment)
    enough = needed(rate, learned.basis.size)
    if own.size < enough:
        text = f"monitor: a baseline of {own.size} tests is short for {100 * rate:g} % false alarms; with "
        warn("short_baseline", f"{text}{enough} the limits can be relied on.")
    expected = np.exp(learned.expected(used, len(tests)))
    return Watched(
        alarm=frozen(alarm),
        statistic=frozen(statistic),
        charts=FrozenDict(charts.charts),
        false_alarm_rate=rate,
        baseline=frozen(own),
        names=tests.names,
        times=tests.times,
        conditions=FrozenDict(given),
        used=tuple(one.name for one in learned.basis.columns),
        bends=FrozenDict({one.name: one.bend for one in learned.basis.columns if one.bend is not None}),
        clocks=clocks,
        outside=frozen(learned.outside(given, len(tests))),
        faults=FrozenDict({i: tuple(here) for i, here in sorted(faults.items())}),
        failed=tests.failed,
        runs=tuple(runs),
        assessments=FrozenDict({i: found for i, found in assessments.items() if found is not None}),
        needed=enough,
        dof=frozen(places.dof[regular]),
        freq_hz=frozen(np.exp(sound.log_hz[:, regular])),
        expected_hz=frozen(expected),
        std_hz=frozen(expected * learned.deviation(sound.std[:, regular], used)),
    )


def _lost(charts: Charts, values: Values, regular: Any, places: Places) -> dict[int, Fault]:
    """Alarms that one response explains which has lost its antiresonances."""
    found = {}
    single = np.maximum(charts.charts["T2"].ratio, charts.charts["events"].ratio)
    dof = places.dof[regular]
    for i in np.flatnonzero(single > 1.0).tolist():
        without = {}
        for one in dict.fromkeys(dof.tolist()):
            rest = np.where(rows_with(dof, one), np.nan, charts.z[i])
            if count := np.sum(~np.isnan(rest)):
                t2 = np.array([charts.inverses.t2(rest)])
                without[one] = float(wilson_hilferty(t2, np.array([float(count)]))[0])
        fault = lost_alone(values, places, i, without, _USUAL_W)
        if fault is not None:
            found[i] = fault
    return found
