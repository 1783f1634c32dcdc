"""Results of tasks, in their order or as they come, whatever the workers are."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Literal, Self

from ..progress import counted, step
from .answers import Outcome
from .engine import Engine
from .kinds import engine_of
from .schedule import Schedule

__all__ = ["Failed", "Workers", "in_order"]

#: How often a waiting caller is asked whether to go on; Ctrl-C is seen at least as often.
LOOK_S = 0.1
#: Chunks that are begun or have arrived before the next in order, for each worker: memory stays flat.
_AHEAD = 6

Errors = Literal["raise", "return"]


@dataclass(frozen=True)
class Failed:
    """What stands in place of a result with ``errors="return"``.

    Attributes
    ----------
    error : BaseException
        What the function raised, with the worker's traceback as a note; or a ``LostWorkerError``.
    """

    error: BaseException


class Workers:
    """Workers for one function, for several rounds of tasks.

    Parameters
    ----------
    function : callable
        ``function(task)``, or ``function(shared, task)`` where something is shared.
    workers : None, int, str or executor
        None or 1: this thread. A number from 2 on, or ``"processes"`` for one a processor: processes, begun
        by spawn and ended with the context. ``"threads"``. An executor: anything with ``submit`` or ``map``
        (``concurrent.futures``, a Dask ``Client``, ``mpi4py.futures``, ``multiprocessing.Pool``), or a
        callable used as ``map``; it stays open.
    shared : object, optional
        Goes to each worker once: a model.
    seconds_a_chunk : float
        Tasks are sent in chunks of about so long, from measured times, longer where one scheduler serves many
        workers; the results do not depend on it. 0: one by one.
    losses : int
        Workers that may be lost with one and the same task before that task fails.

    Raises
    ------
    InvalidInputError
        Workers of another kind; a function or a task that does not pickle where it has to; processes that
        cannot begin.

    Notes
    -----
    Functions run with one BLAS thread in every kind of worker, this thread with ``workers=1`` included, so
    that the bits are the same; with None they run as they are called.

    Examples
    --------
    >>> from antires_rs.support.workers.door import Workers
    >>> with Workers(pow, "threads", shared=2) as workers:
    ...     list(workers.in_order(range(5)))
    [1, 2, 4, 8, 16]
    """

    def __init__(
        self,
        function: Callable[..., Any],
        workers: Any = None,
        *,
        shared: Any = None,
        seconds_a_chunk: float = 1.0,
        losses: int = 10,
    ) -> None:
        self._seconds, self._losses = seconds_a_chunk, losses
        self._engine: Engine = engine_of(workers, function, shared)
        if workers is None:
            self._seconds = 0.0  # one by one: Ctrl-C loses none that is done
        self._in_flight = 0
        self._a_task: float | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        self.close(at_once=kind is not None)

    def close(self, at_once: bool = False) -> None:
        """End what is of our own."""
        self._engine.close(at_once or self._in_flight > 0)

    def in_order(
        self,
        tasks: Iterable[Any],
        *,
        errors: Errors = "raise",
        what: str = "",
        poll: Callable[[], None] | None = None,
    ) -> Iterator[Any]:
        """Results in the order of the tasks, which are read no further than needed.

        Parameters
        ----------
        tasks : iterable
            May be endless.
        errors : {"raise", "return"}
            What becomes of an exception of the function: raised when its task's turn comes, with the number
            of the task as a note, or given in place of the result as a :class:`Failed`.
        what : str
            What a task is; progress then says ``what 7 of 90``, if anyone is waiting for it.
        poll : callable, optional
            Asked while waiting, ten times a second; what it raises comes out.

        Yields
        ------
        object
            The result of each task.
        """
        waiting: dict[int, Outcome] = {}
        start, nth = time.monotonic(), 0
        round_ = self._round(tasks, waiting, poll)
        try:
            for total in round_:
                while nth in waiting:
                    value = _value(waiting.pop(nth), nth, errors)
                    nth += 1
                    if what:
                        step(counted(what, nth, total, time.monotonic() - start))
                    yield value
        finally:
            round_.close()

    def as_done(
        self, tasks: Iterable[Any], *, poll: Callable[[], None] | None = None
    ) -> Iterator[tuple[int, Any]]:
        """The number of each task with its result, or a :class:`Failed`, as they come."""
        arrived: dict[int, Outcome] = {}
        round_ = self._round(tasks, arrived, poll)
        try:
            for _ in round_:
                for nth in sorted(arrived):
                    yield nth, _value(arrived.pop(nth), nth, "return")
        finally:
            round_.close()

    def _round(
        self, tasks: Iterable[Any], arrived: dict[int, Outcome], poll: Callable[[], None] | None
    ) -> Generator[int | None, None, None]:
        """Whenever something has arrived: how many tasks there are, where that is known.

        What arrives is put into ``arrived``; who takes nothing out of it stops the reading of tasks.
        """
        a_chunk_s = self._engine.a_chunk_s if self._seconds else 0.0  # 0: one by one, whatever it costs
        schedule = Schedule(tasks, self._seconds, self._losses, arrived, self._a_task, a_chunk_s)
        try:
            while True:
                self._hand_out(schedule)
                if self._in_flight == 0 and schedule.over:
                    return
                for answer in self._engine.wait(LOOK_S):
                    self._in_flight -= 1
                    if answer.lost:
                        schedule.lost(answer.chunk, answer.lost, answer.losses)
                    else:
                        schedule.done(answer.chunk, answer.outcomes, answer.seconds)
                successor = self._engine.successor()
                if successor is not None:
                    self._engine = successor
                if poll is not None:
                    poll()
                if arrived:
                    # Workers are busy while the caller is.
                    self._hand_out(schedule)
                    yield schedule.total
        finally:
            self._a_task = schedule.a_task
            if self._in_flight:
                self._engine.close(at_once=True)
                self._in_flight = 0

    def _hand_out(self, schedule: Schedule) -> None:
        while self._engine.slots() > 0:
            workers = self._engine.workers
            chunk = schedule.next(workers, _AHEAD * workers + 2)
            if chunk is None:
                return
            self._engine.submit(chunk)
            self._in_flight += 1


def in_order(
    function: Callable[..., Any],
    tasks: Iterable[Any],
    workers: Any = None,
    *,
    shared: Any = None,
    seconds_a_chunk: float = 1.0,
    losses: int = 10,
    errors: Errors = "raise",
    what: str = "",
) -> Iterator[Any]:
    """``function(task)`` of every task, in the order of the tasks, the same bits for any workers.

    A round of :class:`Workers`, which says what the arguments are; nothing begins before the first result is
    asked for, and nothing runs on after the last, an exception, or ``close()`` of the iterator.

    Parameters
    ----------
    function : callable
        ``function(task)``, or ``function(shared, task)``.
    tasks : iterable
        A generator is read a few chunks ahead only.
    workers : None, int, str or executor
        As for :class:`Workers`.
    shared, seconds_a_chunk, losses
        As for :class:`Workers`.
    errors, what
        As for :meth:`Workers.in_order`.

    Yields
    ------
    object
        The result of each task, or a :class:`Failed`.

    Examples
    --------
    >>> from antires_rs.support.workers.door import in_order
    >>> list(in_order(abs, (-2, -1, 0), "threads"))
    [2, 1, 0]
    """
    with Workers(function, workers, shared=shared, seconds_a_chunk=seconds_a_chunk, losses=losses) as open_:
        yield from open_.in_order(tasks, errors=errors, what=what)


def _value(outcome: Outcome, nth: int, errors: Errors) -> Any:
    if outcome.error is None:
        return outcome.value
    if errors == "return":
        return Failed(outcome.error)
    outcome.error.add_note(f"This was task {nth}, counted from 0.")
    raise outcome.error
