"""``--roving`` with several files: each is a hit at another place, joined to one set."""

from __future__ import annotations

import argparse
from typing import Any

from ..identification.roving import Hit, identify_roving
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.validation import reject
from .measurement import NAMES, measurement
from .terminal import arguments, say

__all__ = ["hits_of", "of_setups"]


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
