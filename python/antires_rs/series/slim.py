"""What a series keeps of an identified set: all that a file holds of it, and what the data check found."""

from __future__ import annotations

from typing import Any

from ..data_check import DataCheck
from ..measured.antiresonance_set import AntiresonanceSet

__all__ = ["slim"]


def slim(found: AntiresonanceSet) -> AntiresonanceSet:
    """The set without diagrams, curves of the data check and cross-check.

    Those are 100 times as large as the antiresonances; a series of a year would not fit into memory.
    """
    return AntiresonanceSet.from_tables(
        found.excitation,
        found.tables,
        edits=found.edits,
        before=found.original().tables if found.edits else None,
        left_out=found.left_out,
        unexplained_hz=found.unexplained_hz,
        sees=found.sees,
        channels=found.channels,
        data_check=_without_curves(found.data_check),
    )


def _without_curves(checked: Any) -> DataCheck | None:
    if not isinstance(checked, DataCheck):
        return None
    return DataCheck(
        checked.findings,
        checked.not_tested,
        checked.dofs,
        checked.excitation,
        checked.band_hz,
        n_averages=checked.n_averages,
        nperseg=checked.nperseg,
    )
