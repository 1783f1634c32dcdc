"""A series for pandas."""

from __future__ import annotations

from typing import Any

from ..io.tables import frame_of, rows_of
from .kept_tests import KeptTests

__all__ = ["series_frame"]


def series_frame(series: KeptTests) -> Any:
    """A pandas.DataFrame, one row an antiresonance; failed tests have none."""
    rows: list[dict[str, Any]] = []
    names: dict[str, None] = dict.fromkeys(("test", "name"))
    if series.times is not None:
        names["time"] = None
    names |= dict.fromkeys(series.conditions)
    for i, found in enumerate(series):
        if found is None:
            continue
        beside: dict[str, Any] = {"test": i, "name": series.names[i]}
        if series.times is not None:
            beside["time"] = series.times[i]
        beside |= {name: float(column[i]) for name, column in series.conditions.items()}
        columns, own = rows_of(found)
        names |= dict.fromkeys(columns)
        rows += [beside | row for row in own]
    return frame_of(rows, list(names))
