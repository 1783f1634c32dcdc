"""Accepted values with what speaks for each of them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np

from ..support.pickling import ReadOnly, frozen
from ..support.validation import ComplexArray, FloatArray
from .scores import grades, local_misfit, prominence_db

__all__ = ["Accepted", "Value"]


class Value(NamedTuple):
    """One accepted value; the fields are the columns of :class:`Accepted`."""

    freq_hz: float
    damping_ratio: float
    rows: int
    spread: float
    dominance: float
    how: str
    std_hz: float = float("nan")
    residual: float = float("nan")
    prominence_db: float = float("nan")


@dataclass(frozen=True)
class Accepted(ReadOnly):
    """Columns of the accepted values, ascending in frequency.

    Attributes
    ----------
    freq_hz, damping_ratio : (n,)
    rows : (n,) int
        Orders of the chain, or orders in which a persistent value was seen.
    spread : (n,)
        Relative standard deviation of the frequency over those orders.
    dominance : (n,)
        Share of the curve that the pole owns at its frequency.
    how : (n,) str
        "chain": stable over consecutive orders; "persistent": in most orders, though it does not stand still.
    std_hz : (n,)
        Standard deviation, NaN where it is not known.
    residual, prominence_db : (n,)
        See :mod:`~antires_rs.order_sweep.scores`; NaN where not known.
    """

    freq_hz: FloatArray
    damping_ratio: FloatArray
    rows: Any
    spread: FloatArray
    dominance: FloatArray
    how: Any
    std_hz: FloatArray
    residual: FloatArray
    prominence_db: FloatArray

    @classmethod
    def of(cls, values: Iterable[Value]) -> Accepted:
        """Columns of some values, sorted."""
        ranked = sorted(values, key=lambda v: v.freq_hz)
        kinds = {"rows": np.int64, "how": np.str_}
        return cls(
            **{
                name: frozen(np.array([getattr(v, name) for v in ranked], dtype=kinds.get(name, float)))
                for name in Value._fields
            }
        )

    def values(self) -> list[Value]:
        """One :class:`Value` each."""
        columns = [getattr(self, name).tolist() for name in Value._fields]
        return [Value(*row) for row in zip(*columns, strict=True)]

    def take(self, chosen: Sequence[int] | Any) -> Accepted:
        """Some of the values, by index or by mask."""
        return Accepted(**{f.name: frozen(getattr(self, f.name)[chosen]) for f in fields(self)})

    def scored(
        self, freq_hz: FloatArray, background: FloatArray, data: ComplexArray, fitted: ComplexArray
    ) -> Accepted:
        """The same values with residual and prominence; ``data`` and ``fitted`` are (n_outputs, n_freq)."""
        at = (self.freq_hz, self.damping_ratio)
        return replace(
            self,
            residual=frozen(local_misfit(freq_hz, data, fitted, *at)),
            prominence_db=frozen(prominence_db(freq_hz, background, *at)),
        )

    def scores(self, graded: bool) -> dict[str, Any]:
        """What :class:`~antires_rs.AntiresonanceSet` shows as ``scores``."""
        own = {
            name: getattr(self, name)
            for name in ("rows", "spread", "dominance", "how", "residual", "prominence_db")
        }
        if not graded:
            return own
        return own | {
            "grade": grades(self.rows, self.spread, self.dominance, self.residual, self.prominence_db)
        }

    def __len__(self) -> int:
        return int(self.freq_hz.size)
