"""Anything with ``map`` only, or a callable used as one: some chunks at a time, in a thread to be left."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from ...exceptions import InvalidInputError
from .answers import Call, run_here
from .counts import processors
from .engine import Answer, Engine
from .schedule import Chunk

__all__ = ["Mapped"]


class Mapped:
    """Chunks as items of a map: it ends before the next one begins."""

    a_chunk_s = 0.0

    def __init__(self, run: Callable[..., Iterable[Any]], call: Call) -> None:
        self._run, self._on = run, partial(run_here, call)
        self.workers = processors()
        self._next: list[Chunk] = []
        self._under_way: list[Chunk] = []
        self._done: queue.SimpleQueue[list[Any] | BaseException] = queue.SimpleQueue()

    def slots(self) -> int:
        """Several, while it rests."""
        return 0 if self._under_way else 2 * self.workers - len(self._next)

    def submit(self, chunk: Chunk) -> None:
        """Keep it for the next map."""
        self._next.append(chunk)

    def wait(self, seconds: float) -> list[Answer]:
        """Begin a map with what was given, or look whether it has ended."""
        if not self._under_way:
            self._under_way, self._next = self._next, []
            threading.Thread(target=self._map, args=(self._under_way, self._done), daemon=True).start()
        try:
            found = self._done.get(timeout=seconds)
        except queue.Empty:
            return []
        chunks, self._under_way = self._under_way, []
        if isinstance(found, BaseException):
            raise found
        return [Answer(chunk, *one) for chunk, one in zip(chunks, found, strict=True)]

    def _map(self, chunks: list[Chunk], done: queue.SimpleQueue[list[Any] | BaseException]) -> None:
        try:
            done.put(list(self._run(self._on, [chunk.tasks for chunk in chunks])))
        except TypeError as error:  # not of a task: what a task raises is its outcome
            got = f"{self._run!r}, which did not work as a map ({error})"
            wanted = "a function such as map: map(function, tasks) gives the results in order"
            done.put(InvalidInputError("workers", got, wanted, "Pass an executor, or a number."))
        except BaseException as error:  # raised again in the caller's thread
            done.put(error)

    def successor(self) -> Engine | None:
        """Nobody."""
        return None

    def close(self, at_once: bool) -> None:
        """What a map has begun it does; nobody waits for it."""
        self._done = queue.SimpleQueue()
        self._next, self._under_way = [], []
