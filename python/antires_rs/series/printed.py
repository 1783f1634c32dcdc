"""A series as text: how many tests, what failed and why, what was measured beside."""

from __future__ import annotations

from collections import Counter

import numpy as np

from .kept_tests import KeptTests

__all__ = ["printed"]

#: So many reasons are told; the others are counted.
REASONS = 3
#: A reason longer than this is cut.
LONG = 90


def printed(series: KeptTests) -> str:
    """One line for each fact."""
    count, failed = len(series), len(series.failed)
    rows = [("identified", f"{count - failed}{_antiresonances(series)}")]
    if failed:
        rows.append(("failed", f"{failed}: {_reasons(series)}"))
    if series.times is not None:
        known = series.times[~np.isnat(series.times)]
        if known.size:
            first, last = np.datetime_as_string(np.sort(known)[[0, -1]], unit="m")
            rows.append(("times", f"{first} to {last}{_missing(count - known.size)}"))
    for name, column in series.conditions.items() if count else ():
        values = column[~np.isnan(column)]
        span = f"{values.min():g} to {values.max():g}" if values.size else "not known"
        rows.append((name, span + _missing(count - values.size if values.size else 0)))
    width = max(len(name) for name, _ in rows)
    force = "" if series.excitation is None else f", force at {series.excitation}"
    dofs = f", {_counted(len(series.dofs), 'response')}" if series.dofs else ""
    title = f"series of {_counted(count, 'test')}{force}{dofs}"
    if series.interrupted:
        title += "; interrupted, more tests are to come"
    return "\n".join([title, *(f"  {name:<{width}}  {text}" for name, text in rows)])


def _counted(count: int, what: str) -> str:
    return f"{count:,} {what}{'' if count == 1 else 's'}"


def _missing(count: int) -> str:
    return f", {count} not known" if count else ""


def _antiresonances(series: KeptTests) -> str:
    """How many each has; a file says so without its sets being read."""
    counts = getattr(series.sets, "counts", None)
    if counts is None:
        counts = [sum(map(len, one.tables.values())) for one in series if one is not None]
    if not len(counts):
        return ""
    low, high = min(counts), max(counts)
    return f", with {low if low == high else f'{low} to {high}'} antiresonances"


def _reasons(series: KeptTests) -> str:
    told = Counter(_short(why) for why in series.failed.values()).most_common()
    said = [f"{why} ({n} times)" if n > 1 else why for why, n in told[:REASONS]]
    more = sum(n for _, n in told[REASONS:])
    return "; ".join(said) + (f"; and {more} others, see .failed" if more else "")


def _short(why: str) -> str:
    return why if len(why) <= LONG else why[: LONG - 3].rstrip() + "..."
