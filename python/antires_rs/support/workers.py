"""Results of tasks in their order, whoever computes them: this thread, processes, anything with ``submit``.

Every kind of worker is an executor: tasks are numbered and go out in chunks of about a second, answers are
put back in order, and a chunk whose worker is lost is submitted again. A task's own exception is an answer
like any other: whatever else comes out of a worker is about the worker.
"""

from __future__ import annotations

import os
import pickle
import queue
import re
import signal
import threading
import time
import traceback
from asyncio import CancelledError
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sized
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import islice
from typing import Any, Literal, NoReturn, Self

from ..exceptions import InvalidInputError, LostWorkerError, reject
from .checks import integer
from .progress import LOOK_S, counted, one_blas_thread, step

Call = Callable[[Any], Any]
Errors = Literal["raise", "return"]

MOST_WORKERS = 1024  # more than any machine has; a larger number is a slip
#: Chunks that are begun or have arrived before the next in order, for each worker: memory stays flat.
AHEAD = 6
_RESULT_S = 120.0  # an answer that has not come so long after its task was done counts as a lost worker
_FOR_GOOD = (ImportError, AttributeError, TypeError, pickle.PicklingError)  # what no repetition mends
_THREADS = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
_REMEDY = "Pass a number, a concurrent.futures executor (itself, not its map), or a Client of a Dask cluster "
_REMEDY += '(pip install "antires-rs[dask]").'
_NEW = "Make a new one; or pass a number of processes, of which lost ones are replaced."


