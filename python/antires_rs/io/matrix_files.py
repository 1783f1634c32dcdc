"""Stiffness and mass of any finite-element program: from its files, or matrices themselves.

The rows are the model's dofs. :func:`read_dof_map` reads which node and direction each of them is; what it
returns fits ``dofs=`` of :func:`~antires_rs.io.uff.read_uff`. First a reader for each format, then models.
"""

from __future__ import annotations

import io
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import part, reject
from ..models.matrix_model import MatrixModel
from ..models.recipes import MatrixRecipe
from ..models.structural_model import ModelDescription
from ..support.directions import DIRECTIONS, NAMES
from ..support.messages import warn
from ._child import Answer, room
from .archive import Store, decoded, encoded, read_store, recipe_1, write_store
from .child_process import Limits, in_a_child
from .common import PathLike, brief, existing_file, require, unsuitable
from .own_format import read_archive

#: Node and direction code, 1 to 6; 0 is a scalar.
Point = tuple[int, int]


@dataclass(frozen=True)
class Labelled:
    """A matrix (n, n), sparse or dense, and the node and direction of each row where the file tells them."""

    matrix: Any
    points: tuple[Point, ...] | None = None


def _fortran(text: str) -> float:
    """1.5, 1.5E+3, 1.5D+3 or 1.5+3."""
    plain = text.upper().replace("D", "E")
    return float(plain if "E" in plain else _SHORT.sub(r"E\1", plain))


def completed(rows: Any, columns: Any, values: Any, n: int) -> Any:
    """A symmetric matrix from its entries, of which the file may hold one triangle only."""
    from scipy.sparse import coo_array

    rows, columns = np.asarray(rows, dtype=np.int64), np.asarray(columns, dtype=np.int64)
    values = np.asarray(values, dtype=np.float64)
    beside = rows != columns
    if not ((rows > columns).any() and (rows < columns).any()):
        rows, columns = np.append(rows, columns[beside]), np.append(columns, rows[beside])
        values = np.append(values, values[beside])
    return coo_array((values, (rows, columns)), shape=(n, n))


def by_points(
    file: Path, entries: Sequence[tuple[Point, Point, float]], points: Sequence[Point] | None = None
) -> Labelled:
    """A matrix whose entries name node and direction; rows in ascending order of these."""
    if not entries:
        unsuitable(file, "without an entry", "a matrix", "Export it again.")
    found = sorted(set(points or ()) | {p for row, column, _ in entries for p in (row, column)})
    number = {point: nth for nth, point in enumerate(found)}
    rows, columns, values = zip(
        *((number[row], number[column], v) for row, column, v in entries), strict=True
    )
    return Labelled(completed(rows, columns, values, len(found)), tuple(found))


# -- Matrices that Abaqus writes with ``*MATRIX GENERATE`` and ``*MATRIX OUTPUT``: node, dof, node, dof, value
#
# Written as matrix input (with a line ``*MATRIX``) or as labels. A dof with a boundary condition has 1e36 on
# its diagonal: it is left out, with a warning.

#: What stands on the diagonal of a dof with a boundary condition.
_FIXED = 1e35


def is_abaqus(file: Path) -> bool:
    """Whether the first line with data has node, dof, node, dof, value."""
    with file.open(encoding="ascii", errors="replace") as opened:
        first = next((line for line in opened if line.strip() and not line.startswith("*")), "")
    *places, _ = first.split(",")
    return len(places) == 4 and all(place.strip().lstrip("-").isdigit() for place in places)


