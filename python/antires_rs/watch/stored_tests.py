"""What is kept of one test, and many of them as one long table that any program reads: Parquet or CSV.

Each test has one row with ``row`` "test" (why it failed, how many antiresonances it has, and ``facts``, the
rest as JSON), and behind it one for each antiresonance, each that was seen and not accepted ("left_out") and
each peak without explanation ("unexplained"). Name, time and conditions of the test stand in all of them. A
row group of Parquet holds ``GROUP`` tests, so that any of them is found without reading the others.
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from functools import lru_cache, partial
from pathlib import Path
from typing import Any
from zlib import compress, decompress

import numpy as np

from .._core import __version__
from ..exceptions import AntiresError, reject
from ..io.child_process import Limits, in_a_child
from ..io.common import DAMAGE, brief, require
from ..io.table_files import tried_parquet
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.edits import BY_HAND
from ..measured.response_table import NUMBERS, ResponseTable
from ..signals.findings import DataCheck, Finding
from ..support.checks import Dofs
from ..support.files import cell, written_beside
from ..support.values import frozen

# -- A set of antiresonances as plain data: facts about its tables, and columns with a row an antiresonance
#
# This is what a worker sends back, a database holds, and the rows of a table are made of. Nothing
# is lost but diagrams and curves of the data check; floats keep every bit.

Plain = dict[str, Any]
#: What a row of a set is: accepted, seen and not accepted, a peak that nothing explains.
GROUPS = ("antiresonance", "left_out", "unexplained")
#: Columns of every row with the letters of their types; scores stand beside them by their names.
COLUMNS = dict.fromkeys(NUMBERS, "f") | {"by_hand": "b"}
_CASTS = {"f": np.float64, "i": np.int64, "b": np.bool_, "U": np.str_}
_ARROW = {"f": "double", "i": "int64", "b": "bool", "U": "string", "n": "int32", "M": "timestamp[ms]"}
#: What is kept of a data check beside its findings.
_OF_CHECK = ("not_tested", "dofs", "excitation", "band_hz", "n_averages", "nperseg")


def encoded(found: AntiresonanceSet) -> dict[str, Any]:
    """``facts``, ``columns`` and ``scores``, fit for JSON but for NaN in the data check."""
    peaks = {dof: ResponseTable(freq) for dof, freq in found.unexplained_hz.items()}
    grouped = zip(GROUPS, (found.tables, found.left_out, peaks), strict=True)
    tables = [(group, dof, table) for group, own in grouped for dof, table in own.items()]
    letters = dict(zip("fibuU", "fibiU", strict=True))  # of the types that scores come back as
    kinds = [{k: letters.get(v.dtype.kind, "U") for k, v in table.scores.items()} for *_, table in tables]
    columns: dict[str, list[Any]] = {name: [] for name in COLUMNS}
    scores: dict[str, list[Any]] = {name: [] for own in kinds for name in own}
    for *_, table in tables:
        for name, column in columns.items():
            column += _plain(getattr(table, name))
        for name, column in scores.items():
            column += _plain(table.scores[name]) if name in table.scores else [None] * len(table)
    counted = [[group, dof, len(table), own] for (group, dof, table), own in zip(tables, kinds, strict=True)]
    facts = {"excitation": found.excitation, "sees": found.sees, "channels": list(found.channels)}
    facts |= {"tables": counted, "check": None, "options": dict(found.options)}
    if isinstance(check := found.data_check, DataCheck):
        findings = [asdict(finding) | {"where": list(finding.where)} for finding in check.findings]
        facts["check"] = {"findings": findings} | {name: getattr(check, name) for name in _OF_CHECK}
    if found.edits:
        facts["edited"] = found.to_json()
    return {"facts": facts, "columns": columns, "scores": scores}


def decoded(plain: Mapping[str, Any]) -> AntiresonanceSet:
    """The set of :func:`encoded`."""
    facts, columns, scores = plain["facts"], plain["columns"], plain["scores"]
    if "edited" in facts:
        return AntiresonanceSet.from_json(facts["edited"])
    tables: dict[str, dict[Any, ResponseTable]] = {group: {} for group in GROUPS}
    first = 0
    for group, dof, count, kinds in facts["tables"]:
        rows = slice(first, first + count)
        first += count
        own = {name: _column(columns[name][rows], kind) for name, kind in COLUMNS.items()}
        known = {name: _column(scores[name][rows] if count else [], kind) for name, kind in kinds.items()}
        tables[group][Dofs.of_file(dof)] = ResponseTable(**own, scores=known)
    check = facts["check"]
    if check is not None:
        findings = tuple(Finding(**row | {"where": tuple(row["where"])}) for row in check["findings"])
        tuples = {name: tuple(check[name]) for name in ("dofs", "band_hz")}
        check = DataCheck(**check | tuples | {"findings": findings})
    accepted, left_out, peaks = (tables[group] for group in GROUPS)
    about = {name: facts.get(name) for name in ("sees", "channels", "options")}
    unexplained = {dof: frozen(table.freq_hz) for dof, table in peaks.items()}
    about |= {"left_out": left_out, "unexplained_hz": unexplained, "data_check": check}
    return AntiresonanceSet.from_tables(facts["excitation"], accepted, **about)


def _plain(values: Any) -> list[Any]:
    """NaN becomes None."""
    return [None if value != value else value for value in values.tolist()]


def _column(values: Sequence[Any], kind: str) -> Any:
    """None becomes NaN."""
    known = [np.nan if value is None else value for value in values] if kind == "f" else list(values)
    return np.array(known, dtype=_CASTS[kind])


@dataclass(frozen=True, slots=True)
class Entry:
    """A test: its name, what was measured beside it, its time (datetime64 or None), what tells its source."""

    name: str
    conditions: Mapping[str, float]
    time: Any
    fingerprint: str

    @classmethod
    def kept(cls, name: str, conditions: Mapping[str, float | None], time: Any, fingerprint: str) -> Entry:
        """Out of a file, in which null stands for NaN."""
        known = {key: np.nan if value is None else float(value) for key, value in conditions.items()}
        if not (isinstance(name, str) and isinstance(fingerprint, str)):
            raise TypeError(f"the name {name!r}")
        return cls(name, known, None if time is None else np.datetime64(time, "ms"), fingerprint)


@dataclass(frozen=True, slots=True)
class Row(Entry):
    """A test with its result: what is asked often, scores with letters of types, ``plain`` gets its set."""

    failed: str | None
    count: int
    excitation: Any
    dofs: tuple[Any, ...]
    kinds: tuple[tuple[str, str], ...]
    plain: Callable[[], Plain]

    @classmethod
    def of(
        cls, entry: Entry, failed: str | None, facts: Mapping[str, Any] | None, plain: Callable[[], Plain]
    ) -> Row:
        """A test that failed, or a set of which the facts are known."""
        tables = facts["tables"] if facts else []
        accepted = [(Dofs.of_file(dof), count) for group, dof, count, _ in tables if group == GROUPS[0]]
        dofs, counts = ([one[at] for one in accepted] for at in range(2))
        kinds = sorted({item for *_, kinds in tables for item in kinds.items()})
        own = {each.name: getattr(entry, each.name) for each in fields(Entry)}
        force = Dofs.of_file(facts["excitation"]) if facts else None
        own |= {"failed": failed, "count": sum(counts), "excitation": force}
        return cls(**own, dofs=tuple(dict.fromkeys(dofs)), kinds=tuple(kinds), plain=plain)  # hashable

    @classmethod
    def packed(cls, entry: Entry, outcome: Plain | str) -> Row:
        """An outcome held in memory, packed: 3 kB where a set of eight responses has 60."""
        if isinstance(outcome, str):
            return cls.of(entry, outcome, None, dict)
        data = compress(json.dumps(outcome).encode(), 1)
        return cls.of(entry, None, outcome["facts"], lambda: json.loads(decompress(data)))


class StoredSets(Sequence[AntiresonanceSet | None]):
    """The sets of some tests, made when they are asked for."""

    def __init__(self, rows: Sequence[Row]) -> None:
        self.rows = tuple(rows)

    def take(self, at: Iterable[int]) -> StoredSets:
        """Those of some tests."""
        return StoredSets([self.rows[i] for i in at])

    def __getitem__(self, at: Any) -> Any:
        if isinstance(at, slice):
            return StoredSets(self.rows[at])
        row = self.rows[at]
        if row.failed is not None:
            return None
        try:
            return decoded(row.plain())
        except AntiresError:
            raise
        except DAMAGE as exc:
            got = f"a series whose test {row.name!r} is damaged ({type(exc).__name__}: {brief(exc)})"
            reject("path", got, WANTED, "Restore the file from a copy, or identify its tests anew.")

    def __len__(self) -> int:
        return len(self.rows)

    def __reduce__(self) -> Any:
        return tuple, (list(self),)


def parts_of(rows: Sequence[Row]) -> dict[str, Any]:
    """Arguments of a :class:`~antires_rs.Series` of these tests."""
    times = np.array(["NaT" if row.time is None else row.time for row in rows], dtype="datetime64[ms]")
    conditions = _conditions_of(rows)
    return {
        "sets": StoredSets(rows),
        "names": [row.name for row in rows],
        "conditions": {name: [row.conditions.get(name, np.nan) for row in rows] for name in conditions},
        "times": None if np.isnat(times).all() else times,
        "failed": {i: row.failed for i, row in enumerate(rows) if row.failed is not None},
        "excitation": next((row.excitation for row in rows if row.failed is None), None),
        "dofs": tuple(dict.fromkeys(dof for row in rows for dof in row.dofs)),
    }


def _conditions_of(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(name for row in rows for name in row.conditions))


# -- Many tests as a table

FORMAT, VERSION = "antires_rs.Series", 1
GROUP, HELD = 128, 2  # tests in a row group, and row groups that are held as plain data once they were read
#: Columns with the letters of their types, n a short integer: of every row, conditions behind them; of an
#: antiresonance, its scores behind them; of the row of a test.
OF_ALL = {"row": "U", "test": "n", "name": "U", "time": "M"}
OF_VALUE = {"dof": "U"} | dict.fromkeys(NUMBERS, "f") | {"source": "U"}
OF_TEST = {"failed": "U", "count": "n", "fingerprint": "U", "facts": "U"}
WANTED = "a series that antires_rs wrote"
Columns = dict[str, list[Any]]
#: Tables that this process wrote, or that a child read without harm, by what tells their state.
_TRIED: set[tuple[int, ...]] = set()


def pyarrow(what: str = "a series in a file") -> Any:
    """The package, imported where a file is asked for, or the error that names the extra."""
    require(what, "pyarrow", "series")
    import pyarrow.parquet

    return pyarrow


def check_format(argument: str, path: Path, facts: Mapping[str, Any], newest: int) -> None:
    """Refuse a file that is no series, or of a version to come."""
    if facts.get("format") != FORMAT:
        reject(argument, f"{str(path)!r} of another kind", WANTED, "Name another.")
    if facts.get("version", newest + 1) > newest:
        got = f"{str(path)!r} of version {facts.get('version')}"
        reject(argument, got, f"{newest}", "Update antires_rs.")


def _state(path: Path) -> tuple[int, ...]:
    found = path.stat()
    return found.st_dev, found.st_ino, found.st_mtime_ns, found.st_size


def write_table(path: Path, rows: Sequence[Row], config: dict[str, Any] | None) -> None:
    """Write all tests, whole or not at all; the bytes depend on nothing else."""
    conditions = _conditions_of(rows)
    scores: dict[str, str] = {}
    for name, kind in sorted({item for own in {row.kinds for row in rows} for item in own}):
        # A score that has several types is of floats, or of texts if it has any.
        known = scores.get(f"score_{name}", kind)
        scores[f"score_{name}"] = kind if known == kind else "U" if "U" in (known, kind) else "f"
    fields = OF_ALL | dict.fromkeys(conditions, "f") | OF_VALUE | scores | OF_TEST
    if not any(row.time is not None and not np.isnat(row.time) for row in rows):
        del fields["time"]
    facts = {"format": FORMAT, "version": VERSION, "made_by": __version__, "tests": len(rows)}
    facts |= {"tests_in_row_group": GROUP, "conditions": conditions, "config": config}
    firsts = range(0, len(rows), GROUP)
    groups = (_columns(first, rows[first : first + GROUP], fields, conditions) for first in firsts)
    with written_beside(path) as beside:
        if path.suffix.lower() == ".csv":
            with open(beside, "w", encoding="utf-8", newline="") as file:
                lines = csv.writer(file, lineterminator="\n")
                lines.writerow(map(cell, fields))
                for columns in groups:
                    lines.writerows(zip(*(map(cell, column) for column in columns.values()), strict=True))
        else:
            arrow = pyarrow()
            types = {name: arrow.type_for_alias(_ARROW[kind]) for name, kind in fields.items()}
            schema = arrow.schema(types).with_metadata({"antires_rs": json.dumps(facts)})
            write = arrow.parquet.ParquetWriter
            options = {"compression": "zstd", "write_page_checksum": True}
            with open(beside, "wb") as binary, write(binary, schema, **options) as writer:
                for columns in groups:
                    arrays = [arrow.array(columns[field.name], field.type) for field in schema]
                    table = arrow.Table.from_arrays(arrays, schema=schema)
                    writer.write_table(table, row_group_size=max(table.num_rows, 1))
        with open(beside, "rb+") as written:
            os.fsync(written.fileno())
    _TRIED.add(_state(path))


def _columns(first: int, rows: Sequence[Row], fields: Iterable[str], conditions: Sequence[str]) -> Columns:
    """The rows of some tests, a test's own first; what is missing behind it is null."""
    columns: Columns = {name: [] for name in fields}
    for number, row in enumerate(rows, start=first):
        plain = None if row.failed is not None else row.plain()
        tables = plain["facts"]["tables"] if plain else []
        of_rows = [(group, str(dof)) for group, dof, count, _ in tables for _ in range(count)]
        many = 1 + len(of_rows)
        own: Columns = {
            "row": ["test", *(group for group, _ in of_rows)],
            "test": [number] * many,
            "name": [row.name] * many,
            "time": [None if row.time is None or np.isnat(row.time) else row.time] * many,
            "failed": [row.failed],
            "count": [row.count],
            "fingerprint": [row.fingerprint],
        }
        for name in conditions:
            value = row.conditions.get(name, np.nan)
            own[name] = [None if value != value else value] * many
        if plain:
            found = plain["columns"] | {f"score_{name}": column for name, column in plain["scores"].items()}
            found["dof"] = [dof for _, dof in of_rows]
            found["source"] = [BY_HAND if by_hand else "identified" for by_hand in found["by_hand"]]
            own["facts"] = [json.dumps(plain["facts"], separators=(",", ":"))]
            own |= {name: [None, *column] for name, column in found.items()}
        for name, column in columns.items():
            given = own.get(name, [])
            column += given + [None] * (many - len(given))
    return columns


