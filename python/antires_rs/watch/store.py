"""Where the results of a series go while it runs: in memory, or in an SQLite database, a transaction a test.

A store named ``.sqlite`` is that database. One named ``.parquet`` has it beside, as ``<store>.part``, while
the series runs, and is written from it at the end. A kill costs no result, a power cut perhaps the last ones.
The run holds a transaction open, which ends with its process, to keep a second one out.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any
from zlib import compress, crc32, decompressobj

import numpy as np

from ..exceptions import AntiresError, reject
from ..io.common import DAMAGE, bounded, brief, most_bytes
from ..io.registry import natural
from ..support.files import written_beside
from ..support.messages import some, warn
from .stored_tests import FORMAT, WANTED, Entry, Plain, Row, check_format, pyarrow, read_table, write_table

VERSION = 3  # 2 had no checksums
DATABASES = (".sqlite", ".db")
_SIGNATURE = b"SQLite format 3\0"
_TABLES = """
CREATE TABLE series (name TEXT PRIMARY KEY, value TEXT);
CREATE TABLE tests (place INTEGER PRIMARY KEY, name TEXT UNIQUE, fingerprint TEXT, conditions TEXT, time TEXT,
                    failed TEXT, facts TEXT, columns BLOB, checksum INTEGER);
"""
_COLUMNS = ("name", "fingerprint", "conditions", "time", "failed", "facts", "columns")
_ALL = f"SELECT {', '.join(_COLUMNS)}, checksum FROM tests ORDER BY place"
_DAMAGED = "do not have their checksum"
_BUSY_S = 1.0  # so long the end of another process that writes is waited for
Config = dict[str, Any]


def part_path(store: Path) -> Path:
    """The database beside a store that is a table."""
    return store.with_name(store.name + ".part")


# -- A database of a series: facts about it as JSON by their names, and a row a test


def _text(data: bytes) -> str:
    return data.decode("utf-8", "surrogateescape")  # what is damaged fails its checksum


@contextmanager
def _reading(path: Path) -> Iterator[sqlite3.Connection]:
    try:
        with closing(sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)) as db:
            db.text_factory = _text
            yield db
    except AntiresError:
        raise
    except (sqlite3.Error, *DAMAGE) as exc:
        reject("path", f"{str(path)!r}, which cannot be read ({brief(exc)})", WANTED, "Name another file.")


def _checksum(values: Iterable[Any]) -> int:
    return crc32(repr(tuple(values)).encode("utf-8", "surrogatepass"))


def _read(path: Path, db: sqlite3.Connection, argument: str) -> tuple[list[Row], dict[str, Any]]:
    """The tests of a database in their order, and the facts about the series; none where it was not begun.

    One to be gone on with has to be whole. Of another all is read that is, and told what is not.
    """
    if not db.execute("SELECT * FROM sqlite_master").fetchone():
        return [], {}
    damage = [] if (said := db.execute("PRAGMA integrity_check(1)").fetchone()[0]) == "ok" else [said]
    try:
        facts = {name: json.loads(value) for name, value in db.execute("SELECT name, value FROM series")}
    except ValueError:
        raise sqlite3.DatabaseError(f"the facts about it {_DAMAGED}") from None
    check_format(argument, path, facts, VERSION)
    if facts["version"] == VERSION and facts.pop("checksum", None) != _checksum(sorted(facts.items())):
        damage.append(f"the facts about it {_DAMAGED}")
    if damage and argument == "store":
        raise sqlite3.DatabaseError(damage[0])
    rows, lost = _rows(path, db, facts["version"], damage)
    if lost:
        damage.append(f"{len(lost)} tests are not as they were written: {some(map(repr, lost))}")
    if damage:
        text = f"{argument}: {str(path)!r} is damaged ({'; '.join(damage)}); "
        warn("incomplete_file", text + f"the other {len(rows)} tests were read.")
    return rows, facts


def _rows(path: Path, db: sqlite3.Connection, version: int, damage: list[str]) -> tuple[list[Row], list[str]]:
    """Tests in their order, and names of those that are not as they were written; from both ends up to a page
    that cannot be read."""
    query = _ALL if version >= VERSION else _ALL.replace(" checksum ", " NULL ")
    ways: list[list[tuple[Any, ...]]] = []
    for order in ("", " DESC"):
        ways.append([])
        try:
            ways[-1].extend(iter(db.execute(query + order)))
            break
        except sqlite3.DatabaseError as exc:
            if not damage:
                raise
            damage.append(str(exc))
    rows: dict[str, Row] = {}
    lost = []
    for *values, checksum in dict.fromkeys([*ways[0], *reversed(ways[-1])]):
        name, fingerprint, conditions, time, failed, known, columns = values
        try:
            if version >= VERSION and checksum != _checksum(values):
                raise ValueError(_DAMAGED)
            entry = Entry.kept(name, json.loads(conditions), time, fingerprint)
            plain = partial(_plain, path, name, crc32(columns or b""))
            rows[name] = Row.of(entry, failed, json.loads(known or "null"), plain)
        except DAMAGE:
            lost.append(name)
    return list(rows.values()), lost


def _plain(path: Path, name: str, checksum: int) -> Plain:
    """The set of a test, if it is still the one that was meant."""
    found = None
    if path.exists():
        with _reading(path) as db:
            found = db.execute("SELECT facts, columns FROM tests WHERE name = ?", (name,)).fetchone()
    if found is None or crc32(found[1] or b"") != checksum:
        store = str(path.with_suffix("") if path.suffix == ".part" else path)
        got = f"{str(path)!r}, which has ended or was begun anew"
        wanted = "the database that the sets of this series are in"
        reject("store", got, wanted, f"Load the series as it is now: Series.load({store!r}).")
    unpacked = decompressobj()
    columns = unpacked.decompress(found[1], most_bytes(path))
    if not unpacked.eof:
        bounded(path, most_bytes(path) + 1, f"whose test {name!r} unpacks to more")
    plain: Plain = {"facts": json.loads(found[0])} | json.loads(columns)
    return plain


def _insert(db: sqlite3.Connection, path: Path, row: Row) -> Row:
    """Keep a test behind the others; returns it as it is in the database."""
    facts, columns = None, b""
    if row.failed is None:
        plain = row.plain()
        facts = json.dumps(plain["facts"], separators=(",", ":"))
        columns = compress(json.dumps({name: plain[name] for name in ("columns", "scores")}).encode(), 1)
    values = (row.name, row.fingerprint, *_texts(row), row.failed, facts, columns)
    db.execute(
        "INSERT OR REPLACE INTO tests VALUES (NULL, ?, ?, ?, ?, ?, ?, ?, ?)", (*values, _checksum(values))
    )
    return replace(row, plain=partial(_plain, path, row.name, crc32(columns)))


def _set_facts(db: sqlite3.Connection, **facts: Any) -> None:
    known = {name: json.loads(value) for name, value in db.execute("SELECT name, value FROM series")} | facts
    known.pop("checksum", None)
    facts["checksum"] = _checksum(sorted(json.loads(json.dumps(known)).items()))
    items = [(name, json.dumps(value)) for name, value in facts.items()]
    db.executemany("INSERT OR REPLACE INTO series VALUES (?, ?)", items)


def _seal(db: sqlite3.Connection) -> None:
    """Checksums of all tests as they are now."""
    sums = [(_checksum(values), values[0]) for *values, _ in db.execute(_ALL)]
    db.executemany("UPDATE tests SET checksum = ? WHERE name = ?", sums)


def _begin(db: sqlite3.Connection, config: Config | None, finished: bool) -> None:
    for statement in _TABLES.split(";")[:-1]:
        db.execute(statement)
    _set_facts(db, format=FORMAT, version=VERSION, config=config, finished=finished)


def _texts(row: Row) -> tuple[str, str | None]:
    """What was measured beside, with NaN equal to itself."""
    beside = {name: None if value != value else float(value) for name, value in row.conditions.items()}
    return json.dumps(beside), None if row.time is None or np.isnat(row.time) else str(row.time)


def write_series(
    path: Path, rows: Iterable[Row], config: Config | None = None, finished: bool = True
) -> None:
    """Write all tests, whole or not at all: a database, or a table by its ending."""
    if path.suffix.lower() not in (*DATABASES, ".part"):
        write_table(path, list(rows), config)
        return
    try:
        with written_beside(path) as beside, closing(sqlite3.connect(beside)) as db, db:
            _begin(db, config, finished)
            for row in rows:
                _insert(db, path, row)
    except sqlite3.OperationalError as exc:  # a disk without room, as other files tell it
        raise OSError(f"{str(path)!r} cannot be written ({exc})") from exc


def read_series(path: Path) -> tuple[list[Row], bool]:
    """The tests of a file, and whether a run that has not ended has more of them."""
    part = part_path(path)
    if not path.exists() and not part.exists():
        raise FileNotFoundError(f"there is no series {str(path)!r}")
    rows: dict[str, Row] = {}
    unfinished = part.exists()
    for file in filter(Path.exists, (path, part)):
        if _is_database(file):
            with _reading(file) as db:
                found, facts = _read(file, db, "path")
            unfinished |= not facts.get("finished")
        else:
            found, _ = read_table(file)
        rows |= {row.name: row for row in found}
    return list(rows.values()), unfinished


def _is_database(path: Path) -> bool:
    with open(path, "rb") as file:
        return file.read(len(_SIGNATURE)) == _SIGNATURE


# -- The store of a series that runs


@dataclass(frozen=True)
class LastingStore(PathLike[str]):
    """A store that keeps tests whose sources are gone; all are in the order of their names."""

    path: Path

    def __fspath__(self) -> str:
        return str(self.path)


class Store:
    """Results in memory, where a caller names no store, or in a database."""

    def __init__(self, store: Any, config: Config) -> None:
        self.path: Path | None = None
        self.changed: list[str] = []  # sources that were identified before and are others now
        self._config, self._lasting = config, isinstance(store, LastingStore)
        #: What the finished file holds, if that is of use; and all that is known.
        self._there: list[Row] | None = None
        self._known: dict[str, Row] = {}
        self._db: sqlite3.Connection | None = None
        if store is None:
            return
        known = (".parquet", *DATABASES)
        if not isinstance(store, str | PathLike) or Path(store).suffix.lower() not in known:
            wanted = "the path of a file that ends in .parquet or .sqlite, or None for memory"
            reject("store", store, wanted, "As in store='year.parquet'.")
        path = self.path = Path(store)
        if not path.parent.is_dir() or path.is_dir():
            reject("store", repr(str(path)), "a file in a folder that exists", "Make the folder first.")
        self._file = path if path.suffix.lower() in DATABASES else part_path(path)
        if self._file != path:
            pyarrow("store")  # now rather than after a night
            if path.exists():
                rows, there = read_table(path, "store")
                self._there = rows if self._agrees(path, rows, there) else None
        try:
            self._db, rows = self._opened()
        except AntiresError:
            raise
        except (sqlite3.DatabaseError, *DAMAGE) as exc:
            file = repr(str(self._file))
            if getattr(exc, "sqlite_errorcode", None) in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
                wanted, remedy = "a store of this process alone", "Wait for it, or stop it first."
                reject("store", f"{file}, to which another process writes", wanted, remedy)
            reject("store", f"{file}, which cannot be read ({brief(exc)})", WANTED, "Name another file.")
        self._known = {row.name: row for row in [*(self._there or []), *rows]}

    def _opened(self) -> tuple[sqlite3.Connection, list[Row]]:
        """The database, begun if it is not there, and its tests."""
        file = self._file
        db = sqlite3.connect(file, timeout=_BUSY_S, isolation_level=None)
        db.text_factory = _text
        try:
            db.execute("PRAGMA journal_mode = WAL")
            db.execute("PRAGMA synchronous = NORMAL")
            db.execute("BEGIN IMMEDIATE")
            rows, facts = _read(file, db, "store")
            if facts and facts["version"] < VERSION:
                db.execute("ALTER TABLE tests ADD COLUMN checksum INTEGER")
                _seal(db)
                _set_facts(db, version=VERSION)
            if not facts:
                _begin(db, self._config, False)
            elif not self._agrees(file, rows, facts["config"]):
                rows = []
                db.execute("DELETE FROM tests")
                _set_facts(db, config=self._config, finished=False)
            elif facts["finished"]:
                self._there = rows
            self._commit(db)
        except BaseException:
            db.close()
            raise
        return db, rows

    @staticmethod
    def _commit(db: sqlite3.Connection) -> None:
        """End the transaction that keeps others out, and begin the next."""
        db.execute("COMMIT")
        db.execute("BEGIN IMMEDIATE")

    def _agrees(self, path: Path, rows: Sequence[Row], there: Config | None) -> bool:
        """Whether to go on with results of these options; of others only without a single set."""
        if there is None:
            wanted, remedy = "a store that identify_series made", "Name another store."
            reject("store", f"{str(path)!r}, which Series.save wrote", wanted, remedy)
        if there == self._config:
            return True
        if all(row.failed is not None for row in rows):
            # A wrong band or excitation, and nothing found by it: what is corrected begins anew.
            return False
        name = min(n for n in there.keys() | self._config.keys() if there.get(n) != self._config.get(n))
        got = f"made with {name} = {there.get(name)!r} in place of {self._config.get(name)!r}"
        wanted = "the same options, so that all tests of a series are identified alike"
        remedy = "Name another store for other options, or remove this one to begin anew."
        reject("store", f"{str(path)!r}, {got}", wanted, remedy)

    def known(self, name: str, fingerprint: str) -> Row | None:
        """The result of a source that was identified before, and has not changed since."""
        found = self._known.get(name)
        if found is not None and found.fingerprint != fingerprint:
            self.changed.append(name)
            return None
        return found

    def keep(self, entry: Entry, outcome: Plain | str) -> Row:
        """Keep a result, for good."""
        row = Row.packed(entry, outcome)
        if self._db is not None:
            row = _insert(self._db, self._file, row)
            _set_facts(self._db, finished=False)
            self._commit(self._db)
            self._known[row.name] = row
        return row

    def finish(self, rows: Sequence[Row]) -> Sequence[Row]:
        """All tests are there: write the file, unless it holds just these already."""
        if self.path is None or self._db is None:
            return rows
        gone = sorted(self._known.keys() - {row.name for row in rows})
        if gone and self._lasting:
            both = [*rows, *(self._known[name] for name in gone)]
            rows = sorted(both, key=lambda row: natural(Path(row.name)))
        elif gone:
            shown = ", ".join(map(repr, gone[:3])) + (f" and {len(gone) - 3} more" if len(gone) > 3 else "")
            got = f"no source {shown}, of which {str(self.path)!r} holds a result"
            wanted = "all sources of that series, and what has come since"
            reject("sources", got, wanted, "Put them back, or name another store for other sources.")
        new = self._there is None or list(map(_identity, self._there)) != list(map(_identity, rows))
        if self._file != self.path:
            if new:
                write_table(self.path, rows, self._config)
            self.close()
            self._file.unlink()
            return read_series(self.path)[0]
        if new:  # the order of the tests, and what was measured beside them now
            self._db.execute("UPDATE tests SET place = -place - 1")
            texts = ((place, *_texts(row), row.name) for place, row in enumerate(rows))
            self._db.executemany("UPDATE tests SET place = ?, conditions = ?, time = ? WHERE name = ?", texts)
            _seal(self._db)
            _set_facts(self._db, finished=True)
        self._db.execute("COMMIT")
        self._db.execute("PRAGMA journal_mode = DELETE")  # one file, which a read-only place may hold
        self.close()
        return read_series(self.path)[0]

    def close(self) -> None:
        """Stop in between; what is kept can still be read."""
        if self._db is not None:
            self._db.close()
            self._db = None


def _identity(row: Row) -> Any:
    return row.name, _texts(row), row.fingerprint, row.failed, row.plain
