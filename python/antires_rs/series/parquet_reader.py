"""A series out of its file: what is known of all tests at once, their sets when they are asked for."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..support.validation import reject
from .encoded import decoded
from .kept import Kept, Plain, Row
from .parquet_file import FORMAT, VERSION
from .pyarrow_package import pyarrow, pyarrow_parquet

__all__ = ["SeriesFile"]

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
