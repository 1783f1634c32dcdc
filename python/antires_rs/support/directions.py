"""Nodes and directions, as programs of tests and of finite elements call them."""

from __future__ import annotations

import re

#: Direction codes of universal files: translations, then rotations; 0 is a scalar.
DIRECTIONS = {0: "S"} | {
    sign * code: f"{'+' if sign > 0 else '-'}{axis}"
    for code, axis in enumerate(("X", "Y", "Z", "RX", "RY", "RZ"), 1)
    for sign in (1, -1)
}
CODES = {name: code for code, name in DIRECTIONS.items()}
#: As finite-element programs call them too.
_OTHERS = ["1 UX T1 X U", "2 UY T2 Y V", "3 UZ T3 Z W", "4 ROTX R1 RX", "5 ROTY R2 RY", "6 ROTZ R3 RZ THETA"]
NAMES = CODES | {name: code for code, names in enumerate(_OTHERS, 1) for name in names.split()}
_POINT = re.compile(r"(?:NODE\s*)?(\d+)\s*[:._\s]?\s*([+-]?[A-Z]+\d?|(?<=[:._\s])\d)", re.IGNORECASE)


def point_of(label: str) -> tuple[int, int] | None:
    """Node and direction code of ``'1204:Z'``, ``'1204+Z'``, ``'1204 UZ'`` or ``'1204:3'``, if it is one."""
    found = _POINT.fullmatch(label.strip())
    code = None if found is None else NAMES.get(found[2].upper())
    return None if found is None or code is None else (int(found[1]), code)