def read_abaqus(file: Path) -> dict[str, Labelled]:
    """The matrix of a file, under its stem."""
    entries: list[tuple[Point, Point, float]] = []
    for number, line in enumerate(file.read_text(encoding="ascii", errors="replace").splitlines(), 1):
        if not line.strip() or line.startswith("*"):
            continue
        try:
            node, dof, other, other_dof, value = line.split(",")
            entries.append(((int(node), int(dof)), (int(other), int(other_dof)), float(value)))
        except ValueError:
            found, wanted = f"with the line {number}: {line.strip()[:40]!r}", "node, dof, node, dof, value"
            unsuitable(file, found, wanted, "Export it again with FORMAT=MATRIX INPUT or LABELS.")
    fixed = {row for row, column, value in entries if row == column and value >= _FIXED}
    if fixed:
        few = ", ".join(f"{node}:{dof}" for node, dof in sorted(fixed)[:5]) + ", ..." * (len(fixed) > 5)
        said = f"has {len(fixed)} dof(s) with a boundary condition, 1e36 on the diagonal ({few})"
        warn("dofs_on_supports", f"path: {str(file)!r} {said}; they are left out.")
    return {file.stem: by_points(file, [e for e in entries if e[0] not in fixed and e[1] not in fixed])}


# -- Files of ``scipy.sparse.save_npz``, every checksum compared before SciPy sees them


def read_sparse_npz(file: Path) -> dict[str, Labelled]:
    """The matrix of a file, under its stem."""
    from scipy.sparse import load_npz

    arrays = read_archive(file)
    if "format" not in arrays or "shape" not in arrays:
        found = f"with the arrays {', '.join(arrays)}"
        unsuitable(file, found, "a file of scipy.sparse.save_npz", "Save it by scipy.sparse.save_npz.")
    return {file.stem: Labelled(load_npz(file))}


# -- Matrices as Nastran writes them into punch files and bulk data: the DMIG card
#
# The first card of a matrix tells its form (6 is symmetric, one triangle given) and type (1 and 2 are real);
# each other card is a column: grid and component, then grid, component and value of its entries. Fields are 8
# wide, 16 where the first ends in ``*``, or divided by commas.

_WANTED = "a punch file or bulk data with DMIG cards of real matrices"
_SHORT = re.compile(r"(?<=[\d.])([+-]\d+)$")


def read_dmig(file: Path) -> dict[str, Labelled]:
    """All matrices of a file, by name."""
    heads: set[str] = set()
    entries: dict[str, list[tuple[Point, Point, float]]] = {}
    columns: dict[str, list[Point]] = {}
    for line, fields in _cards(file.read_text(encoding="ascii", errors="replace").splitlines()):
        try:
            name = fields[1].upper()
            if fields[2] == "0" and name not in heads:
                if fields[4] not in ("1", "2"):
                    raise ValueError(f"matrix {name} of type {fields[4]}; 1 and 2 are real")
                heads.add(name)
                continue
            column = (int(fields[2]), int(fields[3] or 0))
            columns.setdefault(name, []).append(column)
            own = entries.setdefault(name, [])
            for i in range(5, len(fields) - 2, 4):
                if fields[i]:
                    own.append(((int(fields[i]), int(fields[i + 1] or 0)), column, _fortran(fields[i + 2])))
        except (ValueError, IndexError) as exc:
            got = f"with the card in line {line} that cannot be read ({exc})"
            unsuitable(file, got, _WANTED, "Correct it.")
    if not entries:
        unsuitable(file, "without a DMIG card", _WANTED, "Export with PARAM,EXTOUT,DMIGPCH.")
    return {name: by_points(file, own, columns[name]) for name, own in entries.items()}


def _cards(lines: list[str]) -> Iterator[tuple[int, list[str]]]:
    """DMIG cards: the number of their first line, and all fields without those of continuations."""
    card: list[str] | None = None
    begun = 0
    for number, raw in enumerate(lines, 1):
        line = raw.split("$")[0].rstrip()
        if not line:
            continue
        fields = _fields(line)
        if fields[0][:1] in ("", "*", "+"):
            if card is not None:
                card += fields[1:]
            continue
        if card is not None:
            yield begun, card
        is_dmig = fields[0].rstrip("*").upper() == "DMIG"
        card, begun = (fields if is_dmig else None), number
    if card is not None:
        yield begun, card


