"""A measurement as the arguments of ``identify`` and ``look`` name it: read, with the place of its force."""

from __future__ import annotations

import argparse
import re
import shlex
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from ..exceptions import reject
from ..identification.identify import Hit, identify_roving
from ..io.registry import conversion
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.messages import LeftOut, Part, warn
from .command import arguments, existing, say
from .keys import DATA, FOLDER, FORMATS, format_of

#: So many channels are named in a message.
_NAMED = 12

#: Options by the arguments of the functions behind it.
NAMES = {
    "path": "FILE",
    "files": "FILE",
    "format": "--format",
    "signal": "FILE",
    "source": "FILE",
    "band_hz": "--band",
    "dofs": "--dof",
    "fs_hz": "--fs",
    "df_hz": "--df",
    "pairs": "--pairs",
    "run": "--run",
    "responses": "--responses",
    "sheet": "--sheet",
    "roving": "--roving",
    "full_scale": "--full-scale",
    "pattern": "--pattern",
    "cross_check": "--cross-check",
    "max_order": "--max-order",
    **{
        name: f"--{name}"
        for name in ("excitation", "unit", "force", "kind", "first", "reference", "preset", "route")
    },
}
READING = (
    *("kind", "reference", "force", "fs_hz", "unit", "first", "df_hz", "pairs", "of_run", "pattern"),
    *("responses", "sheet", "full_scale", "roving"),
)
CHOICES = ("preset", "max_order", "cross_check", "route")


@dataclass(frozen=True)
class Measurement:
    """What a file holds.

    Attributes
    ----------
    signal : Recording or FrequencyResponse
    force : int or str
        The dof of the force.
    options : dict
        Those of the identification.
    """

    signal: Any
    force: Any
    options: dict[str, Any]


def files_of(args: argparse.Namespace) -> None:
    """Check that the files are there and of one kind; the first is ``args.file``."""
    for file in args.files:
        if not file.is_dir():
            existing("FILE", file, "Name a measurement, or a job.")
    args.file = args.files[0]
    if len(args.files) > 1:
        _of_one_kind(args.files)


def refuse_beside(args: argparse.Namespace, what: str, remedy: str, *more: str) -> None:
    """Refuse options of reading and identifying a measurement, and ``more``, beside something else."""
    for name in ("band", "excitation", "format", "dofs", "hit", *READING, *CHOICES, *more):
        if getattr(args, name, None) is not None:
            option = {"dofs": "--dof", "fs_hz": "--fs", "df_hz": "--df", "of_run": "--run"}.get(
                name, "--" + name.replace("_", "-")
            )
            reject(option, f"it beside {what}", "it with a measurement alone", remedy)


def kind_of(args: argparse.Namespace) -> str:
    """Format of the file."""
    kind = FOLDER if args.file.is_dir() else format_of(args.file.name, args.format)
    if kind is None:
        reject(
            "FILE",
            repr(str(args.file)),
            "an ending out of " + " ".join(e for ends in FORMATS.values() for e in ends),
            f"Say by --format what it is.{conversion(args.file.name)}",
        )
    return kind


def measurement(
    args: argparse.Namespace, kind: str, *, band_needed: bool = True, hammer_roved: bool = False
) -> Measurement:
    """Read it; the force may be stated by the file itself, and need not be measured where it moved."""
    if args.hit is not None and not hammer_roved:
        wanted = "it beside --roving SENSOR, with a file for each hit"
        reject("--hit", "it for one place of the force", wanted, "Name that place by --excitation.")
    if args.excitation is None and args.roving is not None:
        from ..io.uff import as_point, label_of

        with arguments(NAMES):
            args.excitation = label_of(as_point("roving", args.roving))
    if args.excitation is None and kind == "uff" and args.reference is None:
        from ..io.uff import force_of

        with arguments(NAMES):
            args.excitation = force_of(args.file)
        if args.excitation is not None:
            say(f"the force is at {args.excitation}, as the file states")
    from ..signals.frequency_response import covered_hz
    from ..signals.repeats import one_source
    from .reading import read_signal

    options = {
        name.removeprefix("of_"): getattr(args, name) for name in READING if getattr(args, name) is not None
    }
    if kind == FOLDER and args.format is not None:
        options["format"] = args.format
    if args.dofs:
        options["dofs"] = dict(args.dofs)
    chosen = {name: getattr(args, name) for name in CHOICES if getattr(args, name) is not None}
    with arguments(NAMES):
        signals = []
        for file in args.files:
            say(f"reading {file.name}")
            signals.append(read_signal(file, kind, options, _as_option))
        signal = one_source(signals)
        if args.excitation is None:
            reject(
                "--excitation",
                "nothing",
                "--excitation DOF, where the force acts",
                f"The file has the channels {_some(signal.dofs)}.",
            )
        if args.band is None and band_needed:
            low, high = covered_hz(signal)
            reject(
                "--band",
                "nothing",
                "--band LOW HIGH, in Hz, where the curves are clean",
                f"The data reach from {low:.4g} to {high:.4g} Hz; 'antires look' shows them without it.",
            )
        # A channel that is left out still names the place of the force, which need not be recorded.
        named = options.get("dofs", {}).get(args.excitation, False)
        force = args.excitation if named is False else named
        if not (hammer_roved or force in signal.dofs or args.excitation in options.get("dofs", {})):
            _warn_unmeasured(force, signal.dofs)
    return Measurement(signal, force, chosen)


