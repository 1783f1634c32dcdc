"""The tests that the rows of a table of conditions are of, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from pathlib import PurePath
from typing import Any

from ..support.validation import reject

__all__ = ["NAMES", "is_one_of", "keys_of", "rows_by_name", "test_names"]

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
