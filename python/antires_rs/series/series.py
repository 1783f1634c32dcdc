"""Many tests of one structure, in order."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Self, overload

import numpy as np
from numpy.typing import NDArray

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.compare import Comparison, compare
from ..measured.matching import MAX_SHIFT
from ..measured.track import followed
from ..measured.tracks import Tracks
from ..support.validation import reject
from .average import averaged
from .condition_table import in_order
from .encoded import encoded
from .frames import series_frame
from .kept import InMemory, Kept, Row, parts_of
from .kept_tests import KeptTests, SomeSets
from .parquet_file import write_series
from .printed import printed
from .some_tests import one_or_some
from .store import stored_rows

__all__ = ["Series"]


class Series(KeptTests):
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
        """Write all of it into one Parquet file, whole or not at all; see :meth:`load`.

        Raises
        ------
        InvalidInputError
            A folder that does not exist.
        MissingDependencyError
            pyarrow is not installed.
        """
        place = InMemory(self.sets)
        rows = []
        for i, one in enumerate(self.sets):
            outcome = self.failed[i] if one is None else encoded(one)
            conditions = {name: float(column[i]) for name, column in self.conditions.items()}
            time = None if self.times is None else self.times[i]
            rows.append(Row(self.names[i], conditions, time, Kept.of("", outcome, place, i)))
        write_series(Path(path), rows, None)

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
        rows, unfinished = stored_rows(Path(path))
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
            SomeSets(self.sets, tuple(rank)),
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
