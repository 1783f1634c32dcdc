"""A series as one Parquet file: a long table that any program reads.

Each test has one row with ``row`` "test" (why it failed, how many antiresonances it has, and ``facts``, the
rest as JSON), and behind it one for each antiresonance, each that was seen and not accepted ("left_out") and
each peak without explanation ("unexplained"). Name, time and conditions of the test stand in all of them. A
row group holds ``GROUP`` tests, so that any of them is found without reading the others.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._core import __version__
from ..support.files import written_beside
from .kept import Row
from .pyarrow_package import pyarrow, pyarrow_parquet

__all__ = ["FORMAT", "GROUP", "VERSION", "write_series"]

FORMAT, VERSION = "antires_rs.Series", 1
#: Tests in a row group.
GROUP = 128
_SOURCES = {True: "by hand", False: "identified", None: None}


def write_series(path: Path, rows: Sequence[Row], config: dict[str, Any] | None) -> None:
    """Write all tests, whole or not at all; the bytes depend on nothing else."""
    arrow, parquet = pyarrow("a series in a file"), pyarrow_parquet("a series in a file")
    conditions = list(dict.fromkeys(name for row in rows for name in row.conditions))
    timed = any(row.time is not None and not np.isnat(row.time) for row in rows)
    kinds: dict[str, set[str]] = {}
    for own in {row.kept.kinds for row in rows}:
        for name, kind in own:
            kinds.setdefault(name, set()).add(kind)
    facts = {
        "format": FORMAT,
        "version": VERSION,
        "made_by": __version__,
        "tests": len(rows),
        "tests_in_row_group": GROUP,
        "conditions": conditions,
        "config": config,
    }
    schema = _schema(arrow, conditions, timed, {name: kinds[name] for name in sorted(kinds)})
    schema = schema.with_metadata({"antires_rs": json.dumps(facts)})
    with written_beside(path) as beside:
        with open(beside, "wb") as file, parquet.ParquetWriter(file, schema, compression="zstd") as writer:
            for first in range(0, len(rows), GROUP):
                columns = _columns(first, rows[first : first + GROUP], schema.names, conditions)
                arrays = [arrow.array(columns[field.name], field.type) for field in schema]
                table = arrow.Table.from_arrays(arrays, schema=schema)
                writer.write_table(table, row_group_size=max(table.num_rows, 1))
        with open(beside, "rb+") as written:
            os.fsync(written.fileno())


def _schema(arrow: Any, conditions: list[str], timed: bool, kinds: dict[str, set[str]]) -> Any:
    text, number = arrow.string(), arrow.float64()
    fields = [("row", text), ("test", arrow.int32()), ("name", text)]
    fields += [("time", arrow.timestamp("ms"))] if timed else []
    fields += [(name, number) for name in conditions]
    fields += [("dof", text)] + [(name, number) for name in ("freq_hz", "damping_ratio", "std_hz")]
    fields += [("source", text)]
    for name, own in kinds.items():
        one = {"U": text, "b": arrow.bool_(), "i": arrow.int64(), "f": number}
        fields.append((f"score_{name}", one[min(own)] if len(own) == 1 else text if "U" in own else number))
    fields += [("failed", text), ("count", arrow.int32()), ("fingerprint", text), ("facts", text)]
    return arrow.schema(fields)


def _columns(
    first: int, rows: Sequence[Row], names: list[str], conditions: list[str]
) -> dict[str, list[Any]]:
    columns: dict[str, list[Any]] = {name: [] for name in names}
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
    kept = row.kept
    plain = None if kept.failed is not None else kept.plain()
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
    yield "failed", [kept.failed]
    yield "count", [kept.count]
    yield "fingerprint", [kept.fingerprint]
    if plain is None:
        return
    yield "facts", [json.dumps(plain["facts"], separators=(",", ":"))]
    yield "dof", [None, *(str(dof) for _, dof, count, _ in tables for _ in range(count))]
    for name in ("freq_hz", "damping_ratio", "std_hz"):
        yield name, [None, *plain["columns"][name]]
    yield "source", [None, *(_SOURCES[value] for value in plain["columns"]["by_hand"])]
    for name, values in plain["scores"].items():
        yield f"score_{name}", [None, *values]
