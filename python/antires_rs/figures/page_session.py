"""A set of antiresonances on the desk: edited, identified again, saved."""

from __future__ import annotations

import math
import os
import tempfile
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, replace
from itertools import combinations, islice
from pathlib import Path
from threading import Lock, RLock
from typing import Any

import numpy as np

from ..exceptions import AntiresError, AntiresWarning, InvalidInputError, reject
from ..identification.identify import Hit, identify_antiresonances, identify_roving
from ..identification.options import sorted_out
from ..identification.stabilization import StabilizationDiagram
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.edits import NAMED_WITHIN
from ..measured.replay import Asked, asked_of, replayed, to_json
from ..measured.response_table import MOST_SETS, doubts_of
from ..signals.averaging import Averages, Averaging, average
from ..signals.frequency_response import FrequencyResponse, covered_hz
from ..signals.recording import Recording
from ..support.checks import Dofs, FloatArray, finite_scalar, force_label, frequency_band, integer
from ..support.files import write_atomically
from .identification import SEEN_ABOVE, Curve, curve_of, evidence_figure, mark_columns, pole_table
from .live_canvas import item


@dataclass(frozen=True)
class Sight:
    """A set with the edits that it can take; all edits, and why each waits, None where it was made."""

    zeros: AntiresonanceSet
    asked: tuple[Asked, ...] = ()
    waits: tuple[str | None, ...] = ()
    band_hz: tuple[float, float] | None = None
    max_order: int | None = None
    warned: tuple[str, ...] = ()

    def on(self, base: AntiresonanceSet, asked: Sequence[Asked]) -> Sight:
        """With these edits on a set without any."""
        zeros, waits = replayed(base, asked)
        return replace(self, zeros=zeros, asked=tuple(asked), waits=tuple(waits))


# -- The file of a session: nothing of others is replaced unasked, and what was not saved finds a place

TAKEN = "file"  # what the error is about where a file is not as this session left it


class SessionFile:
    """Where a session is saved; without a path the set can only be downloaded, or taken from Python."""

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self._own: tuple[int, int, int] | None = None

    def opened(self) -> None:
        """Say that the session knows what stands in the file now, and may replace it."""
        self._own = self._there()

    def write(self, text: str, *, replace_file: bool = False) -> str:
        """Write the text; the name of the file."""
        if self.path is None:
            reject("path", None, "a file to write", "Download the set instead.")
        found = self._there()
        if found is not None and found != self._own and not replace_file:
            how = "is there already" if self._own is None else "something else has changed meanwhile"
            wanted = "a file that is not there yet, or as this page left it"
            reject(TAKEN, f"{self.path}, which {how}", wanted, "Replace it, or download the set.")
        _write(self.path, text)
        self.opened()
        return self.path.name

    def write_beside(self, text: str) -> Path | None:
        """Write to a new file beside, or where that cannot be in the folder for temporary files; its path."""
        if self.path is None:
            return None
        for folder in (self.path.parent, Path(tempfile.gettempdir())):
            names = (folder / f"{self.path.stem}_unsaved{f'_{i}' * (i > 1)}.json" for i in range(1, 1000))
            with suppress(AntiresError):
                free = next(path for path in names if not path.exists())
                _write(free, text)
                return free
        got = f"{self.path.parent} and {tempfile.gettempdir()}, in neither of which a file can be written"
        reject("path", got, "a folder for edits that were not saved", "Make room there.")

    def _there(self) -> tuple[int, int, int] | None:
        """What tells a version of the file from another; None for no file."""
        with suppress(OSError):
            found = self.path.stat() if self.path else None
            return found and (found.st_mtime_ns, found.st_size, found.st_ino)
        return None


def _write(path: Path, text: str) -> None:
    try:
        write_atomically(path, text.encode())
    except OSError as exc:
        got = f"{path}, which cannot be written ({exc.strerror or exc})"
        wanted = "a file in a folder in which you may write, on a disk with room"
        raise InvalidInputError("path", got, wanted, "Download the set to another place.") from exc


# -- What a set on the desk was identified from, and can be again

