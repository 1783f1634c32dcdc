"""The page of a result: its figures, its answer and its tables; nothing can be changed there."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any

from ...support.validation import reject
from ..canvas import item
from .view import Arguments

__all__ = ["Drawn", "ResultView", "Table"]


@dataclass(frozen=True)
class Drawn:
    """A figure, made when it is asked for, and what stands under it."""

    make: Callable[[], Any]
    caption: str


@dataclass(frozen=True)
class Table:
    """Heads and rows as text; heads with a unit are those of numbers."""

    title: str
    head: tuple[str, ...]
    rows: list[list[str]]


class ResultView:
    """What the server shows of a result.

    Parameters
    ----------
    title : str
    answer : sequence of str
        Sentences, the first one in large letters.
    figures : sequence of Drawn
    tables : sequence of Table
    """

    slow: frozenset[str] = frozenset()

    def __init__(
        self, title: str, answer: Sequence[str], figures: Sequence[Drawn], tables: Sequence[Table]
    ) -> None:
        self.title, self.answer, self.figures, self.tables = title, answer, figures, tables
        self._item = cache(lambda shown: item(self.figures[shown].make()))

    def state(self, shown: int) -> dict[str, Any]:
        """Everything but the figures."""
        return {
            "kind": "result",
            "answer": list(self.answer),
            "figures": [{"caption": one.caption} for one in self.figures],
            "tables": [asdict(one) for one in self.tables],
        }

    def figure(self, shown: int) -> dict[str, Any]:
        """One of the figures."""
        if not 0 <= shown < len(self.figures):
            reject("shown", shown, f"a figure from 0 to {len(self.figures) - 1}", "Load the page again.")
        return dict(self._item(shown))

    def do(self, command: str, arguments: Arguments) -> str:
        """Nothing: a result follows from its data and its job."""
        reject("command", command, "nothing: a result is looked at", "Change the job, and run it again.")

    def file(self) -> None:
        """There is nothing to download that the folder of the result does not have."""
