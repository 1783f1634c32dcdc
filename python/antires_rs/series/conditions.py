"""Conditions of the tests of a series: columns by name, names and times, in the order of the tests."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.pickling import FrozenDict, frozen
from ..support.validation import FloatArray, part, reject
from .condition_numbers import refuse_infinite
from .reserved import refuse_reserved

__all__ = ["checked_conditions", "checked_names", "checked_times"]

_NUMBERS = "numbers, NaN where one is not known"


def checked_conditions(given: Any, count: int) -> FrozenDict[str, FloatArray]:
    """Columns (count,) by name."""
    if given is None:
        return FrozenDict({})
    if not isinstance(given, Mapping):
        reject("conditions", type(given).__name__, "a mapping of name to array", "Pass a dict of columns.")
    return FrozenDict({_name(key): _column(key, values, count) for key, values in given.items()})


def checked_names(given: Any, count: int) -> tuple[str, ...]:
    """Distinct texts; by default the numbers of the tests."""
    if given is None:
        return tuple(map(str, range(count)))
    wanted = f"{count} distinct names, one for each test"
    if isinstance(given, str | bytes):
        reject("names", given, wanted, "Put them in a list.")
    names = tuple(map(str, given))
    if len(names) != count:
        reject("names", f"{len(names)} of them", wanted, "Give one for each test.")
    if len(set(names)) != count:
        seen: set[str] = set()
        twice = next(name for name in names if name in seen or seen.add(name))  # type: ignore[func-returns-value]
        reject("names", f"{twice!r} more than once", wanted, "Rename one of the two.")
    return names


def checked_times(given: Any, count: int) -> NDArray[np.datetime64] | None:
    """Instants (count,) without a time zone, NaT where not known; None where there are none."""
    if given is None:
        return None
    wanted = f"{count} dates, as datetime64, datetime or ISO text, one for each test"
    try:
        times = np.array(given, dtype="datetime64[ms]")
    except (TypeError, ValueError) as exc:
        reject("times", f"what does not convert ({exc})", wanted, "Write them as in '2026-01-31T14:00'.")
    if times.shape != (count,):
        reject("times", f"an array of shape {times.shape}", wanted, "Give one for each test.")
    return frozen(times)


def _name(key: Any) -> str:
    if not isinstance(key, str) or not key:
        reject("conditions", key, "a text as the name of each condition", "As in {'temperature_c': [...]}.")
    refuse_reserved("conditions", key)
    return key


def _column(key: str, values: Any, count: int) -> FloatArray:
    name = part("conditions", key)
    try:
        column = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as exc:
        reject(name, f"what does not convert ({exc})", _NUMBERS, "Leave texts out, or number them.")
    if column.shape != (count,):
        got = f"{column.size} values" if column.ndim == 1 else f"an array of shape {column.shape}"
        reject(name, got, f"{count} numbers, one for each test", "Give NaN where one is not known.")
    refuse_infinite(name, column)
    return frozen(column)