def processors() -> int:
    """Processors that this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@dataclass(frozen=True)
class Failed:
    """In place of a result: what the function raised, or a ``LostWorkerError``."""

    error: BaseException


# -- What a worker does with a chunk, and what it sends back


def _bound(function: Callable[..., Any], shared: Any) -> Call:
    return function if shared is None else partial(function, shared)


def _results(call: Call, tasks: list[Any], caught: Any = Exception) -> tuple[list[Any], float]:
    """The result of each task, or a :class:`Failed`, and the seconds they took."""
    start = time.perf_counter()
    found: list[Any] = []
    for task in tasks:
        try:
            found.append(call(task))
        except caught as error:
            found.append(Failed(error))
    return found, time.perf_counter() - start


_results_alike = one_blas_thread(_results)


@lru_cache(maxsize=8)
def _unpacked(payload: bytes) -> Call:
    """A function with what it shares: a worker unpacks a model once."""
    return _bound(*pickle.loads(payload))


@one_blas_thread
def _packed_results(payload: bytes, tasks: bytes) -> bytes | BaseException:
    """A chunk in another process; an exception says that it cannot be unpacked there."""
    try:
        call, given = _unpacked(payload), pickle.loads(tasks)
    except Exception as error:
        return _sendable(error)
    found, seconds = _results(call, given, BaseException)
    found = [Failed(_sendable(one.error)) if isinstance(one, Failed) else one for one in found]
    try:
        return _dumps((found, seconds))
    except Exception:
        for i, one in enumerate(found):
            try:
                _dumps(one)
            except Exception as error:
                found[i] = Failed(_sendable(error))
        return _dumps((found, seconds))


def _sendable(error: BaseException) -> BaseException:
    """An exception with where it was raised as a note, since that does not travel otherwise."""
    text = "".join(traceback.format_exception(error)).rstrip()
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        error = RuntimeError(f"{type(error).__name__}: {error}")
    error.add_note(f"In the worker:\n{text}")
    return error


def _dumps(value: Any) -> bytes:
    """By cloudpickle: what is in the main program, or inside a function, goes whole."""
    import cloudpickle

    data: bytes = cloudpickle.dumps(value)
    return data


# -- Which tasks go to a worker next, how many at a time, and again if the worker was lost

#: A lost chunk of several tasks is cut into this many, until the one that ends workers stands alone.
_PIECES = 8
#: The next chunk has at most so many times the tasks of the largest before: a first task may have been short.
_GROWTH = 8
#: Chunks of many workers are so many times as long as those that leave no rest to whoever gives them out;
#: towards the end so many times.
_LEISURE, _PRESSED = 4.0, 1.5


@dataclass(eq=False)
class Chunk:
    """Tasks in a row, the number of the first, and the workers lost with it where it is a single task."""

    first: int
    tasks: list[Any]
    losses: int = 0


class Schedule:
    """The tasks of one round, read as far as they are given out; the caller empties ``arrived``."""

    def __init__(
        self,
        tasks: Iterable[Any],
        seconds_a_chunk: float,
        losses: int,
        arrived: dict[int, Any],
        a_task: float | None = None,
        a_chunk_s: float = 0.0,
    ) -> None:
        self.total = len(tasks) if isinstance(tasks, Sized) else None
        self.arrived, self.a_task = arrived, a_task
        self._tasks: Iterator[Any] = iter(tasks)
        # A chunk costs a_chunk_s of whoever gives them all out: with many workers they are longer.
        self._seconds, self._losses, self._a_chunk = seconds_a_chunk, losses, a_chunk_s
        self._again: deque[Chunk] = deque()
        self._flying: set[Chunk] = set()
        self._read, self._exhausted = 0, False
        self._largest = 1 if a_task is None else max(1, int(seconds_a_chunk / max(a_task, 1e-9)))

    @property
    def over(self) -> bool:
        """Whether nothing is left to be given out or waited for."""
        return self._exhausted and not self._again and not self._flying

    def next(self, workers: int, ahead: int) -> Chunk | None:
        """The next chunk; None if there is none, or more than ``ahead`` chunks wait to be done or taken."""
        if self._again:
            chunk = self._again.popleft()
        else:
            size = self._size(workers)
            if self._exhausted or len(self._flying) + len(self.arrived) / size >= ahead:
                return None
            chunk = Chunk(self._read, list(islice(self._tasks, size)))
            self._read += len(chunk.tasks)
            self._exhausted = not chunk.tasks or self._read == self.total
            if not chunk.tasks:
                return None
            self._largest = max(self._largest, len(chunk.tasks))
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

    def done(self, chunk: Chunk, results: list[Any], seconds: float) -> None:
        """A chunk has come back."""
        self._flying.discard(chunk)
        self.arrived.update(enumerate(results, chunk.first))
        mean = seconds / len(chunk.tasks)
        self.a_task = mean if self.a_task is None else 0.5 * (self.a_task + mean)

    def lost(self, chunk: Chunk, reason: str, count: int = 1) -> None:
        """A chunk will not come back: so many workers were lost with it."""
        self._flying.discard(chunk)
        if len(chunk.tasks) == 1:
            chunk.losses += count
            if chunk.losses > self._losses:
                self.arrived[chunk.first] = Failed(LostWorkerError(chunk.first, chunk.losses, reason))
                return
        size = -(-len(chunk.tasks) // _PIECES)
        for at in range(0, len(chunk.tasks), size):
            self._again.append(Chunk(chunk.first + at, chunk.tasks[at : at + size], chunk.losses))


# -- Kinds of workers, each an executor: something with ``submit`` and, as far as known, ``_max_workers``


class _Here:
    """This thread: what is submitted is done at once."""

    _max_workers = a_worker = 1

    def submit(self, function: Callable[..., Any], *args: Any) -> Any:
        future: Future[Any] = Future()
        future.set_result(function(*args))
        return future


class Processes:
    """Processes of our own by loky, each an executor, so that it is known which chunk a lost one was at."""

    a_worker = 1

    def __init__(self, count: int) -> None:
        import multiprocessing

        if multiprocessing.current_process().daemon:
            remedy = "A worker of multiprocessing may not begin processes of its own: pass workers=1."
            reject("workers", f"{count} processes inside a worker process", "1 there, or threads", remedy)
        self._max_workers = count
        self._idle: list[Any] = []
        self._all: list[Any] = []

    def submit(self, function: Callable[..., Any], *args: Any) -> Any:
        """Give it to an idle process, or to a new one."""
        from loky import ProcessPoolExecutor

        while True:
            if self._idle:
                process = self._idle.pop()
            else:
                env = dict.fromkeys(_THREADS, "1")  # for a BLAS that is loaded later
                process = ProcessPoolExecutor(1, initializer=_begin, initargs=(os.getpid(),), env=env)
                self._all.append(process)
            try:
                with _sigint_blocked():
                    future = process.submit(function, *args)
            except BrokenExecutor:  # it was lost while it rested
                self._all.remove(process)
                continue
            future.add_done_callback(partial(self._back, process))
            return future

    def _back(self, process: Any, future: Any) -> None:
        if process not in self._all:
            return
        if isinstance(future.exception(), BrokenExecutor):
            self._all.remove(process)
        else:
            self._idle.append(process)

    def shutdown(self, at_once: bool) -> None:
        """End all processes, and what they have begun, those at work only ``at_once``."""
        ended, self._all, self._idle = self._all, [], []
        with ThreadPoolExecutor(max(1, len(ended))) as threads:
            for process in ended:
                threads.submit(process.shutdown, kill_workers=at_once)


def _begin(parent: int) -> None:
    """In a process that begins: Ctrl-C is for its parent, and without that one it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def end_with_parent() -> None:
        while os.getppid() == parent:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()


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


