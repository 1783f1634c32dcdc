"""From the [data] of a job, or of a command, to signals and antiresonances at dofs of its model."""

from __future__ import annotations

import argparse
import re
import warnings
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import contextmanager
from copy import copy
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import Any, NoReturn

from .. import io
from ..damage.options import ONE_STATE, TWO_STATES, options_with
from ..exceptions import AntiresWarning, InvalidInputError, reject
from ..identification.identify import Hit, identify_antiresonances, identify_roving
from ..identification.minors import MinorResponse, minors_of_curves
from ..identification.modes import identify_modes
from ..identification.options import sorted_out
from ..io.channels import renamed
from ..io.common import Signal
from ..io.options import READERS
from ..io.own_format import relabelled
from ..io.points import MatchedPoints, match_points
from ..io.registry import CONVERT, differences
from ..io.uff import as_point, force_of, label_of
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.structural_model import StructuralModel
from ..signals.alignment import align
from ..signals.frequency_response import FrequencyResponse, covered_hz
from ..signals.recording import Recording
from ..signals.repeats import one_source
from ..support.messages import EDIT_WANTED, edit_named, some, warn
from .arguments import dof_finder
from .command import existing, hint, say
from .job import Job, KeyPath, Place, Spell, spelled
from .keys import DATA, FOLDER, IDENTIFICATION, SECTIONS, SIGNAL_ENDINGS, format_of, shown
from .parser import nearest

# -- One file: its signal, whatever its format

_READERS: dict[str, Callable[..., Signal]] = {**READERS, FOLDER: io.read_frf_files}
#: Keys of [data] that are not a reader's.
_OURS = {"file", "repeats", "format", "excitation", "band_hz", "dofs", "points", "drop", "add"}


def read_signal(file: Path, kind: str, options: Mapping[str, Any], spell: Spell = Job.spelled) -> Signal:
    """Read a signal by keys of [data]; ``spell`` writes an argument of a reader as this user would."""
    chosen = {name: value for name, value in options.items() if name not in _OURS}
    for name in chosen:
        key = DATA.key(name)
        if key and key.of and kind not in key.of:
            reject(name, f"it for a {kind} file", f"{name} with {' or '.join(key.of)} alone", "Leave it out.")
    if kind == FOLDER and "format" in options:
        chosen["format"] = options["format"]
    if chosen.get("force") is False:
        chosen["force"] = None
    dofs: Any = options.get("dofs", [])
    named = isinstance(dofs, dict)
    given = [None if dof is False else dof for dof in (dofs.values() if named else dofs)]
    dofs = dict(zip(dofs, given, strict=True)) if named else given
    # Universal files name points, whose sign may have to be turned: that is the reader's.
    by_point = kind == "uff" and named and all(map(_is_point, dofs))
    left_out = {name for name, dof in dofs.items() if dof is None} if named else set()
    if by_point:
        chosen["dofs"] = dofs
    elif left_out and kind != FOLDER:  # before the reader finds that they do not fit the rest
        chosen["dofs"] = lambda name: None if str(name) in left_out else name
    try:
        signal = _READERS[kind](file, **chosen)
        if by_point or not dofs:
            return signal
        names = [str(name) if named else name for name in signal.dofs]
        for name in (name for name in dofs if named and name not in [*names, *left_out]):
            got = f"{name!r}, which is no channel of {file.name}"
            reject("dofs", got, f"names out of {', '.join(map(repr, names))}", "Correct or remove it.")
        # What a table does not name keeps its name.
        labels = {**dict(zip(names, names, strict=True)), **dofs} if named else dofs
        return relabelled(signal, renamed("dofs", names, labels))
    except InvalidInputError as exc:
        texts = (spelled(text, spell) for text in (exc.wanted, exc.remedy))
        raise type(exc)(exc.argument, exc.got, *texts) from exc


def _is_point(name: str) -> bool:
    try:
        as_point("dofs", name)
    except InvalidInputError:
        return False
    return True


# -- One [data]: the files of a test, and what is identified from them

OPTIONS: dict[str, KeyPath] = {key.name: ("identification", key.name) for key in IDENTIFICATION.keys}
_OF_MODES = [name for name in OPTIONS if name in signature(identify_modes).parameters]


