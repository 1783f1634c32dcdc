"""Stiffness and mass of any finite-element program: from its files, or matrices themselves.

The rows are the model's dofs. :func:`read_dof_map` reads which node and direction each of them is; what it
returns fits ``dofs=`` of :func:`~antires_rs.io.uff.read_uff`. First a reader for each format, then models. A
reader says by ValueError what is wrong with a file; what it should have been is in the table of formats.
"""

from __future__ import annotations

import gzip
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import AntiresError, part, reject
from ..models.matrix_model import MatrixModel
from ..models.structural_model import ModelDescription
from ..support.directions import DIRECTIONS, NAMES
from ..support.messages import warn
from ._child import Answer, room
from .archive import Store, decoded, encoded, read_store, recipe_1, within, write_store
from .child_process import Limits, in_a_child
from .common import BYTES_OF_DOF, bounded, existing_file, most_bytes, parts_of, require, unsuitable
from .options import PathLike
from .own_format import read_archive

__all__ = ["read_dof_map", "read_matrices", "write_matrices"]

Point = tuple[int, int]  # node and direction code, 1 to 6; 0 is a scalar
Entry = tuple[Point, Point, float]  # row, column, value


@dataclass(frozen=True)
class Labelled:
    """A matrix (n, n), sparse or dense, and the node and direction of each row where the file tells them."""

    matrix: Any
    points: tuple[Point, ...] | None = None


def _fortran(text: str) -> float:
    """1.5, 1.5E+3, 1.5D+3 or 1.5+3."""
    plain = text.upper().replace("D", "E")
    return float(plain if "E" in plain else _SHORT.sub(r"E\1", plain))


def _lines(file: Path) -> list[str]:
    return file.read_text(encoding="ascii", errors="replace").splitlines()


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


def by_points(entries: Sequence[Entry], points: Iterable[Point] = ()) -> Labelled:
    """A matrix whose entries name node and direction; rows in ascending order of these."""
    if not entries:
        raise ValueError("a matrix without an entry")
    found = sorted({*points, *(point for entry in entries for point in entry[:2])})
    number = {point: nth for nth, point in enumerate(found)}
    rows, columns, values = zip(*((number[r], number[c], v) for r, c, v in entries), strict=True)
    return Labelled(completed(rows, columns, values, len(found)), tuple(found))


# -- Matrices that Abaqus writes with ``*MATRIX GENERATE`` and ``*MATRIX OUTPUT``: node, dof, node, dof, value
#
# Written as matrix input (with a line ``*MATRIX``) or as labels. A dof with a boundary condition has 1e36 on
# its diagonal: it is left out, with a warning.

_FIXED = 1e35  # what stands on the diagonal of a dof with a boundary condition


def is_abaqus(file: Path) -> bool:
    """Whether the first line with data has node, dof, node, dof, value."""
    with file.open(encoding="ascii", errors="replace") as opened:
        first = next((line for line in opened if line.strip() and not line.startswith("*")), "")
    *places, _ = first.split(",")
    return len(places) == 4 and all(place.strip().lstrip("-").isdigit() for place in places)


def read_abaqus(file: Path) -> dict[str, Labelled]:
    """The matrix of a file, under its stem."""
    entries: list[Entry] = []
    for number, line in enumerate(_lines(file), 1):
        if line.strip() and not line.startswith("*"):
            try:
                node, dof, other, other_dof, value = line.split(",")
                entries.append(((int(node), int(dof)), (int(other), int(other_dof)), float(value)))
            except ValueError:
                raise ValueError(f"line {number} is {line.strip()[:40]!r}") from None
    fixed = {row for row, column, value in entries if row == column and value >= _FIXED}
    if fixed:
        few = ", ".join(f"{node}:{dof}" for node, dof in sorted(fixed)[:5]) + ", ..." * (len(fixed) > 5)
        said = f"has {len(fixed)} dof(s) with a boundary condition, 1e36 on the diagonal ({few})"
        warn("dofs_on_supports", f"path: {str(file)!r} {said}; they are left out.")
    return {file.stem: by_points([e for e in entries if e[0] not in fixed and e[1] not in fixed])}


def read_sparse_npz(file: Path) -> dict[str, Labelled]:
    """The matrix of ``scipy.sparse.save_npz``, checksums, types and places compared before SciPy uses it."""
    from scipy.sparse import load_npz

    arrays = read_archive(file)
    if "format" not in arrays or "shape" not in arrays:
        unsuitable(file, f"with the arrays {', '.join(arrays)}", FORMATS[".npz"][1])
    places = {name: "iu" for name in ("shape", "indices", "indptr", "row", "col", "coords", "offsets")}
    for name, kinds in ({"data": "biufc"} | places).items():
        if (name in arrays or name == "data") and arrays[name].dtype.kind not in kinds:
            raise ValueError(f"{name} of {arrays[name].dtype}")
    matrix = load_npz(file)
    if hasattr(matrix, "check_format"):  # its C code trusts the places
        matrix.check_format(full_check=True)
    return {file.stem: Labelled(matrix)}