def _fields(line: str) -> list[str]:
    """The first field, and four of 16 or eight of 8 of the card itself."""
    if "," in line:
        parts = [part.strip() for part in line.split(",")]
        count = 4 if parts[0].endswith("*") else 8
        return [*parts[: count + 1], *[""] * (count + 1 - len(parts))]
    first = line[:8].strip()
    width, count = (16, 4) if first.startswith("*") or first.endswith("*") else (8, 8)
    return [first, *(line[8 + i * width : 8 + (i + 1) * width].strip() for i in range(count))]


# -- Stiffness and mass of an ANSYS ``.full`` file, read by ansys-mapdl-reader in a child process

_WANTED_FULL = "a .full file with matrices, written by WRFULL"


def read_full(file: Path) -> dict[str, Labelled]:
    """``K`` and ``M`` of a file, of the dofs without constraints."""
    # The package is compiled: a damaged file can end or fill the interpreter that reads it.
    require("Reading .full files", "ansys.mapdl.reader", "ansys", "ansys-mapdl-reader")
    arrays = in_a_child(matrices_of_full, file, _WANTED_FULL, Limits(600.0, 16.0)).arrays
    points = arrays["points"]
    rows, columns = ([arrays[f"{name}.{axis}"] for name in "KM"] for axis in ("row", "col"))
    if any(each.size and not 0 <= each.min() <= each.max() < len(points) for each in (*rows, *columns)):
        found = f"with entries beyond its {len(points)} dofs"
        unsuitable(file, found, _WANTED_FULL, "It was damaged: write it again.")
    # Dofs with constraints are there, without an entry.
    kept = np.flatnonzero(np.isin(np.arange(len(points)), [*rows[0], *rows[1]]))
    # The directions of ANSYS count from 0: UX, UY, UZ, ROTX, ROTY, ROTZ.
    named: tuple[Point, ...] = tuple((int(node), int(code) + 1) for node, code in points[kept])
    place = np.cumsum(np.isin(np.arange(len(points)), kept)) - 1
    made = {}
    for name, row, column in zip("KM", rows, columns, strict=True):
        whole = completed(place[row], place[column], arrays[f"{name}.data"], len(named))
        made[name] = Labelled(whole, named)
    return made


def matrices_of_full(path: str, request: dict[str, Any]) -> Answer:
    """Stiffness and mass of ANSYS as entries, with node and direction of each row."""
    from ansys.mapdl.reader import read_binary

    points, *matrices = read_binary(path).load_km(as_sparse=True, sort=False)
    arrays = {"points": np.asarray(points, dtype=np.int64).reshape(-1, 2)}
    for name, matrix in zip("KM", matrices, strict=True):
        entries = matrix.tocoo()
        arrays |= {f"{name}.row": entries.row, f"{name}.col": entries.col, f"{name}.data": entries.data}
    room(sum(array.size for array in arrays.values()), request)
    return arrays, {}, []


# -- Matrices in the Harwell-Boeing form, as ANSYS writes them with HBMAT: real, assembled
#
# Four lines of head (title; counts of lines; type and sizes; forms of numbers), a fifth where a right-hand
# side follows; then the pointers to columns, the rows and the values, each in a form of Fortran. Reference:
# I. S. Duff, R. G. Grimes, J. G. Lewis, ACM Trans. Math. Softw. 15 (1989) 1-14.

_WANTED_HARWELL_BOEING = "a real assembled square matrix in the Harwell-Boeing form (RSA or RUA)"
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
        got = f"which is cut, damaged or of another kind ({exc})"
        unsuitable(file, got, _WANTED_HARWELL_BOEING, "Export it again.")
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
    return np.array(list(map(_fortran, parts)))


# -- Matrix Market files, every line checked before SciPy sees them: at some damaged ones it ends the process


