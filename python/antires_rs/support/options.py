"""One declaration an option: what it means, of which kind, in which range; everything else is made of it.

A frozen dataclass holds the options of a call. Its fields, made by :func:`option`, say what each means; from
them come the checks of values, the keys of jobs, the arguments of the command line and the words of reports.

>>> from dataclasses import dataclass
>>> @dataclass(frozen=True, kw_only=True)
... class Shaking(Options):
...     level_g: float = option(0.5, "Level in g.", low=0.0)
>>> Shaking(level_g=0.7).given, Shaking().checked().level_g
(frozenset({'level_g'}), 0.5)
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any, ClassVar, Self

import numpy as np

from .checks import choice, finite_scalar, integer


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
            integer(
                name,
                value,
                low=None if self.low is None else int(self.low),
                high=None if self.high is None else int(self.high),
            )
        elif self.kind == "number":
            low, high = (
                -np.inf if self.low is None else self.low,
                np.inf if self.high is None else self.high,
            )
            finite_scalar(name, value, low=low, high=high, low_open=self.low_open)


_KINDS = {bool: "switch", int: "whole", float: "number", str: "text"}


def option(default: Any, sentence: str, *, kind: str = "", **limits: Any) -> Any:
    """A field of :class:`Options`; ``kind`` is that of the default unless it is said."""
    said = Option(sentence, kind or _KINDS[type(default)], default, **limits)
    return field(default=default, metadata={"option": said})


class Options:
    """Base of frozen dataclasses of options, which remember the names that were given."""

    given: frozenset[str]
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
