"""One test of a series: read, identified, and made plain data; or the reason why not."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np

from ..data_check import DataCheck, Finding
from ..exceptions import AntiresWarning, InvalidInputError, MissingDependencyError, UnsuitableDataError
from ..identification.identify import identify_antiresonances
from ..io import read_frf_files
from ..io.own import relabelled
from ..io.readers import ENDINGS, READERS, format_by_ending
from ..measured.antiresonance_set import AntiresonanceSet
from ..signals.recording import Recording
from ..support.progress import apart
from ..support.validation import reject
from .encoded import encoded

__all__ = ["Instructions", "Outcome", "Unread", "identified", "loaded", "why_not"]

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
    found = identify_antiresonances(signal, **options, progress=False)
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
