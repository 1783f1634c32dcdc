r"""Hotelling's distance of single tests from what the baseline expects.

Of the values that a test has, with normal scores z and the changes G that need no damage (conditions),

.. math:: T^2 = \min_a \left( s(z - G a)^T R^{-1} s(z - G a) + a^T a \right),

s turning residuals into normal deviates. Without G this is z' R^-1 z.

Reference: D. C. Montgomery, Introduction to Statistical Quality Control, 7th ed. 2013, chapter 11.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .learned import Learned
from .normal import scores
from .nuisance import directions

__all__ = ["Distances", "Inverses", "distances"]


@dataclass(frozen=True)
class Distances:
    """Of n tests: scores (n, m) with NaN, T^2 (n,), and the number of values behind it (n,)."""

    z: FloatArray
    t2: FloatArray
    count: FloatArray


class Inverses:
    """R^-1 of the values that are there, kept for patterns that come again."""

    _MOST = 200

    def __init__(self, correlation: FloatArray) -> None:
        self._correlation = correlation
        self._kept: dict[bytes, FloatArray] = {}

    def of(self, there: NDArray[np.bool_]) -> FloatArray:
        """The inverse of the part of R that belongs to a mask (m,)."""
        key = there.tobytes()
        if key not in self._kept:
            if len(self._kept) >= self._MOST:
                self._kept.clear()
            self._kept[key] = np.asarray(
                np.linalg.inv(self._correlation[np.ix_(there, there)]), dtype=np.float64
            )
        return self._kept[key]

    def t2(self, z: FloatArray) -> float:
        """z' R^-1 z of the values that are not NaN; 0 without any."""
        there = ~np.isnan(z)
        own = z[there]
        return float(own @ self.of(there) @ own)


def distances(
    learned: Learned,
    y: FloatArray,
    std: FloatArray,
    conditions: Mapping[str, FloatArray],
    *,
    free: bool,
    inverses: Inverses | None = None,
) -> Distances:
    """T^2 of tests (n, m); ``free`` as for :func:`directions`."""
    inverses = inverses or Inverses(learned.correlation)
    n = len(y)
    rest = y - learned.expected(conditions, n)
    deviation = learned.deviation(std, conditions)
    scaled = rest / deviation
    z = np.full(y.shape, np.nan)
    t2 = np.zeros(n)
    for i in range(n):
        there = ~np.isnan(scaled[i])
        if not there.any():
            continue
        own, extra = scaled[i, there], 0.0
        g = directions(learned, conditions, i, free=free)
        if g.shape[1]:
            g = g[there] / deviation[i, there, None]
            inverse = inverses.of(there)
            a = np.linalg.solve(np.eye(g.shape[1]) + g.T @ inverse @ g, g.T @ inverse @ own)
            own, extra = own - g @ a, float(a @ a)
        z[i, there] = scores(own, learned.degrees)
        t2[i] = inverses.t2(z[i]) + extra
    return Distances(z, t2, np.sum(~np.isnan(z), axis=1).astype(np.float64))