class Measurement:
    """One [data] of a job, or its intact counterpart, at dofs of the model; the files repeat the first.

    ``files`` are pairs of a place in the job and a path. A file of antiresonances has no ``signal``.
    """

    signal: Signal | None = None
    force: Any = None
    found: AntiresonanceSet

    def __init__(
        self,
        job: Job,
        place: KeyPath,
        table: Mapping[str, Any],
        model: StructuralModel | None,
        files: list[tuple[KeyPath, Path]],
    ) -> None:
        self.job, self.place, self.table, self._model = job, place, table, model
        self.places: list[KeyPath] = [at for at, _ in files]
        self.file, *self.repeats = [path for _, path in files]
        self.kind = kind_of(job, place, table, self.file)
        job.only(place, table, self.kind)
        self._find = dof_finder(job, model)
        self._dofs: Any = table.get("dofs")
        self._names: dict[int, str] = {}  # what the user calls dofs of the model
        if self._dofs is not None:
            named = isinstance(self._dofs, dict)
            given = self._dofs.items() if named else enumerate(self._dofs)
            found = {key: self._find((*place, "dofs", key), dof) for key, dof in given}
            self._names |= {dof: str(key) for key, dof in found.items() if named and type(dof) is int}
            self._dofs = found if named else list(found.values())
        self._points = self._matched() if "points" in table else None
        say(f"reading {self.file.name}" + (f" and {len(self.repeats)} more" if self.repeats else ""))
        if self.kind != "antiresonances":
            self._read()

    def _matched(self) -> MatchedPoints:
        """Where the channels are on the model."""
        at = (*self.place, "points")
        if self._model is None or self._dofs is not None:
            got = "it beside dofs" if self._model is not None else "it without a model"
            self.job.reject(at, got, "points on the model of the job, which give the dofs", "Leave it out.")
        file = self.job.existing(at, self.table["points"])
        with self.job.blame(self.place, {"path": at, "points": at, "nodes": ("model",)}):
            matched = match_points(file, self._model)
        found = {name: self._find(at, dof) for name, dof in matched.dofs.items()}
        self._names |= {dof: str(name) for name, dof in found.items() if type(dof) is int}
        return matched

    def _read(self) -> None:
        job, place = self.job, self.place
        job.check_data(place, self.table)
        options = self.table if self._dofs is None else {**self.table, "dofs": self._dofs}
        joins = bool(options.get("align"))
        signals = []
        for at, path in zip(self.places, (self.file, *self.repeats), strict=True):
            of_file = ("path", "files", "signal", *(("dofs", "responses") if at[0] == "damage" else ()))
            with job.blame(place, dict.fromkeys(of_file, at)):  # a baseline that lacks a channel is at fault
                alone = {name: value for name, value in options.items() if name != "dofs" or not joins}
                signal = read_signal(path, self.kind, alone, job.spelled)
            signals.append(signal if joins else self._at_dofs(signal))
        known = {*(self._dofs if isinstance(self._dofs, dict) else ()), *signals[0].dofs}
        forces = places_of(self.table.get("excitation", ()), known)
        with job.blame(place, {"source": self.places, "records": self.places}):
            # Curves of several forces are of one each.
            if len(forces) > 1 and isinstance(signals[0], FrequencyResponse):
                self.signal = minors_of_curves(signals, len(forces))
            else:
                self.signal = self._at_dofs(self._aligned(signals)) if joins else one_source(signals)
        job.check_data(place, self.table, self.signal)
        if "excitation" not in self.table:  # modes do not ask for it
            return
        forces = [self._acts_at(one) for one in places_of(self.table["excitation"], known)]
        self.force = forces[0] if len(forces) == 1 else forces

    def _acts_at(self, force: Any) -> Any:
        """The dof of a place of a force; the name of a channel stands for its own."""
        at = (*self.place, "excitation")
        if self._points is not None:
            force = self._points.dofs.get(force, force)
        if isinstance(self._dofs, dict) and force in self._dofs:
            if self._dofs[force] is not False:
                force = self._dofs[force]
            elif self._model is not None:
                remedy = "Write the dof at which the force acts; its channel may still be left out."
                self.job.reject(at, f"{shown(force)}, which dofs leaves out", "a dof of the model", remedy)
        return self._of_model(at, self._find(at, force))

    def modes(self) -> ModalSet:
        """The resonances and mode shapes of the signal."""
        for key in self.job.sections["identification"]:
            if key not in _OF_MODES:
                place: KeyPath = ("identification", key)
                got, wanted = f"{key!r} for modes", f"{' or '.join(_OF_MODES)} alone"
                raise InvalidInputError(self.job.where(place), got, wanted, "Leave it out.")
        if self.signal is None:
            wanted = "a measurement to be identified"
            reject("--modes", "it beside antiresonances", wanted, "Name the file of the measurement.")
        say(f"identifying the modes of {len(self.signal.dofs)} responses")
        with self.job.blame(self.place, {"source": self.places[0], **OPTIONS}):
            options = self.job.sections["identification"]
            return identify_modes(self.signal, band_hz=self.table["band_hz"], **options)

    def _aligned(self, sensors: list[Any]) -> Signal:
        """Sensors with a file each as one record, channels named by what the files differ in."""
        names = [dof for rec in sensors for dof in rec.dofs]
        if len(set(names)) < len(names):
            stems = differences([path.stem for path in (self.file, *self.repeats)])
            each = [(stem, rec, dof) for stem, rec in zip(stems, sensors, strict=True) for dof in rec.dofs]
            names = [stem if rec.n_channels == 1 else f"{stem} {dof}" for stem, rec, dof in each]
        joined, dofs = align(sensors, dofs=names), self._dofs
        if isinstance(dofs, dict):
            names = [str(name) for name in names]
            given = {name: None if dof is False else dof for name, dof in dofs.items()}
            dofs = dict(zip(names, names, strict=True)) | given
        return joined if dofs is None else relabelled(joined, renamed("dofs", names, dofs))

    def identified(self) -> Measurement:
        """The same, with its antiresonances, edited as the table says."""
        if self.signal is None:
            with self.job.blame(self.place, {"path": self.places[0]}):
                found = AntiresonanceSet.load(self.file)
            found = self._renamed(found)
        else:
            say(f"identifying the antiresonances of {len(self.signal.dofs)} responses")
            chosen = dict(self.job.sections["identification"])
            if "dofs" in chosen:
                chosen["dofs"] = [self._each(("identification", "dofs"), dof) for dof in chosen["dofs"]]
            given = {"excitation": self.force, "band_hz": self.table["band_hz"], **sorted_out(chosen)}
            with self.job.blame(self.place, {"source": self.places[0], **OPTIONS}), self._warned_by_name():
                found = identify_antiresonances(self.signal, **given)
            found = self._checked_by_name(found)
        self.found = edited(self.job, self.place, self.table, found, self._find)
        return self

    def _each(self, at: KeyPath, dof: Any) -> Any:
        """A dof, or each of several."""
        return [self._find(at, one) for one in dof] if isinstance(dof, list) else self._find(at, dof)

    def _by_name(self, text: str) -> str:
        """A text on dofs of the model, and on records, with what the user calls them."""
        if self.repeats:
            files = [path.name for path in (self.file, *self.repeats)]
            text = _RECORDS.sub(lambda one: _NUMBER.sub(lambda n: files[int(n[0])], one[0]), text)
            text = re.sub("counted from 0; |, counted from 0", "", text)
        if not self._names:
            return text
        return _DOFS.sub(
            lambda one: _NUMBER.sub(lambda n: repr(self._names.get(int(n[0]), int(n[0]))), one[0]), text
        )

    @contextmanager
    def _warned_by_name(self) -> Iterator[None]:
        heard: list[warnings.WarningMessage] = []
        try:
            with warnings.catch_warnings(record=True) as heard:
                warnings.simplefilter("always", AntiresWarning)
                yield
        except InvalidInputError as exc:
            texts = map(self._by_name, (exc.got, exc.wanted, exc.remedy))
            raise type(exc)(exc.argument, *texts) from exc
        finally:
            for each in heard:
                one = each.message
                if isinstance(one, AntiresWarning):
                    one = AntiresWarning(self._by_name(one.text), one.about)
                warnings.warn_explicit(one, each.category, each.filename, each.lineno)

    def _checked_by_name(self, found: AntiresonanceSet) -> AntiresonanceSet:
        check = found.data_check
        if check is None or not (self._names or self.repeats):
            return found
        name = self._by_name
        findings = [
            replace(f, text=name(f.text), advice=name(f.advice), brief=name(f.brief)) for f in check.findings
        ]
        named = copy(found)
        named._fill(data_check=replace(check, findings=tuple(findings)))
        return named

    def _at_dofs(self, signal: Signal) -> Signal:
        """The signal with every channel at a dof of the model."""
        if self._model is None:
            return signal
        at = (*self.place, "dofs")
        if self._points is not None:
            if lost := {*map(str, signal.dofs)} - {*self._points.points}:
                warn("points_without_dof", f"points: no row of {some(sorted(lost))}, which is left out.")
            with self.job.blame(self.place, {"signal": (*self.place, "points")}):
                signal = self._points.apply(signal)
        dofs = [self._of_model(at, self._find(at, name), name) for name in signal.dofs]
        named = zip(signal.dofs, dofs, strict=True)
        self._names |= {dof: name for name, dof in named if isinstance(name, str)}
        if dofs == list(signal.dofs):
            return signal
        with self.job.blame(self.place):
            return relabelled(signal, dofs)

    def _renamed(self, found: AntiresonanceSet) -> AntiresonanceSet:
        """A set of a file at dofs of the model; the same object where nothing changes."""
        names, at = self._dofs or {}, (*self.place, "dofs")
        channels = list(found if found.order == 1 else found.channels)
        if self._points is not None:  # without those askew, which would have to be turned before
            names = {**dict.fromkeys(map(str, channels), False), **self._points.dofs}
        if isinstance(names, list):
            if len(names) != len(channels):
                wanted = f"{len(channels)}, one for each of {channels}"
                self.job.reject(at, f"{len(names)} dofs", wanted, "Or a table name = dof.")
            names = dict(zip(channels, names, strict=True))
        given = {dof: names.get(str(dof), names.get(dof, dof)) for dof in channels}
        kept = {dof: new for dof, new in given.items() if new is not False}
        table = {dof: self._of_model(at, self._find(at, new), dof) for dof, new in kept.items()}
        acted = [found.excitation] if found.order == 1 else list(found.excitation)
        forces = [self._find(at, names.get(str(force), force)) for force in acted]
        if forces == acted and list(table.items()) == [(dof, dof) for dof in channels]:
            return found
        with self.job.blame(self.place, {"freq_hz": at, "dofs": at}):
            return found.relabelled([self._of_model(at, force) for force in forces], table)

    def _of_model(self, place: KeyPath, dof: Any, name: Any = None) -> Any:
        """A dof of the model."""
        model = self._model
        if model is None or (isinstance(dof, int) and 0 <= dof < model.n_dof):
            return dof
        got = f"{dof!r}" if name is None or name == dof else f"{dof!r} for {name!r}"
        remedy = "Dofs count from 0; correct it, or the model."
        if isinstance(dof, str):
            remedy = f'Correct the name, or say which dof it is: dofs = {{ "{dof}" = 0, ... }}.'
        return self.job.reject(place, got, f"a dof of the model, 0 to {model.n_dof - 1}", remedy)


