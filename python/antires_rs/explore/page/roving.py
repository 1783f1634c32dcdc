"""The hits of a roving hammer as one source, whose force is at another place for each response."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...identification.roving import Hit, identify_roving
from ...measured.antiresonance_set import AntiresonanceSet
from ..curve import Curve
from .sources import Band, OneMeasurement

__all__ = ["RovingHammer"]


class RovingHammer:
    """A measurement for each place that was hit, and the sensor that stayed: by reciprocity its responses."""

    def __init__(self, hits: Sequence[Hit], sensor: Any) -> None:
        self._hits, self._sensor = tuple(hits), sensor
        self._places: dict[Any, tuple[OneMeasurement, Any]] = {}
        for hit in hits:
            one = OneMeasurement(hit.signal)
            # A hit at the sensor itself shows all responses.
            own = {dof: dof for dof in one.dofs} if hit.force == sensor else {hit.force: sensor}
            for dof, channel in own.items():
                self._places.setdefault(dof, (one, channel))

    @property
    def dofs(self) -> tuple[Any, ...]:
        """Places that were hit, and responses under a hit at the sensor."""
        return tuple(self._places)

    @property
    def covered_hz(self) -> Band:
        """Of all measurements."""
        return self._common("covered_hz")

    @property
    def whole_band(self) -> Band:
        """That of all measurements."""
        return self._common("whole_band")

    @property
    def response(self) -> None:
        """There is none: each has a force of its own."""

    def identify(self, excitation: Any, band_hz: Band, options: Mapping[str, Any]) -> AntiresonanceSet:
        """Each by itself, joined."""
        return identify_roving(self._hits, self._sensor, band_hz, progress=False, **options)

    def curve(self, dof: Any, band_hz: Band, options: Mapping[str, Any]) -> Curve | None:
        """That of the sensor under the hit there."""
        one, channel = self._places.get(dof, (None, None))
        return None if one is None else one.curve(channel, band_hz, options)

    def _common(self, name: str) -> Band:
        bands = [getattr(one, name) for one, _ in self._places.values()]
        return max(low for low, _ in bands), min(high for _, high in bands)