# -- Matrices as Nastran writes them into punch files and bulk data: the DMIG card
#
# The first card of a matrix tells its form (6 is symmetric, one triangle given) and type (1 and 2 are real);
# each other card is a column: grid and component, then grid, component and value of its entries. Fields are 8
# wide, 16 where the first ends in ``*``, or divided by commas.

_SHORT = re.compile(r"(?<=[\d.])([+-]\d+)$")


def read_dmig(file: Path) -> dict[str, Labelled]:
    """All matrices of a file, by name."""
    cards: list[tuple[int, list[str]]] = []
    for number, raw in enumerate(_lines(file), 1):
        line = raw.split("$")[0].rstrip()
        fields = _fields(line) if line else []
        if fields and fields[0][:1] not in ("", "*", "+"):
            cards.append((number, fields))
        elif cards:  # it goes on
            cards[-1][1].extend(fields[1:])
    heads: set[str] = set()
    entries: dict[str, list[Entry]] = {}
    columns: dict[str, list[Point]] = {}
    for number, fields in cards:
        if fields[0].rstrip("*").upper() != "DMIG":
            continue
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
            raise ValueError(f"the card in line {number}: {exc}") from exc
    return {name: by_points(own, columns[name]) for name, own in entries.items()}


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


def read_full(file: Path) -> dict[str, Labelled]:
    """``K`` and ``M`` of a file, of the dofs without constraints."""
    # The package is compiled: a damaged file can end or fill the interpreter that reads it.
    require("Reading .full files", "ansys.mapdl.reader", "ansys", "ansys-mapdl-reader")
    arrays = in_a_child(matrices_of_full, file, FORMATS[".full"][1], Limits(600.0, 16.0)).arrays
    points = arrays["points"]
    rows, columns = ([arrays[f"{name}.{axis}"] for name in "KM"] for axis in ("row", "col"))
    if any(each.size and not 0 <= each.min() <= each.max() < len(points) for each in (*rows, *columns)):
        raise ValueError(f"entries beyond its {len(points)} dofs")
    kept = np.unique(np.concatenate(rows))  # Dofs with constraints are there, without an entry.
    # The directions of ANSYS count from 0: UX, UY, UZ, ROTX, ROTY, ROTZ.
    named: tuple[Point, ...] = tuple((int(node), int(code) + 1) for node, code in points[kept])
    made = {}
    for name, row, column in zip("KM", rows, columns, strict=True):
        i, j = np.searchsorted(kept, row), np.searchsorted(kept, column)
        made[name] = Labelled(completed(i, j, arrays[f"{name}.data"], len(named)), named)
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

_FORM = re.compile(r"(\d*)[IEDFG](\d+)", re.IGNORECASE)


def read_harwell_boeing(file: Path) -> dict[str, Labelled]:
    """The matrix of a file, under its stem."""
    lines = _lines(file)
    counts = [int(word) for word in lines[1].split()]
    n_rows, n, n_entries = map(int, lines[2][3:].split()[:3])
    if lines[2][:3].upper() not in ("RSA", "RUA") or n_rows != n or n < 1:
        raise ValueError(f"matrix of type {lines[2][:3]!r}, {n_rows} by {n}")
    at, parts = 5 if len(counts) > 4 and counts[4] > 0 else 4, []
    forms = (lines[3][:16], n + 1), (lines[3][16:32], n_entries), (lines[3][32:52], n_entries)
    for (form, count), n_lines in zip(forms, counts[1:4], strict=True):
        parts.append(_numbers(lines[at : at + n_lines], form, count))
        at += n_lines
    pointers, rows = parts[0].astype(np.int64), parts[1].astype(np.int64) - 1
    if pointers[0] != 1 or pointers[-1] != n_entries + 1 or rows.min() < 0 or rows.max() >= n:
        raise ValueError("pointers or rows out of range")
    return {file.stem: Labelled(completed(rows, np.repeat(np.arange(n), np.diff(pointers)), parts[2], n))}


