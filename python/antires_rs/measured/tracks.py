"""What following antiresonances over many tests gives: their tracks, and what happened to them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.pickling import ReadOnly
from ..support.validation import FloatArray
from .layout import aligned, number
from .repeatability import scatter

__all__ = ["TrackEvent", "Tracks"]


@dataclass(frozen=True)
class TrackEvent:
    """One thing that happened to a track.

    Attributes
    ----------
    kind : {"new", "lost", "merged", "back"}
    test : int
        The first test without it, or with it.
    dof : int or str
    track : int
        Its column in :class:`Tracks`.
    freq_hz : float
        Where it was seen last, or first.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.TrackEvent("lost", 3, 0, 1, 23.8).kind)
    lost
    """

    kind: str
    test: int
    dof: Any
    track: int
    freq_hz: float


@dataclass(frozen=True, eq=False, repr=False)
class Tracks(ReadOnly):
    """Antiresonances over many tests, see :func:`~antires_rs.track`; print it for a table.

    Attributes
    ----------
    excitation : int or str
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
    >>> followed = ar.track([ar.AntiresonanceSet(0, {0: f}) for f in ([8.0, 23.9], [8.1])])
    >>> followed, followed.change_percent[1].round(2).tolist()
    (Tracks(2 antiresonances, 2 tests, 1 events), [1.25, nan])
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
        return np.asarray(100.0 * (self.freq_hz / self._first() - 1.0))

    @property
    def std_between(self) -> float:
        """Relative scatter of one value from test to test beyond its stated deviation, if tests are repeats.

        See :mod:`antires_rs.measured.repeatability`; 0 where the stated deviations explain all of it, NaN
        without an antiresonance that two tests have.
        """
        return scatter(self.freq_hz, self.std_hz)[0]

    @property
    def std_common(self) -> float:
        """Relative scatter from test to test that moves all values alike, if tests are repeats.

        See :mod:`antires_rs.measured.repeatability`.
        """
        return scatter(self.freq_hz, self.std_hz)[1]

    def of(self, dof: Any) -> NDArray[np.int64]:
        """Columns of one response."""
        return np.flatnonzero(self.dof == dof)

    def _first(self) -> FloatArray:
        at = np.argmax(~np.isnan(self.freq_hz), axis=0)
        return np.asarray(self.freq_hz[at, np.arange(self.freq_hz.shape[1])])

    def _last(self) -> FloatArray:
        at = len(self.conditions) - 1 - np.argmax(~np.isnan(self.freq_hz[::-1]), axis=0)
        return np.asarray(self.freq_hz[at, np.arange(self.freq_hz.shape[1])])

    def __len__(self) -> int:
        return int(self.dof.size)

    def __repr__(self) -> str:
        return f"Tracks({len(self)} antiresonances, {len(self.conditions)} tests, {len(self.events)} events)"

    def __str__(self) -> str:
        first, last = self._first(), self._last()
        seen = np.sum(~np.isnan(self.freq_hz), axis=0)
        told: dict[int, list[str]] = {}
        for event in self.events:
            told.setdefault(event.track, []).append(f"{event.kind} at {self.conditions[event.test]}")
        rows = [
            [str(self.dof[i]), str(seen[i]), number(first[i], 3), number(last[i], 3)]
            + [number(100.0 * (last[i] / first[i] - 1.0), 3, sign=True), ", ".join(told.get(i, []))]
            for i in range(len(self))
        ]
        title = f"antiresonances followed over {len(self.conditions)} tests, force at {self.excitation}"
        return "\n".join([title, *aligned(["dof", "tests", "first_hz", "last_hz", "change_%", ""], rows)])

    def to_dataframe(self) -> Any:
        """One row a test and track: test, condition, dof, track, freq_hz, std_hz, change_percent, event.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        MissingDependencyError
            pandas is not installed.
        """
        from ..io.compared import tracks_frame

        return tracks_frame(self)

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` over test and track, conditions and dofs as coordinates; needs xarray."""
        from ..io.compared import tracks_dataset

        return tracks_dataset(self)

    def plot(self, dof: Any = None, *, kind: str = "change", ax: Any = None) -> Any:
        """Draw the tracks of a response over the tests; see :func:`~antires_rs.plotting.plot_tracks`."""
        from ..plotting.tracks import plot_tracks

        return plot_tracks(self, dof, kind=kind, ax=ax)
