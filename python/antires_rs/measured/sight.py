"""What a set of antiresonances was identified from, and so which roots of a model it can show."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

from ..support.validation import reject
from .tables import label

__all__ = ["Sees", "channels_of", "checked_sees", "moved_channels", "sight_of_all"]

Sees = Literal["frf", "transmissibility"] | None
_KINDS = ("frf", "transmissibility", None)


def checked_sees(sees: Any) -> Sees:
    """One of the kinds."""
    if sees not in _KINDS:
        reject("sees", repr(sees), "'frf', 'transmissibility' or None", "Leave it out where it is not known.")
    kind: Sees = sees
    return kind


def channels_of(given: Iterable[Any] | None, dofs: tuple[Any, ...]) -> tuple[Any, ...]:
    """All responses measured together, those with a table among them; empty if not all are known."""
    if given is None:
        return dofs
    if isinstance(given, str | bytes) or not isinstance(given, Iterable):
        reject("channels", given, "a list of dofs", "Put the dofs in a list, such as channels=[0, 1].")
    named = tuple(dict.fromkeys(label("channels", dof) for dof in given))
    missing = [dof for dof in dofs if dof not in named]
    if named and missing:
        reject(
            "channels",
            f"{named} without {missing[0]!r}",
            "every dof of freq_hz among them",
            "Add it: it was measured too. Leave channels out if there were no others.",
        )
    return named


def moved_channels(channels: tuple[Any, ...], names: Mapping[Any, Any]) -> tuple[Any, ...]:
    """The channels under other names; empty if one has none, for what all share cannot be told then."""
    return tuple(names[dof] for dof in channels) if all(dof in names for dof in channels) else ()


def sight_of_all(sets: Sequence[Any], force: Any) -> dict[str, Any]:
    """``sees`` and ``channels`` of setups that are joined: of one kind, all channels if the force stayed."""
    kinds = {one.sees for one in sets}
    stayed = all(one.excitation == force and one.channels for one in sets)
    channels = tuple(dict.fromkeys(dof for one in sets for dof in one.channels)) if stayed else ()
    return {"sees": kinds.pop() if len(kinds) == 1 else None, "channels": channels}