def places_of(given: Any, known: Container[Any] = ()) -> list[Any]:
    """Where forces act: one place, a list, or a text with commas that is the name of none."""
    if isinstance(given, list | tuple):
        return list(given)
    if not isinstance(given, str) or given in known or "," not in given:
        return [given]
    names = [name.strip() for name in given.split(",")]
    if not all(names):
        reject("excitation", repr(given), "dofs between commas, as in 0,4", "Take the empty ones out.")
    return [int(name) if name.isdecimal() else name for name in names]


_DOFS = re.compile(r"\b(?:[Dd]ofs?|[Cc]hannels?) \d+(?:(?:, | and | or )\d+)*")
#: Not "Record 13 s, better 40 s", nor what "and 2 more" leaves out.
_RECORDS = re.compile(r"\b[Rr]ecords? \d+\b(?!\.\d| s\b)(?:(?:, | and )\d+\b(?! more))*")
_NUMBER = re.compile(r"\d+")

#: Keys of values that are dropped and added by hand, and what each does.
EDITS: dict[str, Any] = {"drop": AntiresonanceSet.drop, "add": AntiresonanceSet.add}


def edited(
    job: Job,
    place: KeyPath,
    table: Mapping[str, Any],
    found: AntiresonanceSet,
    find: Callable[[KeyPath, Any], Any] = lambda place, name: name,
) -> AntiresonanceSet:
    """The set with the edits of its [data], dropped values first; dofs as the model names them."""
    for key, change in EDITS.items():
        for at, text in _listed(table.get(key, []), (*place, key)):
            named = edit_named(text)
            if named is None:
                job.reject(at, shown(text), EDIT_WANTED, "Write the dof, =, the frequency, and why.")
            name, freq_hz, reason = named
            with job.blame(place, {"dof": at, "freq_hz": at}):
                if found.order > 1:
                    dof: Any = [find(at, one) for one in places_of(name)]
                else:
                    dof = find(at, int(name) if name.isdecimal() else name)
                found = change(found, dof, freq_hz, reason=reason)
    return found


