"""Which arrays of a file are responses: by name, by pattern, or single rows of a matrix."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from ..support.validation import reject, shape_of
from ..support.warned import warn
from ._common import unsuitable

__all__ = ["array_of", "chosen_rows", "listed"]

_ROW = re.compile(r"(.+)\[(\d{1,9})\]")


def chosen_rows(
    path: Path, numeric: Mapping[str, NDArray[Any]], responses: Any, taken: set[str]
) -> list[tuple[str, NDArray[Any], str]]:
    """(name, values, array) of every response, in the order asked for; rows of a matrix are ``name[0]``..."""
    if responses is None:
        names = _longest(path, numeric, taken)
        rows = [row for name in names for row in _rows(name, numeric[name])]
    else:
        asked: Sequence[Any] = [responses] if shape_of(responses) == () else list(responses)
        found = {row[0]: row for pattern in asked for row in _asked(path, pattern, numeric, taken)}
        rows = list(found.values())
    if not rows:
        unsuitable(
            path,
            f"with {listed(numeric)}, none of which is a response",
            "arrays of samples",
            "Name them: responses=[...].",
        )
    shared = {n.rpartition(".")[0] for n, _, _ in rows}
    cut = len(shared.pop()) + 1 if len(shared) == 1 and "." in rows[0][0] else 0
    return [(name[cut:], row, raw) for name, row, raw in rows]


def array_of(name: str) -> str:
    """The array of a single row, ``acc`` of ``acc[3]``; any other name as it is."""
    match = _ROW.fullmatch(name)
    return name if match is None else match[1]


def _longest(path: Path, numeric: Mapping[str, NDArray[Any]], taken: set[str]) -> list[str]:
    """Arrays with the most samples, but those that have another role."""
    longest = max((v.shape[1] for n, v in numeric.items() if n not in taken), default=0)
    # Tables of settings are short; what is nearly as long is a channel that was cut.
    short = [
        f"{n} ({v.shape[1]})"
        for n, v in numeric.items()
        if n not in taken and longest > v.shape[1] > longest // 2
    ]
    if short:
        warn(
            "short_arrays",
            f"path: {str(path)!r} has arrays shorter than the {longest} samples of the longest, "
            f"{', '.join(short)}, which are left out. Name the responses= to choose.",
        )
    return [n for n, v in numeric.items() if n not in taken and v.shape[1] == longest and longest > 1]


def _asked(
    path: Path, pattern: Any, numeric: Mapping[str, NDArray[Any]], taken: set[str]
) -> list[tuple[str, NDArray[Any], str]]:
    """The rows that a name or pattern means."""
    if isinstance(pattern, str):
        if pattern in numeric:
            return _rows(pattern, numeric[pattern])
        one = [
            row for row in _rows(array_of(pattern), numeric.get(array_of(pattern), ())) if row[0] == pattern
        ]
        if one:
            return one
        # Names of struct arrays have brackets, which are no patterns.
        hits = [n for n in numeric if fnmatchcase(n, pattern.replace("[", "[[]")) and n not in taken]
        if "*" in pattern and hits:
            return [row for name in hits for row in _rows(name, numeric[name])]
    reject(
        "responses",
        repr(pattern),
        f"arrays of {str(path)!r}: {listed(numeric)}",
        "Correct the pattern; the names of the file are listed.",
    )


def _rows(name: str, values: Any) -> list[tuple[str, NDArray[Any], str]]:
    several = len(values) > 1
    return [(f"{name}[{i}]" if several else name, row, name) for i, row in enumerate(values)]


def listed(arrays: Mapping[str, Any]) -> str:
    """Names and shapes, for a message."""
    shown = [f"{name} {'x'.join(map(str, value.shape))}" for name, value in list(arrays.items())[:20]]
    return ", ".join(shown) + (f" and {len(arrays) - 20} more" if len(arrays) > 20 else "")
