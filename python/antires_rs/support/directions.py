"""Nodes and directions, as programs of tests and of finite elements call them."""

from __future__ import annotations

import re

#: Direction codes of universal files: translations, then rotations; 0 is a scalar.
DIRECTIONS = {
    0: "S",
    1: "+X",
    -1: "-X",
    2: "+Y",
    -2: "-Y",
    3: "+Z",
    -3: "-Z",
    4: "+RX",
    -4: "-RX",
    5: "+RY",
    -5: "-RY",
    6: "+RZ",
    -6: "-RZ",
}
CODES = {name: code for code, name in DIRECTIONS.items()}
#: As finite-element programs call them too.
NAMES = {
    **CODES,
    **{
        name: code
        for code, names in enumerate(
            ["1 UX T1 X U", "2 UY T2 Y V", "3 UZ T3 Z W", "4 ROTX R1", "5 ROTY R2", "6 ROTZ R3 THETA"], 1
        )
        for name in [*names.split(), DIRECTIONS[code][1:]]
    },
}
_POINT = re.compile(r"(?:NODE\s*)?(\d+)\s*[:._\s]?\s*([+-]?[A-Z]+\d?|(?<=[:._\s])\d)", re.IGNORECASE)


def point_of(label: str) -> tuple[int, int] | None:
    """Node and direction code of ``'1204:Z'``, ``'1204+Z'``, ``'1204 UZ'`` or ``'1204:3'``, if it is one."""
    found = _POINT.fullmatch(label.strip())
    code = None if found is None else NAMES.get(found[2].upper())
    return None if found is None or code is None else (int(found[1]), code)
