"""Universal files in which points were recorded several times."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from ..support.validation import reject
from ..support.warned import warn
from ..support.wording import Passed, Wording
from ._common import unsuitable
from .uff_names import Point, label_of
from .uff_sets import Function

__all__ = ["listed", "one_run"]

_Key = tuple[str, Point, Point, str]


def _runs_of(functions: list[Function]) -> list[int]:
    """Which run each function is of: 1 where its point comes first, 2 where it comes again, ..."""
    seen: Counter[_Key] = Counter()
    runs = []
    for f in functions:
        seen[_key(f)] += 1
        runs.append(seen[_key(f)])
    return runs


def one_run(file: Path, functions: list[Function], run: int | None) -> list[Function]:
    """The functions of one run; refuses to choose among several.

    Points that have no such run are left out, with a warning that names them.
    """
    if run is not None and (isinstance(run, bool) or not isinstance(run, int) or run < 1):
        reject("run", run, "a whole number from 1", "Number the runs from 1, in their order in the file.")
    runs = _runs_of(functions)
    most = max((n for f, n in zip(functions, runs, strict=True) if f.what != "coherence"), default=1)
    if run is None and most > 1:
        again = next(f for f, n in zip(functions, runs, strict=True) if n == 2 and f.what != "coherence")
        over = "" if again.what == "time" else f" / {label_of(again.reference)}"
        unsuitable(
            file,
            f"with several functions ({again.what}) of {label_of(again.response)}{over}: {most} runs",
            "one for each point",
            Wording(
                "Choose one by {} to {}, and give them together as repeats of one test.",
                Passed("run", 1),
                Passed("run", most),
            ),
        )
    if run is not None and run > most:
        reject("run", run, f"1 to {most}, the runs of {str(file)!r}", "Number the runs from 1.")
    if most == 1:
        return functions
    there = {_key(f) for f, number in zip(functions, runs, strict=True) if number == run}
    lost = dict.fromkeys(label_of(f.response) for f in functions if _key(f) not in there)
    if lost:
        warn(
            "points_without_run",
            f"path: {str(file)!r} has no run {run} of {', '.join(lost)}, which is left out.",
        )
    return [f for f, number in zip(functions, runs, strict=True) if number == run]


def _key(f: Function) -> _Key:
    return (f.what, f.response, f.reference if f.what != "time" else (0, 0), f.role)


def listed(functions: list[Function]) -> list[str]:
    """A line for each function, with its run where there are several."""
    runs = _runs_of(functions)
    several = max(runs, default=1) > 1
    return [f"{f}, run {run}" if several else str(f) for f, run in zip(functions, runs, strict=True)]
