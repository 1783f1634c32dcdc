"""Anything with ``submit``: executors of concurrent.futures, mpi4py, loky, and threads of our own."""

from __future__ import annotations

import pickle
import queue
import uuid
from asyncio import CancelledError
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, ProcessPoolExecutor, ThreadPoolExecutor
from typing import Any

from ...exceptions import InvalidInputError
from ..checks import reject
from .answers import Call, bound, run_chunk, run_here
from .counts import processors
from .engine import Answer, Engine
from .processes import Processes
from .schedule import Chunk
from .sending import does_not_arrive, payload_of, tasks_of

__all__ = ["Submitted", "submitted", "threads_of_our_own"]

#: Chunks for each worker at a time: while it does one, the next is on its way.
_EACH = 2
#: A function up to this size goes with every chunk.
SMALL_BYTES = 65_536
#: What no repetition mends.
_FOR_GOOD = (ImportError, AttributeError, TypeError, pickle.PicklingError)


def threads_of_our_own(call: Call, count: int) -> Engine:
    """Threads that end with the search."""
    return Submitted(ThreadPoolExecutor(count, thread_name_prefix="antires"), count, call=call, own=True)


def submitted(executor: Any, function: Callable[..., Any], shared: Any) -> Engine:
    """The caller's executor."""
    count = _count_of(executor)
    if isinstance(executor, ThreadPoolExecutor):
        return Submitted(executor, count, call=bound(function, shared))
    try:
        payload = payload_of(function, shared)
    except InvalidInputError:
        if isinstance(executor, ProcessPoolExecutor):
            raise
        # It may know a way of its own to send what does not pickle.
        return Submitted(executor, count, call=bound(function, shared))
    return Submitted(executor, count, payload=payload)


def _count_of(executor: Any) -> int:
    for name in ("_max_workers", "num_workers"):
        count = getattr(executor, name, None)
        if isinstance(count, int) and count > 0:
            return count
    return processors()


class Submitted:
    """Chunks as futures of an executor.

    Parameters
    ----------
    executor : object
        With ``submit``, whose futures have ``add_done_callback`` and ``result``.
    count : int
        Its workers.
    call, payload
        The function as it is, or as bytes that a worker keeps once it has them.
    own : bool
        Whether the executor ends with these.
    """

    a_chunk_s = 0.0

    def __init__(
        self, executor: Any, count: int, *, call: Call | None = None, payload: bytes = b"", own: bool = False
    ) -> None:
        self.executor, self._own = executor, own
        self._count, self._call, self._payload = count, call, payload
        self._token = uuid.uuid4().hex
        self._begun = 0
        self._flying: dict[Any, Chunk] = {}
        self._done: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._broken: BaseException | None = None

    @property
    def workers(self) -> int:
        """As the executor says."""
        return self._count

    def slots(self) -> int:
        """Some more than there are workers."""
        return 0 if self._broken else _EACH * self.workers - len(self._flying)

    def submit(self, chunk: Chunk) -> None:
        """Begin a chunk; a broken executor is noticed in :meth:`wait`."""
        self._submit(chunk, self._begun < _EACH * self.workers or len(self._payload) <= SMALL_BYTES)
        self._begun += 1

    def _submit(self, chunk: Chunk, with_payload: bool) -> None:
        try:
            if self._call is not None:
                future = self._begin(run_here, self._call, chunk.tasks)
            else:
                payload = self._sent_payload() if with_payload else None
                future = self._begin(run_chunk, self._token, payload, self._packed(chunk.tasks))
        except BrokenExecutor as error:
            self._flying[error] = chunk
            self._done.put(error)
            return
        except RuntimeError as error:
            reject(
                "workers", f"an executor that takes nothing ({error})", "one that is open", "Open it first."
            )
        self._flying[future] = chunk
        future.add_done_callback(self._done.put)

    def _begin(self, function: Callable[..., Any], *args: Any) -> Any:
        return self.executor.submit(function, *args)

    def _result(self, future: Any) -> Any:
        return future.result()

    def _sent_payload(self) -> Any:
        return self._payload

    def _packed(self, tasks: list[Any]) -> bytes:
        return tasks_of(tasks)

    def wait(self, seconds: float) -> list[Answer]:
        """What is done, or lost with a broken executor."""
        try:
            done = [self._done.get(timeout=seconds)]
        except queue.Empty:
            return []
        while not self._done.empty():
            done.append(self._done.get())
        return [answer for future in done if (answer := self._answer(future)) is not None]

    def _answer(self, future: Any) -> Answer | None:
        chunk = self._flying.pop(future, None)
        if chunk is None:
            return None
        try:
            if isinstance(future, BaseException):
                raise future
            found = self._result(future)
        except (Exception, CancelledError) as error:
            return self._lost(chunk, error)
        if self._call is not None:
            return Answer(chunk, *found)
        if found is None:  # a worker that came later, or has forgotten
            self._submit(chunk, with_payload=True)
            return None
        unpacked = pickle.loads(found)
        if isinstance(unpacked, BaseException):
            does_not_arrive(unpacked)
        return Answer(chunk, *unpacked)

    def _lost(self, chunk: Chunk, error: BaseException) -> Answer:
        if isinstance(error, _FOR_GOOD):
            does_not_arrive(error)
        if isinstance(error, BrokenExecutor):
            self._broken = error
            # Of those that are in flight together nobody knows which one did it.
            return Answer(chunk, lost=_said(error), losses=0)
        return Answer(chunk, lost=_said(error))

    def successor(self) -> Engine | None:
        """Processes of our own, as many and begun alike, where those of the caller's executor are broken."""
        if self._broken is None or self._flying:
            return None
        if not isinstance(self.executor, ProcessPoolExecutor) or self._call is not None:
            reject(
                "workers",
                f"{type(self.executor).__name__} that is broken ({_said(self._broken)})",
                "one that lives",
                "Make a new one; or pass a number of processes, of which lost ones are replaced.",
            )
        how = vars(self.executor)
        return Processes(
            self._payload,
            self._count,
            how.get("_mp_context"),
            how.get("_initializer"),
            tuple(how.get("_initargs", ())),
        )

    def close(self, at_once: bool) -> None:
        """Begin nothing more; wait for nothing ``at_once``."""
        flying, self._flying = self._flying, {}
        for future in flying:
            if not isinstance(future, BaseException):
                future.cancel()
        if self._own:
            self.executor.shutdown(wait=not at_once, cancel_futures=True)


def _said(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