# -- A series out of Parquet: what is known of all tests at once, their sets when they are asked for


@contextmanager
def _reading(path: Path, argument: str) -> Iterator[None]:
    """Whatever pyarrow says of a damaged table is told as such."""
    try:
        yield
    except (AntiresError, FileNotFoundError):
        raise
    except (OSError, *DAMAGE, pyarrow().ArrowException) as exc:
        got = f"{str(path)!r}, which cannot be read ({brief(exc)})"
        reject(argument, got, WANTED, "Name another file.")


def read_table(path: Path, argument: str = "path") -> tuple[list[Row], dict[str, Any] | None]:
    """The tests of a file, and what :func:`~antires_rs.identify_series` was called with."""
    if (state := _state(path)) not in _TRIED:
        in_a_child(tried_parquet, path, WANTED, Limits(120.0, 8.0))
        _TRIED.add(state)
    with _reading(path, argument):
        return _rows_of_table(path, argument)


def _rows_of_table(path: Path, argument: str) -> tuple[list[Row], dict[str, Any] | None]:
    arrow = pyarrow()
    with open(path, "rb") as file:
        schema = arrow.parquet.read_schema(file)
    facts = json.loads((schema.metadata or {}).get(b"antires_rs", b"{}"))
    check_format(argument, path, facts, VERSION)
    sets = _Sets(path, facts["tests_in_row_group"])
    names = ["row", "name", *facts["conditions"], "failed", "fingerprint", "facts"]
    timed = ["time"] if "time" in schema.names else []
    rows: list[Row] = []
    with arrow.parquet.ParquetFile(path, page_checksum_verification=True) as opened:
        for group in range(opened.num_row_groups):
            table = opened.read_row_group(group, columns=names + timed)
            own = table.filter([row == "test" for row in table.column("row").to_pylist()])
            times = own.column("time").to_numpy() if timed else [None] * own.num_rows
            for one, time in zip(own.select(names).to_pylist(), times, strict=True):
                values = {name: one[name] for name in facts["conditions"]}
                entry = Entry.kept(one["name"], values, time, one["fingerprint"])
                known = json.loads(one["facts"] or "null")
                failed = one["failed"] if known is not None or one["failed"] else ""
                rows.append(Row.of(entry, failed, known, partial(sets.plain, len(rows))))
    return rows, facts["config"]