def read_matrix_market(file: Path) -> dict[str, Labelled]:
    """The matrix of a file, under its stem; its entries are counted against its header."""
    import gzip
    import zlib

    from scipy.io import mmread
    from scipy.sparse import coo_array

    wanted = "a whole Matrix Market file"
    try:
        with (gzip.open if file.suffix == ".gz" else open)(file, "rb") as opened:
            text = opened.read()
    except (OSError, EOFError, zlib.error) as exc:
        unsuitable(file, f"which cannot be unpacked ({exc})", wanted, "It was cut or damaged.")
    lines = [line for line in text.splitlines() if line.strip()]
    numbers = [line for line in lines if not line.startswith(b"%")]
    if not lines or not lines[0].lower().startswith(b"%%matrixmarket") or not numbers:
        found = "which is cut in its head or of another kind"
        unsuitable(file, found, wanted, "Export it again as MatrixMarket, .mtx.")
    try:
        form, kind, stated = _head(lines[0].lower().split(), numbers[0].split())
    except ValueError:
        got = f"with the sizes {numbers[0]!r}"
        unsuitable(file, got, wanted, "Export it again: the matrix must be square.")
    if len(numbers) - 1 != stated or not text.endswith((b"\n", b"\r")):
        end = "" if text.endswith((b"\n", b"\r")) else ", the last without a line end"
        unsuitable(file, f"with {len(numbers) - 1} of {stated} entries{end}", wanted, "Copy it again.")
    places, width = 2 * (form == b"coordinate"), {b"pattern": 0, b"complex": 2}.get(kind, 1)
    number = rb"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?|inf|infinity|nan)"
    blank, fields = rb"[ \t\r]*", rb"[ \t]+".join([rb"\d+"] * places + [number] * width)
    entry = re.compile(blank + fields + blank, re.IGNORECASE)
    wrong = next((line for line in numbers[1:] if not entry.fullmatch(line)), None)
    if wrong is not None:
        unsuitable(file, f"with the entry {wrong[:40]!r}", wanted, "Export it again, as real numbers.")
    try:
        head = b"%%MatrixMarket" + lines[0][14:].lower().replace(b"double", b"real")
        whole = mmread(io.BytesIO(b"\n".join([head, *numbers, b""])))
    except (ValueError, OverflowError, MemoryError) as exc:
        got = f"which cannot be read ({brief(exc)})"
        unsuitable(file, got, wanted, "Export it again, as real numbers in MatrixMarket format.")
    return {file.stem: Labelled(coo_array(whole) if places else whole)}


def _head(words: Sequence[bytes], sizes: Sequence[bytes]) -> tuple[bytes, bytes, int]:
    """Form, kind of numbers, and entries that are stated; ValueError for any other head."""
    if len(words) != 5 or words[1] != b"matrix":
        raise ValueError("unknown head")
    _, _, form, kind, symmetry = words
    if len(sizes) != {b"coordinate": 3, b"array": 2}.get(form) or not all(map(bytes.isdigit, sizes)):
        raise ValueError("no sizes")
    n, columns, *entries = map(int, sizes)
    if n != columns or not 0 < n < 2**31:
        raise ValueError("not square")
    half = n * (n + 1) // 2
    stored = {b"general": n * n, b"symmetric": half, b"hermitian": half, b"skew-symmetric": half - n}
    if symmetry not in stored or kind not in (b"real", b"integer", b"double", b"pattern", b"complex"):
        raise ValueError("unknown symmetry or kind of numbers")
    if form == b"array" and kind == b"pattern":
        raise ValueError("a pattern without places")
    return form, kind, entries[0] if entries else stored[symmetry]


# -- Matrices that Nastran's OUTPUT4 writes: text or binary, dense or sparse, of single or double precision
#
# A matrix is a header (columns, rows, form, type, name) and a record for each column that is not empty: its
# number, its first row or 0 where it is made of strings, and the count of words that follow. A string is a
# run of rows: its length and first row are two words where the header's rows are negative, else packed into
# one as row + 65536 (length + 1).

