"""Texts of errors that name arguments of a call, for callers who do not write Python.

A job file and the command line spell the same argument in their own way; the text keeps it as data.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

__all__ = ["EDIT_WANTED", "LeftOut", "Part", "Passed", "Wording", "edit_named", "spelled"]

#: How an edit by hand is written in a job and on the command line.
EDIT_WANTED = 'DOF=HZ, such as "3=31.9" or "3=31.9 mains hum"'


@dataclass(frozen=True)
class Passed:
    """An argument, alone or with the value to be passed: ``unit=``, ``first='time'``."""

    name: str
    value: Any = None

    def __str__(self) -> str:
        return f"{self.name}={'' if self.value is None else repr(self.value)}"


@dataclass(frozen=True)
class LeftOut:
    """How one of several is left out by ``dofs``."""

    what: str

    def __str__(self) -> str:
        return f"Map a {self.what} to None to leave it out"


Part = Passed | LeftOut


class Wording(str):
    """A text for who calls from Python; ``template`` has a ``{}`` for each of its parts.

    Examples
    --------
    >>> from antires_rs.support.wording import Passed, Wording, spelled
    >>> text = Wording("Pass {}.", Passed("first", "freq"))
    >>> print(text, spelled(text, lambda part: f"--{part.name} {part.value}"))
    Pass first='freq'. Pass --first freq.
    """

    template: str
    parts: tuple[Part, ...]

    def __new__(cls, template: str, *parts: Part) -> Wording:
        """The text as Python spells the parts."""
        made = super().__new__(cls, template.format(*parts))
        made.template, made.parts = template, parts
        return made

    def __getnewargs__(self) -> Any:
        return (self.template, *self.parts)


def spelled(text: str, spell: Callable[[Part], str]) -> str:
    """A text with its arguments as this caller writes them."""
    return text.template.format(*map(spell, text.parts)) if isinstance(text, Wording) else text


def edit_named(text: str) -> tuple[str, float, str] | None:
    """Dof, frequency in Hz and reason of ``DOF=HZ reason``; None for another text.

    Examples
    --------
    >>> from antires_rs.support.wording import edit_named
    >>> edit_named("3 v=31.9 mains hum"), edit_named("3=soon")
    (('3 v', 31.9, 'mains hum'), None)
    """
    name, _, rest = text.partition("=")
    value, _, reason = rest.strip().partition(" ")
    try:
        freq_hz = float(value)
    except ValueError:
        return None
    return (name.strip(), freq_hz, reason.strip()) if name.strip() and 0.0 < freq_hz < float("inf") else None
