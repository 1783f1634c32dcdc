"""Checksums of the datasets 58 that we write, in their ID line 3, which other programs do not interpret.

One is of the numbers, one of the header. Who edits the header, or writes the set anew with our ID lines in
it, is believed: the checksum of the numbers counts only below a header that is as we wrote it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from zlib import crc32

from .uff_scan import Dataset

__all__ = ["checked", "checksum_line"]

_LINE = re.compile(rb"antires_rs crc32 ([0-9a-f]{8}) ([0-9a-f]{8}) *\Z")
#: Lines before the numbers: marker, type, and the header, whose third is that of the checksums.
_LINES, _AT, _WIDTH = 13, 4, 80
_MARKER = b"    -1"


def checksum_line(lines: Sequence[str], numbers: bytes) -> str:
    """ID line 3 of a set of these lines, marker first and anything in its own place, and these numbers."""
    return f"antires_rs crc32 {_of_header([line.ljust(_WIDTH).encode() for line in lines])} {_hex(numbers)}"


def checked(data: bytes, dataset: Dataset) -> Dataset:
    """The dataset, with a problem if it is ours and its numbers are not those that were written."""
    if dataset.number != 58 or dataset.problem:
        return dataset
    parts = data[dataset.start : dataset.stop].split(b"\n", _LINES)
    stated = _LINE.match(parts[_AT]) if len(parts) > _LINES else None
    if stated is None or _of_header(parts[:_LINES]) != stated[1].decode():
        return dataset
    numbers = parts[_LINES]
    if _hex(numbers[: numbers.rindex(_MARKER)]) == stated[2].decode():
        return dataset
    return replace(dataset, problem="its numbers do not have the checksum in its ID line 3")


def _of_header(lines: Sequence[bytes]) -> str:
    return _hex(b"\n".join(line for i, line in enumerate(lines) if i != _AT))


def _hex(data: bytes) -> str:
    return f"{crc32(data):08x}"
