"""Where the results of a series go while it runs, and what becomes of them: in memory, or in a file."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from time import monotonic
from typing import Any, Protocol, Self
from zlib import crc32

import numpy as np

from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from .series_parquet import SeriesFile, pyarrow, write_series
from .sources import natural
from .stored_tests import Kept, Packed, Plain, Row, decoded

# -- The results of a series that runs, one line a test, kept as they are made
#
# Each line is a checksum and JSON. A kill can only tear the last one; whoever opens the file again cuts it
# off. A lock that ends with its process keeps a second one out.


FORMAT, VERSION = "antires_rs.Series.journal", 1
#: Lines are flushed to the disk this often: a power cut costs so much, a kill nothing.
FLUSH_S = 2.0


def journal_path(store: Path) -> Path:
    """The journal of a file."""
    return store.with_name(store.name + ".part")


class Journal:
    """An open journal, at its end.

    Attributes
    ----------
    kept : dict of str to (Kept, conditions, time)
        What it holds, by the name of the test; the last of each name.
    """

    def __init__(self, path: Path, config: dict[str, Any] | None) -> None:
        self.path = path
        self.kept: dict[str, tuple[Kept, dict[str, Any], str | None]] = {}
        #: Checksums of the lines by the bytes at which they begin.
        self._sums: dict[int, int] = {}
        self._file = -1
        if config is not None:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
            _lock(self._file, path)
        self._flushed = monotonic()
        try:
            self._end = self._taken_up(config)
        except BaseException:
            self.close()
            raise
        if config is not None:
            os.ftruncate(self._file, self._end)
            os.lseek(self._file, self._end, os.SEEK_SET)
            if not self._end:
                self._write({"format": FORMAT, "version": VERSION, "config": config})

    @classmethod
    def read(cls, path: Path) -> Self:
        """A journal as it is now, which another process may go on with."""
        return cls(path, None)

    def append(
        self, name: str, fingerprint: str, conditions: dict[str, Any], time: str | None, outcome: Plain | str
    ) -> Kept:
        """Keep the outcome of one test."""
        line = {"name": name, "fingerprint": fingerprint, "conditions": conditions, "time": time}
        key = self._write(line | {"outcome": outcome})
        kept = Kept.of(fingerprint, outcome, self, key)
        self.kept[name] = kept, conditions, time
        return kept

    def plain(self, key: int) -> Plain:
        """The set whose line begins at a byte.

        Raises
        ------
        InvalidInputError
            The series was finished meanwhile, or another one was begun in its place.
        """
        line = b""
        with suppress(FileNotFoundError), open(self.path, "rb") as file:
            file.seek(key)
            line = file.readline()
        data = _parsed(line)
        if not data or int(line[:8], 16) != self._sums[key]:
            store = str(self.path.with_suffix(""))
            got = f"{str(self.path)!r}, which has ended or was begun anew"
            wanted = "the journal that the sets of this unfinished series are in"
            reject("store", got, wanted, f"Load the series as it is now: Series.load({store!r}).")
        found: Plain = data["outcome"]
        return found

    def set(self, key: int) -> AntiresonanceSet:
        """The set itself."""
        return decoded(self.plain(key))

    def close(self) -> None:
        """Flush; what is kept can still be read."""
        if self._file >= 0:
            with suppress(OSError):
                os.fsync(self._file)
            os.close(self._file)
            self._file = -1

    def remove(self) -> None:
        """Close for good: another file holds all of it."""
        if os.name == "posix":
            self.path.unlink(missing_ok=True)
        self.close()
        self.path.unlink(missing_ok=True)

    def _write(self, line: dict[str, Any]) -> int:
        text = json.dumps(line, separators=(",", ":")).encode()
        start, checksum = self._end, crc32(text)
        data = memoryview(b"%08x %s\n" % (checksum, text))
        self._sums[start] = checksum
        self._end += len(data)
        while data:
            data = data[os.write(self._file, data) :]
        if monotonic() - self._flushed > FLUSH_S:
            os.fsync(self._file)
            self._flushed = monotonic()
        return start

    def _taken_up(self, config: dict[str, Any] | None) -> int:
        """Read what is whole; returns where it ends: at 0 if it is of other options and holds no set."""
        end, head = 0, {}
        with open(self.path, "rb") as file:
            for line in file:
                data = _parsed(line)
                if not data:
                    break
                if end == 0:
                    _check(self.path, data)
                    head = data
                else:
                    kept = Kept.of(data["fingerprint"], data["outcome"], self, end)
                    self._sums[end] = int(line[:8], 16)
                    self.kept[data["name"]] = kept, data["conditions"], data["time"]
                end += len(line)
        if not head or config is None or head["config"] == config:
            return end
        if any(kept.failed is None for kept, _, _ in self.kept.values()):
            same_config(self.path, head["config"], config)
        self.kept.clear()
        return 0


def _parsed(line: bytes) -> dict[str, Any]:
    """What a line holds; empty if it is torn."""
    try:
        text = line[9:-1]
        if line[-1:] != b"\n" or int(line[:8], 16) != crc32(text):
            return {}
        data = json.loads(text)
    except ValueError:
        return {}
    return data if isinstance(data, dict) else {}


def _check(path: Path, data: dict[str, Any]) -> None:
    if data.get("format") != FORMAT or data.get("version") != VERSION:
        reject("store", f"{str(path)!r} of another kind", "a journal of this version", "Name another store.")


def same_config(path: Path, there: dict[str, Any] | None, config: dict[str, Any]) -> None:
    """Refuse to go on with other options than those that a store was begun with."""
    if there is None:
        wanted, remedy = "a store that identify_series made", "Name another store."
        reject("store", f"{str(path)!r}, which Series.save wrote", wanted, remedy)
    for name in sorted(there.keys() | config.keys()):
        if there.get(name) != config.get(name):
            reject(
                "store",
                f"{str(path)!r}, made with {name} = {there.get(name)!r} in place of {config.get(name)!r}",
                "the same options, so that all tests of a series are identified alike",
                "Name another store for other options, or remove this one to begin anew.",
            )


def _lock(file: int, path: Path) -> None:
    """Keep other processes out; where there are no locks, trust."""
    try:
        import fcntl
    except ImportError:
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(file)
        reject(
            "store",
            f"{str(path)!r}, to which another process writes",
            "a store of this process alone",
            "Wait for it, or stop it first.",
        )


class Store(Protocol):
    """What keeps results."""

    def known(self, name: str, fingerprint: str) -> Kept | None:
        """The result of a source that was identified before, and has not changed since."""

    def keep(
        self, name: str, fingerprint: str, conditions: Mapping[str, float], time: Any, outcome: Plain | str
    ) -> Kept:
        """Keep a result, for good."""

    def finish(self, rows: Sequence[Row]) -> Sequence[Row]:
        """All tests are there."""

    def close(self) -> None:
        """Stop in between; what is kept can still be read."""


class MemoryStore:
    """Results in memory, nothing of before."""

    def __init__(self) -> None:
        self._place = Packed()

    def known(self, name: str, fingerprint: str) -> None:
        """Nothing is."""

    def keep(
        self, name: str, fingerprint: str, conditions: Mapping[str, float], time: Any, outcome: Plain | str
    ) -> Kept:
        """Its plain data are kept."""
        return Kept.of(fingerprint, outcome, self._place, self._place.add(outcome))

    def finish(self, rows: Sequence[Row]) -> Sequence[Row]:
        """Nothing is left to do."""
        return rows

    def close(self) -> None:
        """Nothing is open."""


@dataclass(frozen=True)
class LastingStore(PathLike[str]):
    """A store that keeps tests whose sources are gone; all are in the order of their names."""

    path: Path

    def __fspath__(self) -> str:
        return str(self.path)


class FileStore:
    """Results in a journal while a series runs, and in one file when it is through.

    Attributes
    ----------
    changed : list of str
        Sources that were identified before and are others now.
    """

    def __init__(self, path: Path, config: dict[str, Any], *, lasting: bool = False) -> None:
        pyarrow("store")  # now rather than after a night
        self.path, self.config, self._lasting = path, config, lasting
        self.changed: list[str] = []
        self._file: SeriesFile | None = None
        if path.exists():
            self._file = SeriesFile(path, "store")
            if all(row.kept.failed is not None for row in self._file.rows) and self._file.config is not None:
                # A wrong band or excitation, and nothing found by it: what is corrected begins anew.
                self._file = self._file if self._file.config == config else None
            else:
                same_config(path, self._file.config, config)
        self._before = {row.name: row.kept for row in self._file.rows} if self._file else {}
        self._journal = Journal(journal_path(path), config)

    def known(self, name: str, fingerprint: str) -> Kept | None:
        """From the journal, or from the file of an earlier run."""
        found = self._journal.kept[name][0] if name in self._journal.kept else self._before.get(name)
        if found is not None and found.fingerprint != fingerprint:
            self.changed.append(name)
            return None
        return found

    def keep(
        self, name: str, fingerprint: str, conditions: Mapping[str, float], time: Any, outcome: Plain | str
    ) -> Kept:
        """One more line of the journal."""
        beside = {key: None if value != value else value for key, value in conditions.items()}
        when = None if time is None or np.isnat(time) else str(time)
        return self._journal.append(name, fingerprint, beside, when, outcome)

    def finish(self, rows: Sequence[Row]) -> Sequence[Row]:
        """Write the file, unless it holds just this already; the journal is no longer needed."""
        gone = sorted(self._names() - {row.name for row in rows})
        if gone and self._lasting:
            here = {row.name for row in rows}
            stored = _with_journal(self._file.rows if self._file else [], self._journal)
            both = [*rows, *(row for row in stored if row.name not in here)]
            rows = sorted(both, key=lambda row: natural(Path(row.name)))
        elif gone:
            self.close()
            shown = ", ".join(map(repr, gone[:3])) + (f" and {len(gone) - 3} more" if len(gone) > 3 else "")
            reject(
                "sources",
                f"no source {shown}, of which {str(self.path)!r} holds a result",
                "all sources of that series, and what has come since",
                "Put them back, or name another store for other sources.",
            )
        if self._file is None or not _same(self._file.rows, rows):
            write_series(self.path, rows, self.config)
        self._journal.remove()
        return stored_rows(self.path)[0]

    def close(self) -> None:
        """The journal stays."""
        self._journal.close()

    def _names(self) -> set[str]:
        return self._before.keys() | self._journal.kept.keys()


def open_store(store: Any, config: dict[str, Any]) -> MemoryStore | FileStore:
    """The store that a caller names; None for memory."""
    if store is None:
        return MemoryStore()
    lasting = isinstance(store, LastingStore)
    store = store.path if isinstance(store, LastingStore) else store
    wanted = "the path of a file that ends in .parquet, or None for memory"
    if not isinstance(store, str | PathLike) or Path(store).suffix.lower() != ".parquet":
        reject("store", store, wanted, "As in store='year.parquet'.")
    path = Path(store)
    if not path.parent.is_dir() or path.is_dir():
        reject("store", repr(str(path)), "a file in a folder that exists", "Make the folder first.")
    return FileStore(path, config, lasting=lasting)


def stored_rows(path: Path) -> tuple[list[Row], bool]:
    """The tests of a file, and whether a run that has not ended has more of them beside it."""
    if not path.exists() and not journal_path(path).exists():
        raise FileNotFoundError(f"there is no series {str(path)!r}")
    rows = SeriesFile(path).rows if path.exists() else []
    unfinished = journal_path(path).exists()
    if unfinished:
        rows = _with_journal(rows, Journal.read(journal_path(path)))
    return rows, unfinished


def _with_journal(rows: list[Row], journal: Journal) -> list[Row]:
    found = {row.name: row for row in rows}
    for name, (kept, conditions, time) in journal.kept.items():
        values = {key: np.nan if value is None else value for key, value in conditions.items()}
        found[name] = Row(name, values, None if time is None else np.datetime64(time, "ms"), kept)
    return list(found.values())


def _same(one: Sequence[Row], other: Sequence[Row]) -> bool:
    return len(one) == len(other) and all(
        a.kept is b.kept and a.name == b.name and _beside(a) == _beside(b)
        for a, b in zip(one, other, strict=True)
    )


def _beside(row: Row) -> Any:
    """What was measured beside, with NaN equal to itself."""
    time = None if row.time is None or np.isnat(row.time) else row.time
    return {key: None if value != value else float(value) for key, value in row.conditions.items()}, time
