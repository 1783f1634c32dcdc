"""The antiresonances of a structure under one force or several: what identification hands to updating."""

from __future__ import annotations

import copy
import json
import os
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray

from ..exceptions import InvalidInputError, Name, reject
from ..support.checks import Dofs, FloatArray, choice, force_label, forces_at, label, members
from ..support.files import marked_json, write_atomically
from ..support.messages import keywords_left
from ..support.values import FrozenDict, ReadOnly, frozen
from ..views import Viewed
from .edits import BY_HAND, Edit, added, dropped, edit_of, marked
from .response_table import NUMBERS, ResponseTable, doubts_of, frequencies_hz, key_of, tables_of

if TYPE_CHECKING:
    from ..signals.findings import DataCheck

NOT_SEEN = "followed, not seen"  # why a value that was followed is among those left out
#: What a set was identified from, and so which roots of a model it can show.
Sees = Literal["frf", "transmissibility"] | None


# -- Tables as text, in columns that stand under each other


def number(value: float, digits: int, *, sign: bool = False) -> str:
    """A number with so many decimals; a dash where it is not known."""
    return "-" if value != value else f"{value:{'+' if sign else ''}.{digits}f}"


def aligned(head: Sequence[str], rows: Sequence[Sequence[str]], left: Sequence[str] = ("",)) -> list[str]:
    """Lines of a table: columns right-aligned, those named in ``left`` left-aligned."""
    columns = []
    for name, *cells in zip(head, *rows, strict=True):
        width = max(map(len, (name, *cells)))
        columns.append([cell.ljust(width) if name in left else cell.rjust(width) for cell in (name, *cells)])
    return ["  ".join(row).rstrip() for row in zip(*columns, strict=True)]


PLAIN, MOST = 3, 6  # decimals of frequencies without a deviation, and the most that are printed
_HEAD = ("dof", "freq_hz", "std_hz", "grade", "doubts")


def _rows_printed(tables: Mapping[Any, ResponseTable]) -> list[str]:
    """Lines of the table; deviations, grades and doubts only where there are any."""
    std = np.concatenate([np.empty(0), *(table.std_hz for table in tables.values())])
    known = std[std > 0.0]
    # As many decimals that the typical deviation has two digits.
    digits = int(np.clip(np.ceil(-np.log10(np.median(known))) + 1, PLAIN, MOST)) if known.size else PLAIN
    rows = []
    for dof, table in tables.items():
        words = doubts_of(table)
        grades = table.scores.get("grade", [""] * len(table))
        for i, freq in enumerate(table.freq_hz):
            # A score of another kind stands in the place of one that is not known.
            grade = "" if str(grades[i]) == BY_HAND else str(grades[i])
            deviation = number(table.std_hz[i], digits)
            rows.append(["" if i else str(dof), number(freq, digits), deviation, grade, ", ".join(words[i])])
        if not len(table):
            rows.append([str(dof), "-", "", "", ""])
    there = [True, True, bool(std.size and not np.isnan(std).all())]
    there += [any(row[k] for row in rows) for k in (3, 4)]
    head, *kept = ([cell for cell, shown in zip(row, there, strict=True) if shown] for row in (_HEAD, *rows))
    return aligned(head, kept, left=_HEAD[3:])


# -- A set as JSON: version 1 has excitation and, by dof, the columns; version 2 the scores, the edits made by
# hand, and the values before the first of them; version 3, of several forces, lists in place of dofs; the
# rest is optional

FORMAT, VERSION, OF_ONE_FORCE = "antires_rs.AntiresonanceSet", 3, 2
_WANTED = f"a file written by AntiresonanceSet.save, version {VERSION} or older"
_ANOTHER = "It was cut, or is another file: save the set again, or name the file that holds it."


def damaged(path: str, exc: Exception) -> InvalidInputError:
    """The error of a file whose contents cannot be."""
    return InvalidInputError("path", f"{path!r}, which is damaged ({exc})", _WANTED, _ANOTHER)


def _unknown(column: FloatArray) -> bool:
    return bool(column.size and np.isnan(column).all())


