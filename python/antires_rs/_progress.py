"""Progress of long runs on standard error: one line, rewritten in place."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["watched"]

State = dict[str, Any]
Watcher = Callable[[State], bool | None]

#: A run shows nothing in its first second, then a line a few times a second.
FIRST_S, EVERY_S = 1.0, 0.25


@contextmanager
def watched(callback: Watcher | None, progress: bool | None, budget: int) -> Iterator[Watcher | None]:
    """One callable for the core out of the user's callback and, if wanted, a progress line.

    ``progress=None`` shows the line on a terminal and in a notebook.
    """
    show = progress if progress is not None else (sys.stderr.isatty() or "ipykernel" in sys.modules)
    if not show:
        yield callback
        return
    start = time.monotonic()
    due, shown, width = start + FIRST_S, False, 0
    first: int | None = None  # evaluations before this process, where a search goes on

    def watcher(state: State) -> bool | None:
        nonlocal due, shown, first, width
        now = time.monotonic()
        first = state["nfev"] if first is None else first
        if now >= due:
            due, shown = now + EVERY_S, True
            line = _line(state, budget, now - start, state["nfev"] - first)
            width = max(width, len(line))  # what was longer before is written over
            sys.stderr.write(f"\r{line:<{width}}")
            sys.stderr.flush()
        return callback(state) if callback is not None else None

    try:
        yield watcher
    finally:
        if shown:
            sys.stderr.write("\n")


def _line(state: State, budget: int, seconds: float, done: int) -> str:
    waiting = sum(1 for _, name in state["islands"] if name == "waiting")
    return (f"{state['nfev']:>9,} of at most {budget:,} evaluations   best J {state['fun']:.6g}   "
            f"generation {state['nit']}   {waiting}/{len(state['islands'])} islands waiting   "
            f"{seconds:.0f} s, {_left(budget - state['nfev'], seconds, done)}")


def _left(evaluations: int, seconds: float, done: int) -> str:
    """How long the budget lasts at this pace; most searches end before it does."""
    if done <= 0:
        return "time left not known yet"
    left = evaluations * seconds / done
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if left >= 2.0 * size:
            return f"at most {left / size:.0f} {unit} left"
    return f"at most {left:.0f} s left"
