"""Files of recorders, whose channels state their own rate: TDMS, WAV, miniSEED and LVM."""

from __future__ import annotations

import math
from collections import Counter
from contextlib import suppress
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any, NamedTuple, Unpack

import numpy as np

from ..exceptions import reject
from ..signals.recording import Recording
from ..support.checks import real_array
from ..support.messages import warn
from ._child import Answer, Unfit, answer, asked, called, room
from .channels import Channel, stated_recording
from .child_process import Limits, channels_of_child
from .common import (
    PathLike,
    Rated,
    Selected,
    choose_run,
    missing_part,
    opened,
    rate_of,
    reader,
    require,
    unsuitable,
)
from .raw_arrays import stated_number
from .text_table import decoded

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
    columns = map(np.float64, values.T)
    names = (f"channel {i + 1}" for i in range(values.shape[1]))
    pairs = zip(names, columns, strict=True)
    return answer([{"name": name, "values": column, "step_s": 1.0 / rate} for name, column in pairs])


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
        remedy = "Cut a part without gaps out of it, with ObsPy's slice or the recorder's program."
        unsuitable(file, found, "traces without gaps", remedy)
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
        raise Unfit("the traces are " + called(trace.id for trace in stream))
    return answer(made)


# -- LVM, text of LabVIEW: a header, and segments with a header each or for all
#
# The format is documented by National Instruments, "Specification for the LabVIEW Measurement File".
# Columns lie between separators; with ``X_Columns`` No the first is empty, with One it is the abscissa of
# all channels, with Multi every channel has its own before it. The last one is a comment.

_WANTED_LVM = "a whole LabVIEW Measurement File (.lvm)"
_END, _START_SPECIAL, _END_SPECIAL = "***End_of_Header***", "***Start_Special***", "***End_Special***"


class Segment(NamedTuple):
    """What one call of LabVIEW wrote: tags of its header, titles of columns, rows with their line."""

    tags: dict[str, list[str]]
    titles: list[str]
    rows: list[tuple[int, list[str]]]


class _Form:
    """How the numbers stand, by the header of the file."""

    def __init__(self, header: list[str]) -> None:
        tags: dict[str, str] = {}
        for line in header:
            sign = next((sign for sign in ("\t", ",") if sign in line), None)
            if sign is not None:
                name, value, *_ = line.split(sign)
                tags[name.strip()] = value.strip()
        self.separator = "," if tags.get("Separator", "").lower() == "comma" else "\t"
        self.commas = tags.get("Decimal_Separator", "").startswith(",") and self.separator != ","
        self.columns = tags.get("X_Columns", "One").lower()

    def fields(self, line: str) -> list[str]:
        return [part.strip() for part in line.split(self.separator)]

    def number(self, text: str) -> float:
        return float(text.replace(",", ".") if self.commas else text)

    def is_row(self, line: str) -> bool:
        """Whether the first field that is not empty is a number."""
        try:
            self.number(next((part for part in self.fields(line) if part), ""))
        except ValueError:
            return False
        return True


def _segments(file: Path) -> tuple[_Form, list[Segment]]:
    """How the numbers of a file stand, and its segments in order."""
    text = decoded(file)
    lines = text.split("\n")
    if not lines[0].startswith("LabVIEW Measurement") or "\x00" in text:
        remedy = "A file without header is a table of text: read it by read_csv, format csv."
        unsuitable(file, "which does not begin with the line 'LabVIEW Measurement'", _WANTED_LVM, remedy)
    ends = [i for i, line in enumerate(lines) if line.startswith(_END)]
    if not ends:
        unsuitable(file, "whose header has no end", _WANTED_LVM, "It was cut: copy it again.")
    form = _Form(lines[1 : ends[0]])
    found = _blocks(file, lines, ends, form)
    if not found:
        unsuitable(file, "with a header and no numbers", _WANTED_LVM, "It was cut: copy it again.")
    return form, found


