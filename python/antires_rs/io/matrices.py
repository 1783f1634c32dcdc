"""Stiffness and mass of any finite-element program: Matrix Market, npz, or matrices themselves.

The rows are the model's dofs. :func:`read_dof_map` reads which node and direction each of them is; what it
returns fits ``dofs=`` of :func:`~antires_rs.io.read_uff`.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from ..models.matrix_model import MatrixModel
from ..models.recipes import MatrixRecipe
from ..support.validation import part, reject
from ._common import existing_file, unsuitable
from ._store import Store, read_store, write_store
from .npz import read_archive
from .uff_names import CODES, DIRECTIONS

__all__ = ["read_dof_map", "read_matrices", "write_matrices"]

FORMAT, VERSION = "antires_rs.matrices", 1
#: As finite-element programs call directions.
_NAMES = {
    **CODES,
    **{
        name: code
        for code, names in enumerate(
            ("1 UX T1 X", "2 UY T2 Y", "3 UZ T3 Z", "4 ROTX R1 RX", "5 ROTY R2 RY", "6 ROTZ R3 RZ"), 1
        )
        for name in names.split()
    },
}


def read_matrices(
    stiffness: Any, mass: Any = None, *, stiffness_terms: Iterable[Any] = (), mass_terms: Iterable[Any] = ()
) -> MatrixModel:
    """A model from matrices in files.

    Parameters
    ----------
    stiffness, mass : path-like, array_like or scipy.sparse
        Files in Matrix Market form (``.mtx``, ``.mtx.gz``) or of ``scipy.sparse.save_npz``; or the matrices
        themselves. Without ``mass``, a file of :func:`write_matrices`.
    stiffness_terms, mass_terms : sequence of the same
        Contribution of each element or group that a parameter may scale.

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
            reject("mass", None, "the mass matrix", "Only a file of write_matrices holds both.")
        return _own(stiffness)
    terms = [
        [_matrix(part(name, i), term) for i, term in enumerate(each)]
        for name, each in (("stiffness_terms", stiffness_terms), ("mass_terms", mass_terms))
    ]
    return MatrixModel(
        _matrix("stiffness", stiffness), _matrix("mass", mass), stiffness_terms=terms[0], mass_terms=terms[1]
    )


def write_matrices(path: str | os.PathLike[str], model: MatrixModel) -> Path:
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
        reject(
            "model",
            "an updated model" if isinstance(model, MatrixModel) else type(model).__name__,
            "a MatrixModel as it was made",
            "Save the result of an updating with result.save.",
        )
    store = Store()
    matrices = [[store.put(part) for part in matrix] for matrix in (recipe.stiffness, recipe.mass)]
    terms = [
        [[store.put(part) for part in term] for term in each]
        for each in (recipe.stiffness_terms, recipe.mass_terms)
    ]
    return write_store(
        path,
        {"format": FORMAT, "version": VERSION, "n_dof": model.n_dof, "matrices": matrices, "terms": terms},
        store,
    )


