"""miniSEED, the format of seismic recorders and many wireless sensors, through ObsPy."""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from ..signals.recording import Recording
from ._child import Answer, Unfit, answer, asked, called, room
from .channels import Channel, Dofs, Reading, stated_recording
from .child_process import Limits, channels_of_child, require
from .common import existing_file, unsuitable


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
    file, given = existing_file(path), Reading.of(locals())
    require("read_miniseed", "obspy", "miniseed")
    limits = Limits(time_limit_s, memory_limit_gb)
    entries, _ = channels_of_child(traces_of_miniseed, file, "a whole miniSEED file", limits, given)
    _no_gaps(file, entries)
    for entry in entries:
        del entry["until"]
    return stated_recording(file, _on_one_clock([Channel(**entry) for entry in entries]), given)


def traces_of_miniseed(path: str, request: dict[str, Any]) -> Answer:
    """Traces of a miniSEED file, those that follow each other joined."""
    import numpy as np
    from obspy import read

    room(int(sum(trace.stats.npts for trace in read(path, format="MSEED", headonly=True))), request)
    stream = read(path, format="MSEED")
    stream.merge(method=-1)
    made = []
    for trace in stream:
        if (
            asked((trace.id, trace.stats.channel), trace.stats.channel, request)
            and trace.data.dtype.kind in "biuf"
        ):
            made.append(
                {
                    "name": trace.id,
                    "values": np.float64(trace.data),
                    "unit": "counts",
                    "step_s": float(trace.stats.delta),
                    "start": str(trace.stats.starttime),
                    "offset_s": 0.0,
                    "until": str(trace.stats.endtime),
                }
            )
    if not made and request["only"] is not None:
        raise Unfit("the traces are " + called(trace.id for trace in stream))
    return answer(made)


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


def _on_one_clock(channels: list[Channel]) -> list[Channel]:
    """Traces that begin within half a sample of each other begin together."""
    if len(channels) < 2:
        return channels
    begun = [datetime.fromisoformat(c.start.replace("Z", "+00:00")) for c in channels]
    step = channels[0].step_s or 0.0
    if max(abs((each - begun[0]).total_seconds()) for each in begun) <= 0.5 * step:
        return [replace(c, start=channels[0].start) for c in channels]
    return channels
