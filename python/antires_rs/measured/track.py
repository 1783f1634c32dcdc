"""Antiresonances followed over many sets: what moved, came, went, and ran into its neighbour."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..support.checks import FloatArray, forces_at
from ..support.messages import keywords_left
from ..support.values import ReadOnly, frozen
from ..views import Viewed
from .antiresonance_set import aligned, number
from .matching import KNOWN, MAX_SHIFT, SeriesOfTests, check_sets, paired, scatter, variance_hz, within
from .response_table import ResponseTable, label_array, rows_with

# -- What following antiresonances over many tests gives: their tracks, and what happened to them


@dataclass(frozen=True)
class TrackEvent:
    """One thing that happened to a track: it is "new", "lost", "merged" or "back".

    ``test`` is the first without it, or with it, ``track`` its column in :class:`Tracks`, ``freq_hz`` where
    it was seen last, or first.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.TrackEvent("lost", 3, 0, 1, 23.8).kind
    'lost'
    """

    kind: str
    test: int
    dof: Any
    track: int
    freq_hz: float


@dataclass(frozen=True, eq=False, repr=False)
class Tracks(ReadOnly, Viewed):
    """Antiresonances over many tests, see :func:`~antires_rs.track`; print it for a table.

    Attributes
    ----------
    excitation : int, str or tuple
    conditions : tuple, (n_tests,)
    dof : (n_tracks,)
        Response of each track; those of a dof stand together, ascending.
    freq_hz, std_hz : (n_tests, n_tracks)
        NaN where a test does not have it, or its deviation is not known.
    events : tuple of TrackEvent
        By test.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.track([ar.AntiresonanceSet(0, {0: f}) for f in ([8.0, 23.9], [8.1])])
    Tracks(2 antiresonances, 2 tests, 1 events)
    """

    excitation: Any
    conditions: tuple[Any, ...]
    dof: NDArray[Any]
    freq_hz: FloatArray
    std_hz: FloatArray
    events: tuple[TrackEvent, ...]

    @property
    def change_percent(self) -> FloatArray:
        """Change of each since its first test, (n_tests, n_tracks)."""
        return np.asarray(100.0 * (self.freq_hz / _first(self.freq_hz) - 1.0))

    @property
    def std_between(self) -> float:
        """Relative scatter of one value from test to test beyond its stated deviation, if tests are repeats.

        0 where the stated deviations explain all of it, NaN without an antiresonance that two tests have.
        """
        return scatter(self.freq_hz, self.std_hz)[0]

    @property
    def std_common(self) -> float:
        """The same of what moves all values alike."""
        return scatter(self.freq_hz, self.std_hz)[1]

    def of(self, dof: Any) -> NDArray[np.int64]:
        """Columns of one response."""
        return np.flatnonzero(rows_with(self.dof, dof))

    def __len__(self) -> int:
        return int(self.dof.size)

    def __repr__(self) -> str:
        return f"Tracks({len(self)} antiresonances, {len(self.conditions)} tests, {len(self.events)} events)"

    def __str__(self) -> str:
        first, last = _first(self.freq_hz), _first(self.freq_hz[::-1])
        seen = np.sum(~np.isnan(self.freq_hz), axis=0)
        words: list[list[str]] = [[] for _ in range(len(self))]
        for event in self.events:
            words[event.track].append(f"{event.kind} at {self.conditions[event.test]}")
        change = 100.0 * (last / first - 1.0)
        rows = [
            [str(dof), str(n), number(a, 3), number(b, 3), number(by, 3, sign=True), ", ".join(own)]
            for dof, n, a, b, by, own in zip(self.dof, seen, first, last, change, words, strict=True)
        ]
        title = f"antiresonances followed over {len(self.conditions)} tests, {forces_at(self.excitation)}"
        return "\n".join([title, *aligned(["dof", "tests", "first_hz", "last_hz", "change_%", ""], rows)])

    def to_dataframe(self) -> Any:
        """One row a test and track: test, condition, dof, track, freq_hz, std_hz, change_percent, event."""
        return self._view("to_dataframe")(self)

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` over test and track, conditions and dofs as coordinates; needs xarray."""
        return self._view("to_xarray")(self)

    @keywords_left(kind="changes are drawn")
    def plot(self, dof: Any = None, *, ax: Any = None) -> Any:
        """Draw the tracks of a response over the tests; see :func:`~antires_rs.figures.plot_tracks`."""
        return self._view("plot")(self, dof, ax=ax)


def _first(freq_hz: FloatArray) -> FloatArray:
    """What each track has in the first test that has it."""
    return np.asarray(freq_hz[np.argmax(~np.isnan(freq_hz), axis=0), np.arange(freq_hz.shape[1])])


