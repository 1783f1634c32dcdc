"""A series as one long table that any program reads: Parquet, which it is read from again, or CSV.

Each test has one row with ``row`` "test" (why it failed, how many antiresonances it has, and ``facts``, the
rest as JSON), and behind it one for each antiresonance, each that was seen and not accepted ("left_out") and
each peak without explanation ("unexplained"). Name, time and conditions of the test stand in all of them. A
row group of Parquet holds ``GROUP`` tests, so that any of them is found without reading the others.
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .._core import __version__
from ..exceptions import reject
from ..io.common import missing_package
from ..support.files import written_beside
from .stored_tests import Plain, Row

FORMAT, VERSION = "antires_rs.Series", 1
#: Tests in a row group, and row groups that are held as plain data once they were read.
GROUP, HELD = 128, 2
_SOURCES = {True: "by hand", False: "identified", None: None}
Columns = dict[str, list[Any]]


def pyarrow(what: str) -> Any:
    """The package, imported where a file is asked for, or the error that names the extra."""
    try:
        import pyarrow.parquet
    except ImportError as exc:
        raise missing_package(what, "pyarrow", "series", exc) from exc
    return pyarrow


def write_table(path: Path, rows: Sequence[Row], config: dict[str, Any] | None) -> None:
    """Write all tests, whole or not at all; the bytes depend on nothing else."""
    conditions = list(dict.fromkeys(name for row in rows for name in row.conditions))
    fields = _fields(rows, conditions)
    groups = (_columns(first, rows[first : first + GROUP], fields, conditions) for first in _firsts(rows))
    write = _write_csv if path.suffix.lower() == ".csv" else _write_parquet
    facts = {
        "format": FORMAT,
        "version": VERSION,
        "made_by": __version__,
        "tests": len(rows),
        "tests_in_row_group": GROUP,
        "conditions": conditions,
        "config": config,
    }
    with written_beside(path) as beside:
        write(beside, fields, facts, groups)
        with open(beside, "rb+") as written:
            os.fsync(written.fileno())


def _firsts(rows: Sequence[Row]) -> range:
    return range(0, len(rows), GROUP)


def _write_csv(path: Path, fields: dict[str, str], _: Any, groups: Iterator[Columns]) -> None:
    with open(path, "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(fields)
        for columns in groups:
            table.writerows(zip(*(columns[name] for name in fields), strict=True))


def _write_parquet(path: Path, fields: dict[str, str], facts: Any, groups: Iterator[Columns]) -> None:
    arrow = pyarrow("a series in a file")
    types = {
        "U": arrow.string(),
        "f": arrow.float64(),
        "b": arrow.bool_(),
        "i": arrow.int64(),
        "n": arrow.int32(),
        "M": arrow.timestamp("ms"),
    }
    schema = arrow.schema([(name, types[kind]) for name, kind in fields.items()])
    schema = schema.with_metadata({"antires_rs": json.dumps(facts)})
    with open(path, "wb") as file, arrow.parquet.ParquetWriter(file, schema, compression="zstd") as writer:
        for columns in groups:
            arrays = [arrow.array(columns[field.name], field.type) for field in schema]
            table = arrow.Table.from_arrays(arrays, schema=schema)
            writer.write_table(table, row_group_size=max(table.num_rows, 1))


def _fields(rows: Sequence[Row], conditions: list[str]) -> dict[str, str]:
    """Letters of the types of all columns by their names, in their order; n is a short integer."""
    timed = any(row.time is not None and not np.isnat(row.time) for row in rows)
    kinds: dict[str, set[str]] = {}
    for own in {row.kinds for row in rows}:
        for name, kind in own:
            kinds.setdefault(name, set()).add(kind)
    fields = {"row": "U", "test": "n", "name": "U"} | ({"time": "M"} if timed else {})
    fields |= dict.fromkeys(conditions, "f")
    fields |= {"dof": "U", "freq_hz": "f", "damping_ratio": "f", "std_hz": "f", "source": "U"}
    for name, several in sorted(kinds.items()):
        fields[f"score_{name}"] = min(several) if len(several) == 1 else "U" if "U" in several else "f"
    return fields | {"failed": "U", "count": "n", "fingerprint": "U", "facts": "U"}


def _columns(first: int, rows: Sequence[Row], fields: dict[str, str], conditions: list[str]) -> Columns:
    columns: Columns = {name: [] for name in fields}
    for number, row in enumerate(rows, start=first):
        for name, values in _rows_of(number, row, conditions):
            if name in columns:
                columns[name] += values
        longest = len(columns["row"])
        for column in columns.values():
            column += [None] * (longest - len(column))
    return columns


def _rows_of(number: int, row: Row, conditions: list[str]) -> Iterator[tuple[str, list[Any]]]:
    """Name and values of each column, a test's own row first; what is missing behind is null."""
    plain = None if row.failed is not None else row.plain()
    tables = plain["facts"]["tables"] if plain else []
    kinds = ["test", *(group for group, _, count, _ in tables for _ in range(count))]
    many = len(kinds)
    yield "row", kinds
    yield "test", [number] * many
    yield "name", [row.name] * many
    yield "time", [None if row.time is None or np.isnat(row.time) else row.time] * many
    for name in conditions:
        value = row.conditions.get(name, np.nan)
        yield name, [None if value != value else value] * many
    yield "failed", [row.failed]
    yield "count", [row.count]
    yield "fingerprint", [row.fingerprint]
    if plain is None:
        return
    yield "facts", [json.dumps(plain["facts"], separators=(",", ":"))]
    yield "dof", [None, *(str(dof) for _, dof, count, _ in tables for _ in range(count))]
    for name in ("freq_hz", "damping_ratio", "std_hz"):
        yield name, [None, *plain["columns"][name]]
    yield "source", [None, *(_SOURCES[value] for value in plain["columns"]["by_hand"])]
    for name, values in plain["scores"].items():
        yield f"score_{name}", [None, *values]


