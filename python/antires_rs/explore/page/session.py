"""A set of antiresonances on the desk: edited, identified again, undone, saved."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from threading import RLock
from typing import Any

from ...exceptions import AntiresWarning
from ...measured.antiresonance_set import AntiresonanceSet
from ...measured.edits import NAMED_WITHIN
from ...measured.replay import Asked, asked_of
from ...measured.replay_file import to_json
from ...signals.frequency_response import FrequencyResponse
from ...signals.recording import Recording
from ...support.validation import frequency_band, integer, reject
from ..curve import Curve
from .kept import SessionFile
from .picks import Click, picked
from .sight import Sight
from .sources import Source, source_of

__all__ = ["Session"]


class Session:
    """A set and what may be done with it. Calls may come from several threads.

    Parameters
    ----------
    zeros : AntiresonanceSet or None
        None: :meth:`identify` makes it, and until then there are curves without values.
    source : Recording, FrequencyResponse or Source, optional
        What it was identified from: curves are shown, and band and orders may be changed.
    excitation : int or str, optional
        Of a source without a set.
    band_hz, max_order, options : optional
        With which the set was identified, and the other options of the identification.
    save_to : path-like, optional
        Where :meth:`save` writes.
    """

    def __init__(
        self,
        zeros: AntiresonanceSet | None,
        source: Recording | FrequencyResponse | Source | None = None,
        *,
        excitation: Any = None,
        band_hz: Sequence[float] | None = None,
        max_order: int | None = None,
        options: Mapping[str, Any] | None = None,
        save_to: str | os.PathLike[str] | None = None,
    ) -> None:
        self.source, self.options = source_of(source), dict(options or {})
        self.identified = zeros is not None
        if zeros is None:
            assert self.source is not None
            dofs = self.source.dofs
            zeros = AntiresonanceSet(excitation, {dof: [] for dof in dofs}, channels=dofs)
        if self.source is not None:
            diagram = next(iter(zeros.diagrams.values()), None)
            if band_hz is None:
                band_hz = self.source.whole_band if diagram is None else diagram.band_hz
            band_hz = _inside(self.source, band_hz)
        asked = asked_of(zeros)
        self._now = Sight(
            zeros,
            asked,
            (None,) * len(asked),
            None if band_hz is None else (band_hz[0], band_hz[1]),
            max_order,
        )
        self._past: list[Sight] = []
        self._future: list[Sight] = []
        self._saved: tuple[AntiresonanceSet | None, tuple[Asked, ...]] = (None, asked)
        self.file = SessionFile(None if save_to is None else Path(save_to))
        self._lock = RLock()
        #: Grows with every change, of what is saved too.
        self.turn = 0

    @property
    def now(self) -> Sight:
        """What is on the desk."""
        return self._now

    @property
    def zeros(self) -> AntiresonanceSet:
        """The set as it is now."""
        return self._now.zeros

    @property
    def can_undo(self) -> bool:
        """Whether there is something to undo."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether there is something to do again."""
        return bool(self._future)

    @property
    def unsaved(self) -> bool:
        """Whether there are edits that the file does not have, or values that are others than those saved."""
        zeros, asked = self._saved
        other = zeros is not None and self.zeros != zeros
        return self.identified and (other or self._now.asked != asked)

    @property
    def text(self) -> str:
        """What the file is to hold: the set, and the edits that wait."""
        now = self._now
        waiting = [each for each, why in zip(now.asked, now.waits, strict=True) if why is not None]
        return to_json(now.zeros, waiting)

    def click(self, dof: Any, click: Click, reason: str = "") -> str | None:
        """Do what a click means; what was done, in words, None where it hit nothing."""
        with self._lock:
            pick = picked(self.zeros, dof, click, self.curve(dof))
            if pick is None:
                return None
            if pick.action == "drop":
                return self.drop(dof, pick.freq_hz, reason)
            if pick.action == "restore":
                return self.restore(dof, pick.freq_hz)
            return self.add(dof, pick.freq_hz, reason, pick.damping_ratio, pick.std_hz)

    def drop(self, dof: Any, freq_hz: float, reason: str = "") -> str:
        """Drop a value; one that was added by hand is taken back instead."""
        with self._lock:
            for i, each in enumerate(self._now.asked):
                same = each.edit.dof == dof and each.edit.freq_hz == freq_hz
                if same and each.edit.action == "add" and self._now.waits[i] is None:
                    return self.take_back(i)
            return self._edited(self.zeros.drop(dof, freq_hz, reason=reason))

    def add(
        self,
        dof: Any,
        freq_hz: float,
        reason: str = "",
        damping_ratio: float | None = None,
        std_hz: float | None = None,
    ) -> str:
        """Add a value; one outside the band is told, one that the measurement cannot reach is refused."""
        with self._lock:
            added = self.zeros.add(dof, freq_hz, damping_ratio=damping_ratio, std_hz=std_hz, reason=reason)
            if self.source is not None:
                _reached(self.source, freq_hz)
            band = self._now.band_hz
            outside = band is not None and not band[0] <= freq_hz <= band[1]
            seen = f", outside of the band of {band[0]:g} to {band[1]:g} Hz" if band and outside else ""
            return f"{self._edited(added)}{seen}"

    def restore(self, dof: Any, freq_hz: float) -> str:
        """Bring back a value that was dropped, as it was."""
        with self._lock:
            off = {
                i: abs(each.edit.freq_hz / freq_hz - 1.0)
                for i, each in enumerate(self._now.asked)
                if (each.edit.dof, each.edit.action, self._now.waits[i]) == (dof, "drop", None)
            }
            nearest = min(off, key=off.__getitem__, default=None)
            if nearest is not None and off[nearest] < NAMED_WITHIN:
                return self.take_back(nearest)
            reject("freq_hz", f"{freq_hz:g} Hz at dof {dof!r}", "a value that was dropped", "Name another.")

    def take_back(self, number: int) -> str:
        """Take an edit back, by its place in the list; the others stay."""
        with self._lock:
            asked = self._edits(number)
            undone = asked[number].edit
            rest = [each for i, each in enumerate(asked) if i != number]
            self._step(self._now.on(self.zeros.original(), rest))
            verb = "brought back" if undone.action == "drop" else "took back"
            return f"{verb} {undone.freq_hz:.2f} Hz at dof {undone.dof}"

    def reword(self, number: int, reason: str) -> str:
        """Give an edit another reason."""
        with self._lock:
            asked = list(self._edits(number))
            if asked[number].edit.reason == reason:
                return ""
            asked[number] = asked[number].reworded(reason)
            self._step(self._now.on(self.zeros.original(), asked))
            return "reason kept"

    def identify(self, band_hz: Sequence[float] | None = None, max_order: int | None = None) -> str:
        """Identify again, and make all edits again; what became of those that wait is told by :attr:`now`.

        It takes as long as it takes; until then the set stays as it was.
        """
        if self.source is None:
            reject("source", "a set alone", "the measurement too", "Open the measurement to identify again.")
        band = self._now.band_hz if band_hz is None else band_hz
        band = _inside(self.source, band)
        if max_order is not None:
            max_order = integer("max_order", max_order, low=2)
        options = {**self.options, **({} if max_order is None else {"max_order": max_order})}
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always", AntiresWarning)
            made = self.source.identify(self.zeros.excitation, band, options)
        with self._lock:
            said = tuple(line for each in heard for line in str(each.message).splitlines())
            seen = replace(self._now, band_hz=(band[0], band[1]), max_order=max_order, warned=said)
            seen = seen.on(made, self._now.asked)
            if self.identified:
                self._step(seen)
            else:  # the first one is where undo ends
                self.identified = True
                self._show(seen)
            count = sum(len(each) for each in made.values())
            return f"identified {count} values in {band[0]:g} to {band[1]:g} Hz"

    def undo(self) -> str:
        """Go back to what was before the last change, of edits, band or orders."""
        return self._moved(self._past, self._future, "undone")

    def redo(self) -> str:
        """Do again what was undone."""
        return self._moved(self._future, self._past, "done again")

    def save(self, *, replace_file: bool = False) -> str:
        """Write the set, and the edits that wait, where it belongs.

        Raises
        ------
        InvalidInputError
            A file of that name is there that this session has not written, and ``replace_file`` is False;
            there is no name; or the file cannot be written.
        """
        with self._lock:
            name = self.file.write(self.text, replace_file=replace_file)
            self._saved = (self.zeros, self._now.asked)
            self.turn += 1
            waiting = sum(why is not None for why in self._now.waits)
            kept = f"; of its edits {waiting} still wait{'s' * (waiting == 1)}" if waiting else ""
            return f"saved {name}{kept}"

    def keep_unsaved(self) -> Path | None:
        """Write what was not saved beside the file; where it is, None if there was nothing or no file."""
        with self._lock:
            return self.file.write_beside(self.text) if self.unsaved else None

    def opened(self, asked: Sequence[Asked], path: Path | None = None) -> None:
        """Say that the set came from a file with these edits: ``path``, where it may be written back."""
        self._now = self._now.on(self.zeros.original(), asked)
        self._saved = (None, self._now.asked)
        if path is not None:
            self._saved = (self.zeros, self._now.asked)
            self.file = SessionFile(path)
            self.file.opened()

    def make_again(self, edits: Sequence[Asked]) -> None:
        """Make the edits of another set, as far as this one can take them; the others wait."""
        now = self._now
        if edits and self.identified:
            self._step(now.on(self.zeros.original(), [*now.asked, *edits]))
        elif edits:
            self._now = replace(now, asked=tuple(edits), waits=("not identified yet",) * len(edits))

    def curve(self, dof: Any) -> Curve | None:
        """What was measured at a response, on the lines of the band."""
        source, band = self.source, self._now.band_hz
        return None if source is None or band is None else source.curve(dof, band, self.options)

    def _edits(self, number: int) -> tuple[Asked, ...]:
        asked = self._now.asked
        if not 0 <= number < len(asked):
            reject(
                "number", number, f"an edit from 0 to {len(asked) - 1}", "Look again: the list has changed."
            )
        return asked

    def _edited(self, zeros: AntiresonanceSet) -> str:
        edit = zeros.edits[-1]
        now = self._now
        asked = (*now.asked, Asked.on(zeros.original(), edit))
        self._step(replace(now, zeros=zeros, asked=asked, waits=(*now.waits, None)))
        return str(edit)

    def _step(self, sight: Sight) -> None:
        self._past.append(self._now)
        self._future.clear()
        self._show(sight)

    def _show(self, sight: Sight) -> None:
        self._now = sight
        self.turn += 1

    def _moved(self, source: list[Sight], target: list[Sight], said: str) -> str:
        with self._lock:
            if not source:
                return f"nothing to be {said}"
            target.append(self._now)
            self._show(source.pop())
            return said


def _inside(source: Source, band_hz: Any) -> tuple[float, float]:
    """A band inside what the source covers."""
    low, high = source.covered_hz
    return frequency_band("band_hz", band_hz, low_hz=low, high_hz=high)


def _reached(source: Source, freq_hz: float) -> None:
    """Refuse a frequency of which the measurement cannot tell."""
    low, high = source.covered_hz
    if not low <= freq_hz <= high:
        wanted = f"a frequency from {low:g} to {high:g} Hz, as the data reach"
        reject("freq_hz", f"{freq_hz:g} Hz", wanted, "Correct it.")
