"""From channels as a file has them to a Recording: roles, units and names."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import reject
from ..signals.recording import Recording
from ..support.checks import FloatArray, shape_of
from ..support.messages import LeftOut, Passed, Wording, warn
from .common import unsuitable
from .units import Unit, named_unit, parse_unit

#: How a user names dofs: in the order of the channels, by the channel's own name, or by a function of it.
Dofs = Iterable[Any] | Mapping[Any, Any] | Callable[[Any], Any] | None


@dataclass(frozen=True)
class Channel:
    """One channel of a file.

    Attributes
    ----------
    name : str or int
        As the file has it.
    values : (n_samples,)
    unit : str
        As the file has it; ``''`` where it is silent.
    role : {"", "force", "response"}
        Where the file states it.
    """

    name: Any
    values: FloatArray
    unit: str = ""
    role: str = ""


def recording_of(
    path: Path,
    channels: Sequence[Channel],
    fs_hz: float,
    *,
    dofs: Dofs = None,
    force: Any = "auto",
    unit: str | None = None,
) -> Recording:
    """The recording, in SI, its force told from its responses.

    A channel is a force where the file says so, by role or unit. ``force`` is "auto" (the only one there is),
    None (left out) or the name of a channel.
    """
    # The unit that a user names is that of the responses.
    units = {id(c): _unit(path, c) for c in channels}
    forces = [c for c in channels if c.role == "force" or units[id(c)].quantity == "force"]
    if force not in ("auto", None) and all(c.name != force for c in forces):
        forces += [c for c in channels if c.name == force]  # the user knows better than a silent file
    responses = [c for c in channels if not any(c is f for f in forces)]
    if not responses:
        unsuitable(
            path,
            f"with {len(forces)} force and no response",
            "at least one response channel",
            "Export the response channels too.",
        )
    chosen = _force(forces, force)
    labels = renamed("dofs", [c.name for c in responses], dofs)
    # What is left out need not fit the rest.
    rows = kept(labels)
    used = [responses[i] for i in rows]
    lengths = {c.values.size for c in (*used, *([] if chosen is None else [chosen]))}
    if len(lengths) > 1:
        unsuitable(
            path,
            f"with channels of {sorted(lengths)} samples",
            "channels of one length",
            Wording("Leave out those of other lengths by {}.", Passed("dofs")),
        )
    if unit is not None:
        units |= {id(c): named_unit("unit", unit) for c in used}
    else:
        _warn_unknown(path, used)
    if len({units[id(c)].quantity for c in used}) > 1:
        unsuitable(
            path,
            "with responses of several kinds, "
            + ", ".join(f"{c.name!r} in {c.unit or 'no unit'}" for c in used),
            "accelerations, velocities or displacements alone",
            Wording(
                "Leave out those of other kinds by {}, or name the {} of all.", Passed("dofs"), Passed("unit")
            ),
        )
    return Recording(
        np.stack([in_si(c.values, units[id(c)]) for c in used]),
        fs_hz,
        [labels[i] for i in rows],
        None if chosen is None else in_si(chosen.values, units[id(chosen)]),
    )


def renamed(argument: str, names: Sequence[Any], dofs: Dofs) -> list[Any]:
    """The dof of each channel; None for those the user leaves out."""
    if dofs is None:
        return list(names)
    if isinstance(dofs, Mapping):
        lost = [name for name in names if name not in dofs]
        if lost:
            reject(
                argument,
                f"no dof for {lost}",
                f"a dof for each of {list(names)}",
                Wording("{}.", LeftOut("channel")),
            )
        return [dofs[name] for name in names]
    if callable(dofs):
        return [dofs(name) for name in names]
    labels = list(dofs) if shape_of(dofs) != () else [dofs]
    if len(labels) != len(names):
        reject(
            argument,
            f"{len(labels)} dofs",
            f"{len(names)}, one for each of {list(names)}",
            "Name a dof for each channel, in their order, or map channels to dofs.",
        )
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
        unsuitable(
            path,
            f"with the unit {channel.unit!r} of channel {channel.name!r}",
            "a unit of a record",
            "Export time records, or read the file as frequency responses.",
        )
    return unit


def _warn_unknown(path: Path, responses: Sequence[Channel]) -> None:
    for odd in sorted({c.unit for c in responses if parse_unit(c.unit) is None}):
        unit_or_warning(path, odd)


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
    if force is None or (isinstance(force, str) and force == "auto" and not forces):
        return None
    names = [c.name for c in forces]
    if isinstance(force, str) and force == "auto":
        if len(forces) > 1:
            reject(
                "force",
                f"'auto' for a file with {len(forces)} force channels, {names}",
                "the name of one, or None",
                "The theory is that of one force.",
            )
        return forces[0]
    if force not in names:
        reject(
            "force",
            repr(force),
            f"'auto', None or a channel of the file, {names or 'it has no force'}",
            "Name a channel of the file, or pass None for no force.",
        )
    return forces[names.index(force)]
