"""What is on the desk at one moment, and how far the measurement behind it reaches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ...measured.antiresonance_set import AntiresonanceSet
from ...measured.replay import Asked, replayed
from ...signals.band import covered_hz
from ...signals.frequency_response import FrequencyResponse
from ...signals.recording import Recording
from ...support.validation import reject

__all__ = ["Sight", "Source", "reached", "whole_band"]

Source = Recording | FrequencyResponse


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


def whole_band(source: Source) -> tuple[float, float]:
    """A band to begin with: all lines of curves; of records up to 80 % of the highest frequency."""
    if isinstance(source, FrequencyResponse):
        positive = source.freq_hz[source.freq_hz > 0.0]
        return float(positive[0]), float(source.freq_hz[-1])
    return 0.005 * source.fs_hz, 0.4 * source.fs_hz


def reached(source: Source, freq_hz: float) -> None:
    """Refuse a frequency of which the measurement cannot tell."""
    low, high = covered_hz(source)
    if not low <= freq_hz <= high:
        reject(
            "freq_hz",
            f"{freq_hz:g} Hz",
            f"a frequency from {low:g} to {high:g} Hz, as the data reach",
            "Correct it.",
        )
