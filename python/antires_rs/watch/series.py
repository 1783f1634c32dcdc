"""Many tests of one structure, in order."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from pathlib import Path
from typing import Any, Self, overload

import numpy as np
from numpy.typing import NDArray

from ..exceptions import part, reject
from ..io.data_frames import frame_of, rows_of
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.compare import Comparison, compare
from ..measured.matching import MAX_SHIFT
from ..measured.response_table import ResponseTable
from ..measured.track import Tracks, followed
from ..support.checks import FloatArray, forces_at
from ..support.messages import keywords_left
from ..support.values import FrozenDict, ReadOnly, frozen
from .conditions import checked_names, condition_table
from .store import read_series, write_series
from .stored_tests import Entry, Row, StoredSets, encoded, parts_of

NO_SET = "no set was given"  # the reason of a test that was given as None
REASONS, LONG = 3, 90  # so many reasons are printed, cut to this length; the others are counted
MOST = 0.5  # part of the tests that must have an antiresonance that their average has


def _read_through(sets: Sequence[AntiresonanceSet | None]) -> tuple[Any, tuple[Any, ...]]:
    """Excitation and responses of sets that nothing is known of."""
    if not len(sets):
        reject("sets", "none", "one test or more", "Give the sets.")
    there = {i: one for i, one in enumerate(sets) if one is not None}
    excitation: Any = None
    for i, one in there.items():
        if not isinstance(one, AntiresonanceSet):
            wanted, remedy = "an AntiresonanceSet or None", "Identify the record first."
            reject(part("sets", i), type(one).__name__, wanted, remedy)
        if excitation not in (None, one.excitation):
            got, wanted = f"a set of force at {one.excitation!r}", f"that of the others, {excitation!r}"
            reject(part("sets", i), got, wanted, "Make a series for each excitation.")
        excitation = one.excitation
    return excitation, tuple(dict.fromkeys(dof for one in there.values() for dof in one))


def _chosen(at: Any, count: int) -> int | NDArray[np.intp]:
    """The index of one test, or those of some, by an index, a slice, indices or a mask."""
    asked: Any = at if isinstance(at, slice) else np.asarray(at if np.size(at) else np.empty(0, int))
    whole = isinstance(asked, np.ndarray) and asked.dtype.kind in "iu"
    if whole and np.any((asked < -count) | (asked >= count)):
        raise IndexError(f"test {at} of a series of {count}, which are counted from 0")
    try:
        found: NDArray[np.intp] = np.arange(count)[asked]
        if found.ndim == 0:
            return int(found)
        if found.ndim != 1 or len(np.unique(found)) < len(found):
            raise IndexError("a test more than once")
    except IndexError as exc:
        wanted = "an index, a slice, a list of distinct indices, or a mask with a truth value for each test"
        reject("series[...]", f"{at!r} ({exc})", wanted, "As in series[3], series[:100] or series[mask].")
    return found


@dataclass(frozen=True, eq=False, repr=False)
class Series(ReadOnly):
    """Antiresonances of many tests of one structure under one force, with what was measured beside them.

    A sequence of :class:`~antires_rs.AntiresonanceSet`, None where a test failed: ``series[3]`` is one of
    them, ``series[10:20]`` and ``series[series.conditions["temperature_c"] < 0]`` are series.
    :func:`~antires_rs.identify_series` makes one of records, :meth:`from_sets` of sets.

    Attributes
    ----------
    sets : sequence of AntiresonanceSet or None
        Without diagrams.
    names, times : tuple of str, (n,) datetime64 or None
        Of the tests: such as the names of their files, and when each was made, where that is known.
    conditions, failed : dict of str to (n,), and dict of int to str
        What was measured beside, NaN where not known; why a test has no set, by its index.
    excitation, dofs, interrupted : int, str or None, tuple and bool
        The dof of the force, None without any set; all responses of all sets; whether the series was stopped
        before its last test.

    Examples
    --------
    >>> import antires_rs as ar
    >>> sets = [ar.AntiresonanceSet(0, {0: [8.7, f]}) for f in (23.9, 23.8)] + [None]
    >>> series = ar.Series.from_sets(sets, conditions={"temperature_c": [21.0, 24.5, 19.0]})
    >>> len(series), series.failed, series[1][0].tolist(), series[:2].conditions["temperature_c"].tolist()
    (3, {2: 'no set was given'}, [8.7, 23.8], [21.0, 24.5])
    >>> print(series)
    series of 3 tests, force at 0, 1 response
      identified     2, with 2 antiresonances
      failed         1: no set was given
      temperature_c  19 to 24.5
    """

    sets: Sequence[AntiresonanceSet | None]
    _: KW_ONLY
    names: tuple[str, ...]
    conditions: Mapping[str, FloatArray]
    times: NDArray[np.datetime64] | None
    failed: Mapping[int, str]
    excitation: Any
    dofs: tuple[Any, ...]
    interrupted: bool = False

    def __post_init__(self) -> None:
        columns = {name: frozen(np.array(own, dtype=np.float64)) for name, own in self.conditions.items()}
        self._fill(conditions=FrozenDict(columns), failed=FrozenDict(sorted(self.failed.items())))
        self._fill(names=tuple(self.names), times=None if self.times is None else frozen(self.times))

    def __iter__(self) -> Iterator[AntiresonanceSet | None]:
        return iter(self.sets)

    def __len__(self) -> int:
        return len(self.sets)

    def __eq__(self, other: object) -> bool:
        """Same tests in the same order: names, conditions, times, reasons and sets, bit for bit."""
        if not isinstance(other, Series):
            return NotImplemented
        one, two = (
            dict(each.conditions) | ({} if each.times is None else {"times": each.times})
            for each in (self, other)
        )
        return (
            (self.names, self.failed, one.keys()) == (other.names, other.failed, two.keys())
            and all(np.array_equal(column, two[name], equal_nan=True) for name, column in one.items())
            and all(a == b for a, b in zip(self, other, strict=True))
        )

    __hash__ = None  # type: ignore[assignment]

    @classmethod
    @keywords_left(times="give them as conditions={'time': ...}", failed="a test that failed is None")
    def from_sets(
        cls,
        sets: Sequence[AntiresonanceSet | None],
        conditions: Any = None,
        names: Sequence[str] | None = None,
    ) -> Self:
        """A series of sets that are there, all of one excitation; None for a test without a result.

        ``conditions`` are as for :func:`~antires_rs.identify_series`, when each test was made with them as
        "time"; ``names`` by default the numbers of the tests. No test, several excitations, or columns of
        another length are an ``InvalidInputError``.
        """
        if not isinstance(sets, Sequence) or isinstance(sets, str | Mapping):
            reject("sets", type(sets).__name__, "a list of sets", "Put the sets in a list.")
        excitation, dofs = _read_through(sets)
        table, _ = condition_table(conditions)
        if names is None and table.names is not None and len(table.names) == len(sets):
            names = table.names
        called = checked_names(names, len(sets))
        columns, dated = table.in_order(called)
        failed = {i: NO_SET for i, one in enumerate(sets) if one is None}
        more: dict[str, Any] = {"failed": failed, "excitation": excitation, "dofs": dofs}
        return cls(tuple(sets), names=called, conditions=columns, times=dated, **more)

    def tracks(
        self, conditions: Any = None, *, max_shift: float = MAX_SHIFT, std_between: float = 0.0
    ) -> Tracks:
        """Every antiresonance followed over the tests that have a set, a row each, as by ``ar.track``.

        ``conditions`` is the name of one, "times", "names", or what differs from test to test (n,), the
        indices of the tests by default. An unknown one, or fewer than two sets, is an ``InvalidInputError``.
        """
        kept = [(i, one) for i, one in enumerate(self.sets) if one is not None]
        labels: Any = range(len(self)) if conditions is None else conditions
        if isinstance(conditions, str):
            known: dict[str, Any] = {"names": self.names, **self.conditions}
            known |= {} if self.times is None else {"times": np.datetime_as_string(self.times)}
            if conditions not in known:
                wanted, remedy = f"one of {tuple(known)}", "Name a condition of the series."
                reject("conditions", conditions, wanted, remedy)
            labels = known[conditions]
        if len(labels) != len(self):
            wanted = f"{len(self)}, one for each test"
            reject("conditions", f"{len(labels)} of them", wanted, "Give those of failed tests too.")
        sets, named = [one for _, one in kept], [labels[i] for i, _ in kept]
        return followed(sets, named, self.dofs, max_shift, std_between)

    def average(self, *, max_shift: float = MAX_SHIFT) -> AntiresonanceSet:
        """One set that stands for all tests, two or more, if nothing changed between them.

        Its frequencies are the means of the tracks that at least half of the tests have, with their standard
        deviations. ``ar.compare`` of two series compares their averages.
        """
        tracks = self.tracks(max_shift=max_shift)
        count = np.sum(~np.isnan(tracks.freq_hz), axis=0)
        tables = {}
        for dof in self.dofs:
            own = tracks.of(dof)
            own = own[count[own] >= max(MOST * count[own].max(initial=0), 2)]
            n, freq = count[own], tracks.freq_hz[:, own]
            mean, std = (np.nanmean(freq, axis=0), np.nanstd(freq, axis=0, ddof=1)) if own.size else (n, n)
            scores = {"averages": n.astype(np.float64)}
            tables[dof] = ResponseTable(mean, std_hz=std / np.sqrt(n), scores=scores)
        return AntiresonanceSet.from_tables(self.excitation, tables)

    def compare(self, i: int, j: int, **options: Any) -> Comparison:
        """Two tests that have a set compared; options as for :func:`~antires_rs.compare`."""
        return compare(self._set("i", i), self._set("j", j), **options)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all of it into one file, whole or not at all; see :meth:`load`.

        One that ends in ``.sqlite`` is a database, in ``.csv`` a table of text, which cannot be loaded again;
        else it is the same table as Parquet, which needs pyarrow.
        """
        rows = []
        for i, one in enumerate(self.sets):
            conditions = {name: float(column[i]) for name, column in self.conditions.items()}
            entry = Entry(self.names[i], conditions, None if self.times is None else self.times[i], "")
            rows.append(Row.packed(entry, self.failed[i] if one is None else encoded(one)))
        write_series(Path(path), rows)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """A series out of what :meth:`save` wrote, or the ``store`` of :func:`~antires_rs.identify_series`.

        Its sets are read when they are asked for; of a store that runs, or was stopped, these are the tests
        so far. A file of another kind, or of a newer version, is an ``InvalidInputError``.
        """
        rows, unfinished = read_series(Path(path))
        return cls(**parts_of(rows), interrupted=unfinished)

    def to_dataframe(self) -> Any:
        """A ``pandas.DataFrame``, a row an antiresonance: test, name, time, conditions, columns of a set."""
        times = {} if self.times is None else {"time": self.times}
        names: dict[str, None] = dict.fromkeys(("test", "name", *times, *self.conditions))
        rows: list[dict[str, Any]] = []
        for i, found in enumerate(self):
            if found is not None:
                beside = {"test": i, "name": self.names[i]} | {name: time[i] for name, time in times.items()}
                beside |= {name: float(column[i]) for name, column in self.conditions.items()}
                columns, own = rows_of(found)
                names |= dict.fromkeys(columns)
                rows += [beside | row for row in own]
        return frame_of(rows, list(names))

    @overload
    def __getitem__(self, at: int) -> AntiresonanceSet | None: ...
    @overload
    def __getitem__(self, at: slice | Sequence[int] | NDArray[Any]) -> Series: ...
    def __getitem__(self, at: Any) -> Any:
        """The set of one test by its index, or a series of some: a slice, indices or a mask."""
        chosen = _chosen(at, len(self))
        if isinstance(chosen, int):
            return self.sets[chosen]
        rank, sets = {int(i): k for k, i in enumerate(chosen)}, self.sets
        return replace(
            self,
            sets=sets.take(rank) if isinstance(sets, StoredSets) else [sets[i] for i in rank],
            names=tuple(self.names[i] for i in rank),
            conditions={name: column[chosen] for name, column in self.conditions.items()},
            times=None if self.times is None else self.times[chosen],
            failed={rank[i]: why for i, why in self.failed.items() if i in rank},
        )

    def __repr__(self) -> str:
        return f"Series({len(self)} tests, {len(self.failed)} failed, excitation={self.excitation!r})"

    def __str__(self) -> str:
        count, failed = len(self), len(self.failed)
        if isinstance(self.sets, StoredSets):  # without reading them
            sizes = {row.count for row in self.sets.rows if row.failed is None}
        else:
            sizes = {sum(map(len, one.tables.values())) for one in self if one is not None}
        ends = " to ".join(map(str, sorted({min(sizes, default=0), max(sizes, default=0)})))
        rows = [("identified", f"{count - failed}" + f", with {ends} antiresonances" * bool(sizes))]
        if failed:
            reasons = self.failed.values()
            whys = [why if len(why) <= LONG else why[: LONG - 3].rstrip() + "..." for why in reasons]
            ranked = Counter(whys).most_common()
            told = [f"{why} ({n} times)" if n > 1 else why for why, n in ranked[:REASONS]]
            if len(ranked) > REASONS:
                told.append(f"and {sum(n for _, n in ranked[REASONS:])} others, see .failed")
            rows.append(("failed", f"{failed}: {'; '.join(told)}"))
        columns: list[tuple[str, Any]] = [] if self.times is None else [("times", self.times)]
        for name, column in [*columns, *self.conditions.items()] if count else ():
            known = np.sort(column[column == column])
            missing = f", {count - known.size} not known" * (known.size < count)
            if not known.size:
                rows += [] if column is self.times else [(name, "not known")]
            elif column is self.times:
                first, last = np.datetime_as_string(known[[0, -1]], unit="m")
                rows.append((name, f"{first} to {last}{missing}"))
            else:
                rows.append((name, f"{known[0]:g} to {known[-1]:g}{missing}"))
        width = max(len(name) for name, _ in rows)
        title = f"series of {count:,} test{'s' * (count != 1)}"
        title += "" if self.excitation is None else f", {forces_at(self.excitation)}"
        title += f", {len(self.dofs):,} response{'s' * (len(self.dofs) != 1)}" if self.dofs else ""
        title += "; interrupted, more tests are to come" * self.interrupted
        return "\n".join([title, *(f"  {name:<{width}}  {text}" for name, text in rows)])

    def _set(self, name: str, at: int) -> AntiresonanceSet:
        if not -len(self) <= at < len(self):
            reject(name, at, f"a test of {len(self)}", "Tests are counted from 0.")
        found = self.sets[at]
        if found is None:
            why = self.failed[at % len(self)]
            reject(name, f"test {at}, which failed: {why}", "a test with a set", "Name another.")
        return found
