"""Files of recorders, whose channels state their own rate: TDMS, WAV and miniSEED."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from ..exceptions import reject
from ..signals.recording import Recording
from ..support.checks import real_array
from ._child import Answer, Unfit, answer, asked, called, room
from .channels import Channel, stated_recording
from .child_process import Limits, channels_of_child
from .common import missing_part, require, unsuitable
from .reading import PathLike, Rated, Selected, opened, reader

# -- TDMS of National Instruments (LabVIEW, FlexLogger, DIAdem)


_WANTED_TDMS = "a whole TDMS file"
#: Bytes of a segment's lead-in, and the length of a segment that LabVIEW did not close.
_LEAD_IN, _NEVER_CLOSED = 28, 2**64 - 1


@reader
def read_tdms(
    path: PathLike,
    *,
    partial: bool = False,
    time_limit_s: float = 60.0,
    memory_limit_gb: float = 8.0,
    **options: Unpack[Rated],
) -> Recording:
    """Read a TDMS file, scaled as it says.

    Where several groups have channels they are named ``group/channel``. Rates are those of ``wf_increment``
    or of a channel of time, units those of ``unit_string``. When the record began is compared between the
    channels, and not kept.

    Parameters
    ----------
    partial : bool
        Read a file that was cut, or whose writing was interrupted, as far as it goes, with a warning.

    Raises
    ------
    UnsuitableDataError
        A damaged file; channels of several rates, lengths or starts, without a choice among them.
    MissingDependencyError
        npTDMS is not installed.

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
    file, given = opened(read_tdms, path, options)
    _check_segments(file, partial)
    require("read_tdms", "nptdms", "tdms")
    limits = Limits(time_limit_s, memory_limit_gb)
    entries, _ = channels_of_child(channels_of_tdms, file, _WANTED_TDMS, limits, given)
    return stated_recording(file, [Channel(**entry) for entry in entries], given)


def channels_of_tdms(path: str, request: dict[str, Any]) -> Answer:
    """Channels of a TDMS file, scaled, with rate, unit and start where their properties have them."""
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


def _check_segments(file: Path, partial: bool) -> None:
    """Each segment states its length, and the last must end the file."""
    size, at, count = file.stat().st_size, 0, 0
    with open(file, "rb") as stream:
        while at < size:
            stream.seek(at)
            lead = stream.read(_LEAD_IN)
            if lead[:4] != b"TDSm":
                what = f"damaged after segment {count}" if count else "which does not begin with a segment"
                unsuitable(file, what, _WANTED_TDMS, "It is another file, or was damaged.")
            order: Any = "big" if len(lead) > 4 and lead[4] & 0x40 else "little"
            length = int.from_bytes(lead[12:20], order)
            end = at + _LEAD_IN + length
            if len(lead) < _LEAD_IN or length == _NEVER_CLOSED or end > size:
                problem = "was never closed" if length == _NEVER_CLOSED else "is cut"
                found, whole = f"its segment {count + 1} {problem}", count + (len(lead) == _LEAD_IN)
                missing_part(file, found, _WANTED_TDMS, partial, whole)
                return
            at, count = end, count + 1


# -- WAV of sound cards and recorders


_WANTED_WAV = "a whole WAV file (RIFF) of whole numbers or floats"


@reader
def read_wav(
    path: PathLike,
    *,
    full_scale: Any = None,
    time_limit_s: float = 60.0,
    memory_limit_gb: float = 8.0,
    **options: Unpack[Selected],
) -> Recording:
    """Read a WAV file: 8 to 32 bit whole numbers, 32 and 64 bit floats, any number of channels.

    The channels are called ``channel 1``, ``channel 2``, ...

    Parameters
    ----------
    full_scale : float or sequence of float, optional
        What full scale stands for in ``unit`` (of the force: N), one number or one for each channel. Whole
        numbers are shares of full scale, -1 to 1; floats are multiplied too. 1 by default.

    Raises
    ------
    UnsuitableDataError
        A cut or damaged file, compressed sound.

    Warns
    -----
    AntiresWarning
        Without ``unit``: the format has none.

    Examples
    --------
    >>> import tempfile, numpy as np, antires_rs as ar
    >>> from scipy.io import wavfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     wavfile.write(folder + "/a.wav", 8000, np.array([[0, 16384], [8192, -16384]], dtype=np.int16))
    ...     record = ar.read_wav(folder + "/a.wav", full_scale=10.0, unit="m/s2")
    >>> record.fs_hz, record.responses.tolist()
    (8000.0, [[0.0, 2.5], [5.0, -5.0]])
    """
    file, given = opened(read_wav, path, options)
    _check_chunks(file)
    limits = Limits(time_limit_s, memory_limit_gb)
    entries, _ = channels_of_child(channels_of_wav, file, _WANTED_WAV, limits)
    for entry, scale in zip(entries, _scales(full_scale, len(entries)), strict=True):
        entry |= {"values": entry["values"] * scale, "unit": "N" if entry["name"] == given.force else ""}
    return stated_recording(file, [Channel(**entry) for entry in entries], given)