Band = tuple[float, float]


class OneMeasurement:
    """A record, or FRFs; repeated ones as one."""

    def __init__(self, signal: Recording | FrequencyResponse) -> None:
        self._signal = signal
        self._averages: dict[Band, Averages] = {}
        self.dofs: tuple[Any, ...] = signal.dofs
        self.covered_hz = covered_hz(signal)
        if isinstance(signal, Recording):
            self.whole_band = 0.005 * signal.fs_hz, 0.4 * signal.fs_hz
        else:
            self.whole_band = float(signal.freq_hz[signal.freq_hz > 0.0][0]), float(signal.freq_hz[-1])

    def identify(self, excitation: Any, band_hz: Band, options: Mapping[str, Any]) -> AntiresonanceSet:
        """As :func:`~antires_rs.identify_antiresonances`."""
        given = {"excitation": excitation, "band_hz": band_hz, "progress": False}
        return identify_antiresonances(self._signal, **given, **sorted_out(options))

    def curve(self, dof: Any, band_hz: Band, options: Mapping[str, Any]) -> Curve | None:
        """That of the channel."""
        signal = self._signal
        if isinstance(signal, Recording) and band_hz not in self._averages:
            names = ("nperseg", "noverlap", "window", "method")
            chosen = Averaging(**{name: options[name] for name in names if name in options})
            with_force = signal.force is not None
            self._averages = {band_hz: average(signal, band_hz, chosen, include_force=with_force)}
        return curve_of(signal, self._averages.get(band_hz), dof)


class RovingHammer:
    """A measurement for each place that was hit, and the sensor that stayed: by reciprocity its responses."""

    covered_hz: Band
    whole_band: Band

    def __init__(self, hits: Sequence[Hit], sensor: Any) -> None:
        self._hits, self._sensor = tuple(hits), sensor
        self._places: dict[Any, tuple[OneMeasurement, Any]] = {}
        for hit in hits:
            one = OneMeasurement(hit.signal)
            # A hit at the sensor itself shows all responses.
            own = {dof: dof for dof in one.dofs} if hit.force == sensor else {hit.force: sensor}
            for dof, channel in own.items():
                self._places.setdefault(dof, (one, channel))
        self.dofs = tuple(self._places)
        for name in ("covered_hz", "whole_band"):
            low, high = zip(*(getattr(one, name) for one, _ in self._places.values()), strict=True)
            setattr(self, name, (max(low), min(high)))

    def identify(self, excitation: Any, band_hz: Band, options: Mapping[str, Any]) -> AntiresonanceSet:
        """Each by itself, joined."""
        return identify_roving(self._hits, self._sensor, band_hz, progress=False, **options)

    def curve(self, dof: Any, band_hz: Band, options: Mapping[str, Any]) -> Curve | None:
        """That of the sensor under the hit there."""
        one, channel = self._places.get(dof, (None, None))
        return None if one is None else one.curve(channel, band_hz, options)


Source = OneMeasurement | RovingHammer


# -- What a click means: the value, pole or dip that is nearest to it

REACH_PX = 9.0  # how far from a thing a click may be, in pixels


@dataclass(frozen=True)
class Click:
    """Where in a figure: its name, the place in units of the axes, and how much of them a pixel is."""

    figure: str
    x: float
    y: float
    x_per_px: float
    y_per_px: float

    def nearest(self, values: FloatArray) -> int | None:
        """Which of some places across was hit, if any."""
        off = np.abs(values - self.x)
        at = int(np.argmin(off)) if off.size else None
        return at if at is not None and off[at] <= REACH_PX * self.x_per_px else None


@dataclass(frozen=True)
class Pick:
    """What to do: "drop" or "add" a value, or "restore" one that was dropped."""

    action: str
    freq_hz: float
    damping_ratio: float | None = None
    std_hz: float | None = None


