"""The results of a series that runs, one line a test, kept as they are made.

Each line is a checksum and JSON. A kill can only tear the last one; whoever opens the file again cuts it off.
A lock that ends with its process keeps a second one out.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from pathlib import Path
from time import monotonic
from typing import Any, Self
from zlib import crc32

from ..measured.antiresonance_set import AntiresonanceSet
from ..support.validation import reject
from .encoded import decoded
from .kept import Kept, Plain

__all__ = ["Journal", "journal_path", "same_config"]

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
