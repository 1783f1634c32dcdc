"""Matrices that Nastran's OUTPUT4 writes: text or binary, dense or sparse, of single or double precision.

A matrix is a header (columns, rows, form, type, name) and a record for each column that is not empty: its
number, its first row or 0 where it is made of strings, and the count of words that follow. A string is a run
of rows: its length and first row are two words where the header's rows are negative, else packed into one as
row + 65536 (length + 1).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._common import unsuitable
from .labelled import Labelled

__all__ = ["read_op4"]

_WANTED = "a whole file of OUTPUT4, of real matrices"
_CUT = "Export it again; complex matrices have no place in an undamped model."
_HEADER = re.compile(r"^([ \d-]{8})([ \d-]{8})([ \d-]{8})([ \d-]{8})(.{8})(.*)$")
_WIDTH = re.compile(r"[EDG](\d+)\.\d+")
_PACKED = 65536

#: Column, first row, values.
Run = tuple[int, int, NDArray[np.float64]]


def read_op4(file: Path) -> dict[str, Labelled]:
    """All matrices of a file, by name."""
    content = file.read_bytes()
    binary = content[:4] in (b"\x18\0\0\0", b"\0\0\0\x18")
    found: dict[str, Labelled] = {}
    try:
        matrices = _binary(content) if binary else _text(content.decode("ascii").splitlines())
        for name, n_rows, n_columns, runs in matrices:
            found[name] = Labelled(_matrix(runs, n_rows, n_columns))
    except (ValueError, IndexError, StopIteration, UnicodeDecodeError, RuntimeError) as exc:
        unsuitable(file, f"which is cut, damaged or of another kind ({exc})", _WANTED, _CUT)
    if not found:
        unsuitable(file, "without a matrix", _WANTED, _CUT)
    return found


def _matrix(runs: list[Run], n_rows: int, n_columns: int) -> object:
    from scipy.sparse import coo_array

    rows = [np.arange(first, first + values.size) for _, first, values in runs]
    columns = [np.full(values.size, column) for column, _, values in runs]
    if not runs:
        return coo_array((n_rows, n_columns))
    values = np.concatenate([values for _, _, values in runs])
    return coo_array((values, (np.concatenate(rows), np.concatenate(columns))), shape=(n_rows, n_columns))


def _checked(kind: int) -> None:
    if kind not in (1, 2):
        raise ValueError(f"matrix of type {kind}; 1 and 2 are real")


def _text(lines: list[str]) -> Iterator[tuple[str, int, int, list[Run]]]:
    """Lines of whole numbers are headers; all others are values of the form that the header states."""
    at = 0
    while at < len(lines):
        head = _HEADER.match(lines[at])
        if head is None:
            raise ValueError(f"line {at + 1} is no header")
        n_columns, n_rows, _, kind = (int(head[i]) for i in range(1, 5))
        _checked(kind)
        stated = _WIDTH.search(head[6])
        width = int(stated[1]) if stated else 16
        runs: list[Run] = []
        column, first, at = 0, 0, at + 1
        while True:
            words = lines[at].split()
            if len(words) == 3 and _whole(words):
                column, first = int(words[0]), int(words[1])
                if column > n_columns:
                    at += 2  # the record that ends the matrix has one value
                    break
                at += 1
                if first == 0:
                    continue
                start = first
            elif _whole(words) and len(words) == 2:
                start, at = int(words[1]), at + 1
            elif _whole(words) and len(words) == 1:
                start, at = int(words[0]) % _PACKED, at + 1
            else:
                raise ValueError(f"line {at + 1} is neither a header nor expected")
            values: list[float] = []
            while at < len(lines) and not _whole(lines[at].split()):
                line = lines[at].rstrip()
                values += [_number(line[i : i + width]) for i in range(0, len(line), width)]
                at += 1
            if not values:
                raise ValueError(f"no values above line {at + 1}")
            runs.append((column - 1, start - 1, np.array(values)))
        yield head[5].strip(), abs(n_rows), n_columns, runs


def _whole(words: list[str]) -> bool:
    return bool(words) and all(word.lstrip("-").isdigit() for word in words)


def _number(text: str) -> float:
    return float(text.replace("D", "E").replace("d", "e"))


def _binary(content: bytes) -> Iterator[tuple[str, int, int, list[Run]]]:
    order = "<" if content[0] else ">"
    records = _records(content, order)
    for record in records:
        if len(record) != 24:
            raise ValueError("no header of 24 bytes")
        n_columns, n_rows, _, kind = (int(i) for i in np.frombuffer(record[:16], f"{order}i4"))
        _checked(kind)
        name = record[16:].decode("ascii").strip()
        runs: list[Run] = []
        while True:
            record = next(records)
            column, first, _ = (int(i) for i in np.frombuffer(record[:12], f"{order}i4"))
            if column > n_columns:
                break
            runs += [
                (column - 1, start - 1, values.astype(np.float64))
                for start, values in _strings(record[12:], first, n_rows < 0, f"{order}f{4 * kind}")
            ]
        yield name, abs(n_rows), n_columns, runs


def _strings(data: bytes, first: int, apart: bool, kind: str) -> Iterator[tuple[int, NDArray[np.floating]]]:
    """First row and values of each run in a column."""
    size = np.dtype(kind).itemsize
    if first:
        yield first, np.frombuffer(data[: len(data) // size * size], kind)
        return
    order, at = kind[0], 0
    while at < len(data):
        word = int(np.frombuffer(data[at : at + 4], f"{order}i4")[0])
        if apart:
            words, start, at = word - 1, int(np.frombuffer(data[at + 4 : at + 8], f"{order}i4")[0]), at + 8
        else:
            words, start, at = word // _PACKED - 1, word % _PACKED, at + 4
        yield start, np.frombuffer(data[at : at + 4 * words], kind)
        at += 4 * words


def _records(content: bytes, order: str) -> Iterator[bytes]:
    """Records of a Fortran program: the length in bytes before and behind each."""
    at = 0
    while at < len(content):
        length = int(np.frombuffer(content[at : at + 4], f"{order}i4")[0])
        end = at + 4 + length
        if length < 0 or content[end : end + 4] != content[at : at + 4]:
            raise ValueError(f"the record at byte {at} does not end as it begins")
        yield content[at + 4 : end]
        at = end + 4
