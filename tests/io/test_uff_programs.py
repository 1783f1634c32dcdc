"""Universal files as measurement programs write them: what pyuff's own files show, with numbers of ours."""

import re

import numpy as np
import pytest

import antires_rs as ar

pytest.importorskip("pyuff")
VALUES = np.array([0.4, -0.06 - 0.055j, 0.026 - 0.00023j, -0.3 + 0.317j, -1.8 + 1.55j, 3.75 + 2.93j])


def dataset(kind, form, body, *, even=1, step=0.195313, unit="NONE", axis="Hz", over=18, points=6):
    """Lines of a dataset 58; ``form`` is the ordinate type, ``body`` the lines of numbers."""
    return [
        "    -1",
        "    58",
        "a test",
        "NONE",
        "23-Mar-17 19:02:23",
        "Record 1 of Dataset no 58",
        "H1 : #  2 / #  1",
        f"{kind:5d}         0    0         0 NONE               0   0 NONE               0   0",
        f"{form:10d}{points:10d}{even:10d} {0.0:.5e}  {step:.5e}  {0.0:.5e} ",
        f"{over:10d}    0    0    0 NONE                 {axis:<20}",
        f"{1:10d}    0    0    0 Frequency Function   {unit:<20}",
        "         0    0    0    0 NONE                 NONE                ",
        "         0    0    0    0 NONE                 NONE                ",
        *body,
        "    -1",
    ]


def numbers(values, form):
    rows = np.asarray(values, dtype=complex).view(float).reshape(-1, 6)
    return ["".join(form.format(v) for v in row) for row in rows]


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1"])
def test_signs_at_the_beginning_of_fields_and_units_beyond_ascii(tmp_path, encoding):
    lines = dataset(4, 5, numbers(VALUES, "{: .5e} "), unit="(1/N)*(m/s²)")
    (tmp_path / "a.uff").write_bytes("\n".join([*lines, ""]).encode(encoding))
    read = ar.read_uff(tmp_path / "a.uff")
    np.testing.assert_allclose(read.values[0], VALUES, rtol=1e-5)
    assert read.freq_hz[1] == 0.1953125  # 100/512, of which six digits are written
    broken = [*lines[:-2], lines[-2][:-14], lines[-1]]
    (tmp_path / "b.uff").write_bytes("\n".join([*broken, ""]).encode(encoding))
    with pytest.raises(ar.UnsuitableDataError, match="points, not the 6"):
        ar.read_uff(tmp_path / "b.uff")


def test_power_spectra_alone_have_no_phase(tmp_path):
    body = [
        f" {i:12.6E} {1e-6 * (i + 1):12.6E} {0.0:12.6E} {i + 1:12.6E} {2e-6:12.6E} {0.0:12.6E}"
        for i in (0, 2, 4)
    ]
    lines = dataset(9, 5, body, even=0, step=0.0, unit="g²/Hz")
    (tmp_path / "a.uff").write_bytes("\n".join([*lines, ""]).encode())
    with pytest.raises(ar.UnsuitableDataError, match=r"1 auto spectra .* of 0S.*lost the phase"):
        ar.read_uff(tmp_path / "a.uff")


def test_a_last_line_that_is_filled_with_blanks(tmp_path):
    values = [-3.81956, -3.56616, -2.98987, 1.0, 2.0, -3.0, -5.84096]
    body = ["".join(f" {v:12.5E}"[:13] for v in values[:6]), "".join(f" {v:12.5E}"[:13] for v in values[6:])]
    lines = dataset(1, 2, body, step=5e-5, unit="m/s²", axis="s", over=17, points=7)
    (tmp_path / "a.uff").write_bytes("\n".join([*(line.ljust(80) for line in lines), ""]).encode())
    read = ar.read_uff(tmp_path / "a.uff")
    assert read.fs_hz == 20000.0
    np.testing.assert_allclose(read.responses[0], values)


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
    record = ar.Recording(np.random.default_rng(3).standard_normal((1, 22)), 512.0, dofs=["12+Z"])
    file = ar.write_uff(tmp_path / "a.uff", record, binary=False)
    plain = ar.read_uff(file).responses
    whole = file.read_bytes().replace(b"antires_rs crc32", b"another program ")
    moved = next(m for width in (13, 20) if (m := moved_left(whole, width)) != whole)
    file.write_bytes(moved)
    assert np.array_equal(ar.read_uff(file).responses, plain)
    # A number that is lost is missed all the same.
    row = next(r for r in reversed(moved.split(b"\n")) if len(r.split()) > 1 and b"e" in r.lower())
    file.write_bytes(moved.replace(row, row[: row.rindex(b" ")].rstrip()))
    with pytest.raises(ar.UnsuitableDataError, match="points, not the 22"):
        ar.read_uff(file)