def _blocks(file: Path, lines: list[str], ends: list[int], form: _Form) -> list[Segment]:
    """Segments: header lines up to their end mark, a line of titles, rows of numbers."""
    found: list[Segment] = []
    now = Segment({}, [], [])
    special = headed = False
    i = ends[0] + 1
    while i < len(lines):
        line = lines[i]
        head = line.startswith("Channels" + form.separator)
        if line.startswith(_START_SPECIAL) or special:
            special = not line.startswith(_END_SPECIAL)
        elif head or not line.strip(form.separator + " "):  # a blank line ends a packet
            found += [now] if now.rows else []
            now = now._replace(rows=[])
            if head:
                end = next((at for at in ends if at > i), None)
                if end is None:
                    got = f"whose segment header in line {i + 1} has no end"
                    unsuitable(file, got, _WANTED_LVM, "It was cut.")
                tags = {name: values for name, *values in map(form.fields, lines[i:end])}
                now, headed, i = Segment(tags, [], []), True, end
        elif headed and not now.titles and not form.is_row(line):
            now = now._replace(titles=form.fields(line))
        else:
            now.rows.append((i + 1, form.fields(line)))
        i += 1
    return [*found, now] if now.rows else found


def _count(segment: Segment, form: _Form) -> int:
    """How many channels: by the header, else by the titles, else by the first row."""
    stated = segment.tags.get("Channels", [""])[0]
    if stated.isdecimal() and 0 < int(stated) <= 100_000:
        return int(stated)
    parts = segment.titles or segment.rows[0][1]
    parts = parts[:-1] if segment.titles and parts[-1] == "Comment" else parts
    return max(len(parts) // 2 if form.columns == "multi" else len(parts) - 1, 1)


def _column(file: Path, form: _Form, segment: Segment, c: int, most: float) -> tuple[Any, Any]:
    """Abscissae, if there are any, and values of a channel, which may be shorter than others."""
    place, before = (2 * c + 1, 2 * c) if form.columns == "multi" else (c + 1, 0)
    x: list[float] = []
    values: list[float] = []
    ended = False
    for number, parts in segment.rows:
        if place >= len(parts) or not parts[place]:
            ended = True
            continue
        wrong = f"a value of channel {c + 1} after an empty one" if ended else ""
        if len(values) >= most:
            wrong = f"a value more than the {most} of its channel {c + 1}"
        try:
            values.append(form.number(parts[place]))
            x += [] if form.columns == "no" else [form.number(parts[before])]
        except ValueError:
            wrong = wrong or f"{form.separator.join(parts).strip()[:50]!r}"
        if wrong:
            wanted, remedy = "rows of numbers", "Correct or remove that line."
            unsuitable(file, f"whose line {number} has {wrong}", wanted, remedy)
    return None if form.columns == "no" else np.array(x), np.array(values)


@reader
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
    >>> lines = ["LabVIEW Measurement", "Separator\\tTab", "X_Columns\\tNo", "***End_of_Header***", "",
    ...          "Channels\\t1", "Samples\\t3", "Y_Unit_Label\\tg", "Delta_X\\t0.01", "***End_of_Header***",
    ...          "X_Value\\ttip\\tComment", "\\t1.0\\ta knock", "\\t2.0", "\\t4.0", ""]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "a.lvm")
    ...     _ = file.write_text("\\n".join(lines))
    ...     ar.read_lvm(file)
    Recording(1 channels, 0.03 s at 100 Hz, dofs=('tip',), no force)
    """
    file, given = opened(read_lvm, path, options)
    form, segments = _segments(file)
    if run is not None and not (type(run) is int and 1 <= run <= len(segments)):
        wanted = f"1 to {len(segments)}, the segments of {str(file)!r}"
        reject("run", run, wanted, "Number the segments from 1.")
    chosen = segments if run is None else [segments[run - 1]]
    made = [_channels(file, form, segment, partial, given.fs_hz) for segment in chosen]
    return stated_recording(file, _joined(file, made, len(segments)), given)


def _channels(file: Path, form: _Form, segment: Segment, partial: bool, fs_hz: float | None) -> list[Channel]:
    """Channels of one segment, each with its own rate and start."""
    titles, stated = segment.titles, [int(n) for n in segment.tags.get("Samples", []) if n.isdecimal()]
    made: list[tuple[str, Any, Any]] = []
    for c in range(_count(segment, form)):
        place = 2 * c + 1 if form.columns == "multi" else c + 1
        most = stated[c] if c < len(stated) else math.inf
        name = titles[place] if place < len(titles) and titles[place] else f"channel {c + 1}"
        x, values = _column(file, form, segment, c, most)
        made.append((name, x, values))
        if values.size < most < math.inf:
            found = f"{name!r} has {values.size} of {most} samples"
            missing_part(file, found, _WANTED_LVM, partial, int(values.size))
    if partial:  # a row that was cut leaves its last channels shorter
        shortest = min(values.size for _, _, values in made)
        made = [(name, None if x is None else x[:shortest], values[:shortest]) for name, x, values in made]
    if min(values.size for _, _, values in made) == 0:
        unsuitable(file, "with a channel without samples", _WANTED_LVM, "Export it again.")
    if not all(np.isfinite(values).all() for _, _, values in made):
        remedy = "Cut out the part without them."
        unsuitable(file, "with values that are not finite", "finite numbers", remedy)
    kinds = {kind.lower() for kind in segment.tags.get("X_Dimension", [])} - {"", "time"}
    if kinds:
        over = f"lies over {', '.join(sorted(kinds))}, as its X_Dimension says"
        warn("not_over_time", f"path: {str(file)!r} {over}; it is read as a record over time.")
    tags = [{key: "".join(of[c : c + 1]) for key, of in segment.tags.items()} for c in range(len(made))]
    return [_channel(file, *each, own, fs_hz) for each, own in zip(made, tags, strict=True)]


def _channel(
    file: Path, name: str, x: Any, values: Any, tags: dict[str, str], fs_hz: float | None
) -> Channel:
    """A channel with what its tags or its abscissae say of rate and start."""
    step, offset = stated_number(tags.get("Delta_X", "")), stated_number(tags.get("X0", "")) or 0.0
    if x is not None and x.size > 1 and np.isfinite(x).all() and fs_hz is None:
        rate = rate_of(file, x, digits=1e-6 if step is None else 1e-5)
        if step is not None and step > 0.0 and abs(rate * step - 1.0) > 1e-3:
            found = f"whose {name!r} has a Delta_X of {step:g} s and instants at {rate:g} Hz"
            unsuitable(file, found, "one rate", "Give the true one by fs_hz=.")
        step = step if step is not None and step > 0.0 else 1.0 / rate
        offset = float(x[0])
    start = " ".join(tags[key] for key in ("Date", "Time") if key in tags)
    return Channel(name, values, tags.get("Y_Unit_Label", ""), step, start, offset)


def _joined(file: Path, made: list[list[Channel]], n_segments: int) -> list[Channel]:
    """Segments that follow each other without a gap as one record."""

    def apart(number: int, why: str) -> None:
        found = f"whose segment {number} of {n_segments} does not follow the one before: {why}"
        unsuitable(file, found, "one record without gaps", choose_run(n_segments))

    joined = list(made[0])
    for number, segment in enumerate(made[1:], start=2):
        if [c.name for c in segment] != [c.name for c in joined]:
            apart(number, "it has other channels")
        for i, (before, after) in enumerate(zip(joined, segment, strict=True)):
            step = before.step_s or 0.0
            gap = _begun(after, before) - step * before.values.size
            if not step or after.step_s is None or abs(after.step_s - step) > 1e-9 * step:
                apart(number, "it has another rate")
            if abs(gap) > 0.1 * step:
                apart(number, f"it begins {gap:+.4g} s after the end of the one before")
            joined[i] = replace(before, values=np.concatenate([before.values, after.values]))
    return joined


def _begun(after: Channel, before: Channel) -> float:
    """Seconds from the first sample of one to that of the other."""
    apart = after.offset_s - before.offset_s
    if apart == 0.0 and after.start and before.start:  # every segment counts from its own start
        with suppress(ValueError):
            return (_instant(after.start) - _instant(before.start)).total_seconds()
    return apart


def _instant(text: str) -> datetime:
    """``2015/10/03 12:31:22.1234567`` to microseconds."""
    whole, _, part = text.replace(",", ".").partition(".")
    return datetime.strptime(f"{whole}.{(part + '000000')[:6]}", "%Y/%m/%d %H:%M:%S.%f")