_WANTED_OP4 = "a whole file of OUTPUT4, of real matrices"
_CUT = "Export it again; complex matrices have no place in an undamped model."
_HEADER = re.compile(r"^([ \d-]{8})([ \d-]{8})([ \d-]{8})([ \d-]{8})(.{8})(.*)$")
_WIDTH = re.compile(r"[EDG](\d+)\.\d+")
_PACKED = 65536

#: Column, first row, values.
Run = tuple[int, int, NDArray[np.float64]]


def read_op4(file: Path) -> dict[str, Labelled]:
    """All matrices of a file, by name."""
    from scipy.sparse import coo_array

    content = file.read_bytes()
    binary = content[:4] in (b"\x18\0\0\0", b"\0\0\0\x18")
    found: dict[str, Labelled] = {}
    try:
        matrices = _binary(content) if binary else _text(content.decode("ascii").splitlines())
        for name, n_rows, n_columns, runs in matrices:
            whole = coo_array((n_rows, n_columns))
            if runs:
                rows = np.concatenate([np.arange(first, first + own.size) for _, first, own in runs])
                columns = np.concatenate([np.full(own.size, column) for column, _, own in runs])
                values = np.concatenate([own for _, _, own in runs])
                whole = coo_array((values, (rows, columns)), shape=(n_rows, n_columns))
            found[name] = Labelled(whole)
    except (ValueError, IndexError, StopIteration, UnicodeDecodeError, RuntimeError) as exc:
        unsuitable(file, f"which is cut, damaged or of another kind ({exc})", _WANTED_OP4, _CUT)
    if not found:
        unsuitable(file, "without a matrix", _WANTED_OP4, _CUT)
    return found


def _sizes(words: Iterable[Any]) -> tuple[int, int, int]:
    """Columns, rows and type of a matrix, which has to be real."""
    n_columns, n_rows, _, kind = map(int, words)
    if kind not in (1, 2):
        raise ValueError(f"matrix of type {kind}; 1 and 2 are real")
    return n_columns, n_rows, kind


def _text(lines: list[str]) -> Iterator[tuple[str, int, int, list[Run]]]:
    """Lines of whole numbers are headers; all others are values of the form that the header states."""
    at = 0
    while at < len(lines):
        head = _HEADER.match(lines[at])
        if head is None:
            raise ValueError(f"line {at + 1} is no header")
        n_columns, n_rows, _ = _sizes(head.groups()[:4])
        stated = _WIDTH.search(head[6])
        width = int(stated[1]) if stated else 16
        runs: list[Run] = []
        column, at = 0, at + 1
        while True:
            words = lines[at].split()
            if not _whole(words) or len(words) > 3:
                raise ValueError(f"line {at + 1} is neither a header nor expected")
            at += 1
            start = int(words[-1]) % _PACKED if len(words) == 1 else int(words[1])
            if len(words) == 3:
                column = int(words[0])
                if column > n_columns:
                    at += 1  # the record that ends the matrix has one value
                    break
                if start == 0:
                    continue
            values: list[float] = []
            while at < len(lines) and not _whole(lines[at].split()):
                line = lines[at].rstrip()
                values += [_fortran(line[i : i + width]) for i in range(0, len(line), width)]
                at += 1
            if not values:
                raise ValueError(f"no values above line {at + 1}")
            runs.append((column - 1, start - 1, np.array(values)))
        yield head[5].strip(), abs(n_rows), n_columns, runs


def _whole(words: list[str]) -> bool:
    return bool(words) and all(word.lstrip("-").isdigit() for word in words)


