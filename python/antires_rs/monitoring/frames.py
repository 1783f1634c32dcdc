"""A watch for pandas."""

from __future__ import annotations

from typing import Any

from ..io.tables import frame_of
from .judged_tests import JudgedTests

__all__ = ["watched_frame"]


def watched_frame(watched: JudgedTests) -> Any:
    """A pandas.DataFrame, one row a test."""
    inside = set(watched.baseline.tolist())
    rows: list[dict[str, Any]] = []
    for i, name in enumerate(watched.names):
        row: dict[str, Any] = {"test": i, "name": name}
        if watched.times is not None:
            row["time"] = watched.times[i]
        row |= {key: float(column[i]) for key, column in watched.conditions.items()}
        row |= {
            "baseline": i in inside,
            "alarm": bool(watched.alarm[i]),
            "statistic": float(watched.statistic[i]),
        }
        for key, chart in watched.charts.items():
            row |= {key: float(chart.statistic[i]), f"{key}_limit": float(chart.limit[i])}
        row |= {
            "why": ", ".join(watched.why(i)) if watched.alarm[i] else "",
            "outside_range": bool(watched.outside[i]),
            "faults": "; ".join(f"{fault.dof}: {fault.text}" for fault in watched.faults.get(i, ())),
            "failed": watched.failed.get(i, ""),
        }
        rows.append(row)
    return frame_of(rows, list(rows[0]) if rows else ["test"])
