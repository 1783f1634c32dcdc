"""What all readers share: files and packages named in errors, rates of instants, options of a call."""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn, TypedDict, TypeVar, get_args, get_type_hints

import numpy as np

from ..exceptions import AntiresError, MissingDependencyError, UnsuitableDataError, reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.checks import finite_scalar
from ..support.messages import warn

#: Parts of a record whose mean steps are compared, and by how much they may differ relatively.
_PARTS, _DRIFT = 32, 1e-3
_EVEN = "instants in s, evenly spaced and ascending"

Signal = Recording | FrequencyResponse


def existing_file(path: str | os.PathLike[str]) -> Path:
    """The path of a file that is there and not empty."""
    if not isinstance(path, str | os.PathLike):
        reject("path", path, "the path of a file", "Pass a text or a pathlib.Path.")
    file = Path(path)
    if file.is_dir():
        reject("path", str(file), "a file, not a folder", "Name one of the files in it.")
    if file.stat().st_size == 0:
        unsuitable(file, "which is empty", "a file with data", "Copy or export it again.")
    return file


def unsuitable(path: Path, found: str, wanted: str, remedy: str) -> NoReturn:
    """Raise for a file that is damaged or of another kind."""
    raise UnsuitableDataError("path", f"{str(path)!r}, {found}", wanted, remedy)


def brief(exc: BaseException) -> str:
    """The first line of an error of another package, at most so long that it can be read."""
    said = (str(exc).splitlines() or [""])[0]
    return said[:120] if said and said.isprintable() else type(exc).__name__


def missing_part(path: Path, found: str, wanted: str, partial: bool, kept: int) -> None:
    """A file of which a part is missing: an error, or with ``partial`` a warning that counts it."""
    if partial and kept:
        warn("incomplete_file", f"path: {str(path)!r} is incomplete: {found}; what is whole was read.")
        return
    more = ", or pass partial=True to read what is whole" if kept else ""
    unsuitable(path, found, wanted, f"Copy or export it again{more}.")


@contextmanager
def parts_of(path: Path, wanted: str, remedy: str, found: str = "which is damaged") -> Iterator[None]:
    """Where a signal or a result is made of the parts of a file; one that is missing or odd is told."""
    try:
        yield
    except AntiresError:
        raise
    except (KeyError, TypeError, AttributeError, IndexError, ValueError) as exc:
        unsuitable(path, f"{found} ({type(exc).__name__}: {exc})", wanted, remedy)


def choose_run(count: int) -> str:
    """What to do with a file of several runs."""
    return f"Choose one by run=1 to run={count}, and give them together as repeats of one test."


def refuse_real(path: Path, rows: Sequence[tuple[Any, Any]]) -> None:
    """Refuse names and responses if one is real, or all imaginary parts vanish; ones are references."""
    real = next((name for name, row in rows if not np.iscomplexobj(row)), None)
    vary = any((row != row[:1]).any() for _, row in rows)
    if real is not None or (vary and not any(np.any(row.imag) for _, row in rows)):
        found = "whose responses have no imaginary part" if real is None else f"whose {real} is real"
        remedy = "export real and imaginary part, or magnitude and phase."
        wanted = "complex FRFs or transmissibilities"
        unsuitable(path, found, wanted, f"Magnitudes alone have lost the phase: {remedy}")


def require(what: str, module: str, extra: str, package: str = "") -> None:
    """Raise where a package is not installed, without importing it; the error names the extra to install."""
    try:
        there = find_spec(module) is not None
    except ModuleNotFoundError:  # of a package above it
        there = False
    if not there:
        package = package or module
        how = f'pip install "antires-rs[{extra}]", or: pip install {package}'
        raise MissingDependencyError(f"{what} needs {package}; install it with: {how}")


def simplest_rate(low: float, high: float) -> float:
    """The rate in [low, high] that is the simplest number, or whose step is; both positive."""

    def simplest(low: float, high: float) -> float:
        numbers = (float(f"{0.5 * (low + high):.{digits}e}") for digits in range(16))
        return next((number for number in numbers if low <= number <= high), 0.5 * (low + high))

    def key(number: float, rate: float) -> tuple[int, float, float]:
        # Of equally simple ones, the nearer to the middle.
        digits = f"{number:.15e}".partition("e")[0].rstrip("0")
        return len(digits), abs(rate - 0.5 * (low + high)), rate

    rate, step = simplest(low, high), simplest(1.0 / high, 1.0 / low)
    return min(key(rate, rate), key(step, 1.0 / step))[2]