def _binary(content: bytes) -> Iterator[tuple[str, int, int, list[Run]]]:
    order = "<" if content[0] else ">"
    records = _records(content, order)
    for record in records:
        if len(record) != 24:
            raise ValueError("no header of 24 bytes")
        n_columns, n_rows, kind = _sizes(np.frombuffer(record[:16], f"{order}i4"))
        name = record[16:].decode("ascii").strip()
        runs: list[Run] = []
        while True:
            record = next(records)
            column, first, _ = (int(i) for i in np.frombuffer(record[:12], f"{order}i4"))
            if column > n_columns:
                break
            for start, values in _strings(record[12:], first, n_rows < 0, f"{order}f{4 * kind}"):
                runs.append((column - 1, start - 1, values.astype(np.float64)))
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


# -- Matrices in the files of finite-element programs: a reader for each format, chosen by the ending

_READERS: dict[str, Callable[[Path], dict[str, Labelled]]] = {
    ".npz": read_sparse_npz,
    **dict.fromkeys((".mtx", ".mtx.gz", ".mm"), read_matrix_market),
    ".op4": read_op4,
    **dict.fromkeys((".pch", ".bdf", ".dmig"), read_dmig),
    ".full": read_full,
    **dict.fromkeys((".rsa", ".rua", ".hb"), read_harwell_boeing),
}


def matrices_in(name: str, path: PathLike) -> dict[str, Labelled]:
    """All matrices of a file, by name."""
    file = existing_file(path)
    ending = next((e for e in _READERS if file.name.lower().endswith(e)), None)
    if ending is None:
        remedy = "Export the matrix in one of these formats, or pass it as a scipy.sparse array."
        reject(name, repr(str(file)), "a file that ends in " + ", ".join(_READERS) + ", or a matrix", remedy)
    return (read_abaqus if ending == ".mtx" and is_abaqus(file) else _READERS[ending])(file)


def choose(name: str, path: PathLike, letter: str) -> Labelled:
    """The only matrix of a file, or the only one whose name begins with ``letter``."""
    found = matrices_in(name, path)
    own = list(found) if len(found) == 1 else [each for each in found if each.upper().startswith(letter)]
    if len(own) != 1:
        got = f"{str(path)!r} with the matrices {', '.join(found)}"
        wanted = f"a file with one matrix, or with one whose name begins with {letter}"
        reject(name, got, wanted, "Write the matrices into files of their own.")
    return found[own[0]]


FORMAT, VERSION = "antires_rs.matrices", 2
#: Files that may hold stiffness and mass, by their names: K... and M...
_OF_BOTH = (".op4", ".pch", ".bdf", ".dmig", ".full")


