"""Stiffness and mass of any finite-element program: from its files, or matrices themselves.

The rows are the model's dofs. :func:`read_dof_map` reads which node and direction each of them is; what it
returns fits ``dofs=`` of :func:`~antires_rs.io.uff.read_uff`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import part, reject
from ..models.matrix_model import MatrixModel
from ..models.recipes import MatrixRecipe
from ..models.structural_model import ModelDescription
from ..support.directions import DIRECTIONS, NAMES
from .archive import Store, decoded, encoded, read_store, recipe_1, write_store
from .common import existing_file, unsuitable
from .matrix_formats import (
    Labelled,
    is_abaqus,
    is_matrix_market,
    read_abaqus,
    read_dmig,
    read_full,
    read_harwell_boeing,
    read_matrix_market,
    read_op4,
    read_sparse_npz,
)

# -- Matrices in the files of finite-element programs: a reader for each format, chosen by the ending


_READERS: dict[str, Callable[[Path], dict[str, Labelled]]] = {
    ".npz": read_sparse_npz,
    ".mtx": read_matrix_market,
    ".mtx.gz": read_matrix_market,
    ".mm": read_matrix_market,
    ".op4": read_op4,
    ".pch": read_dmig,
    ".bdf": read_dmig,
    ".dmig": read_dmig,
    ".full": read_full,
    ".rsa": read_harwell_boeing,
    ".rua": read_harwell_boeing,
    ".hb": read_harwell_boeing,
}


def matrices_in(name: str, path: str | os.PathLike[str]) -> dict[str, Labelled]:
    """All matrices of a file, by name."""
    file = existing_file(path)
    ending = next((e for e in _READERS if file.name.lower().endswith(e)), None)
    if ending is None:
        remedy = "Export the matrix in one of these formats, or pass it as a scipy.sparse array."
        reject(name, repr(str(file)), "a file that ends in " + ", ".join(_READERS) + ", or a matrix", remedy)
    if ending == ".mtx" and not is_matrix_market(file) and is_abaqus(file):
        return read_abaqus(file)
    return _READERS[ending](file)


def choose(name: str, path: str | os.PathLike[str], letter: str) -> Labelled:
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

    terms = [
        [placed(part(name, i), term, letter) for i, term in enumerate(each)]
        for name, each, letter in (("stiffness_terms", stiffness_terms, "K"), ("mass_terms", mass_terms, "M"))
    ]
    if isinstance(dofs, str | os.PathLike):
        dofs = read_dof_map(dofs)
    elif dofs is None and rows.points is not None:
        dofs = rows.points
    return MatrixModel(
        rows.matrix,
        placed("mass", mass, "M"),
        stiffness_terms=terms[0],
        mass_terms=terms[1],
        constraints=constraints,
        keep=tuple(keep),
        dofs=dofs,
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
        got = "an updated model" if isinstance(model, MatrixModel) else type(model).__name__
        wanted = "a MatrixModel as it was made"
        reject("model", got, wanted, "Save the result of an updating with result.save.")
    store = Store()
    data = {"format": FORMAT, "version": VERSION, "recipe": encoded(recipe, store)}
    return write_store(path, data, store)


def read_dof_map(path: str | os.PathLike[str], *, first_row: int = 1) -> dict[tuple[int, str], int]:
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
        return _own_map(file)
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


def _own_map(file: Path) -> dict[tuple[int, str], int]:
    """Of a file of matrices."""
    found = matrices_in("path", file)
    points = (next(iter(found.values())) if len(found) == 1 else choose("path", file, "K")).points
    if points is None:
        got = "which does not name its rows"
        wanted = "DMIG cards, Abaqus's *MATRIX OUTPUT, or a text with node and direction of each row"
        unsuitable(file, got, wanted, "Write the table of equations beside the matrices.")
    return {(node, DIRECTIONS[code]): row for row, (node, code) in enumerate(points)}


def _own(path: str | os.PathLike[str]) -> MatrixModel:
    file, data = read_store(path, FORMAT, VERSION, "a file of write_matrices")
    if data["version"] == 1:
        stiffness, mass = data["matrices"]
        recipe = recipe_1({**data, "stiffness": stiffness, "mass": mass})
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
