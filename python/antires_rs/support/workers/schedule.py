"""Which tasks go to a worker next, how many at a time, and again if the worker was lost."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sized
from dataclasses import dataclass
from itertools import islice
from typing import Any

from ...exceptions import LostWorkerError
from .answers import Outcome

__all__ = ["Chunk", "Schedule"]

#: A lost chunk of several tasks is cut into this many, until the one that ends workers stands alone.
_PIECES = 8
#: The next chunk has at most so many times the tasks of the largest before: a first task may have been short.
_GROWTH = 8
#: Chunks of many workers are so many times as long as those that leave no rest to whoever gives them out;
#: towards the end so many times.
_LEISURE, _PRESSED = 4.0, 1.5


@dataclass(eq=False)
class Chunk:
    """Tasks in a row that go to a worker together.

    Attributes
    ----------
    first : int
        Number of the first of them.
    tasks : list
        The tasks.
    losses : int
        Workers that were lost with this chunk, where it is a single task.
    """

    first: int
    tasks: list[Any]
    losses: int = 0


class Schedule:
    """The tasks of one round.

    Parameters
    ----------
    tasks : iterable
        Read as far as they are given out.
    seconds_a_chunk : float
        Aimed at, from the times measured so far.
    losses : int
        Workers that one task may take with it.
    a_chunk_s : float
        What a chunk costs whoever gives them all out, whatever is in it: with many workers chunks are longer.
    arrived : dict
        Gets the outcomes, by number of the task; the caller takes them out.
    """

    def __init__(
        self,
        tasks: Iterable[Any],
        seconds_a_chunk: float,
        losses: int,
        arrived: dict[int, Outcome],
        a_task: float | None = None,
        a_chunk_s: float = 0.0,
    ) -> None:
        self.total = len(tasks) if isinstance(tasks, Sized) else None
        self._tasks: Iterator[Any] = iter(tasks)
        self._seconds, self._losses, self._a_chunk = seconds_a_chunk, losses, a_chunk_s
        self._again: deque[Chunk] = deque()
        self._read = 0
        self._exhausted = False
        self._flying: set[Chunk] = set()
        #: Seconds of a task, where some were measured; an earlier round may have done so.
        self.a_task = a_task
        self._largest = 1 if a_task is None else max(1, int(seconds_a_chunk / max(a_task, 1e-9)))
        self.arrived = arrived

    @property
    def over(self) -> bool:
        """Whether nothing is left to be given out or waited for."""
        return self._exhausted and not self._again and not self._flying

    def next(self, workers: int, ahead: int) -> Chunk | None:
        """The next chunk for one of ``workers``; None if there is none or too much waits to be taken.

        ``ahead`` is how many tasks were read and not yet handed to the caller, at most, in chunks.
        """
        if self._again:
            chunk = self._again.popleft()
        else:
            if self._exhausted or len(self._flying) + len(self.arrived) / self._size(workers) >= ahead:
                return None
            chunk = Chunk(self._read, list(islice(self._tasks, self._size(workers))))
            if not chunk.tasks:
                self._exhausted = True
                return None
            self._read += len(chunk.tasks)
            self._largest = max(self._largest, len(chunk.tasks))
            self._exhausted = self._read == self.total
        self._flying.add(chunk)
        return chunk

    def _size(self, workers: int) -> int:
        if self.a_task is None:
            return 1
        # So many workers keep whoever gives out the chunks busy all the time if theirs are this long.
        least = workers * self._a_chunk
        a_task = max(self.a_task, 1e-9)
        size = min(max(self._seconds, _LEISURE * least) / a_task, _GROWTH * self._largest)
        if self.total is not None:  # towards the end smaller ones, so that all end together
            left = (self.total - self._read) / workers
            size = min(size, max(left / 3, min(left, _PRESSED * least / a_task)))
        return max(1, int(size))

    def done(self, chunk: Chunk, outcomes: list[Outcome], seconds: float) -> None:
        """A chunk has come back."""
        self._flying.discard(chunk)
        self.arrived.update(enumerate(outcomes, chunk.first))
        mean = seconds / len(chunk.tasks)
        self.a_task = mean if self.a_task is None else 0.5 * (self.a_task + mean)

    def lost(self, chunk: Chunk, reason: str, count: int = 1) -> None:
        """A chunk will not come back; ``count`` 0 says that it was none of its doing."""
        self._flying.discard(chunk)
        if len(chunk.tasks) == 1:
            chunk.losses += count
            if chunk.losses > self._losses:
                error = LostWorkerError(chunk.first, chunk.losses, reason)
                self.arrived[chunk.first] = Outcome(error=error)
            else:
                self._again.append(chunk)
        elif count == 0:
            self._again.append(chunk)
        else:
            step = -(-len(chunk.tasks) // _PIECES)
            for at in range(0, len(chunk.tasks), step):
                self._again.append(Chunk(chunk.first + at, chunk.tasks[at : at + step]))