NEIGHBOUR = 0.02  # two values nearer than this may become one; farther apart, one of them was lost
# A track lives while half of the last so many tests have it; what lives is assigned first, so that a value
# seen once does not take over an antiresonance that drifts past its place.
RECENT = 10
# A track not seen in so many tests, and in ten times as many as have it, is not looked for any more.
CLOSED, CLOSED_TIMES = 100, 10


class _Track:
    """One antiresonance: where it was last, and its row in every test that has it, counted by ``nth``."""

    def __init__(self, test: int, nth: int, table: ResponseTable, row: int) -> None:
        self.rows: dict[int, int] = {}
        #: The value that it was followed from, or a value that others are followed from.
        self.known_hz = float(table.scores[KNOWN][row] if KNOWN in table.scores else table.freq_hz[row])
        self._seen: list[int] = []
        self.follow(test, nth, table, row)

    def follow(self, test: int, nth: int, table: ResponseTable, row: int) -> None:
        self.rows[test] = row
        self._seen.append(nth)
        self.freq_hz = float(table.freq_hz[row])

    def lives(self, nth: int) -> bool:
        """Whether half of the last tests before this one have it, or half of those since its first."""
        seen = len(self._seen) - bisect_left(self._seen, nth - RECENT)
        return 2 * seen >= min(RECENT, nth - self._seen[0])

    def is_closed(self, nth: int) -> bool:
        """Whether it was not seen for long."""
        return nth - self._seen[-1] > max(CLOSED, CLOSED_TIMES * len(self._seen))


def track(
    sets: Sequence[Any] | SeriesOfTests,
    conditions: Any = None,
    *,
    max_shift: float = MAX_SHIFT,
    std_between: float = 0.0,
) -> Tracks:
    """Follow every antiresonance over many tests of one structure.

    Parameters
    ----------
    sets : list of AntiresonanceSet, or Series
        In the order of the tests, two or more, of the same excitation. Tests of a series that failed are left
        out, with their conditions.
    conditions : sequence, (n_tests,), optional
        What differs from test to test (temperature, damage, date, load): numbers or texts. Default: 0, 1, ...
    max_shift : float
        Largest relative difference from one test to the next of two values that are taken for one.
    std_between : float
        Relative scatter from test to test, as for :func:`~antires_rs.compare`: it widens what is one.

    Returns
    -------
    Tracks
        A track a value, with NaN where a test does not have it; ``.events`` tell what is new, lost, merged or
        back. ``.std_between`` is the scatter between the tests, if they are repeats.

    Raises
    ------
    InvalidInputError
        Other excitations, no dof in common, or conditions of another length.

    Notes
    -----
    Values that were followed (``near=``) from one value are one track. The others of a response are, from
    test to test, assigned to the tracks, all at once (:mod:`antires_rs.measured.matching`), each track being
    where it was seen last: first to those that half of the last ten tests have, what is left to the others.
    What was not seen in 100 tests, and in ten times as many as have it, is not looked for any more. What a
    track loses has "merged" if a neighbour, nearer than 2 % when both were last seen, is still there; else it
    is "lost".

    Examples
    --------
    >>> import antires_rs as ar
    >>> tests = [{0: [8.7, 23.9]}, {0: [8.6, 23.8, 31.0]}, {0: [8.5]}]
    >>> sets = [ar.AntiresonanceSet(0, values) for values in tests]
    >>> print(ar.track(sets, ["new", "1 year", "2 years"]))
    antiresonances followed over 3 tests, force at 0
    dof  tests  first_hz  last_hz  change_%
      0      3     8.700    8.500    -2.299
      0      2    23.900   23.800    -0.418  lost at 2 years
      0      1    31.000   31.000    +0.000  new at 1 year, lost at 2 years
    """
    if isinstance(sets, SeriesOfTests):
        found: Tracks = sets.tracks(conditions, max_shift=max_shift, std_between=std_between)
        return found
    given = check_sets("sets", sets, 2)
    dofs = [dof for dof in given[0] if all(dof in one for one in given)]
    return followed(given, conditions, dofs, max_shift, std_between)


