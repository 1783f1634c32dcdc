"""A Dask client: what is different from other executors.

Dask begins a task anew whose worker was lost, until it has lost a few with one task (``allowed-failures`` of
its scheduler, 3) and gives that one up; what it gives up, or cancels as its scheduler restarts, is submitted
again. A scheduler that comes back at its address is connected to by the client, and what it has forgotten is
submitted again; one that stays away is an error, as soon as the client gives up.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from ..checks import reject
from ..messages import warn
from .engine import Answer, Engine
from .executors import SMALL_BYTES, Submitted
from .schedule import Chunk

__all__ = ["OnDask"]

#: How often the cluster is asked for its size, which may change.
_ASK_S = 2.0
#: Without any worker for so long there is a warning, then an error: a queue may hold the next job back.
_WARN_S, _PATIENCE_S = 60.0, 3600.0
#: An answer that has not come so long after its task was done counts as a lost worker.
_RESULT_S = 120.0


class OnDask(Submitted):
    """Chunks as futures of a Dask client; functions are sent by cloudpickle, as Dask does."""

    # Measured on a busy machine; benchmarks/cluster_plan.py measures it on any other.
    a_chunk_s = 0.02

    def __init__(self, client: Any, function: Callable[..., Any], shared: Any) -> None:
        if getattr(client, "asynchronous", False):
            reject("workers", "an asynchronous Dask client", "a synchronous one", "Make it by Client(...).")
        import cloudpickle

        super().__init__(client, 1, payload=cloudpickle.dumps((function, shared)))
        self._pickled = cloudpickle.dumps
        self._asked = -_ASK_S
        self._there, self._warned = time.monotonic(), False
        self._scattered: Any = None

    @property
    def workers(self) -> int:
        """Threads of the cluster's workers, at least one: it may still be growing."""
        now = time.monotonic()
        if now > self._asked + _ASK_S:
            self._asked = now
            with suppress(OSError, RuntimeError, ValueError):  # the scheduler is away; the futures will tell
                found = sum(self.executor.nthreads().values())
                self._count = max(1, found)
                if found:
                    self._there, self._warned = now, False
        return self._count

    def slots(self) -> int:
        """As of any executor; an error of a client that has given up, or of a cluster that is deserted."""
        self._connected()
        found = super().slots()
        alone = time.monotonic() - self._there
        if alone > _PATIENCE_S:
            reject(
                "workers",
                f"a Dask cluster that has had no worker for {alone:.0f} s",
                "one with workers",
                "Begin workers and call again: what store= or checkpoint= keeps is taken up.",
            )
        if alone > _WARN_S and not self._warned:
            self._warned = True
            text = f"workers: the Dask cluster has had no worker for {alone:.0f} s; waiting for one."
            warn("no_dask_worker", text)
        return found

    def _connected(self) -> None:
        """Refuse a client that has lost its scheduler for good."""
        if self.executor.status != "closed":
            return
        reject(
            "workers",
            f"a Dask client that has lost its scheduler, with {len(self._flying)} chunks of tasks under way",
            "one that is connected",
            "Connect to a scheduler that runs and call again: a series with store=, or a search with "
            "checkpoint=, goes on from what is kept.",
        )

    def _packed(self, tasks: list[Any]) -> bytes:
        data: bytes = self._pickled(tasks)
        return data

    def _sent_payload(self) -> Any:
        if len(self._payload) <= SMALL_BYTES:
            return self._payload
        if self._scattered is None:
            self._scattered = self.executor.scatter(self._payload, hash=False)
        return self._scattered

    def _begin(self, function: Callable[..., Any], *args: Any) -> Any:
        return self.executor.submit(function, *args, pure=False)

    def _lost(self, chunk: Chunk, error: BaseException) -> Answer:
        self._scattered = None  # it may have been on the worker that was lost
        self._connected()
        answer = super()._lost(chunk, error)
        # Lost workers for each time that Dask gives up.
        return Answer(chunk, lost=answer.lost, losses=1 + getattr(error, "allowed_failures", 0))

    def _result(self, future: Any) -> Any:
        return future.result(timeout=_RESULT_S)

    def close(self, at_once: bool) -> None:
        """Cancel what is under way, where there is still a scheduler to be told."""
        if self.executor.status == "closed":
            self._flying = {}
        super().close(at_once)

    def successor(self) -> Engine | None:
        """Nobody: its scheduler replaces workers."""
        return None
