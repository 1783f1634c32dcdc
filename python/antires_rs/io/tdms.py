"""TDMS of National Instruments (LabVIEW, FlexLogger, DIAdem), through npTDMS."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from ..signals.recording import Recording
from ._child import Answer, Unfit, answer, asked, called, room
from .channels import Channel, Dofs, Reading, stated_recording
from .child_process import Limits, channels_of_child, require
from .common import existing_file, missing_part, unsuitable

_WANTED = "a whole TDMS file"
#: Bytes of a segment's lead-in, and the length of a segment that LabVIEW did not close.
_LEAD_IN, _NEVER_CLOSED = 28, 2**64 - 1


def read_tdms(
    path: str | os.PathLike[str],
    *,
    responses: Any = None,
    fs_hz: float | None = None,
    dofs: Dofs = None,
    force: Any = "auto",
    unit: str | None = None,
    partial: bool = False,
    time_limit_s: float = 60.0,
    memory_limit_gb: float = 8.0,
) -> Recording:
    """Read a TDMS file, scaled as it says.

    Parameters
    ----------
    path : path-like
    responses : str or sequence of str, optional
        Names of the response channels, ``*`` for any text; all by default. Where several groups have
        channels they are named ``group/channel``.
    fs_hz : float, optional
        Sampling rate, where the file has no ``wf_increment`` and no channel of time.
    dofs : sequence, mapping or callable, optional
        Dof of each response: in order, by name, or a function of the name; None leaves one out. Default: the
        names.
    force : str or None
        Name of the force; "auto" takes the one in N or called force, None leaves it out.
    unit : str, optional
        Unit of the responses, in place of the file's ``unit_string``: ``'m/s2'``, ``'g'`` and the like.
    partial : bool
        Read a file that was cut, or whose writing was interrupted, as far as it goes, with a warning.
    time_limit_s, memory_limit_gb : float
        Limits of the child process that reads (the memory's where the system has such limits).

    Returns
    -------
    Recording
        In SI. When it began is compared between the channels, and not kept.

    Raises
    ------
    UnsuitableDataError
        A damaged file; channels of several rates, lengths or starts, without a choice among them.
    InvalidInputError
        Options that do not fit the file.
    MissingDependencyError
        npTDMS is not installed.
    FileNotFoundError
        There is none.

    Warns
    -----
    AntiresWarning
        Units that are unknown or missing, another rate than ``fs_hz``.

    Examples
    --------
    >>> import tempfile, numpy as np, antires_rs as ar
    >>> from nptdms import ChannelObject, TdmsWriter
    >>> made = {"wf_increment": 0.01, "unit_string": "g"}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with TdmsWriter(folder + "/a.tdms") as file:
    ...         file.write_segment([ChannelObject("run", "tip", np.array([1.0, 2.0, 4.0]), properties=made)])
    ...     ar.read_tdms(folder + "/a.tdms", dofs={"tip": 4})
    Recording(1 channels, 0.03 s at 100 Hz, dofs=(4,), no force)
    """
    file, given = existing_file(path), Reading.of(locals())
    _check_length(file, partial)
    require("read_tdms", "nptdms", "tdms")
    limits = Limits(time_limit_s, memory_limit_gb)
    entries, _ = channels_of_child(channels_of_tdms, file, _WANTED, limits, given)
    return stated_recording(file, [Channel(**entry) for entry in entries], given)


def channels_of_tdms(path: str, request: dict[str, Any]) -> Answer:
    """Channels of a TDMS file, scaled, with rate, unit and start where their properties have them."""
    import numpy as np
    from nptdms import TdmsFile

    made: list[dict[str, Any]] = []
    with TdmsFile.open(path) as file:
        several = sum(bool(group.channels()) for group in file.groups()) > 1
        chosen = [
            (f"{group.name}/{channel.name}" if several else channel.name, channel)
            for group in file.groups()
            for channel in group.channels()
            if len(channel) and asked((f"{group.name}/{channel.name}", channel.name), channel.name, request)
        ]
        if not chosen and request["only"] is not None:
            raise Unfit("the channels are " + called(c.name for g in file.groups() for c in g.channels()))
        room(sum(len(channel) for _, channel in chosen), request)
        for name, channel in chosen:
            values = np.asarray(channel[:])
            if values.dtype.kind == "M":
                values = (values - values[0]) / np.timedelta64(1, "s")
            if values.dtype.kind not in "biufc":
                continue
            own = channel.properties
            axis = f"{own.get('wf_xname', '')} {own.get('wf_xunit_string', '')}".lower()
            if "frequency" in axis or axis.endswith("hz"):
                raise Unfit(f"the channel {name!r} lies over frequency, not time")
            step = own.get("wf_increment")
            unit = own.get("unit_string") or own.get("NI_UnitDescription") or own.get("Unit") or ""
            made.append(
                {
                    "name": name,
                    "values": values,
                    "unit": str(unit),
                    "step_s": None if step is None else float(step),
                    "start": str(own.get("wf_start_time", "")),
                    "offset_s": float(own.get("wf_start_offset", 0.0) or 0.0),
                }
            )
    return answer(made)


def _check_length(file: Path, partial: bool) -> None:
    """Walk the segments: each states its length, and the last must end the file."""
    size, at, count = file.stat().st_size, 0, 0
    with open(file, "rb") as opened:
        while at < size:
            opened.seek(at)
            lead = opened.read(_LEAD_IN)
            if lead[:4] != b"TDSm":
                what = (
                    "which does not begin with a segment" if count == 0 else f"damaged after segment {count}"
                )
                unsuitable(file, what, _WANTED, "It is another file, or was damaged.")
            order = "big" if len(lead) > 4 and lead[4] & 0x40 else "little"
            length = int.from_bytes(lead[12:20], order)  # type: ignore[arg-type]
            end = at + _LEAD_IN + length
            if len(lead) < _LEAD_IN or length == _NEVER_CLOSED or end > size:
                said = "was never closed" if length == _NEVER_CLOSED else "is cut"
                missing_part(
                    file, f"its segment {count + 1} {said}", _WANTED, partial, count + (len(lead) == 28)
                )
                return
            at, count = end, count + 1
