r"""Slow and small changes: a weighted mean of the scores of a test and all before it.

.. math:: m_t = (1 - \lambda) m_{t-1} + \lambda z_t, \qquad T^2 = m_t^T V_t^{-1} m_t,

each value by itself where tests lack it. V counts the error of the baseline's mean too. What a single test
adds is bounded by the limit of its own chart. A test that by itself says that the change is over does not
alarm, however far the mean still is: one that lacks the mean's change, or what tests show that alarmed by
themselves of late.

Reference: C. A. Lowry, W. H. Woodall, C. W. Champ, S. E. Rigdon, Technometrics 34 (1992) 46-53.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .distance import Inverses
from .limits import upper_limit, wilson_hilferty

__all__ = ["WEIGHT", "Means", "autocorrelation", "drawn", "means"]

#: lambda: a mean over some twenty tests.
WEIGHT = 0.1
#: A value whose mean holds less than this part of what it would of complete tests is left out.
_FILLED = 0.2
#: Draws of the chart from baseline tests, and tests that each of them reaches back.
_DRAWS, _BACK = 3000, 45
#: Of the change that the mean shows, a test may lack so many standard deviations by chance.
_BY_CHANCE = 1.645
#: So many alarms of single tests of late are a change, not chance.
_ALARMS = 1.5


class Means:
    """The chart in order: T^2, number of values behind it, whether a test agrees with its mean."""

    def __init__(self, t2: FloatArray, count: FloatArray, agrees: NDArray[np.bool_]) -> None:
        self.t2, self.count, self.agrees = t2, count, agrees


def means(
    z: FloatArray,
    bounds: FloatArray,
    inverses: Inverses,
    x: FloatArray,
    inverse: FloatArray,
    beyond: FloatArray,
) -> Means:
    """Chart of scores (n, m).

    Parameters
    ----------
    z : (n, m)
    bounds : (n,)
        What each test is multiplied by.
    inverses : Inverses
        Of the correlations.
    x, inverse : (n, q), (q, q)
        Rows of the basis, and (X'X)^-1 of the baseline: its coefficients have one error for all tests.
    beyond : (n, m)
        What is not known outside the baseline's range, over the standard deviation of a test: one error too.
    """
    n, m = z.shape
    row, lasting = np.zeros(x.shape[1]), np.zeros(m)
    strong = _Strong(m)
    mean, filled, variance = np.zeros(m), np.zeros(m), np.zeros(m)
    t2, count, agrees = np.zeros(n), np.zeros(n), np.ones(n, dtype=bool)
    for i in range(n):
        there = ~np.isnan(z[i])
        before = np.where(filled > _FILLED, mean / np.maximum(filled, 1e-9), np.nan)
        step = np.where(there, WEIGHT, 0.0)
        mean = (1.0 - step) * mean + step * np.where(there, z[i] * bounds[i], 0.0)
        variance = (1.0 - step) ** 2 * variance + step**2
        filled = (1.0 - step) * filled + step
        if there.any():
            row = (1.0 - WEIGHT) * row + WEIGHT * x[i]
        lasting = (1.0 - step) * lasting + step * beyond[i]
        used = variance > 0.0
        if used.any():
            error = float(row @ inverse @ row) + lasting[used] ** 2
            scaled = mean[used] / np.sqrt(variance[used] + error)
            full = np.full(m, np.nan)
            full[used] = scaled
            t2[i], count[i] = inverses.t2(full), float(used.sum())
        agrees[i] = _agrees(z[i], before, inverses) and strong.agrees(z[i], inverses)
        strong.follow(z[i], alarmed=bool(bounds[i] < 1.0))
    return Means(t2, count, agrees)


class _Strong:
    """The change that tests show which alarm by themselves, while there were some of late."""

    def __init__(self, size: int) -> None:
        self._sum, self._weights, self._squares = np.zeros(size), np.zeros(size), np.zeros(size)

    def follow(self, z: FloatArray, *, alarmed: bool) -> None:
        """Count a test in, if it alarms."""
        for kept, power in ((self._sum, 1), (self._weights, 1), (self._squares, 2)):
            kept *= (1.0 - WEIGHT) ** power
        if alarmed:
            there = ~np.isnan(z)
            self._sum[there] += z[there]
            self._weights[there] += 1.0
            self._squares[there] += 1.0

    def agrees(self, z: FloatArray, inverses: Inverses) -> bool:
        """Whether a test is nearer to that change than to none."""
        both = ~np.isnan(z) & (self._weights > _ALARMS)
        if not both.any():
            return True
        mean = self._sum[both] / self._weights[both]
        along = inverses.of(both) @ mean
        # The mean's own errors are no part of the change.
        noise = float(np.sum(self._squares[both] / self._weights[both] ** 2))
        return bool(float(along @ z[both]) >= 0.5 * max(float(along @ mean) - noise, 0.0))


def _agrees(z: FloatArray, mean: FloatArray, inverses: Inverses) -> bool:
    """Whether a test may have the mean's change, by the likelihood of both."""
    both = ~np.isnan(z) & ~np.isnan(mean)
    if not both.any():
        return True
    inverse = inverses.of(both)
    along = inverse @ mean[both]
    size = float(mean[both] @ along)
    return bool(float(along @ z[both]) >= size - _BY_CHANCE * np.sqrt(size))


def drawn(z: FloatArray, correlation: FloatArray, error: float, rate: float) -> tuple[float, float]:
    """Limit for a rate (w of ``limits``) and mean T^2 of the chart over baseline tests in random order."""
    rng = np.random.default_rng(0)
    n, m = z.shape
    off = rng.multivariate_normal(np.zeros(m), correlation, size=_DRAWS, method="cholesky") * np.sqrt(error)
    there, filled = ~np.isnan(z), np.nan_to_num(z)
    mean, variance, weight = np.zeros((_DRAWS, m)), np.zeros((_DRAWS, m)), np.zeros((_DRAWS, m))
    for _ in range(_BACK):  # as ``means`` does, missing values included
        test = rng.integers(0, n, _DRAWS)
        step = np.where(there[test], WEIGHT, 0.0)
        mean = (1.0 - step) * mean + step * filled[test]
        variance = (1.0 - step) ** 2 * variance + step**2
        weight = (1.0 - step) * weight + step
    with np.errstate(invalid="ignore"):
        scaled = (mean + off * weight) / np.sqrt(np.where(variance > 0.0, variance + error, np.nan))
    inverses = Inverses(correlation)
    t2 = np.array([inverses.t2(one) for one in scaled])
    count = np.sum(variance > 0.0, axis=1).astype(np.float64)
    return upper_limit(wilson_hilferty(t2, count), rate), float(t2.mean())


def autocorrelation(t2: FloatArray, count: FloatArray, usual: float) -> float:
    """How much larger the chart of the baseline in its order is than in random order, at least 1.

    Tests that follow each other may be off together (weather that no condition tells): a part beyond what
    chance makes is taken off the chart.
    """
    settled = slice(int(2 / WEIGHT), None)
    if t2[settled].size < 2 / WEIGHT:
        return 1.0
    ratio = float(np.mean(t2[settled])) / usual
    independent = t2[settled].size * WEIGHT / 2.0
    chance = np.sqrt(2.0 / (float(np.mean(count[settled])) * independent))
    return ratio if ratio > 1.0 + 2.0 * chance else 1.0
