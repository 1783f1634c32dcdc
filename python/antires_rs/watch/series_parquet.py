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
from ..exceptions import reject
from ..io.common import missing_package
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.files import written_beside
from .stored_tests import Kept, Plain, Row, decoded

# -- The package that reads and writes Parquet, imported where a file is asked for


def pyarrow(what: str) -> Any:
    """The package, or the error that names the extra."""
    try:
        import pyarrow
    except ImportError as exc:
        raise missing_package(what, "pyarrow", "series", exc) from exc
    return pyarrow


def pyarrow_parquet(what: str) -> Any:
    """Its module for Parquet."""
    from importlib import import_module

    return import_module(f"{pyarrow(what).__name__}.parquet")


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


# -- A series out of its file: what is known of all tests at once, their sets when they are asked for


#: Row groups that are held as plain data.
HELD = 2


class SeriesFile:
    """An open file.

    Attributes
    ----------
    rows : list of Row
    config : dict or None
        What :func:`~antires_rs.identify_series` was called with.
    """

    def __init__(self, path: Path, argument: str = "path") -> None:
        self.path = path
        arrow, parquet = pyarrow("a series in a file"), pyarrow_parquet("a series in a file")
        try:
            with open(path, "rb") as file:
                schema = parquet.read_schema(file)
            facts = json.loads((schema.metadata or {}).get(b"antires_rs", b"{}"))
        except (arrow.ArrowInvalid, ValueError) as exc:
            got = f"{str(path)!r}, which cannot be read ({exc})"
            reject(argument, got, "a series that antires_rs wrote", "Name another file.")
        if facts.get("format") != FORMAT:
            reject(
                argument, f"{str(path)!r} of another kind", "a series that antires_rs wrote", "Name another."
            )
        if facts["version"] > VERSION:
            reject(
                argument, f"{str(path)!r} of version {facts['version']}", f"{VERSION}", "Update antires_rs."
            )
        self.config: dict[str, Any] | None = facts["config"]
        self._in_group: int = facts["tests_in_row_group"]
        self._made = _made(path)
        self._held: dict[int, dict[str, list[Any]]] = {}
        with parquet.ParquetFile(path) as opened:
            self.rows = self._all_rows(opened, facts["conditions"])

    def plain(self, key: int) -> Plain:
        """The set of one test as plain data."""
        group, nth = divmod(key, self._in_group)
        held = self._group(group)
        first = held["first"][nth]
        facts = json.loads(held["facts"][first])
        rows = slice(first + 1, first + 1 + sum(count for _, _, count, _ in facts["tables"]))
        names = dict.fromkeys(name for _, _, _, kinds in facts["tables"] for name in kinds)
        columns = {name: held[name][rows] for name in ("freq_hz", "damping_ratio", "std_hz")}
        columns["by_hand"] = [source == "by hand" for source in held["source"][rows]]
        scores = {name: held[f"score_{name}"][rows] for name in names}
        return {"facts": facts, "columns": columns, "scores": scores}

    def set(self, key: int) -> AntiresonanceSet:
        """The set itself."""
        return decoded(self.plain(key))

    def _group(self, group: int) -> dict[str, list[Any]]:
        if group not in self._held:
            while len(self._held) >= HELD:
                del self._held[next(iter(self._held))]
            if _made(self.path) != self._made:
                got = f"{str(self.path)!r}, which was written anew"
                reject("path", got, "the file that this series was loaded from", "Load it again.")
            with pyarrow_parquet("a series in a file").ParquetFile(self.path) as file:
                held = file.read_row_group(group).to_pydict()
            held["first"] = [i for i, row in enumerate(held["row"]) if row == "test"]
            self._held[group] = held
        return self._held[group]

    def _all_rows(self, opened: Any, conditions: list[str]) -> list[Row]:
        known = set(opened.schema_arrow.names)
        timed = ["time"] if "time" in known else []
        wanted = ["row", "name", *timed, *conditions, "failed", "fingerprint", "facts"]
        rows: list[Row] = []
        for group in range(opened.num_row_groups):
            table = opened.read_row_group(group, columns=wanted)
            own = table.filter([row == "test" for row in table.column("row").to_pylist()])
            columns = {name: own.column(name).to_pylist() for name in wanted if name != "time"}
            times = own.column("time").to_numpy() if timed else [None] * own.num_rows
            for i in range(own.num_rows):
                values = {name: columns[name][i] for name in conditions}
                rows.append(
                    Row(
                        columns["name"][i],
                        {name: np.nan if value is None else value for name, value in values.items()},
                        times[i],
                        self._kept(len(rows), *(columns[n][i] for n in ("fingerprint", "failed", "facts"))),
                    )
                )
        return rows

    def _kept(self, key: int, fingerprint: str, failed: str | None, facts: str | None) -> Kept:
        if failed is not None or facts is None:
            return Kept.of(fingerprint, failed or "", self, key)
        return Kept.of_facts(fingerprint, json.loads(facts), self, key)


def _made(path: Path) -> tuple[int, int]:
    """What is another for a file that was replaced."""
    state = path.stat()
    return state.st_ino, state.st_mtime_ns
