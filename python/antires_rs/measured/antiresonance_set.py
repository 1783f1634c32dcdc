"""The antiresonances of a structure under one force: what identification hands to updating."""

from __future__ import annotations

import copy
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.files import write_atomically
from ..support.pickling import ReadOnly, frozen
from ..support.validation import FloatArray, choice, reject
from . import edits as _edits
from . import set_file as _set_file
from .columns import companions, label, sorted_scores, values_of, with_column
from .edits import Edit

if TYPE_CHECKING:
    from ..data_check import DataCheck
    from ..identification.cross_check import SecondOpinion

__all__ = ["AntiresonanceSet", "Edit"]


class AntiresonanceSet(ReadOnly, Mapping[Any, FloatArray]):
    """Antiresonant frequencies by response dof, a mapping ``{dof: freq_hz}``.

    Parameters
    ----------
    excitation : int or str
        The dof of the force.
    freq_hz : mapping of dof to array_like
        Antiresonances in Hz, in any order; a number stands for a list of one; an empty list says that the dof
        was looked at and has none.
    damping_ratio, std_hz : mapping of dof to array_like, optional
        Damping ratio and standard deviation of each value, in the order of ``freq_hz``; NaN where not known.
        Dofs may be missing.
    diagrams, scores : mapping of dof, optional
        See Attributes.

    Attributes
    ----------
    excitation : int or str
    damping_ratio, std_hz : dict
        By dof, in the order of the sorted frequencies; without the dofs for which they are not known. After
        :meth:`add` single values may be NaN.
    scores : dict
        By dof: what speaks for each value, a dict of name to (n,) array, see
        :mod:`antires_rs.order_sweep.scores`. Empty where a set was made by hand.
    edits : tuple of Edit
        What was dropped and added by hand, in order.
    diagrams : dict
        Stabilization diagram by dof where the set was identified; not saved.
    second_opinion : SecondOpinion or None
        What another method says of the values, where it was asked; not saved.
    data_check : DataCheck or None
        Whether the data were fit for it; not saved.

    Raises
    ------
    InvalidInputError
        Frequencies that are not positive and finite, or companions of another length or dof.

    Examples
    --------
    >>> from antires_rs.measured.antiresonance_set import AntiresonanceSet
    >>> table = AntiresonanceSet(0, {0: [23.9, 8.7], 1: 14.4, 2: []})
    >>> table[0].tolist(), len(table), 3 in table
    ([8.7, 23.9], 3, False)
    >>> print(table)
    antiresonances, force at 0
    dof  count  freq_hz
      0      2  8.700  23.900
      1      1  14.400
      2      0  -
    """

    second_opinion: SecondOpinion | None
    data_check: DataCheck | None

    def __init__(
        self,
        excitation: Any,
        freq_hz: Mapping[Any, Any],
        damping_ratio: Mapping[Any, Any] | None = None,
        std_hz: Mapping[Any, Any] | None = None,
        *,
        diagrams: Mapping[Any, Any] | None = None,
        scores: Mapping[Any, Mapping[str, Any]] | None = None,
    ) -> None:
        self.excitation = label("excitation", excitation)
        if not isinstance(freq_hz, Mapping) or not freq_hz:
            got = "an empty mapping" if isinstance(freq_hz, Mapping) else type(freq_hz).__name__
            reject("freq_hz", got, "a mapping of dof to frequencies in Hz, e.g. {0: [12.2, 36.2], 1: []}")
        self._freq_hz: dict[Any, FloatArray] = {}
        self.diagrams: dict[Any, Any] = dict(diagrams or {})
        self.edits: tuple[Edit, ...] = ()
        self.second_opinion = self.data_check = None
        self._original: AntiresonanceSet | None = None
        rank: dict[Any, Any] = {}
        for key, value in freq_hz.items():
            dof = label("freq_hz", key)
            if dof in self._freq_hz:
                reject("freq_hz", f"dof {dof!r} more than once", "each dof once")
            values = values_of(f"freq_hz[{dof!r}]", value, "positive frequencies in Hz")
            if values.size and values.min() <= 0.0:
                reject(f"freq_hz[{dof!r}]", f"{values.min():g} Hz", "positive frequencies in Hz")
            rank[dof] = np.argsort(values, kind="stable")
            self._freq_hz[dof] = frozen(values[rank[dof]])
        self.damping_ratio = companions("damping_ratio", damping_ratio, rank)
        self.std_hz = companions("std_hz", std_hz, rank)
        self.scores = sorted_scores(scores, rank)

    def __getitem__(self, dof: Any) -> FloatArray:
        return self._freq_hz[dof]

    def __iter__(self) -> Iterator[Any]:
        return iter(self._freq_hz)

    def __len__(self) -> int:
        return len(self._freq_hz)

    def __eq__(self, other: object) -> bool:
        """Same excitation, dofs and values, bit for bit; diagrams, scores and edits do not count."""
        if not isinstance(other, AntiresonanceSet):
            return NotImplemented
        mine, theirs = (s._tables() for s in (self, other))
        return self.excitation == other.excitation and all(
            a.keys() == b.keys() and all(np.array_equal(a[dof], b[dof], equal_nan=True) for dof in a)
            for a, b in zip(mine, theirs, strict=True)
        )

    __hash__ = None  # type: ignore[assignment]

    def _tables(self) -> tuple[dict[Any, FloatArray], ...]:
        return self._freq_hz, self.damping_ratio, self.std_hz

    def __repr__(self) -> str:
        counts = ", ".join(f"{dof!r}: {f.size}" for dof, f in self._freq_hz.items())
        return f"AntiresonanceSet(excitation={self.excitation!r}, values by dof {{{counts}}})"

    def __str__(self) -> str:
        width = max(3, *(len(str(dof)) for dof in self._freq_hz))
        lines = [f"antiresonances, force at {self.excitation}"]
        if self.data_check is not None:
            lines += [f"do not trust: {f.text}" for f in self.data_check.findings if f.severity == "fatal"]
        lines.append(f"{'dof':>{width}}  count  freq_hz")
        for dof, freq in self._freq_hz.items():
            values = "  ".join(f"{f:.3f}" for f in freq) or "-"
            lines.append(f"{dof!s:>{width}}  {freq.size:5d}  {values}")
        if self.edits:
            lines.append(_edits.described(self.edits))
        return "\n".join(lines)

    def drop(
        self, dof: Any, freq_hz: Any, *, reason: str = "", tol_hz: float | None = None
    ) -> AntiresonanceSet:
        """A new set without some values; this one stays as it is.

        Parameters
        ----------
        dof : int or str
        freq_hz : float or array_like
            Each drops the value nearest to it.
        reason : str
            Kept with the record of what was done, ``edits``.
        tol_hz : float, optional
            How far the nearest value may be; default 1 % of ``freq_hz``.

        Returns
        -------
        AntiresonanceSet
            ``original()`` gives back the set before all edits.

        Raises
        ------
        InvalidInputError
            No such dof, no value that near, or two frequencies that mean the same value.

        Examples
        --------
        >>> from antires_rs.measured.antiresonance_set import AntiresonanceSet
        >>> table = AntiresonanceSet(0, {0: [8.7, 12.2], 1: 14.4})
        >>> fewer = table.drop(0, 12.2, reason="mains hum of the shaker")
        >>> table[0].tolist(), fewer[0].tolist()
        ([8.7, 12.2], [8.7])
        >>> print(fewer.edits[0])
        dropped 12.20 Hz at dof 0 (mains hum of the shaker)
        """
        dof = self._known(dof)
        return self._edited(
            dof, _edits.dropped(dof, self.columns(dof), self.scores.get(dof, {}), freq_hz, reason, tol_hz)
        )

    def add(
        self, dof: Any, freq_hz: Any, *, damping_ratio: Any = None, std_hz: Any = None, reason: str = ""
    ) -> AntiresonanceSet:
        """A new set with more values; this one stays as it is.

        Parameters
        ----------
        dof : int or str
            One of the set's.
        freq_hz : float or array_like, (n,)
        damping_ratio, std_hz : float or array_like, (n,), optional
            One for all, or one each. Not known by default.
        reason : str
            Kept with the record of what was done, ``edits``.

        Returns
        -------
        AntiresonanceSet
            ``original()`` gives back the set before all edits. In tables the values' source is "by hand".

        Raises
        ------
        InvalidInputError
            No such dof, a frequency that is not positive, or a value that is there already.

        Examples
        --------
        >>> from antires_rs.measured.antiresonance_set import AntiresonanceSet
        >>> more = AntiresonanceSet(0, {0: [8.7], 1: 14.4}).add(0, 12.2, reason="clear in the phase")
        >>> print(more)
        antiresonances, force at 0
        dof  count  freq_hz
          0      2  8.700  12.200
          1      1  14.400
        edited by hand: added 12.20 Hz at dof 0 (clear in the phase)
        """
        dof = self._known(dof)
        return self._edited(
            dof,
            _edits.added(
                dof, self.columns(dof), self.scores.get(dof, {}), freq_hz, damping_ratio, std_hz, reason
            ),
        )

    def original(self) -> AntiresonanceSet:
        """The set before the first edit by hand; itself if there was none."""
        return self if self._original is None else self._original

    def plot(self, dof: Any, *, kind: str = "stabilization", ax: Any = None) -> Any:
        """Draw the evidence for one dof, edits by hand included; returns the axes.

        Parameters
        ----------
        dof : int or str
        kind : {"stabilization", "damping_clusters"}
            :func:`~antires_rs.plotting.plot_stabilization` or
            :func:`~antires_rs.plotting.plot_damping_clusters`.
        ax : matplotlib.axes.Axes, optional

        Raises
        ------
        InvalidInputError
            A dof without a stabilization diagram: sets made by hand or loaded have none.
        MissingDependencyError
            matplotlib is not installed.
        """
        choice("kind", kind, ("stabilization", "damping_clusters"))
        if self._known(dof) not in self.diagrams:
            reject(
                "dof",
                f"{dof!r}, which has no stabilization diagram",
                "a dof of a set that was identified, not made by hand or loaded",
            )
        from ..plotting.damping_clusters import plot_damping_clusters
        from ..plotting.stabilization import plot_stabilization

        draw = plot_stabilization if kind == "stabilization" else plot_damping_clusters
        found = self.original()[dof]
        return draw(
            self.diagrams[dof],
            ax=ax,
            dropped=found[~np.isin(found, self[dof])],
            added=self[dof][~np.isin(self[dof], found)],
        )

    def _known(self, dof: Any) -> Any:
        dof = label("dof", dof)
        if dof not in self._freq_hz:
            reject("dof", dof, f"one of {tuple(self._freq_hz)}")
        return dof

    def columns(self, dof: Any) -> dict[str, FloatArray]:
        """All columns of a dof, NaN where not known."""
        freq = self._freq_hz[dof]
        unknown = np.full(freq.size, np.nan)
        return {
            "freq_hz": freq,
            "damping_ratio": self.damping_ratio.get(dof, unknown),
            "std_hz": self.std_hz.get(dof, unknown),
        }

    def _edited(self, dof: Any, edited: _edits.Edited) -> AntiresonanceSet:
        """A copy with other columns at one dof; whatever else the set carries stays with it."""
        columns, scores, records = edited
        new = copy.copy(self)
        new._freq_hz = {**self._freq_hz, dof: frozen(columns["freq_hz"])}
        new.damping_ratio = with_column(self.damping_ratio, dof, columns["damping_ratio"])
        new.std_hz = with_column(self.std_hz, dof, columns["std_hz"])
        new.scores = dict(self.scores)
        if scores:
            new.scores[dof] = {name: frozen(column) for name, column in scores.items()}
        new.diagrams = dict(self.diagrams)
        new.edits = (*self.edits, *records)
        new._original = self.original()
        return new

    def by_hand(self) -> set[tuple[Any, float]]:
        """(dof, frequency in Hz) of the values that are there because they were added by hand."""
        made: set[tuple[Any, float]] = set()
        for edit in self.edits:
            (made.add if edit.action == "add" else made.discard)((edit.dof, edit.freq_hz))
        return made

    def to_dataframe(self) -> Any:
        """One row a value: dof, freq_hz, damping_ratio, std_hz (NaN where not known), source, and the scores.

        ``source`` is "by hand" for values that were added by hand, "identified" for those that the set was
        made with. A column for each score follows, and, after a second opinion, ``confirmed`` (None where a
        value was not judged).

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        MissingDependencyError
            pandas is not installed.
        """
        from ..io.tables import to_dataframe

        return to_dataframe(self)

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` over dof and rank, NaN beyond a dof's values; needs xarray."""
        from ..io.tables import to_xarray

        return to_xarray(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as JSON, whole or not at all; every float comes back bit for bit.

        Values, scores, edits and the values before them are saved; diagrams and second opinion are not.

        Parameters
        ----------
        path : path-like
            Replaced if it exists.

        Raises
        ------
        InvalidInputError
            The folder does not exist.
        """
        write_atomically(path, self.to_json().encode())

    def to_json(self) -> str:
        """The text that :meth:`save` writes."""
        first = self.original()
        return _set_file.to_json(
            self.excitation,
            self._tables(),
            self.scores,
            self.edits,
            (first._tables(), first.scores) if self.edits else None,
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> AntiresonanceSet:
        """Read what :meth:`save` wrote, in this version or an older one.

        Parameters
        ----------
        path : path-like

        Raises
        ------
        InvalidInputError
            The file is damaged, of another kind, or of a newer version.
        FileNotFoundError
            There is none.
        """
        try:
            text = Path(path).read_text(encoding="utf-8")
        except UnicodeDecodeError as exc:
            raise _set_file.damaged(str(path), exc) from exc
        return cls.from_json(text, str(path))

    @classmethod
    def from_json(cls, text: str, name: str = "text") -> AntiresonanceSet:
        """A set from the text of :meth:`to_json`; ``name`` stands for it in messages."""
        data = _set_file.from_json(text, name)
        try:
            new = cls(data["excitation"], **data["now"])
            if data["before"] is not None:
                new._original = cls(data["excitation"], **data["before"])
                new.edits = data["edits"]
            return new
        except (TypeError, ValueError) as exc:
            raise _set_file.damaged(name, exc) from exc