class Dask:
    """A Dask client, which may lose its scheduler for good; what it gives up is submitted again."""

    a_chunk_s = 0.02  # measured on a busy machine; benchmarks/cluster_plan.py measures it on any other
    ask_s = 2.0  # how often the cluster is asked for its size, which may change
    small_bytes = 65_536

    def __init__(self, client: Any) -> None:
        if getattr(client, "asynchronous", False):
            reject("workers", "an asynchronous Dask client", "a synchronous one", "Make it by Client(...).")
        self._client = client
        self._asked, self._found = 0.0, 1
        self._scattered: Any = None

    def submit(self, function: Callable[..., Any], payload: bytes, tasks: bytes) -> Any:
        """Not ``pure``: what is submitted again is computed again. A large model goes to each worker once."""
        if len(payload) > self.small_bytes:
            if self._scattered is None or self._scattered.status != "finished":
                self._scattered = self._client.scatter(payload, hash=False)
            payload = self._scattered
        return self._client.submit(function, payload, tasks, pure=False)

    @property
    def _max_workers(self) -> int:
        """Threads of the cluster's workers, at least one: it may still be growing."""
        if self._client.status == "closed":
            got = "a Dask client that has lost its scheduler, with chunks of tasks under way"
            remedy = "Connect to one that runs and call again: what store= or checkpoint= keeps is taken up."
            reject("workers", got, "one that is connected", remedy)
        now = time.monotonic()
        if now > self._asked + self.ask_s:
            self._asked = now
            with suppress(OSError, RuntimeError, ValueError):  # the scheduler is away; the futures will tell
                self._found = sum(self._client.nthreads().values())
        return max(1, self._found)


def _executor_of(workers: Any) -> tuple[Any, bool]:
    """The executor that ``workers=`` means, and whether it is our own."""
    if workers is None:
        return _Here(), True
    if isinstance(workers, str) and workers in ("threads", "processes"):
        threads = partial(ThreadPoolExecutor, thread_name_prefix="antires")
        return (threads if workers == "threads" else Processes)(processors()), True
    if isinstance(workers, float) or hasattr(workers, "__index__"):
        count = integer("workers", workers, low=1, high=MOST_WORKERS)
        return (_Here() if count == 1 else Processes(count)), True
    if not hasattr(workers, "submit") or isinstance(workers, type):
        got = repr(workers) if isinstance(workers, str) else type(workers).__name__
        wanted = 'a number from 1 on, "processes", "threads", or an executor with submit'
        reject("workers", got, wanted, _REMEDY)
    return (Dask(workers) if type(workers).__module__.split(".")[0] == "distributed" else workers), False


