"""Progress of long runs on standard error: one line, rewritten in place.

A thread keeps it alive; it names the step that work is at (``waiting``, ``step``), or how far a search is
(``watched``), and the seconds.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np

from ..exceptions import NumericalError, reject

P = ParamSpec("P")
T = TypeVar("T")

State = dict[str, Any]
Watcher = Callable[[State], bool | None]

FIRST_S, EVERY_S = 1.0, 0.25  # a run shows nothing in its first second, then a line a few times a second
LOOK_S = 0.1  # Ctrl-C is looked for this often while the core works in the background


def _stops(said: object) -> bool | None:
    """What a callback returns, as the core takes it: any scalar; 0 and None go on."""
    try:
        return None if said is None else bool(said)
    except (TypeError, ValueError):
        wanted = "True to stop, False or None to go on"
        reject("callback", f"one that returns {type(said).__name__}", wanted, "Return a truth value.")


def _shown(progress: bool | None) -> bool:
    """As asked for; by default on a terminal and in a notebook. There may be no standard error at all."""
    if progress is not None or sys.stderr is None:
        return bool(progress) and sys.stderr is not None
    return sys.stderr.isatty() or "ipykernel" in sys.modules


#: The step that the outermost ``waiting`` shows, or None outside of any.
_AT: ContextVar[list[str] | None] = ContextVar("_AT", default=None)


@contextmanager
def waiting(what: str, progress: bool | None) -> Iterator[None]:
    """Show ``what``, the latest :func:`step` and the seconds; inside another one this is a step of that.

    A LinAlgError becomes one of ours.
    """
    if _AT.get() is not None:
        step(what)
        yield
        return
    at, over = [""], threading.Event()
    token = _AT.set(at)
    thread = threading.Thread(target=_keep_alive, args=(what, at, over), daemon=True)
    shown = _shown(progress)
    if shown:
        thread.start()
    try:
        yield
    except np.linalg.LinAlgError as error:  # NumPy's, of input that no check has foreseen
        why = f"{error}. Check the units of model and values, and whether values are given twice."
        raise NumericalError(what, why) from error
    finally:
        _AT.reset(token)
        over.set()
        if shown:
            thread.join()


@contextmanager
def watched(callback: Watcher | None, progress: bool | None, budget: int) -> Iterator[Watcher | None]:
    """One callable for the core out of the user's callback and, if wanted, a progress line."""
    if not _shown(progress):
        yield None if callback is None else lambda state: _stops(callback(state))
        return
    start, first = time.monotonic(), -1  # evaluations before this process, where a search goes on
    with waiting("searching", progress):
        at: Any = _AT.get()

        def watcher(state: State) -> bool | None:
            nonlocal first
            first = state["nfev"] if first < 0 else first
            at[0] = _line(state, budget, time.monotonic() - start, state["nfev"] - first)
            return _stops(callback(state)) if callback is not None else None

        yield watcher


@contextmanager
def apart() -> Iterator[None]:
    """Inside, steps are not those of who waits outside: for one task of many that are counted there."""
    token = _AT.set(None)
    try:
        yield
    finally:
        _AT.reset(token)


def step(text: str) -> None:
    """Name what is being done, if anyone is waiting for it."""
    at = _AT.get()
    if at is not None:
        at[0] = text


def counted(what: str, done: int, total: int | None, seconds: float) -> str:
    """A step of many alike: how far it is, and how long the rest takes at this pace."""
    if total is None:
        return f"{what} {done}"
    left = f", about {span((total - done) * seconds / done)} left" if 0 < done < total else ""
    return f"{what} {done} of {total}{left}"


def patient(what: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """A function with a keyword ``progress`` whose caller is shown that it works."""

    def around(function: Callable[P, T]) -> Callable[P, T]:
        @wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            progress: Any = kwargs.get("progress")
            with waiting(what, progress):
                return function(*args, **kwargs)

        return call

    return around


def interruptible(work: Callable[[], T], what: str) -> T:
    """The result of a long call into the core, which Ctrl-C leaves at once; the core then ends on its own."""
    answer: Future[T] = Future()

    def run() -> None:
        try:
            answer.set_result(work())
        except BaseException as exc:  # raised again in the caller's thread
            answer.set_exception(exc)

    thread = threading.Thread(target=run, daemon=True)
    with waiting(what, None):
        thread.start()
        while thread.is_alive():
            thread.join(LOOK_S)
    return answer.result()


def _keep_alive(what: str, at: list[str], over: threading.Event) -> None:
    """The line on standard error; blanks go over what a longer one left."""
    start, width = time.monotonic(), 0
    over.wait(FIRST_S)
    while not over.is_set():
        text = f"\r{what}{': ' if at[0] else ''}{at[0]}   {time.monotonic() - start:.0f} s "
        width = max(width, len(text))
        sys.stderr.write(f"{text:<{width}}")
        sys.stderr.flush()
        over.wait(EVERY_S)
    if width:
        sys.stderr.write("\n")
        sys.stderr.flush()


def _line(state: State, budget: int, seconds: float, done: int) -> str:
    waiting = sum(1 for _, name in state["islands"] if name == "waiting")
    left = "time left not known yet"
    if done > 0:  # most searches end before the budget does
        left = f"at most {span((budget - state['nfev']) * seconds / done)} left"
    return (
        f"{state['nfev']:>9,} of at most {budget:,} evaluations   best J {state['fun']:.6g}   "
        f"generation {state['nit']}   {waiting}/{len(state['islands'])} islands waiting   {left}"
    )


def span(seconds: float) -> str:
    """A time in the unit that suits it."""
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"


# -- One thread for linear algebra while a function runs
#
# BLAS adds in another order with another number of threads, and a fit that takes discrete decisions (an
# order, what is stable) can turn a last digit into another answer. With one thread the bits do not depend
# on their number, and the small matrices of this package are no slower.

_lock = threading.Lock()
_inside = 0
_limiter: Any = None


def one_blas_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Let ``function`` run with one BLAS thread; calls that overlap share the limit, the last one ends it."""

    @wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> T:
        _nested(1)
        try:
            return function(*args, **kwargs)
        finally:
            _nested(-1)

    return limited


def _nested(by: int) -> None:
    """Count the calls: the first limits the threads, the last lets them go."""
    global _inside
    with _lock:
        _inside += by
        if _inside == (1 if by > 0 else 0):
            # The thread that sets a limit owns it while it lives, and no other can restore it.
            thread = threading.Thread(target=_limit, args=(by > 0,))
            thread.start()
            thread.join()


def _limit(on: bool) -> None:
    """Limit the threads, or let them go."""
    global _limiter
    if not on:
        _limiter.restore_original_limits()
        return
    # Imported at first use. NumPy and SciPy each bring a BLAS; both must be there before the search.
    import scipy.linalg  # noqa: F401
    from threadpoolctl import threadpool_limits

    _limiter = threadpool_limits(limits=1, user_api="blas")
