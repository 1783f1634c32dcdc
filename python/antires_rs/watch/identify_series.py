"""Many records to one series: identified or followed, kept as it is made, and taken up again after a stop."""

from __future__ import annotations

import json
import re
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, islice
from os import PathLike
from pathlib import Path
from time import monotonic
from typing import Any

import numpy as np

from ..exceptions import InvalidInputError, MissingDependencyError, reject
from ..identification.identify import of_same_force
from ..identification.options import declared, flat
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.response_table import ResponseTable
from ..signals.averaging import is_transient
from ..signals.recording import Recording
from ..support.checks import FloatArray, force_label, frequency_band, integer
from ..support.messages import unheard, warn
from ..support.progress import apart, span, step, waiting
from ..support.workers import Failed, in_order
from . import sources as one_test
from .association import places_in
from .conditions import ConditionTable, condition_table, of_source
from .series import Series
from .sources import Instructions, Outcome, Source, Sources, Unread
from .store import Store
from .stored_tests import Entry, Row, StoredSets, parts_of

# -- The sources of a series computed, by whatever workers, in their order


def _computed(instructions: Instructions, tasks: Iterable[Any], workers: Any) -> Iterator[Outcome]:
    """The outcome of each source; workers read files themselves, a second's worth of tests at a time."""
    given = None if type(workers) is int and workers == 1 else workers
    for outcome in in_order(one_test.identified, tasks, given, shared=instructions, errors="return"):
        if not isinstance(outcome, Failed):
            yield outcome
            continue
        of_all = isinstance(outcome.error, MissingDependencyError | MemoryError | InvalidInputError)
        if of_all or not isinstance(outcome.error, Exception):
            raise outcome.error
        yield one_test.why_not(outcome.error)  # a test failed together with its worker


# -- What is followed: values of the first tests together, with the scatter that they have from test to test

FIRST = 20  # so many of the first tests are identified together, where nothing else is asked for
LOCAL = ("directions", "followed")  # fits that tell single tests less than what is known already
RECURS = 0.7  # a value is followed if so large a part of these tests shows it,
PLACE = 0.03  # within this share of where most do


def _known_of(instructions: Instructions, sources: Sequence[Source]) -> AntiresonanceSet | str:
    """What the tests have together and most of them show, with the scatter of single tests; else why not."""
    with unheard(), apart():
        given = [one_test.loaded(instructions, one.given) for one in sources]
        read = [signal for signal in given if not isinstance(signal, Unread)]
        pooled = _together(read, instructions.options)
        if isinstance(pooled, str):
            return pooled
        options = {name: value for name, value in instructions.options.items() if name != "new_values"}
        sight: dict[str, Any] = {"sees": pooled.sees, "channels": pooled.channels}
        sight["options"] = pooled.options
        tests: list[AntiresonanceSet] = []
        for signal in read:
            one = one_test.tried(one_test.set_of, signal, {**options, "near": pooled})
            if isinstance(one, Unread):  # it is told with the other tests why it has no values
                continue
            if not tests:
                if all("followed" in table.scores["how"] for table in one.tables.values() if len(table)):
                    # No fit over the band predicts a test by itself.
                    sight["options"] = {**pooled.options, "fitted": "followed"}
                pooled = AntiresonanceSet.from_tables(pooled.excitation, pooled.tables, **sight)
            tests.append(one)
    if not tests:
        return "values that no test shows by itself"
    if len(tests) == 1:
        return pooled
    tables = {}
    for dof, table in pooled.tables.items():
        freq = np.full((len(tests), len(table)), np.nan)
        for row, one in zip(freq, tests, strict=True):
            if dof in one:
                row[one.followed[dof]] = one[dof]
        with np.errstate(invalid="ignore"):
            near = np.abs(freq / _middle(freq) - 1.0) < PLACE
        kept = np.sum(near, axis=0) >= max(2, RECURS * sum(dof in one for one in tests))
        middle = _middle(freq)[kept]
        scatter = 1.4826 * _middle(np.abs(freq[:, kept] - middle))
        tables[dof] = ResponseTable(middle, table.damping_ratio[kept], scatter, table.take(kept).scores)
    if not any(map(len, tables.values())):
        return "no value that most of them show"
    return AntiresonanceSet.from_tables(pooled.excitation, tables, **sight)


