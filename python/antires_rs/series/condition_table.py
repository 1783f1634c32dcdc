"""Conditions of the tests out of any table, a row a test: by the names of the tests or in their order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..support.validation import part, reject
from ..support.warned import warn
from .condition_files import read_table
from .condition_numbers import number, refuse_infinite
from .reserved import refuse_reserved
from .row_names import NAMES, is_one_of, keys_of, rows_by_name, test_names

__all__ = ["ConditionTable", "condition_table", "in_order", "of_source"]

#: Columns that date the test of a row, in any case.
TIMES = ("time", "times", "date", "datetime", "timestamp")
_FORMS = (
    "a mapping of name to array, a DataFrame, a structured array, a list of dicts, or a CSV or Parquet file"
)


class ConditionTable:
    """Rows of conditions for tests that come one after the other.

    Attributes
    ----------
    columns : dict of str to (n,) float
    times : (n,) datetime64 or None
    names : tuple of str or None
        Of the tests, where the table has them; else rows are in the order of the tests.
    """

    def __init__(
        self, columns: Mapping[str, Any], times: Any, names: tuple[str, ...] | None, numbered: bool = False
    ) -> None:
        self.columns, self.times, self.names = columns, times, names
        self._row = None if names is None else rows_by_name(names)
        self._numbered, self._used = numbered, 0

    @property
    def count(self) -> int:
        """Rows."""
        return max([len(column) for column in self.columns.values()] + [_length(self.times)], default=0)

    def expect(self, count: int | None) -> None:
        """Refuse a table in order that has another number of rows than there are tests, if that is known."""
        given = bool(self.columns) or self.times is not None
        if self._row is None and given and count not in (None, self.count):
            wanted = f"{count}, one for each test, or a column 'name' with the names of the tests"
            reject("conditions", f"{self.count} rows", wanted, "Give NaN where nothing is known.")

    def at(self, number: int, name: str) -> tuple[dict[str, float], Any]:
        """Conditions and time of a test; NaN and None where the table lacks it."""
        if self._row is None:
            row: int | None = number
            if (self.columns or self.times is not None) and number >= self.count:
                reject("conditions", f"{self.count} rows", f"one for test {number} too", "Give as many.")
        else:
            row = next((self._row[key] for key in keys_of(name) if key in self._row), None)
            self._used += row is not None
            if row is None and self._numbered and name == str(number):
                # Tests counted from 1 in the table would be those beside the ones that are meant.
                wanted = "a row for each test, which are counted from 0"
                reject(
                    "conditions", f"no row of test {name}", wanted, "Count from 0, or leave the names out."
                )
        if row is None:
            return dict.fromkeys(self.columns, float("nan")), None
        time = None if self.times is None else self.times[row]
        return {key: float(column[row]) for key, column in self.columns.items()}, time

    def over(self, count: int) -> None:
        """Refuse a table that was not used up, or of which nothing was."""
        if self._row is None:
            self.expect(count)
        elif count and not self._used:
            first = ", ".join(repr(name) for name in (self.names or ())[:3])
            reject("conditions", f"tests named {first}, ...", "names of the sources", "Compare the names.")


def condition_table(given: Any) -> tuple[ConditionTable, tuple[Path, ...]]:
    """The table, and the file that it was read from, if any."""
    if given is None:
        return ConditionTable({}, None, None), ()
    if isinstance(given, ConditionTable):
        return given, ()
    if isinstance(given, str | PathLike):
        return _of_columns(read_table(Path(given))), (Path(given),)
    return _of_columns(_columns(given)), ()


def in_order(given: Any, count: int, names: Any) -> tuple[dict[str, Any], Any, Any]:
    """Columns, names and times of so many tests out of a table; it names them where ``names`` are None."""
    table, _ = condition_table(given)
    if names is None and table.names is not None and len(table.names) == count:
        names = table.names
    table.expect(count)
    rows = [table.at(i, str(name)) for i, name in enumerate(range(count) if names is None else names)]
    table.over(count)
    columns = {key: [row[key] for row, _ in rows] for key in table.columns}
    times = None if table.times is None else ["NaT" if time is None else time for _, time in rows]
    return columns, names, times


def of_source(nth: int, given: Mapping[str, Any]) -> tuple[dict[str, float], Any]:
    """Conditions and time that came with a source."""
    if not given:
        return {}, None
    time, values = None, {}
    for key, value in given.items():
        name = part(part("sources", nth), key)
        if is_one_of(key, TIMES) and (found := _times([value])) is not None:
            time = found[0]
            continue
        if not isinstance(key, str) or not key:
            reject(name, key, "a text as the name of each condition", "As in {'temperature_c': 20.5}.")
        refuse_reserved(name, key)
        try:
            values[key] = number(value)
        except (TypeError, ValueError):
            values[key] = np.inf
        if np.isinf(values[key]):
            reject(name, repr(value), "a finite number, NaN where it is not known", "Leave texts out.")
    return values, time


def _columns(given: Any) -> dict[str, Any]:
    """Columns by name, of whatever table."""
    if isinstance(given, Mapping):
        return dict(given)
    if isinstance(given, np.ndarray) and given.dtype.names:
        return {name: given[name] for name in given.dtype.names}
    if hasattr(given, "columns") and hasattr(given, "__getitem__"):  # pandas, polars
        table = {name: np.asarray(given[name]) for name in given.columns}
        index = getattr(given, "index", None)
        kind = getattr(getattr(index, "dtype", None), "kind", "")
        if kind == "M":
            table.setdefault("time", np.asarray(index))
        elif (
            kind in ("O", "T", "U") and index is not None and not any(is_one_of(key, NAMES) for key in table)
        ):
            table["name"] = np.asarray(index)
        return table
    if (
        isinstance(given, Sequence)
        and not isinstance(given, str)
        and all(isinstance(r, Mapping) for r in given)
    ):
        keys = dict.fromkeys(key for row in given for key in row)
        return {key: [row.get(key) for row in given] for key in keys}
    reject("conditions", type(given).__name__, _FORMS, "As in conditions={'temperature_c': [...]}.")


def _of_columns(given: Mapping[Any, Any]) -> ConditionTable:
    columns: dict[str, Any] = {}
    names = times = None
    naming, numbered = test_names(given)
    for key, values in given.items():
        if not isinstance(key, str) or not key:
            reject("conditions", key, "a text as the name of each column", "As in {'temperature_c': [...]}.")
        if isinstance(values, str) or not hasattr(values, "__len__"):
            reject(part("conditions", key), values, "a list or an array, one for each test", "Give a list.")
        if key == naming:
            names = tuple(str(int(value)) if numbered else str(value) for value in values)
        elif times is None and is_one_of(key, TIMES) and (found := _times(values)) is not None:
            times = found
        else:
            column = _numbers(key, values)
            if column is not None:
                columns[key] = column
    counts = {len(column) for column in columns.values()} | {len(x) for x in (names, times) if x is not None}
    if len(counts) > 1:
        got = ", ".join(f"{len(column)} of {key!r}" for key, column in given.items())
        reject("conditions", got, "columns of one length", "Give NaN where one is not known.")
    for key in columns:
        refuse_reserved("conditions", key)
    return ConditionTable(columns, times, names, numbered)


def _numbers(key: str, values: Any) -> Any:
    """Floats, NaN for what is missing; None for a column of texts, with a word."""
    column, other = np.full(len(values), np.nan), []
    for i, value in enumerate(values):
        try:
            column[i] = number(value)
        except (TypeError, ValueError):
            other.append(i)
    name = part("conditions", key)
    refuse_infinite(name, column)
    if len(other) > np.count_nonzero(~np.isnan(column)):
        text = f"conditions: column {key!r} is left out, its values are no numbers."
        warn("condition_left_out", text)  # the caller of identify_series
        return None
    if other:  # a column of numbers: leaving it out would be a surprise
        wanted = "numbers; nothing, NaN, NA or - where one is not known"
        reject(part(name, other[0]), repr(values[other[0]]), wanted, "Correct it, or leave the column out.")
    return column


def _times(values: Any) -> Any:
    """Instants, if these are any."""
    array = np.asarray(values)
    if array.dtype.kind in "fiub":
        return None
    try:
        return np.array(
            ["NaT" if value is None or value == "" else _instant(value) for value in array.tolist()]
            if array.dtype.kind != "M"
            else array,
            dtype="datetime64[ms]",
        )
    except (TypeError, ValueError):
        return None


def _instant(value: Any) -> Any:
    """Without its time zone, which numpy does not know: as UTC."""
    if isinstance(value, str):
        from datetime import datetime

        value = datetime.fromisoformat(value)
    if getattr(value, "tzinfo", None) is not None:
        value = value.astimezone(UTC).replace(tzinfo=None)
    return np.datetime64(value, "ms")


def _length(values: Any) -> int:
    return 0 if values is None else len(values)
