"""The text of a LabVIEW Measurement File (.lvm): a header, and segments with a header each or for all.

The format is documented by National Instruments, "Specification for the LabVIEW Measurement File". Columns
lie between separators; with ``X_Columns`` No the first is empty, with One it is the abscissa of all channels,
with Multi every channel has its own before it. The last one is a comment.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._common import unsuitable

__all__ = ["WANTED", "Segment", "segments_of"]

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