def _row(table: ResponseTable) -> dict[str, Any]:
    """A table as a file has it; a column of which nothing is known is left out, NaN becomes null."""

    def plain(columns: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
        return {name: [None if x != x else x for x in own.tolist()] for name, own in columns.items()}

    columns = {name: getattr(table, name) for name in NUMBERS}
    known = plain({name: own for name, own in columns.items() if not _unknown(own)})
    return known | ({"scores": plain(table.scores)} if table.scores else {})


def _read(rows: Any, named: Callable[[Name, Any], Any]) -> dict[Any, ResponseTable]:
    """Tables by dof."""
    out: dict[str, dict[Any, Any]] = {name: {} for name in (*NUMBERS, "scores")}
    for row in rows:
        dof = Dofs.of_file(row["dof"])
        if dof in out["freq_hz"]:
            raise ValueError(f"dof {dof!r} more than once")
        out["freq_hz"][dof] = row["freq_hz"]
        for name in NUMBERS[1:]:
            if name in row:
                out[name][dof] = [np.nan if v is None else v for v in row[name]]
        if "scores" in row:
            out["scores"][dof] = {name: _column(values) for name, values in row["scores"].items()}
    return tables_of(**out, named=named)


def _column(values: list[Any]) -> NDArray[Any]:
    """Text, truth, whole numbers or floats; null is NaN."""
    for kind, dtype in ((str, None), (bool, None), (int, np.int64)):
        if values and all(isinstance(v, kind) for v in values):
            return np.array(values, dtype=dtype)
    return np.array([np.nan if v is None else v for v in values], dtype=np.float64)


class AntiresonanceSet(ReadOnly, Viewed, Mapping[Any, FloatArray]):
    """Antiresonant frequencies by response dof, a mapping ``{dof: freq_hz}``; read-only.

    Parameters
    ----------
    excitation : int or str, or a list of them
        The dof of the force; of several forces that act at once all their dofs. A list of one is that one.
    freq_hz : mapping of dof to array_like
        Antiresonances in Hz, positive, in any order; a number is a list of one, an empty list none. Of r
        forces the keys are tuples of r different response dofs, see Notes.
    damping_ratio, std_hz : mapping of dof to array_like, optional
        Of each, in the order of ``freq_hz``; NaN where not known. Dofs may be missing.
    sees : {"frf", "transmissibility", None}
        What the antiresonances were identified from, see Notes.
    channels : iterable of dof, optional
        All responses that were measured together, a dof each; default: those of ``freq_hz``. Empty where some
        of them have no name here, see :meth:`relabelled`.
    scores, diagrams, data_check, options : optional
        As the attributes.

    Attributes
    ----------
    order : int
        How many forces acted at once, r; of so many dofs each key consists.
    options : dict
        How it was identified: every option by name, the band, the package's version; of a record "fs_hz",
        "response_level", how strongly it shook, in its unit, and where it was judged "held_back_misfit", what
        one fit of half of it leaves of the other half over noise. Empty for sets made by hand or joined.
    tables : dict
        By dof: one ``ResponseTable``, from which ``damping_ratio``, ``std_hz`` and ``scores`` are taken.
    edits : tuple of Edit
        What was dropped and added by hand, in order.
    left_out : dict of ResponseTable
        By dof: what fits saw and did not accept, with the score "why".
    unexplained_hz : dict
        By dof: peaks of its curve beside which nothing was seen.
    diagrams, data_check
        The stabilization diagram by dof, and whether the data were fit; not saved.

    Notes
    -----
    Where a sensor sits on a node of a mode, the root of its numerator on that resonance cancels in its FRF.
    Transmissibilities to it have a peak there: they lose only roots that all ``channels`` share. So a model
    is compared with its antiresonances less the cancelled ones for ``sees="frf"``, and for
    ``sees="transmissibility"`` with the cancelled ones that not all channels share. With None, for sets made
    by hand and from older files, a cancelled root may be the partner of a value, and need not be.

    Of r unknown forces that act at once the antiresonances of order r stand by sets of r responses: roots of
    det(K - w^2 M) with the rows of the responses and the columns of the forces deleted; r = 1 is one force. A
    key is the tuple of the responses, numbers ascending and other dofs in the order of ``channels``, and may
    be asked for in any order; ``excitation`` is the tuple of the forces.

    Examples
    --------
    >>> import antires_rs as ar
    >>> print(ar.AntiresonanceSet(0, {0: [23.9, 8.7], 2: []}))
    antiresonances, force at 0
    dof  freq_hz
      0    8.700
          23.900
      2        -
    >>> both = ar.AntiresonanceSet([0, 4], {(5, 1): [36.2, 58.5]})
    >>> both.order, both[1, 5].tolist(), list(both)
    (2, [36.2, 58.5], [(1, 5)])
    """

    excitation: Any = None
    order: int = 1
    tables: Mapping[Any, ResponseTable] = FrozenDict()
    sees: Sees = None
    channels: tuple[Any, ...] = ()
    options: Mapping[str, Any] = FrozenDict()
    diagrams: Mapping[Any, Any] = FrozenDict()
    left_out: Mapping[Any, ResponseTable] = FrozenDict()
    unexplained_hz: Mapping[Any, FloatArray] = FrozenDict()
    data_check: DataCheck | None = None
    edits: tuple[Edit, ...] = ()
    _original: Self | None = None

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
        options: Mapping[str, Any] | None = None,
    ) -> None:
        choice("sees", sees, ("frf", "transmissibility", None))
        if not isinstance(freq_hz, Mapping) or not freq_hz:
            got = "an empty mapping" if isinstance(freq_hz, Mapping) else type(freq_hz).__name__
            wanted = "a mapping of dof to frequencies in Hz, e.g. {0: [12.2, 36.2], 1: []}"
            reject("freq_hz", got, wanted, "Pass a dict; an empty list stands for no antiresonance.")
        force = force_label("excitation", excitation)
        if isinstance(channels, str | bytes) or not isinstance(channels, Iterable | None):
            reject("channels", channels, "a list of dofs", "Put the dofs in a list, such as channels=[0, 1].")
        named_once = dict.fromkeys(label("channels", dof) for dof in channels or ())
        listed = None if channels is None else tuple(named_once)
        named = key_of(force, freq_hz, listed or ())
        tables = tables_of(freq_hz, damping_ratio, std_hz, scores, named)
        drawn = {dof: one for dof, one in (diagrams or {}).items() if hasattr(one, "unexplained_hz")}
        self._fill(excitation=force, order=len(members(force)), tables=FrozenDict(tables), sees=sees)
        missing = [dof for dof in self._responses() if dof not in listed] if listed else []
        if missing:
            remedy = "Add it: it was measured too. Leave channels out if there were no others."
            reject("channels", f"{listed} without {missing[0]!r}", "every dof of freq_hz among them", remedy)
        measured = self._responses() if listed is None else listed
        self._fill(channels=measured, options=FrozenDict(options or {}))
        self._fill(diagrams=FrozenDict(diagrams or {}), data_check=data_check)
        for name in ("left_out", "unexplained_hz"):
            self._fill(**{name: FrozenDict({dof: getattr(one, name) for dof, one in drawn.items()})})

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
        """A set of tables that are there, by dof; ``evidence`` as for the constructor.

        ``edits`` were made by hand on the tables ``before``; ``left_out`` and ``unexplained_hz`` by default
        as the diagrams say.
        """
        new = cls(excitation, {dof: table.freq_hz for dof, table in tables.items()}, **evidence)
        told = {"left_out": left_out, "unexplained_hz": unexplained_hz}
        new._fill(**{name: FrozenDict(given) for name, given in told.items() if given is not None})
        if edits and before is not None:
            sight: dict[str, Any] = {name: evidence.get(name) for name in ("sees", "channels")}
            sight |= {name: getattr(new, name) for name in told}
            new._fill(_original=cls.from_tables(excitation, before, **sight))
        new._fill(tables=FrozenDict(zip(new.tables, tables.values(), strict=True)), edits=tuple(edits))
        return new

    def _responses(self) -> tuple[Any, ...]:
        """Dofs of all keys; numbers ascend where keys have several."""
        if self.order == 1:
            return tuple(self.tables)
        dofs = dict.fromkeys(dof for key in self.tables for dof in key)
        return tuple(sorted(dofs) if all(isinstance(dof, int) for dof in dofs) else dofs)

    def _key(self, dof: Any) -> Any:
        """A key as the set has it, whose dofs may be given in any order."""
        if self.order == 1 or not isinstance(dof, list | tuple):
            return dof
        given = Dofs(dof)
        return next((key for key in self.tables if set(key) == set(given)), given)

    @property
    def damping_ratio(self) -> Mapping[Any, FloatArray]:
        """By dof: NaN where not known, without the dofs with none known."""
        return self._known("damping_ratio")

    @property
    def share(self) -> Mapping[Any, FloatArray]:
        """How often perturbed fits, or fits over windows, saw each value, 0 to 1; NaN for other fits."""
        found = {dof: t.scores.get("share", np.full(len(t), np.nan)) for dof, t in self.tables.items()}
        return FrozenDict({dof: frozen(own.astype(np.float64)) for dof, own in found.items()})

    @property
    def expected_false(self) -> float | None:
        """Bound on how many values are false, on average; None where no search by perturbed fits tells all.

        The score ``expected_false`` bounds those of a response with at least the share of a value; all with
        less are counted as false, from the share on that gives the least sum. Values by hand count as right.
        """
        total = 0.0
        for table in self.tables.values():
            if "expected_false" not in table.scores:
                return None
            bound = np.sort(table.scores["expected_false"][~table.by_hand])
            if np.isnan(bound).any():
                return None
            total += float(np.min(bound + np.arange(bound.size)[::-1], initial=bound.size))
        return total

    @property
    def followed(self) -> Mapping[Any, NDArray[np.int64]]:
        """By dof, where values were followed (``near=``): of which value each is, by its index, or -1."""
        given = {dof: t.scores["followed"] for dof, t in self.tables.items() if "followed" in t.scores}
        numbers = {dof: np.nan_to_num(own, nan=-1).astype(np.int64) for dof, own in given.items()}
        return FrozenDict({dof: frozen(own) for dof, own in numbers.items()})

    @property
    def not_seen(self) -> Mapping[Any, FloatArray]:
        """By dof, where values were followed: those in Hz that are not seen in this test."""
        out = {dof: t for dof, t in self.left_out.items() if dof in self.followed}
        unseen = {dof: t.scores["why"] == NOT_SEEN if len(t) else [] for dof, t in out.items()}
        return FrozenDict({dof: out[dof].take(rows).freq_hz for dof, rows in unseen.items()})

    @property
    def std_hz(self) -> Mapping[Any, FloatArray]:
        """Standard deviations by dof: NaN where not known, without the dofs with none known."""
        return self._known("std_hz")

    @property
    def scores(self) -> Mapping[Any, Mapping[str, NDArray[Any]]]:
        """By dof: what speaks for each, arrays by name, see :mod:`antires_rs.identification.scores`."""
        return FrozenDict({dof: table.scores for dof, table in self.tables.items() if table.scores})

    def columns(self, dof: Any) -> dict[str, FloatArray]:
        """Frequency, damping ratio and standard deviation of a dof, (n,) each; NaN where not known."""
        return {name: getattr(self.tables[self._key(dof)], name) for name in NUMBERS}

    def by_hand(self) -> set[tuple[Any, float]]:
        """(dof, frequency in Hz) of what is there because it was added by hand."""
        return {(dof, f) for dof, one in self.tables.items() for f in one.freq_hz[one.by_hand].tolist()}

    def __getitem__(self, dof: Any) -> FloatArray:
        return self.tables[self._key(dof)].freq_hz

    def __iter__(self) -> Iterator[Any]:
        return iter(self.tables)

    def __len__(self) -> int:
        return len(self.tables)

    def __eq__(self, other: object) -> bool:
        """Same excitation, dofs and values, bit for bit; diagrams, scores and edits do not count."""
        if not isinstance(other, AntiresonanceSet):
            return NotImplemented
        return (
            self.excitation == other.excitation
            and self.tables.keys() == other.tables.keys()
            and all(table.same_as(other.tables[dof]) for dof, table in self.tables.items())
        )

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        counts = ", ".join(f"{dof!r}: {len(table)}" for dof, table in self.tables.items())
        return f"{type(self).__name__}(excitation={self.excitation!r}, values by dof {{{counts}}})"

    def _known(self, name: str) -> FrozenDict[Any, FloatArray]:
        columns = {dof: getattr(table, name) for dof, table in self.tables.items()}
        return FrozenDict({dof: column for dof, column in columns.items() if not _unknown(column)})

    def _dof(self, dof: Any) -> Any:
        """One of the set's keys."""
        dof = key_of(self.excitation, self.tables, self.channels)("dof", dof)
        if dof not in self.tables:
            wanted = f"one of {', '.join(map(repr, self.tables))}"
            reject("dof", dof, wanted, "Name a dof of the set; those are its keys.")
        return dof

    @keywords_left(tol_hz="1 % of the value holds")
    def drop(self, dof: Any, freq_hz: Any, *, reason: str = "") -> Self:
        """A new set without the values nearest to ``freq_hz`` (Hz, one or several).

        None may be further away than 1 % of it, or be meant twice (InvalidInputError). ``reason`` is kept in
        ``edits``.

        Examples
        --------
        >>> import antires_rs as ar
        >>> fewer = ar.AntiresonanceSet(0, {0: [8.7, 12.2], 1: 14.4}).drop(0, 12.2, reason="mains hum")
        >>> fewer[0].tolist(), str(fewer.edits[0])
        ([8.7], 'dropped 12.20 Hz at dof 0 (mains hum)')
        """
        dof = self._dof(dof)
        return self._edited(dof, *dropped(dof, self.tables[dof], freq_hz, reason))

    def add(
        self, dof: Any, freq_hz: Any, *, damping_ratio: Any = None, std_hz: Any = None, reason: str = ""
    ) -> Self:
        """A new set with more values (Hz, one or several) of one of its dofs, whose source is "by hand".

        ``damping_ratio`` and ``std_hz`` are one for all, or one each, and not known by default. A value that
        is there already is an InvalidInputError. ``reason`` is kept in ``edits``.

        Examples
        --------
        >>> import antires_rs as ar
        >>> more = ar.AntiresonanceSet(0, {0: [8.7]}).add(0, 12.2, reason="clear in the phase")
        >>> more[0].tolist(), more.tables[0].by_hand.tolist()
        ([8.7, 12.2], [False, True])
        """
        dof = self._dof(dof)
        return self._edited(dof, *added(dof, self.tables[dof], freq_hz, damping_ratio, std_hz, reason))

    def original(self) -> Self:
        """The set before the first edit by hand; itself if there was none."""
        return self if self._original is None else self._original

    def _edited(self, dof: Any, table: ResponseTable, records: Sequence[Edit]) -> Self:
        """A copy with another table of a dof; whatever else the set carries stays with it."""
        new, tables = copy.copy(self), FrozenDict({**self.tables, dof: table})
        new._fill(tables=tables, edits=(*self.edits, *records), _original=self.original())
        return new

    def relabelled(self, excitation: Any, dofs: Mapping[Any, Any] | None = None) -> Self:
        """The set with other names of the dofs, in tables and edits; diagrams and checks stay behind.

        Dofs that ``dofs``, the new name of each, lacks are left out, and the keys that hold them; if
        ``channels`` are among these, what all of them share cannot be told any more, and ``channels`` is
        empty. No dof left, or two of one name, are an InvalidInputError.
        """
        if not isinstance(dofs, Mapping):
            remedy = (
                f"Write relabelled(force, {{{next(iter(self), 0)!r}: ...}}), the name of the force first."
            )
            reject("dofs", dofs, "a mapping of each dof to its new name", remedy)
        channels = [dofs[dof] for dof in self.channels] if all(c in dofs for c in self.channels) else ()
        if self.order > 1:
            keys = [key for key in {**self.tables, **self.left_out} if all(dof in dofs for dof in key)]
            named = key_of(force_label("excitation", excitation), keys, dofs.values())
            dofs = {key: named("dofs", [dofs[dof] for dof in key]) for key in keys}
        kept = [dofs[dof] for dof in self if dof in dofs]
        if not kept:
            reject("dofs", f"none of {tuple(self)}", "a new name of one of them or more", "Check the names.")
        twice = [dof for dof in kept if kept.count(dof) > 1]
        if twice:
            got = f"{twice[0]!r} for two of {tuple(self)}"
            reject("dofs", got, "each dof once", "Name one otherwise, or leave it out.")

        def moved(tables: Mapping[Any, Any]) -> dict[Any, Any]:
            return {dofs[dof]: table for dof, table in tables.items() if dof in dofs}

        told: dict[str, Any] = {"sees": self.sees, "channels": channels, "options": self.options}
        told |= {name: moved(getattr(self, name)) for name in ("left_out", "unexplained_hz")}
        told["edits"] = [replace(edit, dof=dofs[edit.dof]) for edit in self.edits if edit.dof in dofs]
        before = moved(self.original().tables)
        return self.from_tables(excitation, moved(self.tables), before=before, **told)

    def __str__(self) -> str:
        lines = [f"antiresonances, {forces_at(self.excitation)}"]
        if self.data_check is not None:
            lines += self.data_check.cautions
            why = self.data_check.not_tested.get("force_location") if self.order == 1 else None
            grades = [table.scores.get("grade", ["sure"] * len(table)) for table in self.tables.values()]
            if why and any(grade != "weak" for own in grades for grade in own):
                lines.append(f"the place of the force could not be tested: {why}")
        lines += _rows_printed(self.tables)
        count = sum(len(table) for table in self.left_out.values())
        if count:
            whys = [str(why) for table in self.left_out.values() for why in table.scores.get("why", ())]
            reasons = "; ".join(f"{n} {why}" for why, n in Counter(filter(None, whys)).most_common())
            lines.append(f"left out: {count}{f' ({reasons})' if reasons else ''}, see .left_out")
        unexplained = sum(len(one) for one in self.unexplained_hz.values())
        if unexplained:
            lines.append(
                f"peaks of the curves at which no value was found: {unexplained}, see .unexplained_hz"
            )
        if self.edits:
            lines.append("edited by hand: " + "; ".join(map(str, self.edits)))
        return "\n".join(lines)

    @keywords_left(kind="the poles of every order are drawn")
    def plot(self, dof: Any, *, ax: Any = None) -> Any:
        """Draw the stabilization diagram of a dof, edits by hand included; returns the axes.

        Sets made by hand or loaded have none (InvalidInputError).
        """
        if self._dof(dof) not in self.diagrams:
            wanted = "a dof of a set that was identified, not made by hand or loaded"
            remedy = "Identify it from the measurement to have its diagram."
            reject("dof", f"{dof!r}, which has no stabilization diagram", wanted, remedy)
        return self._view("plot")(self.diagrams[dof], ax=ax, zeros=self, dof=dof)

    def look(
        self,
        source: Any = None,
        *,
        save_to: Any = None,
        wait: bool | None = None,
        browser: bool = True,
        **options: Any,
    ) -> Any:
        """Open a page of this computer on which the set is looked at and edited; needs bokeh.

        Parameters
        ----------
        source : Recording, FrequencyResponse or a list of either, optional
            What it was identified from. With it curves are shown, and band and orders can be changed.
        save_to : path-like, optional
            Where the page saves the set; without it the page offers a download.
        wait : bool, optional
            Return when the page was closed, or Ctrl-C. By default everywhere but in a notebook, where the
            page stands below the cell and stays open.
        browser : bool
            Open the browser; else the address is printed only.
        **options
            Of :func:`~antires_rs.identify_antiresonances`, for the page to identify again as the set was.

        Returns
        -------
        Page
            ``.zeros`` is the set as it is now, with all edits; ``.url`` the address, ``.stop()`` ends it.

        Examples
        --------
        >>> import antires_rs as ar
        >>> page = ar.AntiresonanceSet(0, {0: [8.7, 12.2]}).look(wait=False, browser=False)
        looking at antiresonances, force at 0: http://127.0.0.1:...
        >>> page.zeros[0].tolist(), page.stop()
        ([8.7, 12.2], None)
        """
        return self._view("look")(self, source, save_to, options, wait=wait, browser=browser)

    def to_dataframe(self) -> Any:
        """One row a value: dof, freq_hz, damping_ratio, std_hz (NaN where not known), source, and the scores.

        ``source`` is "by hand" or "identified". A ``pandas.DataFrame``; needs pandas.
        """
        return self._view("to_dataframe")(self)

    def to_xarray(self) -> Any:
        """An ``xarray.Dataset`` over dof and rank, NaN beyond a dof's values; needs xarray."""
        return self._view("to_xarray")(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as JSON, whole or not at all; every float comes back bit for bit. It replaces a file."""
        write_atomically(path, self.to_json().encode())

    def to_json(self) -> str:
        """The text that :meth:`save` writes."""
        version = OF_ONE_FORCE if self.order == 1 else VERSION
        data: dict[str, Any] = {"format": FORMAT, "version": version, "excitation": self.excitation}
        if self.sees is not None:
            data["sees"] = self.sees
        if self.channels != self._responses():
            data["channels"] = list(self.channels)
        if self.options:
            data["options"] = dict(self.options)
        data["dofs"] = []
        for dof, table in self.tables.items():
            row = {"dof": dof, **_row(table)}
            if dof in self.left_out:
                row["left_out"] = _row(self.left_out[dof])
            if dof in self.unexplained_hz:
                row["unexplained_hz"] = self.unexplained_hz[dof].tolist()
            data["dofs"].append(row)
        if self.edits:
            data["edits"] = [asdict(edit) for edit in self.edits]
            before = self.original().tables
            data["before_edits"] = [{"dof": dof, **_row(table)} for dof, table in before.items()]
        return json.dumps(data, indent=1, allow_nan=False) + "\n"

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read what :meth:`save` wrote, in this version or an older one; others are an InvalidInputError."""
        try:
            text = Path(path).read_text(encoding="utf-8")
        except UnicodeDecodeError as exc:
            raise damaged(str(path), ValueError("it is no text")) from exc
        return cls.from_json(text, str(path))

    @classmethod
    def from_json(cls, text: str, name: str = "text") -> Self:
        """A set from the text of :meth:`to_json`; ``name`` stands for it in messages."""
        data = marked_json(text, name, FORMAT, VERSION, _WANTED, _ANOTHER)
        try:
            force, listed = force_label("excitation", data["excitation"]), data.get("channels")
            named = key_of(force, [row["dof"] for row in data["dofs"]], listed or ())
            edits = tuple(edit_of(row) for row in data.get("edits", ()))
            left_out = [{**row["left_out"], "dof": row["dof"]} for row in data["dofs"] if "left_out" in row]
            peaks = [(row["dof"], row["unexplained_hz"]) for row in data["dofs"] if "unexplained_hz" in row]
            tables = {dof: marked(table, dof, edits) for dof, table in _read(data["dofs"], named).items()}
            return cls.from_tables(
                force,
                tables,
                edits=edits,
                before=_read(data["before_edits"], named) if edits else None,
                left_out=_read(left_out, named) if left_out else None,
                unexplained_hz={
                    Dofs.of_file(dof): frozen(frequencies_hz(f"peaks of {dof!r}", hz)) for dof, hz in peaks
                },
                sees=data.get("sees"),
                channels=listed,
                options=dict(data.get("options", {})),
            )
        except (KeyError, TypeError, ValueError, AttributeError) as exc:
            raise damaged(name, exc) from exc
