"""What a server asks of what it shows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

__all__ = ["Arguments", "Refused", "View"]

Arguments = Mapping[str, Any]


class View(Protocol):
    """What the server shows: a set that is edited, or a result."""

    title: str
    #: Commands that take long; the others are answered at once.
    slow: frozenset[str]

    def state(self, shown: int) -> dict[str, Any]:
        """What stands beside the figures, as plain data."""

    def figure(self, shown: int) -> dict[str, Any]:
        """A figure as ``Bokeh.embed.embed_item`` takes it."""

    def do(self, command: str, arguments: Arguments) -> str:
        """Carry out a command; what was done, in words."""

    def file(self) -> tuple[str, str] | None:
        """Name and text of what can be downloaded."""


class Refused:
    """In place of a view: why there is none."""

    slow: frozenset[str] = frozenset()

    def __init__(self, title: str, why: Exception) -> None:
        self.title, self._why = title, why

    def state(self, shown: int) -> dict[str, Any]:
        """Says why."""
        raise self._why

    def figure(self, shown: int) -> dict[str, Any]:
        """Says why."""
        raise self._why

    def do(self, command: str, arguments: Arguments) -> str:
        """Says why."""
        raise self._why

    def file(self) -> None:
        """There is none."""