def picked(zeros: AntiresonanceSet, dof: Any, click: Click, curve: Curve | None = None) -> Pick | None:
    """What a click asks for: the line of a value goes before what lies beside it. None: nothing is near."""
    now, before = zeros[dof], zeros.original()[dof]
    for values, action in ((now, "drop"), (before[~np.isin(before, now)], "restore")):
        if (at := click.nearest(values)) is not None:
            return Pick(action, float(values[at]))
    if click.figure == "stabilization" and dof in zeros.diagrams:
        return _pole(zeros.diagrams[dof], click)
    return _dip(curve, click) if click.figure == "curve" and curve is not None else None


def _pole(diagram: StabilizationDiagram, click: Click) -> Pick | None:
    """What fits saw and did not accept, whose marks stand above the poles; or the nearest pole."""
    table, at = diagram.left_out, click.nearest(diagram.left_out.freq_hz)
    above = float(diagram.orders[-1]) + SEEN_ABOVE - REACH_PX * click.y_per_px
    if at is not None and click.y >= above:
        return Pick("add", float(table.freq_hz[at]), *_known(table.damping_ratio[at], table.std_hz[at]))
    order, freq, damping, stable = pole_table(diagram)
    off = np.hypot((freq - click.x) / click.x_per_px, (order - click.y) / click.y_per_px)
    # Of two that are nearly as near, the stable one is meant.
    at = int(np.argmin(off + np.where(stable, 0.0, 0.3 * REACH_PX))) if off.size else None
    return None if at is None or off[at] > REACH_PX else Pick("add", float(freq[at]), float(damping[at]))


def _dip(curve: Curve, click: Click) -> Pick | None:
    """The lowest line near the click, if it is lower than its neighbours on both sides."""
    off = np.abs(curve.freq_hz - click.x)
    near = np.flatnonzero(off <= max(REACH_PX * click.x_per_px, off.min()))
    at, size = int(near[np.argmin(curve.size[near])]), curve.size
    dip = 0 < at < size.size - 1 and size[at] <= min(size[at - 1], size[at + 1])
    return Pick("add", float(curve.freq_hz[at])) if dip else None


def _known(*values: Any) -> list[float | None]:
    """Numbers, None for NaN."""
    return [None if np.isnan(value) else float(value) for value in values]


