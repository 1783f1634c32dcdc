"""Which workers ``workers=`` means."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..checks import integer, reject
from .answers import bound
from .counts import MOST_WORKERS, processors
from .engine import Engine, Here
from .sending import payload_of

__all__ = ["engine_of"]

_WANTED = 'a number from 1 on, "processes", "threads", or an executor with submit or map'
_REMEDY = (
    "Pass a number, a concurrent.futures executor, or a Client of a Dask cluster "
    '(pip install "antires-rs[dask]").'
)


def engine_of(workers: Any, function: Callable[..., Any], shared: Any) -> Engine:
    """The workers that are meant, for this function. Kinds are imported as they are needed."""
    call = bound(function, shared)
    if workers is None:
        return Here(call, limited=False)
    if isinstance(workers, str | bool):
        if workers == "threads":
            from .executors import threads_of_our_own

            return threads_of_our_own(call, processors())
        if workers != "processes":
            reject("workers", repr(workers), _WANTED, _REMEDY)
        return _processes(processors(), function, shared)
    if isinstance(workers, float) or hasattr(workers, "__index__"):
        count = integer("workers", workers, low=1, high=MOST_WORKERS)
        return Here(call) if count == 1 else _processes(count, function, shared)
    return _of_the_caller(workers, function, shared)


def _processes(count: int, function: Callable[..., Any], shared: Any) -> Engine:
    from .processes import Processes

    return Processes(payload_of(function, shared), count)


def _of_the_caller(workers: Any, function: Callable[..., Any], shared: Any) -> Engine:
    # pool.map stands for the pool, which can do more.
    owner = getattr(workers, "__self__", None)
    if callable(workers) and (hasattr(owner, "submit") or hasattr(owner, "apply_async")):
        workers = owner
    if isinstance(workers, type) and workers is not map:
        reject("workers", workers, _WANTED, "Make one of this class first.")
    if hasattr(workers, "submit"):
        if hasattr(workers, "scatter") and type(workers).__module__.split(".")[0] == "distributed":
            from .dask import OnDask

            return OnDask(workers, function, shared)
        from .executors import submitted

        return submitted(workers, function, shared)
    if hasattr(workers, "apply_async") and hasattr(workers, "_pool"):
        from .pools import pooled

        return pooled(workers, function, shared)
    run = getattr(workers, "map", workers)
    if not callable(run):
        reject("workers", workers, _WANTED, _REMEDY)
    from .maps import Mapped

    return Mapped(run, bound(function, shared))
