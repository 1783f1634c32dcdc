"""Files of recorders, whose channels state their own rate: TDMS, WAV, miniSEED and LVM."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from datetime import datetime
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple, Unpack, cast

import numpy as np

from ..exceptions import reject
from ..signals.recording import Recording
from ..support.checks import real_array
from ..support.messages import warn
from ._child import Answer, Unfit, answer, asked, called, room
from .channels import Channel, stated_recording
from .child_process import Limits, channels_of_child
from .common import choose_run, missing_part, rate_of, require, unsuitable
from .options import PathLike, Rated, Selected, opened, reader
from .raw_arrays import stated_number
from .text_table import decoded, signal_of_table, table_of

__all__ = ["read_lvm", "read_miniseed", "read_tdms", "read_wav"]

# -- TDMS of National Instruments (LabVIEW, FlexLogger, DIAdem)

_WANTED_TDMS = "a whole TDMS file"
#: Bytes of a segment's lead-in, and the length of a segment that LabVIEW did not close.
_LEAD_IN, _NEVER_CLOSED = 28, 2**64 - 1


@reader(".tdms")
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
        every = [(f"{group.name}/{one.name}", one) for group in file.groups() for one in group.channels()]
        chosen = [
            (path if several else channel.name, channel)
            for path, channel in every
            if len(channel) and asked((path, channel.name), channel.name, request)
        ]
        if not chosen and request["only"] is not None:
            there = called(channel.name for _, channel in every)
            raise Unfit(f"no channel has a name that you gave; they are {there}")
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
            one: dict[str, Any] = {"name": name, "values": values, "unit": str(unit)}
            one["start"] = str(own.get("wf_start_time", ""))
            one["step_s"] = None if step is None else float(step)
            one["offset_s"] = float(own.get("wf_start_offset") or 0.0)
            made.append(one)
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
                unsuitable(file, what, _WANTED_TDMS)
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


@reader(".wav")
def read_wav(
    path: PathLike,
    *,
    full_scale: Any = None,
    time_limit_s: float = 60.0,
    memory_limit_gb: float = 8.0,
    **options: Unpack[Selected],
) -> Recording:
    """Read a WAV file: 8 to 32 bit whole numbers, 32 and 64 bit floats, any number of channels.

    The channels are called ``channel 1``, ``channel 2``, ... The format has no unit: without ``unit``
    a warning says so.

    Parameters
    ----------
    full_scale : float or sequence of float, optional
        What full scale stands for in ``unit`` (of the force: N), one number or one for each channel. Whole
        numbers are shares of full scale, -1 to 1; floats are multiplied too. 1 by default.

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
    entries, _ = channels_of_child(channels_of_wav, file, _WANTED_WAV, Limits(time_limit_s, memory_limit_gb))
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
    columns = map(np.float64, values.T)
    pairs = zip((f"channel {i + 1}" for i in range(values.shape[1])), columns, strict=True)
    return answer([{"name": name, "values": column, "step_s": 1.0 / rate} for name, column in pairs])


def _scales(full_scale: Any, count: int) -> list[float]:
    wanted = f"one number, or {count}, one for each channel, none of them 0"
    given = 1.0 if full_scale is None else real_array("full_scale", full_scale, ndim=None, wanted=wanted)
    if np.size(given) not in (1, count) or np.any(given == 0.0):
        reject("full_scale", full_scale, wanted, "Give what 0 dB of full scale stands for.")
    return [float(scale) for scale in np.broadcast_to(given, count)]


def _check_chunks(file: Path) -> None:
    """Each chunk states its length, and the one of the samples must be whole."""
    size, at = file.stat().st_size, 12
    with open(file, "rb") as stream:
        head = stream.read(12)
        if head[:4] not in (b"RIFF", b"RIFX", b"RF64") or head[8:12] != b"WAVE":
            unsuitable(file, "which has no RIFF header", _WANTED_WAV)
        order: Any = "big" if head[:4] == b"RIFX" else "little"
        while at + 8 <= size:
            stream.seek(at)
            chunk = stream.read(8)
            length = int.from_bytes(chunk[4:8], order)
            if chunk[:4] == b"data":
                if head[:4] != b"RF64" and at + 8 + length > size:
                    unsuitable(file, f"with {size - at - 8} of {length} bytes of samples", _WANTED_WAV)
                return
            at += 8 + length + length % 2
    unsuitable(file, "without samples (no data chunk)", _WANTED_WAV)


