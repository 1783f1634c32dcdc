"""A hammer that roved: each hit is identified by itself, all are joined at the sensor that stayed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.merge import merge_setups
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from .identify import identify_antiresonances

__all__ = ["Hit", "identify_roving"]


@dataclass(frozen=True)
class Hit:
    """One of the measurements: what it is called, and where its force acted."""

    name: str
    signal: Recording | FrequencyResponse
    force: Any


def identify_roving(
    hits: Sequence[Hit],
    sensor: Any,
    band_hz: Sequence[float],
    *,
    say: Callable[[str], Any] | None = None,
    **options: Any,
) -> AntiresonanceSet:
    """The antiresonances of all places that were hit, to a force at the sensor (H_ik = H_ki).

    Parameters
    ----------
    hits : sequence of Hit
        Two or more.
    sensor : int or str
        A response or the force of each of them.
    band_hz : (low, high)
    say : callable, optional
        Told of each measurement before it is identified.
    **options
        Of :func:`~antires_rs.identify_antiresonances`.

    Returns
    -------
    AntiresonanceSet
        As :func:`~antires_rs.merge_setups` joins them, with the diagram of each value that comes from one
        measurement alone.
    """
    sets = []
    for hit in hits:
        if say is not None:
            say(f"identifying the antiresonances of {hit.name}, force at {hit.force}")
        sets.append(identify_antiresonances(hit.signal, excitation=hit.force, band_hz=band_hz, **options))
    joined = merge_setups(sets, excitation=sensor)
    diagrams = {}
    for dof in joined:
        seen = [one.diagrams[dof] for one in sets if one.excitation == sensor and dof in one.diagrams]
        seen += [one.diagrams[sensor] for one in sets if dof == one.excitation != sensor]
        if len(seen) == 1:
            diagrams[dof] = seen[0]
    return AntiresonanceSet.from_tables(
        sensor, joined.tables, diagrams=diagrams, sees=joined.sees, channels=joined.channels or None
    )