def _listed(given: str | list[str], at: KeyPath) -> list[tuple[KeyPath, str]]:
    """The texts of a key with their places."""
    return [(at, given)] if isinstance(given, str) else [((*at, i), text) for i, text in enumerate(given)]


def kind_of(job: Job, place: KeyPath, table: Mapping[str, Any], file: Path) -> str:
    """Format of a measurement."""
    kind = FOLDER if file.is_dir() else format_of(file.name, table.get("format"))
    return kind or job.unknown_format(place, table, file)


def read_of(job: Job, model: StructuralModel | None) -> list[Measurement]:
    """Read every [data] of a job."""
    measured = []
    for place, table in zip(job.data_places, job.data, strict=True):
        file = job.file(table["file"])
        if not file.is_dir():
            kind_of(job, place, table, file)  # an unknown ending is told before a file that is not there
        at: KeyPath = (*place, "file")
        files = [(at, path) for path in job.files(at, table["file"], folders=True)]
        for at, name in _listed(table.get("repeats", []), (*place, "repeats")):
            known = {path.resolve() for _, path in files}  # the first is not read twice
            files += [(at, path) for path in job.files(at, name) if path.resolve() not in known]
        measured.append(Measurement(job, place, table, model, files))
    return measured


def measured_of(job: Job, model: StructuralModel | None) -> list[Measurement]:
    """Read and identify every [data] of a job."""
    measured = [each.identified() for each in read_of(job, model)]
    if model is not None:
        _refuse_without_values(job, measured)
    if job.sections["identification"] and all(each.signal is None for each in measured):
        got = "options beside files that hold antiresonances already"
        wanted = "a measurement to be identified"
        job.reject(("identification",), got, wanted, "Remove the section, or name the measurement.")
    return measured


