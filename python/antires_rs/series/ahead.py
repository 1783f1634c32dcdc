"""The next source is read while the one before it is computed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from queue import SimpleQueue
from threading import Thread
from typing import Any, TypeVar

__all__ = ["read_ahead"]

Task = TypeVar("Task")
Read = TypeVar("Read")
_OVER = object()


def read_ahead(read: Callable[[Task], Read], tasks: Iterable[Task]) -> Iterator[Read]:
    """``read(task)`` of every task in order, the next one read by a thread meanwhile.

    Tasks are taken in the caller's thread, since a generator of theirs may be anything.

    Examples
    --------
    >>> from antires_rs.series.ahead import read_ahead
    >>> list(read_ahead(len, ["a", "bc"]))
    [1, 2]
    """
    asked: SimpleQueue[Any] = SimpleQueue()
    answers: SimpleQueue[tuple[Any, BaseException | None]] = SimpleQueue()

    def work() -> None:
        while (task := asked.get()) is not _OVER:
            try:
                answers.put((read(task), None))
            except BaseException as exc:  # raised again in the caller's thread
                answers.put((None, exc))
            del task  # or it would be held while the next one is waited for

    def answer() -> Any:
        value, error = answers.get()
        if error is not None:
            raise error
        return value

    Thread(target=work, daemon=True).start()
    waiting = 0
    try:
        for task in tasks:
            asked.put(task)
            waiting += 1
            if waiting > 1:
                yield answer()
                waiting -= 1
        if waiting:
            yield answer()
    finally:
        asked.put(_OVER)
