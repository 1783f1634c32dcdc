"""The sources of a series computed, by whatever workers, in their order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from typing import Any

from ..exceptions import InvalidInputError, MissingDependencyError
from ..support.workers.door import Failed, in_order
from .ahead import read_ahead
from .one_test import Instructions, Outcome, identified, loaded, why_not

__all__ = ["computed"]


def computed(instructions: Instructions, tasks: Iterable[Any], workers: Any) -> Iterator[Outcome]:
    """The outcome of each source.

    In this process the next one is read while one is computed, and each is given as soon as it is there.
    Workers read files themselves, a second's worth of tests at a time.
    """
    if workers is None or (type(workers) is int and workers == 1):
        for signal in read_ahead(partial(loaded, instructions), tasks):
            yield identified(instructions, signal)
        return
    for outcome in in_order(identified, tasks, workers, shared=instructions, errors="return"):
        yield _failed(outcome.error) if isinstance(outcome, Failed) else outcome


def _failed(error: BaseException) -> str:
    """Why a test failed together with its worker; what concerns all tests is raised."""
    of_all = isinstance(error, MissingDependencyError | MemoryError | InvalidInputError)
    if of_all or not isinstance(error, Exception):
        raise error
    return why_not(error)
