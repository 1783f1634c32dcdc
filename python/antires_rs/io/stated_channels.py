"""Channels that state their own name, unit, rate and start (TDMS, LVM, miniSEED, WAV) as one recording."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from ..exceptions import reject
from ..signals.recording import Recording
from ..support.checks import FloatArray, finite_scalar, shape_of
from ..support.messages import Passed, Wording, warn
from .channels import Channel, Dofs, recording_of
from .child_process import Asked, in_a_child
from .common import missing_package, rate_of, simplest_rate, unsuitable

#: Names of a channel that holds the instants of the others.
_TIME = ("time", "t", "time_s", "x_value", "zeit")
_SAME_RATE = 1e-6


@dataclass(frozen=True)
class Stated:
    """A channel with what its file says of it.

    Attributes
    ----------
    name, unit : str
    values : (n_samples,)
    step_s : float or None
        Sampling interval; None where the file is silent.
    start : str
        When the record began, as the file writes it; channels of one record agree.
    offset_s : float
        Its first sample after that.
    """

    name: str
    values: FloatArray
    unit: str = ""
    step_s: float | None = None
    start: str = ""
    offset_s: float = 0.0


def channels_of_child(
    kind: str,
    file: Path,
    packages: tuple[str, str],
    reader: str,
    wanted: str,
    *,
    responses: Any = None,
    time_limit_s: float,
    memory_limit_gb: float,
    **more: Any,
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """What the child makes of a file: the entries of its channels, with their values, and further texts.

    ``packages`` are the package that reads, and the extra that brings it.
    """
    from importlib.util import find_spec

    package, extra = packages
    if package and find_spec(package) is None:
        raise missing_package(reader, package, extra, ImportError(package))
    limits = {
        "time_limit_s": finite_scalar("time_limit_s", time_limit_s, low=0.0, low_open=True, unit="s"),
        "memory_limit_gb": finite_scalar(
            "memory_limit_gb", memory_limit_gb, low=0.0, low_open=True, unit="GB"
        ),
    }
    found = in_a_child(kind, file, Asked.of(responses=responses), wanted, **limits, **more)
    entries = json.loads(found.texts["channels"])
    for i, entry in enumerate(entries):
        entry["values"] = found.arrays[f"c{i}"]
    return entries, found.texts


def stated_recording(
    file: Path,
    channels: Sequence[Stated],
    *,
    responses: Any = None,
    fs_hz: float | None = None,
    dofs: Dofs = None,
    force: Any = "auto",
    unit: str | None = None,
) -> Recording:
    """The recording of these channels, in SI.

    ``responses`` are names, ``*`` for any text; by default all channels but instants and force.
    """
    instants = [c for c in channels if c.step_s is None and c.name.rpartition("/")[2].lower() in _TIME]
    rest = [c for c in channels if c not in instants]
    forces = [c for c in rest if c.name == force or c.name.lower() == "force"]
    chosen = rest if responses is None else [*_named(file, rest, responses), *forces]
    chosen = list({id(c): c for c in chosen}.values())
    if not chosen:
        unsuitable(
            file,
            "without a channel of numbers",
            "at least one channel of samples",
            "Export the channels of the record.",
        )
    rate = _rate(file, chosen, instants, fs_hz)
    _together(file, chosen)
    odd = sorted({c.unit for c in chosen} - {""})
    if not odd and unit is None:
        warn(
            "no_unit",
            f"path: {str(file)!r} does not say in which unit its channels are; the values are as in "
            "the file. Name it by unit=.",
        )
    made = [
        Channel(c.name, c.values, c.unit, "force" if c in forces and force is not None else "")
        for c in chosen
    ]
    return recording_of(file, made, rate, dofs=dofs, force=force, unit=unit)


def _named(file: Path, channels: Sequence[Stated], responses: Any) -> list[Stated]:
    asked = [responses] if shape_of(responses) == () else list(responses)
    found = []
    for pattern in asked:
        hits = [
            c
            for c in channels
            if isinstance(pattern, str)
            and (c.name == pattern or fnmatchcase(c.name, pattern.replace("[", "[[]")))
        ]
        if not hits:
            shown = ", ".join(repr(c.name) for c in channels[:20]) or "none of that name"
            reject(
                "responses",
                repr(pattern),
                f"channels of {str(file)!r}: {shown}",
                "Correct the name or pattern.",
            )
        found += hits
    return found


def _rate(file: Path, channels: Sequence[Stated], instants: Sequence[Stated], fs_hz: float | None) -> float:
    rates = {c.name: rate_of_step(c.step_s) for c in channels if c.step_s is not None and c.step_s > 0.0}
    given = None if fs_hz is None else finite_scalar("fs_hz", fs_hz, low=0.0, low_open=True, unit="Hz")
    if given is None and not rates:
        if len(instants) == 1:
            return rate_of(file, instants[0].values)
        unsuitable(
            file,
            f"whose channels {', '.join(repr(c.name) for c in channels[:6])} state no sampling interval",
            "a sampling rate",
            Wording("Give it by {}.", Passed("fs_hz")),
        )
    if rates and max(rates.values()) - min(rates.values()) > _SAME_RATE * max(rates.values()):
        low, high = (f(rates, key=lambda name: rates[name]) for f in (min, max))
        unsuitable(
            file,
            f"with {low!r} at {rates[low]:.6g} Hz and {high!r} at {rates[high]:.6g} Hz",
            "channels of one rate",
            Wording("Name the {} of one rate.", Passed("responses")),
        )
    own = next(iter(rates.values()), given)
    if given is not None and own is not None and abs(own - given) > 1e-3 * given:
        warn(
            "other_rate",
            f"path: {str(file)!r} has channels at {own:.6g} Hz; read at {given:.6g} Hz, as fs_hz= says. "
            "Leave fs_hz= out if the file is right.",
        )
    return float(given if given is not None else own or 0.0)


def rate_of_step(step_s: float, digits: float = 1e-12) -> float:
    """The rate of a sampling interval that was rounded to so many digits, relatively."""
    return simplest_rate((1.0 - digits) / step_s, (1.0 + digits) / step_s)


def _together(file: Path, channels: Sequence[Stated]) -> None:
    """Channels of one record begin together."""
    first = channels[0]
    begun = (first.start, round(first.offset_s, 9))
    other = next((c for c in channels if (c.start, round(c.offset_s, 9)) != begun), None)
    if other is not None:
        names = (f"{c.name!r} from {c.start or 'the start'} + {c.offset_s:g} s" for c in (first, other))
        unsuitable(
            file,
            f"with {' and '.join(names)}",
            "channels that begin together",
            Wording("Name the {} of one record.", Passed("responses")),
        )
