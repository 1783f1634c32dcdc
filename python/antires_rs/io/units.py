"""Units of channels and how they become SI: m/s2, m/s, m and N.

Names are compared without brackets, spaces, carets and superscripts: ``m/s^2`` and ``(m/s²)`` are one unit.
An FRF has a quotient, such as ``g/N`` or ``m/s2/N``.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

from ..exceptions import reject

STANDARD_GRAVITY = 9.80665  # m/s2 in one g, by definition (3rd CGPM, 1901)
INCH, POUND_FORCE = 0.0254, 4.4482216152605

_SI = {
    "acceleration": {
        **dict.fromkeys(("m/s2", "m/s/s", "ms-2"), 1.0),
        **dict.fromkeys(("g", "gn"), STANDARD_GRAVITY),
        **{"mg": 1e-3 * STANDARD_GRAVITY, "mm/s2": 1e-3, "cm/s2": 1e-2, "gal": 1e-2},
        **{"in/s2": INCH, "ft/s2": 12.0 * INCH},
    },
    "velocity": {"m/s": 1.0, "mm/s": 1e-3, "cm/s": 1e-2, "in/s": INCH, "ft/s": 12.0 * INCH},
    "displacement": {"m": 1.0, "mm": 1e-3, "um": 1e-6, "in": INCH, "ft": 12.0 * INCH},
    "force": {"N": 1.0, "kN": 1e3, "mN": 1e-3, "lbf": POUND_FORCE, "kgf": STANDARD_GRAVITY},
}
_ABSCISSA = {  #: Units of time and frequency, in small letters.
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds", "hz", "hertz", "1/s"), 1.0),
    **dict.fromkeys(("ms", "msec", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "usec", "microseconds"), 1e-6),
    "ns": 1e-9,
    **dict.fromkeys(("min", "minutes"), 60.0),
    **dict.fromkeys(("h", "hr", "hours"), 3600.0),
    **dict.fromkeys(("samples/s", "samples/sec", "samples/second", "sa/s", "s/s", "sps"), 1.0),
    **dict.fromkeys(("khz", "ksamples/s", "ksa/s", "ks/s", "ksps"), 1e3),
    **dict.fromkeys(("rpm", "cpm", "1/min"), 1.0 / 60.0),
    **dict.fromkeys(("rad/s", "rad/sec"), 0.5 / math.pi),
}
_INVERSE = re.compile(r"^\(?1/(\w+)\)?[*.](.+)$")
_NONE = {"", "1", "-", "none", "unknown", "[]"}
_SPELLED = str.maketrans({"²": "2", "µ": "u", "μ": "u", "^": "", "·": "", " ": ""})


@dataclass(frozen=True)
class Unit:
    """What a channel measures, per what ('' where that is not stated), and the factor into SI."""

    quantity: str = ""
    per: str = ""
    factor: float = 1.0
    known: bool = True

    @classmethod
    def of(cls, text: str) -> Unit:
        """The unit of that name; one that is not ``known`` leaves values as they are."""
        name = _plain(text)
        if name.lower() in _NONE:
            return cls()
        if inverse := _INVERSE.match(name):  # (1/N)*(m/s2)
            name = f"{inverse[2].strip('()')}/{inverse[1]}"
        if simple := _simple(name):
            return cls(simple[0], "", simple[1])
        for cut in (i for i, letter in enumerate(name) if letter == "/"):
            above, below = _simple(_plain(name[:cut])), _simple(_plain(name[cut + 1 :]))
            if above and below:
                return cls(above[0], below[0], above[1] / below[1])
        return cls(known=False)

    @classmethod
    def named(cls, value: Any) -> Unit:
        """The unit that a user names by ``unit=``; an unknown one is refused."""
        unit = cls.of(value) if isinstance(value, str) else cls(known=False)
        if not unit.known:
            known = ", ".join(repr(u) for units in _SI.values() for u in list(units)[:4])
            wanted = f"a unit such as {known}, or a quotient such as 'g/N'"
            remedy = "Correct the unit, or convert the values to SI and leave it out."
            reject("unit", repr(value), wanted, remedy)
        return unit

    @classmethod
    def written(cls, value: Any) -> Unit:
        """The unit in which a user writes values, which stay as they are."""
        unit = cls.named(value)
        if unit.factor != 1.0:
            wanted = "an SI unit, such as 'm/s2' or 'm/s2/N': signals are in SI"
            reject("unit", repr(value), wanted, "Name the SI unit, or leave unit out.")
        return unit

    def in_si(self, values: Any) -> Any:
        """Values in SI; bit-identical where they are SI already."""
        return values if self.factor == 1.0 else values * self.factor


def abscissa_factor(text: str) -> float:
    """Factor of a time or frequency into s or Hz; 1 for names that are not known."""
    return _ABSCISSA.get(_plain(text).lower(), 1.0)


def is_abscissa(text: str) -> bool:
    """Whether the name is that of a unit of time or frequency."""
    return _plain(text).lower() in _ABSCISSA


def is_frequency(text: str) -> bool:
    """Whether the name is that of a unit of frequency."""
    return _plain(text).lower() in ("hz", "hertz", "khz", "rad/s", "rad/sec")


def _plain(text: str) -> str:
    # What is left of a Latin-1 ² where a package read it as UTF-8.
    text = text.replace("/s\ufffd", "/s2").replace("**", "").translate(_SPELLED)
    while len(text) > 1 and (text[0], text[-1]) in (("(", ")"), ("[", "]")):
        text = text[1:-1]
    return text


def _simple(name: str) -> tuple[str, float] | None:
    # Capitals as they are first: mN and MN differ. Then in small letters, as some programs print M/S2.
    for spelled in (name, name.lower()):
        for quantity, units in _SI.items():
            if spelled in units:
                return quantity, units[spelled]
    return None