def _refuse_without_values(job: Job, measured: list[Measurement], of: str = "") -> None:
    """Refuse a state without any antiresonance: where it was identified, its band is at fault."""
    if not measured or any(f.size for each in measured for f in each.found.values()):
        return
    first = measured[0]
    low, high = first.table.get("band_hz", (0.0, 0.0))
    seen = first.found.data_check
    noise = seen is not None and {"dead_channel", "signal_to_noise"} & {f.name for f in seen.findings}
    got = f"no antiresonance{of}" + (f" in {low:g}-{high:g} Hz" if high else "")
    got += "; the channels hold noise there" if noise else ""
    remedy = "Choose another band_hz; 'antires look' shows the curves."
    job.reject((*first.place, "band_hz") if high else first.places[0], got, "a band with some", remedy)


# -- Measured modes of a job: [measured], and ``baseline`` of [damage] where modes are fitted

_KEY: KeyPath = ("damage", "baseline")


def modal_files(job: Job) -> dict[KeyPath, list[tuple[KeyPath, str]]]:
    """Places and names of files of modes by key: those measured, and intact ones where modes are fitted."""
    keys: list[KeyPath] = [("measured", "modes")] + ([] if job.data else [_KEY])
    return {(s, key): _listed(job.sections[str(s)].get(str(key), []), (s, key)) for s, key in keys}


def modes_of(job: Job, model: StructuralModel, key: KeyPath = ("measured", "modes")) -> list[ModalSet]:
    """The sets of a key, at dofs of the model."""
    find, sets, at_dofs = dof_finder(job, model), [], ("measured", "dofs")
    given: Any = job.sections["measured"].get("dofs", {})
    for at, name in modal_files(job).get(key, []):
        file = job.existing(at, name)
        with job.blame(at, {"path": at}):
            found = ModalSet.load(file)
        if isinstance(given, list) and len(given) != len(found.dofs):
            wanted = f"{len(found.dofs)}, one for each of {some(map(repr, found.dofs), _NAMED)}"
            job.reject(at_dofs, f"{len(given)} dofs", wanted, "Or a table name = dof.")
        new = given if isinstance(given, list) else [given.get(str(dof), dof) for dof in found.dofs]
        kept = [i for i, dof in enumerate(new) if dof is not False]
        if not kept:
            job.reject(at_dofs, "no column of the shapes left", "some of them", "Leave fewer of them out.")
        with job.blame(at_dofs, {"dofs": at_dofs, "measured dof": at_dofs}):
            dofs = [model._dof("measured dof", find(at_dofs, new[i])) for i in kept]
            sets.append(found.at_dofs(kept, dofs))
    return sets