def _middle(values: FloatArray) -> FloatArray:
    """Median of each column without NaN; NaN where there is nothing else."""
    known = [own[~np.isnan(own)] for own in values.T]
    return np.array([np.median(own) if own.size else np.nan for own in known])


def _together(read: Sequence[Any], options: Mapping[str, Any]) -> AntiresonanceSet | str:
    """What records of the commonest kind have together, or why nothing."""
    parts: list[tuple[Any, Any]] = []
    for signal in read:
        for one in signal if isinstance(signal, list) else [signal]:
            kind = one_test.tried(_kind, one)
            parts += [] if isinstance(kind, Unread) else [(one, kind)]
    if not parts:
        return "no record that suits"
    common, count = Counter(kind for _, kind in parts).most_common(1)[0]
    if count == 1 < len(parts):
        return "no two records of the same dofs and sampling rate"
    same = [one for one, kind in parts if kind == common]
    if isinstance(same[0], Recording) and not is_transient(same[0]):
        # The segments of all are no longer than the shortest record.
        least = 0.5 * float(np.median([one.n_samples for one in same]))
        same = [one for one in same if one.n_samples >= least]

    def pooled(each: list[Any]) -> Any:
        return one_test.tried(one_test.set_of, each if len(each) > 1 else each[0], options)

    found = pooled(same)
    if isinstance(found, Unread) and found.unsuitable:  # one of them by itself may be the cause
        alone = [one_test.tried(one_test.set_of, one, options) for one in same]
        unfit = [isinstance(got, Unread) and got.unsuitable for got in alone]
        fit = [one for one, odd in zip(same, unfit, strict=True) if not odd]
        found = pooled(fit) if 0 < len(fit) < len(same) else found
    return str(found) if isinstance(found, Unread) else found


def _kind(signal: Any) -> tuple[Any, ...]:
    """What records that are pooled have in common."""
    dofs = frozenset(signal.dofs)
    if isinstance(signal, Recording):
        return dofs, frozenset(one_test.living(signal)[1]), signal.fs_hz, is_transient(signal)
    ends = (float(f"{freq:.9g}") for freq in signal.freq_hz[[0, -1]])
    return dofs, signal.kind, signal.reference, signal.n_freq, *ends


