"""What a set of antiresonances carries beside its tables, and what it asks of it.

The data check and the cross-check are made by packages that use this one: here stands what a set itself reads
of them. Whoever asks a set for them gets the objects themselves, with all that they have.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, runtime_checkable

__all__ = ["CrossCheck", "DataCheck", "Finding", "SeriesOfTests"]


class Finding(Protocol):
    """One thing seen in the data, see :class:`antires_rs.Finding`."""

    @property
    def severity(self) -> str:
        """Fatal, warning or note."""

    @property
    def text(self) -> str:
        """What was seen."""


class DataCheck(Protocol):
    """Whether the data were fit for identification, see :class:`antires_rs.DataCheck`."""

    @property
    def findings(self) -> Sequence[Finding]:
        """Worst first."""


class CrossCheck(Protocol):
    """What another method says, see :class:`antires_rs.identification.cross_check.SecondOpinion`."""

    def is_confirmed(self, dof: Any, freq_hz: float) -> bool | None:
        """Whether this very antiresonance is confirmed; None if it was not judged."""


@runtime_checkable
class SeriesOfTests(Protocol):
    """Many tests of one structure, see :class:`antires_rs.Series`."""

    def tracks(self, conditions: Any = None, **options: Any) -> Any:
        """Every antiresonance followed over them."""

    def average(self, **options: Any) -> Any:
        """One set that stands for all of them."""