# -- The intact structure of a job: ``baseline`` of [damage], read and identified as [data] is

_SEARCH = ("seed", "workers")  # keys of [search] that count with a baseline


def check_options(job: Job) -> None:
    """Refuse keys that would have no effect, with a baseline or without one."""
    damage, search = job.sections["damage"], job.sections["search"]
    if job.data and job.sections["updating"].get("objective") == "modal":
        wanted = "modes alone: [measured] without [data]"
        job.reject(("updating", "objective"), '"modal" beside [data]', wanted, "Remove [data], or this key.")
    one_state, two_states = options_with(ONE_STATE), ("prior", *options_with(TWO_STATES))
    if "baseline" in damage:
        wanted, remedy = "it without a baseline", "Remove it: probabilities replace prices and search."
        wrong = [("damage", name) for name in one_state if name in damage]
        wrong += [("search", name) for name in search if name not in _SEARCH]
    else:
        wanted, remedy = "it beside baseline", "Name the measurement of the intact structure, or remove it."
        wrong = [("damage", name) for name in two_states if name in damage]
    for place in wrong:
        state = "beside" if "baseline" in damage else "without a"
        job.reject(place, f"{place[1]!r} {state} baseline", wanted, remedy)


def baseline_of(job: Job, model: StructuralModel) -> list[Measurement]:
    """Read and identify the intact structure: a file for each [data], or any number with a single one."""
    names = _listed(job.sections["damage"].get("baseline", []), _KEY) if job.data else []
    if names and len(job.data) > 1 and len(names) != len(job.data):
        got = f"{len(names)} of them"
        wanted = f"{len(job.data)}, one for each [[data]] in their order"
        job.reject(_KEY, got, wanted, "A * in the name takes several records of one test.")
    measured: list[Measurement] = []
    for i, (at, name) in enumerate(names):
        measured += _intact(job, at, name, i if len(job.data) > 1 else 0, model)
    _refuse_without_values(job, measured, " of the intact structure")
    return measured


def _intact(job: Job, at: KeyPath, name: str, number: int, model: StructuralModel) -> list[Measurement]:
    place, table = job.data_places[number], job.data[number]
    files = job.files(at, name, folders=True)
    if {*files} & {*job.files((*place, "file"), table["file"], folders=True)}:
        got, wanted = f"{shown(name)}, which is [data] itself", "a measurement of the intact structure"
        job.reject(at, got, wanted, "Name that of before, or leave baseline out.")
    # What a file is its ending tells, else [data].
    own = format_of(files[0].name) or kind_of(job, place, table, files[0])
    held = (format_of(table["file"]) or table.get("format")) == "antiresonances"
    if own == "antiresonances":
        # Saved sets have dofs of the model, or names of channels; a list is of channels in a record.
        named = "dofs" in table and (held or isinstance(table["dofs"], dict))
        known = {"format": own} | ({"dofs": table["dofs"]} if named else {})
        return [Measurement(job, place, known, model, [(at, file)]).identified() for file in files]
    if held:
        got = f"{shown(name)}, a measurement beside a [data] that holds antiresonances already"
        remedy = "Identify it first with the same options: antires identify FILE --out intact.json."
        job.reject(at, got, "antiresonances of the intact structure, a .json", remedy)
    known = {key: value for key, value in table.items() if key not in ("repeats", *EDITS)}
    known |= {} if own == FOLDER else {"format": own}
    return [Measurement(job, place, known, model, [(at, path) for path in files]).identified()]


# -- A measurement as the arguments of ``identify`` and ``look`` name it: a job made of them

_NAMED = 12  # so many channels are named in a message
_PLACE: KeyPath = ("data",)
#: What functions call the files, or what was read from them.
_OF_FILES = ("file", "path", "files", "signal", "source", "sets")
#: Options of the command line by keys of a job.
_FLAGS = {key.name: key.flag.split()[0] for key in (*DATA.keys, *IDENTIFICATION.keys) if key.flag}
_FLAGS |= {name: f"--{name}" for name in EDITS}
_OTHERS = ("damage", "updating", "search")  # sections of jobs whose keys no command has


