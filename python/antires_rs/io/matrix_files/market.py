"""Matrix Market files, read here and not by SciPy, whose reader ends the process at some damaged ones."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._common import brief, unsuitable
from .labelled import Labelled

__all__ = ["is_matrix_market", "read_matrix_market"]


def is_matrix_market(file: Path) -> bool:
    """Whether a plain file says so of itself."""
    with file.open("rb") as opened:
        return opened.read(14).lower() == b"%%matrixmarket"


def read_matrix_market(file: Path) -> dict[str, Labelled]:
    """The matrix of a file, under its stem; its entries are counted against its header."""
    import gzip
    import zlib

    wanted = "a whole Matrix Market file"
    try:
        with (gzip.open if file.suffix == ".gz" else open)(file, "rb") as opened:
            text = opened.read()
    except (OSError, EOFError, zlib.error) as exc:
        unsuitable(file, f"which cannot be unpacked ({exc})", wanted, "It was cut or damaged.")
    lines = [line for line in text.splitlines() if line.strip()]
    numbers = [line for line in lines if not line.startswith(b"%")]
    if not lines or not lines[0].lower().startswith(b"%%matrixmarket") or not numbers:
        unsuitable(
            file,
            "which is cut in its head or of another kind",
            wanted,
            "Export it again as MatrixMarket, .mtx.",
        )
    try:
        head, stated = _head(lines[0].lower().split(), numbers[0].split())
    except ValueError:
        unsuitable(
            file, f"with the sizes {numbers[0]!r}", wanted, "Export it again: the matrix must be square."
        )
    if len(numbers) - 1 != stated or not text.endswith((b"\n", b"\r")):
        end = "" if text.endswith((b"\n", b"\r")) else ", the last without a line end"
        unsuitable(file, f"with {len(numbers) - 1} of {stated} entries{end}", wanted, "Copy it again.")
    entry = _entry(head[0].split())
    wrong = next((line for line in numbers[1:] if not entry.fullmatch(line)), None)
    if wrong is not None:
        unsuitable(file, f"with the entry {wrong[:40]!r}", wanted, "Export it again, as real numbers.")
    try:
        whole = _matrix(head, b"\n".join(numbers[1:]).decode("ascii"))
    except (ValueError, OverflowError, MemoryError) as exc:
        unsuitable(
            file,
            f"which cannot be read ({brief(exc)})",
            wanted,
            "Export it again, as real numbers in MatrixMarket format.",
        )
    return {file.stem: Labelled(whole)}


def _matrix(head: Sequence[bytes], entries: str) -> Any:
    """The matrix of entries that were counted and looked at, the other triangle filled in."""
    _, _, form, field, symmetry = head[0].lower().split()
    n = int(head[1].split()[0])
    numbers = np.array(entries.split(), dtype=np.float64)
    width = {b"pattern": 0, b"complex": 2}.get(field, 1)
    table = numbers.reshape(-1, width + 2 * (form == b"coordinate"))
    at, parts = table[:, : table.shape[1] - width], table[:, table.shape[1] - width :]
    values: Any = parts[:, 0] + 1j * parts[:, 1] if width == 2 else parts[:, 0] if width else np.ones(len(at))
    if form == b"coordinate":
        rows, columns = (at.astype(np.int64) - 1).T
        if at.size and (at.min() < 1 or at.max() > n or (at != np.round(at)).any()):
            raise ValueError("a row or column outside of the matrix")
    elif symmetry == b"general":
        columns, rows = np.divmod(np.arange(n * n), n)
    else:
        skew = int(symmetry == b"skew-symmetric")
        columns, rows = np.triu_indices(n, skew)  # lower triangle, column by column
    if symmetry != b"general":
        below = rows != columns
        other = {b"skew-symmetric": -values, b"hermitian": np.conj(values)}.get(symmetry, values)[below]
        rows, columns = np.append(rows, columns[below]), np.append(columns, rows[below])
        values = np.append(values, other)
    from scipy.sparse import coo_array

    whole = coo_array((values, (rows, columns)), shape=(n, n))
    return whole if form == b"coordinate" else whole.toarray()


def _head(words: Sequence[bytes], sizes: Sequence[bytes]) -> tuple[list[bytes], int]:
    """Both lines of the head, and the entries that they state; ValueError for any other head."""
    if len(words) != 5 or words[1] != b"matrix":
        raise ValueError("unknown head")
    if len(sizes) != {b"coordinate": 3, b"array": 2}.get(words[2]) or not all(map(bytes.isdigit, sizes)):
        raise ValueError("no sizes")
    n, columns, *entries = map(int, sizes)
    if n != columns or not 0 < n < 2**31:
        raise ValueError("not square")
    half = n * (n + 1) // 2
    stored = {b"general": n * n, b"symmetric": half, b"hermitian": half, b"skew-symmetric": half - n}
    if words[4] not in stored or words[3] not in (b"real", b"integer", b"double", b"pattern", b"complex"):
        raise ValueError("unknown symmetry or kind of numbers")
    if words[2] == b"array" and words[3] == b"pattern":
        raise ValueError("a pattern without places")
    lines = [b" ".join([b"%%MatrixMarket", *words[1:]]), b" ".join(sizes)]
    return lines, entries[0] if entries else stored[words[4]]


def _entry(words: Sequence[bytes]) -> re.Pattern[bytes]:
    """A line of numbers."""
    places = 2 * (words[2] == b"coordinate") + {b"pattern": 0, b"complex": 2}.get(words[3], 1)
    number = rb"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?|inf|infinity|nan)"
    return re.compile(rb"[ \t\r]*" + rb"[ \t]+".join([number] * places) + rb"[ \t\r]*", re.IGNORECASE)
