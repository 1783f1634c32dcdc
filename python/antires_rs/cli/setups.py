"""``antires identify --roving`` with several files: each is a hit at another place, joined to one set."""

from __future__ import annotations

import argparse
from typing import Any

from ..measured.antiresonance_set import AntiresonanceSet
from ..support.validation import reject
from .measurement import NAMES, measurement
from .terminal import arguments, say

__all__ = ["of_setups"]


def of_setups(args: argparse.Namespace, kind: str) -> AntiresonanceSet:
    """Identify every file by itself, and join them by reciprocity at the sensor that stayed."""
    from ..identification.identify import identify_antiresonances
    from ..measured.merge import merge_setups

    hits: list[Any] = args.hit or [None] * len(args.files)
    if len(hits) != len(args.files):
        reject(
            "--hit",
            f"{len(hits)} places",
            f"{len(args.files)}, one for each file in their order",
            "Name the place of the force of every file.",
        )
    if args.excitation is not None:
        reject("--excitation", "it beside --roving", "--hit for each file", "Leave it out: the force moved.")
    sensor, files = args.roving, args.files
    sets = []
    for file, hit in zip(files, hits, strict=True):
        one = argparse.Namespace(**{**vars(args), "file": file, "files": [file], "roving": None})
        one.excitation = hit
        given = measurement(one, kind)
        if sensor not in given.signal.dofs and given.force != sensor:
            reject(
                "--roving",
                f"{sensor!r} for {file.name}, with responses at {', '.join(map(repr, given.signal.dofs))}",
                "a sensor that is in every file",
                "Name the one that stayed.",
            )
        say(f"identifying the antiresonances of {file.name}, force at {given.force}")
        with arguments(NAMES):
            sets.append(
                identify_antiresonances(
                    given.signal, excitation=given.force, band_hz=args.band, **given.options
                )
            )
    with arguments({"sets": "FILE", "excitation": "--roving"}):
        return merge_setups(sets, excitation=sensor)
