"""LabVIEW Measurement Files (.lvm), text of National Instruments."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..signals.recording import Recording
from ..support.messages import Passed, Wording, warn
from .channels import Dofs
from .common import existing_file, missing_part, rate_of, unsuitable
from .stated_channels import Stated, stated_recording

# -- The text of a LabVIEW Measurement File (.lvm): a header, and segments with a header each or for all
#
# The format is documented by National Instruments, "Specification for the LabVIEW Measurement File".
# Columns lie between separators; with ``X_Columns`` No the first is empty, with One it is the abscissa of
# all channels, with Multi every channel has its own before it. The last one is a comment.


WANTED = "a whole LabVIEW Measurement File (.lvm)"
_END, _START_SPECIAL, _END_SPECIAL = "***End_of_Header***", "***Start_Special***", "***End_Special***"
_SEPARATORS = {"tab": "\t", "comma": ","}


@dataclass
class Segment:
    """What one call of LabVIEW wrote.

    Attributes
    ----------
    tags : dict of str to list of str
        Of its header: one value for each channel.
    names : list of str
        Of the channels.
    x : list of (n,) or None
        Abscissa of each channel; None without one.
    values : list of (n,)
    stated : list of int
        Samples of each channel, by the header; empty where it is silent.
    """

    tags: dict[str, list[str]] = field(default_factory=dict)
    names: list[str] = field(default_factory=list)
    x: list[NDArray[Any] | None] = field(default_factory=list)
    values: list[NDArray[Any]] = field(default_factory=list)
    stated: list[int] = field(default_factory=list)


@dataclass
class _Form:
    """How the numbers stand, by the header of the file."""

    separator: str
    decimal: str
    columns: str

    def fields(self, line: str) -> list[str]:
        return [part.strip() for part in line.split(self.separator)]

    def number(self, text: str) -> float:
        return float(text.replace(",", ".") if self.decimal == "," else text)


def segments_of(file: Path) -> list[Segment]:
    """The segments of a file, in order."""
    raw = file.read_bytes()
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    lines = text.split("\n")
    lines = [line.rstrip("\r") for line in lines]
    if not lines[0].startswith("LabVIEW Measurement") or "\x00" in text:
        unsuitable(
            file,
            "which does not begin with the line 'LabVIEW Measurement'",
            WANTED,
            "A file without header is a table of text: read it by read_csv, format csv.",
        )
    end = _find(lines, _END, 0)
    if end is None:
        unsuitable(file, "whose header has no end", WANTED, "It was cut: copy it again.")
    form = _form(lines[1:end])
    blocks = _blocks(file, lines[end + 1 :], form, offset=end + 2)
    if not blocks:
        unsuitable(file, "with a header and no numbers", WANTED, "It was cut: copy it again.")
    return blocks


def _find(lines: list[str], mark: str, start: int) -> int | None:
    return next((i for i in range(start, len(lines)) if lines[i].startswith(mark)), None)


def _form(header: list[str]) -> _Form:
    tags: dict[str, str] = {}
    for line in header:
        for sign in ("\t", ","):
            name, found, value = line.partition(sign)
            if found:
                tags[name.strip()] = value.split(sign)[0].strip()
                break
    separator = _SEPARATORS.get(tags.get("Separator", "Tab").lower(), "\t")
    decimal = "," if tags.get("Decimal_Separator", ".").startswith(",") else "."
    return _Form(separator, "." if separator == "," else decimal, tags.get("X_Columns", "One").lower())


def _blocks(file: Path, lines: list[str], form: _Form, offset: int) -> list[Segment]:
    """Segments: header lines up to their end mark, a line of titles, rows of numbers."""
    found: list[Segment] = []
    tags: dict[str, list[str]] = {}
    titles: list[str] = []
    rows: list[tuple[int, str]] = []
    special = False

    def close() -> None:
        if rows:
            found.append(_segment(file, tags, titles, rows, form))
            rows.clear()

    headed, i = False, 0
    while i < len(lines):
        line = lines[i]
        if line.startswith(_START_SPECIAL) or special:
            special = not line.startswith(_END_SPECIAL)
        elif line.startswith("Channels" + form.separator):
            close()
            end = _find(lines, _END, i)
            if end is None:
                unsuitable(
                    file, f"whose segment header in line {offset + i} has no end", WANTED, "It was cut."
                )
            tags = {}
            for each in lines[i:end]:
                name, *values = form.fields(each)
                tags[name] = values
            i, headed = end, True
            titles = []
        elif not line.strip(form.separator + " "):
            close()  # a blank line ends a packet
        elif headed and not titles and not _is_row(line, form):
            titles = form.fields(line)
        else:
            rows.append((offset + i, line))
        i += 1
    close()
    return found


def _is_row(line: str, form: _Form) -> bool:
    """Whether the first field that is not empty is a number."""
    first = next((part for part in form.fields(line) if part), "")
    try:
        form.number(first)
    except ValueError:
        return False
    return True


def _segment(
    file: Path, tags: dict[str, list[str]], titles: list[str], rows: list[tuple[int, str]], form: _Form
) -> Segment:
    stated = [int(n) for n in tags.get("Samples", []) if n.isdecimal()]
    count = _count(tags, titles, rows, form)
    per = 2 if form.columns == "multi" else 1
    places = [per * i + 1 for i in range(count)]
    abscissae = [per * i if per == 2 else 0 for i in range(count)]
    width = places[-1] + 1
    table: list[list[float]] = [[] for _ in range(count)]
    over: list[list[float]] = [[] for _ in range(count)]
    ended = [False] * count
    for number, line in rows:
        parts = form.fields(line)
        if len(parts) < width:
            parts += [""] * (width - len(parts))
        for c in range(count):
            text = parts[places[c]]
            if not text:  # a channel that is shorter than others
                ended[c] = True
                continue
            if ended[c]:
                _bad(file, number, f"a value of channel {c + 1} after an empty one")
            if stated and c < len(stated) and len(table[c]) >= stated[c]:
                _bad(file, number, f"a value more than the {stated[c]} of its channel {c + 1}")
            try:
                table[c].append(form.number(text))
                if form.columns != "no":
                    over[c].append(form.number(parts[abscissae[c]]))
            except ValueError:
                _bad(file, number, f"{line.strip()[:50]!r}")
    names = [titles[p] if p < len(titles) and titles[p] else f"channel {i + 1}" for i, p in enumerate(places)]
    return Segment(
        dict(tags),
        names,
        [np.array(x) if form.columns != "no" else None for x in over],
        [np.array(values) for values in table],
        stated,
    )


def _count(tags: dict[str, list[str]], titles: list[str], rows: list[tuple[int, str]], form: _Form) -> int:
    """How many channels: by the header, else by the titles, else by the first row."""
    told = tags.get("Channels", [""])[0]
    if told.isdecimal() and 0 < int(told) <= 100_000:
        return int(told)
    parts = titles[:-1] if titles and titles[-1] == "Comment" else titles or form.fields(rows[0][1])
    return max(len(parts) // 2 if form.columns == "multi" else len(parts) - 1, 1)


def _bad(file: Path, number: int, what: str) -> None:
    unsuitable(file, f"whose line {number} has {what}", "rows of numbers", "Correct or remove that line.")


def read_lvm(
    path: str | os.PathLike[str],
    *,
    run: int | None = None,
    responses: Any = None,
    fs_hz: float | None = None,
    dofs: Dofs = None,
    force: Any = "auto",
    unit: str | None = None,
    partial: bool = False,
) -> Recording:
    """Read a LabVIEW Measurement File, of which a segment is what one call of LabVIEW wrote.

    Parameters
    ----------
    path : path-like
        Separator, decimal sign and abscissae (``X_Columns`` No, One or Multi) as its header says; the column
        of comments is left out.
    run : int, optional
        Which segment to read, from 1. By default all, which then have to follow each other without a gap.
        Segments that are impacts or runs are read one by one and given together:
        ``identify_antiresonances([run 1, run 2], ...)``.
    responses : str or sequence of str, optional
        Names of the response channels, ``*`` for any text; all by default.
    fs_hz : float, optional
        Sampling rate, where the file states none.
    dofs : sequence, mapping or callable, optional
        Dof of each response: in order, by name, or a function of the name; None leaves one out. Default: the
        names.
    force : str or None
        Name of the force; "auto" takes the one in N or called force, None leaves it out.
    unit : str, optional
        Unit of the responses, in place of the file's ``Y_Unit_Label``.
    partial : bool
        Read a file that was cut as far as it goes, with a warning that counts what is missing.

    Returns
    -------
    Recording
        In SI.

    Raises
    ------
    UnsuitableDataError
        A cut or damaged file, fewer samples than its header states, segments with gaps between them.
    InvalidInputError
        Options that do not fit the file.
    FileNotFoundError
        There is none.

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
    file = existing_file(path)
    segments = segments_of(file)
    if run is not None and (
        isinstance(run, bool) or not isinstance(run, int) or not 1 <= run <= len(segments)
    ):
        reject(
            "run", run, f"1 to {len(segments)}, the segments of {str(file)!r}", "Number the segments from 1."
        )
    chosen = segments if run is None else [segments[run - 1]]
    for segment in chosen:
        _whole(file, segment, partial)
    made = [_channels(file, segment, fs_hz) for segment in chosen]
    channels = made[0] if len(made) == 1 else _joined(file, made, len(segments))
    return stated_recording(
        file, channels, responses=responses, fs_hz=fs_hz, dofs=dofs, force=force, unit=unit
    )


