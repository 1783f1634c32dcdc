"""What may be given to the watch: a series or a list of sets, the baseline among them, their conditions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..measured.antiresonance_set import AntiresonanceSet
from ..series.series import Series
from ..support.validation import FloatArray, reject

__all__ = ["baseline_tests", "clocks", "conditions_of", "series_of"]

#: Fewer tests than this are no baseline.
LEAST = 8


def series_of(given: Any) -> Series:
    """A series of what was given."""
    if isinstance(given, Series):
        return given
    if not isinstance(given, Sequence) or isinstance(given, str | Mapping):
        reject(
            "series", type(given).__name__, "a Series or a list of AntiresonanceSets", "Put them in a list."
        )
    for i, one in enumerate(given):
        if one is not None and not isinstance(one, AntiresonanceSet):
            reject(
                f"series[{i}]",
                type(one).__name__,
                "an AntiresonanceSet, or None for a test that failed",
                "Identify the records first: identify_series(records, ...).",
            )
    return Series.from_sets(list(given))


def baseline_tests(given: Any, series: Series) -> NDArray[np.intp]:
    """Indices of the baseline's tests that have a set."""
    n = len(series)
    wanted = f"a slice, a number of first tests, indices or a mask of the {n} tests"
    if isinstance(given, int | np.integer) and not isinstance(given, bool):
        given = slice(0, int(given))
    try:
        at = np.asarray(given) if not isinstance(given, slice) else given
        chosen = np.unique(np.arange(n)[at])
    except (IndexError, TypeError, ValueError):
        reject("baseline", given, wanted, "As in baseline=slice(0, 100).")
    sound = np.array([i for i in chosen.tolist() if i not in series.failed], dtype=np.intp)
    if sound.size < LEAST:
        reject(
            "baseline",
            f"{sound.size} tests with antiresonances",
            f"at least {LEAST}, from which limits can be learned",
            "Take more tests of the intact structure; a rate of 1 % wants 50.",
        )
    return sound


def conditions_of(given: Any, series: Series) -> dict[str, FloatArray]:
    """Columns (n,) by name; by default those of the series."""
    if given is None:
        return dict(series.conditions)
    if not isinstance(given, Mapping):
        reject("conditions", type(given).__name__, "a mapping of name to array", "Pass a dict of columns.")
    return dict(Series.from_sets(list(series.sets), conditions=given).conditions)


def clocks(conditions: Mapping[str, FloatArray]) -> tuple[str, ...]:
    """Those that only count the tests: a line over time would take damage that grows for weather."""
    found = []
    for name, column in conditions.items():
        known = column[~np.isnan(column)]
        if known.size > 2 and np.all(np.diff(known) > 0.0):
            found.append(name)
    return tuple(found)
