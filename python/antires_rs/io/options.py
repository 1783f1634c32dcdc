"""What readers and writers take: each common option with its type, its text and its default once.

A reader names its family of options, ``**options: Unpack[Selected]``; :func:`reader` puts them into its
signature and their texts into its docstring.
"""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypedDict, TypeVar, get_args, get_type_hints

from ..support.checks import finite_scalar
from .common import existing_file

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
    align: bool = False

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
    align: bool


class OfArrays(OverEither, total=False):
    """Options for files of named arrays."""

    responses: Any
    time: str | None
    freq: str | None


class OfColumns(OverEither, total=False):
    """Options for tables."""

    responses: Any
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
align : bool
    Take gaps and jitter in the time as they are. Only :func:`align` uses a record with gaps.
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
