"""The antiresonances of a structure under one force: what identification hands to updating."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from ..order_sweep.table import ResponseTable
from ..support.files import write_atomically
from ..support.pickling import FrozenDict, frozen
from ..support.validation import FloatArray, choice, reject
from . import set_file
from .edits import Edit, described, marked
from .evidence import CrossCheck, DataCheck
from .evidence_tables import EvidenceTables
from .printed import left_out_printed, rows_printed
from .sight import Sees, channels_of, checked_sees, moved_channels
from .tables import frequencies_hz, label, tables_of

__all__ = ["AntiresonanceSet", "Edit"]


class AntiresonanceSet(EvidenceTables):
    """Antiresonant frequencies by response dof, a mapping ``{dof: freq_hz}``; read-only.

    Parameters
    ----------
    excitation : int or str
        The dof of the force.
    freq_hz : mapping of dof to array_like
        Antiresonances in Hz, in any order; a number stands for a list of one; an empty list says that the dof
        was looked at and has none.
    damping_ratio, std_hz : mapping of dof to array_like, optional
        Damping ratio and standard deviation of each, in the order of ``freq_hz``; NaN where not known.
        Dofs may be missing.
    sees : {"frf", "transmissibility", None}
        What the antiresonances were identified from, see Notes.
    channels : iterable of dof, optional
        All responses that were measured together, with or without antiresonances here. Default: those of
        ``freq_hz``.
    scores, diagrams, data_check, cross_check : optional
        See Attributes.

    Attributes
    ----------
    excitation : int or str
    sees : str or None
    channels : tuple of dof
        Empty where some of them have no name here, see :meth:`relabelled`.
    tables : dict
        By dof: one :class:`~antires_rs.order_sweep.table.ResponseTable`, from which the next three are taken.
    damping_ratio, std_hz : dict
        By dof, in the order of the sorted frequencies; without the dofs for which they are not known. After
        :meth:`add` single ones may be NaN.
    scores : dict
        By dof: what speaks for each antiresonance, a dict of name to (n,) array, see
        :mod:`antires_rs.order_sweep.scores`. Empty where a set was made by hand.
    edits : tuple of Edit
        What was dropped and added by hand, in order.
    left_out : dict of ResponseTable
        By dof, where curves were identified: what fits saw and did not accept, with the score "why".
    unexplained_hz : dict
        By dof, where it was identified: peaks of its curve beside which nothing was seen.
    diagrams : dict
        Stabilization diagram by dof where the set was identified; not saved.
    cross_check, second_opinion : SecondOpinion or None
        What another method says of the antiresonances, where it was asked (one thing, two names); not saved.
    data_check : DataCheck or None
        Whether the data were fit for it; not saved.

    Raises
    ------
    InvalidInputError
        Frequencies that are not positive and finite, or companions of another length or dof.

    Notes
    -----
    Where a sensor sits on a node of a mode, the root of its numerator on that resonance cancels in its FRF.
    In transmissibilities to it the other responses still resonate: they have a peak there. They lose only
    roots that all ``channels`` share. So a model is compared with its antiresonances less the cancelled ones
    for ``sees="frf"``, and for ``sees="transmissibility"`` with the cancelled ones that not all channels
    share. With None, for sets made by hand and from older files, a cancelled root may be the partner of a
    measured value, and nothing is missed where none is. :func:`~antires_rs.identify_antiresonances` sets it
    by its route.

    Examples
    --------
    >>> from antires_rs.measured.antiresonance_set import AntiresonanceSet
    >>> table = AntiresonanceSet(0, {0: [23.9, 8.7], 1: 14.4, 2: []})
    >>> table[0].tolist(), len(table), 3 in table
    ([8.7, 23.9], 3, False)
    >>> print(table)
    antiresonances, force at 0
    dof  freq_hz
      0    8.700
          23.900
      1   14.400
      2        -
    """

    def __init__(
        self,
        excitation: Any,
        freq_hz: Mapping[Any, Any],
        damping_ratio: Mapping[Any, Any] | None = None,
        std_hz: Mapping[Any, Any] | None = None,
        *,
        sees: Sees = None,
        channels: Iterable[Any] | None = None,
        scores: Mapping[Any, Mapping[str, Any]] | None = None,
        diagrams: Mapping[Any, Any] | None = None,
        data_check: DataCheck | None = None,
        cross_check: CrossCheck | None = None,
    ) -> None:
        super().__init__(label("excitation", excitation), tables_of(freq_hz, damping_ratio, std_hz, scores))
        self._fill_diagrams(diagrams or {})
        self._fill(
            _data_check=data_check,
            _cross_check=cross_check,
            _sees=checked_sees(sees),
            _channels=channels_of(channels, tuple(self)),
        )

    @classmethod
    def from_tables(
        cls,
        excitation: Any,
        tables: Mapping[Any, ResponseTable],
        *,
        edits: Sequence[Edit] = (),
        before: Mapping[Any, ResponseTable] | None = None,
        left_out: Mapping[Any, ResponseTable] | None = None,
        unexplained_hz: Mapping[Any, FloatArray] | None = None,
        **evidence: Any,
    ) -> Self:
        """A set of tables that are there.

        Parameters
        ----------
        excitation : int or str
        tables : mapping of dof to ResponseTable
        edits, before : optional
            What was edited by hand in these tables, and the tables before it.
        left_out, unexplained_hz : mapping of dof, optional
            What was not accepted; by default as the diagrams say.
        **evidence
            ``sees``, ``channels``, ``diagrams``, ``data_check``, ``cross_check`` as for the constructor.
        """
        new = cls(excitation, {dof: table.freq_hz for dof, table in tables.items()}, **evidence)
        if left_out is not None:
            new._fill(_left_out=FrozenDict(left_out))
        if unexplained_hz is not None:
            new._fill(_unexplained_hz=FrozenDict(unexplained_hz))
        sight: dict[str, Any] = {name: evidence.get(name) for name in ("sees", "channels")}
        sight |= {"left_out": new.left_out, "unexplained_hz": new.unexplained_hz}
        original = cls.from_tables(excitation, before, **sight) if edits and before is not None else None
        return new._with(
            _tables=FrozenDict(zip(new, tables.values(), strict=True)),
            _edits=tuple(edits),
            _original=original,
        )

    def relabelled(self, excitation: Any, dofs: Mapping[Any, Any]) -> Self:
        """The set with other names of the dofs, in tables and edits; diagrams and checks stay behind.

        Parameters
        ----------
        excitation : int or str
            The dof of the force.
        dofs : mapping of dof to int or str
            The new name of each; dofs that it lacks are left out. If ``channels`` are among these, what all
            of them share cannot be told any more, and ``channels`` is empty.

        Raises
        ------
        InvalidInputError
            No dof is left, or two have one name.

        Examples
        --------
        >>> from antires_rs.measured.antiresonance_set import AntiresonanceSet
        >>> found = AntiresonanceSet("tip", {"tip": [8.7], "root": 14.4}).add("tip", 9.9)
        >>> print(found.relabelled(0, {"tip": 0}))
        antiresonances, force at 0
        dof  freq_hz  doubts
          0    8.700
               9.900  added by hand
        edited by hand: added 9.90 Hz at dof 0
        """
        kept = [dofs[dof] for dof in self if dof in dofs]
        twice = [dof for dof in kept if kept.count(dof) > 1]
        if twice:
            reject(
                "dofs",
                f"{twice[0]!r} for two of {tuple(self)}",
                "each dof once",
                "Name one otherwise, or leave it out.",
            )

        def moved(tables: Mapping[Any, Any]) -> dict[Any, Any]:
            return {dofs[dof]: table for dof, table in tables.items() if dof in dofs}

        edits = [replace(edit, dof=dofs[edit.dof]) for edit in self.edits if edit.dof in dofs]
        return self.from_tables(
            excitation,
            moved(self.tables),
            edits=edits,
            before=moved(self.original().tables),
            left_out=moved(self.left_out),
            unexplained_hz=moved(self.unexplained_hz),
            sees=self.sees,
            channels=moved_channels(self.channels, dofs),
        )

    def __str__(self) -> str:
        lines = [f"antiresonances, force at {self.excitation}"]
        if self._data_check is not None:
            lines += [f"do not trust: {f.text}" for f in self._data_check.findings if f.severity == "fatal"]
        lines += rows_printed(self.tables, self._cross_check)
        lines += left_out_printed(self.left_out)
        unexplained = sum(len(one) for one in self.unexplained_hz.values())
        if unexplained:
            lines.append(f"unexplained: {unexplained}, see .unexplained_hz")
        if self.edits:
            lines.append(described(self.edits))
        return "\n".join(lines)

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
        if self._dof(dof) not in self.diagrams:
            reject(
                "dof",
                f"{dof!r}, which has no stabilization diagram",
                "a dof of a set that was identified, not made by hand or loaded",
                "Identify it from the measurement to have its diagram.",
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

    def to_dataframe(self) -> Any:
        """One row a value: dof, freq_hz, damping_ratio, std_hz (NaN where not known), source, and the scores.

        ``source`` is "by hand" for values that were added by hand, "identified" for those that the set was
        made with. A column for each score follows, and, after a cross-check, ``confirmed`` (None where an
        antiresonance was not judged).

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

        Tables, edits, the tables before them and what was not accepted are saved; diagrams and checks
        are not.

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
        return set_file.to_json(
            self.excitation,
            self.tables,
            self.edits,
            self.original().tables if self.edits else None,
            (self.sees, self.channels),
            (self.left_out, self.unexplained_hz),
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
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
            raise set_file.damaged(str(path), exc) from exc
        return cls.from_json(text, str(path))

    @classmethod
    def from_json(cls, text: str, name: str = "text") -> Self:
        """A set from the text of :meth:`to_json`; ``name`` stands for it in messages."""
        data = set_file.from_json(text, name)
        try:
            edits, before = data["edits"], data["before"]
            return cls.from_tables(
                data["excitation"],
                {dof: marked(table, dof, edits) for dof, table in tables_of(**data["now"]).items()},
                edits=edits,
                before=None if before is None else tables_of(**before),
                left_out=tables_of(**data["left_out"]) if data["left_out"]["freq_hz"] else None,
                unexplained_hz={
                    dof: frozen(frequencies_hz(f"unexplained_hz of {dof!r}", values))
                    for dof, values in data["unexplained_hz"].items()
                },
                sees=data["sees"],
                channels=data["channels"],
            )
        except (TypeError, ValueError) as exc:
            raise set_file.damaged(name, exc) from exc
