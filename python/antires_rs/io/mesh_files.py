"""Meshes of other programs, for pictures and places of models whose code gives none."""

from __future__ import annotations

import warnings
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import AntiresError, reject
from ..models.term_groups import Mesh
from ..support.checks import shape_of
from .calculix import Deck
from .common import brief, existing_file, require, unsuitable
from .options import PathLike

__all__ = ["read_mesh"]

_WANTED = "a mesh with lines, surfaces or solids, in a format of meshio"


def read_mesh(path: PathLike, *, nodes: Any = None) -> Mesh:
    """A mesh that another program has written: Gmsh, Nastran, ANSYS, MED, VTK, and what else meshio reads.

    Parameters
    ----------
    path : path-like
        Files ``.inp`` are read as inputs of CalculiX, without meshio.
    nodes : sequence of int, optional
        Number of each node, in the order of the file, by which dofs of a model, ``"12:Z"``, are found.
        Default: those of the file where meshio keeps them, as of Nastran, else 1, 2, ...

    Returns
    -------
    Mesh
        For :func:`~antires_rs.read_model` and :class:`~antires_rs.MatrixModel`.

    Raises
    ------
    MissingDependencyError
        meshio is not installed.
    UnsuitableDataError
        A file without elements, or that meshio cannot read.

    Examples
    --------
    >>> import tempfile, pathlib, antires_rs as ar
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "bar.inp"
    >>> bar = "*NODE\\n5, 0.\\n9, 2.\\n*ELEMENT, TYPE=T3D2, ELSET=BAR\\n1, 5, 9\\n*MATERIAL, NAME=M\\n"
    >>> _ = file.write_text(bar + "*SOLID SECTION, ELSET=BAR, MATERIAL=M\\n1e-4\\n")
    >>> ar.io.read_mesh(file).place(9)
    array([2., 0., 0.])
    """
    file = existing_file(path)
    if file.suffix.lower() == ".inp":
        if nodes is not None:
            reject("nodes", "numbers for an input of CalculiX", "none", "Leave them out: it has its own.")
        return Deck(file).mesh()
    require("Reading meshes", "meshio", "mesh")
    read = _read(file)
    blocks = [block for block in read.cells if block.type != "vertex"]
    if not blocks:
        unsuitable(file, "without elements", _WANTED)
    places = np.asarray(read.points, dtype=np.float64)
    places = np.pad(places, ((0, 0), (0, 3 - places.shape[1])))
    for block in blocks:
        if block.type.startswith("polyhedron"):
            unsuitable(file, "with polyhedra", _WANTED)
        if not np.isin(block.data, range(len(places))).all():
            unsuitable(file, f"with nodes of a {block.type} that it has not", _WANTED)
    given = getattr(read, "points_id", range(1, len(places) + 1)) if nodes is None else nodes
    if shape_of(given) != (len(places),) or not all(isinstance(node, int | np.integer) for node in given):
        reject("nodes", given, f"a whole number for each of {len(places)} nodes", "In the order of the file.")
    numbers = np.asarray(given)
    counts = [len(block.data) for block in blocks]
    connectivity = np.full((sum(counts), max(block.data.shape[1] for block in blocks)), -1)
    for first, block in zip(np.cumsum([0, *counts]), blocks, strict=False):
        connectivity[first : first + len(block.data), : block.data.shape[1]] = numbers[block.data]
    kinds = tuple(dict.fromkeys(block.type for block in blocks))
    kind = np.repeat([kinds.index(block.type) for block in blocks], counts)
    return Mesh(numbers, places, np.arange(1, sum(counts) + 1), connectivity, kinds, kind)


def _read(file: Path) -> Any:
    """What meshio reads; it says its errors and ends the program."""
    import meshio

    said = StringIO()
    try:
        with warnings.catch_warnings(), redirect_stdout(said), redirect_stderr(said):
            warnings.simplefilter("ignore")
            return meshio.read(file)
    except (AntiresError, PermissionError, MemoryError):
        raise
    except SystemExit:
        unsuitable(file, "which no reader of meshio takes", _WANTED)
    except Exception as exc:
        unsuitable(file, f"which meshio cannot read ({brief(exc)})", _WANTED)
