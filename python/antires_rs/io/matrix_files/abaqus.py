"""Matrices that Abaqus writes with ``*MATRIX GENERATE`` and ``*MATRIX OUTPUT``: node, dof, node, dof, value.

Written as matrix input (with a line ``*MATRIX``) or as labels. A dof with a boundary condition has 1e36 on
its diagonal: it is left out, with a warning.
"""

from __future__ import annotations

from pathlib import Path

from ...support.warned import warn
from .._common import unsuitable
from .labelled import Labelled, Point, by_points

__all__ = ["is_abaqus", "read_abaqus"]

#: What stands on the diagonal of a dof with a boundary condition.
_FIXED = 1e35


def is_abaqus(file: Path) -> bool:
    """Whether the first line with data has node, dof, node, dof, value."""
    with file.open(encoding="ascii", errors="replace") as opened:
        for line in opened:
            if line.strip() and not line.startswith("*"):
                parts = line.split(",")
                return len(parts) == 5 and all(p.strip().lstrip("-").isdigit() for p in parts[:4])
    return False


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
            unsuitable(
                file,
                f"with the line {number}: {line.strip()[:40]!r}",
                "node, dof, node, dof, value",
                "Export it again with FORMAT=MATRIX INPUT or LABELS.",
            )
    fixed = {row for row, column, value in entries if row == column and value >= _FIXED}
    if fixed:
        first = ", ".join(f"{node}:{dof}" for node, dof in sorted(fixed)[:5])
        more = ", ..." if len(fixed) > 5 else ""
        warn(
            "dofs_on_supports",
            f"path: {str(file)!r} has {len(fixed)} dof(s) with a boundary condition, 1e36 on the diagonal "
            f"({first}{more}); they are left out.",
        )
    return {file.stem: by_points(file, [e for e in entries if e[0] not in fixed and e[1] not in fixed])}