class Session:
    """A set, what it was identified from, and what may be done; threads that change it take its ``lock``."""

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
        if isinstance(source, Recording | FrequencyResponse):
            source = OneMeasurement(source)
        self.source, self.options = source, dict(options or {})
        self.identified = zeros is not None
        if zeros is None:
            assert self.source is not None
            dofs = self.source.dofs
            force = force_label("excitation", excitation)
            keys = combinations(dofs, len(force)) if isinstance(force, Dofs) else dofs
            zeros = AntiresonanceSet(force, {key: [] for key in islice(keys, MOST_SETS)}, channels=dofs)
        asked = asked_of(zeros)
        band = None if band_hz is None else (band_hz[0], band_hz[1])
        if self.source is not None:
            diagram = next(iter(zeros.diagrams.values()), None)
            own_hz = self.source.whole_band if diagram is None else diagram.band_hz
            band = _inside(self.source, band or own_hz)
        self.now = Sight(zeros, asked, (None,) * len(asked), band, max_order)
        self._saved: tuple[AntiresonanceSet | None, tuple[Asked, ...]] = (None, asked)
        self.file = SessionFile(None if save_to is None else Path(save_to))
        self.lock = RLock()  # of what reads and then changes the set
        self.turn = 0  # grows with every change, of what is saved too

    @property
    def zeros(self) -> AntiresonanceSet:
        """The set as it is now."""
        return self.now.zeros

    @property
    def unsaved(self) -> bool:
        """Whether there are edits that the file does not have, or values that are others than those saved."""
        zeros, asked = self._saved
        other = zeros is not None and self.zeros != zeros
        return self.identified and (other or self.now.asked != asked)

    @property
    def text(self) -> str:
        """What the file is to hold: the set, and the edits that wait."""
        now = self.now
        return to_json(now.zeros, [each for each, why in zip(now.asked, now.waits, strict=True) if why])

    def click(self, dof: Any, click: Click, reason: str = "") -> str | None:
        """Do what a click means; what was done, in words, None where it hit nothing."""
        pick = picked(self.zeros, dof, click, self.curve(dof))
        if pick is None:
            return None
        if pick.action == "add":
            return self.add(dof, pick.freq_hz, reason, pick.damping_ratio, pick.std_hz)
        if pick.action == "drop":
            return self.drop(dof, pick.freq_hz, reason)
        return self.restore(dof, pick.freq_hz)

    def drop(self, dof: Any, freq_hz: float, reason: str = "") -> str:
        """Drop a value; one that was added by hand is taken back instead."""
        for i, added_hz in self._made("add", dof).items():
            if added_hz == freq_hz:
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
        """Add a value."""
        added = self.zeros.add(dof, freq_hz, reason=reason, damping_ratio=damping_ratio, std_hz=std_hz)
        low, high = (0.0, math.inf) if self.source is None else self.source.covered_hz
        if not low <= freq_hz <= high:
            reject("freq_hz", f"{freq_hz:g} Hz", f"{low:g} to {high:g} Hz, as the data reach", "Correct it.")
        band, said = self.now.band_hz, self._edited(added)
        if band is None or band[0] <= freq_hz <= band[1]:
            return said
        return f"{said}, outside of the band of {band[0]:g} to {band[1]:g} Hz"

    def restore(self, dof: Any, freq_hz: float) -> str:
        """Bring back a value that was dropped, as it was."""
        off = {i: abs(dropped_hz / freq_hz - 1.0) for i, dropped_hz in self._made("drop", dof).items()}
        nearest = min(off, key=off.__getitem__, default=None)
        if nearest is None or off[nearest] >= NAMED_WITHIN:
            reject("freq_hz", f"{freq_hz:g} Hz at dof {dof!r}", "a value that was dropped", "Name another.")
        return self.take_back(nearest)

    def take_back(self, number: int) -> str:
        """Take an edit back, by its place in the list; the others stay."""
        asked = self.now.asked
        if not 0 <= number < len(asked):
            wanted, remedy = f"an edit from 0 to {len(asked) - 1}", "The list has changed: look again."
            reject("number", number, wanted, remedy)
        undone = asked[number].edit
        self._show(self.now.on(self.zeros.original(), asked[:number] + asked[number + 1 :]))
        verb = "brought back" if undone.action == "drop" else "took back"
        return f"{verb} {undone.freq_hz:.2f} Hz at dof {undone.dof}"

    def identify(self, band_hz: Sequence[float] | None = None, max_order: int | None = None) -> str:
        """Identify again and make all edits again; until that is done the set stays as it was."""
        if self.source is None:
            reject("source", "a set alone", "the measurement too", "Open the measurement to identify again.")
        band = _inside(self.source, self.now.band_hz if band_hz is None else band_hz)
        options = self.options
        if max_order is not None:
            max_order = integer("max_order", max_order, low=2)
            options = {**options, "max_order": max_order}
        with warnings.catch_warnings(record=True) as heard:
            warnings.simplefilter("always", AntiresWarning)
            made = self.source.identify(self.zeros.excitation, band, options)
        said = tuple(line for each in heard for line in str(each.message).splitlines())
        with self.lock:
            seen = replace(self.now, band_hz=band, max_order=max_order, warned=said).on(made, self.now.asked)
            self.identified = True
            self._show(seen)
        return f"identified {sum(map(len, made.values()))} values in {band[0]:g} to {band[1]:g} Hz"

    def save(self, *, replace_file: bool = False) -> str:
        """Write the set, and the edits that wait, where it belongs."""
        name = self.file.write(self.text, replace_file=replace_file)
        self._saved = (self.zeros, self.now.asked)
        self.turn += 1
        waiting = sum(why is not None for why in self.now.waits)
        return f"saved {name}" + f"; of its edits {waiting} still wait{'s' * (waiting == 1)}" * bool(waiting)

    def keep_unsaved(self) -> Path | None:
        """Write what was not saved beside the file; where it is, None if there was nothing or no file."""
        with self.lock:
            return self.file.write_beside(self.text) if self.unsaved else None

    def opened(self, asked: Sequence[Asked], path: Path | None = None) -> None:
        """Say that the set came from a file with these edits: ``path``, where it may be written back."""
        self.now = self.now.on(self.zeros.original(), asked)
        self._saved = (None if path is None else self.zeros, self.now.asked)
        if path is not None:
            self.file = SessionFile(path)
            self.file.opened()

    def make_again(self, edits: Sequence[Asked]) -> None:
        """Make the edits of another set, as far as this one can take them; the others wait."""
        now = self.now
        if edits and self.identified:
            self._show(now.on(self.zeros.original(), [*now.asked, *edits]))
        elif edits:
            self.now = replace(now, asked=tuple(edits), waits=("not identified yet",) * len(edits))

    def curve(self, dof: Any) -> Curve | None:
        """What was measured at a response, on the lines of the band."""
        source, band = self.source, self.now.band_hz
        return None if source is None or band is None else source.curve(dof, band, self.options)

    def _made(self, action: str, dof: Any) -> dict[int, float]:
        """Numbers and frequencies of the edits of a kind that were made at a response."""
        each = enumerate(zip(self.now.asked, self.now.waits, strict=True))
        made = {i: one.edit for i, (one, why) in each if why is None}
        return {i: edit.freq_hz for i, edit in made.items() if (edit.action, edit.dof) == (action, dof)}

    def _edited(self, zeros: AntiresonanceSet) -> str:
        edit, now = zeros.edits[-1], self.now
        asked = (*now.asked, Asked.on(zeros.original(), edit))
        self._show(replace(now, zeros=zeros, asked=asked, waits=(*now.waits, None)))
        return str(edit)

    def _show(self, sight: Sight) -> None:
        self.now = sight
        self.turn += 1


