"""What a set on the desk was identified from, and can be again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

from ...identification.identify import identify_antiresonances
from ...measured.antiresonance_set import AntiresonanceSet
from ...signals.averaging import Averages, Averaging, average
from ...signals.band import covered_hz
from ...signals.frequency_response import FrequencyResponse
from ...signals.recording import Recording
from ..curve import Curve, curve_of

__all__ = ["Band", "OneMeasurement", "Source", "source_of"]

Band = tuple[float, float]


class Source(Protocol):
    """A measurement, or several that make one set."""

    @property
    def dofs(self) -> tuple[Any, ...]:
        """Those of the set."""

    @property
    def covered_hz(self) -> Band:
        """Frequencies of which it can tell."""

    @property
    def whole_band(self) -> Band:
        """A band to begin with."""

    @property
    def response(self) -> FrequencyResponse | None:
        """Curves of all responses under one force, where it has them."""

    def identify(self, excitation: Any, band_hz: Band, options: Mapping[str, Any]) -> AntiresonanceSet:
        """The set, in a band."""

    def curve(self, dof: Any, band_hz: Band, options: Mapping[str, Any]) -> Curve | None:
        """What was measured at a dof, on the lines of the band."""


class OneMeasurement:
    """A record, or FRFs; repeated ones as one."""

    def __init__(self, signal: Recording | FrequencyResponse) -> None:
        self._signal = signal
        self._averages: dict[Band, Averages] = {}

    @property
    def dofs(self) -> tuple[Any, ...]:
        """Those of the channels."""
        return self._signal.dofs

    @property
    def covered_hz(self) -> Band:
        """Of records up to half the sampling rate."""
        return covered_hz(self._signal)

    @property
    def whole_band(self) -> Band:
        """All lines of curves; of records up to 80 % of the highest frequency."""
        signal = self._signal
        if isinstance(signal, FrequencyResponse):
            positive = signal.freq_hz[signal.freq_hz > 0.0]
            return float(positive[0]), float(signal.freq_hz[-1])
        return 0.005 * signal.fs_hz, 0.4 * signal.fs_hz

    @property
    def response(self) -> FrequencyResponse | None:
        """None of a record."""
        return self._signal if isinstance(self._signal, FrequencyResponse) else None

    def identify(self, excitation: Any, band_hz: Band, options: Mapping[str, Any]) -> AntiresonanceSet:
        """As :func:`~antires_rs.identify_antiresonances`."""
        return identify_antiresonances(
            self._signal, excitation=excitation, band_hz=band_hz, progress=False, **options
        )

    def curve(self, dof: Any, band_hz: Band, options: Mapping[str, Any]) -> Curve | None:
        """That of the channel."""
        signal, averages = self._signal, None
        if isinstance(signal, Recording):
            if band_hz not in self._averages:
                names = ("nperseg", "noverlap", "window", "method")
                chosen = Averaging(**{name: options[name] for name in names if name in options})
                with_force = signal.force is not None
                self._averages = {band_hz: average(signal, band_hz, chosen, include_force=with_force)}
            averages = self._averages[band_hz]
        return curve_of(signal, averages, dof)


def source_of(given: Any) -> Source | None:
    """What was given, as a source."""
    return OneMeasurement(given) if isinstance(given, Recording | FrequencyResponse) else given