# -- What callers use


class Workers:
    """Workers for ``function(task)``, or ``function(shared, task)``, for several rounds of tasks.

    None or 1 is this thread; a number from 2 on, or ``"processes"``, processes that end with the context;
    ``"threads"``; an executor, which stays open. Chunks of tasks last about ``seconds_a_chunk`` (0: one by
    one). A task fails that took more than ``losses`` workers with it. But for None, functions run with one
    BLAS thread, so that the bits are the same.
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
        self._executor, self._own = _executor_of(workers)
        # None: one by one, so that Ctrl-C loses none that is done.
        self._seconds, self._losses = 0.0 if workers is None else seconds_a_chunk, losses
        self._run = _results if workers is None else _results_alike
        self._call: Call | None = None
        if isinstance(self._executor, _Here | ThreadPoolExecutor):
            self._call = _bound(function, shared)
        else:
            self._payload = _sent((function, shared), "a function that cannot be sent to them")
        self._flying: dict[Any, Chunk] = {}
        self._done: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._a_task: float | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close(at_once=kind is not None)

    def close(self, at_once: bool = False) -> None:
        """End what is of our own; begin nothing more elsewhere."""
        at_once = at_once or bool(self._flying)
        flying, self._flying = self._flying, {}
        if isinstance(self._executor, Processes):
            # Cancelled here, a task that has not begun stops loky's own thread, and the process lives on.
            self._executor.shutdown(at_once)
            return
        for future in flying:
            with suppress(Exception):  # there may be no scheduler to be told
                future.cancel()
        if self._own and hasattr(self._executor, "shutdown"):
            self._executor.shutdown(wait=not at_once, cancel_futures=True)

    def in_order(self, tasks: Iterable[Any], *, errors: Errors = "raise", what: str = "") -> Iterator[Any]:
        """The result of each task in their order, read no further than needed; an exception in its turn.

        With ``errors="return"`` that is a :class:`Failed`.
        """
        waiting: dict[int, Any] = {}
        start, nth = time.monotonic(), 0
        with closing(self._round(tasks, waiting)) as round_:
            for total in round_:
                while nth in waiting:
                    value = waiting.pop(nth)
                    if isinstance(value, Failed) and errors == "raise":
                        value.error.add_note(f"This was task {nth}, counted from 0.")
                        raise value.error
                    nth += 1
                    if what:
                        step(counted(what, nth, total, time.monotonic() - start))
                    yield value

    def as_done(
        self, tasks: Iterable[Any], *, poll: Callable[[], None] | None = None
    ) -> Iterator[tuple[int, Any]]:
        """The number of each task with its result, or a :class:`Failed`; ``poll`` ten times a second."""
        arrived: dict[int, Any] = {}
        with closing(self._round(tasks, arrived, poll)) as round_:
            for _ in round_:
                for nth in sorted(arrived):
                    yield nth, arrived.pop(nth)

    def _round(
        self, tasks: Iterable[Any], arrived: dict[int, Any], poll: Callable[[], None] | None = None
    ) -> Generator[int | None, None, None]:
        """Whenever something was put into ``arrived``: how many tasks there are, where that is known."""
        a_chunk_s = getattr(self._executor, "a_chunk_s", 0.0) if self._seconds else 0.0
        schedule = Schedule(tasks, self._seconds, self._losses, arrived, self._a_task, a_chunk_s)
        try:
            while True:
                self._hand_out(schedule)
                if not self._flying and schedule.over:
                    return
                self._receive(schedule)
                if poll is not None:
                    poll()
                if arrived:
                    if not isinstance(self._executor, _Here):
                        self._hand_out(schedule)  # workers are busy while the caller is
                    yield schedule.total
        finally:
            self._a_task = schedule.a_task
            if self._flying:
                self.close(at_once=True)

    def _workers(self) -> int:
        for name in ("_max_workers", "num_workers"):
            count = getattr(self._executor, name, None)
            if isinstance(count, int) and count > 0:
                return count
        return processors()

    def _hand_out(self, schedule: Schedule) -> None:
        """Fill the workers; an executor of the caller's has the next chunk while one is done."""
        workers = self._workers()
        at_most = getattr(self._executor, "a_worker", 2) * workers
        while len(self._flying) < at_most:
            chunk = schedule.next(workers, AHEAD * workers + 2)
            if chunk is None:
                return
            self._submit(chunk)

    def _submit(self, chunk: Chunk) -> None:
        try:
            if self._call is not None:
                future = self._executor.submit(self._run, self._call, chunk.tasks)
            else:
                tasks = _sent(chunk.tasks, "tasks that cannot be sent to them")
                future = self._executor.submit(_packed_results, self._payload, tasks)
        except RuntimeError as error:
            reject("workers", f"an executor that takes nothing ({error})", "one that is open", _NEW)
        self._flying[future] = chunk
        future.add_done_callback(self._done.put)

    def _receive(self, schedule: Schedule) -> None:
        """Wait a moment for answers; what is lost goes out again."""
        with suppress(queue.Empty):
            future = self._done.get(timeout=LOOK_S)
            while True:
                chunk = self._flying.pop(future, None)
                if chunk is not None:
                    self._answered(future, chunk, schedule)
                future = self._done.get_nowait()

    def _answered(self, future: Any, chunk: Chunk, schedule: Schedule) -> None:
        try:
            found = future.result(timeout=_RESULT_S)
        except _FOR_GOOD as error:
            _does_not_arrive(error)
        except BrokenExecutor as error:
            if not isinstance(self._executor, Processes):
                got = f"{type(self._executor).__name__} that is broken ({_reason(error)})"
                reject("workers", got, "one that lives", _NEW)
            schedule.lost(chunk, _reason(error))
        except (InvalidInputError, MemoryError):
            raise
        except (Exception, CancelledError) as error:
            # Lost workers for each time that Dask gives up.
            schedule.lost(chunk, _reason(error), 1 + getattr(error, "allowed_failures", 0))
        else:
            if isinstance(found, BaseException):
                _does_not_arrive(found)
            schedule.done(chunk, *(found if self._call is not None else pickle.loads(found)))


