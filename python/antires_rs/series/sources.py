"""What a series is made of, one at a time: files, folders, records in memory, functions, a generator."""

from __future__ import annotations

import glob
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

from ..exceptions import Argument
from ..io.readers import ENDINGS
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.pickling import FrozenDict
from ..support.validation import reject

__all__ = ["Source", "Sources", "is_measurement", "listed", "natural"]

_WANTED = (
    "files, a folder, records or responses in memory, functions that give one, or a generator of any of them"
)


@dataclass(frozen=True)
class Source:
    """One test: its name, what is to be identified, and what came with it.

    Attributes
    ----------
    name : str
    given : Path, Recording, FrequencyResponse, callable, or a list of them for repeats of one test
    conditions : dict of str to value
    """

    name: str
    given: Any
    conditions: Mapping[str, Any] = field(default_factory=FrozenDict)


@dataclass(frozen=True)
class Sources:
    """Sources in order, read no further than asked for; ``count`` is None for a generator.

    ``files`` are all of them where they are files.
    """

    each: Iterable[Source]
    count: int | None
    files: Sequence[Path] = ()


def listed(sources: Any, beside: Sequence[Path] = ()) -> Sources:
    """Sources in the order of the tests; files in ``beside`` are none."""
    if isinstance(sources, Recording | FrequencyResponse):
        reject("sources", f"one {type(sources).__name__}", _WANTED, "Put it in a list.")
    if isinstance(sources, str | PathLike):
        files = _files(Path(sources), beside)
        return Sources(_of_files(files), len(files), files)
    if isinstance(sources, Mapping):
        named = [_source(i, (str(name), given), None) for i, (name, given) in enumerate(sources.items())]
        return Sources(_once(named), len(named))
    if not isinstance(sources, Iterable):
        reject("sources", type(sources).__name__, _WANTED, "Put them in a list.")
    if isinstance(sources, Sequence):
        if not len(sources):
            reject("sources", "an empty list", "one test or more", "Name the records.")
        if all(isinstance(one, str | PathLike) for one in sources):
            files = [Path(one) for one in sources]
            return Sources(_of_files(files), len(files), files)
        return Sources(_once(_source(i, one, None) for i, one in enumerate(sources)), len(sources))
    return Sources(_once(_source(i, one, None) for i, one in enumerate(sources)), None)


def _source(number: int, one: Any, name: str | None) -> Source:
    """A source; a tuple may have its name before it and its conditions behind it."""
    argument = Argument("sources").item(number)
    conditions: Mapping[str, Any] = FrozenDict({})
    if isinstance(one, tuple):
        parts = list(one)
        if len(parts) > 1 and isinstance(parts[0], str):
            name = parts.pop(0)
        if len(parts) > 1 and isinstance(parts[-1], Mapping):
            conditions = FrozenDict(parts.pop())
        if len(parts) != 1:
            wanted = "(name, source), (source, conditions) or (name, source, conditions)"
            reject(argument, f"a tuple of {len(one)}", wanted, "Put repeats of one test in a list.")
        one = parts[0]
    given = _given(argument, one)
    return Source(name or (given.name if isinstance(given, Path) else str(number)), given, conditions)


def _given(argument: Argument, one: Any) -> Any:
    if isinstance(one, str | PathLike):
        return Path(one)
    if isinstance(one, list) and one:
        return [_given(argument.item(i), part) for i, part in enumerate(one)]
    if isinstance(one, Recording | FrequencyResponse | Callable):
        return one
    reject(argument, type(one).__name__, _WANTED, "Read or record it first.")


def _of_files(files: list[Path]) -> Iterator[Source]:
    """Files by their names, or by their paths if two names are the same."""
    names = [file.name for file in files]
    if len(set(names)) < len(names):
        names = [file.as_posix() for file in files]
    return _once(Source(name, file) for name, file in zip(names, files, strict=True))


def _once(sources: Iterable[Source]) -> Iterator[Source]:
    """Every name once."""
    seen: set[str] = set()
    for one in sources:
        if one.name in seen:
            reject("sources", f"{one.name!r} more than once", "each test by a name of its own", "Rename one.")
        seen.add(one.name)
        yield one


def _files(path: Path, beside: Sequence[Path]) -> list[Path]:
    """Measurements in a folder, or those that a pattern names, by their names and the numbers in them."""
    if path.is_dir():
        found = [file for file in path.iterdir() if is_measurement(file)]
        where = f"{str(path)!r}, a folder without measurements"
    elif path.exists():
        return [path]
    elif glob.has_magic(str(path)):
        found, where = list(map(Path, glob.glob(str(path)))), f"{str(path)!r}, which names no file"
    else:
        wanted = "a file, a folder, or a pattern such as 'year/*.uff'"
        reject("sources", f"{str(path)!r}, which does not exist", wanted, "Correct the path.")
    others = {file.resolve() for file in beside}
    found = [file for file in found if file.resolve() not in others]
    if not found:
        endings = " ".join(ending for ends in ENDINGS.values() for ending in ends)
        reject("sources", where, f"a folder or a pattern of files that end in {endings}", "Name the files.")
    return sorted(found, key=natural)


def is_measurement(file: Path) -> bool:
    """By its ending; a folder in the folder is a test with a file for each response."""
    if file.name.startswith("."):
        return False
    if file.is_dir():
        return not file.name.endswith(".parts")
    return any(file.suffix.lower() in endings for endings in ENDINGS.values())


def natural(file: Path) -> tuple[Any, ...]:
    """test_2 before test_10."""
    parts = re.split(r"(\d+)", file.name)
    return tuple((int(part), part) if part.isdigit() else (-1, part) for part in parts)
