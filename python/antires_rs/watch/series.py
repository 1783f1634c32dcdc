"""Many tests of one structure, in order."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
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
from ..support.checks import FloatArray
from ..support.values import FrozenDict, ReadOnly
from .conditions import checked_conditions, checked_names, checked_times, in_order
from .store import read_series, write_series
from .stored_tests import Row, StoredSets, encoded, parts_of

#: Reason of a test that was given as None.
NO_SET = "no set was given"


def _checked_failed(given: Any, sets: Sequence[AntiresonanceSet | None]) -> Mapping[int, str]:
    """Reasons by the index of a test that has no set."""
    wanted = "why a test has no set, by its index"
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        reject("failed", type(given).__name__, wanted, "As in failed={2: 'cable cut'}.")
    for i in given:
        if isinstance(i, bool) or not isinstance(i, int | np.integer) or not 0 <= i < len(sets):
            reject("failed", f"a test {i!r}", f"{wanted}, from 0 to {len(sets) - 1}", "Count from 0.")
        if sets[int(i)] is not None:
            reject("failed", f"test {i}, which has a set", wanted, "Give None in place of its set.")
    return {int(i): str(why) for i, why in given.items()}


def _read_through(
    sets: Sequence[AntiresonanceSet | None], failed: Mapping[int, str]
) -> tuple[Any, tuple[Any, ...], dict[int, str]]:
    """Excitation, responses and failed tests of sets that nothing is known of."""
    if not len(sets):
        reject("sets", "none", "one test or more", "Give the sets.")
    excitation: Any = None
    dofs: dict[Any, None] = {}
    told: dict[int, str] = {}
    for i, one in enumerate(sets):
        name = part("sets", i)
        if one is None:
            told[i] = failed.get(i, NO_SET)
            continue
        if not isinstance(one, AntiresonanceSet):
            reject(name, type(one).__name__, "an AntiresonanceSet or None", "Identify the record first.")
        if excitation is not None and one.excitation != excitation:
            got, wanted = f"a set of force at {one.excitation!r}", f"that of the others, {excitation!r}"
            reject(name, got, wanted, "Make a series for each excitation.")
        excitation = one.excitation
        dofs |= dict.fromkeys(one)
    return excitation, tuple(dofs), told


def _same(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    return one.keys() == other.keys() and all(
        a is b or (a is not None and b is not None and np.array_equal(a, b, equal_nan=True))
        for a, b in zip(one.values(), other.values(), strict=True)
    )


# -- Which tests of a series are meant by an index, a slice, indices or a mask


_WANTED = "an index, a slice, a list of indices, or a mask with a truth value for each test"


def one_or_some(at: Any, count: int) -> int | NDArray[np.intp]:
    """The index of one test, or those of some.

    Raises
    ------
    IndexError
        No such test.
    InvalidInputError
        Nothing that tests are named by, a mask of another length, or a test more than once.
    """
    if isinstance(at, slice):
        return np.arange(count)[at]
    if isinstance(at, int | np.integer) and not isinstance(at, bool):
        _there(int(at), count)
        return int(at)
    found = np.asarray(at) if np.size(at) else np.empty(0, int)
    if found.ndim != 1 or found.dtype.kind not in "biu":
        reject("series[...]", at, _WANTED, "As in series[3], series[:100] or series[temperature_c < 20].")
    if found.dtype.kind == "b":
        if len(found) != count:
            reject("series[...]", f"a mask of {len(found)}", f"one of {count}", "Make it of all tests.")
        return np.flatnonzero(found)
    for i in found.tolist():
        _there(i, count)
    found = found.astype(np.intp) % max(count, 1)
    if len(np.unique(found)) < len(found):
        reject("series[...]", "a test more than once", "each test once", "Use np.unique.")
    return found


def _there(at: int, count: int) -> None:
    if not -count <= at < count:
        raise IndexError(f"test {at} of a series of {count}, which are counted from 0")


# -- A series for pandas


def series_frame(series: Series) -> Any:
    """A pandas.DataFrame, one row an antiresonance; failed tests have none."""
    rows: list[dict[str, Any]] = []
    names: dict[str, None] = dict.fromkeys(("test", "name"))
    if series.times is not None:
        names["time"] = None
    names |= dict.fromkeys(series.conditions)
    for i, found in enumerate(series):
        if found is None:
            continue
        beside: dict[str, Any] = {"test": i, "name": series.names[i]}
        if series.times is not None:
            beside["time"] = series.times[i]
        beside |= {name: float(column[i]) for name, column in series.conditions.items()}
        columns, own = rows_of(found)
        names |= dict.fromkeys(columns)
        rows += [beside | row for row in own]
    return frame_of(rows, list(names))


# -- A series as text: how many tests, what failed and why, what was measured beside


#: So many reasons are told; the others are counted.
REASONS = 3
#: A reason longer than this is cut.
LONG = 90


def printed(series: Series) -> str:
    """One line for each fact."""
    count, failed = len(series), len(series.failed)
    rows = [("identified", f"{count - failed}{_antiresonances(series)}")]
    if failed:
        rows.append(("failed", f"{failed}: {_reasons(series)}"))
    if series.times is not None:
        known = series.times[~np.isnat(series.times)]
        if known.size:
            first, last = np.datetime_as_string(np.sort(known)[[0, -1]], unit="m")
            rows.append(("times", f"{first} to {last}{_missing(count - known.size)}"))
    for name, column in series.conditions.items() if count else ():
        values = column[~np.isnan(column)]
        span = f"{values.min():g} to {values.max():g}" if values.size else "not known"
        rows.append((name, span + _missing(count - values.size if values.size else 0)))
    width = max(len(name) for name, _ in rows)
    force = "" if series.excitation is None else f", force at {series.excitation}"
    dofs = f", {_counted(len(series.dofs), 'response')}" if series.dofs else ""
    title = f"series of {_counted(count, 'test')}{force}{dofs}"
    if series.interrupted:
        title += "; interrupted, more tests are to come"
    return "\n".join([title, *(f"  {name:<{width}}  {text}" for name, text in rows)])


def _counted(count: int, what: str) -> str:
    return f"{count:,} {what}{'' if count == 1 else 's'}"


def _missing(count: int) -> str:
    return f", {count} not known" if count else ""


def _antiresonances(series: Series) -> str:
    """How many each has; a file says so without its sets being read."""
    if isinstance(series.sets, StoredSets):
        counts = series.sets.counts
    else:
        counts = [sum(map(len, one.tables.values())) for one in series if one is not None]
    if not len(counts):
        return ""
    low, high = min(counts), max(counts)
    return f", with {low if low == high else f'{low} to {high}'} antiresonances"


def _reasons(series: Series) -> str:
    told = Counter(_short(why) for why in series.failed.values()).most_common()
    said = [f"{why} ({n} times)" if n > 1 else why for why, n in told[:REASONS]]
    more = sum(n for _, n in told[REASONS:])
    return "; ".join(said) + (f"; and {more} others, see .failed" if more else "")


def _short(why: str) -> str:
    return why if len(why) <= LONG else why[: LONG - 3].rstrip() + "..."


# -- One set that stands for many tests of an unchanged structure


#: Part of the tests that must have an antiresonance.
MOST = 0.5


def averaged(tracks: Tracks, dofs: tuple[object, ...]) -> AntiresonanceSet:
    """Mean of each track that most tests have, with the standard deviation of that mean."""
    freq = tracks.freq_hz
    count = np.sum(~np.isnan(freq), axis=0)
    tables = {}
    for dof in dofs:
        own = tracks.of(dof)
        own = own[count[own] >= max(MOST * count[own].max(initial=0), 2)]
        n = count[own]
        std = np.nanstd(freq[:, own], axis=0, ddof=1) / np.sqrt(n) if own.size else np.empty(0)
        mean = np.nanmean(freq[:, own], axis=0) if own.size else np.empty(0)
        tables[dof] = ResponseTable(mean, std_hz=std, scores={"averages": n.astype(np.float64)})
    return AntiresonanceSet.from_tables(tracks.excitation, tables)


class Series(ReadOnly):
    """Antiresonances of many tests of one structure under one force, with what was measured beside them.

    A sequence of :class:`~antires_rs.AntiresonanceSet` in the order of the tests, None where a test failed.
    ``series[3]`` is one of them, ``series[10:20]`` and ``series[series.conditions["temperature_c"] < 0]`` are
    series. :func:`~antires_rs.identify_series` makes one of records, :meth:`from_sets` of sets.

    Attributes
    ----------
    sets : sequence of AntiresonanceSet or None
        Without diagrams. Of a series in a file they are read when they are asked for.
    names : tuple of str
        Of the tests, such as the names of their files.
    times : (n,) datetime64 or None
        When each was made, where that is known.
    conditions : dict of str to (n,)
        What was measured beside, such as the temperature; NaN where not known.
    failed : dict of int to str
        Why a test has no set, by its index.
    excitation : int, str or None
        The dof of the force; None without any set.
    dofs : tuple
        All responses of all sets.
    interrupted : bool
        Whether the series was stopped before its last test.

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
    names: tuple[str, ...]
    times: NDArray[np.datetime64] | None
    conditions: Mapping[str, FloatArray]
    failed: Mapping[int, str]
    excitation: Any
    dofs: tuple[Any, ...]
    interrupted: bool

    def __init__(
        self,
        sets: Sequence[AntiresonanceSet | None],
        *,
        names: Any = None,
        conditions: Any = None,
        times: Any = None,
        failed: Mapping[int, str] | None = None,
        excitation: Any = None,
        dofs: tuple[Any, ...] | None = None,
        interrupted: bool = False,
    ) -> None:
        count = len(sets)
        if failed is None or dofs is None:
            failed = _checked_failed(failed, sets)
            excitation, dofs, failed = _read_through(sets, failed)
        self._fill(
            sets=sets,
            names=checked_names(names, count),
            conditions=checked_conditions(conditions, count),
            times=checked_times(times, count),
            failed=FrozenDict(sorted(failed.items())),
            excitation=excitation,
            dofs=dofs,
            interrupted=interrupted,
        )

    def __iter__(self) -> Iterator[AntiresonanceSet | None]:
        return iter(self.sets)

    def __len__(self) -> int:
        return len(self.sets)

    def __eq__(self, other: object) -> bool:
        """Same tests in the same order: names, conditions, times, reasons and sets, bit for bit."""
        if not isinstance(other, Series):
            return NotImplemented
        return (
            self.names == other.names
            and self.failed == other.failed
            and _same(dict(self.conditions), dict(other.conditions))
            and _same({"times": self.times}, {"times": other.times})
            and all(one == two for one, two in zip(self, other, strict=True))
        )

    __hash__ = None  # type: ignore[assignment]

    @classmethod
    def from_sets(
        cls,
        sets: Sequence[AntiresonanceSet | None],
        conditions: Any = None,
        names: Sequence[str] | None = None,
        *,
        times: Any = None,
        failed: Mapping[int, str] | None = None,
    ) -> Self:
        """A series of sets that are there.

        Parameters
        ----------
        sets : sequence of AntiresonanceSet or None
            In the order of the tests, all of one excitation; None for a test without a result.
        conditions : mapping of str to array_like, (n,), DataFrame, structured array, list of dicts, path
            What was measured beside; NaN where not known. A table may name and date the tests, as for
            :func:`~antires_rs.identify_series`.
        names : sequence of str, optional
            By default the numbers of the tests.
        times : array_like, (n,), optional
            When each was made: datetime64, datetime or ISO text.
        failed : mapping of int to str, optional
            Why a test has none.

        Raises
        ------
        InvalidInputError
            No tests, several excitations, or columns of another length.
        """
        if not isinstance(sets, Sequence) or isinstance(sets, str | Mapping):
            reject("sets", type(sets).__name__, "a list of sets", "Put the sets in a list.")
        if conditions is not None and not isinstance(conditions, Mapping):
            conditions, names, dated = in_order(conditions, len(sets), names)
            times = dated if times is None else times
        return cls(tuple(sets), names=names, conditions=conditions, times=times, failed=failed)

    def tracks(
        self, conditions: Any = None, *, max_shift: float = MAX_SHIFT, std_between: float = 0.0
    ) -> Tracks:
        """Every antiresonance followed over the tests that have a set.

        A test that lacks a response, whose sensor was out, tells nothing of its antiresonances.

        Parameters
        ----------
        conditions : str or sequence, (n,), optional
            The name of a condition, "times", "names", or what differs from test to test. Default: the indices
            of the tests.
        max_shift, std_between : float
            As for :func:`~antires_rs.track`.

        Returns
        -------
        Tracks
            A row for each test that has a set, in their order.

        Raises
        ------
        InvalidInputError
            Fewer than two sets, or no such condition.
        """
        kept = [(i, one) for i, one in enumerate(self.sets) if one is not None]
        labels = self._labels(conditions)
        sets, named = [one for _, one in kept], [labels[i] for i, _ in kept]
        return followed(sets, named, self.dofs, max_shift, std_between)

    def average(self, *, max_shift: float = MAX_SHIFT) -> AntiresonanceSet:
        """One set that stands for all tests, if nothing changed between them.

        Its frequencies are the means of the tracks that at least half of the tests have, its standard
        deviations those of the means by their scatter. ``ar.compare(january, february)`` of two series
        compares their averages.

        Raises
        ------
        InvalidInputError
            Fewer than two sets.
        """
        return averaged(self.tracks(max_shift=max_shift), self.dofs)

    def compare(self, i: int, j: int, **options: Any) -> Comparison:
        """Two tests compared; options as for :func:`~antires_rs.compare`.

        Raises
        ------
        InvalidInputError
            A test that has no set, or a malformed option.
        """
        return compare(self._set("i", i), self._set("j", j), **options)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all of it into one file, whole or not at all; see :meth:`load`.

        Parameters
        ----------
        path : path-like
            Ending in ``.sqlite`` a database; in ``.csv`` a table of text, which cannot be loaded again; else
            the same table as Parquet.

        Raises
        ------
        InvalidInputError
            A folder that does not exist.
        MissingDependencyError
            pyarrow is not installed, for Parquet.
        """
        rows = []
        for i, one in enumerate(self.sets):
            outcome = self.failed[i] if one is None else encoded(one)
            conditions = {name: float(column[i]) for name, column in self.conditions.items()}
            time = None if self.times is None else self.times[i]
            rows.append(Row.packed(self.names[i], conditions, time, "", outcome))
        write_series(Path(path), rows)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """A series out of a file; its sets are read when they are asked for.

        Parameters
        ----------
        path : path-like
            What :meth:`save` wrote, or the ``store`` of :func:`~antires_rs.identify_series`: of one that
            runs, or was stopped, it gives the tests so far.

        Raises
        ------
        FileNotFoundError
            There is none.
        InvalidInputError
            A file of another kind, or of a newer version.
        MissingDependencyError
            pyarrow is not installed.
        """
        rows, unfinished = read_series(Path(path))
        return cls(**parts_of(rows), interrupted=unfinished)

    def to_dataframe(self) -> Any:
        """One row an antiresonance: test, name, time, the conditions, and the columns of a set.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        MissingDependencyError
            pandas is not installed.
        """
        return series_frame(self)

    @overload
    def __getitem__(self, at: int) -> AntiresonanceSet | None: ...
    @overload
    def __getitem__(self, at: slice | Sequence[int] | NDArray[Any]) -> Series: ...
    def __getitem__(self, at: Any) -> Any:
        """The set of one test by its index, or a series of some: a slice, indices or a mask.

        Raises
        ------
        IndexError
            No such test.
        InvalidInputError
            Anything else, a mask of another length, or a test more than once.
        """
        at = one_or_some(at, len(self))
        return self.sets[at] if isinstance(at, int) else self._some(at)

    def __repr__(self) -> str:
        return f"Series({len(self)} tests, {len(self.failed)} failed, excitation={self.excitation!r})"

    def __str__(self) -> str:
        return printed(self)

    def _some(self, at: NDArray[np.intp]) -> Series:
        rank = {int(i): k for k, i in enumerate(at)}
        return Series(
            self.sets.take(rank) if isinstance(self.sets, StoredSets) else [self.sets[i] for i in rank],
            names=[self.names[i] for i in rank],
            conditions={name: column[at] for name, column in self.conditions.items()},
            times=None if self.times is None else self.times[at],
            failed={rank[i]: why for i, why in self.failed.items() if i in rank},
            excitation=self.excitation,
            dofs=self.dofs,
            interrupted=self.interrupted,
        )

    def _labels(self, conditions: Any) -> Any:
        if conditions is None:
            return range(len(self))
        if not isinstance(conditions, str):
            if len(conditions) != len(self):
                wanted = f"{len(self)}, one for each test"
                reject("conditions", f"{len(conditions)} of them", wanted, "Give those of failed tests too.")
            return conditions
        known: dict[str, Any] = {"names": self.names, **self.conditions}
        if self.times is not None:
            known["times"] = np.datetime_as_string(self.times)
        if conditions not in known:
            reject("conditions", conditions, f"one of {tuple(known)}", "Name a condition of the series.")
        return known[conditions]

    def _set(self, name: str, at: int) -> AntiresonanceSet:
        if not -len(self) <= at < len(self):
            reject(name, at, f"a test of {len(self)}", "Tests are counted from 0.")
        found = self.sets[at]
        if found is None:
            why = self.failed[at % len(self)]
            reject(name, f"test {at}, which failed: {why}", "a test with a set", "Name another.")
        return found