def in_order(
    function: Callable[..., Any],
    tasks: Iterable[Any],
    workers: Any = None,
    *,
    errors: Errors = "raise",
    what: str = "",
    **options: Any,
) -> Iterator[Any]:
    """One round of :class:`Workers`, which tells the arguments; nothing begins before it is asked for."""
    with Workers(function, workers, **options) as open_:
        yield from open_.in_order(tasks, errors=errors, what=what)


def _sent(value: Any, what: str) -> bytes:
    """A function with what it shares, or tasks, as bytes."""
    try:
        return _dumps(value)
    except Exception as error:
        remedy = 'Pass "threads", or let the function open files and locks where it runs.'
        reject("workers", f"processes, and {what} ({error})", "what pickles, with all that it needs", remedy)


def _does_not_arrive(error: BaseException) -> NoReturn:
    got = f"a function or tasks that do not arrive there ({type(error).__name__}: {error})"
    remedy = "Put it into a module that they have, with this package in the same version."
    reject("workers", got, "a function that the workers can import", remedy)


def _reason(error: BaseException) -> str:
    """What is known of a lost worker: its exit code, or what its executor says."""
    code = re.search(r"exit codes of the workers are \{\w*\((-?\d+)\)", str(error))
    return f"exit code {code[1]}" if code else f"{type(error).__name__}: {error}"