def _inside(source: Source, band_hz: Any) -> Band:
    low, high = source.covered_hz
    return frequency_band("band_hz", band_hz, low_hz=low, high_hz=high)


def rows_of(zeros: AntiresonanceSet) -> list[dict[str, Any]]:
    """One row a value: what the table of the page says."""
    rows: list[dict[str, Any]] = []
    for at, (dof, table) in enumerate(zeros.tables.items()):
        words = doubts_of(table)
        grades = table.scores.get("grade", np.full(len(table), ""))
        shares = [f", {share:.0%}" if share == share else "" for share in zeros.share[dof].tolist()]
        for i, by_hand in enumerate(table.by_hand):
            std, damping = _known(table.std_hz[i], 100.0 * table.damping_ratio[i])
            row = {"dof": at, "freq_hz": float(table.freq_hz[i]), "std_hz": std, "damping_percent": damping}
            grade, doubts = ("by hand", "") if by_hand else (f"{grades[i]}{shares[i]}", ", ".join(words[i]))
            rows.append(row | {"grade": grade, "doubts": doubts})
    return rows


# -- What a server asks of what it shows

Arguments = Mapping[str, Any]


class View:
    """What the server shows: a set that is edited, or as it is the reason why there is none."""

    slow: frozenset[str] = frozenset()  # commands that take long; the others are answered at once

    def __init__(self, title: str, why: Exception | None = None) -> None:
        self.title, self._why = title, why

    def state(self, shown: int) -> dict[str, Any]:
        """What stands beside the figures, as plain data."""
        raise self._why or NotImplementedError

    def figure(self, shown: int) -> dict[str, Any]:
        """A figure as ``Bokeh.embed.embed_item`` takes it."""
        raise self._why or NotImplementedError

    def do(self, command: str, arguments: Arguments) -> str:
        """Carry out a command; what was done, in words."""
        raise self._why or NotImplementedError

    def file(self) -> tuple[str, str] | None:
        """Name and text of what can be downloaded."""
        return None


# -- What the page may ask for: each command by name, its arguments checked, in plain data both ways

MOST = 1_000_000  # no number of a response, an edit or an order is larger


