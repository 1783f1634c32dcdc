"""What a series is made of, one at a time: files, folders, records in memory, functions, a generator."""

from __future__ import annotations

import copy
import glob
import hashlib
import inspect
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import Argument, InvalidInputError, MissingDependencyError, part, reject
from ..identification.identify import identify_antiresonances
from ..identification.options import sorted_out
from ..io.options import ENDINGS, READERS
from ..io.own_format import relabelled
from ..io.registry import format_by_ending, natural, read_frf_files
from ..measured.antiresonance_set import AntiresonanceSet
from ..signals.findings import Finding
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.messages import some, unheard
from ..support.progress import apart
from ..support.values import FrozenDict
from .stored_tests import encoded

_WANTED = "files, a folder, records or responses, functions that give one, or a generator of any of them"
_ALL_ENDINGS = [ending for endings in ENDINGS.values() for ending in endings]


@dataclass(frozen=True)
class Source:
    """A test: a path, Recording, FrequencyResponse, function or list of repeats, and its conditions."""

    name: str
    given: Any
    conditions: Mapping[str, Any] = field(default_factory=FrozenDict)


@dataclass(frozen=True)
class Sources:
    """Sources in order, read no further than asked for; ``files`` where all are; no count of a generator."""

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
    count, files = None, []
    if isinstance(sources, Sequence):
        count = len(sources)
        if not count:
            reject("sources", "none", "one test or more", "Name the records.")
        if all(isinstance(one, str | PathLike) for one in sources):
            files = [Path(one) for one in sources]
            distinct = len({file.name for file in files}) == count  # else by their paths
            sources = [(file.name if distinct else file.as_posix(), file) for file in files]
    return Sources(_once(sources), count, files)


def _once(sources: Iterable[Any]) -> Iterator[Source]:
    """Every name once; a tuple has the name before a source, and perhaps its conditions behind it."""
    seen: set[str] = set()
    for number, one in enumerate(sources):
        argument = part("sources", number)
        name, conditions = None, {}
        if isinstance(one, tuple):
            if not (len(one) in (2, 3) and isinstance(one[0], str) and isinstance((*one, {})[2], Mapping)):
                wanted = "(name, source) or (name, source, conditions)"
                reject(argument, f"a tuple of {len(one)}", wanted, "Put repeats of one test in a list.")
            name, one, conditions = (*one, {})[:3]
        given = _given(argument, one)
        name = name or (given.name if isinstance(given, Path) else str(number))
        if name in seen:
            reject("sources", f"{name!r} more than once", "each test by a name of its own", "Rename one.")
        seen.add(name)
        yield Source(name, given, FrozenDict(conditions))


def _given(argument: Argument, one: Any) -> Any:
    if isinstance(one, str | PathLike):
        return Path(one)
    if isinstance(one, list) and one:
        return [_given(argument.item(i), part) for i, part in enumerate(one)]
    if isinstance(one, Recording | FrequencyResponse | Callable):
        return one
    reject(argument, type(one).__name__, _WANTED, "Read or record it first.")


def _files(path: Path, beside: Sequence[Path]) -> list[Path]:
    """Measurements in a folder, or those that a pattern names, by their names and the numbers in them."""
    if path.is_dir():
        found, where = list(filter(is_measurement, path.iterdir())), "a folder without measurements"
    elif path.exists():
        return [path]
    elif glob.has_magic(str(path)):
        found, where = list(map(Path, glob.glob(str(path)))), "which names no file"
    else:
        wanted = "a file, a folder, or a pattern such as 'year/*.uff'"
        reject("sources", f"{str(path)!r}, which does not exist", wanted, "Correct the path.")
    others = {file.resolve() for file in beside}
    found = [file for file in found if file.resolve() not in others]
    if not found:
        wanted = f"a folder or a pattern of files that end in {' '.join(_ALL_ENDINGS)}"
        reject("sources", f"{str(path)!r}, {where}", wanted, "Name the files.")
    return sorted(found, key=natural)


def is_measurement(file: Path) -> bool:
    """By its ending; a folder in the folder is a test with a file for each response."""
    if file.is_dir():
        return not file.name.startswith(".") and not file.name.endswith(".parts")
    return not file.name.startswith(".") and file.suffix.lower() in _ALL_ENDINGS


