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
    due, shown = start + FIRST_S, False

    def watcher(state: State) -> bool | None:
        nonlocal due, shown
        now = time.monotonic()
        if now >= due:
            due, shown = now + EVERY_S, True
            sys.stderr.write("\r" + _line(state, budget, now - start))
            sys.stderr.flush()
        return callback(state) if callback is not None else None

    try:
        yield watcher
    finally:
        if shown:
            sys.stderr.write("\n")


def _line(state: State, budget: int, seconds: float) -> str:
    waiting = sum(1 for _, name in state["islands"] if name == "waiting")
    return (f"{state['nfev']:>9,} of at most {budget:,} evaluations   best J {state['fun']:.6g}   "
            f"generation {state['nit']}   {waiting}/{len(state['islands'])} islands waiting   "
            f"{seconds:.0f} s ")
