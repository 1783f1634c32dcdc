"""Where the datasets of a universal file begin and end, found without trusting any of them.

A dataset lies between two lines ``    -1``. The file does not say how many there are, nor does a reader
notice that one is short; so each dataset 58 is measured here against the number of points in its own header.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

__all__ = ["Dataset", "plain_exponents", "scan"]

#: A line of its own: ``-1`` in the first six columns and nothing else.
_MARKER = re.compile(rb"(?:\A|(?<=[\r\n])) {4}-1[ ]*(?=[\r\n]|\Z)")
_HEADER_LINES = 11
#: By ordinate type: numbers per point, width in text, bytes in binary form.
_FORMS = {2: (1, 13, 4), 4: (1, 20, 8), 5: (2, 13, 4), 6: (2, 20, 8)}


#: The exponent of a Fortran double, 1.5D+03.
_FORTRAN = re.compile(rb"(?<=[0-9.])[Dd](?=[+-]?[0-9])")


@dataclass(frozen=True)
class Dataset:
    """One dataset of a file.

    Attributes
    ----------
    number : int
        Type of the dataset, 58 for functions; 0 where it cannot be read.
    start, stop : int
        Bytes from the first marker to the end of the second.
    points : int
        Of a 58: points its header states.
    found : int
        Of a 58: points that are there, by their space in the file.
    problem : str
        What is wrong; empty for a whole one.
    """

    number: int
    start: int
    stop: int
    points: int = 0
    found: int = 0
    problem: str = ""


def scan(data: bytes) -> list[Dataset]:
    """Every dataset of a file, in order; the last may have a problem."""
    found: list[Dataset] = []
    position = 0
    while data[position:].strip(b" \r\n\t\x1a\x00"):
        begin = _MARKER.search(data, position)
        stray = data[position : begin.start() if begin else len(data)]
        if stray.strip(b" \r\n\t\x1a\x00"):
            problem = f"{len(stray)} bytes at byte {position} belong to no dataset"
            found.append(Dataset(0, position, position + len(stray), problem=problem))
        if begin is None:
            break
        dataset = _dataset(data, begin.start(), begin.end())
        found.append(dataset)
        position = dataset.stop
    if data[position:].lstrip(b"\r\n"):
        # Blanks without a line end are the beginning of a marker.
        tail = data[position:].rpartition(b"\n")[2]
        if tail.strip(b"\r\x1a\x00"):
            found.append(Dataset(0, position, len(data), problem="it is cut in its first line"))
    return found


def plain_exponents(data: bytes, dataset: Dataset) -> bytes:
    """The bytes of a dataset; in a 58 of text, Fortran's 1.5D+03 as 1.5E+03, and fields of full width."""
    part = data[dataset.start : dataset.stop]
    lines = part.splitlines(keepends=True)
    if dataset.number != 58 or len(lines) < 3 or lines[1][6:7].lower() == b"b":
        return part
    # After marker and type: five lines of text, points, the abscissa, four axes with labels, numbers.
    numbers = 2 + _HEADER_LINES
    lines = [_FORTRAN.sub(b"E", line) if i == 8 or i >= numbers else line for i, line in enumerate(lines)]
    try:
        width, even = _FORMS[int(lines[8][:10])][1], int(lines[8][20:30])
    except (ValueError, KeyError, IndexError):
        return b"".join(lines)
    body = lines[numbers:-1]
    if _to_the_left(body, width if even or width == 13 else 0):  # pyuff would lose the last of each line
        ends = [line[len(line.rstrip()) :].lstrip(b" ") for line in body]
        whole = [line.rstrip() for line in body]
        lines[numbers:-1] = [
            line.ljust(-(-len(line) // width) * width) + end for line, end in zip(whole, ends, strict=True)
        ]
    return b"".join(lines)


def _dataset(data: bytes, start: int, after: int) -> Dataset:
    at, identity = _line(data, _next_line(data, after))
    try:
        number, binary = int(identity[:6]), identity[6:7].lower() == b"b"
    except ValueError:
        number, binary = 0, False
    if number != 58:
        end = _MARKER.search(data, at)
        problem = "" if end and number else "it has no end" if number else "its type cannot be read"
        return Dataset(number, start, end.end() if end else len(data), problem=problem)
    lines: list[bytes] = []
    for _ in range(_HEADER_LINES):
        at, line = _line(data, at)
        lines.append(line)
    try:
        kind, points, even = (int(lines[6][i : i + 10]) for i in (0, 10, 20))
        form = _FORMS[kind]
    except (ValueError, KeyError):
        end = _MARKER.search(data, min(at, len(data)))
        return Dataset(58, start, end.end() if end else len(data), problem="its header is cut or damaged")
    numbers = form[0] + (0 if even else 1)
    if binary:
        return _binary(data, start, at, points, numbers, form[2])
    end = _MARKER.search(data, at)
    body = data[at : end.start() if end else len(data)]
    # Fields are 13 or 20 wide; an abscissa, where there is one, has 13.
    width = form[1] * form[0] + (0 if even else 13)
    rows = body.splitlines()
    there = sum(len(line.rstrip()) for line in rows) // width
    if there != points and _to_the_left(rows, form[1] if even or form[1] == 13 else 0):
        there = sum(len(line.split()) for line in rows) // numbers
    return _judged(start, end, len(data), points, there)


def _to_the_left(rows: Iterable[bytes], width: int) -> bool:
    """Whether numbers begin their fields, so that blanks at the end of a line belong to the last.

    A blank in the place of the sign counts as the beginning.
    """
    some = False
    for row in rows if width > 0 else ():
        for found in re.finditer(rb"\S+", row):
            if found.start() % width > 1:
                return False  # in most files on one of the first lines
            some = True
    return some


def _binary(data: bytes, start: int, at: int, points: int, numbers: int, size: int) -> Dataset:
    """The end is where the number of points says; the number of bytes beside it is often wrong."""
    # Some programs write single precision as double.
    for length in dict.fromkeys((points * numbers * size, points * numbers * 8)):
        if at + length <= len(data):
            end = re.compile(rb"[\r\n]{0,2} {4}-1[ ]*(?=[\r\n]|\Z)").match(data, at + length)
            if end:
                return Dataset(58, start, end.end(), points, points)
    marker = re.compile(rb" {4}-1[ ]*(?=[\r\n]|\Z)").search(data, at)
    there = ((marker.start() if marker else len(data)) - at) // (numbers * size)
    return _judged(start, marker, len(data), points, min(there, points), short=True)


def _judged(
    start: int, end: re.Match[bytes] | None, size: int, points: int, there: int, short: bool = False
) -> Dataset:
    problem = ""
    if end is None:
        problem = f"it has no end and {min(there, points)} of {points} points"
    elif short or there != points:
        problem = f"it has {there} points, not the {points} that its header states"
    return Dataset(58, start, end.end() if end else size, points, there, problem)


def _next_line(data: bytes, at: int) -> int:
    while data[at : at + 1] == b" ":
        at += 1
    at += data[at : at + 1] == b"\r"
    return at + (data[at : at + 1] == b"\n")


def _line(data: bytes, at: int) -> tuple[int, bytes]:
    """Where the next line begins, and this one without its end."""
    ends = [i for i in (data.find(b"\n", at), data.find(b"\r", at)) if i >= 0]
    if not ends:
        return len(data), data[at:]
    stop = min(ends)
    return stop + (2 if data[stop : stop + 2] == b"\r\n" else 1), data[at:stop]
