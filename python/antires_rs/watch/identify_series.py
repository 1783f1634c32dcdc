"""Many records to one series: each identified, kept as it is made, and taken up again after a stop."""

from __future__ import annotations

import json
import re
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from os import PathLike
from pathlib import Path
from time import monotonic
from typing import Any, TypeVar

import numpy as np

from ..exceptions import InvalidInputError, MissingDependencyError, reject
from ..identification.options import declared, flat
from ..measured.response_table import label
from ..support.checks import frequency_band
from ..support.messages import warn
from ..support.progress import span, step, waiting
from ..support.workers import Failed, in_order
from .conditions import ConditionTable, condition_table, of_source
from .series import Series
from .sources import (
    Instructions,
    Outcome,
    Sources,
    checked_reading,
    fingerprint,
    identified,
    listed,
    loaded,
    why_not,
)
from .store import Store
from .stored_tests import Entry, Row, parts_of

# -- The sources of a series computed, by whatever workers, in their order

Task = TypeVar("Task")
Read = TypeVar("Read")


def read_ahead(read: Callable[[Task], Read], tasks: Iterable[Task]) -> Iterator[Read]:
    """``read(task)`` of every task in order, the next one read by a thread meanwhile.

    Tasks are taken in the caller's thread, since a generator of theirs may be anything.

    Examples
    --------
    >>> from antires_rs.watch.identify_series import read_ahead
    >>> list(read_ahead(len, ["a", "bc"]))
    [1, 2]
    """
    pool = ThreadPoolExecutor(1)
    before: Future[Read] | None = None
    try:
        for task in tasks:
            coming = pool.submit(read, task)
            del task  # or it would be held while the next one is waited for
            if before is not None:
                yield before.result()
            before = coming
        if before is not None:
            yield before.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def computed(instructions: Instructions, tasks: Iterable[Any], workers: Any) -> Iterator[Outcome]:
    """The outcome of each source.

    In this process the next one is read while one is computed, and each is given as soon as it is there.
    Workers read files themselves, a second's worth of tests at a time.
    """
    if workers is None or (type(workers) is int and workers == 1):
        for signal in read_ahead(partial(loaded, instructions), tasks):
            yield identified(instructions, signal)
        return
    for outcome in in_order(identified, tasks, workers, shared=instructions, errors="return"):
        if not isinstance(outcome, Failed):
            yield outcome
            continue
        of_all = isinstance(outcome.error, MissingDependencyError | MemoryError | InvalidInputError)
        if of_all or not isinstance(outcome.error, Exception):
            raise outcome.error
        yield why_not(outcome.error)  # a test failed together with its worker


