"""Processes of our own: one pipe each, so that it is known which task a lost one was at.

A process has one chunk at a time; while it works nothing is written to it, so neither side ever waits for the
other to read. They begin by spawn: the caller's threads and locks are not theirs. They end with the pipe, on
SIGTERM, or are killed.
"""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from typing import Any

from ..checks import reject
from .answers import Ended, bound, packed
from .engine import Answer, Engine
from .schedule import Chunk
from .sending import does_not_arrive, tasks_of

__all__ = ["Processes"]

#: A process that is told to end gets so long before it is killed.
_GRACE_S = 0.5
#: So many in a row that end before they have begun: something in the beginning itself is wrong.
_FALSE_STARTS = 3
_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
_HERE, _READY = b"here", b"ready"


class _Worker:
    """One process, the pipe to it, and the chunk that it has."""

    def __init__(
        self, context: Any, initializer: Callable[..., Any] | None, initargs: tuple[Any, ...]
    ) -> None:
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=_serve, args=(theirs, initializer, initargs), daemon=True)
        with _sigint_blocked():
            self.process.start()
        theirs.close()
        self.ready = False
        self.chunk: Chunk | None = None


class Processes:
    """A number of processes, begun as they are needed, each replaced when it is lost."""

    a_chunk_s = 0.0

    def __init__(
        self,
        payload: bytes,
        count: int,
        context: Any = None,
        initializer: Callable[..., Any] | None = None,
        initargs: tuple[Any, ...] = (),
    ) -> None:
        if multiprocessing.current_process().daemon:
            reject(
                "workers",
                f"{count} processes inside a worker process",
                "1 there, or threads",
                "A worker of multiprocessing may not begin processes of its own: pass workers=1.",
            )
        if multiprocessing.get_start_method(allow_none=True) == "loky":
            # In a worker of joblib. What begins by spawn is told this name and does not know it.
            multiprocessing.set_start_method("spawn", force=True)
        self.workers = count
        self._payload = payload
        self._how = (context or multiprocessing.get_context("spawn"), initializer, initargs)
        self._all: list[_Worker] = []
        self._false_starts = 0

    def slots(self) -> int:
        """One chunk for each process."""
        return self.workers - sum(worker.chunk is not None for worker in self._all)

    def submit(self, chunk: Chunk) -> None:
        """Give it to an idle process, or to a new one."""
        idle = next((w for w in self._all if w.chunk is None), None)
        if idle is None:
            idle = _Worker(*self._how)
            self._all.append(idle)
        idle.chunk = chunk
        if idle.ready:
            self._send(idle, tasks_of(chunk.tasks))

    def _send(self, worker: _Worker, data: bytes) -> None:
        with suppress(OSError):  # it has ended, which its sentinel tells
            worker.pipe.send_bytes(data)

    def wait(self, seconds: float) -> list[Answer]:
        """What has come back, and the chunks of processes that have ended."""
        of: dict[Any, _Worker] = {w.pipe: w for w in self._all} | {w.process.sentinel: w for w in self._all}
        answers: list[Answer] = []
        for worker in dict.fromkeys(of[which] for which in wait(list(of), seconds)):
            try:
                # What it sent before it ended counts.
                message = worker.pipe.recv_bytes() if worker.pipe.poll() else None
            except (EOFError, OSError):
                message = None
            if message is None:
                answers += self._bury(worker)
            elif message == _HERE:
                self._send(worker, self._payload)
            elif message == _READY:
                worker.ready, self._false_starts = True, 0
                if worker.chunk is not None:
                    self._send(worker, tasks_of(worker.chunk.tasks))
            else:
                answers.append(_answer(worker, message))
        return answers

    def _bury(self, worker: _Worker) -> list[Answer]:
        self._all.remove(worker)
        _end([worker], at_once=True)
        code = worker.process.exitcode
        worker.process.close()
        if not worker.ready:
            self._false_starts += 1
            if self._false_starts >= _FALSE_STARTS:
                reject(
                    "workers",
                    f"processes that end with code {code} before they begin",
                    "a program that another process can begin anew",
                    'Put what it does under if __name__ == "__main__":, in a file; or pass "threads".',
                )
        if worker.chunk is None:
            return []
        lost = Answer(worker.chunk, lost=f"exit code {code}", losses=int(worker.ready))
        return [lost]

    def successor(self) -> Engine | None:
        """Nobody: lost processes are replaced one by one."""
        return None

    def close(self, at_once: bool) -> None:
        """End all processes; those at work only ``at_once`` or as they are done."""
        workers, self._all = self._all, []
        _end(workers, at_once)
        for worker in workers:
            worker.process.close()


def _answer(worker: _Worker, message: bytes) -> Answer:
    chunk, worker.chunk = worker.chunk, None
    assert chunk is not None
    found = pickle.loads(message)
    if isinstance(found, BaseException):
        does_not_arrive(found)
    return Answer(chunk, *found)


def _end(workers: list[_Worker], at_once: bool) -> None:
    """End processes: idle ones by their pipe, others by SIGTERM, which a task may answer, then SIGKILL."""
    for worker in workers:
        worker.pipe.close()
        if at_once or worker.chunk is not None or not worker.ready:
            worker.process.terminate()
    for last in (False, True):
        end = time.monotonic() + _GRACE_S
        for worker in workers:
            worker.process.join(max(0.0, end - time.monotonic()))
            if worker.process.is_alive():
                worker.process.kill()
        if last:
            for worker in workers:
                worker.process.join()


@contextmanager
def _sigint_blocked() -> Iterator[None]:
    """Ctrl-C is for the caller: a process that begins meanwhile never gets one, the caller gets his later."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _serve(pipe: Connection, initializer: Callable[..., Any] | None, initargs: tuple[Any, ...]) -> None:
    """What a process does: take the function, then one chunk after the other, until the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _told_to_end)
    with suppress(EOFError, OSError, Ended):
        pipe.send_bytes(_HERE)
        payload = pipe.recv_bytes()
        try:
            if initializer is not None:
                initializer(*initargs)
            call = bound(*pickle.loads(payload))
        except Exception as error:
            failure = error
        else:
            _one_blas_thread_for_good()
            pipe.send_bytes(_READY)
            while True:
                pipe.send_bytes(packed(call, pipe.recv_bytes()))
        pipe.send_bytes(_READY)
        pipe.recv_bytes()
        pipe.send_bytes(pickle.dumps(failure))


def _told_to_end(*_: Any) -> None:
    # Whatever the task is at, a program that it waits for included, gets the chance to end in order.
    raise Ended


def _one_blas_thread_for_good() -> None:
    from threadpoolctl import threadpool_limits

    # A BLAS that is loaded later looks at the environment; what is there already is told.
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    threadpool_limits(limits=1, user_api="blas")
