"""What readers and writers take: each common option with its type and default; texts: ``options.txt``.

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


_SECTION = re.compile(r"^(\w+)\n-+\n", re.MULTILINE)
_ITEM = re.compile(r"^(?=\S)", re.MULTILINE)


def _sections(text: str) -> tuple[str, dict[str, str]]:
    """What stands before the first section of a text, and the sections by name."""
    head, *parts = _SECTION.split(text + "\n")
    return head, {name: own.rstrip() + "\n" for name, own in zip(parts[::2], parts[1::2], strict=True)}


#: What all readers, and all writers, have in common.
_COMMON = _sections(Path(__file__).with_name("options.txt").read_text(encoding="utf-8"))[1]

#: Readers of signals by format, and the endings of their files, as :func:`reader` adds them.
READERS: dict[str, Callable[..., Any]] = {}
ENDINGS: dict[str, tuple[str, ...]] = {}


def reader(endings: str) -> Callable[[Made], Made]:
    """A format with files of these endings, read by ``read_`` and its name: signature and docstring with what
    the options are."""

    def described(function: Made) -> Made:
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
        common = {"Returns": f"{made}\n    In SI.\n", "Raises": _COMMON["Raises"], "Warns": _COMMON["Warns"]}
        _document(function, _COMMON["Readers"], common)
        name = function.__name__.removeprefix("read_")
        READERS[name], ENDINGS[name] = function, tuple(endings.split())
        return function

    return described


def writer(function: Made) -> Made:
    """Docstring of a writer with what all of them take."""
    _document(function, _COMMON["Writers"], {"Returns": "pathlib.Path\n", "Raises": _COMMON["Refusals"]})
    return function


def _document(function: Any, texts: str, common: dict[str, str]) -> None:
    """Add the texts of parameters that a docstring does not describe, and what is common to its sections."""
    if function.__doc__ is None:  # python -OO
        return
    head, sections = _sections(inspect.cleandoc(function.__doc__))
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
