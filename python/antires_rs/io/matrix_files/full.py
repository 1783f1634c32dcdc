"""Stiffness and mass of an ANSYS ``.full`` file, read by ansys-mapdl-reader in a child process."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import numpy as np

from .._common import missing_package, unsuitable
from ..child import Asked, in_a_child
from .labelled import Labelled, Point, completed

__all__ = ["read_full"]

_WANTED = "a .full file with matrices, written by WRFULL"
_TIME_LIMIT_S, _MEMORY_LIMIT_GB = 600.0, 16.0


def read_full(file: Path) -> dict[str, Labelled]:
    """``K`` and ``M`` of a file, of the dofs without constraints."""
    try:
        there = find_spec("ansys.mapdl.reader") is not None
    except ModuleNotFoundError:  # of a package above it
        there = False
    if not there:
        raise missing_package(
            "Reading .full files", "ansys-mapdl-reader", "ansys", ImportError("ansys-mapdl-reader")
        )
    # The package is compiled: a damaged file can end or fill the interpreter that reads it.
    arrays = in_a_child(
        "full", file, Asked(), _WANTED, time_limit_s=_TIME_LIMIT_S, memory_limit_gb=_MEMORY_LIMIT_GB
    ).arrays
    points = arrays["points"]
    rows, columns = ([arrays[f"{name}.{axis}"] for name in "KM"] for axis in ("row", "col"))
    if any(each.size and not 0 <= each.min() <= each.max() < len(points) for each in (*rows, *columns)):
        unsuitable(
            file, f"with entries beyond its {len(points)} dofs", _WANTED, "It was damaged: write it again."
        )
    # Dofs with constraints are there, without an entry.
    kept = np.flatnonzero(np.isin(np.arange(len(points)), [*rows[0], *rows[1]]))
    # The directions of ANSYS count from 0: UX, UY, UZ, ROTX, ROTY, ROTZ.
    named: tuple[Point, ...] = tuple((int(node), int(code) + 1) for node, code in points[kept])
    place = np.cumsum(np.isin(np.arange(len(points)), kept)) - 1
    return {
        name: Labelled(completed(place[row], place[column], arrays[f"{name}.data"], len(named)), named)
        for name, row, column in zip("KM", rows, columns, strict=True)
    }
