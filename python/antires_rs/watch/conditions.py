"""Conditions of the tests of a series: columns by name, names and times, in the order of the tests."""

from __future__ import annotations

import csv
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Mapping, Sequence
from datetime import UTC
from numbers import Real
from os import PathLike
from pathlib import Path, PurePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import part, reject
from ..support.checks import FloatArray
from ..support.messages import warn
from ..support.values import FrozenDict, frozen
from .series_table import pyarrow
from .stored_tests import COLUMNS

# -- Numbers of a condition: what stands for one that is not known, and what is none


#: What loggers and spreadsheets write where nothing was measured, in any case.
MISSING = ("", "na", "n/a", "#n/a", "nan", "nat", "null", "none", "-", "--", "---", "missing")


def number(value: Any) -> float:
    """A value as a float, NaN where it stands for one that is not known.

    Raises
    ------
    TypeError, ValueError
        It is no number.
    """
    if value is None or (isinstance(value, str) and value.strip().lower() in MISSING):
        return float("nan")
    try:
        return float(value)
    except TypeError:
        if type(value).__name__ in ("NAType", "NaTType"):  # of pandas
            return float("nan")
        raise


def refuse_infinite(name: str, column: FloatArray) -> None:
    """Refuse a condition that is infinite in one test."""
    at = np.flatnonzero(np.isinf(column))
    if at.size:
        got, wanted = f"{column[at[0]]:g}", "a finite number, NaN where it is not known"
        reject(part(name, int(at[0])), got, wanted, "Give NaN for what was not measured.")


# -- Names of the columns of a series as a table, which no condition may have


#: Beside the columns of antiresonances; see :mod:`~antires_rs.watch.series_parquet`.
TEST_COLUMNS = ("row", "test", "name", "time", "dof", "failed", "count", "fingerprint", "facts")


def refuse_reserved(argument: str, name: str) -> None:
    """Refuse a condition that has the name of a column of the table."""
    if name in TEST_COLUMNS or name in COLUMNS or name == "source" or name.startswith("score_"):
        reject(argument, name, "a name that no column of a series has", "Rename it, as in 'outside_c'.")


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


# -- The tests that the rows of a table of conditions are of, by name


#: Columns that name the test of a row, in any case.
NAMES = ("name", "source", "file", "filename", "record", "test")


def test_names(table: Mapping[Any, Any]) -> tuple[str | None, bool]:
    """The column that names the tests, and whether by whole numbers; texts come before numbers."""
    possible = [key for name in NAMES for key in table if is_one_of(key, (name,))]
    for numbered, fits in ((False, _is_text), (True, _is_whole)):
        for key in possible:
            if len(table[key]) and all(map(fits, table[key])):
                return key, numbered
    return None, False


def is_one_of(key: Any, known: Sequence[str]) -> bool:
    """In any case."""
    return isinstance(key, str) and key.strip().lower() in known


def keys_of(name: str) -> tuple[str, ...]:
    """What a table may call a test: its name, the name of its file, that without the ending."""
    path = PurePath(name)
    return name, path.name, path.stem


def rows_by_name(names: tuple[str, ...]) -> dict[str, int]:
    """The row of each name."""
    rows: dict[str, int] = {}
    for i, name in enumerate(names):
        if name in rows:
            reject("conditions", f"test {name!r} more than once", "each test once", "Remove one of the rows.")
        rows[name] = i
    for i, name in enumerate(names):  # under its shorter names too, where no other has them
        for key in keys_of(name)[1:]:
            rows.setdefault(key, i)
    return rows


def _is_text(value: Any) -> bool:
    return isinstance(value, str | PurePath)


def _is_whole(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and float(value).is_integer()


# -- Tables of conditions in files: CSV as any program writes it, and Parquet


_ENDINGS = "a file that ends in .csv, .tsv, .txt or .parquet"


def read_table(path: Path) -> dict[str, Any]:
    """Columns by name.

    Raises
    ------
    FileNotFoundError
        There is none.
    InvalidInputError
        A file of another kind, or rows of different lengths.
    """
    suffix = path.suffix.lower()
    if suffix == ".parquet":
        table = pyarrow("conditions from Parquet").parquet.read_table(path)
        return {name: table.column(name).to_pylist() for name in table.column_names}
    if suffix not in (".csv", ".tsv", ".txt"):
        reject("conditions", repr(str(path)), _ENDINGS, "Export the table as CSV.")
    text = _text(path)
    head = text.partition("\n")[0]
    delimiter = max(("\t", ";", ","), key=head.count)
    rows = [row for row in csv.reader(text.splitlines(), delimiter=delimiter) if row]
    while rows and not any(map(str.strip, rows[-1])):  # within, nothing is known of a test
        rows.pop()
    if len(rows) < 2:
        reject("conditions", f"{str(path)!r} without rows", "a line of names and a line a test", "Fill it.")
    names = [name.strip() for name in rows[0]]
    twice = next((name for name in names if name and names.count(name) > 1), None)
    if twice is not None:
        got = f"two columns {twice!r} in {str(path)!r}"
        reject("conditions", got, "columns of different names", "Rename or remove one.")
    for i, row in enumerate(rows[1:], start=2):
        if len(row) != len(names):
            got, wanted = f"{len(row)} cells in row {i} of {str(path)!r}", f"{len(names)} as in its first row"
            reject("conditions", got, wanted, "Correct that row.")
    cells = zip(*rows[1:], strict=True)
    return {
        name: _column_condition_files(name, [cell.strip() for cell in column])
        for name, column in zip(names, cells, strict=True)
    }


def _text(path: Path) -> str:
    """What the file says: in UTF-8, in UTF-16 where it is marked so, or as older spreadsheets write it."""
    data = path.read_bytes()
    if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def _column_condition_files(name: str, cells: list[str]) -> list[Any]:
    """Numbers where there are some, with a decimal comma too; texts stay, as do the names of tests."""
    return list(cells) if is_one_of(name, NAMES) else [_cell(cell) for cell in cells]


def _cell(cell: str) -> Any:
    try:
        value = number(cell.replace(",", "."))
    except ValueError:
        return cell
    return None if value != value else value


# -- Conditions of the tests out of any table, a row a test: by the names of the tests or in their order


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