# -- A series out of Parquet: what is known of all tests at once, their sets when they are asked for


def read_parquet_rows(path: Path, argument: str = "path") -> tuple[list[Row], dict[str, Any] | None]:
    """The tests of a file, and what :func:`~antires_rs.identify_series` was called with."""
    arrow = pyarrow("a series in a file")
    wanted = "a series that antires_rs wrote"
    try:
        with open(path, "rb") as file:
            schema = arrow.parquet.read_schema(file)
        facts = json.loads((schema.metadata or {}).get(b"antires_rs", b"{}"))
    except (arrow.ArrowInvalid, ValueError) as exc:
        reject(argument, f"{str(path)!r}, which cannot be read ({exc})", wanted, "Name another file.")
    if facts.get("format") != FORMAT:
        reject(argument, f"{str(path)!r} of another kind", wanted, "Name another.")
    if facts["version"] > VERSION:
        reject(argument, f"{str(path)!r} of version {facts['version']}", f"{VERSION}", "Update antires_rs.")
    sets = _Sets(path, facts["tests_in_row_group"])
    timed = ["time"] if "time" in schema.names else []
    wanted_columns = ["row", "name", *timed, *facts["conditions"], "failed", "fingerprint", "facts"]
    rows: list[Row] = []
    with arrow.parquet.ParquetFile(path) as opened:
        for group in range(opened.num_row_groups):
            table = opened.read_row_group(group, columns=wanted_columns)
            own = table.filter([row == "test" for row in table.column("row").to_pylist()])
            columns = {name: own.column(name).to_pylist() for name in wanted_columns if name != "time"}
            times = own.column("time").to_numpy() if timed else [None] * own.num_rows
            for i in range(own.num_rows):
                values = {name: columns[name][i] for name in facts["conditions"]}
                failed, known = columns["failed"][i], columns["facts"][i]
                rows.append(
                    Row.of(
                        columns["name"][i],
                        {name: np.nan if value is None else value for name, value in values.items()},
                        times[i],
                        columns["fingerprint"][i],
                        failed if known is not None or failed else "",
                        None if known is None else json.loads(known),
                        partial(sets.plain, len(rows)),
                    )
                )
    return rows, facts["config"]


class _Sets:
    """The sets in a file, by row groups."""

    def __init__(self, path: Path, in_group: int) -> None:
        self._path, self._in_group, self._made = path, in_group, _made(path)
        self._held: dict[int, Columns] = {}

    def plain(self, nth: int) -> Plain:
        """The set of one test as plain data."""
        group, nth = divmod(nth, self._in_group)
        held = self._group(group)
        first = held["first"][nth]
        facts = json.loads(held["facts"][first])
        rows = slice(first + 1, first + 1 + sum(count for _, _, count, _ in facts["tables"]))
        names = dict.fromkeys(name for _, _, _, kinds in facts["tables"] for name in kinds)
        columns = {name: held[name][rows] for name in ("freq_hz", "damping_ratio", "std_hz")}
        columns["by_hand"] = [source == "by hand" for source in held["source"][rows]]
        scores = {name: held[f"score_{name}"][rows] for name in names}
        return {"facts": facts, "columns": columns, "scores": scores}

    def _group(self, group: int) -> Columns:
        if group not in self._held:
            while len(self._held) >= HELD:
                del self._held[next(iter(self._held))]
            if _made(self._path) != self._made:
                got = f"{str(self._path)!r}, which was written anew"
                reject("path", got, "the file that this series was loaded from", "Load it again.")
            with pyarrow("a series in a file").parquet.ParquetFile(self._path) as file:
                held: Columns = file.read_row_group(group).to_pydict()
            held["first"] = [i for i, row in enumerate(held["row"]) if row == "test"]
            self._held[group] = held
        return self._held[group]


def _made(path: Path) -> tuple[int, int]:
    """What is another for a file that was replaced."""
    state = path.stat()
    return state.st_ino, state.st_mtime_ns
