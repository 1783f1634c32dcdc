"""The charts of a series and their limits, from a baseline of which parts are left out in turn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.checks import FloatArray
from ..support.values import ReadOnly, frozen
from .association import Values
from .baseline import Learned, basis_of, degrees_of, fitted, folds_of, learned, scores

# -- Hotelling's distance of single tests from what the baseline expects
#
# Of the values that a test has, with normal scores z and the changes G that need no damage (conditions),
#
# .. math:: T^2 = \min_a \left( s(z - G a)^T R^{-1} s(z - G a) + a^T a \right),
#
# s turning residuals into normal deviates. Without G this is z' R^-1 z.
#
# Reference: D. C. Montgomery, Introduction to Statistical Quality Control, 7th ed. 2013, chapter 11.


@dataclass(frozen=True)
class Distances:
    """Of n tests: scores (n, m) with NaN, T^2 (n,), and the number of values behind it (n,)."""

    z: FloatArray
    t2: FloatArray
    count: FloatArray


class Inverses:
    """R^-1 of the values that are there, kept for patterns that come again."""

    def __init__(self, correlation: FloatArray) -> None:
        def of(mask: bytes) -> FloatArray:
            there = np.frombuffer(mask, dtype=np.bool_)
            return np.asarray(np.linalg.inv(correlation[np.ix_(there, there)]), dtype=np.float64)

        self._kept = lru_cache(200)(of)

    def of(self, there: NDArray[np.bool_]) -> FloatArray:
        """The inverse of the part of R that belongs to a mask (m,)."""
        return self._kept(there.tobytes())

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
    inverses: Inverses | None = None,
) -> Distances:
    """T^2 of tests (n, m); without any condition shared factors of the baseline are free."""
    inverses = inverses or Inverses(learned.correlation)
    deviation = learned.deviation(std, conditions)
    scaled = (y - learned.expected(conditions, len(y))) / deviation
    z, t2 = np.full(y.shape, np.nan), np.zeros(len(y))
    for i, rest in enumerate(scaled):
        there = ~np.isnan(rest)
        if not there.any():
            continue
        own, extra = rest[there], 0.0
        g = learned.directions(conditions, i, free=not learned.basis.columns)
        if g.shape[1]:
            g = g[there] / deviation[i, there, None]
            inverse = inverses.of(there)
            a = np.linalg.solve(np.eye(g.shape[1]) + g.T @ inverse @ g, g.T @ inverse @ own)
            own, extra = own - g @ a, float(a @ a)
        z[i, there] = scores(own, learned.degrees)
        t2[i] = inverses.t2(z[i]) + extra
    return Distances(z, t2, np.sum(~np.isnan(z), axis=1).astype(np.float64))


# -- Limits of a chart, from the statistics of baseline tests that were left out
#
# A chi-square over its degrees of freedom p is made nearly normal by
#
# .. math:: w = \frac{(T^2 / p)^{1/3} - (1 - 2 / (9 p))}{\sqrt{2 / (9 p)}},
#
# so that tests with other values missing can be compared. The limit for a rate a is the larger of two: that
# of a normal variable whose mean and variance are known from n tests (Student's t), and that of a
# generalized Pareto tail fitted to the highest fifth, whose shape few tests tell little of: it is drawn to
# that of a normal tail.
#
# References: E. B. Wilson, M. M. Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684-688; J. R. M. Hosking,
# J. R. Wallis, Technometrics 29 (1987) 339-349.

TAIL = 0.2  # the tail is fitted to so large a part
#: The shape of a normal tail there, and for how many tests of the tail it counts.
NORMAL_SHAPE, PRIOR = -0.12, 30.0
_STEEPEST, _HEAVIEST = -0.25, 0.5
#: Baseline tests over the inverse of the rate, at least; and beside the coefficients that are fitted.
_SHARE, _BESIDE = 0.5, 20


@np.errstate(divide="ignore", invalid="ignore")
def wilson_hilferty(t2: FloatArray, p: FloatArray) -> FloatArray:
    """w of the module; NaN without any value."""
    spread = 2.0 / (9.0 * p)
    w = ((t2 / p) ** (1.0 / 3.0) - (1.0 - spread)) / np.sqrt(spread)
    return np.asarray(np.where(p > 0, w, np.nan))


@np.errstate(divide="ignore", invalid="ignore")
def _chi_square(w: float, p: FloatArray) -> FloatArray:
    """T^2 of a given w."""
    spread = 2.0 / (9.0 * p)
    return np.asarray(np.where(p > 0, p * (1.0 - spread + w * np.sqrt(spread)) ** 3, np.nan))


def upper_limit(w: FloatArray, rate: float) -> float:
    """What a further one exceeds with probability ``rate``."""
    from scipy.special import stdtrit

    w = np.sort(w[~np.isnan(w)])
    n = w.size
    normal = float(w.mean() + float(-stdtrit(n - 1, rate)) * w.std(ddof=1) * np.sqrt(1.0 + 1.0 / n))
    start = float(np.quantile(w, 1.0 - TAIL))
    above = w[w > start] - start
    if above.size < 3:
        return normal
    # Probability weighted moments.
    first = float(above.mean())
    second = float(np.mean(above * (above.size - np.arange(1, above.size + 1)) / max(above.size - 1, 1)))
    told = 2.0 - first / max(first - 2.0 * second, 1e-12)
    shape = (above.size * np.clip(told, -1.0, 1.0) + PRIOR * NORMAL_SHAPE) / (above.size + PRIOR)
    shape = float(np.clip(shape, _STEEPEST, _HEAVIEST))
    scale = first * (1.0 - shape)
    ratio = TAIL / rate
    tail = scale * (np.log(ratio) if abs(shape) < 1e-6 else (ratio**shape - 1.0) / shape)
    return max(normal, float(start + tail))


def needed(rate: float, coefficients: int) -> int:
    """Baseline tests for a rate of false alarms that can be relied on."""
    return max(_BESIDE + 5 * coefficients, int(np.ceil(_SHARE / rate)))


# -- Slow and small changes: a weighted mean of the scores of a test and all before it
#
# .. math:: m_t = (1 - \lambda) m_{t-1} + \lambda z_t, \qquad T^2 = m_t^T V_t^{-1} m_t,
#
# each value by itself where tests lack it. V counts the error of the baseline's mean too. What a single test
# adds is bounded by the limit of its own chart. A test that by itself says that the change is over does not
# alarm, however far the mean still is: one that lacks the mean's change, or what tests show that alarmed by
# themselves of late.
#
# Reference: C. A. Lowry, W. H. Woodall, C. W. Champ, S. E. Rigdon, Technometrics 34 (1992) 46-53.

WEIGHT = 0.1  # lambda: a mean over some twenty tests
_FILLED = 0.2  # a value whose mean holds less than this part of what it would of complete tests is left out
_DRAWS, _BACK = 3000, 45  # draws of the chart from baseline tests, and tests that each of them reaches back
_BY_CHANCE = 1.645  # of the change that the mean shows, a test may lack so many standard deviations by chance
_ALARMS = 1.5  # so many alarms of single tests of late are a change, not chance


def means(
    z: FloatArray,
    bounds: FloatArray,
    inverses: Inverses,
    x: FloatArray,
    inverse: FloatArray,
    beyond: FloatArray,
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Chart of scores z (n, m) in order: T^2, number of values behind it, whether a test agrees with it.

    Tests are multiplied by ``bounds`` (n,). The coefficients of the baseline have one error for all tests, of
    rows ``x`` (n, q) and (X'X)^-1; so has what is not known outside its range, ``beyond`` (n, m).
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
            scaled = np.full(m, np.nan)
            scaled[used] = mean[used] / np.sqrt(variance[used] + error)
            t2[i], count[i] = inverses.t2(scaled), float(used.sum())
        # Whether it may have the mean's change, by the likelihood of both.
        along, size = _along(z[i], before, inverses)
        agrees[i] = along >= size - _BY_CHANCE * np.sqrt(size) and strong.agrees(z[i], inverses)
        strong.follow(z[i], alarmed=bool(bounds[i] < 1.0))
    return t2, count, agrees


class _Strong:
    """The change that tests show which alarm by themselves, while there were some of late."""

    def __init__(self, size: int) -> None:
        self._sum, self._weights, self._squares = np.zeros(size), np.zeros(size), np.zeros(size)

    def follow(self, z: FloatArray, *, alarmed: bool) -> None:
        """Count a test in, if it alarms."""
        there = ~np.isnan(z) & alarmed
        for kept, power, new in ((self._sum, 1, z), (self._weights, 1, 1.0), (self._squares, 2, 1.0)):
            kept *= (1.0 - WEIGHT) ** power
            kept += np.where(there, new, 0.0)

    def agrees(self, z: FloatArray, inverses: Inverses) -> bool:
        """Whether a test is nearer to that change than to none."""
        known = self._weights > _ALARMS
        weights = np.where(known, self._weights, np.nan)
        along, size = _along(z, self._sum / weights, inverses)
        # The mean's own errors are no part of the change.
        noise = float(np.sum((self._squares / weights**2)[known & ~np.isnan(z)]))
        return along >= 0.5 * max(size - noise, 0.0)


def _along(z: FloatArray, change: FloatArray, inverses: Inverses) -> tuple[float, float]:
    """z' R^-1 c and c' R^-1 c of a test and a change c, over the values that are in both."""
    both = ~np.isnan(z) & ~np.isnan(change)
    along = inverses.of(both) @ change[both]
    return float(along @ z[both]), float(change[both] @ along)


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
    """How much larger the chart of the baseline in its order is than in random order, beyond chance."""
    settled, count = t2[int(2 / WEIGHT) :], count[int(2 / WEIGHT) :]
    if settled.size < 2 / WEIGHT:
        return 1.0
    ratio = float(np.mean(settled)) / usual
    chance = np.sqrt(2.0 / (float(np.mean(count)) * (settled.size * WEIGHT / 2.0)))
    return ratio if ratio > 1.0 + 2.0 * chance else 1.0


# -- Antiresonances that vanish, merge or appear: how surprising the pattern of a test is
#
# A place that a share q of the baseline's tests has costs :math:`-\ln q` where a test has it and
# :math:`-\ln(1 - q)` where not, less what it costs on average; a value at no place costs as the baseline has
# such values rarely. Shares are those of n tests plus one half. What the test before showed as well counts
# twice: chance does not do the same again. The limit for a rate goes beyond the baseline by an exponential
# tail, whose scale is at least that of one place that was never missed.
#
# What one test does not tell many do: for each place, and each new value,
#
# .. math:: S_t = \max\left(0, S_{t-1} + \ln \frac{P_1(x_t)}{P_0(x_t)}\right)
#
# over whether a test lacks it (has it), with the share of the baseline and one of 0.8 (Page). A sum passes h
# by chance at most every e^h tests (Lorden); the limit is the h of half the rate over all places, and beyond
# what the baseline in its order shows. No sum grows far beyond, no test alarms by what it has.
#
# References: E. S. Page, Biometrika 41 (1954) 100-115; G. Lorden, Ann. Math. Stat. 42 (1971) 1897-1908.

_SAME = 0.01  # strange values of two tests are one if they are this near
#: Share of the tests that lack what has vanished, or have what is new, at least; part of the rate of sums.
_GONE, _SUMS = 0.8, 0.5


class _Costs:
    """Costs learned from presence (n, m) with what was looked at (n, m), and strange values by test."""

    def __init__(self, baseline: Values) -> None:
        tests = baseline.looked.sum(axis=0)
        there = ~np.isnan(baseline.log_hz) & baseline.looked
        share = (np.sum(there, axis=0) + 0.5) / (tests + 1.0)
        self.present, self.absent = -np.log(share), -np.log(1.0 - share)
        self.usual = share * self.present + (1.0 - share) * self.absent
        # A new value is as rare as there are tests without one, and costs more the fewer there were.
        strange = sum(map(len, baseline.strange))
        self.strange = max(float(np.log((len(baseline.strange) + 1.0) / (strange + 0.5))), 0.0) + 1.0
        # What a test adds to the sums that lacks a place, and that has it.
        gone = np.maximum(_GONE, 1.0 - 0.5 * share)
        self.lacks, self.has = np.log(gone / (1.0 - share)), np.log((1.0 - gone) / share)


def events(
    values: Values, baseline: NDArray[np.intp], folds: NDArray[np.intp], rate: float
) -> tuple[FloatArray, float]:
    """The chart of tests, (n,), and its limit; each of ``folds`` of the baseline is judged by the others."""
    own, tests = values.take(baseline), baseline.size
    whole = _Costs(own)
    chart = _chart(values, [whole] * len(values.strange))
    parts = [_Costs(own.take(np.flatnonzero(folds != fold))) for fold in range(int(folds.max()) + 1)]
    chart[baseline] = _chart(own, [parts[fold] for fold in folds.tolist()])
    top = np.quantile(chart[baseline], 1.0 - rate) if tests * rate > 3.0 else np.max(chart[baseline])
    scale = max(np.log(tests + 1.0), float(np.std(chart[baseline])))
    limit = float(top + scale * max(0.25, float(np.log(1.0 / (tests * rate)))))
    highest = float(np.log((whole.usual.size + 1) / (_SUMS * rate)))
    highest = max(highest, float(_sums(own, whole, np.inf).max()) + 0.5 * highest)
    return np.maximum(chart, _sums(values, whole, highest) / highest * limit), limit


def _sums(values: Values, costs: _Costs, limit: float) -> FloatArray:
    """The largest sum of what each test lacks or has anew, (n,), none beyond twice the limit."""
    found = np.zeros(len(values.strange))
    sums: FloatArray = np.zeros(values.log_hz.shape[1])
    new: dict[tuple[Any, float], float] = {}
    for i, strange in enumerate(values.strange):
        lacks = values.looked[i] & np.isnan(values.log_hz[i])
        step = np.where(lacks, costs.lacks, np.where(values.looked[i], costs.has, 0.0))
        sums = np.clip(sums + step, 0.0, 2.0 * limit)
        found[i] = np.max(sums[lacks], initial=0.0)
        before, new = new, {}
        for dof, freq in strange:
            same = [key for key in before if key[0] == dof and abs(key[1] / freq - 1.0) < _SAME]
            new[dof, freq] = min(costs.strange - 1.0 + sum(before.pop(key) for key in same), 2.0 * limit)
            found[i] = max(found[i], new[dof, freq])
        fall = np.log(1.0 - _GONE)
        new |= {key: total + fall for key, total in before.items() if total > -fall}
    return found


def _chart(values: Values, costs: Sequence[_Costs]) -> FloatArray:
    chart = np.zeros(len(values.strange))
    before: FloatArray = np.zeros(values.log_hz.shape[1])
    strange_before: Sequence[tuple[Any, float]] = ()
    for i, cost in enumerate(costs):
        there, strange = ~np.isnan(values.log_hz[i]), values.strange[i]
        place = np.where(values.looked[i], np.where(there, cost.present, cost.absent) - cost.usual, 0.0)
        chart[i] = float(place.sum()) + cost.strange * len(strange)
        chart[i] += float(np.minimum(np.maximum(place, 0.0), np.maximum(before, 0.0)).sum())
        again = (any(dof == d and abs(f / g - 1.0) < _SAME for d, g in strange_before) for dof, f in strange)
        chart[i] += cost.strange * sum(again)
        before, strange_before = place, strange
    return chart


SHARES = {"T2": 0.6, "EWMA": 0.2, "events": 0.2}  # how the rate of false alarms is shared out


@dataclass(frozen=True, eq=False, repr=False)
class Chart(ReadOnly):
    """One control chart.

    Attributes
    ----------
    statistic : (n,)
        NaN where a test has nothing to judge it by.
    limit : (n,)
        A test alarms above it.
    rate : float
        Its share of the rate of false alarms.

    Examples
    --------
    >>> import antires_rs as ar, numpy as np
    >>> ar.Chart(np.array([12.0, 31.0]), np.array([25.0, 25.0]), 0.006)
    Chart(1 of 2 above the limit, rate 0.006)
    """

    statistic: FloatArray
    limit: FloatArray
    rate: float

    @property
    @np.errstate(invalid="ignore", divide="ignore")
    def ratio(self) -> FloatArray:
        """Statistic over limit, 0 where there is none, (n,)."""
        return np.asarray(np.nan_to_num(self.statistic / self.limit))

    def __repr__(self) -> str:
        above = f"{np.sum(self.ratio > 1.0)} of {self.statistic.size} above the limit"
        return f"Chart({above}, rate {self.rate:g})"


@dataclass(frozen=True)
class Charts:
    """All charts of n tests by name, what the baseline taught, and the scores (n, m) behind them."""

    charts: Mapping[str, Chart]
    learned: Learned
    z: FloatArray
    inverses: Inverses


def charts_of(
    values: Values,
    regular: NDArray[np.bool_],
    baseline: NDArray[np.intp],
    conditions: Mapping[str, FloatArray],
    rate: float,
) -> Charts:
    """Charts of n tests, without responses at fault, over the ``regular`` places, by the ``baseline``."""
    y, std = values.log_hz[:, regular], values.std[:, regular]
    own = {name: column[baseline] for name, column in conditions.items()}
    basis = basis_of(y[baseline], own)
    x = basis.rows(conditions, len(y))
    degrees = degrees_of(y[baseline] - fitted(y[baseline], x[baseline]).at(x[baseline]))
    whole = learned(y[baseline], std[baseline], own, basis, degrees)
    inverses = Inverses(whole.correlation)
    found = distances(whole, y, std, conditions, inverses)
    z, t2, count = found.z.copy(), found.t2.copy(), found.count
    folds = folds_of(baseline.size)  # The baseline's tests as what they would be if they came later.
    for fold in range(int(folds.max()) + 1):
        out, kept = baseline[folds == fold], baseline[folds != fold]
        others, there = ({name: column[at] for name, column in conditions.items()} for at in (kept, out))
        seen = distances(learned(y[kept], std[kept], others, basis, degrees), y[out], std[out], there)
        z[out], t2[out] = seen.z, seen.t2
    rates = {name: share * rate for name, share in SHARES.items()}
    limit = _chi_square(upper_limit(wilson_hilferty(t2[baseline], count[baseline]), rates["T2"]), count)
    single = _chart_over(t2, limit, count > 0, rates["T2"])
    # Slow changes.
    bounds = np.sqrt(1.0 / np.maximum(single.ratio, 1.0))
    unsure = whole.beyond(conditions, len(y)) / whole.deviation(std, conditions)
    slow, values_behind, agrees = means(z, bounds, inverses, x, whole.regression.inverse, unsure)
    limit_w, usual = drawn(z[baseline], whole.correlation, basis.size / baseline.size, rates["EWMA"])
    first = np.sort(baseline)
    slow = slow / autocorrelation(slow[first], values_behind[first], usual)
    limit = _chi_square(limit_w, values_behind)
    slow = np.where(agrees, slow, np.minimum(slow, limit))
    mean = _chart_over(slow, limit, (count > 0) & (values_behind > 0), rates["EWMA"])
    chart, highest = events(values, baseline, folds, rates["events"])
    looked = np.any(values.looked, axis=1)
    vanished = _chart_over(chart, np.full(chart.size, highest), looked, rates["events"])
    return Charts({"T2": single, "EWMA": mean, "events": vanished}, whole, z, inverses)


def _chart_over(statistic: FloatArray, limit: FloatArray, judged: NDArray[np.bool_], rate: float) -> Chart:
    return Chart(frozen(np.where(judged, statistic, np.nan)), frozen(limit), rate)