def identify_series(
    sources: Any,
    *,
    excitation: Any,
    band_hz: Sequence[float],
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
        A folder, whose measurements are taken by their names (``test_2`` before ``test_10``), a pattern such
        as ``"year/*.uff"``, or a list or generator of: files, folders of one FRF a file, Recordings,
        FrequencyResponses, functions without arguments that give one, and lists of these, which are repeats
        of one test. A mapping gives them names; so does a tuple ``(name, source)``. A tuple
        ``(name, source, conditions)`` also says what was measured beside.
    excitation, band_hz
        As for :func:`~antires_rs.identify_antiresonances`.
    conditions : mapping, DataFrame, structured array, list of dicts or path, optional
        What was measured beside the tests (a CSV or Parquet file, or the table itself): columns of numbers, a
        row a test in the order of the sources, or by the names of the tests in a column "name", "source" or
        "file". A column "time" or "date" gives the times.
    store : path, optional
        A file in which every result is kept as it is made: ``.sqlite``, or ``.parquet``, which needs the
        extra ``series``. Called again, a series goes on where it was stopped or killed, and takes in new
        sources. By default the results are kept in memory.
    workers : int, "processes", "threads" or executor, optional
        Who identifies them: by default this process. The results do not depend on it, bit for bit. Processes
        read files themselves; records in memory, and functions, are sent to them.
    reading : mapping or callable, optional
        Options of the reader of the files (:func:`~antires_rs.read_uff` and the others), such as ``dofs``,
        ``unit`` and ``fs_hz``; "format" names it where the ending does not. Or a function of a path that
        gives a Recording or a FrequencyResponse, for files of any other kind.
    progress : bool, optional
        A line on standard error with the rest time; by default on a terminal and in a notebook.
    **options
        Of :func:`~antires_rs.identify_antiresonances`, for all tests.

    Returns
    -------
    Series
        A set for each test, without its diagrams. A test that failed has none, and its reason is in
        ``.failed``: an unreadable file, unsuitable data, no antiresonance. Sensors that were dead all the
        time are left out of their test. After Ctrl-C the tests so far, with ``.interrupted``.

    Raises
    ------
    InvalidInputError
        A malformed argument, a path that does not exist, an option that no reader of the files has, sources
        with the same name, conditions that do not fit the sources, or a store of other options or sources.
    MissingDependencyError
        A package that the store or a reader needs is not installed.

    Warns
    -----
    AntiresWarning
        Sources that have changed since they were identified, and are identified again; columns of conditions
        that are no numbers.

    Notes
    -----
    Memory does not grow with the records: at most two are held in this process, and a result is some
    kilobytes. What the data check says of a test is ``series[i].data_check``, without its curves; its
    warnings are not raised.

    An exception that ends a series, one of a generator of sources or of conditions that do not fit, has the
    tests so far as ``error.series``.

    A store ``.parquet`` that runs has its results in ``<store>.part`` beside it, a database of SQLite. What
    was done is recognised by the name of the source and its content (of long files: size and three parts).
    Whether it was killed or not, and how often, the Parquet file is the same byte for byte.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> tests = (case.experiment(noise=0.01, duration_s=32.0, rng=seed) for seed in range(3))
    >>> series = ar.identify_series(
    ...     tests, excitation=0, band_hz=(3, 130), conditions={"temperature_c": [18.0, 21.5, 19.0]}
    ... )
    >>> print(series)
    series of 3 tests, force at 0, 8 responses
      identified     3, with 28 antiresonances
      temperature_c  18 to 21.5
    >>> series.tracks("temperature_c").freq_hz.shape
    (3, 28)
    """
    excitation = label("excitation", excitation)
    band = frequency_band("band_hz", band_hz, low_hz=0.0, high_hz=np.inf)
    chosen = _checked(options)
    table, beside = condition_table(conditions)
    found = listed(sources, beside)
    table.expect(found.count)
    read = checked_reading(reading, found.files)
    given = {"excitation": excitation, "band_hz": band, **chosen}
    config = json.loads(json.dumps(given | {"reading": read}, default=_plain))
    opened = Store(store, config)
    run = _Run(found, table, opened)
    try:
        with waiting("identifying a series", progress):
            interrupted = run.carried_out(Instructions(read, given), workers)
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
    if opened.changed:
        text = f"store: {len(opened.changed)} sources have changed since they were identified and were "
        warn("changed_sources", text + f"identified again, the first is {opened.changed[0]!r}.")
    return Series(**parts_of(rows), interrupted=interrupted)


class _Run:
    """One pass over the sources."""

    def __init__(self, sources: Sources, table: ConditionTable, store: Store) -> None:
        self._sources, self._table, self._store = sources, table, store
        self._rows: list[Row | None] = []
        #: What is being computed, by its number.
        self._pending: deque[tuple[int, Entry]] = deque()
        self._failed = 0

    @property
    def rows(self) -> list[Row]:
        """The tests that are through, in the order of the sources."""
        return [row for row in self._rows if row is not None]

    def carried_out(self, instructions: Instructions, workers: Any) -> bool:
        """Identify what is not known yet; returns whether Ctrl-C came."""
        start, done = monotonic(), 0
        try:
            for outcome in computed(instructions, self._tasks(), workers):
                number, entry = self._pending.popleft()
                row = self._rows[number] = self._store.keep(entry, outcome)
                self._failed += row.failed is not None
                done += 1
                step(_progress(number + 1, self._sources.count, self._failed, monotonic() - start, done))
        except KeyboardInterrupt:
            return True
        if not self._rows:
            reject("sources", "no source at all", "one test or more", "Look at what gives them.")
        return False

    def _tasks(self) -> Iterator[Any]:
        for number, source in enumerate(self._sources.each):
            conditions, time = self._table.at(number, source.name)
            own, own_time = of_source(number, source.conditions)
            conditions, time = conditions | own, time if own_time is None else own_time
            content = "" if self._store.path is None else fingerprint(source.given)
            row = self._store.known(source.name, content)
            self._rows.append(None if row is None else replace(row, conditions=conditions, time=time))
            if row is None:
                self._pending.append((number, Entry(source.name, conditions, time, content)))
                yield source.given
            else:
                self._failed += row.failed is not None


def _progress(at: int, count: int | None, failed: int, seconds: float, done: int) -> str:
    """How far it is, and how long the rest takes at this pace."""
    text = f"test {at:,}" + ("" if count is None else f" of {count:,}")
    text += f", {failed:,} failed" if failed else ""
    if count is None or at >= count:
        return text
    return f"{text}, about {span((count - at) * seconds / done)} left"


def _checked(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options of the identification that are not the default; a wrong one is not kept as a failed test."""
    for name in options:
        if name not in {*declared(), "dofs", "fit", "second_opinion"}:
            raise TypeError(f"identify_series() got an unexpected keyword argument {name!r}")
    chosen = flat(options)
    dofs = chosen.pop("dofs", None)
    if dofs is None:
        return chosen
    return chosen | {"dofs": list(dofs) if isinstance(dofs, Iterable) and not isinstance(dofs, str) else dofs}


def _plain(value: Any) -> Any:
    """What JSON does not know, for the record of the options."""
    if hasattr(value, "tolist"):
        return value.tolist()
    # A function by its name, other objects by their texts, without an address: it is another one every time.
    return getattr(value, "__qualname__", None) or re.sub(r" at 0x[0-9a-fA-F]+", "", repr(value))
