"""The tables as the core reads them, and the antiresonances without damage."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from .. import _core
from ..damage.view import Band, Foreseen
from ..support.validation import FloatArray
from .tables import LEVELS, Tables

__all__ = ["Interpolated"]

#: Roots so far outside of the band (ln f) are not looked at.
_MARGIN = 0.3


@dataclass(frozen=True)
class Interpolated:
    """Tables, read between their levels."""

    tables: Tables
    #: Variance of a root that has just appeared.
    tau2: float

    @cached_property
    def spread(self) -> FloatArray:
        """Covariance of the roots without damage (r, r)."""
        rows = self.tables.errors[0, 0].astype(np.float64)
        return np.asarray(rows @ rows.T)

    @cached_property
    def core(self) -> _core.PreparedTables:
        """The tables, handed over."""
        t = self.tables
        c: Any = np.ascontiguousarray
        return _core.PreparedTables(
            c(LEVELS), c(t.response), c(t.seen), c(t.old), c(t.intact), c(t.there), c(t.place), c(t.beside),
            c(t.by_own), c(t.slopes), c(np.moveaxis(t.slopes, 3, 0)), c(t.errors), self.spread, self.tau2,
        )  # fmt: skip

    def undamaged(self, band: Band, alike: float) -> Foreseen:
        """As the likelihood has the roots without damage, ascending."""
        t = self.tables
        place, model = t.place[0, 0], t.place[0, 0] - t.beside[0, 0]
        near = t.there[0, 0] & (model > band.low - _MARGIN) & (model < band.high + _MARGIN)
        shown = np.flatnonzero(near)
        shown = shown[np.lexsort((place[shown], t.response[shown]))]
        return Foreseen(
            response=t.response[shown],
            place=place[shown],
            beside=t.beside[0, 0, shown],
            spread=self.spread[np.ix_(shown, shown)] + alike**2,
            change=np.zeros(shown.size),
            slopes=np.empty((shown.size, 0)),
            seen=t.seen[shown],
        )