def followed(
    sets: Sequence[Any], conditions: Any, dofs: Sequence[Any], max_shift: float, std_between: float
) -> Tracks:
    """Tracks of some responses; a test that lacks one of them tells nothing of it."""
    given = check_sets("sets", sets, 2)
    shift, between = within("max_shift", max_shift), within("std_between", std_between)
    names = _conditions(conditions, len(given))
    first = given[0]
    for i, one in enumerate(given):
        if one.excitation != first.excitation:
            got, wanted = f"a set of force at {one.excitation!r}", f"that of the first, {first.excitation!r}"
            reject(f"sets[{i}]", got, wanted, "Follow each excitation by itself.")
    if not dofs:
        reject("sets", "sets without a common dof", "sets of the same responses", "Leave out the others.")
    labels: list[Any] = []
    events: list[TrackEvent] = []
    columns: list[FloatArray] = []
    for dof in dofs:
        tables = {test: one.tables[dof] for test, one in enumerate(given) if dof in one}
        tracks, seen = _followed(tables, shift, between)
        order = sorted(range(len(tracks)), key=lambda i: tracks[i].freq_hz)
        at = {i: len(columns) + rank for rank, i in enumerate(order)}
        events += [TrackEvent(kind, test, dof, at[i], freq) for kind, test, i, freq in seen]
        for i in order:
            column = np.full((2, len(given)), np.nan)
            for test, row in tracks[i].rows.items():
                column[:, test] = tables[test].freq_hz[row], tables[test].std_hz[row]
            columns.append(column)
            labels.append(dof)
    freq, std = np.stack(columns, axis=2) if columns else np.empty((2, len(given), 0))
    happened = tuple(sorted(events, key=lambda event: (event.test, event.track)))
    return Tracks(first.excitation, names, label_array(labels), frozen(freq), frozen(std), happened)


def _followed(
    tables: Mapping[int, ResponseTable], shift: float, between: float
) -> tuple[list[_Track], list[tuple[str, int, int, float]]]:
    """Tracks of one response by test, and (kind, test, track, frequency) of what happened to them."""
    (before, first), *others = tables.items()
    tracks = [_Track(before, 0, first, row) for row in range(len(first))]
    looked_for = list(range(len(tracks)))
    events: list[tuple[str, int, int, float]] = []
    for nth, (test, table) in enumerate(others, start=1):
        looked_for = [i for i in looked_for if not tracks[i].is_closed(nth)]
        where = np.array([tracks[i].freq_hz for i in looked_for])
        pairs = _assigned([tracks[i] for i in looked_for], nth, table, shift, between)
        for k, i in enumerate(looked_for):
            was = before in tracks[i].rows
            if k in pairs and not was:
                events.append(("back", test, i, float(table.freq_hz[pairs[k]])))
            elif was and k not in pairs:
                near = np.abs(where / where[k] - 1.0) <= NEIGHBOUR
                merged = any(near[j] and j != k for j in pairs if before in tracks[looked_for[j]].rows)
                events.append(("merged" if merged else "lost", test, i, float(where[k])))
        for k, row in pairs.items():
            tracks[looked_for[k]].follow(test, nth, table, row)
        for row in sorted(set(range(len(table))) - set(pairs.values())):
            events.append(("new", test, len(tracks), float(table.freq_hz[row])))
            looked_for.append(len(tracks))
            tracks.append(_Track(test, nth, table, row))
        before = test
    return tracks, events


def _assigned(
    tracks: list[_Track], nth: int, table: ResponseTable, shift: float, between: float
) -> dict[int, int]:
    """Row of the test by track: what was followed from one value, those that live, then what is left."""
    known = {one.known_hz: k for k, one in enumerate(tracks)}
    origin = np.asarray(table.scores.get(KNOWN, np.full(len(table), np.nan))).tolist()
    pairs = {known[freq]: row for row, freq in enumerate(origin) if freq in known}
    # Of a track that is new to this test only the test's own deviation is looked at, twice.
    variance = 2.0 * variance_hz(table, between)
    for living in (True, False):
        some = [k for k, one in enumerate(tracks) if one.lives(nth) is living and k not in pairs]
        left = np.array(sorted(set(range(len(table))) - set(pairs.values())), dtype=int)
        where = np.array([tracks[k].freq_hz for k in some])
        scatter = np.broadcast_to(variance[left], (len(some), left.size))
        pairs |= {some[i]: int(left[row]) for i, row in paired(where, table.freq_hz[left], shift, scatter)}
    return pairs


def _conditions(conditions: Any, count: int) -> tuple[Any, ...]:
    """One for each test, all numbers or all texts."""
    if conditions is None:
        return tuple(range(count))
    wanted = f"{count} numbers or {count} texts, one for each test"
    if isinstance(conditions, str) or not hasattr(conditions, "__len__"):
        reject("conditions", conditions, wanted, "Put them in a list.")
    if len(conditions) != count:
        reject("conditions", f"{len(conditions)} of them", wanted, "Give one for each set.")
    given = [item.item() if isinstance(item, np.generic) else item for item in conditions]
    if all(isinstance(item, int | float) and np.isfinite(item) for item in given):
        return tuple(given)
    return tuple(map(str, given))
