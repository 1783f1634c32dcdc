"""A session as plain data: what the page shows beside its figures."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...measured.antiresonance_set import AntiresonanceSet
from ...measured.doubts import doubts_of
from ..marks import mark_columns
from .session import Session

__all__ = ["told"]


def told(session: Session, dof: Any) -> dict[str, Any]:
    """Table, edits and what may be done, and the marks of the response that is shown."""
    turn = session.turn  # before what it is of: never newer than that
    now = session.now
    zeros, band = now.zeros, now.band_hz
    shown = zeros.diagrams[dof].band_hz if dof in zeros.diagrams else band
    return {
        "kind": "set",
        "turn": turn,
        "excitation": str(zeros.excitation),
        "dofs": [str(each) for each in zeros],
        "dof": list(zeros).index(dof),
        "rows": rows_of(zeros),
        "edits": [
            {
                "text": _said(each.edit.action, each.edit.freq_hz, each.edit.dof),
                "reason": each.edit.reason,
                "waits": why,
            }
            for each, why in zip(now.asked, now.waits, strict=True)
        ],
        "marks": mark_columns(zeros, dof, shown or (0.0, 1.0)),
        "band_hz": None if band is None else list(band),
        "max_order": now.max_order,
        "identified": session.identified,
        "can_identify": session.source is not None,
        "can_undo": session.can_undo,
        "can_redo": session.can_redo,
        "unsaved": session.unsaved,
        "file": None if session.file.path is None else str(session.file.path),
        "warnings": list(now.warned) or _warnings(zeros),
    }


def rows_of(zeros: AntiresonanceSet) -> list[dict[str, Any]]:
    """One row a value: what the table of the page says."""
    rows = []
    for at, (dof, table) in enumerate(zeros.tables.items()):
        words = doubts_of(dof, table, zeros.cross_check)
        grades = table.scores.get("grade", np.full(len(table), ""))
        for i, freq in enumerate(table.freq_hz.tolist()):
            std, damping = float(table.std_hz[i]), float(table.damping_ratio[i])
            rows.append(
                {
                    "dof": at,
                    "freq_hz": freq,
                    "std_hz": None if np.isnan(std) else std,
                    "damping_percent": None if np.isnan(damping) else 100.0 * damping,
                    "grade": "by hand" if table.by_hand[i] else str(grades[i]),
                    "doubts": "" if table.by_hand[i] else ", ".join(words[i]),
                }
            )
    return rows


def _said(action: str, freq_hz: float, dof: Any) -> str:
    return f"{'dropped' if action == 'drop' else 'added'} {freq_hz:.2f} Hz at dof {dof}"


def _warnings(zeros: AntiresonanceSet) -> list[str]:
    return [] if zeros.data_check is None else [f"data check: {line}" for line in zeros.data_check.warnings]
