"""What a worker does with a chunk of tasks, and what it sends back.

A task's own exception is an answer like any other, so that whatever else comes out of a worker is about the
worker. Between processes all goes as bytes.
"""

from __future__ import annotations

import pickle
import threading
import time
import traceback
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from ..progress import one_blas_thread

__all__ = ["Ended", "Outcome", "answers", "bound", "packed", "run_chunk", "run_here"]

Call = Callable[[Any], Any]


class Ended(BaseException):
    """This worker is told to end; no answer of the task."""


@dataclass(frozen=True)
class Outcome:
    """Result of a task, or the exception that it raised."""

    value: Any = None
    error: BaseException | None = None


def bound(function: Callable[..., Any], shared: Any) -> Call:
    """The function of one task."""
    return function if shared is None else partial(function, shared)


def answers(call: Call, tasks: list[Any], caught: type[BaseException]) -> tuple[list[Outcome], float]:
    """An outcome for each task, and the seconds they took."""
    start = time.perf_counter()
    outcomes = []
    for task in tasks:
        try:
            outcomes.append(Outcome(call(task)))
        except Ended:
            raise
        except caught as error:
            outcomes.append(Outcome(error=error))
    return outcomes, time.perf_counter() - start


@one_blas_thread
def run_here(call: Call, tasks: list[Any]) -> tuple[list[Outcome], float]:
    """A chunk where nothing needs to be packed: in a thread, or by an executor that packs by itself."""
    return answers(call, tasks, Exception)


def packed(call: Call, tasks: bytes) -> bytes:
    """A chunk in another process: tasks and outcomes as bytes."""
    try:
        given = pickle.loads(tasks)
    except Exception as error:
        return pickle.dumps(_sendable(error))
    outcomes, seconds = answers(call, given, BaseException)
    outcomes = [Outcome(error=_told(one.error)) if one.error else one for one in outcomes]
    try:
        return pickle.dumps((outcomes, seconds), protocol=pickle.HIGHEST_PROTOCOL)
    except Exception:
        return pickle.dumps(([_whole(one) for one in outcomes], seconds))


def _whole(outcome: Outcome) -> Outcome:
    """The outcome, or why it cannot be sent."""
    try:
        pickle.dumps(outcome)
    except Exception as error:
        return Outcome(error=_told(error))
    return outcome


def _told(error: BaseException) -> BaseException:
    """An exception with where it was raised, which does not travel otherwise."""
    text = "".join(traceback.format_exception(error)).rstrip()
    sent = _sendable(error)
    sent.add_note(f"In the worker:\n{text}")
    return sent


def _sendable(error: BaseException) -> BaseException:
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
    return error


#: Functions with what they share, as this worker has unpacked them: so a model arrives once.
_known: OrderedDict[str, Call] = OrderedDict()
_KEPT = 8
_lock = threading.Lock()


@one_blas_thread
def run_chunk(token: str, payload: bytes | None, tasks: bytes) -> bytes | None:
    """A chunk in a worker of someone else's; None asks for the payload, which this worker does not have."""
    with _lock:
        call = _known.get(token)
        if call is None:
            if payload is None:
                return None
            try:
                call = bound(*pickle.loads(payload))
            except Exception as error:
                return pickle.dumps(_sendable(error))
            _known[token] = call
            while len(_known) > _KEPT:
                _known.popitem(last=False)
    return packed(call, tasks)