def _whole(file: Path, segment: Segment, partial: bool) -> None:
    for i, (values, stated) in enumerate(zip(segment.values, segment.stated, strict=False)):
        if values.size < stated:
            missing_part(
                file,
                f"{segment.names[i]!r} has {values.size} of {stated} samples",
                WANTED,
                partial,
                int(values.size),
            )
    if partial:  # a row that was cut leaves its last channels shorter
        shortest = min(values.size for values in segment.values)
        segment.values = [values[:shortest] for values in segment.values]
        segment.x = [None if x is None else x[:shortest] for x in segment.x]
    if min(values.size for values in segment.values) == 0:
        unsuitable(file, "with a channel without samples", WANTED, "Export it again.")
    if not all(np.isfinite(values).all() for values in segment.values):
        unsuitable(
            file, "with values that are not finite", "finite numbers", "Cut out the part without them."
        )


def _channels(file: Path, segment: Segment, fs_hz: float | None) -> list[Stated]:
    """Channels of one segment, each with its own rate and start."""
    made = []
    for i, (name, values, x) in enumerate(zip(segment.names, segment.values, segment.x, strict=True)):
        tags = {key: values[i : i + 1] for key, values in segment.tags.items()}
        step, offset = _number(tags.get("Delta_X", [])), _number(tags.get("X0", [])) or 0.0
        if x is not None and x.size > 1 and np.isfinite(x).all() and fs_hz is None:
            rate = rate_of(file, x, digits=1e-6 if step is None else 1e-5)
            if step is not None and step > 0.0 and abs(rate * step - 1.0) > 1e-3:
                unsuitable(
                    file,
                    f"whose {name!r} has a Delta_X of {step:g} s and instants at {rate:g} Hz",
                    "one rate",
                    Wording("Give the true one by {}.", Passed("fs_hz")),
                )
            step = step if step is not None and step > 0.0 else 1.0 / rate
            offset = float(x[0])
        start = " ".join([*tags.get("Date", []), *tags.get("Time", [])])
        made.append(Stated(name, values, "".join(tags.get("Y_Unit_Label", [])), step, start, offset))
    kinds = {kind.lower() for kind in segment.tags.get("X_Dimension", [])} - {"", "time"}
    if kinds:
        warn(
            "not_over_time",
            f"path: {str(file)!r} lies over {', '.join(sorted(kinds))}, as its X_Dimension says; it is read "
            "as a record over time.",
        )
    return made


