"""Layouts of text tables that loggers and analysers write: KYOWA PCD, Movella DOT, B&K PULSE."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ..support.checks import FloatArray

# -- Columns under rows that are called by what they hold: CH No., Range, ..., Unit (KYOWA PCD)

_UNITS = ("unit", "units", "einheit")
_NAMES = re.compile(r"(ch|channel|signal|sensor|kanal)\b|name\b", re.IGNORECASE)
_RATE = re.compile(r"sampl\w*[ _]?(rate|freq)\w*", re.IGNORECASE)


def labelled_rows(rows: Sequence[Sequence[str]], width: int) -> tuple[list[str], list[str]] | None:
    """Names and units of the columns where each row above them says first what it holds; None for others."""
    own = next((row for row in reversed(rows) if len(row) == width and row[0].lower() in _UNITS), None)
    if own is None:
        return None
    named = (row for row in reversed(rows) if len(row) == width and _NAMES.match(row[0]) and all(row[1:]))
    names = next(named, ["", *(f"channel {i}" for i in range(1, width))])
    return ["", *names[1:]], ["", *own[1:]]


def stated_rate_hz(rows: Sequence[Sequence[str]]) -> float | None:
    """What a row such as ``Sampling Rate(Hz),50`` says; None without one."""
    for row in rows:
        if (
            len(row) > 1
            and _RATE.match(row[0])
            and re.fullmatch(r"[\d.]+", row[1])
            and "khz" not in row[0].lower()
        ):
            return float(row[1]) or None
    return None


# -- One response a file (PULSE): "Header Size:", "X-Axis unit:", "Signal:", tags; number, x, real, imaginary


def is_pulse(body: Sequence[str]) -> bool:
    """Whether the lines of a file begin as PULSE writes a function as text."""
    return bool(body) and body[0].startswith("Header Size:")


def pulse_columns(head: Sequence[str], width: int) -> tuple[list[str], list[str]]:
    """Names and units of the columns."""
    pairs = (line.partition(":") for line in head)
    said = {key.strip().lower(): value.strip() for key, _, value in pairs}
    x = next((said[key] for key in ("x-axis unit", "x-axis units", "x-axisunit") if key in said), "")
    unit, base = said.get("amplitudeunit", ""), said.get("signal", "").strip("()") or "response"
    values = [base] if width < 4 else [f"re({base})", f"im({base})"]
    names = ["", "Time" if x.lower() in ("s", "ms") else "Frequency", *values]
    return names[-width:], ["", x, *[unit] * len(values)][-width:]


# -- Sensors with a counter of packets and a clock of 32 bits in microseconds (Movella, Xsens DOT)

_MOVELLA = {"acc": "m/s2", "freeacc": "m/s2", "gyr": "deg/s", "euler": "deg", "mag": "a.u.", "quat": "1"}
_CLOCK = "SampleTimeFine"


def movella_columns(names: Sequence[str]) -> tuple[list[int], list[str]] | None:
    """Which columns count, the clock first, and their units; None for another layout."""
    if _CLOCK not in names:
        return None
    at = [names.index(_CLOCK), *(i for i, name in enumerate(names) if name not in ("PacketCounter", _CLOCK))]
    return at, ["us", *(_MOVELLA.get(names[i].partition("_")[0].lower(), "") for i in at[1:])]


def unwrapped(ticks: FloatArray) -> FloatArray:
    """The readings of a counter of 16, 24 or 32 bits that began again at zero, as if it had more."""
    steps = np.diff(ticks)
    down = steps < 0.0
    if not down.any() or np.any(ticks != np.rint(ticks)):
        return ticks
    usual = float(np.median(steps))
    for bits in (16, 24, 32):
        fixed = steps[down] + 2.0**bits
        if (
            ticks.max() < 2.0**bits
            and fixed.min() > 0.0
            and fixed.max() <= 1000.0 * usual < 2.0 ** (bits - 1)
        ):
            return np.concatenate([ticks[:1], ticks[0] + np.cumsum(steps + 2.0**bits * down)])
    return ticks