class Call(Job):
    """The job that says what arguments do; ``place`` is that of the force where the hammer roved."""

    def __init__(
        self, args: argparse.Namespace, *, band_needed: bool = True, place: Any = None, roved: bool = False
    ) -> None:
        self._modes = getattr(args, "modes", False)
        self.path = Path("arguments")
        self._band_needed, self._roved = band_needed, roved
        own = [key.name for key in DATA.keys if key.flag] + ([] if roved else list(EDITS))
        table = {name: getattr(args, name, None) for name in own}
        if roved:
            table |= {"excitation": place, "roving": None}
        elif getattr(args, "hit", None) is not None:
            wanted = "it beside --roving SENSOR, with a file for each hit"
            reject("--hit", "it for one place of the force", wanted, "Name that place by --excitation.")
        if table["dofs"] is not None:
            table["dofs"] = dict(table["dofs"])
        options = {key.name: getattr(args, key.name) for key in IDENTIFICATION.keys if key.flag}
        self.data, self.data_places = [_given(table)], [_PLACE]
        self.sections = {"identification": _given(options)}

    def read(self, files: list[Path]) -> Measurement:
        """What the files hold; a universal file may state the place of the force."""
        (table,) = self.data
        if "excitation" not in table and "roving" in table:
            # A folder has a file an FRF, named by point numbers: the force was at each, by reciprocity.
            if files[0].is_dir():
                table["excitation"] = table.pop("roving")
            else:
                with self.blame(_PLACE):
                    table["excitation"] = label_of(as_point("roving", table["roving"]))
        stated = {"excitation", "reference"} & table.keys()
        if not (stated or self._modes) and kind_of(self, _PLACE, table, files[0]) == "uff":
            with self.blame(_PLACE):
                force = force_of(files[0])
            if force is not None:
                say(f"the force is at {force}, as the file states")
                table["excitation"] = force
        return Measurement(self, _PLACE, table, None, [(_FILE, file) for file in files])

    def only(self, *_: Any) -> None:
        """The reader tells what belongs to another format."""

    def unknown_format(self, place: KeyPath, table: Any, file: Path) -> NoReturn:
        """Refuse a file whose format is not known."""
        wanted = f"an ending out of {' '.join(SIGNAL_ENDINGS)}"
        reject("FILE", repr(str(file)), wanted, f"Say by --format if it is one of these; {CONVERT}")

    def check_data(self, place: KeyPath, table: Any, signal: Any = None) -> None:
        """Refuse what the signal cannot tell of, and tell what could be given."""
        if signal is None:
            return
        low, high = covered_hz(signal)
        if "fs_hz" in table and isinstance(signal, Recording):  # nothing in the file tells that it is wrong
            hint(f"{signal.n_samples} samples at {signal.fs_hz:g} Hz are {signal.duration_s:.4g} s")
        if "excitation" not in table and not self._modes:
            wanted = "--excitation DOF, where the force acts"
            remedy = f"The file has the channels {some(map(repr, signal.dofs), _NAMED)}."
            reject("--excitation", "nothing", wanted, remedy)
        if "band_hz" not in table and self._band_needed:
            remedy = f"The data reach from {low:.4g} to {high:.4g} Hz; 'antires look' shows them without it."
            reject("--band", "nothing", "--band LOW HIGH, in Hz, where the curves are clean", remedy)
        named = table.get("dofs", {})
        channels = signal.columns[0].dofs if isinstance(signal, MinorResponse) else signal.dofs
        force = table.get("excitation")
        if type(force) is int and force < len(channels) and all(isinstance(name, str) for name in channels):
            told = f"channel {force} of those that are used, from 0"
            hint(f"the force is at {channels[force]!r}, {told}")
            table["excitation"] = force = channels[force]
        asked = () if self._roved or force is None else places_of(force, {*named, *channels})
        for force in asked:
            if force in named or force in channels:
                continue
            # Antiresonances do not depend on that name: a slip of the pen would pass in silence.
            near = nearest(str(force), map(str, channels), 0.7) or "If it is one of them, write that name."
            said = f"--excitation: {force!r} is none of the channels {some(map(repr, channels), _NAMED)}"
            warn("force_not_measured", f"{said}: the place of the force cannot be tested. {near}")

    def where(self, place: KeyPath) -> Place:
        """The option of a place."""
        name = next((part for part in place[1:] if isinstance(part, str)), "file")
        return Place("FILE" if name in _OF_FILES else _FLAGS.get(name, name), place)

    def belongs(self, place: KeyPath) -> str:
        """Nothing: the help of the command tells."""
        return ""

    @staticmethod
    def spelled(name: str, value: Any) -> str:
        """An argument of a reader as this command has it; those it lacks a job has."""
        section = next((part for part in _OTHERS if SECTIONS[part].key(name)), "")
        flag = _FLAGS.get(name, f"{name} in [{section}]" if section else f"{name} (in a job)")
        value = ",".join(map(str, value)) if isinstance(value, list) else value
        return flag if value is None or value is True else f"{flag} {value}"


