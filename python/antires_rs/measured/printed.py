"""A set of antiresonances as text: one line each, with what is known of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..order_sweep.table import ResponseTable
from ..support.validation import FloatArray
from .doubts import doubts_of
from .layout import aligned, number

__all__ = ["left_out_printed", "rows_printed"]

# Decimals of frequencies without a deviation, and the most that are printed.
PLAIN, MOST = 3, 6


def rows_printed(tables: Mapping[Any, ResponseTable], cross_check: Any = None) -> list[str]:
    """Lines of the table; deviations, grades and doubts only where there are any.

    Examples
    --------
    >>> from antires_rs.measured.printed import rows_printed
    >>> from antires_rs.order_sweep.table import ResponseTable
    >>> tables = {0: ResponseTable([8.7, 23.9], std_hz=[0.004, 0.02]), 1: ResponseTable([])}
    >>> print("\\n".join(rows_printed(tables)))
    dof  freq_hz  std_hz
      0    8.700   0.004
          23.900   0.020
      1        -
    """
    std = np.concatenate([np.empty(0), *(table.std_hz for table in tables.values())])
    digits = _decimals(std)
    rows = []
    for dof, table in tables.items():
        words = doubts_of(dof, table, cross_check)
        for i in range(len(table)):
            # A score of another kind stands in the place of one that is not known.
            grade = str(table.scores["grade"][i]) if "grade" in table.scores else ""
            rows.append(
                [
                    "" if i else str(dof),
                    number(table.freq_hz[i], digits),
                    number(table.std_hz[i], digits),
                    "" if grade == "by hand" else grade,
                    ", ".join(words[i]),
                ]
            )
        if not len(table):
            rows.append([str(dof), "-", "", "", ""])
    head = ["dof", "freq_hz", "std_hz", "grade", "doubts"]
    there = [True, True, not np.isnan(std).all() if std.size else False]
    there += [any(row[k] for row in rows) for k in (3, 4)]
    chosen = [k for k in range(5) if there[k]]
    return aligned(
        [head[k] for k in chosen], [[row[k] for k in chosen] for row in rows], left=("grade", "doubts")
    )


def left_out_printed(left_out: Mapping[Any, ResponseTable]) -> list[str]:
    """A line on what was seen and not accepted, with how many for which reason; none without any."""
    count = sum(len(table) for table in left_out.values())
    whys = Counter(str(why) for table in left_out.values() for why in table.scores.get("why", ()) if why)
    reasons = "; ".join(f"{n} {why}" for why, n in whys.most_common())
    return [f"left out: {count}{f' ({reasons})' if reasons else ''}, see .left_out"] if count else []


def _decimals(std: FloatArray) -> int:
    """As many that the typical deviation has two digits."""
    known = std[std > 0.0]
    if not known.size:
        return PLAIN
    return int(np.clip(np.ceil(-np.log10(np.median(known))) + 1, PLAIN, MOST))
