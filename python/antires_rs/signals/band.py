"""The band that data cover, and the band that is asked of them."""

from __future__ import annotations

from typing import Any

from ..support.validation import frequency_band, reject
from .frequency_response import FrequencyResponse
from .recording import Recording

__all__ = ["band_of", "covered_hz"]


def covered_hz(source: Any) -> tuple[float, float]:
    """Frequencies that a source of either kind can tell of; anything else is refused."""
    if isinstance(source, Recording):
        return 0.0, source.fs_hz / 2
    if isinstance(source, FrequencyResponse):
        return float(source.freq_hz[0]), float(source.freq_hz[-1])
    reject(
        "source",
        type(source).__name__,
        "a Recording or a FrequencyResponse",
        "Make one of the arrays first: Recording(responses, fs_hz).",
    )


def band_of(source: Any, band_hz: Any) -> tuple[float, float]:
    """A band inside what the source covers."""
    low, high = covered_hz(source)
    return frequency_band("band_hz", band_hz, low_hz=low, high_hz=high)
