"""What a series is made of, one at a time: files, folders, records in memory, functions, a generator."""

from __future__ import annotations

import glob
import hashlib
import inspect
import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from ..exceptions import (
    AntiresWarning,
    Argument,
    InvalidInputError,
    MissingDependencyError,
    UnsuitableDataError,
    part,
    reject,
)
from ..identification.identify import identify_antiresonances
from ..identification.options import sorted_out
from ..io.frf_files import read_frf_files
from ..io.own_format import relabelled
from ..io.registry import ENDINGS, READERS, format_by_ending
from ..measured.antiresonance_set import AntiresonanceSet
from ..signals.frequency_response import FrequencyResponse
from ..signals.one_force import DataCheck, Finding
from ..signals.recording import Recording
from ..support.progress import apart
from ..support.values import FrozenDict
from .stored_tests import encoded

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


# -- One test of a series: read, identified, and made plain data; or the reason why not


#: Plain data of a set, or the reason why there is none.
Outcome = dict[str, Any] | str
#: Fewer responses than these make no transmissibility.
LEAST = 2


@dataclass(frozen=True)
class Instructions:
    """What is done with every source: options of the readers and of the identification."""

    reading: Mapping[str, Any] | Callable[[Path], Any]
    options: Mapping[str, Any]


@dataclass(frozen=True)
class Unread:
    """What stands in place of a source that could not be read: why."""

    why: str


def identified(instructions: Instructions, given: Any) -> Outcome:
    """The antiresonances of one source, or in words why there are none."""
    try:
        with _quiet(), apart():
            signal = loaded(instructions, given)
            if isinstance(signal, Unread):
                return signal.why
            return encoded(_set_of(signal, instructions.options))
    except (MissingDependencyError, MemoryError):
        raise  # of this machine, not of the record
    except Exception as exc:
        return why_not(exc)


def loaded(instructions: Instructions, given: Any) -> Any:
    """The signal of a source, or an :class:`Unread`."""
    try:
        return _signal(instructions.reading, given)
    except (MissingDependencyError, MemoryError):
        raise
    except Exception as exc:
        return Unread(why_not(exc))


def why_not(exc: Exception) -> str:
    """The reason that is kept."""
    if isinstance(exc, InvalidInputError | UnsuitableDataError):
        return f"{exc.argument}: {exc.got}; wanted {exc.wanted}"
    return f"{type(exc).__name__}: {exc}"


def _signal(reading: Mapping[str, Any] | Callable[[Path], Any], given: Any) -> Any:
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
        endings = " ".join(ending for ends in ENDINGS.values() for ending in ends)
        reject("path", repr(str(file)), f"an ending out of {endings}", "Name its format in reading=.")
    return READERS[kind](file, **options)


def _set_of(signal: Any, options: Mapping[str, Any]) -> AntiresonanceSet:
    """Identified, without the sensors that were out."""
    signal, dead = _living(signal)
    options = dict(options)
    if dead and options.get("dofs") is not None:
        options["dofs"] = [dof for dof in options["dofs"] if dof not in dead]
    found = identify_antiresonances(signal, **sorted_out(options), progress=False)
    if not sum(map(len, found.tables.values())):
        raise ValueError("no antiresonance was found in the band")
    checked = found.data_check
    if not dead or not isinstance(checked, DataCheck):
        return found
    out = Finding(
        "dead_channel",
        "warning",
        dead,
        0.0,
        0.0,
        f"Dofs {', '.join(map(str, dead))}: constant, left out of this test.",
        "Check sensor and cable.",
    )
    return AntiresonanceSet.from_tables(
        found.excitation,
        found.tables,
        left_out=found.left_out,
        unexplained_hz=found.unexplained_hz,
        sees=found.sees,
        options=found.options,
        channels=found.channels,
        data_check=replace(checked, findings=(out, *checked.findings)),
    )


def _living(signal: Any) -> tuple[Any, tuple[Any, ...]]:
    """Records without the channels that are constant in any of them, and their dofs."""
    records = signal if isinstance(signal, list) else [signal]
    if not all(isinstance(one, Recording) for one in records):
        return signal, ()
    constant = np.any([np.ptp(one.responses, axis=1) == 0.0 for one in records], axis=0)
    rows = np.flatnonzero(~constant).tolist()
    if constant.sum() == 0 or len(rows) < LEAST:
        return signal, ()
    dofs = records[0].dofs
    kept = [relabelled(one, rows, [dofs[i] for i in rows]) for one in records]
    return (kept if isinstance(signal, list) else kept[0]), tuple(dofs[i] for i in np.flatnonzero(constant))


_lock = Lock()
_inside = 0
_before: Any = None


@contextmanager
def _quiet() -> Iterator[None]:
    """No warnings of this package: findings are kept with each test. Threads share the filters."""
    global _inside, _before
    with _lock:
        if _inside == 0:
            _before = warnings.catch_warnings()
            _before.__enter__()
            warnings.simplefilter("ignore", AntiresWarning)
        _inside += 1
    try:
        yield
    finally:
        with _lock:
            _inside -= 1
            if _inside == 0:
                _before.__exit__(None, None, None)
                _before = None


# -- The argument ``reading=`` of a series, checked before the first file is read


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


# -- What tells whether a source is the one that was identified before


#: Of a longer file its beginning, middle and end are read: a year of records is looked through in seconds.
WHOLE, PART = 1 << 20, 1 << 16


def fingerprint(given: Any) -> str:
    """Text that is another one for another source; of a function it is empty: its name must do.

    Files are told apart by size and content, of long ones by three parts of it; not by their dates, which
    change when a file is copied.
    """
    digest = hashlib.blake2b(digest_size=16)
    if isinstance(given, list):
        for one in given:
            digest.update(fingerprint(one).encode())
    elif isinstance(given, Path):
        files = sorted(file for file in given.iterdir() if file.is_file()) if given.is_dir() else [given]
        for file in files:
            _of_file(digest, file)
    elif isinstance(given, Recording):
        digest.update(repr((given.fs_hz, given.dofs)).encode())
        _of_array(digest, given.responses)
        _of_array(digest, given.force)
    elif isinstance(given, FrequencyResponse):
        digest.update(repr((given.kind, given.reference, given.dofs, given.n_averages)).encode())
        for array in (given.freq_hz, given.values, given.coherence, given.std):
            _of_array(digest, array)
    else:
        return ""
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


def _of_array(digest: Any, array: Any) -> None:
    if array is not None:
        digest.update(repr(array.shape).encode())
        digest.update(np.ascontiguousarray(array).data)
