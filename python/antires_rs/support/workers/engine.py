"""What every kind of worker can do, and the kind that needs none: this thread."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Protocol

from .answers import Call, Outcome, answers, run_here
from .schedule import Chunk

__all__ = ["Answer", "Engine", "Here"]


@dataclass(frozen=True)
class Answer:
    """What became of a chunk: its outcomes, or why it was lost.

    ``losses`` is how many workers it took with it: 0 where it only was there when others were lost.
    """

    chunk: Chunk
    outcomes: list[Outcome] = field(default_factory=list)
    seconds: float = 0.0
    lost: str = ""
    losses: int = 1


class Engine(Protocol):
    """Workers of one kind, for one function."""

    @property
    def a_chunk_s(self) -> float:
        """Seconds that a chunk costs the one scheduler of them all; 0 where there is none, or it is quick."""

    @property
    def workers(self) -> int:
        """How many there are now, as far as known."""

    def slots(self) -> int:
        """How many chunks it takes now."""

    def submit(self, chunk: Chunk) -> None:
        """Begin a chunk."""

    def wait(self, seconds: float) -> list[Answer]:
        """What has come back, after ``seconds`` at the latest."""

    def successor(self) -> Engine | None:
        """Who goes on, where these workers are lost for good; all their chunks were reported lost."""

    def close(self, at_once: bool) -> None:
        """End what is of our own; ``at_once`` also where it is at work."""


class Here:
    """This thread; ``limited`` to one BLAS thread as all other workers."""

    workers = 1
    a_chunk_s = 0.0

    def __init__(self, call: Call, limited: bool = True) -> None:
        self._call = call
        self._run = run_here if limited else partial(answers, caught=Exception)
        self._chunk: Chunk | None = None

    def slots(self) -> int:
        """One chunk at a time."""
        return int(self._chunk is None)

    def submit(self, chunk: Chunk) -> None:
        """Keep it for :meth:`wait`."""
        self._chunk = chunk

    def wait(self, seconds: float) -> list[Answer]:
        """Do it."""
        chunk, self._chunk = self._chunk, None
        return [] if chunk is None else [Answer(chunk, *self._run(self._call, chunk.tasks))]

    def successor(self) -> Engine | None:
        """Nobody: it is never lost."""
        return None

    def close(self, at_once: bool) -> None:
        """Nothing to end."""
