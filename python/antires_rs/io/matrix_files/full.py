"""Stiffness and mass of an ANSYS ``.full`` file, read by the package ansys-mapdl-reader."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .._common import missing_package, unsuitable
from .labelled import Labelled, Point, completed

__all__ = ["read_full"]


def read_full(file: Path) -> dict[str, Labelled]:
    """``K`` and ``M`` of a file, of the dofs without constraints."""
    try:
        from ansys.mapdl.reader import read_binary
    except ImportError as exc:
        raise missing_package("Reading .full files", "ansys-mapdl-reader", "ansys", exc) from exc
    try:
        points, stiffness, mass = read_binary(str(file)).load_km(as_sparse=True, sort=False)
    except Exception as exc:  # the package tells no family of its own
        unsuitable(
            file, f"which cannot be read ({exc})", "a .full file with matrices", "Write it with WRFULL."
        )
    stiffness, mass = stiffness.tocoo(), mass.tocoo()
    # Dofs with constraints are there, without an entry.
    kept = np.flatnonzero(np.isin(np.arange(len(points)), [*stiffness.row, *mass.row]))
    # The directions of ANSYS count from 0: UX, UY, UZ, ROTX, ROTY, ROTZ.
    named: tuple[Point, ...] = tuple((int(node), int(code) + 1) for node, code in points[kept])
    row = np.cumsum(np.isin(np.arange(len(points)), kept)) - 1
    return {
        name: Labelled(completed(row[each.row], row[each.col], each.data, len(named)), named)
        for name, each in (("K", stiffness), ("M", mass))
    }
