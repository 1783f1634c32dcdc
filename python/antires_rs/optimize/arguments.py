"""Arguments of a search, checked: seed, threads, bounds, guesses and the types of options."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from .. import _core
from ..support.validation import FloatArray, finite_scalar, integer, real_array, reject
from ..support.workers.counts import MOST_WORKERS, processors

__all__ = ["check_bounds", "check_option_type", "guesses", "seed_of", "texts", "thread_count"]

#: Largest count that the core can hold.
_MOST = 2**63 - 1
_INTEGERS = {
    "islands",
    "population",
    "patience",
    "cost_migrations",
    "polish_interval",
    "polish_evaluations",
    "max_evaluations",
    "max_generations",
}


def seed_of(rng: int | np.random.Generator | None) -> int:
    """Master seed of a run: an int as it is, or one drawn from a Generator or the system.

    So the seed kept in a result, passed back as ``rng``, repeats the run.
    """
    if rng is not None and not isinstance(rng, np.random.Generator):
        return integer("rng", rng, low=0, high=2**63 - 1)
    return int(np.random.default_rng(rng).integers(0, 2**63, dtype=np.int64))


def thread_count(workers: int | None) -> int:
    """Threads to use: the given number, or the processors this process may run on."""
    if workers is not None:
        return integer("workers", workers, low=1, high=MOST_WORKERS)
    return processors()


def check_bounds(bounds: Any) -> FloatArray:
    """Bounds as an (n, 2) array; order and finiteness are checked in the core, by gene."""
    wanted = "an array (n, 2) of lower and upper bounds, n >= 1"
    try:
        box = np.asarray(bounds, dtype=np.float64)
    except (TypeError, ValueError) as exc:
        reject(
            "bounds",
            f"{type(bounds).__name__} that does not convert ({exc})",
            wanted,
            "Write them as in [(0.0, 1.0), (0.9, 1.1)].",
        )
    if box.ndim != 2 or box.shape[1] != 2 or box.size == 0:
        reject("bounds", f"shape {box.shape}", wanted, "Write them as in [(0.0, 1.0), (0.9, 1.1)].")
    return box


def guesses(x0: Any, n: int) -> list[list[float]]:
    """Initial guesses as rows."""
    if x0 is None:
        return []
    rows = np.atleast_2d(real_array("x0", x0, ndim=None, wanted=f"an array ({n},) or (m, {n})"))
    if rows.ndim != 2 or rows.shape[1] != n:
        reject(
            "x0",
            f"shape {np.shape(x0)}",
            f"an array ({n},) or (m, {n})",
            "Give a value for each parameter, in the order of the bounds.",
        )
    return [[float(v) for v in row] for row in rows]


def check_option_type(name: str, value: Any) -> None:
    """Type of an option; its range is the core's to judge, and so is an unknown name."""
    if name in _INTEGERS:
        if not (name == "max_generations" and value is None):
            integer(name, value, low=0, high=_MOST)
    elif name == "agreement":
        texts(name, [value])
    elif name == "polish":
        if value is not None and not isinstance(value, bool):
            reject(name, value, "True, False or None", "None lets the optimizer choose.")
    elif name != "crossovers" and name in _core.island_options({}):
        finite_scalar(name, value)


def texts(name: str, value: Any) -> list[str]:
    """A list of texts."""
    listed = list(value) if isinstance(value, Iterable) and not isinstance(value, str) else [value]
    if not all(isinstance(text, str) for text in listed):
        reject(
            name,
            value,
            "text, or a list of texts where several are possible",
            "Put it in quotes; see the docstring for the names.",
        )
    return listed