def edited(found: AntiresonanceSet, args: argparse.Namespace) -> AntiresonanceSet:
    """The set without what ``--drop`` names and with what ``--add`` does."""
    for option, change in (("drop", AntiresonanceSet.drop), ("add", AntiresonanceSet.add)):
        with arguments({"dof": f"--{option}", "freq_hz": f"--{option}"}):
            for dof, freq_hz, reason in getattr(args, option) or ():
                found = change(found, dof, freq_hz, reason=reason)
    return found


def _of_one_kind(files: list[Path]) -> None:
    """Several files are repeats of one test: measurements of one format."""
    ending = files[0].suffix.lower()
    for file in files:
        if file.suffix.lower() in (".toml", ".json") or file.suffix.lower() != ending:
            reject(
                "FILE",
                repr(str(file)) + " among several",
                "measurements of one format: other impacts or runs of the same test",
                "Name a job or a file of antiresonances alone.",
            )


def _warn_unmeasured(force: Any, dofs: tuple[Any, ...]) -> None:
    """The antiresonances do not depend on the name, so that a slip of the pen would pass in silence."""
    meant = _meant(force, dofs)
    hint = "If it acts at one of them, write that name."
    if meant is not None:
        hint = f"Did you mean {meant!r}? Then write --excitation {shlex.quote(str(meant))}."
    warn(
        "force_not_measured",
        f"--excitation: {force!r} is none of the channels {_some(dofs)}, so that "
        f"the place of the force cannot be tested. {hint}",
    )


def _meant(force: Any, dofs: tuple[Any, ...]) -> Any:
    """The channel that a name probably stands for: the only one with that number, else the most like it."""
    for part in (slice(-1, None), slice(1)):  # chassis2[0], 0:+Z
        same = [dof for dof in dofs if str(force) in re.findall(r"\d+", str(dof))[part]]
        if len(same) == 1:
            return same[0]
    near = get_close_matches(str(force), names := [str(dof) for dof in dofs], 1, 0.7)
    return dofs[names.index(near[0])] if near else None


def _some(dofs: tuple[Any, ...]) -> str:
    """The channels by name; of many the first and the last."""
    names = [repr(dof) for dof in dofs]
    if len(names) > _NAMED:
        names = [*names[: _NAMED - 1], "...", names[-1]]
    return ", ".join(names)


def _as_option(part: Part) -> str:
    """An argument of a reader as this command has it; those it lacks a job has."""
    if isinstance(part, LeftOut):
        from .reading import LEAVE_OUT

        return LEAVE_OUT
    option = NAMES.get(part.name)
    if option is None or not option.startswith("--"):
        return f"{part.name} (in a job)" if DATA.key(part.name) else part.name
    return option if part.value is None else f"{option} {part.value}"


# -- ``--roving`` with several files: each is a hit at another place, joined to one set


def hits_of(args: argparse.Namespace, kind: str, *, band_needed: bool = True) -> tuple[list[Hit], Any]:
    """What was measured at each hit, read, and the options of the identification."""
    places: list[Any] = args.hit or [None] * len(args.files)
    if len(places) != len(args.files):
        reject(
            "--hit",
            f"{len(places)} places",
            f"{len(args.files)}, one for each file in their order",
            "Name the place of the force of every file.",
        )
    if args.excitation is not None:
        reject("--excitation", "it beside --roving", "--hit for each file", "Leave it out: the force moved.")
    sensor, files = args.roving, args.files
    hits, options = [], {}
    for file, place in zip(files, places, strict=True):
        one = argparse.Namespace(**{**vars(args), "file": file, "files": [file], "roving": None})
        one.excitation = place
        given = measurement(one, kind, band_needed=band_needed, hammer_roved=True)
        if sensor not in given.signal.dofs and given.force != sensor:
            reject(
                "--roving",
                f"{sensor!r} for {file.name}, with responses at {', '.join(map(repr, given.signal.dofs))}",
                "a sensor that is in every file",
                "Name the one that stayed.",
            )
        hits.append(Hit(file.name, given.signal, given.force))
        options = given.options
    return hits, options


def of_setups(args: argparse.Namespace, kind: str) -> AntiresonanceSet:
    """Identify every file by itself, and join them by reciprocity at the sensor that stayed."""
    hits, options = hits_of(args, kind)
    with arguments({**NAMES, "sets": "FILE"}):
        return identify_roving(hits, args.roving, args.band, say=say, **options)
