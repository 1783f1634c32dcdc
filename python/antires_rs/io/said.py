"""What a file says of its arrays beside them: attributes of HDF5, texts and numbers in fields of structs.

Names are those of arrays, ``run1/acc`` or ``test.acc``; an attribute is ``run1/acc@unit``, of a group
``run1@fs``, of the file ``@fs``. What is said of a group or struct holds for all within.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from ..support.wording import Passed, Wording
from ._common import simplest_rate, unsuitable
from .units import Unit, abscissa_factor, is_abscissa, parse_unit

__all__ = ["RATES", "STEPS", "UNITS", "Said", "stated_number"]

RATES = frozenset(
    {
        *("fs", "fs_hz", "rate", "samplerate", "sampling_rate", "sample_rate", "samplingfrequency"),
        *("sampling_frequency", "samplefrequency", "sample_rate_hz", "sampling_rate_hz", "rate_hz"),
    }
)
STEPS = frozenset({"dt", "dt_s", "delta_t", "deltat", "wf_increment", "sample_interval", "sampling_interval"})
UNITS = frozenset({"unit", "units", "unit_string", "y_unit", "yunit", "y_unit_label", "einheit"})
_PART = re.compile(r"[./@]")
_QUANTITY = re.compile(r"([-+]?[\d.,]+(?:[eE][-+]?\d+)?)\s*(.*)\Z")
_THOUSANDS = re.compile(r"[1-9]\d{0,2}(?:,\d{3})+\Z")


class Said:
    """Values by name.

    Parameters
    ----------
    values : mapping of str to number or str

    Examples
    --------
    >>> said = Said({"run1@fs": 512.0, "run1/acc@unit": "g"})
    >>> said.rate(Path("a.h5"), ["run1/acc"]), said.unit("run1/acc")
    (512.0, 'g')
    """

    def __init__(self, values: Mapping[str, Any] | None = None) -> None:
        self._values = dict(values or {})

    def unit(self, name: str) -> str:
        """Unit of an array; '' where nothing is said."""
        found = next((str(v) for _, v in self._of(name, UNITS) if isinstance(v, str)), "")
        known = [each for each in re.split(r"[,;]", found) if (unit := parse_unit(each)) and unit.quantity]
        return known[0].strip() if len(known) == 1 else found  # "s, m/s2": of time and values

    def factor(self, path: Path, name: str, instead: str = "fs_hz", *, refuse: bool = True) -> float:
        """What makes Hz or s of a rate, step, time or frequency: its attribute ``unit``, or ``NAME_unit``."""
        beside = [f"{name}{mark}{word}" for mark in "@_" for word in ("unit", "units")]
        found = {
            key.lower(): str(value).strip() for key, value in self._values.items() if isinstance(value, str)
        }
        text = next((found[key.lower()] for key in beside if found.get(key.lower())), "")
        words = (text, text.partition(" ")[0])  # "seconds since 1970-01-01"
        known = next((word for word in words if is_abscissa(word)), "")
        if refuse and not known and parse_unit(text) != Unit():
            unsuitable(
                path,
                f"whose {name} is in {text!r}",
                "a unit of time or frequency that is known (s, ms, us, Hz, kHz, rpm, rad/s)",
                Wording("Export it in s or Hz, or give {}.", Passed(instead)),
            )
        return abscissa_factor(known)

    def rate(self, path: Path, names: Iterable[str], *, refuse: bool = True) -> float | None:
        """Sampling rate of arrays; None where nothing is said. Several rates are refused."""
        found: dict[str, float] = {}
        for name in names:
            for key, value in self._of(name, RATES | STEPS):
                number = stated_number(value)
                if number is not None and number > 0.0:
                    number *= self.factor(path, key, refuse=refuse)
                    step = _PART.split(key)[-1].lower() in STEPS
                    found[key] = simplest_rate((1 - 1e-12) / number, (1 + 1e-12) / number) if step else number
                    break
        if found and max(found.values()) > (1.0 + 1e-6) * min(found.values()):
            shown = ", ".join(f"{key} of {rate:g} Hz" for key, rate in found.items())
            unsuitable(
                path, f"with several sampling rates ({shown})", "one", "Name the responses= of one rate."
            )
        return next(iter(found.values()), None)

    def listed(self) -> str:
        """The numbers and texts that are said, for an error; '' without any."""
        shown = [f"{key} = {value!r}" for key, value in self._values.items() if str(value).strip()][:8]
        return "" if not shown else "; it says " + ", ".join(shown)[:300]

    def _of(self, name: str, wanted: frozenset[str]) -> Iterable[tuple[str, Any]]:
        """What is said of an array, the nearest first: of itself, of its struct or group, of the file."""
        here = name.partition("[")[0] if name.endswith("]") and "/" not in name else name
        while True:
            for key, value in self._values.items():
                above, _, last = _split(key)
                if last.lower() in wanted and above == here:
                    yield key, value
            if not here:
                return
            here = _split(here)[0]


def _split(key: str) -> tuple[str, str, str]:
    """The part before the last separator, the separator, and the last part."""
    places = [match.start() for match in _PART.finditer(key)]
    if not places:
        return "", "", key
    return key[: places[-1]], key[places[-1]], key[places[-1] + 1 :]


def stated_number(value: Any) -> float | None:
    """A number in Hz or s, also as text with a decimal comma or a unit behind it, ``51.2 kHz``.

    None where it is no number, in a unit that is not known, or may have a comma between thousands.
    """
    factor = 1.0
    if isinstance(value, str):
        match = _QUANTITY.match(value.strip())
        if match is None or _THOUSANDS.match(match[1]) or not (match[2] == "" or is_abscissa(match[2])):
            return None
        value, factor = match[1].replace(",", "."), abscissa_factor(match[2])
    try:
        number = factor * float(value)
    except (ValueError, TypeError):
        return None
    return number if math.isfinite(number) else None
