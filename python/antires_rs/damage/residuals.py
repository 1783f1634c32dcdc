"""What the most probable hypothesis leaves unexplained, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from ..updating.tables import FrequencyTable, ModalTable

__all__ = ["largest_left"]

_NAMED = 3
#: Differences below it, in %, are no news.
_LEAST_PERCENT = 0.05


def largest_left(table: FrequencyTable | ModalTable) -> str:
    """The values that the model with the damage found misses most; '' where it misses none."""
    missed = np.nan_to_num(np.abs(table.after_percent))
    worst = [i for i in np.argsort(-missed)[:_NAMED] if missed[i] >= _LEAST_PERCENT]
    return ", ".join(
        f"{table.measured_hz[i]:.2f} Hz {_where(table, int(i))} ({missed[i]:.1f} %)" for i in worst
    )


def _where(table: FrequencyTable | ModalTable, row: int) -> str:
    if hasattr(table, "mode"):
        return f"of mode {table.mode[row]}"
    dof = int(table.dof[row])
    return f"at {table.dof_names.get(dof, f'dof {dof}')}"
