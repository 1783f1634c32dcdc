"""A pool of multiprocessing, which never tells that a worker was lost: its processes are watched."""

from __future__ import annotations

from collections.abc import Callable
from multiprocessing.pool import ThreadPool
from typing import Any

from .answers import bound
from .engine import Answer, Engine
from .executors import Submitted
from .processes import Processes
from .sending import payload_of

__all__ = ["pooled"]


def pooled(pool: Any, function: Callable[..., Any], shared: Any) -> Engine:
    """The caller's pool."""
    if isinstance(pool, ThreadPool):
        return _Pooled(pool, call=bound(function, shared))
    return _Pooled(pool, payload=payload_of(function, shared))


class _Result:
    """An asynchronous result of the pool, as a future."""

    def __init__(
        self, pool: Any, function: Callable[..., Any], args: Any, done: Callable[[Any], None]
    ) -> None:
        def told(_: Any) -> None:
            done(self)

        self._of = pool.apply_async(function, args, callback=told, error_callback=told)

    def add_done_callback(self, done: Callable[[Any], None]) -> None:
        """It was given from the beginning."""

    def result(self) -> Any:
        return self._of.get()

    def cancel(self) -> None:
        """What a pool has taken it does."""


class _Pooled(Submitted):
    """Chunks of a pool; after a loss processes of our own go on, as the pool may hang for good."""

    def __init__(self, pool: Any, **function: Any) -> None:
        super().__init__(pool, len(pool._pool), **function)
        self._watched = list(pool._pool)
        self._dead = False

    def _begin(self, function: Callable[..., Any], *args: Any) -> Any:
        return _Result(self.executor, function, args, self._done.put)

    def wait(self, seconds: float) -> list[Answer]:
        """What is done; or everything as lost, once a process has ended as none should."""
        answers = super().wait(seconds)
        known = set(self._watched)
        self._watched += [process for process in list(self.executor._pool) if process not in known]
        codes = [_exit_code(process) for process in self._watched]
        self._watched = [p for p, code in zip(self._watched, codes, strict=True) if code is None]
        if any(codes):
            self._dead = True
            lost, self._flying = list(self._flying.values()), {}
            answers += [Answer(chunk, lost="a worker of the pool was lost", losses=0) for chunk in lost]
        return answers

    def slots(self) -> int:
        """None once it has lost a worker."""
        return 0 if self._dead else super().slots()

    def successor(self) -> Engine | None:
        """As many processes of our own, begun alike."""
        if not self._dead:
            return None
        how = vars(self.executor)
        begun = how.get("_initializer"), tuple(how.get("_initargs") or ())
        return Processes(self._payload, self._count, how.get("_ctx"), *begun)


def _exit_code(process: Any) -> int | None:
    try:
        code: int | None = process.exitcode
    except ValueError:  # closed by the pool
        return 0
    return code