class SetView(View):
    """The page of a set."""

    slow = frozenset({"identify"})

    def __init__(self, session: Session, title: str) -> None:
        super().__init__(title)
        self.session = session
        self._drawing = Lock()
        self._drawn: tuple[Sight, int, dict[str, Any]] | None = None
        self._commands: dict[str, Callable[[Arguments], str]] = {
            "click": self._click,
            "drop": lambda a: session.drop(self._dof(a), _number(a, "freq_hz"), _text(a, "reason")),
            "add": lambda a: session.add(self._dof(a), _number(a, "freq_hz"), _text(a, "reason")),
            "take_back": lambda a: session.take_back(_whole(a, "number")),
            "identify": self._identify,
            "save": lambda a: session.save(replace_file=a.get("replace") is True),
        }

    def state(self, shown: int) -> dict[str, Any]:
        """Table, edits and what may be done, and the marks of the response that is shown."""
        session, dof = self.session, self._at(shown)
        turn = session.turn  # before what it is of: never newer than that
        now = session.now
        zeros, band = now.zeros, now.band_hz
        edits = []
        for each, why in zip(now.asked, now.waits, strict=True):
            edits.append({"text": str(each.edit), "waits": why})
        checked = () if zeros.data_check is None else zeros.data_check.warnings
        around = zeros.diagrams[dof].band_hz if dof in zeros.diagrams else band or (0.0, 1.0)
        return {
            "turn": turn,
            "excitation": str(zeros.excitation),
            "dofs": [str(each) for each in zeros],
            "dof": shown,
            "edits": edits,
            "rows": rows_of(zeros),
            "marks": mark_columns(zeros, dof, around),
            "band_hz": None if band is None else list(band),
            "max_order": now.max_order,
            "identified": session.identified,
            "can_identify": session.source is not None,
            "unsaved": session.unsaved,
            "file": None if session.file.path is None else str(session.file.path),
            "warnings": list(now.warned) or [f"data check: {line}" for line in checked],
        }

    def figure(self, shown: int) -> dict[str, Any]:
        """Everything that speaks for the values of a response."""
        with self._drawing:
            session, now = self.session, self.session.now
            if self._drawn is None or self._drawn[0] is not now or self._drawn[1] != shown:
                dof = self._at(shown)
                around = session.curve(dof), now.band_hz
                made = evidence_figure(session.zeros, dof, *around, every_kind=True)
                self._drawn = (now, shown, item(made))
            return self._drawn[2]

    def do(self, command: str, arguments: Arguments) -> str:
        """One of the commands above; the slow ones wait for no other and hold up none."""
        if command not in self._commands:
            reject("command", command, f"one of {', '.join(self._commands)}", "Load the page again.")
        with nullcontext() if command in self.slow else self.session.lock:
            return self._commands[command](arguments)

    def file(self) -> tuple[str, str]:
        """What saving writes."""
        path = self.session.file.path
        return "antiresonances.json" if path is None else path.name, self.session.text

    def _click(self, a: Arguments) -> str:
        place = (_number(a, name) for name in ("x", "y", "x_per_px", "y_per_px"))
        said = self.session.click(self._dof(a), Click(_text(a, "figure"), *place), _text(a, "reason"))
        return said or "nothing there: click a pole, a dip or the line of a value"

    def _identify(self, a: Arguments) -> str:
        band = None if a.get("low_hz") is None else (_number(a, "low_hz"), _number(a, "high_hz"))
        return self.session.identify(band, None if a.get("max_order") is None else _whole(a, "max_order"))

    def _dof(self, a: Arguments) -> Any:
        return self._at(_whole(a, "dof"))

    def _at(self, number: int) -> Any:
        dofs = list(self.session.zeros)
        if not 0 <= number < len(dofs):
            reject("dof", number, f"a response from 0 to {len(dofs) - 1}", "Load the page again.")
        return dofs[number]


def _number(a: Arguments, name: str) -> float:
    return finite_scalar(name, a.get(name))


def _whole(a: Arguments, name: str) -> int:
    return integer(name, a.get(name), low=0, high=MOST)


def _text(a: Arguments, name: str) -> str:
    value = a.get(name, "")
    if not isinstance(value, str) or len(value) > 1000:
        reject(name, type(value).__name__, "a text of at most 1,000 characters", "Shorten it.")
    return value