def channels_of_wav(path: str, request: dict[str, Any]) -> Answer:
    """Channels of a WAV file; whole numbers become shares of full scale."""
    from scipy.io import wavfile

    rate, values = wavfile.read(path)
    values = values[:, None] if values.ndim == 1 else values
    room(values.size, request)
    if values.dtype == np.uint8:
        values = (values.astype(np.float64) - 128.0) / 128.0
    elif values.dtype.kind == "i":
        values = values / 2.0 ** (8 * values.dtype.itemsize - 1)
    return answer(
        [
            {"name": f"channel {i + 1}", "values": np.float64(column), "step_s": 1.0 / rate}
            for i, column in enumerate(values.T)
        ]
    )


def _scales(full_scale: Any, count: int) -> list[float]:
    if full_scale is None:
        return [1.0] * count
    wanted = "a number, or one for each channel"
    given = np.atleast_1d(real_array("full_scale", full_scale, ndim=None, wanted=wanted))
    if given.size not in (1, count) or (given == 0.0).any():
        expected = f"one number, or {count}, one for each channel, none of them 0"
        reject("full_scale", full_scale, expected, "Give what 0 dB of full scale stands for.")
    return [float(scale) for scale in np.broadcast_to(given, count)]


def _check_chunks(file: Path) -> None:
    """Each chunk states its length, and the one of the samples must be whole."""
    size, at = file.stat().st_size, 12
    with open(file, "rb") as stream:
        head = stream.read(12)
        if head[:4] not in (b"RIFF", b"RIFX", b"RF64") or head[8:12] != b"WAVE":
            unsuitable(file, "which has no RIFF header", _WANTED_WAV, "It is another file, or was cut.")
        order: Any = "big" if head[:4] == b"RIFX" else "little"
        while at + 8 <= size:
            stream.seek(at)
            chunk = stream.read(8)
            length = int.from_bytes(chunk[4:8], order)
            if chunk[:4] == b"data":
                if head[:4] != b"RF64" and at + 8 + length > size:
                    found = f"with {size - at - 8} of {length} bytes of samples"
                    unsuitable(file, found, _WANTED_WAV, "It was cut: copy it again.")
                return
            at += 8 + length + length % 2
    unsuitable(file, "without samples (no data chunk)", _WANTED_WAV, "It was cut: copy it again.")


# -- miniSEED of seismic recorders and many wireless sensors


@reader
def read_miniseed(
    path: PathLike, *, time_limit_s: float = 60.0, memory_limit_gb: float = 8.0, **options: Unpack[Selected]
) -> Recording:
    """Read a miniSEED file.

    The traces are called ``network.station.location.channel``. The format has counts of the recorder alone:
    without ``unit`` a warning says so.

    Raises
    ------
    UnsuitableDataError
        A damaged file, gaps in a trace, traces of several rates, lengths or starts (more than half a sample
        apart).
    MissingDependencyError
        ObsPy is not installed.

    Notes
    -----
    The response of the instruments is not removed: channels of one kind of sensor and recorder go together,
    others are first brought to one unit by ObsPy's ``remove_response``.

    Examples
    --------
    >>> import antires_rs as ar
    >>> record = ar.read_miniseed("tower.mseed", responses="*.HNX", unit="m/s2")  # doctest: +SKIP
    """
    file, given = opened(read_miniseed, path, options)
    require("read_miniseed", "obspy", "miniseed")
    limits = Limits(time_limit_s, memory_limit_gb)
    entries, _ = channels_of_child(traces_of_miniseed, file, "a whole miniSEED file", limits, given)
    name, count = Counter(entry["name"] for entry in entries).most_common(1)[0] if entries else ("", 0)
    if count > 1:
        before, after = [entry for entry in entries if entry["name"] == name][:2]
        unsuitable(
            file,
            f"whose {name} has {count - 1} gaps or overlaps, the first between {before['until']} and "
            f"{after['start']}",
            "traces without gaps",
            "Cut a part without gaps out of it, with ObsPy's slice or the recorder's program.",
        )
    for entry in entries:
        del entry["until"]
    return stated_recording(file, _on_one_clock([Channel(**entry) for entry in entries]), given)


def traces_of_miniseed(path: str, request: dict[str, Any]) -> Answer:
    """Traces of a miniSEED file, those that follow each other joined."""
    from obspy import read

    room(int(sum(trace.stats.npts for trace in read(path, format="MSEED", headonly=True))), request)
    stream = read(path, format="MSEED")
    stream.merge(method=-1)
    made = [
        {
            "name": trace.id,
            "values": np.float64(trace.data),
            "unit": "counts",
            "step_s": float(trace.stats.delta),
            "start": str(trace.stats.starttime),
            "until": str(trace.stats.endtime),
        }
        for trace in stream
        if asked((trace.id, trace.stats.channel), trace.stats.channel, request)
        and trace.data.dtype.kind in "biuf"
    ]
    if not made and request["only"] is not None:
        raise Unfit("the traces are " + called(trace.id for trace in stream))
    return answer(made)


def _on_one_clock(channels: list[Channel]) -> list[Channel]:
    """Traces that begin within half a sample of each other begin together."""
    begun = [datetime.fromisoformat(c.start.replace("Z", "+00:00")) for c in channels]
    step = channels[0].step_s or 0.0 if channels else 0.0
    if any(abs((each - begun[0]).total_seconds()) > 0.5 * step for each in begun):
        return channels
    return [replace(c, start=channels[0].start) for c in channels]
