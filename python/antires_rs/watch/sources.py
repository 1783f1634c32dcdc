"""What a series is made of, one at a time: files, folders, records in memory, functions, a generator."""

from __future__ import annotations

import copy
import glob
import hashlib
import inspect
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import Argument, InvalidInputError, MissingDependencyError, part, reject
from ..identification.identify import identify_antiresonances
from ..identification.options import sorted_out
from ..io.own_format import relabelled
from ..io.registry import ENDINGS, READERS, format_by_ending, read_frf_files
from ..measured.antiresonance_set import AntiresonanceSet
from ..signals.frequency_response import FrequencyResponse
from ..signals.one_force import Finding
from ..signals.recording import Recording
from ..support.messages import unheard
from ..support.progress import apart
from ..support.values import FrozenDict
from .stored_tests import encoded

_WANTED = (
    "files, a folder, records or responses in memory, functions that give one, or a generator of any of them"
)
_ALL_ENDINGS = [ending for endings in ENDINGS.values() for ending in endings]


@dataclass(frozen=True)
class Source:
    """A test: a path, Recording, FrequencyResponse, function or list of repeats, and its conditions."""

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
    if isinstance(sources, Mapping):
        sources = [(str(name), given) for name, given in sources.items()]
    if isinstance(sources, str | PathLike):
        sources = _files(Path(sources), beside)
    elif not isinstance(sources, Iterable):
        reject("sources", type(sources).__name__, _WANTED, "Put them in a list.")
    if not isinstance(sources, Sequence):
        return Sources(_once(_source(i, one) for i, one in enumerate(sources)), None)
    if not len(sources):
        reject("sources", "none", "one test or more", "Name the records.")
    if not all(isinstance(one, str | PathLike) for one in sources):
        return Sources(_once(_source(i, one) for i, one in enumerate(sources)), len(sources))
    files = [Path(one) for one in sources]
    names = [file.name for file in files]
    if len(set(names)) < len(names):  # then by their paths
        names = [file.as_posix() for file in files]
    return Sources(_once(map(Source, names, files)), len(files), files)


def _source(number: int, one: Any) -> Source:
    """A source; a tuple may have its name before it and its conditions behind it."""
    argument = part("sources", number)
    name, conditions = None, {}
    if isinstance(one, tuple):
        parts = list(one)
        if len(parts) > 1 and isinstance(parts[0], str):
            name = parts.pop(0)
        if len(parts) > 1 and isinstance(parts[-1], Mapping):
            conditions = parts.pop()
        if len(parts) != 1:
            wanted = "(name, source), (source, conditions) or (name, source, conditions)"
            reject(argument, f"a tuple of {len(one)}", wanted, "Put repeats of one test in a list.")
        one = parts[0]
    given = _given(argument, one)
    name = name or (given.name if isinstance(given, Path) else str(number))
    return Source(name, given, FrozenDict(conditions))


def _given(argument: Argument, one: Any) -> Any:
    if isinstance(one, str | PathLike):
        return Path(one)
    if isinstance(one, list) and one:
        return [_given(argument.item(i), part) for i, part in enumerate(one)]
    if isinstance(one, Recording | FrequencyResponse | Callable):
        return one
    reject(argument, type(one).__name__, _WANTED, "Read or record it first.")


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
        wanted = f"a folder or a pattern of files that end in {' '.join(_ALL_ENDINGS)}"
        reject("sources", where, wanted, "Name the files.")
    return sorted(found, key=natural)


def is_measurement(file: Path) -> bool:
    """By its ending; a folder in the folder is a test with a file for each response."""
    if file.name.startswith("."):
        return False
    if file.is_dir():
        return not file.name.endswith(".parts")
    return file.suffix.lower() in _ALL_ENDINGS


def natural(file: Path) -> tuple[Any, ...]:
    """test_2 before test_10."""
    parts = re.split(r"(\d+)", file.name)
    return tuple((int(part), part) if part.isdigit() else (-1, part) for part in parts)


# -- One test of a series: read, identified, and made plain data; or the reason why not

Outcome = dict[str, Any] | str  # plain data of a set, or the reason why there is none
Reading = Mapping[str, Any] | Callable[[Path], Any]


@dataclass(frozen=True)
class Instructions:
    """What is done with every source: options of the readers and of the identification."""

    reading: Reading
    options: Mapping[str, Any]


class Unread(str):
    """What stands in place of a source that could not be read, or identified: why."""


def identified(instructions: Instructions, given: Any) -> Outcome:
    """The antiresonances of one source, or in words why there are none."""
    if isinstance(given, Unread):
        return str(given)
    try:
        with unheard(), apart():
            return encoded(set_of(_signal(instructions.reading, given), instructions.options))
    except (MissingDependencyError, MemoryError):
        raise  # of this machine, not of the record
    except Exception as exc:
        return why_not(exc)


def loaded(instructions: Instructions, given: Any) -> Any:
    """The signal of a source, or an :class:`Unread`."""
    return tried(_signal, instructions.reading, given)


def tried(act: Callable[..., Any], *given: Any) -> Any:
    """What ``act(*given)`` returns, or an :class:`Unread` where it fails for the sake of the record."""
    try:
        return act(*given)
    except (MissingDependencyError, MemoryError):
        raise
    except Exception as exc:
        return Unread(why_not(exc))


def why_not(exc: Exception) -> str:
    """The reason that is kept."""
    if isinstance(exc, InvalidInputError):
        return f"{exc.argument}: {exc.got}; wanted {exc.wanted}"
    return f"{type(exc).__name__}: {exc}"


def _signal(reading: Reading, given: Any) -> Any:
    if isinstance(given, list):
        return [_signal(reading, one) for one in given]
    if isinstance(given, Path):
        return reading(given) if callable(reading) else _read(given, dict(reading))
    return given() if callable(given) else given