def read_matrices(
    stiffness: Any,
    mass: Any = None,
    *,
    stiffness_terms: Iterable[Any] = (),
    mass_terms: Iterable[Any] = (),
    constraints: Any = None,
    keep: Iterable[int | str] = (),
    dofs: Any = None,
) -> MatrixModel:
    """A model from matrices in files.

    Parameters
    ----------
    stiffness, mass : path-like, array_like or scipy.sparse
        Files, by their endings: Matrix Market (``.mtx``, ``.mtx.gz``), ``scipy.sparse.save_npz`` (``.npz``),
        Nastran's OUTPUT4 (``.op4``) and DMIG cards (``.pch``, ``.bdf``), Abaqus's ``*MATRIX OUTPUT``
        (``.mtx``), Harwell-Boeing (``.rsa``, ``.rua``, ``.hb``), ANSYS (``.full``, extra ``ansys``); or the
        matrices themselves. Without ``mass``, a file of :func:`write_matrices`, or one that holds both: of
        ANSYS, or of Nastran with one name that begins with K and one with M.
    stiffness_terms, mass_terms : sequence of the same
        Contribution of each element or group that a parameter may scale.
    constraints, keep, dofs : optional
        As of :class:`MatrixModel`. ``dofs`` may be a file for :func:`~antires_rs.io.read_dof_map`;
        by default the names that a file of matrices gives its rows (DMIG cards, Abaqus, ANSYS).

    Returns
    -------
    MatrixModel

    Raises
    ------
    UnsuitableDataError
        A file that is cut, damaged or of another kind.
    InvalidInputError
        Matrices that are not square and symmetric, or of different sizes.
    FileNotFoundError
        There is none.

    Notes
    -----
    See docs/recipes for Nastran (op2, op4), ANSYS, scikit-fem and OpenSees.

    Examples
    --------
    >>> import tempfile, numpy as np, antires_rs as ar
    >>> from scipy.io import mmwrite
    >>> spring = 500.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     mmwrite(folder + "/K.mtx", spring, symmetry="symmetric")
    ...     ar.read_matrices(folder + "/K.mtx", np.eye(2), stiffness_terms=[folder + "/K.mtx"])
    MatrixModel(2 dofs, 1 stiffness terms, 0 mass terms)
    """
    if mass is None:
        if not isinstance(stiffness, str | os.PathLike):
            reject("mass", None, "the mass matrix", "Only files of write_matrices, .op4 and .pch hold both.")
        if not str(stiffness).lower().endswith(_OF_BOTH):
            return _own(stiffness)
        mass = stiffness
    rows = _labelled("stiffness", stiffness, "K")

    def placed(name: str, given: Any, letter: str) -> Any:
        return _in_rows_of(name, _labelled(name, given, letter), rows)

    terms = {}
    for name, each, letter in (("stiffness_terms", stiffness_terms, "K"), ("mass_terms", mass_terms, "M")):
        terms[name] = [placed(part(name, i), term, letter) for i, term in enumerate(each)]
    if isinstance(dofs, str | os.PathLike):
        dofs = read_dof_map(dofs)
    elif dofs is None and rows.points is not None:
        dofs = rows.points
    more: dict[str, Any] = {"constraints": constraints, "keep": tuple(keep), "dofs": dofs}
    return MatrixModel(rows.matrix, placed("mass", mass, "M"), **terms, **more)


def write_matrices(path: PathLike, model: MatrixModel) -> Path:
    """Write stiffness, mass and terms of a model into one npz file, whole or not at all.

    Parameters
    ----------
    path : path-like
        Replaced if it exists.
    model : MatrixModel
        As it was made: not one that came out of an updating, which its result keeps.

    Returns
    -------
    pathlib.Path

    Raises
    ------
    InvalidInputError
        Another kind of model, or a folder that does not exist.

    Examples
    --------
    >>> import tempfile, numpy as np, antires_rs as ar
    >>> spring = 500.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_matrices(folder + "/model.npz", ar.MatrixModel(spring, np.eye(2)))
    ...     ar.read_matrices(file).n_dof
    2
    """
    recipe = model.description.recipe if isinstance(model, MatrixModel) else None
    if not isinstance(recipe, MatrixRecipe) or model.description.applied:
        got = "an updated model" if isinstance(model, MatrixModel) else type(model).__name__
        wanted = "a MatrixModel as it was made"
        reject("model", got, wanted, "Save the result of an updating with result.save.")
    store = Store()
    data = {"format": FORMAT, "version": VERSION, "recipe": encoded(recipe, store)}
    return write_store(path, data, store)