def rate_of(path: Path, times: Any, *, digits: float = 1e-9) -> float:
    """Sampling rate of even instants in s, the simplest their rounding allows; gaps are refused."""
    if times.size < 2 or not np.isfinite(times).all():
        found = f"whose {times.size} instants are too few or not finite"
        unsuitable(path, found, _EVEN, "Correct the instants, or leave them out and pass the rate.")
    span, rounding = float(times[-1] - times[0]), digits * float(np.abs(times).max())
    step = span / (times.size - 1)
    if span <= 0.0:
        found = "whose time does not ascend"
        unsuitable(path, found, _EVEN, "Sort the rows by time, or leave the instants out and pass the rate.")
    # A lost sample moves its neighbour by a whole step; a tenth is jitter no writer makes by rounding.
    late = np.flatnonzero(np.abs(np.diff(times) - step) > max(0.1 * step, 2.0 * rounding))
    if late.size:
        i = int(late[0])
        found = f"with {times[i]:.9g} s followed by {times[i + 1]:.9g} s after steps of {step:.6g} s"
        remedy = "Samples are missing, or the sampling was uneven."
        unsuitable(path, f"{found} ({late.size} such gaps)", _EVEN, remedy)
    # Steps may also change in the course of the record, each by less than counts as a gap. Jitter of single
    # instants averages out over a part; its two ends have at most a tenth of a step each.
    width = max(times.size // _PARTS, 16)
    edges = np.arange(0, times.size - 1, width)
    steps = np.diff(times[edges]) / width
    odd = np.abs(steps - step)
    if edges.size > 2 and odd.max() > _DRIFT * step + (2.0 * rounding + 0.2 * step) / width:
        i = int(np.argmax(odd))
        where = f"from {times[edges[i]]:.9g} to {times[edges[i + 1]]:.9g} s"
        found = f"whose steps are {steps[i]:.6g} s on average {where}, and {step:.6g} s in all"
        remedy = "The sampling rate drifts: resample it to even steps, or cut out a part with an even rate."
        unsuitable(path, found, _EVEN, remedy)
    count = times.size - 1
    return simplest_rate(count / (span + 2.0 * rounding), count / max(span - 2.0 * rounding, 0.5 * span))


# -- What readers and writers take: each common option with its type, its text and its default once
#
# A reader names its family of options, ``**options: Unpack[Selected]``; :func:`reader` puts them into its
# signature and their texts into its docstring.

PathLike = str | os.PathLike[str]
#: How a user names dofs: in the order of the channels, by the channel's own name, or by a function of it.
Dofs = Iterable[Any] | Mapping[Any, Any] | Callable[[Any], Any] | None
Made = TypeVar("Made", bound=Callable[..., Any])


@dataclass(frozen=True)
class Reading:
    """What a caller says of a file; each reader has some of these options."""

    responses: Any = None
    time: str | None = None
    freq: str | None = None
    first: str | None = None
    fs_hz: float | None = None
    dofs: Dofs = None
    force: Any = "auto"
    unit: str | None = None
    kind: str | None = None
    reference: Any = None
    pairs: str | None = None
    freq_hz: Any = None
    df_hz: float | None = None

    @property
    def rate_hz(self) -> float | None:
        """The sampling rate that is given, checked."""
        if self.fs_hz is None:
            return None
        return finite_scalar("fs_hz", self.fs_hz, low=0.0, low_open=True, unit="Hz")


class Named(TypedDict, total=False):
    """Options of all readers."""

    dofs: Dofs
    force: Any
    unit: str | None


class Selected(Named, total=False):
    """Options for files of channels that state their own rate."""

    responses: Any


class Rated(Selected, total=False):
    """Options for files of channels that may lack a rate."""

    fs_hz: float | None


class OverEither(Named, total=False):
    """Options for files of records or of responses over frequency."""

    fs_hz: float | None
    kind: str | None
    reference: Any
    freq_hz: Any
    df_hz: float | None


class OfArrays(OverEither, total=False):
    """Options for files of named arrays."""

    responses: Any
    time: str | None
    freq: str | None


class OfColumns(OverEither, total=False):
    """Options for tables."""

    first: str | None
    pairs: str | None


_TEXTS = """
path : path-like
responses : str or sequence of str, optional
    Names of the responses, ``*`` for any text; by default all that have no other role. A matrix gives one
    channel for each row, the longer axis being time or frequency.
time, freq : str, optional
    Name of the time or the frequency; by default the array called so.
first : {"time", "freq", "channel"}, optional
    What the first column is. By default its name tells, and complex columns lie over frequency.
fs_hz : float, optional
    Sampling rate, where the file has none and no time; in place of the file's where it has one.
dofs : sequence, mapping or callable, optional
    Dof of each response: in order, by name, or a function of the name; None leaves one out. Default: the
    names, or 0, 1, ... without names.
force : str or None
    Name of the force; "auto" takes the one in N or called force, if there is one; None leaves it out.
unit : str, optional
    Unit of the responses, in place of the file's: ``'m/s2'``, ``'g'``, ``'g/N'`` and the like; SI by default.
kind, reference
    Of responses over frequency: as in :class:`FrequencyResponse`; "frf" by default.
pairs : {"real_imag", "magnitude_deg", "magnitude_rad", "db_deg", "db_rad"}, optional
    What two neighbouring columns after the first are, where their names do not tell.
freq_hz : (n_freq,), optional
    Frequencies of the responses, where the file does not hold them. Of a matrix the axis of that length is
    frequency.
df_hz : float, optional
    Their spacing from 0 Hz on, in place of ``freq_hz``.
partial : bool
    Read what is whole of a file that was cut, with a warning that counts what is missing.
time_limit_s, memory_limit_gb : float
    Limits of the child process that reads (the memory's where the system has such limits).
"""
_RAISES = """
UnsuitableDataError
    A file that is cut, damaged or of another kind, or whose channels do not fit together: other rates,
    lengths or starts, gaps in time, names that leave open what is what.
InvalidInputError
    Options that do not fit the file.
MissingDependencyError
    The package that reads the format, where it takes one, is not installed.
FileNotFoundError
    There is none.
"""
_WARNS = """
AntiresWarning
    Units that are unknown or missing, another rate than ``fs_hz``, parts that are left out.
"""
_WRITER = """
path : path-like
    Replaced if it exists.
signal : Recording or FrequencyResponse
"""
_WRITER_RAISES = """
InvalidInputError
    The folder does not exist, or dofs that are neither integers nor strings.
"""
_SECTION = re.compile(r"^(\w+)\n-+\n", re.MULTILINE)
_ITEM = re.compile(r"^(?=\S)", re.MULTILINE)


def reader(function: Made) -> Made:
    """Signature and docstring of a reader with what its options are."""
    own = inspect.signature(function)
    path, *rest = (each for each in own.parameters.values() if each.kind is not each.VAR_KEYWORD)
    shared = []
    if "options" in own.parameters:
        (family,) = get_args(get_type_hints(function)["options"])
        shared = [
            inspect.Parameter(each.name, path.KEYWORD_ONLY, default=each.default, annotation=each.type)
            for each in fields(Reading)
            if each.name in family.__annotations__
        ]
    parameters = [path, *shared, *rest]
    function.__signature__ = own.replace(parameters=parameters)  # type: ignore[attr-defined]
    made = "Recording" if own.return_annotation == "Recording" else "Recording or FrequencyResponse"
    common = {"Returns": f"{made}\n    In SI.\n", "Raises": _RAISES.lstrip(), "Warns": _WARNS.lstrip()}
    _document(function, _TEXTS, common)
    return function


def writer(function: Made) -> Made:
    """Docstring of a writer with what all of them take."""
    _document(function, _WRITER, {"Returns": "pathlib.Path\n", "Raises": _WRITER_RAISES.lstrip()})
    return function


def _document(function: Any, texts: str, common: dict[str, str]) -> None:
    """Add the texts of parameters that a docstring does not describe, and what is common to its sections."""
    if function.__doc__ is None:  # python -OO
        return
    head, *parts = _SECTION.split(inspect.cleandoc(function.__doc__) + "\n")
    sections = {name: text.rstrip() + "\n" for name, text in zip(parts[::2], parts[1::2], strict=True)}
    own = sections.get("Parameters", "")
    order = list(inspect.signature(function).parameters)
    lacking = set(order) - set(_names(own))
    items = [*_ITEM.split(own), *(item for item in _ITEM.split(texts) if lacking & set(_names(item)))]
    items = [item for item in items if item.strip()]
    sections["Parameters"] = "".join(sorted(items, key=lambda item: order.index(_names(item)[0])))
    for name, text in common.items():
        there = set(_names(sections.get(name, "")))
        more = [item for item in _ITEM.split(text) if not there & set(_names(item))]
        sections[name] = sections.get(name, "") + "".join(more)
    headings = ("Parameters", "Returns", "Raises", "Warns", "Notes", "Examples")
    written = [f"{name}\n{'-' * len(name)}\n{sections[name]}" for name in headings if name in sections]
    function.__doc__ = "\n".join([head.rstrip() + "\n", *written])


def _names(items: str) -> list[str]:
    """Names of the parameters that a section describes."""
    heads = [item.partition("\n")[0].partition(" : ")[0] for item in _ITEM.split(items) if item.strip()]
    return [name.strip() for head in heads for name in head.split(",")]


def opened(function: Callable[..., Any], path: Any, options: Mapping[str, Any]) -> tuple[Path, Reading]:
    """The file of a call, and its options."""
    odd = next((name for name in options if name not in inspect.signature(function).parameters), None)
    if odd is not None:
        raise TypeError(f"{function.__name__}() got an unexpected keyword argument {odd!r}")
    return existing_file(path), Reading(**options)