def _read(file: Path, options: dict[str, Any]) -> Any:
    """A measurement of any format."""
    if file.is_dir():
        return read_frf_files(file, **options)
    kind = options.pop("format", None) or format_by_ending(file.name)
    if kind not in READERS:
        wanted = f"an ending out of {' '.join(_ALL_ENDINGS)}"
        reject("path", repr(str(file)), wanted, "Name its format in reading=.")
    return READERS[kind](file, **options)


def set_of(signal: Any, options: Mapping[str, Any]) -> AntiresonanceSet:
    """Identified, without the sensors that were out."""
    signal, dead = living(signal)
    options = dict(options)
    if dead and options.get("dofs") is not None:
        options["dofs"] = [dof for dof in options["dofs"] if dof not in dead]
    found = identify_antiresonances(signal, **sorted_out(options), progress=False)
    if not found.followed and not sum(map(len, found.tables.values())):
        raise ValueError("no antiresonance was found in the band")
    check = found.data_check
    if dead and check is not None:
        text = f"Dofs {', '.join(map(str, dead))}: constant, left out of this test."
        out = Finding("dead_channel", "warning", dead, 0.0, 0.0, text, "Check sensor and cable.")
        found = copy.copy(found)
        found._fill(data_check=replace(check, findings=(out, *check.findings)))
    return found


def living(signal: Any) -> tuple[Any, tuple[Any, ...]]:
    """Records without the channels that are constant in any of them, and their dofs."""
    records = signal if isinstance(signal, list) else [signal]
    if not all(isinstance(one, Recording) for one in records):
        return signal, ()
    constant = np.any([np.ptp(one.responses, axis=1) == 0.0 for one in records], axis=0)
    if not constant.any() or np.sum(~constant) < 2:  # a single response makes no transmissibility
        return signal, ()
    dofs = records[0].dofs
    labels = [None if off else dof for dof, off in zip(dofs, constant, strict=True)]
    kept = [relabelled(one, labels) for one in records]
    return (kept if isinstance(signal, list) else kept[0]), tuple(dofs[i] for i in np.flatnonzero(constant))


# -- The argument ``reading=`` of a series, checked before the first file is read


def checked_reading(given: Any, files: Sequence[Path]) -> Reading:
    """Options that a reader of these files has, or a function; a wrong one is not kept as failed tests."""
    if given is None or callable(given):
        return given or {}
    if not isinstance(given, Mapping):
        wanted = "options of the readers by name, or a function of a path"
        reject("reading", given, wanted, "As in reading={'unit': 'g'}.")
    chosen = given.get("format")
    if chosen is not None and chosen not in READERS:
        wanted = f"one of {', '.join(READERS)}"
        reject(part("reading", "format"), repr(chosen), wanted, "Leave it out where the endings tell.")
    readers: list[Any] = []
    for file in files:
        kind = chosen or format_by_ending(file.name)
        if file.is_dir():
            readers += [read_frf_files, *READERS.values()]  # it hands options on
        elif kind in READERS:
            readers.append(READERS[kind])
    if not files:  # any reader may come to read
        readers = [READERS[chosen], read_frf_files] if chosen else [*READERS.values(), read_frf_files]
    readers = list(dict.fromkeys(readers or READERS.values()))
    known = {"format"}
    for reader in readers:
        parameters = inspect.signature(reader).parameters.values()
        known |= {one.name for one in parameters if one.kind in (one.KEYWORD_ONLY, one.POSITIONAL_OR_KEYWORD)}
    known -= {"path", "files"}
    for name in given:
        if name not in known:
            names = ", ".join(reader.__name__ for reader in readers)
            got = f"{name!r}, which {names} {'does' if len(readers) == 1 else 'do'} not take"
            reject("reading", got, f"options out of {', '.join(sorted(known))}", "Correct or remove it.")
    return dict(given)


# -- What tells whether a source is the one that was identified before

#: Of a longer file its beginning, middle and end are read: a year of records is looked through in seconds.
WHOLE, PART = 1 << 20, 1 << 16


def fingerprint(given: Any) -> str:
    """Text that is another one for another source; of a function it is empty: its name must do.

    Files are told apart by size and content, of long ones by three parts of it; not by their dates, which
    change when a file is copied.
    """
    digest = hashlib.blake2b(digest_size=16)
    arrays: tuple[Any, ...] = ()
    if isinstance(given, list):
        for one in given:
            digest.update(fingerprint(one).encode())
    elif isinstance(given, Path):
        files = sorted(file for file in given.iterdir() if file.is_file()) if given.is_dir() else [given]
        for file in files:
            _of_file(digest, file)
    elif isinstance(given, Recording):
        digest.update(repr((given.fs_hz, given.dofs)).encode())
        arrays = (given.responses, given.force)
    elif isinstance(given, FrequencyResponse):
        digest.update(repr((given.kind, given.reference, given.dofs, given.n_averages)).encode())
        arrays = (given.freq_hz, given.values, given.coherence, given.std)
    else:
        return ""
    for array in arrays:
        if array is not None:
            digest.update(repr(array.shape).encode())
            digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()


def _of_file(digest: Any, file: Path) -> None:
    try:
        with open(file, "rb") as opened:
            size = opened.seek(0, 2)
            digest.update(f"{file.name} {size} ".encode())
            for at in (0,) if size <= WHOLE else (0, size // 2, size - PART):
                opened.seek(at)
                digest.update(opened.read(WHOLE if size <= WHOLE else PART))
    except OSError as exc:  # it is not there, or may not be read: that is what is known of it
        digest.update(type(exc).__name__.encode())
