"""Names of dofs: nodes and directions as programs call them, and which dof a name means."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from ..exceptions import part, reject
from .checks import integer

DIRECTIONS = {0: "S"} | {  #: Direction codes of universal files: translations, then rotations; 0 is a scalar.
    sign * code: f"{'+' if sign > 0 else '-'}{axis}"
    for code, axis in enumerate(("X", "Y", "Z", "RX", "RY", "RZ"), 1)
    for sign in (1, -1)
}
CODES = {name: code for code, name in DIRECTIONS.items()}
#: As finite-element programs call them too.
_OTHERS = ["1 UX T1 X U", "2 UY T2 Y V", "3 UZ T3 Z W", "4 ROTX R1 RX", "5 ROTY R2 RY", "6 ROTZ R3 RZ THETA"]
NAMES = CODES | {name: code for code, names in enumerate(_OTHERS, 1) for name in names.split()}
_POINT = re.compile(
    r"(?:NODE\s*)?(\d+)\s*[:._\s]?\s*(?:DIRECTION\s+)?([+-]?[A-Z]+\d?|(?<=[:._\s])\d)", re.IGNORECASE
)


def point_of(label: str) -> tuple[int, int] | None:
    """Node and direction code of ``'1204:Z'``, ``'1204+Z'``, ``'1204 UZ'`` or ``'1204:3'``, if it is one."""
    found = _POINT.fullmatch(label.strip())
    code = None if found is None else NAMES.get(found[2].upper())
    return None if found is None or code is None else (int(found[1]), code)


def refuse_point(excitation: Sequence[Any], channels: Iterable[Any]) -> None:
    """Refuse (4, "u") for several forces: a node and its direction are one dof, whose name is a text."""
    point = point_of("{}:{}".format(*excitation)) if len(excitation) == 2 else None
    if point and isinstance(excitation[1], str) and not {*excitation} & {*channels}:
        got = f"{tuple(excitation)}, two forces at dofs {excitation[0]!r} and {excitation[1]!r}, no channels"
        remedy = f'A node and its direction are one text: "node {excitation[0]} {excitation[1]}".'
        reject("excitation", got, "a channel, or a list of them", remedy)


_OFFERED = 4  # so many names are offered instead of an unknown one


class DofNames:
    """The dof of each name: the name itself, or its node and direction however they are written."""

    def __init__(self, labels: Sequence[str], fixed: Sequence[str] = ()) -> None:
        self._fixed = {point_of(label) for label in fixed}
        self._dof = {label: dof for dof, label in enumerate(labels)}
        self._at: dict[tuple[int, int], int] = {}
        for dof, label in enumerate(labels):
            point = point_of(label)
            if point is not None:
                self._at.setdefault(point, dof)

    def find(self, name: str, label: str) -> int:
        """Its zero-based number; an unknown one is refused, with those that are near."""
        dof = self._dof.get(label)
        point = point_of(label)
        if dof is None and point is not None:
            dof = self._at.get(point)
        if dof is not None:
            return dof
        if point is not None and point in self._fixed:
            remedy = "A fixed dof does not move: it has no response, and a force on it does nothing."
            reject(name, f"{label!r}, which is fixed", "a free dof", remedy)
        listed = list(self._dof)
        of_node = [listed[d] for (node, _), d in self._at.items() if point and node == point[0]]
        near = (of_node or get_close_matches(label, listed, _OFFERED, 0.5) or listed)[:_OFFERED]
        wanted = f"a dof of the model: its zero-based number, 0 to {len(listed) - 1}, or its name"
        reject(name, repr(label), wanted, f"Names of the model are like {', '.join(map(repr, near))}.")


def names_of(name: str, given: Any, n: int) -> tuple[str, ...]:
    """Names of ``n`` dofs, each once, from what a caller gave; none where that is None."""
    if given is None:
        return ()
    if isinstance(given, Mapping):
        by_row = {integer(part(name, key), row, low=0, high=n - 1): key for key, row in given.items()}
        labels: Iterable[Any] = (by_row.get(row, f"dof {row}") for row in range(n))
    elif isinstance(given, str) or not isinstance(given, Iterable):
        wanted = f"{n} names, or a mapping of names to rows"
        reject(name, given, wanted, "read_dof_map returns such a mapping.")
    else:
        labels = given
    made = tuple(_text(part(name, i), label) for i, label in enumerate(labels))
    if len(made) != n:
        reject(name, f"{len(made)} names", f"{n}, one for each row of the matrices", "Name all, in order.")
    if len(set(made)) < n:
        twice = next(label for label in made if made.count(label) > 1)
        reject(name, f"{twice!r} more than once", "a name of its own for each row", "Rename one of them.")
    at: dict[tuple[int, int], str] = {}
    for label in made:
        point = point_of(label)
        if point is not None and at.setdefault(point, label) != label:
            got = f"{at[point]!r} and {label!r}, two spellings of one name"
            reject(name, got, "a name of its own for each row", "Rename one of them.")
    return made


def _text(name: str, label: Any) -> str:
    """``'1204:Z'`` for (1204, '+Z') and (1204, 3); a text stays what it is."""
    if isinstance(label, str) and label.strip():
        return label.strip()
    if isinstance(label, tuple) and len(label) == 2:
        point = point_of(f"{label[0]}:{label[1]}")
        if point is not None:
            direction = DIRECTIONS[point[1]].removeprefix("+")
            return f"{point[0]}" if direction == "S" else f"{point[0]}:{direction}"
    wanted = "a text, or a node and a direction such as (1204, '+Z')"
    reject(name, label, wanted, "Directions are +X to -RZ, or 1 to 6.")