def identify_series(
    sources: Any,
    *,
    excitation: Any,
    band_hz: Sequence[float],
    near: AntiresonanceSet | int | None = None,
    conditions: Any = None,
    store: str | PathLike[str] | None = None,
    workers: Any = None,
    reading: Mapping[str, Any] | Callable[[Path], Any] | None = None,
    progress: bool | None = None,
    **options: Any,
) -> Series:
    """Identify the antiresonances of many tests of one structure, one record after the other.

    Parameters
    ----------
    sources : path, iterable or mapping
        A folder (``test_2`` before ``test_10``), a pattern such as ``"year/*.uff"``, or a list or generator
        of files, folders of one FRF a file, Recordings, FrequencyResponses, functions that give one, and
        lists of these, repeats of one test. A mapping, or tuples ``(name, source)``, name them;
        ``(name, source, conditions)`` also says what was measured beside.
    excitation, band_hz
        As for :func:`~antires_rs.identify_antiresonances`.
    near : AntiresonanceSet or int, optional
        Values that are followed in every test, or how many of the first tests are identified together for
        them; 0 for none: each test is identified by itself. Default: 20, or all if there are fewer, where the
        first is a record that one fit over the band does not predict; else 0.
    conditions : mapping, DataFrame or path, optional
        What was measured beside (a CSV or Parquet file, or the table): numbers, a row a test in the order of
        the sources, or by their names in a column "name". A column "time" gives the times.
    store : path, optional
        A file, ``.sqlite`` or (extra ``series``) ``.parquet``, in which every result is kept as it is made:
        called again, a series goes on where it was stopped or killed, and takes in new sources.
    workers : int, "processes", "threads" or executor, optional
        Who identifies them: by default this process. No bit depends on it.
    reading : mapping or callable, optional
        Options of the reader of the files, such as ``dofs``, ``unit`` and ``fs_hz``; "format" names it where
        the ending does not. Or a function of a path that gives a Recording or a FrequencyResponse.
    progress : bool, optional
        As of :func:`~antires_rs.update`.
    **options
        Of :func:`~antires_rs.identify_antiresonances`, for all tests.

    Returns
    -------
    Series
        A set for each test, without its diagrams; where values are followed, ``.followed`` and ``.not_seen``
        of each say which. A test that failed has none, and its reason is in ``.failed``. Dead sensors are
        left out of their test. After Ctrl-C the tests so far, with ``.interrupted``.

    Raises
    ------
    InvalidInputError, MissingDependencyError
        An argument, a path or an option of the readers that is wrong, sources with the same name, conditions
        that do not fit them, a store of other options or sources; a package that is not installed.

    Warns
    -----
    AntiresWarning
        Sources that have changed, and are identified again; columns of conditions that are no numbers.

    Notes
    -----
    Warnings of the data check are not raised, see ``series[i].data_check``. An exception that ends a series
    has the tests so far as ``error.series``. A store ``.parquet`` that runs has its results beside it, in
    ``<store>.part``; however often it was killed, the file is the same byte for byte. What was done is
    recognised by the name of the source and its content (of long files: size and three parts).

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> tests = (case.experiment(noise=0.01, duration_s=32.0, rng=seed) for seed in range(3))
    >>> beside = {"temperature_c": [18.0, 21.5, 19.0]}
    >>> print(ar.identify_series(tests, excitation=0, band_hz=(3, 130), conditions=beside))
    series of 3 tests, force at 0, 8 responses
      identified     3, with 28 antiresonances
      temperature_c  18 to 21.5
    """
    excitation = force_label("excitation", excitation)
    if isinstance(near, AntiresonanceSet):
        of_same_force(near, excitation)
    elif near is not None:
        if not isinstance(near, int | np.integer):
            wanted = "a set, whose values are followed, or an integer: how many of the first tests give them"
            reject("near", repr(near), wanted, "Leave it out, or give 0 for none.")
        near = integer("near", near, low=0)
    band = frequency_band("band_hz", band_hz, low_hz=0.0, high_hz=np.inf)
    chosen = _checked(options)
    table, beside = condition_table(conditions)
    found = one_test.listed(sources, beside)
    table.expect(found.count)
    read = one_test.checked_reading(reading, found.files)
    given = {"excitation": excitation, "band_hz": band, **chosen}
    followed = near.to_json() if isinstance(near, AntiresonanceSet) else near
    known = given | ({} if near is None else {"near": followed}) | {"reading": read}
    opened = Store(store, json.loads(json.dumps(known, default=_plain)))
    run = _Run(found, table, opened)
    try:
        with waiting("identifying a series", progress):
            interrupted = run.carried_out(Instructions(read, given), near, workers)
        rows: Sequence[Row] = run.rows
        if not interrupted:
            table.over(len(rows))
            rows = opened.finish(rows)
    except Exception as exc:
        if run.rows:  # hours of work, and without a store all there is of it
            exc.series = Series(**parts_of(run.rows), interrupted=True)  # type: ignore[attr-defined]
        raise
    finally:
        opened.close()
    if changed := list(dict.fromkeys(opened.changed)):
        text = f"store: {len(changed)} sources have changed since they were identified and were "
        warn("changed_sources", text + f"identified again, the first is {changed[0]!r}.")
    return Series(**parts_of(rows), interrupted=interrupted)


#: What was followed last, or why nothing, by what it was made of.
_KEPT: dict[str, AntiresonanceSet | str] = {}


