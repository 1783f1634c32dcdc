"""One declaration an option: what it means, of which kind, in which range; everything else is made of it.

A frozen dataclass holds the options of a call. Its fields, made by :func:`option`, say what each means; from
them come the checks of values, the keys of jobs, the arguments of the command line and the words of reports.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Self, TypeVar

import numpy as np

from ..exceptions import reject
from .checks import choice, finite_scalar, integer
from .messages import warn_of_change


def small(sentence: str) -> str:
    """The sentence as it goes on after others."""
    return (sentence[0].lower() if sentence[1].islower() else sentence[0]) + sentence[1:]


@dataclass(frozen=True)
class Option:
    """A sentence, the kind in a job, the range, and the default."""

    sentence: str
    kind: str
    default: Any = None
    low: float | None = None
    high: float | None = None
    low_open: bool = False
    choices: tuple[Any, ...] = ()
    #: What it is a measure in, and the kind of call for which alone it counts; '' for none, and for all.
    unit: str = ""
    scope: str = ""
    flag: str = ""  # the same on the command line, as in ``--max-order N>=2``; '' for an option of jobs alone

    @property
    def explanation(self) -> str:
        """The sentence, after the scope."""
        if not self.scope:
            return self.sentence
        return f"{self.scope[0].upper()}{self.scope[1:]}: {small(self.sentence)}"

    @property
    def shown(self) -> str:
        """The default as a job writes it; '' where there is none."""
        if self.default is None:
            return ""
        if isinstance(self.default, bool):
            return str(self.default).lower()
        return f'"{self.default}"' if isinstance(self.default, str) else str(self.default)

    def check(self, name: str, value: Any) -> None:
        """Raise InvalidInputError for a value of another kind or out of range; None is its absence."""
        if value is None and self.default is None:
            return
        if self.choices:
            choice(name, value, self.choices)
        elif self.kind == "switch":
            choice(name, value, (True, False))
        elif self.kind == "whole":
            low, high = (None if limit is None else int(limit) for limit in (self.low, self.high))
            integer(name, value, low=low, high=high)
        elif self.kind == "number":
            least = -np.inf if self.low is None else self.low
            most = np.inf if self.high is None else self.high
            finite_scalar(name, value, low=least, high=most, low_open=self.low_open)


_KINDS = {bool: "switch", int: "whole", float: "number", str: "text"}


def option(default: Any, sentence: str, *, kind: str = "", **limits: Any) -> Any:
    """A field of :class:`Options`; ``kind`` is that of the default unless it is said."""
    said = Option(sentence, kind or _KINDS[type(default)], default, **limits)
    return field(default=default, metadata={"option": said})


class Options:
    """Base of frozen dataclasses of options, which remember the names that were given."""

    given: frozenset[str]
    left: ClassVar[Mapping[str, str]] = {}  # what was an option until 0.1, and why it is none
    _without_check: ClassVar[tuple[str, ...]] = ()

    def __new__(cls, *_: Any, **given: Any) -> Self:
        """A value that knows its arguments by name: what is given beside a preset wins."""
        made = super().__new__(cls)
        object.__setattr__(made, "given", frozenset(given))
        return made

    @classmethod
    def declared(cls) -> dict[str, Option]:
        """Every option by its name."""
        every = fields(cls)  # type: ignore[arg-type]
        return {one.name: one.metadata["option"] for one in every if "option" in one.metadata}

    def checked(self) -> Self:
        """The same options, or the error that names the first bad one."""
        for name, said in self.declared().items():
            if name not in self._without_check:
                said.check(name, getattr(self, name))
        return self

    def values(self) -> dict[str, Any]:
        """Every option by name with its value."""
        return {name: getattr(self, name) for name in self.declared()}

    def joined(self, more: Mapping[str, Any]) -> Self:
        """These options with more of them by name, where a value is given."""
        own = {name: getattr(self, name) for name in self.given}
        return type(self)(**(own | {name: value for name, value in more.items() if value is not None}))


Chosen = TypeVar("Chosen", bound=Options)


def documented(options: type[Chosen]) -> type[Chosen]:
    """The class with the sentences of its options in place of ``{options}`` in its docstring."""
    rows = []
    for name, one in options.declared().items():
        most = np.inf if one.high is None else one.high
        limits = "" if one.low is None else f" From {one.low:g} to {most:g}."
        rows.append(f"{name} : {one.kind}, by default {one.default}\n        {one.explanation}{limits}")
    options.__doc__ = (options.__doc__ or "").format(options="\n    ".join(rows))
    return options


def gathered(call: str, place: str, kind: type[Chosen], given: Any, older: Mapping[str, Any]) -> Chosen:
    """The options of ``place=``, joined by those given flat, as until 0.1, with a warning."""
    if given is not None and not isinstance(given, kind):
        reject(place, given, f"{kind.__name__}(...), or None", "See its docstring for the options.")
    chosen: Chosen = kind() if given is None else given
    left = [name for name in older if name in chosen.left]
    for name in left:
        warn_of_change(f"{call}: {name} has left and has no effect: {chosen.left[name]}")
    older = {name: value for name, value in older.items() if name not in left}
    for name in older:
        if name not in chosen.declared():
            raise TypeError(f"{call}() got an unexpected keyword argument {name!r}")
    if not older:
        return chosen
    now = ", ".join(f"{place}={type(chosen).__name__}({name}=...)" for name in older)
    warn_of_change(f"{call}: {' and '.join(older)}: write {now}")
    return chosen.joined(older)
