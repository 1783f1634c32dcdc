"""LabVIEW Measurement Files (.lvm), text of National Instruments."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from datetime import datetime
from itertools import count
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..signals.recording import Recording
from ..support.messages import Passed, Wording, warn
from .channels import Channel, stated_recording
from .common import missing_part, rate_of, unsuitable
from .reading import PathLike, Rated, opened, reader
from .text_table import decoded

# -- The text of a LabVIEW Measurement File (.lvm): a header, and segments with a header each or for all
#
# The format is documented by National Instruments, "Specification for the LabVIEW Measurement File".
# Columns lie between separators; with ``X_Columns`` No the first is empty, with One it is the abscissa of
# all channels, with Multi every channel has its own before it. The last one is a comment.


WANTED = "a whole LabVIEW Measurement File (.lvm)"
_END, _START_SPECIAL, _END_SPECIAL = "***End_of_Header***", "***Start_Special***", "***End_Special***"


@dataclass
class Segment:
    """What one call of LabVIEW wrote: tags of its header; all else by channel."""

    tags: dict[str, list[str]] = field(default_factory=dict)
    names: list[str] = field(default_factory=list)
    x: list[NDArray[Any] | None] = field(default_factory=list)
    values: list[NDArray[Any]] = field(default_factory=list)
    stated: list[int] = field(default_factory=list)


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


def segments_of(file: Path) -> list[Segment]:
    """The segments of a file, in order."""
    text = decoded(file)
    lines = text.split("\n")
    if not lines[0].startswith("LabVIEW Measurement") or "\x00" in text:
        remedy = "A file without header is a table of text: read it by read_csv, format csv."
        unsuitable(file, "which does not begin with the line 'LabVIEW Measurement'", WANTED, remedy)
    end = _find(lines, _END, 0)
    if end is None:
        unsuitable(file, "whose header has no end", WANTED, "It was cut: copy it again.")
    found = _blocks(file, lines, end + 1, _Form(lines[1:end]))
    if not found:
        unsuitable(file, "with a header and no numbers", WANTED, "It was cut: copy it again.")
    return found


def _find(lines: list[str], mark: str, start: int) -> int | None:
    return next((i for i in range(start, len(lines)) if lines[i].startswith(mark)), None)


def _blocks(file: Path, lines: list[str], start: int, form: _Form) -> list[Segment]:
    """Segments: header lines up to their end mark, a line of titles, rows of numbers."""
    found: list[Segment] = []
    tags: dict[str, list[str]] = {}
    titles: list[str] = []
    rows: list[tuple[int, str]] = []
    special = headed = False
    i = start
    while i < len(lines):
        line = lines[i]
        head = line.startswith("Channels" + form.separator)
        if line.startswith(_START_SPECIAL) or special:
            special = not line.startswith(_END_SPECIAL)
        elif head or not line.strip(form.separator + " "):  # a blank line ends a packet
            if rows:
                found.append(_segment(file, tags, titles, rows, form))
                rows = []
            if head:
                end = _find(lines, _END, i)
                if end is None:
                    unsuitable(
                        file, f"whose segment header in line {i + 1} has no end", WANTED, "It was cut."
                    )
                tags = {name: values for name, *values in map(form.fields, lines[i:end])}
                titles, headed, i = [], True, end
        elif headed and not titles and not form.is_row(line):
            titles = form.fields(line)
        else:
            rows.append((i + 1, line))
        i += 1
    return [*found, _segment(file, tags, titles, rows, form)] if rows else found


def _segment(
    file: Path, tags: dict[str, list[str]], titles: list[str], rows: list[tuple[int, str]], form: _Form
) -> Segment:
    def bad(number: int, what: str) -> None:
        unsuitable(file, f"whose line {number} has {what}", "rows of numbers", "Correct or remove that line.")

    stated = [int(n) for n in tags.get("Samples", []) if n.isdecimal()]
    n_channels = _count(tags, titles, rows, form)
    per = 2 if form.columns == "multi" else 1
    places = [per * i + 1 for i in range(n_channels)]
    table: list[list[float]] = [[] for _ in places]
    over: list[list[float]] = [[] for _ in places]
    ended = [False] * n_channels
    for number, line in rows:
        parts = form.fields(line)
        parts += [""] * (places[-1] + 1 - len(parts))
        for c, place in enumerate(places):
            if not parts[place]:  # a channel that is shorter than others
                ended[c] = True
                continue
            if ended[c]:
                bad(number, f"a value of channel {c + 1} after an empty one")
            if c < len(stated) and len(table[c]) >= stated[c]:
                bad(number, f"a value more than the {stated[c]} of its channel {c + 1}")
            try:
                table[c].append(form.number(parts[place]))
                if form.columns != "no":
                    over[c].append(form.number(parts[place - 1 if per == 2 else 0]))
            except ValueError:
                bad(number, f"{line.strip()[:50]!r}")
    names = [titles[p] if p < len(titles) and titles[p] else f"channel {i + 1}" for i, p in enumerate(places)]
    x = [np.array(each) if form.columns != "no" else None for each in over]
    return Segment(tags, names, x, [np.array(values) for values in table], stated)


def _count(tags: dict[str, list[str]], titles: list[str], rows: list[tuple[int, str]], form: _Form) -> int:
    """How many channels: by the header, else by the titles, else by the first row."""
    stated = tags.get("Channels", [""])[0]
    if stated.isdecimal() and 0 < int(stated) <= 100_000:
        return int(stated)
    parts = titles[:-1] if titles and titles[-1] == "Comment" else titles or form.fields(rows[0][1])
    return max(len(parts) // 2 if form.columns == "multi" else len(parts) - 1, 1)


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

    Raises
    ------
    UnsuitableDataError
        A cut or damaged file, fewer samples than its header states, segments with gaps between them.

    Warns
    -----
    AntiresWarning
        Units that are unknown or missing, another rate than ``fs_hz``.

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
    segments = segments_of(file)
    if run is not None:
        if isinstance(run, bool) or not isinstance(run, int) or not 1 <= run <= len(segments):
            wanted = f"1 to {len(segments)}, the segments of {str(file)!r}"
            reject("run", run, wanted, "Number the segments from 1.")
        chosen = [segments[run - 1]]
    else:
        chosen = segments
    for segment in chosen:
        _whole(file, segment, partial)
    made = [_channels(file, segment, given.fs_hz) for segment in chosen]
    return stated_recording(file, _joined(file, made, len(segments)), given)


def _whole(file: Path, segment: Segment, partial: bool) -> None:
    for i, (values, stated) in enumerate(zip(segment.values, segment.stated, strict=False)):
        if values.size < stated:
            found = f"{segment.names[i]!r} has {values.size} of {stated} samples"
            missing_part(file, found, WANTED, partial, int(values.size))
    if partial:  # a row that was cut leaves its last channels shorter
        shortest = min(values.size for values in segment.values)
        segment.values = [values[:shortest] for values in segment.values]
        segment.x = [None if x is None else x[:shortest] for x in segment.x]
    if min(values.size for values in segment.values) == 0:
        unsuitable(file, "with a channel without samples", WANTED, "Export it again.")
    if not all(np.isfinite(values).all() for values in segment.values):
        remedy = "Cut out the part without them."
        unsuitable(file, "with values that are not finite", "finite numbers", remedy)


def _channels(file: Path, segment: Segment, fs_hz: float | None) -> list[Channel]:
    """Channels of one segment, each with its own rate and start."""
    made = []
    for i, name, values, x in zip(count(), segment.names, segment.values, segment.x, strict=False):
        tags = {key: "".join(values[i : i + 1]) for key, values in segment.tags.items()}
        step, offset = _number(tags.get("Delta_X", "")), _number(tags.get("X0", "")) or 0.0
        if x is not None and x.size > 1 and np.isfinite(x).all() and fs_hz is None:
            rate = rate_of(file, x, digits=1e-6 if step is None else 1e-5)
            if step is not None and step > 0.0 and abs(rate * step - 1.0) > 1e-3:
                found = f"whose {name!r} has a Delta_X of {step:g} s and instants at {rate:g} Hz"
                unsuitable(file, found, "one rate", Wording("Give the true one by {}.", Passed("fs_hz")))
            step = step if step is not None and step > 0.0 else 1.0 / rate
            offset = float(x[0])
        start = " ".join(tags[key] for key in ("Date", "Time") if key in tags)
        made.append(Channel(name, values, tags.get("Y_Unit_Label", ""), step, start, offset))
    kinds = {kind.lower() for kind in segment.tags.get("X_Dimension", [])} - {"", "time"}
    if kinds:
        warn(
            "not_over_time",
            f"path: {str(file)!r} lies over {', '.join(sorted(kinds))}, as its X_Dimension says; it is read "
            "as a record over time.",
        )
    return made


def _number(text: str) -> float | None:
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return None
    return value if np.isfinite(value) else None


def _joined(file: Path, made: list[list[Channel]], n_segments: int) -> list[Channel]:
    """Segments that follow each other without a gap as one record."""

    def apart(number: int, why: str) -> None:
        unsuitable(
            file,
            f"whose segment {number} of {n_segments} does not follow the one before: {why}",
            "one record without gaps",
            Wording(
                "Choose one by {} to {}, and give them together as repeats of one test.",
                Passed("run", 1),
                Passed("run", n_segments),
            ),
        )

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
        try:
            return (_instant(after.start) - _instant(before.start)).total_seconds()
        except ValueError:
            pass
    return apart


def _instant(text: str) -> datetime:
    """``2015/10/03 12:31:22.1234567`` to microseconds."""
    whole, _, part = text.replace(",", ".").partition(".")
    return datetime.strptime(f"{whole}.{(part + '000000')[:6]}", "%Y/%m/%d %H:%M:%S.%f")
