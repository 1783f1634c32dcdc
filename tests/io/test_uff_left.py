"""Universal files whose numbers stand at the left of their fields, with or without blanks behind the last."""

import re

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.exceptions import UnsuitableDataError
from antires_rs.io.uff import _to_the_left

pytest.importorskip("pyuff")
RECORD = ar.Recording(np.random.default_rng(3).standard_normal((1, 22)), 512.0, dofs=["12+Z"])


def moved_left(data, width):
    """The numbers of a file at the left of their fields, blanks behind the last cut off."""
    rows = []
    for row in data.split(b"\n"):
        numbers = row.split()
        whole = len(numbers) > 1 and all(re.fullmatch(rb"[-+]?\d\.\d+e[-+]\d+", n.lower()) for n in numbers)
        fields = len(row.rstrip()) == width * len(numbers)
        rows.append(b"".join(n.ljust(width) for n in numbers).rstrip() if whole and fields else row)
    return b"\n".join(rows)


def test_fields_to_the_left(tmp_path):
    file = ar.write_uff(tmp_path / "a.uff", RECORD, binary=False)
    plain = ar.read_uff(file).responses
    whole = file.read_bytes().replace(b"antires_rs crc32", b"another program ")
    moved = next(m for width in (13, 20) if (m := moved_left(whole, width)) != whole)
    file.write_bytes(moved)
    assert np.array_equal(ar.read_uff(file).responses, plain)
    # A number that is lost is missed all the same.
    row = next(r for r in reversed(moved.split(b"\n")) if len(r.split()) > 1 and b"e" in r.lower())
    file.write_bytes(moved.replace(row, row[: row.rindex(b" ")].rstrip()))
    with pytest.raises(UnsuitableDataError, match="points, not the 22"):
        ar.read_uff(file)


def test_fields_to_the_right_are_told_by_their_first_lines():
    """Looking at all lines of a long file took a third of its reading."""
    rows = iter([b"   1.00000e+00  -1.00000e+00"] * 1000)
    assert not _to_the_left(rows, 14)
    assert len(list(rows)) > 900