# -- One test of a series: read, identified, and made plain data; or the reason why not

Outcome = dict[str, Any] | str  # plain data of a set, or the reason why there is none
Reading = Mapping[str, Any] | Callable[[Path], Any]


@dataclass(frozen=True)
class Instructions:
    """What is done with every source: options of the readers and of the identification."""

    reading: Reading
    options: Mapping[str, Any]


class Unread(str):
    """What stands in place of a source that could not be read, or identified: why; data may not suit."""

    unsuitable = False


def identified(instructions: Instructions, given: Any) -> Outcome:
    """The antiresonances of one source, or in words why there are none."""

    def found() -> Outcome:
        return encoded(set_of(_signal(instructions.reading, given), instructions.options))

    with unheard(), apart():
        outcome = given if isinstance(given, Unread) else tried(found)
    return str(outcome) if isinstance(outcome, Unread) else outcome


def loaded(instructions: Instructions, given: Any) -> Any:
    """The signal of a source, or an :class:`Unread`."""
    return tried(_signal, instructions.reading, given)


def tried(act: Callable[..., Any], *given: Any) -> Any:
    """What ``act(*given)`` returns, or an :class:`Unread` where it fails for the sake of the record."""
    try:
        return act(*given)
    except MissingDependencyError:
        raise  # of this machine, not of the record
    except Exception as exc:  # MemoryError too: one file of a folder must not end the watch of all others
        found = Unread(why_not(exc))
        found.unsuitable = isinstance(exc, InvalidInputError)
        return found


def why_not(exc: Exception) -> str:
    """The reason that is kept."""
    if isinstance(exc, InvalidInputError):
        return f"{exc.argument}: {exc.got}; wanted {exc.wanted}"
    return f"{type(exc).__name__}: {exc}"


def _signal(reading: Reading, given: Any) -> Any:
    """A measurement of any format."""
    if isinstance(given, list):
        return [_signal(reading, one) for one in given]
    if not isinstance(given, Path):
        return given() if callable(given) else given
    if callable(reading):
        return reading(given)
    options = dict(reading)
    if given.is_dir():
        return read_frf_files(given, **options)
    kind = options.pop("format", None) or format_by_ending(given.name)
    if kind not in READERS:
        wanted = f"an ending out of {' '.join(_ALL_ENDINGS)}"
        reject("path", repr(str(given)), wanted, "Name its format in reading=.")
    return READERS[kind](given, **options)


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
    found = {chosen or format_by_ending(file.name) for file in files if not file.is_dir()}
    readers: list[Any] = [reader for kind, reader in READERS.items() if kind in found]
    if not readers or any(map(Path.is_dir, files)):  # any reader may come to read, through a folder too
        readers = [read_frf_files, *([READERS[chosen]] if chosen else READERS.values())]
    known = {"format", *(name for reader in readers for name in inspect.signature(reader).parameters)}
    known -= {"path", "files", "options"}
    if odd := given.keys() - known:
        wanted = f"options out of {', '.join(sorted(known))}"
        reject("reading", some(map(repr, sorted(odd))), wanted, "Correct or remove them.")
    return dict(given)


# -- What tells whether a source is the one that was identified before

#: Of a longer file its beginning, middle and end are read: a year of records is looked through in seconds.
WHOLE, PART = 1 << 20, 1 << 16


def fingerprint(given: Any) -> str:
    """Text that is another one for another content, of long files by three parts; of a function empty."""
    digest = hashlib.blake2b(digest_size=16)
    arrays: tuple[Any, ...] = ()
    if isinstance(given, list):
        for one in given:
            digest.update(fingerprint(one).encode())
    elif isinstance(given, Path):
        for file in sorted(filter(Path.is_file, given.iterdir())) if given.is_dir() else [given]:
            if file.exists() and not file.is_file():  # a pipe, say, which is not read, would be waited for
                continue
            try:
                with open(file, "rb") as opened:
                    size = opened.seek(0, 2)
                    digest.update(f"{file.name} {size} ".encode())
                    for at in (0,) if size <= WHOLE else (0, size // 2, size - PART):
                        opened.seek(at)
                        digest.update(opened.read(WHOLE if size <= WHOLE else PART))
            except OSError as exc:  # it is not there, or may not be read: that is what is known of it
                digest.update(type(exc).__name__.encode())
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