def read_dof_map(path: str | os.PathLike[str], *, first_row: int = 1) -> dict[tuple[int, str], int]:
    """Which row of the matrices belongs to which node and direction.

    Parameters
    ----------
    path : path-like
        Text with one line for each row: ``node direction`` in the order of the rows, or ``row node
        direction`` as in the mapping file of ANSYS. Directions are X, UX, +X, T1, 1; rotations RX, ROTX, R1,
        4.
        Other lines above the first of these are skipped.
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
    file, wanted = existing_file(path), "a line 'node direction' or 'row node direction' for each row"
    found: dict[tuple[int, str], int] = {}
    for number, line in enumerate(file.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        parts = line.replace(",", " ").replace(";", " ").split()
        if not parts or line.lstrip().startswith(("#", "!", "$", "%")):
            continue
        code = _NAMES.get(parts[-1].upper())
        whole = len(parts) in (2, 3) and code is not None and all(p.isdigit() for p in parts[:-1])
        if not whole:
            if found:
                unsuitable(file, f"whose line {number} is {line.strip()!r}", wanted, "Correct that line.")
            continue
        row = int(parts[0]) - first_row if len(parts) == 3 else len(found)
        point = (int(parts[-2]), DIRECTIONS[code])  # type: ignore[index]
        if point in found or row in found.values() or row < 0:
            unsuitable(
                file,
                f"with {point} or row {row + first_row} twice or out of range in line {number}",
                "each once, rows from first_row on",
                "Correct that line of the map, or first_row.",
            )
        found[point] = row
    if not found:
        unsuitable(file, "without such a line", wanted, "Export it with its header.")
    return found


def _own(path: str | os.PathLike[str]) -> MatrixModel:
    _, data = read_store(path, FORMAT, VERSION, "a file of write_matrices")
    n = data["n_dof"]
    stiffness, mass = (_sparse(entries, n) for entries in data["matrices"])
    terms = [[_sparse(term, n) for term in each] for each in data["terms"]]
    return MatrixModel(stiffness, mass, stiffness_terms=terms[0], mass_terms=terms[1])


def _sparse(entries: Any, n: int) -> Any:
    from scipy.sparse import coo_array

    rows, columns, values = entries
    return coo_array((values, (rows, columns)), shape=(n, n))


def _matrix(name: str, given: Any) -> Any:
    """A matrix, or the one of a file."""
    if not isinstance(given, str | os.PathLike):
        return given
    file = existing_file(given)
    if file.suffix == ".npz":
        return _sparse_npz(file)
    if file.name.endswith((".mtx", ".mtx.gz", ".mm")):
        return _matrix_market(file)
    return reject(
        name,
        repr(str(file)),
        "a file that ends in .mtx, .mtx.gz or .npz, or a matrix",
        "Export the matrix in one of these formats, or pass it as a scipy.sparse array.",
    )


def _sparse_npz(file: Path) -> Any:
    from scipy.sparse import load_npz

    arrays = read_archive(file)  # every checksum is compared before scipy sees it
    if "format" not in arrays or "shape" not in arrays:
        unsuitable(
            file,
            f"with the arrays {', '.join(arrays)}",
            "a file of scipy.sparse.save_npz",
            "Save it by scipy.sparse.save_npz.",
        )
    return load_npz(file)


def _matrix_market(file: Path) -> Any:
    """A Matrix Market file, its entries counted against its header."""
    import gzip
    from io import BytesIO

    from scipy.io import mmread

    wanted = "a whole Matrix Market file"
    try:
        with (gzip.open if file.suffix == ".gz" else open)(file, "rb") as opened:
            text = opened.read()
    except (OSError, EOFError) as exc:
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
        # Not the file: what SciPy reads is what was looked at here.
        return mmread(BytesIO(b"\n".join([*head, *numbers[1:], b""])))
    except (ValueError, OverflowError, TypeError) as exc:
        unsuitable(
            file,
            f"which cannot be read ({exc})",
            wanted,
            "Export it again, as real numbers in MatrixMarket format.",
        )


def _head(words: Sequence[bytes], sizes: Sequence[bytes]) -> tuple[list[bytes], int]:
    """Both lines of the head, and the entries that they state; ValueError for any other head."""
    if len(words) != 5 or words[1] != b"matrix":
        raise ValueError("unknown head")
    if len(sizes) != {b"coordinate": 3, b"array": 2}.get(words[2]) or not all(map(bytes.isdigit, sizes)):
        raise ValueError("no sizes")
    n, columns, *entries = map(int, sizes)
    if n != columns or n < 1:  # SciPy would write beyond its memory
        raise ValueError("not square")
    half = n * (n + 1) // 2
    stored = {b"general": n * n, b"symmetric": half, b"hermitian": half, b"skew-symmetric": half - n}
    if words[4] not in stored:
        raise ValueError("unknown symmetry")
    lines = [b" ".join([b"%%MatrixMarket", *words[1:]]), b" ".join(sizes)]
    return lines, entries[0] if entries else stored[words[4]]


def _entry(words: Sequence[bytes]) -> re.Pattern[bytes]:
    """A line of numbers. At some others, a NUL behind one in a symmetric array, SciPy ends the process."""
    places = 2 * (words[2] == b"coordinate") + {b"pattern": 0, b"complex": 2}.get(words[3], 1)
    number = rb"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?|inf|infinity|nan)"
    return re.compile(rb"[ \t\r]*" + rb"[ \t]+".join([number] * places) + rb"[ \t\r]*", re.IGNORECASE)