_FILE: KeyPath = ("data", "file")


def _given(values: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value is not None}


def check_files(args: argparse.Namespace) -> None:
    """Check that the files are there, and of several that they are repeats of one test, of one format."""
    # A pattern in quotes, or of a shell that does not replace it.
    found = [sorted(file.parent.glob(file.name)) if "*" in file.name else [file] for file in args.files]
    args.files = [path for file, paths in zip(args.files, found, strict=True) for path in paths or [file]]
    for file in args.files:
        if not file.is_dir():
            existing("FILE", file, "Name a measurement, or a job.")
    ending = args.files[0].suffix.lower()
    for file in args.files if len(args.files) > 1 else ():
        if file.suffix.lower() in (".toml", ".json") or file.suffix.lower() != ending:
            got = f"{str(file)!r} among several"
            wanted = "measurements of one format: other impacts or runs of the same test"
            reject("FILE", got, wanted, "Name a job or a file of antiresonances alone.")


def refuse_beside(args: argparse.Namespace, what: str, remedy: str, *more: str) -> None:
    """Refuse options of reading and identifying a measurement, and ``more``, beside something else."""
    options = {name: flag for name, flag in _FLAGS.items() if name not in EDITS}
    for name, flag in (options | {name: f"--{name}" for name in ("hit", *more)}).items():
        if getattr(args, name, None) is not None:
            reject(flag, f"it beside {what}", "it with a measurement alone", remedy)


def identified(args: argparse.Namespace) -> AntiresonanceSet:
    """The antiresonances of the files of a command, edited as it says."""
    if several_hits(args):  # each is identified by itself, and all are joined at the sensor that stayed
        hits, call = hits_of(args)
        options = call.sections["identification"]
        with call.blame(_PLACE):
            joined = identify_roving(hits, args.roving, args.band_hz, say=say, **options)
        return edited(call, _PLACE, {name: getattr(args, name) or () for name in EDITS}, joined)
    return Call(args).read(args.files).identified().found


def modes_in(args: argparse.Namespace) -> ModalSet:
    """The modes of the files of a command."""
    for name in ("drop", "add", "roving"):
        if getattr(args, name) is not None:
            reject(f"--{name}", "it beside --modes", "it for antiresonances", "Leave it out.")
    return Call(args).read(args.files).modes()


def several_hits(args: argparse.Namespace) -> bool:
    """Whether each file is a hit of a hammer at another place."""
    return args.roving is not None and len(args.files) > 1


def hits_of(args: argparse.Namespace, *, band_needed: bool = True) -> tuple[list[Hit], Call]:
    """What was measured at each hit, read, and the job of the last one."""
    places: list[Any] = args.hit or [None] * len(args.files)
    if len(places) != len(args.files):
        wanted = f"{len(args.files)}, one for each file"
        reject("--hit", f"{len(places)} places", wanted, "Name all in order.")
    if args.excitation is not None:
        reject("--excitation", "it beside --roving", "--hit for each file", "Leave it out: the force moved.")
    sensor, hits = args.roving, []
    for file, place in zip(args.files, places, strict=True):
        call = Call(args, band_needed=band_needed, place=place, roved=True)
        one = call.read([file])
        signal: Any = one.signal
        if sensor not in signal.dofs and one.force != sensor:
            got = f"{sensor!r} for {file.name}, with responses at {', '.join(map(repr, signal.dofs))}"
            reject("--roving", got, "a sensor that is in every file", "Name the one that stayed.")
        hits.append(Hit(file.name, signal, one.force))
    return hits, call
