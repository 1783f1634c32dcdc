"""Why an antiresonance asks for a look: a few words for each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from ..order_sweep.table import (
    LEAST_DOMINANCE,
    LEAST_PROMINENCE_DB,
    MORE_ROWS,
    MOST_RESIDUAL,
    MOST_SPREAD,
    SURE_DEPTH_DB,
    SURE_SHARE,
    SURE_SPREAD,
    ResponseTable,
)

__all__ = ["doubts_of"]

#: What a grade's tests are called where they fail.
_TESTS: tuple[tuple[str, Callable[[ResponseTable, int], Any]], ...] = (
    ("few orders", lambda table, i: table.rows[i] > MORE_ROWS),
    ("unsteady", lambda table, i: table.spread[i] <= MOST_SPREAD),
    ("owns little of its curve", lambda table, i: table.dominance[i] >= LEAST_DOMINANCE),
    ("poor fit", lambda table, i: table.residual[i] <= MOST_RESIDUAL),
    ("no clear peak", lambda table, i: table.prominence_db[i] >= LEAST_PROMINENCE_DB),
)
#: The same of fits over windows.
_OF_WINDOWS: tuple[tuple[str, Callable[[ResponseTable, int], Any]], ...] = (
    ("not in all fits", lambda table, i: table.scores["share"][i] >= SURE_SHARE),
    ("unsteady", lambda table, i: table.spread[i] <= SURE_SPREAD),
    (
        "shallow dip",
        lambda table, i: (
            np.fmin(table.scores["depth_db"][i], table.scores["own_depth_db"][i]) >= SURE_DEPTH_DB
        ),
    ),
)
#: How a value was accepted, where that is a doubt.
_HOW = {"persistent": "does not stand still", "likeliest order": "one order only"}


class _Confirms(Protocol):
    def is_confirmed(self, dof: Any, freq_hz: float) -> bool | None: ...


def doubts_of(dof: Any, table: ResponseTable, cross_check: _Confirms | None = None) -> list[list[str]]:
    """Words for every row: added by hand, how it was accepted, tests failed below "sure", not confirmed.

    Examples
    --------
    >>> from antires_rs.measured.doubts import doubts_of
    >>> from antires_rs.order_sweep.table import ResponseTable
    >>> doubts_of(0, ResponseTable([8.7, 12.2], by_hand=[False, True]))
    [[], ['added by hand']]
    """
    return [_of(dof, table, i, cross_check) for i in range(len(table))]


def _of(dof: Any, table: ResponseTable, i: int, cross_check: _Confirms | None) -> list[str]:
    if table.by_hand[i]:
        return ["added by hand"]
    words = []
    if "how" in table.scores and str(table.how[i]) in _HOW:
        words.append(_HOW[str(table.how[i])])
    grade = str(table.scores["grade"][i]) if "grade" in table.scores else "sure"
    if grade != "sure":
        tests = _OF_WINDOWS if "share" in table.scores else _TESTS
        words += [word for word, passed in tests if not passed(table, i)]
    if cross_check is not None and cross_check.is_confirmed(dof, float(table.freq_hz[i])) is False:
        words.append("not confirmed")
    return words