def _numbers(lines: list[str], form: str, count: int) -> NDArray[np.float64]:
    """Numbers of lines, each of the width that the form states."""
    stated = _FORM.search(re.sub(r"\d*P,?", "", form.upper()))
    if stated is None:
        raise ValueError(f"form {form.strip()!r}")
    parts = [part for line in lines for part in line.split()]
    if len(parts) != count:  # Numbers may touch; those that do not are not always as wide as it is stated.
        width, most = int(stated[2]), int(stated[1] or 1)
        fields = (
            line[i : i + width] for line in lines for i in range(0, min(len(line), width * most), width)
        )
        parts = [part for part in fields if part.strip()]
    if len(parts) != count:
        raise ValueError(f"{len(parts)} of {count} numbers")
    return np.array(list(map(_fortran, parts)))


# -- Matrix Market files: a head, the sizes, and a line for each entry, all of which are counted and checked

_BYTES_OF_LETTER = 8  # of a text, in memory: its lines, and their numbers
_MARKET_HEAD = re.compile(
    r"%%matrixmarket\s+matrix\s+(array(?!\s+pattern)|coordinate)\s+(real|integer|double|pattern)"
    r"\s+(general|symmetric)"
)


def read_matrix_market(file: Path) -> dict[str, Labelled]:
    """The matrix of a file, under its stem."""
    from scipy.sparse import coo_array

    packed = file.suffix == ".gz"
    with (gzip.open if packed else open)(file, "rt", encoding="latin-1") as opened:
        text = opened.read(most_bytes(file) // _BYTES_OF_LETTER + 1 if packed else -1)
    if packed:
        bounded(file, _BYTES_OF_LETTER * len(text), "a packed text of as much or more")
    lines = [line for line in text.split("\n") if line.strip()]
    head = _MARKET_HEAD.fullmatch(lines[0].lower().strip()) if lines else None
    if head is None:
        raise ValueError(f"the head {''.join(lines[:1])[:80]!r}")
    sizes, *rows = [line for line in lines if not line.startswith("%")] or [""]
    form, kind, symmetry = head.groups()
    dense = form == "array"
    whole_ones = re.fullmatch(r"\s*(\d{1,18})\s+(\d{1,18})" + r"\s+(\d{1,18})" * (not dense) + r"\s*", sizes)
    n, n_columns, *stated = map(int, whole_ones.groups()) if whole_ones else (0, 0)
    if n != n_columns or not 0 < n < 2**31:
        raise ValueError(f"the sizes {sizes[:40]!r}")
    count = stated[0] if stated else n * n if symmetry == "general" else n * (n + 1) // 2
    if len(rows) != count or not text.endswith("\n"):
        end = "" if text.endswith("\n") else ", the last without a line end"
        raise ValueError(f"{len(rows)} of {count} entries{end}")
    width, n_places = 2 * (not dense) + (kind != "pattern"), 2 * (not dense)
    try:
        numbers = np.loadtxt(rows, comments=None, ndmin=2) if rows else np.empty((0, width))
    except ValueError as exc:  # behind a semicolon NumPy gives advice to its own callers
        raise ValueError(str(exc).partition(";")[0]) from None
    places = numbers[:, :n_places]
    odd = ((places < 1) | (places > n) | (places != np.floor(places))).any(axis=1)
    if numbers.shape[1] != width or odd.any():
        raise ValueError(f"the entry {rows[int(np.argmax(odd))][:40]!r}")
    values = np.ones(count) if kind == "pattern" else numbers[:, -1]
    if not dense:
        i, j = places.T.astype(np.int64) - 1
    else:  # column by column
        j, i = np.divmod(np.arange(count), n) if symmetry == "general" else np.triu_indices(n)
    if symmetry == "symmetric":
        whole = completed(i, j, values, n)
    else:
        whole = coo_array((values, (i, j)), shape=(n, n))
    return {file.stem: Labelled(whole.toarray() if dense else whole)}


# -- Matrices that Nastran's OUTPUT4 writes: text or binary, dense or sparse, of single or double precision
#
# A matrix is a header (columns, rows, form, type, name) and a record for each column that is not empty: its
# number, its first row or 0 where it is made of strings, and the count of words that follow. A string is a
# run of rows: its length and first row are two words where the header's rows are negative, else packed into
# one as row + 65536 (length + 1).

_HEADER = re.compile(r"^([ \d-]{8})([ \d-]{8})([ \d-]{8})([ \d-]{8})(.{8})(.*)$")
_WIDTH = re.compile(r"[EDG](\d+)\.\d+")
_PACKED = 65536

Run = tuple[int, int, NDArray[np.float64]]  # column, first row, values


def read_op4(file: Path) -> dict[str, Labelled]:
    """All matrices of a file, by name."""
    from scipy.sparse import coo_array

    content = file.read_bytes()
    binary = content[:4] in (b"\x18\0\0\0", b"\0\0\0\x18")
    found: dict[str, Labelled] = {}
    matrices = _binary(content) if binary else _text(content.decode("ascii").splitlines())
    for name, n_rows, n_columns, runs in matrices:
        whole = coo_array((n_rows, n_columns))
        if runs:
            rows = np.concatenate([np.arange(first, first + own.size) for _, first, own in runs])
            columns = np.concatenate([np.full(own.size, column) for column, _, own in runs])
            values = np.concatenate([own for _, _, own in runs])
            whole = coo_array((values, (rows, columns)), shape=(n_rows, n_columns))
        found[name] = Labelled(whole)
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
        if not 0 < 4 * words <= len(data) - at:
            raise ValueError(f"a string of {words} words in a record with {len(data) - at} bytes left")
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


#: What reads a format, and what its files should be, by their endings.
_ABAQUS = read_abaqus, "node, dof, node, dof, value, as FORMAT=MATRIX INPUT or LABELS write them"
_MARKET = read_matrix_market, "a whole Matrix Market file of a real square matrix"
_DMIG = read_dmig, "a punch file or bulk data with DMIG cards of real matrices (PARAM,EXTOUT,DMIGPCH)"
_BOEING = read_harwell_boeing, "a real assembled square matrix in Harwell-Boeing form (RSA or RUA)"
FORMATS: dict[str, tuple[Callable[[Path], dict[str, Labelled]], str]] = {
    ".npz": (read_sparse_npz, "a file of scipy.sparse.save_npz"),
    **dict.fromkeys((".mtx", ".mtx.gz", ".mm"), _MARKET),
    ".op4": (read_op4, "a whole file of OUTPUT4, of real matrices"),
    **dict.fromkeys((".pch", ".bdf", ".dmig"), _DMIG),
    ".full": (read_full, "a .full file with matrices, written by WRFULL"),
    **dict.fromkeys((".rsa", ".rua", ".hb"), _BOEING),
}


def matrices_in(name: str, path: PathLike) -> dict[str, Labelled]:
    """All matrices of a file, by name."""
    file = existing_file(path)
    ending = next((e for e in FORMATS if file.name.lower().endswith(e)), None)
    if ending is None:
        remedy = "Export the matrix in one of these formats, or pass it as a scipy.sparse array."
        reject(name, repr(str(file)), "a file that ends in " + ", ".join(FORMATS) + ", or a matrix", remedy)
    read, wanted = _ABAQUS if ending == ".mtx" and is_abaqus(file) else FORMATS[ending]
    try:
        found = read(file)
    except (AntiresError, PermissionError, MemoryError):
        raise
    except Exception as exc:  # of SciPy, of zlib, and of what a reader does with odd numbers
        unsuitable(file, f"which is cut, damaged or of another kind ({exc})", wanted)
    for each in found.values():
        n_dof = max(each.matrix.shape)
        bounded(file, BYTES_OF_DOF * n_dof, f"with {n_dof} dofs")
    if not found:
        unsuitable(file, "without a matrix", wanted)
    return found


def choose(name: str, path: PathLike, letter: str) -> Labelled:
    """The only matrix of a file, or the only one whose name begins with ``letter``."""
    found = matrices_in(name, path)
    own = list(found) if len(found) == 1 else [each for each in found if each.upper().startswith(letter)]
    if len(own) != 1:
        got = f"{str(path)!r} with the matrices {', '.join(found)}"
        wanted = f"a file with one matrix, or with one whose name begins with {letter}"
        reject(name, got, wanted, "Write the matrices into files of their own.")
    return found[own[0]]


FORMAT, VERSION = "antires_rs.matrices", 3  # 3 has names and groups of terms, and the mesh
#: Files that may hold stiffness and mass, by their names: K... and M...
OF_BOTH = (".op4", ".pch", ".bdf", ".dmig", ".full")


def read_matrices(
    stiffness: Any,
    mass: Any = None,
    *,
    stiffness_terms: Iterable[Any] | Mapping[str, Any] = (),
    mass_terms: Iterable[Any] | Mapping[str, Any] = (),
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
    stiffness_terms, mass_terms : sequence of the same, or mapping of names to them
        Contribution of each element or group that a parameter may scale.
    constraints, keep, dofs : optional
        As of :class:`MatrixModel`. ``dofs`` may be a file for :func:`~antires_rs.io.read_dof_map`;
        by default the names that a file of matrices gives its rows (DMIG cards, Abaqus, ANSYS).

    Returns
    -------
    MatrixModel

    Raises
    ------
    UnsuitableDataError, InvalidInputError
        A file that is cut, damaged or of another kind, or that would take more than 1 GB and its own size
        (the environment variable ``ANTIRES_MAX_BYTES`` allows more); matrices not square, symmetric and of
        one size.

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
        if not str(stiffness).lower().endswith(OF_BOTH):
            return _own(stiffness)
        mass = stiffness
    rows = _labelled("stiffness", stiffness, "K")

    def placed(name: str, given: Any, letter: str) -> Any:
        return in_rows_of(name, _labelled(name, given, letter), rows)

    terms: dict[str, Any] = {}
    for name, each, letter in (("stiffness_terms", stiffness_terms, "K"), ("mass_terms", mass_terms, "M")):
        items = each.items() if isinstance(each, Mapping) else enumerate(each)
        made = {key: placed(part(name, key), term, letter) for key, term in items}
        terms[name] = made if isinstance(each, Mapping) else list(made.values())
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
        As it was made: not one that came out of an updating, which its result keeps, nor of another kind.

    Returns
    -------
    pathlib.Path

    Examples
    --------
    >>> import tempfile, numpy as np, antires_rs as ar
    >>> spring = 500.0 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = ar.write_matrices(folder + "/model.npz", ar.MatrixModel(spring, np.eye(2)))
    ...     ar.read_matrices(file).n_dof
    2
    """
    if not isinstance(model, MatrixModel) or model.description.applied:
        got = "an updated model" if isinstance(model, MatrixModel) else type(model).__name__
        wanted = "a MatrixModel as it was made"
        reject("model", got, wanted, "Save the result of an updating with result.save.")
    store = Store()
    data = {"format": FORMAT, "version": VERSION, "recipe": encoded(model.description.recipe, store)}
    return write_store(path, data, store)


def read_dof_map(path: PathLike, *, first_row: int = 1) -> dict[tuple[int, str], int]:
    """Which row of the matrices belongs to which node and direction.

    Parameters
    ----------
    path : path-like
        Text with one line for each row: ``node direction`` in their order, or ``row node direction`` as in
        the mapping file of ANSYS, below any other lines. Directions are X, UX, +X, T1, 1; rotations RX, ROTX,
        R1, 4. Or a file of matrices that names them itself (DMIG cards, Abaqus).
    first_row : int
        Number of the first row in files that number them.

    Returns
    -------
    dict of (int, str) to int
        ``{(node, '+Z'): row}``, rows zero-based: the ``dofs=`` of :func:`~antires_rs.read_uff`.

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
    if file.name.lower().endswith((".mtx", *OF_BOTH)):
        several = matrices_in("path", file)
        points = (next(iter(several.values())) if len(several) == 1 else choose("path", file, "K")).points
        if points is None:
            wanted = "DMIG cards, Abaqus's *MATRIX OUTPUT, or a text with node and direction of each row"
            unsuitable(file, "which does not name its rows", wanted)
        return {(node, DIRECTIONS[code]): row for row, (node, code) in enumerate(points)}
    wanted = "a line 'node direction' or 'row node direction' for each row, each once"
    found: dict[tuple[int, str], int] = {}
    taken: set[int] = set()
    for number, line in enumerate(file.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        parts = re.split(r"[\s,;]+", line.strip())
        if not parts[-1] or parts[0].startswith(("#", "!", "$", "%")):
            continue
        code = NAMES.get(parts[-1].upper()) if all(p.isdigit() for p in parts[:-1]) else None
        row = int(parts[0]) - first_row if len(parts) == 3 and code is not None else len(found)
        if code is not None and len(parts) in (2, 3) and row >= 0 and row not in taken:
            taken.add(row)
            point = (int(parts[-2]), DIRECTIONS[code])
            if found.setdefault(point, row) == row:
                continue
        if found or code is not None:
            unsuitable(file, f"whose line {number} is {line.strip()!r}", wanted)
    if not found:
        unsuitable(file, "without such a line", wanted)
    return found


def _own(path: PathLike) -> MatrixModel:
    wanted = "a file of write_matrices"
    file, data = read_store(path, FORMAT, VERSION, wanted)
    with parts_of(file, wanted):
        if data["version"] == 1:
            recipe = recipe_1(data | dict(zip(("stiffness", "mass"), data["matrices"], strict=True)))
        else:
            recipe = decoded(data["recipe"], str(file))
        return MatrixModel.from_description(ModelDescription(within(recipe, file), ()))


def _labelled(name: str, given: Any, letter: str) -> Labelled:
    """A matrix, or the one of a file."""
    return choose(name, given, letter) if isinstance(given, str | os.PathLike) else Labelled(given)


def in_rows_of(name: str, each: Labelled, rows: Labelled) -> Any:
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