class _Sets:
    """The sets in a file, by row groups."""

    def __init__(self, path: Path, in_group: int) -> None:
        self._path, self._in_group, self._state = path, in_group, _state(path)
        self._group = lru_cache(HELD)(self._read)

    def plain(self, nth: int) -> Plain:
        """The set of one test as plain data."""
        group, nth = divmod(nth, self._in_group)
        held, firsts = self._group(group)
        first = firsts[nth]
        facts = json.loads(held["facts"][first])
        rows = slice(first + 1, first + 1 + sum(count for _, _, count, _ in facts["tables"]))
        columns = {name: held[name][rows] for name in COLUMNS if name in held}
        columns["by_hand"] = [source == BY_HAND for source in held["source"][rows]]
        scores = {name: held[f"score_{name}"][rows] for *_, kinds in facts["tables"] for name in kinds}
        return {"facts": facts, "columns": columns, "scores": scores}

    def _read(self, group: int) -> tuple[Columns, list[int]]:
        """Columns of a row group, and where its tests begin."""
        if _state(self._path) != self._state:
            got = f"{str(self._path)!r}, which was written anew"
            reject("path", got, "the file that this series was loaded from", "Load it again.")
        file = pyarrow().parquet.ParquetFile
        with _reading(self._path, "path"), file(self._path, page_checksum_verification=True) as opened:
            held: Columns = opened.read_row_group(group).to_pydict()
        return held, [i for i, row in enumerate(held["row"]) if row == "test"]
