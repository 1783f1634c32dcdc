"""Columns of text that are one complex response together: two parts of it, or magnitude and phase."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..support.validation import choice
from ..support.wording import Passed, Wording
from ._common import unsuitable
from .units import parse_unit

__all__ = ["PAIRS", "is_part_unit", "joined", "part_of"]

#: What two neighbouring columns may be.
PAIRS = ("real_imag", "magnitude_deg", "magnitude_rad", "db_deg", "db_rad")
_WORDS = {
    "re": ("re", "real"),
    "im": ("im", "imag", "imaginary"),
    "mag": ("mag", "magnitude", "amp", "ampl", "amplitude", "abs", "modulus"),
    "phase": ("phase", "angle", "arg"),
}
_PART = {word: part for part, words in _WORDS.items() for word in words}
_ANY = "|".join(sorted(_PART, key=len, reverse=True))
_NAME = re.compile(
    rf"^(?:(?P<w1>{_ANY})(?: part)?(?:[ _.(]+(?P<b1>.+?)\)?)?|(?P<b2>.+?)[ _.]+(?P<w2>{_ANY})(?: part)?)$",
    re.IGNORECASE,
)
_ANGLES = {
    **dict.fromkeys(("deg", "degree", "degrees", "°"), "deg"),
    **dict.fromkeys(("rad", "radian", "radians"), "rad"),
}
_LINEAR = ("lin", "linear", "abs")
_PER_TURN = {"deg": np.pi / 180.0, "rad": 1.0}


class Part(NamedTuple):
    """One column: which part it is, of which response, in which unit."""

    part: str
    base: str
    unit: str


def is_part_unit(text: str) -> bool:
    """Whether the text is a unit that only magnitudes and phases have."""
    return text.strip().lower() in _ANGLES or _is_level(text)


def part_of(name: str, unit: str = "") -> Part | None:
    """What the name of a column says; None for any other."""
    match = _NAME.match(name.strip())
    if match is None:
        return None
    base = (match["b1"] or match["b2"] or "").strip()
    if base and not unit and is_part_unit(base):
        base, unit = "", base
    return Part(_PART[(match["w1"] or match["w2"]).lower()], base, unit)


def joined(
    file: Path, names: list[str], units: list[str], columns: list[Any], pairs: str | None, over_freq: bool
) -> tuple[list[str], list[str], list[Any]]:
    """Names, units and values with every pair made one column; its name is '' where the pair has none.

    ``pairs``, one of ``PAIRS``, says what all columns but the first are. Without it the names have to; a
    magnitude and a phase are one response only ``over_freq``.
    """
    if pairs is not None:
        choice("pairs", pairs, PAIRS)
        if len(columns) % 2 == 0:
            unsuitable(
                file,
                f"with {len(columns) - 1} columns beside the first",
                Wording("two for each response, as {} says", Passed("pairs", pairs)),
                "Export both parts of every response.",
            )
    out: tuple[list[str], list[str], list[Any]] = ([], [], [])
    i = 0
    while i < len(columns):
        here, after = (part_of(names[j], units[j]) if j < len(names) else None for j in (i, i + 1))
        named = here is not None and after is not None and here.base == after.base
        kinds = (here.part, after.part) if named and here and after else None
        name, unit, column, step = names[i], units[i], columns[i], 1
        if pairs is not None and i > 0:
            made = pairs
        elif kinds == ("re", "im"):
            made = "real_imag"
        elif kinds == ("mag", "phase") and over_freq and here and after:
            made = _said(file, names[i : i + 2], here.unit, after.unit)
        else:
            made = ""
        if made:
            name = here.base if here is not None and named else ("" if here else names[i])
            plain = here is not None and (is_part_unit(here.unit) or here.unit.lower() in _LINEAR)
            unit = "" if made.startswith("db") or plain else unit
            column, step = _complex(made, columns[i], columns[i + 1]), 2
        for one, value in zip(out, (name, unit, column), strict=True):
            one.append(value)
        i += step
    return out


def _said(file: Path, names: list[str], level: str, angle: str) -> str:
    """Which of ``PAIRS`` a magnitude and a phase are, by their units."""
    turn = _ANGLES.get(angle.strip().lower())
    unit = parse_unit(level)
    if _is_level(level):
        size = "db"
    elif level.strip().lower() in _LINEAR or (unit is not None and unit.quantity):
        size = "magnitude"
    else:
        size = ""
    if not turn or not size:
        lacks = [f"the unit of {names[1]!r}"] * (not turn) + [f"whether {names[0]!r} is in dB"] * (not size)
        unsuitable(
            file,
            f"which does not tell {' nor '.join(lacks)}",
            "headers such as 'Magnitude [g/N]' or 'Magnitude [dB]' and 'Phase [deg]' or 'Phase [rad]'",
            Wording(
                "Pass {}, {}, {} or {}.", *(Passed("pairs", kind) for kind in PAIRS if kind != "real_imag")
            ),
        )
    return f"{size}_{turn}"


def _complex(kind: str, first: Any, second: Any) -> Any:
    if kind == "real_imag":
        return first + 1j * second
    size, turn = kind.split("_")
    magnitude = 10.0 ** (first / 20.0) if size == "db" else first
    return magnitude * np.exp(1j * _PER_TURN[turn] * second)


def _is_level(text: str) -> bool:
    return text.strip().lower().startswith("db")
