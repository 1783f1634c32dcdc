"""What is on the desk at one moment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...measured.antiresonance_set import AntiresonanceSet
from ...measured.replay import Asked, replayed

__all__ = ["Sight"]


@dataclass(frozen=True)
class Sight:
    """What is on the desk at one moment; undo goes back to an earlier one.

    Attributes
    ----------
    zeros : AntiresonanceSet
        With the edits that it can take.
    asked : tuple of Asked
        All edits, in order.
    waits : tuple of str or None
        For each edit why it waits, None where it was made.
    band_hz : (low, high) or None
        None where there is nothing to identify from.
    max_order : int or None
        None for the default.
    warned : tuple of str
        What the identification warned of.
    """

    zeros: AntiresonanceSet
    asked: tuple[Asked, ...] = ()
    waits: tuple[str | None, ...] = ()
    band_hz: tuple[float, float] | None = None
    max_order: int | None = None
    warned: tuple[str, ...] = ()

    def on(self, base: AntiresonanceSet, asked: Sequence[Asked]) -> Sight:
        """The same edits, or others, on a set without any."""
        zeros, waits = replayed(base, asked)
        return replace(self, zeros=zeros, asked=tuple(asked), waits=tuple(waits))
