"""Where the results of a series go while it runs, and what becomes of them: in memory, or in a file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ..support.validation import reject
from .journal import Journal, journal_path, same_config
from .kept import Kept, Packed, Plain, Row
from .parquet_file import write_series
from .parquet_reader import SeriesFile
from .pyarrow_package import pyarrow
from .sources import natural

__all__ = ["FileStore", "LastingStore", "MemoryStore", "Store", "open_store", "stored_rows"]


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