# -- miniSEED of seismic recorders and many wireless sensors


@reader(".mseed .miniseed")
def read_miniseed(
    path: PathLike, *, time_limit_s: float = 60.0, memory_limit_gb: float = 8.0, **options: Unpack[Selected]
) -> Recording:
    """Read a miniSEED file.

    The traces are called ``network.station.location.channel``. The format has counts of the recorder alone:
    without ``unit`` a warning says so.

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
        first = f"the first between {before['until']} and {after['start']}"
        found = f"whose {name} has {count - 1} gaps or overlaps, {first}"
        unsuitable(file, found, "traces without gaps", "Cut a part without gaps out of it.")
    # Traces that begin within half a sample of each other begin together.
    begun = [datetime.fromisoformat(entry["start"].replace("Z", "+00:00")) for entry in entries]
    late = (abs((each - begun[0]).total_seconds()) > 0.5 * entries[0]["step_s"] for each in begun)
    together = {} if any(late) else {"start": entries[0]["start"] if entries else ""}
    for entry in entries:
        del entry["until"]
    return stated_recording(file, [Channel(**entry | together) for entry in entries], given)


def traces_of_miniseed(path: str, request: dict[str, Any]) -> Answer:
    """Traces of a miniSEED file, those that follow each other joined."""
    from obspy import read

    room(int(sum(trace.stats.npts for trace in read(path, format="MSEED", headonly=True))), request)
    stream = read(path, format="MSEED")
    stream.merge(method=-1)
    made = []
    for trace in stream:
        own = trace.stats
        if asked((trace.id, own.channel), own.channel, request) and trace.data.dtype.kind in "biuf":
            one = {"name": trace.id, "values": np.float64(trace.data), "unit": "counts"}
            one |= {"step_s": float(own.delta), "start": str(own.starttime), "until": str(own.endtime)}
            made.append(one)
    if not made and request["only"] is not None:
        raise Unfit(f"no trace has a name that you gave; they are {called(trace.id for trace in stream)}")
    return answer(made)


# -- LVM, text of LabVIEW: a header, and segments with a header each or for all
#
# The format is documented by National Instruments, "Specification for the LabVIEW Measurement File".
# Columns lie between separators; with ``X_Columns`` No the first is empty, with One it is the abscissa of
# all channels, with Multi every channel has its own before it. The last one is a comment.

_WANTED_LVM = "a whole LabVIEW Measurement File (.lvm)"
_END = re.compile(r"^\*\*\*End_of_Header\*\*\*.*\n?", re.MULTILINE)
_SPECIAL = re.compile(  # one without its end goes to that of the file, which keeps the search linear
    r"^\*\*\*Start_Special\*\*\*.*?(?:^\*\*\*End_Special\*\*\*.*?\n|\Z)", re.MULTILINE | re.DOTALL
)
_HEADER = re.compile(r"^(?=Channels[\t,])", re.MULTILINE)


class Segment(NamedTuple):
    """What one call of LabVIEW wrote: tags of its header, titles of columns, rows of fields."""

    tags: dict[str, list[str]]
    titles: list[str]
    rows: list[list[str]]


class _Form:
    """How the numbers stand, by the header of the file."""

    def __init__(self, header: str) -> None:
        parts = (re.split("[\t,]", line, maxsplit=1) for line in header.splitlines())
        tags = {part[0].strip(): part[-1].strip().lower() for part in parts}
        self.separator = "," if tags.get("Separator", "").startswith("comma") else "\t"
        self.commas = tags.get("Decimal_Separator", "").startswith(",") and self.separator != ","
        self.columns = tags.get("X_Columns", "one").strip("\t,")

    def rows(self, text: str) -> list[list[str]]:
        """The fields of each line."""
        return [[part.strip() for part in line.split(self.separator)] for line in text.split("\n")]

    def numbers(self, cells: Iterable[str]) -> Any:
        """The numbers of fields; ValueError for others."""
        return np.array([float(cell.replace(",", ".") if self.commas else cell) for cell in cells])

    def is_row(self, row: list[str]) -> bool:
        """Whether the first field that is not empty is a number."""
        with suppress(ValueError):
            return bool(self.numbers([part for part in row if part][:1]).size)
        return False


def _segments(file: Path) -> tuple[_Form, list[Segment]]:
    """How the numbers of a file stand, and its segments in order; a blank line ends one."""
    text = _SPECIAL.sub("", decoded(file))
    if not text.startswith("LabVIEW Measurement") or "\x00" in text:
        remedy = "A file without header is a table of text: read it by read_csv, format csv."
        unsuitable(file, "which does not begin with the line 'LabVIEW Measurement'", _WANTED_LVM, remedy)
    head, *parts = _END.split(text)
    form, found, tags = _Form(head), list[Segment](), dict[str, list[str]]()
    header = [""] * (not parts)  # of the segment to come
    for part in parts:
        body, *header = _HEADER.split(part, maxsplit=1)
        titles: list[str] = []
        for there, group in groupby(form.rows(body), key=any):
            rows = list(group)
            if there and not titles and not form.is_row(rows[0]):
                titles = rows.pop(0)
                while titles and not titles[-1]:
                    titles.pop()
            found += [Segment(tags, titles, rows)] if there and rows else []
        tags = {name: values for name, *values in form.rows("".join(header))}
    if header:
        unsuitable(file, "whose last header has no end", _WANTED_LVM)
    if not found:
        unsuitable(file, "with a header and no numbers", _WANTED_LVM)
    return form, found


@reader(".lvm")
def read_lvm(
    path: PathLike, *, run: int | None = None, partial: bool = False, **options: Unpack[Rated]
) -> Recording:
    """Read a LabVIEW Measurement File, of which a segment is what one call of LabVIEW wrote.

    Separator, decimal sign and abscissae (``X_Columns`` No, One or Multi) are as its header says, units those
    of ``Y_Unit_Label``; the column of comments is left out.

    Parameters
    ----------
    run : int, optional
        Which segment to read, from 1. By default all, which then have to follow each other without a gap.
        Segments that are impacts or runs are read one by one and given together:
        ``identify_antiresonances([run 1, run 2], ...)``.

    Examples
    --------
    >>> import pathlib, tempfile, antires_rs as ar
    >>> text = "LabVIEW Measurement\\nX_Columns\\tNo\\n***End_of_Header***\\n\\nChannels\\t1\\n"
    >>> text += "Delta_X\\t0.01\\n***End_of_Header***\\nX_Value\\ttip\\n\\t1.0\\n\\t2.0\\n\\t4.0\\n"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "a.lvm")
    ...     _ = file.write_text(text)
    ...     ar.read_lvm(file, unit="g")
    Recording(1 channels, 0.03 s at 100 Hz, dofs=('tip',), no force)
    """
    file, given = opened(read_lvm, path, options)
    if re.match(r"\s*[-+\d.]", decoded(file)) and run is None:  # no header: the first column is the time
        given = replace(given, first="time")
        return cast(Recording, signal_of_table(file, table_of(file, None, None), given))
    form, segments = _segments(file)
    if run is not None and not (type(run) is int and 1 <= run <= len(segments)):
        wanted = f"1 to {len(segments)}, the segments of {str(file)!r}"
        reject("run", run, wanted, "Number the segments from 1.")
    chosen = segments if run is None else [segments[run - 1]]
    made = [_channels(file, form, segment, partial, given.fs_hz) for segment in chosen]
    return stated_recording(file, _joined(file, made, len(segments)), given)


def _channels(file: Path, form: _Form, segment: Segment, partial: bool, fs_hz: float | None) -> list[Channel]:
    """Channels of one segment, each with its own rate and start."""
    (tags, titles, rows), multi = segment, form.columns == "multi"
    count = "".join(tags.get("Channels", [""])[:1])
    width = len(titles or rows[0]) - (titles[-1:] == ["Comment"])
    n = int(count) if count.isdecimal() and int(count) <= 100_000 else 0
    n = n or max(width // (1 + multi) - 1 + multi, 1)
    stated = [int(size) for size in tags.get("Samples", []) if size.isdecimal()]
    made: list[Channel] = []
    for c in range(n):
        place, before = (2 * c + 1, 2 * c) if multi else (c + 1, 0)
        name = titles[place] if place < len(titles) and titles[place] else f"channel {c + 1}"
        cells = [row[place] if place < len(row) else "" for row in rows]
        while cells and not cells[-1]:  # channels may be shorter than others
            cells.pop()
        try:
            values = form.numbers(cells)
            x = None if form.columns == "no" else form.numbers(row[before] for row in rows[: len(cells)])
        except ValueError as exc:
            unsuitable(file, f"whose {name!r} has what is no number ({exc})", "rows of numbers")
        if c < len(stated) and values.size != stated[c]:
            found = f"{name!r} has {values.size} of {stated[c]} samples"
            missing_part(file, found, _WANTED_LVM, partial, values.size if values.size < stated[c] else 0)
        own = {key: "".join(each[c : c + 1]) for key, each in tags.items()}
        made.append(_channel(file, name, x, values, own, fs_hz))
    shortest = min(c.values.size for c in made)
    if partial:  # a row that was cut leaves its last channels shorter
        made = [replace(c, values=c.values[:shortest]) for c in made]
    if shortest == 0 or not all(np.isfinite(c.values).all() for c in made):
        found = "with values that are not finite" if shortest else "with a channel without samples"
        unsuitable(file, found, "finite numbers")
    kinds = {kind.lower() for kind in tags.get("X_Dimension", [])} - {"", "time"}
    if kinds:
        over = f"lies over {', '.join(sorted(kinds))}, as its X_Dimension says"
        warn("not_over_time", f"path: {str(file)!r} {over}; it is read as a record over time.")
    return made


def _channel(
    file: Path, name: str, x: Any, values: Any, tags: dict[str, str], fs_hz: float | None
) -> Channel:
    """A channel with what its tags or its abscissae say of rate and start."""
    step, offset = stated_number(tags.get("Delta_X", "")), stated_number(tags.get("X0", "")) or 0.0
    step = step if step is not None and step > 0.0 else None
    if x is not None and x.size > 1 and np.isfinite(x).all() and fs_hz is None:
        rate = rate_of(file, x, digits=1e-6 if step is None else 1e-5)
        if step is not None and abs(rate * step - 1.0) > 1e-3 and not _rounds_to(tags["Delta_X"], 1.0 / rate):
            found = f"whose {name!r} has a Delta_X of {step:g} s and instants at {rate:g} Hz"
            unsuitable(file, found, "one rate", "Give the true one by fs_hz=.")
        rounded = step is not None and abs(rate * step - 1.0) > 1e-9
        step, offset = 1.0 / rate if rounded or step is None else step, float(x[0])
    start = " ".join(tags[key] for key in ("Date", "Time") if key in tags)
    return Channel(name, values, tags.get("Y_Unit_Label", ""), step, start, offset)


def _rounds_to(text: str, step_s: float) -> bool:
    """Whether a step as written is this one, rounded to its last decimal."""
    plain = text.strip().replace(",", ".").lower()
    mantissa, _, exponent = plain.partition("e")
    last: float = 10.0 ** min(float(exponent or 0) - len(mantissa.partition(".")[2]), 300.0)
    return abs(float(plain) - step_s) <= 0.51 * last


def _joined(file: Path, made: list[list[Channel]], n_segments: int) -> list[Channel]:
    """Segments that follow each other without a gap as one record."""
    joined = list(made[0])
    for number, segment in enumerate(made[1:], start=2):
        why = "" if [c.name for c in segment] == [c.name for c in joined] else "it has other channels"
        for before, after in zip(joined, segment, strict=False):
            step = before.step_s or 0.0
            if not step or after.step_s is None or abs(after.step_s - step) > 1e-9 * step:
                why = why or "it has another rate"
                continue
            gap = _begun(after, before) - step * before.values.size
            if abs(gap) > 0.1 * step:
                why = why or f"it begins {gap:+.4g} s after the end of the one before"
        if why:
            found = f"whose segment {number} of {n_segments} does not follow the one before: {why}"
            unsuitable(file, found, "one record without gaps", choose_run(n_segments))
        pairs = zip(joined, segment, strict=True)
        joined = [replace(a, values=np.concatenate([a.values, b.values])) for a, b in pairs]
    return joined


def _begun(after: Channel, before: Channel) -> float:
    """Seconds from the first sample of one to that of the other."""
    apart = after.offset_s - before.offset_s
    if apart == 0.0 and after.start and before.start:  # every segment counts from its own start
        with suppress(ValueError):
            end, start = (datetime.fromisoformat(c.start.replace("/", "-")) for c in (after, before))
            return (end - start).total_seconds()
    return apart
