"""Matrices in the Harwell-Boeing form, as ANSYS writes them with HBMAT: real, assembled.

Four lines of head (title; counts of lines; type and sizes; forms of numbers), a fifth where a right-hand side
follows; then the pointers to columns, the rows and the values, each in a form of Fortran.
Reference: I. S. Duff, R. G. Grimes, J. G. Lewis, ACM Trans. Math. Softw. 15 (1989) 1-14.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from .._common import unsuitable
from .labelled import Labelled, completed

__all__ = ["read_harwell_boeing"]

_WANTED = "a real assembled square matrix in the Harwell-Boeing form (RSA or RUA)"
_FORM = re.compile(r"(\d*)[IEDFG](\d+)", re.IGNORECASE)


def read_harwell_boeing(file: Path) -> dict[str, Labelled]:
    """The matrix of a file, under its stem."""
    lines = file.read_text(encoding="ascii", errors="replace").splitlines()
    try:
        counts = [int(word) for word in lines[1].split()]
        kind, sizes = lines[2][:3].upper(), [int(word) for word in lines[2][3:].split()]
        if kind not in ("RSA", "RUA"):
            raise ValueError(f"matrix of type {kind!r}")
        n, n_entries = sizes[1], sizes[2]
        if sizes[0] != n or n < 1:
            raise ValueError(f"matrix of {sizes[0]} by {n}")
        at = 5 if len(counts) > 4 and counts[4] > 0 else 4
        pointers = _numbers(lines[at : at + counts[1]], lines[3][:16], n + 1).astype(np.int64)
        at += counts[1]
        rows = _numbers(lines[at : at + counts[2]], lines[3][16:32], n_entries).astype(np.int64) - 1
        at += counts[2]
        values = _numbers(lines[at : at + counts[3]], lines[3][32:52], n_entries)
        if pointers[0] != 1 or pointers[-1] != n_entries + 1 or rows.min() < 0 or rows.max() >= n:
            raise ValueError("pointers or rows out of range")
        columns = np.repeat(np.arange(n), np.diff(pointers))
    except (ValueError, IndexError) as exc:
        unsuitable(file, f"which is cut, damaged or of another kind ({exc})", _WANTED, "Export it again.")
    return {file.stem: Labelled(completed(rows, columns, values, n))}


def _numbers(lines: list[str], form: str, count: int) -> np.ndarray:
    """Numbers of lines, each of the width that the form states."""
    stated = _FORM.search(re.sub(r"\d*P,?", "", form.upper()))
    if stated is None:
        raise ValueError(f"form {form.strip()!r}")
    width, most = int(stated[2]), int(stated[1] or 1)
    apart = [part for line in lines for part in line.split()]
    # Numbers may touch; those that do not are not always as wide as it is stated.
    touching = (line[i : i + width] for line in lines for i in range(0, min(len(line), width * most), width))
    parts = apart if len(apart) == count else [part for part in touching if part.strip()]
    if len(parts) != count:
        raise ValueError(f"{len(parts)} of {count} numbers")
    return np.array([float(part.upper().replace("D", "E")) for part in parts])
