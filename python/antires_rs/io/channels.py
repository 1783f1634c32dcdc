"""From channels as a file has them to a signal: roles, units, rates and names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import shape_of
from ..support.messages import LeftOut, Passed, Wording, warn
from .common import rate_of, refuse_real, simplest_rate, unsuitable
from .reading import Dofs, Reading
from .units import Unit, named_unit, parse_unit

#: Names of a channel that holds the instants of the others.
_TIME = ("time", "t", "time_s", "x_value", "zeit")
_SAME_RATE = 1e-6


@dataclass(frozen=True)
class Channel:
    """A channel with what its file says of it; the unit is '' and the step None where it is silent.

    ``start`` is when the record began, as the file writes it, ``offset_s`` its first sample after that;
    ``role`` is "force" where the file states it.
    """

    name: Any
    values: Any
    unit: str = ""
    step_s: float | None = None
    start: str = ""
    offset_s: float = 0.0
    role: str = ""


def recording_of(path: Path, channels: Sequence[Channel], fs_hz: float, given: Reading) -> Recording:
    """The recording, in SI, its force told from its responses.

    A channel is a force where the file says so, by role or unit. ``given.force`` is "auto" (the only one),
    None (left out) or the name of a channel.
    """
    units = {id(c): _unit(path, c) for c in channels}
    forces = [c for c in channels if c.role == "force" or units[id(c)].quantity == "force"]
    if given.force not in ("auto", None) and all(c.name != given.force for c in forces):
        forces += [c for c in channels if c.name == given.force]  # the user knows better than a silent file
    responses = [c for c in channels if not any(c is f for f in forces)]
    if not responses:
        found = f"with {len(forces)} force and no response"
        unsuitable(path, found, "at least one response channel", "Export the response channels too.")
    force = _force(forces, given.force)
    labels = renamed("dofs", [c.name for c in responses], given.dofs)
    rows = kept(labels)  # what is left out need not fit the rest
    used = [responses[i] for i in rows]
    lengths = {c.values.size for c in (*used, *([] if force is None else [force]))}
    if len(lengths) > 1:
        remedy = Wording("Leave out those of other lengths by {}.", Passed("dofs"))
        unsuitable(path, f"with channels of {sorted(lengths)} samples", "channels of one length", remedy)
    if given.unit is not None:  # which is that of the responses
        units |= {id(c): named_unit("unit", given.unit) for c in used}
    else:
        for unit in sorted({c.unit for c in used}):
            unit_or_warning(path, unit)
    one_quantity(path, [(repr(c.name), units[id(c)].quantity, f"in {c.unit or 'no unit'}") for c in used])
    return Recording(
        np.stack([in_si(c.values, units[id(c)]) for c in used]),
        fs_hz,
        [labels[i] for i in rows],
        None if force is None else in_si(force.values, units[id(force)]),
    )


def response_of(
    path: Path, freq_hz: Any, columns: Sequence[Channel], given: Reading, coherence: Any = None
) -> FrequencyResponse:
    """Complex columns over ``freq_hz`` as a response, in SI; ``coherence`` has a row for each column."""
    labels = renamed("dofs", [c.name for c in columns], given.dofs)
    chosen = kept(labels)
    named = None if given.unit is None else named_unit("unit", given.unit)
    units = [named or unit_or_warning(path, columns[i].unit) for i in chosen]
    values = [in_si(columns[i].values, unit) for i, unit in zip(chosen, units, strict=True)]
    refuse_real(path, values)
    return FrequencyResponse(
        freq_hz,
        np.stack(values),
        [labels[i] for i in chosen],
        "frf" if given.kind is None else given.kind,  # type: ignore[arg-type]
        given.reference,
        None if coherence is None else coherence[chosen],
    )


def stated_recording(file: Path, channels: Sequence[Channel], given: Reading) -> Recording:
    """The recording, in SI, of channels that state their own rate, unit and start."""
    instants = [c for c in channels if c.step_s is None and c.name.rpartition("/")[2].lower() in _TIME]
    rest = [c for c in channels if c not in instants]
    forces = [c for c in rest if c.name == given.force or c.name.lower() == "force"]
    chosen = rest if given.responses is None else [*_named(file, rest, given.responses), *forces]
    chosen = list({id(c): c for c in chosen}.values())
    if not chosen:
        found = "without a channel of numbers"
        unsuitable(file, found, "at least one channel of samples", "Export the channels of the record.")
    rate = _rate(file, chosen, instants, given)
    _together(file, chosen)
    if given.unit is None and not any(c.unit for c in chosen):
        warn(
            "no_unit",
            f"path: {str(file)!r} does not say in which unit its channels are; the values are as in "
            "the file. Name it by unit=.",
        )
    made = [replace(c, role="force" if c in forces and given.force is not None else "") for c in chosen]
    return recording_of(file, made, rate, given)


def _named(file: Path, channels: Sequence[Channel], responses: Any) -> list[Channel]:
    found = []
    for pattern in [responses] if shape_of(responses) == () else list(responses):
        hits = [c for c in channels if isinstance(pattern, str) and matches(c.name, pattern)]
        if not hits:
            shown = ", ".join(repr(c.name) for c in channels[:20]) or "none of that name"
            got = repr(pattern)
            reject("responses", got, f"channels of {str(file)!r}: {shown}", "Correct the name or pattern.")
        found += hits
    return found


def matches(name: str, pattern: str) -> bool:
    """Whether a name is meant; names of struct arrays have brackets, which are no patterns."""
    return name == pattern or fnmatchcase(name, pattern.replace("[", "[[]"))


def _rate(file: Path, channels: Sequence[Channel], instants: Sequence[Channel], given: Reading) -> float:
    rates = {c.name: rate_of_step(c.step_s) for c in channels if c.step_s is not None and c.step_s > 0.0}
    rate = given.rate_hz
    if rate is None and not rates:
        if len(instants) == 1:
            return rate_of(file, instants[0].values)
        found = f"whose channels {', '.join(repr(c.name) for c in channels[:6])} state no sampling interval"
        unsuitable(file, found, "a sampling rate", Wording("Give it by {}.", Passed("fs_hz")))
    if rates and max(rates.values()) - min(rates.values()) > _SAME_RATE * max(rates.values()):
        low, high = (f(rates, key=lambda name: rates[name]) for f in (min, max))
        found = f"with {low!r} at {rates[low]:.6g} Hz and {high!r} at {rates[high]:.6g} Hz"
        wanted = "channels of one rate"
        unsuitable(file, found, wanted, Wording("Name the {} of one rate.", Passed("responses")))
    own = next(iter(rates.values()), rate)
    if rate is not None:
        warn_other_rate(file, "has channels at", own, rate)
    return float(rate if rate is not None else own or 0.0)


def warn_other_rate(file: Path, says: str, own: float | None, rate: float) -> None:
    """A rate that the caller gives and the file denies moves every frequency."""
    if own is not None and abs(own - rate) > 1e-3 * rate:
        warn(
            "other_rate",
            f"path: {str(file)!r} {says} {own:.6g} Hz; read at {rate:.6g} Hz, as fs_hz= says. "
            "Leave fs_hz= out if the file is right.",
        )


def rate_of_step(step_s: float, digits: float = 1e-12) -> float:
    """The rate of a sampling interval that was rounded to so many digits, relatively."""
    return simplest_rate((1.0 - digits) / step_s, (1.0 + digits) / step_s)


def _together(file: Path, channels: Sequence[Channel]) -> None:
    """Channels of one record begin together."""
    first = channels[0]
    begun = (first.start, round(first.offset_s, 9))
    other = next((c for c in channels if (c.start, round(c.offset_s, 9)) != begun), None)
    if other is not None:
        names = (f"{c.name!r} from {c.start or 'the start'} + {c.offset_s:g} s" for c in (first, other))
        remedy = Wording("Name the {} of one record.", Passed("responses"))
        unsuitable(file, f"with {' and '.join(names)}", "channels that begin together", remedy)


def one_quantity(path: Path, found: Sequence[tuple[str, str, str]]) -> None:
    """Refuse accelerations beside displacements; ``found`` has name, quantity and unit of each channel."""
    if len({quantity for _, quantity, _ in found}) > 1:
        unsuitable(
            path,
            "with responses of several kinds, " + ", ".join(f"{name} {unit}" for name, _, unit in found),
            "accelerations, velocities or displacements alone",
            Wording(
                "Leave out those of other kinds by {}, or name the {} of all.", Passed("dofs"), Passed("unit")
            ),
        )


def renamed(argument: str, names: Sequence[Any], dofs: Dofs) -> list[Any]:
    """The dof of each channel; None for those the user leaves out."""
    if dofs is None:
        return list(names)
    if isinstance(dofs, Mapping):
        lost = [name for name in names if name not in dofs]
        if lost:
            got = f"no dof for {lost}"
            reject(argument, got, f"a dof for each of {list(names)}", Wording("{}.", LeftOut("channel")))
        return [dofs[name] for name in names]
    if callable(dofs):
        return [dofs(name) for name in names]
    labels = list(dofs) if shape_of(dofs) != () else [dofs]
    if len(labels) != len(names):
        remedy = "Name a dof for each channel, in their order, or map channels to dofs."
        reject(argument, f"{len(labels)} dofs", f"{len(names)}, one for each of {list(names)}", remedy)
    return labels


def kept(labels: Sequence[Any]) -> list[int]:
    """Which channels are kept: those with a dof."""
    rows = [i for i, label in enumerate(labels) if label is not None]
    if not rows:
        reject("dofs", "None for every channel", "at least one channel to keep", "Give one of them a dof.")
    return rows


def in_si(values: Any, unit: Unit) -> Any:
    """Values in SI; bit-identical where they are SI already."""
    return values if unit.factor == 1.0 else values * unit.factor


def _unit(path: Path, channel: Channel) -> Unit:
    unit = parse_unit(channel.unit) or Unit()
    if unit.per:
        found, wanted = f"with the unit {channel.unit!r} of channel {channel.name!r}", "a unit of a record"
        unsuitable(path, found, wanted, "Export time records, or read the file as frequency responses.")
    return unit


def unit_or_warning(path: Path, text: str) -> Unit:
    """The unit of that name; one that is not known leaves values as they are, with a warning."""
    unit = parse_unit(text)
    if unit is None:
        warn(
            "unknown_unit",
            f"path: {str(path)!r} has responses in {text!r}, which is no unit known "
            "here; values are as they are in the file. Name it by unit= if they should be converted.",
        )
    return unit or Unit()


def _force(forces: list[Channel], force: Any) -> Channel | None:
    automatic = isinstance(force, str) and force == "auto"
    if force is None or (automatic and not forces):
        return None
    names = [c.name for c in forces]
    if automatic and len(forces) > 1:
        got = f"'auto' for a file with {len(forces)} force channels, {names}"
        reject("force", got, "the name of one, or None", "The theory is that of one force.")
    if not automatic and force not in names:
        wanted = f"'auto', None or a channel of the file, {names or 'it has no force'}"
        reject("force", repr(force), wanted, "Name a channel of the file, or pass None for no force.")
    return forces[0 if automatic else names.index(force)]