def _number(texts: list[str]) -> float | None:
    try:
        value = float(texts[0].replace(",", "."))
    except (IndexError, ValueError):
        return None
    return value if np.isfinite(value) else None


def _joined(file: Path, made: list[list[Stated]], count: int) -> list[Stated]:
    """Segments that follow each other without a gap as one record."""
    joined = list(made[0])
    for number, segment in enumerate(made[1:], start=2):
        if [c.name for c in segment] != [c.name for c in joined]:
            _apart(file, number, count, "it has other channels")
        for i, (before, after) in enumerate(zip(joined, segment, strict=True)):
            step = before.step_s or 0.0
            gap = _begun(after, before) - step * before.values.size
            if not step or after.step_s is None or abs(after.step_s - step) > 1e-9 * step:
                _apart(file, number, count, "it has another rate")
            if abs(gap) > 0.1 * step:
                _apart(file, number, count, f"it begins {gap:+.4g} s after the end of the one before")
            joined[i] = Stated(
                before.name,
                np.concatenate([before.values, after.values]),
                before.unit,
                step,
                before.start,
                before.offset_s,
            )
    return joined


def _begun(after: Stated, before: Stated) -> float:
    """Seconds from the first sample of one to that of the other."""
    apart = after.offset_s - before.offset_s
    if apart == 0.0 and after.start and before.start:  # every segment counts from its own start
        try:
            begun = [_instant(each.start) for each in (before, after)]
        except ValueError:
            return apart
        return (begun[1] - begun[0]).total_seconds()
    return apart


def _instant(text: str) -> datetime:
    """``2015/10/03 12:31:22.1234567`` to microseconds."""
    whole, _, part = text.replace(",", ".").partition(".")
    return datetime.strptime(f"{whole}.{(part + '000000')[:6]}", "%Y/%m/%d %H:%M:%S.%f")


def _apart(file: Path, number: int, count: int, why: str) -> None:
    unsuitable(
        file,
        f"whose segment {number} of {count} does not follow the one before: {why}",
        "one record without gaps",
        Wording(
            "Choose one by {} to {}, and give them together as repeats of one test.",
            Passed("run", 1),
            Passed("run", count),
        ),
    )