def read_dof_map(path: PathLike, *, first_row: int = 1) -> dict[tuple[int, str], int]:
    """Which row of the matrices belongs to which node and direction.

    Parameters
    ----------
    path : path-like
        Text with one line for each row: ``node direction`` in the order of the rows, or ``row node
        direction`` as in the mapping file of ANSYS. Directions are X, UX, +X, T1, 1; rotations RX, ROTX, R1,
        4.
        Other lines above the first of these are skipped. Or a file of matrices that names them itself (DMIG
        cards, Abaqus): the rows of its stiffness, if it holds several.
    first_row : int
        Number of the first row in files that number them.

    Returns
    -------
    dict of (int, str) to int
        ``{(node, '+Z'): row}``, rows zero-based: the ``dofs=`` of :func:`~antires_rs.read_uff`.

    Raises
    ------
    UnsuitableDataError
        No such line, a line among them that is cut or damaged, a point or row twice.

    Examples
    --------
    >>> import pathlib, tempfile, antires_rs as ar
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder, "K.mapping")
    ...     _ = file.write_text("Matrix Eqn  Node  DOF\\n 1 12 UY\\n 2 12 UZ\\n")
    ...     ar.io.read_dof_map(file)
    {(12, '+Y'): 0, (12, '+Z'): 1}
    """
    file = existing_file(path)
    if file.name.lower().endswith((".mtx", *_OF_BOTH)):
        several = matrices_in("path", file)
        points = (next(iter(several.values())) if len(several) == 1 else choose("path", file, "K")).points
        if points is None:
            wanted = "DMIG cards, Abaqus's *MATRIX OUTPUT, or a text with node and direction of each row"
            remedy = "Write the table of equations beside the matrices."
            unsuitable(file, "which does not name its rows", wanted, remedy)
        return {(node, DIRECTIONS[code]): row for row, (node, code) in enumerate(points)}
    wanted = "a line 'node direction' or 'row node direction' for each row"
    found: dict[tuple[int, str], int] = {}
    for number, line in enumerate(file.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        parts = line.replace(",", " ").replace(";", " ").split()
        if not parts or line.lstrip().startswith(("#", "!", "$", "%")):
            continue
        code = NAMES.get(parts[-1].upper())
        whole = len(parts) in (2, 3) and code is not None and all(p.isdigit() for p in parts[:-1])
        if not whole:
            if found:
                unsuitable(file, f"whose line {number} is {line.strip()!r}", wanted, "Correct that line.")
            continue
        row = int(parts[0]) - first_row if len(parts) == 3 else len(found)
        point = (int(parts[-2]), DIRECTIONS[code])  # type: ignore[index]
        if point in found or row in found.values() or row < 0:
            got = f"with {point} or row {row + first_row} twice or out of range in line {number}"
            expected = "each once, rows from first_row on"
            unsuitable(file, got, expected, "Correct that line of the map, or first_row.")
        found[point] = row
    if not found:
        unsuitable(file, "without such a line", wanted, "Export it with its header.")
    return found


def _own(path: PathLike) -> MatrixModel:
    file, data = read_store(path, FORMAT, VERSION, "a file of write_matrices")
    if data["version"] == 1:
        recipe = recipe_1(data | dict(zip(("stiffness", "mass"), data["matrices"], strict=True)))
    else:
        recipe = decoded(data["recipe"], str(file))
    return MatrixModel.from_description(ModelDescription(recipe, ()))


def _labelled(name: str, given: Any, letter: str) -> Labelled:
    """A matrix, or the one of a file."""
    return choose(name, given, letter) if isinstance(given, str | os.PathLike) else Labelled(given)


def _in_rows_of(name: str, each: Labelled, rows: Labelled) -> Any:
    """A matrix with the rows of the stiffness: those of a file of another order, or without all of them."""
    if each.points is None or rows.points is None or each.points == rows.points:
        return each.matrix
    from scipy.sparse import coo_array

    number = {point: nth for nth, point in enumerate(rows.points)}
    unknown = [point for point in each.points if point not in number]
    if unknown:
        got = f"entries at node {unknown[0][0]}, component {unknown[0][1]}"
        wanted = "the nodes and components of the stiffness, or some of them"
        reject(name, got, wanted, "Export both matrices of one model, after the same constraints.")
    places = np.array([number[point] for point in each.points])
    entries = coo_array(each.matrix)
    shape = (len(number), len(number))
    return coo_array((entries.data, (places[entries.row], places[entries.col])), shape=shape)
