"""Names of the universal file's points: node and direction, ``12+Z``, and back."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from ..support.directions import CODES, DIRECTIONS
from ..support.validation import reject
from ..support.wording import LeftOut, Wording

__all__ = ["CODES", "DIRECTIONS", "Point", "as_point", "dof_of", "label_of", "points_of"]

_LABEL = re.compile(r"^(\d+)(S|[+-]R?[XYZ])$")

#: Node and direction code.
Point = tuple[int, int]


def label_of(point: Point) -> str:
    """``'12+Z'`` of (12, 3)."""
    return f"{point[0]}{DIRECTIONS.get(point[1], f'?{point[1]}')}"


def as_point(argument: str, value: Any) -> Point:
    """(12, 3) of ``(12, '+Z')``, ``(12, 'Z')``, ``(12, 3)`` or ``'12+Z'``."""
    if isinstance(value, str) and (match := _LABEL.match(value.upper())):
        return int(match[1]), CODES[match[2]]
    if isinstance(value, tuple) and len(value) == 2 and isinstance(value[0], int) and value[0] >= 0:
        direction = value[1]
        if isinstance(direction, str):
            for name in (direction.upper(), "+" + direction.upper()):
                if name in CODES:
                    return value[0], CODES[name]
        elif direction in DIRECTIONS:
            return value[0], int(direction)
    reject(
        argument,
        repr(value),
        "a node and a direction, such as (12, '+Z'), (12, 3) or '12+Z'",
        "Directions are +X to -Z, or 1 to 6 with a sign.",
    )


def dof_of(dofs: Any, own: Mapping[Point, Any]) -> Callable[[Point], tuple[Any, float]]:
    """Function from a point to the user's dof and the sign that turns the channel into that dof.

    A mapping that has ``12+Z`` and not ``12-Z`` takes a channel in ``-Z`` with its sign changed. ``own`` are
    the dofs of a file of ours.
    """
    if dofs is None:
        return lambda point: (own.get(point, label_of(point)), 1.0)
    if isinstance(dofs, Mapping):
        table = {as_point("dofs", key): dof for key, dof in dofs.items()}

        def look_up(point: Point) -> tuple[Any, float]:
            if point in table:
                return table[point], 1.0
            opposite = (point[0], -point[1])
            if opposite in table:
                return table[opposite], -1.0
            reject(
                "dofs",
                f"no dof for {label_of(point)}",
                "a dof for every response of the file",
                Wording("{}; antires_rs.io.list_uff shows all points.", LeftOut("point")),
            )

        return look_up
    if callable(dofs):
        return lambda point: (dofs(point[0], DIRECTIONS.get(point[1], "?")), 1.0)
    reject(
        "dofs",
        type(dofs).__name__,
        "a mapping {(node, direction): dof} or a function of the two",
        "List the points with antires_rs.io.list_uff.",
    )


def points_of(dofs: tuple[Any, ...], given: Any) -> dict[Any, Point]:
    """Node and direction of each dof, for writing: given, read from the label, or numbered."""
    points: dict[Any, Point] = {}
    for dof in dofs:
        if isinstance(given, Mapping):
            if dof not in given:
                reject(
                    "dofs", f"no node and direction for {dof!r}", f"one for each of {dofs}", "Add it to dofs."
                )
            points[dof] = as_point("dofs", given[dof])
        elif callable(given):
            points[dof] = as_point("dofs", given(dof))
        elif given is not None:
            reject(
                "dofs",
                type(given).__name__,
                "a mapping {dof: (node, direction)} or a function of the dof",
                "Or name the dofs so: '12+Z'.",
            )
        elif isinstance(dof, str) and (match := _LABEL.match(dof)):
            points[dof] = int(match[1]), CODES[match[2]]
        elif isinstance(dof, int) and 0 <= dof < 999_999_999:
            points[dof] = dof + 1, 0
    free = max((node for node, _ in points.values()), default=0) + 1
    for dof in (d for d in dofs if d not in points):
        points[dof], free = (free, 0), free + 1
    if len(set(points.values())) != len(points):
        twice = [p for p in points.values() if list(points.values()).count(p) > 1][0]
        reject(
            "dofs",
            f"{label_of(twice)} for two dofs",
            "a point of its own for each",
            "Give one of them another node or direction.",
        )
    return points
