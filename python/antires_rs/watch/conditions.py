"""Conditions of the tests of a series: columns by name, names and times, in the order of the tests."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from os import PathLike
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from ..exceptions import Argument, part, reject
from ..io.child_process import Limits, channels_of_child
from ..io.table_files import table_of_parquet
from ..io.text_table import decoded
from ..support.checks import FloatArray
from ..support.messages import warn
from .stored_tests import COLUMNS, OF_ALL, OF_TEST, OF_VALUE, pyarrow

#: What loggers and spreadsheets write where nothing was measured, in any case.
MISSING = ("", "na", "n/a", "#n/a", "nan", "nat", "null", "none", "-", "--", "---", "missing")
#: Columns that name, and that date, the test of a row, in any case.
NAMES = ("name", "source", "file", "filename", "record", "test")
TIMES = ("time", "times", "date", "datetime", "timestamp")
#: Columns of a series as a table, which no condition may have.
_RESERVED = {*OF_ALL, *OF_VALUE, *OF_TEST, *COLUMNS}
_FINITE = "a finite number, NaN where it is not known"


def _number(value: Any) -> float:
    """A value as a float, NaN where it stands for one that is not known; TypeError or ValueError for none."""
    if value is None or (isinstance(value, str) and value.strip().lower() in MISSING):
        return float("nan")
    if type(value).__name__ in ("NAType", "NaTType"):  # of pandas
        return float("nan")
    return float(value)


def _check_name(argument: str | Argument, key: Any) -> None:
    if not isinstance(key, str) or not key:
        reject(argument, key, "a text as the name of each condition", "As in {'temperature_c': [...]}.")
    if key in _RESERVED or key.startswith("score_"):
        reject(argument, key, "a name that no column of a series has", "Rename it, as in 'outside_c'.")


def _check_finite(name: Argument, column: FloatArray) -> None:
    for at in np.flatnonzero(np.isinf(column)).tolist():
        reject(part(name, at), f"{column[at]:g}", _FINITE, "Give NaN for what was not measured.")


# -- What a series is made with, beside its table of conditions


def checked_names(given: Any, count: int) -> tuple[str, ...]:
    """Distinct texts; by default the numbers of the tests."""
    wanted = f"{count} distinct names, one for each test"
    names = tuple(map(str, range(count) if given is None else given))
    if len(names) != count or isinstance(given, str | bytes):
        got = given if isinstance(given, str | bytes) else f"{len(names)} of them"
        reject("names", got, wanted, "Give a list of one for each test.")
    _each_once("names", "", names, wanted)
    return names


def _each_once(argument: str, what: str, names: Sequence[Any], wanted: str) -> None:
    if len(set(names)) < len(names):
        (twice, _), *_ = Counter(names).most_common(1)
        reject(argument, f"{what}{twice!r} more than once", wanted, "Rename or remove one of the two.")


# -- Tables of conditions in files: CSV as any program writes it, and Parquet


def _read_table(path: Path) -> dict[str, Any]:
    """Columns by name."""
    suffix = path.suffix.lower()
    if suffix == ".parquet":
        pyarrow("conditions from Parquet")
        _, texts = channels_of_child(table_of_parquet, path, "a table of conditions", Limits(120.0, 8.0))
        columns: dict[str, Any] = json.loads(texts["table"])
        return columns
    if suffix not in (".csv", ".tsv", ".txt"):
        wanted = "a file that ends in .csv, .tsv, .txt or .parquet"
        reject("conditions", repr(str(path)), wanted, "Export the table as CSV.")
    text = decoded(path)
    delimiter = max(("\t", ";", ","), key=text.partition("\n")[0].count)
    rows = [row for row in csv.reader(text.splitlines(), delimiter=delimiter) if row]
    while rows and not any(map(str.strip, rows[-1])):  # within, nothing is known of a test
        rows.pop()
    if len(rows) < 2:
        reject("conditions", f"{str(path)!r} without rows", "a line of names and a line a test", "Fill it.")
    names = [name.strip() for name in rows[0]]
    _each_once("conditions", "column ", list(filter(None, names)), "columns of different names")
    for i, row in enumerate(rows[1:], start=2):
        if len(row) != len(names):
            got, wanted = f"{len(row)} cells in row {i} of {str(path)!r}", f"{len(names)} as in its first row"
            reject("conditions", got, wanted, "Correct that row.")
    cells = ([cell.strip() for cell in column] for column in zip(*rows[1:], strict=True))
    # The names of tests stay texts.
    own = ((name, column, _is_one_of(name, NAMES)) for name, column in zip(names, cells, strict=True))
    return {name: column if texts else list(map(_cell, column)) for name, column, texts in own}


def _cell(cell: str) -> Any:
    """A number, with a decimal comma too, None where it is not known; else the text."""
    try:
        value = _number(cell.replace(",", "."))
    except ValueError:
        return cell
    return None if value != value else value


# -- Conditions of the tests out of any table, a row a test: by the names of the tests or in their order


class ConditionTable:
    """Columns of conditions, and times, in the order of the tests, or by their ``names``."""

    def __init__(self, columns: Mapping[str, Any], times: Any, names: tuple[str, ...] | None) -> None:
        self.columns, self.times, self.names, self._used = columns, times, names, False
        lengths = [len(column) for column in (*columns.values(), times) if column is not None]
        self._given, self.count = bool(lengths), max(lengths, default=0)
        self._row = {name: i for i, name in enumerate(names or ())}
        _each_once("conditions", "test ", names or (), "each test once")
        for i, name in enumerate(names or ()):  # under its shorter names too, where no other has them
            for key in _keys_of(name):
                self._row.setdefault(key, i)

    def expect(self, count: int | None) -> None:
        """Refuse a table in order that has another number of rows than there are tests, if that is known."""
        if self.names is None and self._given and count not in (None, self.count):
            wanted = f"{count}, one for each test, or a column 'name' with the names of the tests"
            reject("conditions", f"{self.count} rows", wanted, "Give NaN where nothing is known.")

    def at(self, number: int, name: str) -> tuple[dict[str, float], Any]:
        """Conditions and time of a test; NaN and None where the table lacks it."""
        row: int | None = number
        if self.names is not None:
            row = next((self._row[key] for key in _keys_of(name) if key in self._row), None)
            self._used |= row is not None
            if row is None and name == str(number):  # it has no name: the table may count from 1
                got, wanted = f"no row of test {name}", "a row for each test, which are counted from 0"
                reject("conditions", got, wanted, "Count from 0, or leave the names out.")
        elif self._given and number >= self.count:
            reject("conditions", f"{self.count} rows", f"one for test {number} too", "Give as many.")
        if row is None:
            return dict.fromkeys(self.columns, float("nan")), None
        time = None if self.times is None else self.times[row]
        return {key: float(column[row]) for key, column in self.columns.items()}, time

    def over(self, count: int) -> None:
        """Refuse a table that was not used up, or of which nothing was."""
        self.expect(count)
        if self.names is not None and count and not self._used:
            first = ", ".join(map(repr, self.names[:3]))
            reject("conditions", f"tests named {first}, ...", "names of the sources", "Compare the names.")

    def in_order(self, names: Sequence[str]) -> tuple[dict[str, FloatArray], Any]:
        """Columns and times of all tests of a series."""
        self.expect(len(names))
        rows = [self.at(i, name) for i, name in enumerate(names)]
        self.over(len(names))
        columns = {key: np.array([row[key] for row, _ in rows]) for key in self.columns}
        times = ["NaT" if time is None else time for _, time in rows]
        return columns, None if self.times is None else np.array(times, dtype="datetime64[ms]")


def condition_table(given: Any) -> tuple[ConditionTable, tuple[Path, ...]]:
    """The table, and the file that it was read from, if any."""
    if isinstance(given, ConditionTable):
        return given, ()
    files = (Path(given),) if isinstance(given, str | PathLike) else ()
    if given is None:
        return ConditionTable({}, None, None), ()
    return _of_columns(_read_table(*files) if files else _columns(given)), files


def of_source(nth: int, given: Mapping[str, Any]) -> tuple[dict[str, float], Any]:
    """Conditions and time that came with a source."""
    time, values = None, {}
    for key, value in given.items():
        name = part(part("sources", nth), key)
        if _is_one_of(key, TIMES) and (found := _times([value])) is not None:
            time = found[0]
            continue
        _check_name(name, key)
        try:
            values[key] = _number(value)
        except (TypeError, ValueError):
            values[key] = np.inf
        if np.isinf(values[key]):
            reject(name, repr(value), _FINITE, "Leave texts out.")
    return values, time


def _columns(given: Any) -> dict[Any, Any]:
    """Columns by name, of whatever table."""
    if isinstance(given, Mapping):
        return dict(given)
    if hasattr(given, "columns") and hasattr(given, "__getitem__"):  # pandas, polars
        table = {name: np.asarray(given[name]) for name in given.columns}
        index = getattr(given, "index", None)
        kind = getattr(getattr(index, "dtype", None), "kind", "")
        if kind == "M":
            table.setdefault("time", np.asarray(index))
        elif kind in ("O", "T", "U") and not any(_is_one_of(key, NAMES) for key in table):
            table["name"] = np.asarray(index)
        return table
    wanted = "a mapping of name to array, a DataFrame, or a CSV or Parquet file"
    reject("conditions", type(given).__name__, wanted, "As in conditions={'temperature_c': [...]}.")


def _of_columns(given: Mapping[Any, Any]) -> ConditionTable:
    columns: dict[str, Any] = {}
    names = times = None
    called = (key for name in NAMES for key in given if _is_one_of(key, (name,)) and len(given[key]))
    naming = next(called, None)
    for key, values in given.items():
        if isinstance(values, str) or not hasattr(values, "__len__"):
            reject(part("conditions", key), values, "a list or an array, one for each test", "Give a list.")
        if key == naming:
            names = tuple(map(str, values))
        elif times is None and _is_one_of(key, TIMES) and (found := _times(values)) is not None:
            times = found
        elif (column := _numbers(key, values)) is not None:
            columns[key] = column
    if len({len(column) for column in (*columns.values(), names, times) if column is not None}) > 1:
        got = ", ".join(f"{len(column)} of {key!r}" for key, column in given.items())
        reject("conditions", got, "columns of one length", "Give NaN where one is not known.")
    for key in columns:
        _check_name("conditions", key)
    return ConditionTable(columns, times, names)


def _is_one_of(key: Any, known: Sequence[str]) -> bool:
    """In any case."""
    return isinstance(key, str) and key.strip().lower() in known


def _keys_of(name: str) -> tuple[str, ...]:
    """What a table may call a test: its name, the name of its file, that without the ending."""
    path = PurePath(name)
    return name, path.name, path.stem


def _numbers(key: str, values: Any) -> Any:
    """Floats, NaN for what is missing; None for a column of texts, with a word."""
    column, other = np.full(len(values), np.nan), []
    for i, value in enumerate(values):
        try:
            column[i] = _number(value)
        except (TypeError, ValueError):
            other.append(i)
    name = part("conditions", key)
    _check_finite(name, column)
    if len(other) > np.count_nonzero(~np.isnan(column)):
        warn("condition_left_out", f"conditions: column {key!r} is left out, its values are no numbers.")
        return None
    if other:  # a column of numbers: leaving it out would be a surprise
        wanted = "numbers; nothing, NaN, NA or - where one is not known"
        reject(part(name, other[0]), repr(values[other[0]]), wanted, "Correct it, or leave the column out.")
    return column


def _times(values: Any) -> Any:
    """Instants without their time zone, which numpy does not know, as UTC; None if these are none."""
    array = np.asarray(values)
    if array.dtype.kind in "fiub":
        return None
    if array.dtype.kind == "M":
        return array.astype("datetime64[ms]")
    try:
        instants = [datetime.fromisoformat(v) if isinstance(v, str) and v else v for v in array.tolist()]
        for i in np.flatnonzero([getattr(instant, "tzinfo", None) is not None for instant in instants]):
            instants[i] = instants[i].astimezone(UTC).replace(tzinfo=None)
        return np.array([np.datetime64(instant or "NaT", "ms") for instant in instants])
    except (TypeError, ValueError):
        return None
