"""A matrix as a file holds it, and what its rows are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .._common import unsuitable

__all__ = ["Labelled", "by_points", "completed"]

#: Node and direction code, 1 to 6; 0 is a scalar.
Point = tuple[int, int]


@dataclass(frozen=True)
class Labelled:
    """A matrix (n, n), sparse or dense, and the node and direction of each row where the file tells them."""

    matrix: Any
    points: tuple[Point, ...] | None = None


def completed(rows: Any, columns: Any, values: Any, n: int) -> Any:
    """A symmetric matrix from its entries, of which the file may hold one triangle only."""
    from scipy.sparse import coo_array

    rows, columns = np.asarray(rows, dtype=np.int64), np.asarray(columns, dtype=np.int64)
    values = np.asarray(values, dtype=np.float64)
    beside = rows != columns
    if not ((rows > columns).any() and (rows < columns).any()):
        rows, columns, values = (
            np.concatenate([rows, columns[beside]]),
            np.concatenate([columns, rows[beside]]),
            np.concatenate([values, values[beside]]),
        )
    return coo_array((values, (rows, columns)), shape=(n, n))


def by_points(
    file: Path, entries: Sequence[tuple[Point, Point, float]], points: Sequence[Point] | None = None
) -> Labelled:
    """A matrix whose entries name node and direction; rows in ascending order of these."""
    if not entries:
        unsuitable(file, "without an entry", "a matrix", "Export it again.")
    found = sorted(set(points or ()) | {p for row, column, _ in entries for p in (row, column)})
    number = {point: nth for nth, point in enumerate(found)}
    rows = [number[row] for row, _, _ in entries]
    columns = [number[column] for _, column, _ in entries]
    values = [value for _, _, value in entries]
    return Labelled(completed(rows, columns, values, len(found)), tuple(found))
