"""Functions and tasks as bytes for another process, and what is said of those that do not travel."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any, NoReturn

from ..checks import reject

__all__ = ["does_not_arrive", "payload_of", "tasks_of"]

_IN_A_MODULE = (
    'Define it at the top of a module, not inside another function or as a lambda; or pass "threads".'
)


def payload_of(function: Callable[..., Any], shared: Any) -> bytes:
    """The function and what it shares."""
    try:
        return pickle.dumps((function, shared), protocol=pickle.HIGHEST_PROTOCOL)
    except Exception as error:
        reject(
            "workers",
            f"processes, and a function that cannot be sent to them ({error})",
            "a function that pickles, with what it needs",
            _IN_A_MODULE,
        )


def tasks_of(tasks: list[Any]) -> bytes:
    """Tasks in a row."""
    try:
        return pickle.dumps(tasks, protocol=pickle.HIGHEST_PROTOCOL)
    except Exception as error:
        reject(
            "workers",
            f"processes, and tasks that cannot be sent to them ({error})",
            "tasks that pickle",
            'Pass "threads", or tasks that say where a worker finds its data.',
        )


def does_not_arrive(error: BaseException) -> NoReturn:
    """Refuse what the workers cannot make sense of."""
    reject(
        "workers",
        f"a function or tasks that do not arrive there ({type(error).__name__}: {error})",
        "a function that the workers can import",
        "Put it into a module that they have, with this package in the same version; in a notebook pass "
        '"threads", or a Dask client.',
    )
