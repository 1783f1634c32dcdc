"""The argument ``reading=`` of a series, checked before the first file is read."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..io import read_frf_files
from ..io.readers import READERS, format_by_ending
from ..support.validation import part, reject

__all__ = ["checked_reading"]

Reading = dict[str, Any] | Callable[[Path], Any]


def checked_reading(given: Any, files: Sequence[Path]) -> Reading:
    """Options that a reader of these files has, or a function; a wrong one is not kept as failed tests.

    Raises
    ------
    InvalidInputError
        It is neither, or an option or a format is not known.
    """
    if given is None or callable(given):
        return given or {}
    if not isinstance(given, Mapping):
        wanted = "options of the readers by name, or a function of a path"
        reject("reading", given, wanted, "As in reading={'unit': 'g'}.")
    chosen = given.get("format")
    if chosen is not None and chosen not in READERS:
        wanted = f"one of {', '.join(READERS)}"
        reject(part("reading", "format"), repr(chosen), wanted, "Leave it out where the endings tell.")
    readers = _readers(chosen, files)
    known = {"format"}.union(*map(_options, readers))
    for name in given:
        if name not in known:
            got = f"{name!r}, which {_named(readers)} {'does' if len(readers) == 1 else 'do'} not take"
            reject("reading", got, f"options out of {', '.join(sorted(known))}", "Correct or remove it.")
    return dict(given)


def _readers(chosen: str | None, files: Sequence[Path]) -> list[Callable[..., Any]]:
    """Those that will read the files; all of them where that is not known."""
    if not files:
        return [READERS[chosen], read_frf_files] if chosen else [*READERS.values(), read_frf_files]
    found: dict[Callable[..., Any], None] = {}
    for file in files:
        if file.is_dir():
            found |= dict.fromkeys([read_frf_files, *READERS.values()])  # it hands options on
        elif (kind := chosen or format_by_ending(file.name)) in READERS:
            found[READERS[kind]] = None
    return list(found) or list(READERS.values())


def _options(reader: Callable[..., Any]) -> Iterable[str]:
    """Names of its options, without the path."""
    return [
        name
        for name, one in inspect.signature(reader).parameters.items()
        if one.kind in (one.KEYWORD_ONLY, one.POSITIONAL_OR_KEYWORD) and name not in ("path", "files")
    ]


def _named(readers: list[Callable[..., Any]]) -> str:
    return ", ".join(reader.__name__ for reader in readers)
