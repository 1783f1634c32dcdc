"""One thread for linear algebra while a function runs.

BLAS adds in another order with another number of threads, and a fit that takes discrete decisions (an order,
what is stable) can turn a last digit into another answer. With one thread the bits do not depend on their
number, and the small matrices of this package are no slower.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

_lock = threading.Lock()
_inside = 0
_limiter: Any = None


def one_blas_thread(function: Callable[P, R]) -> Callable[P, R]:
    """Let ``function`` run with one BLAS thread.

    The limit is the process's: calls that overlap in several Python threads share it, and the last one to end
    gives back what was there before.
    """

    @functools.wraps(function)
    def limited(*args: P.args, **kwargs: P.kwargs) -> R:
        _enter()
        try:
            return function(*args, **kwargs)
        finally:
            _leave()

    return limited


def _enter() -> None:
    global _inside
    with _lock:
        if _inside == 0:
            _in_a_thread_of_its_own(_limit)
        _inside += 1


def _leave() -> None:
    global _inside
    with _lock:
        _inside -= 1
        if _inside == 0:
            _in_a_thread_of_its_own(_restore)


def _in_a_thread_of_its_own(action: Callable[[], None]) -> None:
    # The thread that sets a limit owns it while it lives, and no other can restore it.
    thread = threading.Thread(target=action)
    thread.start()
    thread.join()


def _limit() -> None:
    # Imported at first use. NumPy and SciPy each bring a BLAS; both must be there before the search.
    import scipy.linalg  # noqa: F401
    from threadpoolctl import threadpool_limits

    global _limiter
    _limiter = threadpool_limits(limits=1, user_api="blas")


def _restore() -> None:
    global _limiter
    _limiter.restore_original_limits()
    _limiter = None
