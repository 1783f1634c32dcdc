"""miniSEED, the format of seismic recorders and many wireless sensors, through ObsPy."""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from ..signals.recording import Recording
from .channels import Dofs
from .common import existing_file, unsuitable
from .stated_channels import Stated, channels_of_child, stated_recording


def read_miniseed(
    path: str | os.PathLike[str],
    *,
    responses: Any = None,
    dofs: Dofs = None,
    force: Any = "auto",
    unit: str | None = None,
    time_limit_s: float = 60.0,
    memory_limit_gb: float = 8.0,
) -> Recording:
    """Read a miniSEED file.

    Parameters
    ----------
    path : path-like
    responses : str or sequence of str, optional
        Names of the traces, ``network.station.location.channel``, ``*`` for any text; all by default.
    dofs : sequence, mapping or callable, optional
        Dof of each response: in order, by name, or a function of the name; None leaves one out. Default: the
        names.
    force : str or None
        Name of the force; "auto" and None: there is none.
    unit : str, optional
        Unit of the values. The format has counts of the recorder alone: without it a warning says so.
    time_limit_s, memory_limit_gb : float
        Limits of the child process that reads (the memory's where the system has such limits).

    Returns
    -------
    Recording

    Raises
    ------
    UnsuitableDataError
        A damaged file, gaps in a trace, traces of several rates, lengths or starts (more than half a sample
        apart).
    InvalidInputError
        Options that do not fit the file.
    MissingDependencyError
        ObsPy is not installed.
    FileNotFoundError
        There is none.

    Notes
    -----
    The response of the instruments is not removed: channels of one kind of sensor and recorder go together,
    others are first brought to one unit by ObsPy's ``remove_response``.

    Examples
    --------
    >>> import antires_rs as ar
    >>> record = ar.read_miniseed("tower.mseed", responses="*.HNX", unit="m/s2")  # doctest: +SKIP
    """
    file = existing_file(path)
    entries, _ = channels_of_child(
        "mseed",
        file,
        ("obspy", "miniseed"),
        "read_miniseed",
        "a whole miniSEED file",
        responses=responses,
        time_limit_s=time_limit_s,
        memory_limit_gb=memory_limit_gb,
    )
    _no_gaps(file, entries)
    for entry in entries:
        del entry["until"]
    channels = [Stated(**entry) for entry in entries]
    return stated_recording(
        file, _on_one_clock(channels), responses=responses, dofs=dofs, force=force, unit=unit
    )


def _no_gaps(file: Path, entries: list[dict[str, Any]]) -> None:
    """Refuse traces that come in several parts, with the place between the first two."""
    counts = Counter(entry["name"] for entry in entries)
    for name, count in counts.items():
        if count > 1:
            first, second = [entry for entry in entries if entry["name"] == name][:2]
            unsuitable(
                file,
                f"whose {name} has {count - 1} gaps or overlaps, the first between {first['until']} and "
                f"{second['start']}",
                "traces without gaps",
                "Cut a part without gaps out of it, with ObsPy's slice or the recorder's program.",
            )


def _on_one_clock(channels: list[Stated]) -> list[Stated]:
    """Traces that begin within half a sample of each other begin together."""
    if len(channels) < 2:
        return channels
    begun = [datetime.fromisoformat(c.start.replace("Z", "+00:00")) for c in channels]
    step = channels[0].step_s or 0.0
    if max(abs((each - begun[0]).total_seconds()) for each in begun) <= 0.5 * step:
        return [replace(c, start=channels[0].start) for c in channels]
    return channels