class _Run:
    """One pass over the sources."""

    def __init__(self, sources: Sources, table: ConditionTable, store: Store) -> None:
        self._sources, self._table, self._store = sources, table, store
        self._rows: list[Row | None] = []
        self._pending: deque[tuple[int, Entry]] = deque()  # what is being computed, by its number
        self._failed = 0
        self._near: AntiresonanceSet | None = None

    @property
    def rows(self) -> list[Row]:
        """The tests that are through, in the order of the sources."""
        return [row for row in self._rows if row is not None]

    def carried_out(
        self, instructions: Instructions, near: AntiresonanceSet | int | None, workers: Any
    ) -> bool:
        """Identify what is not known yet; returns whether Ctrl-C came."""
        start, done = monotonic(), 0
        try:
            for outcome in self._outcomes(instructions, near, workers):
                number, entry = self._pending.popleft()
                row = self._rows[number] = self._store.keep(entry, outcome)
                self._failed += row.failed is not None
                done += 1
                at, count = number + 1, self._sources.count
                text = f"test {at:,}" + ("" if count is None else f" of {count:,}")
                text += f", {self._failed:,} failed" if self._failed else ""
                if count is not None and at < count:  # at this pace
                    text += f", about {span((count - at) * (monotonic() - start) / done)} left"
                step(text)
        except KeyboardInterrupt:
            return True
        if not self._rows:
            reject("sources", "no source at all", "one test or more", "Look at what gives them.")
        return False

    def _outcomes(
        self, instructions: Instructions, near: AntiresonanceSet | int | None, workers: Any
    ) -> Iterator[Outcome]:
        """What each source that is not known yet gives."""
        done: list[Outcome] = []
        if not isinstance(near, AntiresonanceSet):
            each, auto = iter(self._sources.each), near is None
            first = list(islice(each, near or 0))
            local = bool(first)
            try:
                while auto and len(first) < FIRST and (source := next(each, None)) is not None:
                    first.append(source)
                    row = self._store.known(source.name, self._content(source))
                    outcome: Outcome | None = None if row is None else row.failed or row.plain()
                    if outcome is None:
                        (outcome,) = _computed(instructions, [source.given], workers)
                        done.append(outcome)
                    if not isinstance(outcome, str):
                        local = outcome["facts"]["options"].get("fitted") in LOCAL
                        break
                if auto and local:
                    first += islice(each, FIRST - len(first))
            except (Exception, KeyboardInterrupt) as exc:
                each, local = _raised(exc), False  # behind the tests that are done
            self._sources = replace(self._sources, each=chain(first, each))
            known = self._known(instructions, first) if local else None
            if isinstance(known, str) and not auto:
                wanted = "tests that have antiresonances in common, identified together"
                reject("near", f"the first {len(first)}, with {known}", wanted, "Leave it out, or give 0.")
            near = known if isinstance(known, AntiresonanceSet) else None
        self._near, tasks = near, self._tasks()
        if near is not None:
            instructions = replace(instructions, options={**instructions.options, "near": near})
        else:
            for outcome, _ in zip(done, tasks, strict=False):  # the first, which are done
                yield outcome
        yield from _computed(instructions, tasks, workers)

    def _known(self, instructions: Instructions, first: Sequence[Source]) -> AntiresonanceSet | str:
        """What is followed, or why nothing; kept of the same files: a watch calls for each new one."""
        contents = [self._content(one) for one in first]
        key = json.dumps([contents, instructions.options], default=_plain)
        if not all(contents) or key not in _KEPT:
            _KEPT.clear()
            _KEPT[key] = _known_of(instructions, first)
        return _KEPT[key]

    def _content(self, source: Source) -> str:
        return "" if self._store.path is None else one_test.fingerprint(source.given)

    def _tasks(self) -> Iterator[Any]:
        for number, source in enumerate(self._sources.each):
            conditions, time = self._table.at(number, source.name)
            beside, own_time = of_source(number, source.conditions)
            conditions, time = conditions | beside, time if own_time is None else own_time
            content = self._content(source)
            row = self._store.known(source.name, content)
            if row is not None and row.failed is None and self._near is not None:
                own, near = StoredSets([row])[0], self._near
                same = all(np.isin(places_in(own, dof), near.get(dof, ())).all() for dof in own)
                row = row if same and own.followed else None  # of other values
            self._rows.append(None if row is None else replace(row, conditions=conditions, time=time))
            if row is None:
                self._pending.append((number, Entry(source.name, conditions, time, content)))
                yield source.given
            else:
                self._failed += row.failed is not None


def _raised(exc: BaseException) -> Iterator[Source]:
    raise exc
    yield


def _checked(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options of the identification that are not the default; a wrong one is not kept as a failed test."""
    for name in options:
        if name not in {*declared(), "dofs", "fit"}:
            raise TypeError(f"identify_series() got an unexpected keyword argument {name!r}")
    chosen = flat(options)
    dofs = chosen.pop("dofs", None)
    listed = isinstance(dofs, Iterable) and not isinstance(dofs, str)
    return chosen if dofs is None else chosen | {"dofs": list(dofs) if listed else dofs}


def _plain(value: Any) -> Any:
    """What JSON does not know, for the record of the options."""
    if hasattr(value, "tolist"):
        return value.tolist()
    # A function by its name, other objects by their texts, without an address: it is another one every time.
    return getattr(value, "__qualname__", None) or re.sub(r" at 0x[0-9a-fA-F]+", "", repr(value))
