"""A measurement as the arguments of ``identify`` and ``look`` name it: a job made of them."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any, NoReturn

from ..exceptions import reject
from ..identification.identify import Hit, identify_roving
from ..io.registry import CONVERT
from ..io.uff import as_point, force_of, label_of
from ..measured.antiresonance_set import AntiresonanceSet
from ..signals.frequency_response import covered_hz
from ..support.messages import some, warn
from .command import existing, say
from .job import Job, KeyPath, Place
from .keys import DATA, IDENTIFICATION, SIGNAL_ENDINGS
from .parser import nearest
from .reading import EDITS, Measurement, edited, kind_of

_NAMED = 12  # so many channels are named in a message
_PLACE: KeyPath = ("data",)
#: What functions call the files, or what was read from them.
_OF_FILES = ("file", "path", "files", "signal", "source", "sets")
#: Options of the command line by keys of a job.
_FLAGS = {key.name: key.flag.split()[0] for key in (*DATA.keys, *IDENTIFICATION.keys) if key.flag}
_FLAGS |= {name: f"--{name}" for name in EDITS}


class Call(Job):
    """The job that says what arguments do; ``place`` is that of the force where the hammer roved."""

    def __init__(
        self, args: argparse.Namespace, *, band_needed: bool = True, place: Any = None, roved: bool = False
    ) -> None:
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
            with self.blame(_PLACE):
                table["excitation"] = label_of(as_point("roving", table["roving"]))
        if not {"excitation", "reference"} & table.keys() and kind_of(self, _PLACE, table, files[0]) == "uff":
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
        if "excitation" not in table:
            wanted = "--excitation DOF, where the force acts"
            reject(
                "--excitation",
                "nothing",
                wanted,
                f"The file has the channels {some(map(repr, signal.dofs), _NAMED)}.",
            )
        if "band_hz" not in table and self._band_needed:
            remedy = f"The data reach from {low:.4g} to {high:.4g} Hz; 'antires look' shows them without it."
            reject("--band", "nothing", "--band LOW HIGH, in Hz, where the curves are clean", remedy)
        named = table.get("dofs", {})
        force = table["excitation"]
        if not (self._roved or force in named or force in signal.dofs):
            # Antiresonances do not depend on that name: a slip of the pen would pass in silence.
            hint = nearest(str(force), map(str, signal.dofs), 0.7) or "If it is one of them, write that name."
            said = f"--excitation: {force!r} is none of the channels {some(map(repr, signal.dofs), _NAMED)}"
            warn("force_not_measured", f"{said}: the place of the force cannot be tested. {hint}")

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
        flag = _FLAGS.get(name, f"{name} (in a job)")
        return flag if value is None else f"{flag} {value}"


_FILE: KeyPath = ("data", "file")


def _given(values: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in values.items() if value is not None}


def check_files(args: argparse.Namespace) -> None:
    """Check that the files are there, and of several that they are repeats of one test, of one format."""
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


def several_hits(args: argparse.Namespace) -> bool:
    """Whether each file is a hit of a hammer at another place."""
    return args.roving is not None and len(args.files) > 1


def hits_of(args: argparse.Namespace, *, band_needed: bool = True) -> tuple[list[Hit], Call]:
    """What was measured at each hit, read, and the job of the last one."""
    places: list[Any] = args.hit or [None] * len(args.files)
    if len(places) != len(args.files):
        reject(
            "--hit", f"{len(places)} places", f"{len(args.files)}, one for each file", "Name all in order."
        )
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
