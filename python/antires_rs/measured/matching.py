r"""Which antiresonance of one set is which of another: the assignment of least cost over a response.

A pair at distance d costs (d / t)^2 and a value without partner 1/2, so that two values are paired if that
explains them better than that one vanished and another appeared; t, the largest distance, is

    t^2 = (max_shift f)^2 + (3 std)^2,      std that of the difference.

All pairs of a response are found at once, no value twice; the cost is convex, so that pairs do not cross.

Reference: D. F. Crouse, IEEE Trans. Aerosp. Electron. Syst. 52 (2016) 1679-1696 (the algorithm in SciPy).
"""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..exceptions import Argument, reject
from ..support.checks import FloatArray, finite_scalar
from .antiresonance_set import AntiresonanceSet
from .response_table import ResponseTable

MAX_SHIFT = 0.05  # largest relative distance of two values that are one, by default
STDS = 3.0  # a difference may exceed that by so many standard deviations
FORBIDDEN = 1e3  # cost of what may not be paired: more than leaving both alone


def paired(
    a_hz: FloatArray,
    b_hz: FloatArray,
    max_shift: float,
    variance: FloatArray | None = None,
    worth: FloatArray | None = None,
) -> list[tuple[int, int]]:
    """Indices of the values that are one, by ascending frequency.

    ``worth`` of ``b_hz``, 0 to 1, by default 1: one that is worth less costs less if left alone, and more in
    a pair.
    """
    from scipy.optimize import linear_sum_assignment  # slow to import

    if not a_hz.size or not b_hz.size:
        return []
    middle = 0.5 * (a_hz[:, None] + b_hz)
    reach = (max_shift * middle) ** 2
    if variance is not None:
        reach = reach + STDS**2 * np.nan_to_num(variance)
    cost = (b_hz - a_hz[:, None]) ** 2 / reach
    # Of many tracks few are near what a test has; the others stay alone in any case.
    near_a, near_b = (np.flatnonzero((cost < 1.0).any(axis=axis)) for axis in (1, 0))
    cost, n, m = cost[np.ix_(near_a, near_b)], near_a.size, near_b.size
    alone = 0.5 * (np.ones(m) if worth is None else worth[near_b])
    cost = cost + (0.5 - alone)
    # Beside it a partner of nobody for each, so that the least total may leave any value alone.
    square = np.full((n + m, n + m), FORBIDDEN)
    square[:n, :m] = np.where(cost < 1.0, cost, FORBIDDEN)
    square[np.arange(n), m + np.arange(n)] = 0.5
    square[n + np.arange(m), np.arange(m)] = alone
    square[n:, m:] = 0.0
    rows, columns = linear_sum_assignment(square)
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return [(int(near_a[i]), int(near_b[k])) for i, k in pairs if i < n and k < m]


KNOWN = "known_hz"  # score of values that were followed: where in Hz the value was that each of them is


def matched(
    a: ResponseTable, b: ResponseTable, max_shift: float, variance: FloatArray | None = None
) -> list[tuple[int, int]]:
    """Rows of two tables that are one: those followed from one value, and of the others as :func:`paired`."""
    sure: list[tuple[int, int]] = []
    if KNOWN in a.scores or KNOWN in b.scores:
        where = {freq: k for k, freq in enumerate(_origin(b).tolist())}
        sure = [(i, where[freq]) for i, freq in enumerate(_origin(a).tolist()) if freq in where]
    i = np.setdiff1d(np.arange(len(a)), [row for row, _ in sure])
    k = np.setdiff1d(np.arange(len(b)), [row for _, row in sure])
    rest = None if variance is None else np.broadcast_to(variance, (len(a), len(b)))[np.ix_(i, k)]
    more = paired(a.freq_hz[i], b.freq_hz[k], max_shift, rest)
    return sorted(sure + [(int(i[m]), int(k[n])) for m, n in more])


def _origin(table: ResponseTable) -> FloatArray:
    """Where each value was known, where it was followed; else where it is."""
    known = np.asarray(table.scores.get(KNOWN, table.freq_hz), dtype=np.float64)
    return np.where(np.isnan(known), table.freq_hz, known)


def variance_hz(table: ResponseTable, std_between: float) -> FloatArray:
    """Variance of every value in Hz^2, with the scatter between tests; NaN where neither is known."""
    own = table.std_hz**2
    between = (std_between * table.freq_hz) ** 2
    return np.where(np.isnan(own), between if std_between > 0.0 else np.nan, own + between)


@runtime_checkable
class SeriesOfTests(Protocol):
    """Many tests of one structure, see :class:`antires_rs.Series`, which stands above this room."""

    def tracks(self, conditions: Any = None, **options: Any) -> Any:
        """Every antiresonance followed over them."""

    def average(self, **options: Any) -> Any:
        """One set that stands for all of them."""


#: Limits of the arguments that comparing, following and joining share.
_LIMITS: dict[str, dict[str, Any]] = {
    "max_shift": {"high": 0.5, "low_open": True},
    "std_between": {"high": 0.5},
    "std_common": {"high": 0.5},
    "alpha": {"high": 1.0, "low_open": True, "high_open": True},
}


def within(name: str, value: Any) -> float:
    """One of the shared arguments, in its limits from 0."""
    return finite_scalar(name, value, low=0.0, **_LIMITS[name])


def check_sets(name: str, sets: Any, least: int) -> list[AntiresonanceSet]:
    """A list of sets, at least so many."""
    wanted = f"a list of {least} sets or more"
    if not isinstance(sets, list | tuple):
        reject(name, type(sets).__name__, wanted, "Put the sets in a list.")
    if len(sets) < least:
        reject(name, f"{len(sets)} of them", wanted, "Give the others too.")
    return [check_set(Argument(name).item(i), one) for i, one in enumerate(sets)]


def check_set(name: str, one: Any) -> AntiresonanceSet:
    """A set of antiresonances."""
    if not isinstance(one, AntiresonanceSet):
        remedy = "Identify the record first: identify_antiresonances(record, ...)."
        reject(name, type(one).__name__, "an AntiresonanceSet", remedy)
    return one


# -- Is a difference more than its errors? A test of each value and of all
#
# A standard deviation told by k independent averages is itself known to about 1 / sqrt(2 k) only, so that a
# difference over its standard deviation follows Student's t with the smaller k of the two sets. The test of
# all is chi^2 = sum_i z_i^2, z_i being the normal deviate of the probability of each; it takes values of
# different responses for independent (on the eight-mass chain their correlations are 0.08 at the root mean
# square). What moves all values alike (temperature), with a relative standard deviation c, is no difference:
# with l_i = sqrt(2) c f_i / std_i its likeliest size is
#
#     g = sum_i l_i d_i / (1 + sum_i l_i^2)      (d_i: difference over its own deviation),
#
# and chi^2 is that of the rests d_i - l_i g plus g^2. Which single values have changed is told at the same
# rate of false alarms for all of them together (Holm).
#
# References: B. L. Welch, Biometrika 34 (1947) 28-35; R. A. Fisher, Statistical Methods for Research Workers,
# 1932, sec. 21.1 (joining tests); S. Holm, Scand. J. Stat. 6 (1979) 65-70.

AVERAGES = 15.0  # independent averages behind a standard deviation where a set does not tell


def averages_of(table: ResponseTable) -> FloatArray:
    """Independent averages behind each standard deviation."""
    known = np.asarray(table.scores.get("averages", np.full(len(table), np.nan)), dtype=np.float64)
    return np.where(np.isnan(known), AVERAGES, known)


def of_each(difference: FloatArray, std: FloatArray, averages: FloatArray) -> FloatArray:
    """Probability of a difference as large by chance, NaN where no deviation is known."""
    from scipy.stats import t  # slow to import

    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(2.0 * t.sf(np.abs(difference) / std, averages))


def of_all(p: FloatArray, common: float = 0.0) -> tuple[float, int, float]:
    """Chi-square with the square of g, ``common``, its freedom, and the probability of one as large."""
    from scipy.stats import chi2  # slow to import

    known = p[~np.isnan(p)]
    # Of one degree of freedom: the square of the normal deviate. A p of 0 is one that underflowed.
    total = float(chi2.isf(np.maximum(known, 1e-300), 1).sum()) + common**2
    return total, known.size, float(chi2.sf(total, known.size)) if known.size else float("nan")


def common_part(scaled: FloatArray, load: FloatArray) -> float:
    """g of the module, from the differences over their own deviations and l, (n,) each; NaN are left out."""
    there = ~np.isnan(scaled)
    d, share = scaled[there], load[there]
    return float(share @ d / (1.0 + share @ share))


def holm(p: FloatArray, alpha: float) -> NDArray[np.bool_]:
    """Which differences are real, with a chance of at most ``alpha`` that any of them is not."""
    known = np.flatnonzero(~np.isnan(p))
    rank = known[np.argsort(p[known], kind="stable")]
    passed = np.logical_and.accumulate(p[rank] <= alpha / np.arange(rank.size, 0, -1))
    return np.isin(np.arange(p.size), rank[passed])


# -- How much repeats of one test scatter beyond their stated deviations
#
# With r_tk the distance of value k in test t from its mean over the tests, and s_tk its stated deviation,
# both relative, what all values of a test share is a_t = sum_k w_tk r_tk / sum_k w_tk, w_tk = 1 / (s_tk^2 +
# tau^2). tau, the scatter of single values, makes sum_tk w_tk (r_tk - a_t)^2 the degrees of freedom (R. C.
# Paule and J. Mandel, J. Res. Natl. Bur. Stand. 87 (1982) 377-385); both are found in turn. The variance of
# a_t, less that of the mean, is the square of the common scatter.

ROUNDS = 8  # common part and scatter of the rest settle in a few rounds


def scatter(freq_hz: FloatArray, std_hz: FloatArray) -> tuple[float, float]:
    """Scatter of single values and common scatter, relative; NaN where no value is there twice."""
    some = np.sum(~np.isnan(freq_hz), axis=0) >= 2
    if not some.any():
        return float("nan"), float("nan")
    freq = freq_hz[:, some]
    freq, std = (array[~np.isnan(freq).all(axis=1)] for array in (freq, std_hz[:, some]))
    there = ~np.isnan(freq)
    middle = np.nanmean(freq, axis=0)
    away = freq / middle - 1.0
    n_tests, count = freq.shape
    stated = np.nan_to_num(std / middle) ** 2
    free = int(there.sum()) - count - (n_tests - 1)
    if free <= 0:  # a single value: what is its own and what is common cannot be told apart
        tau2 = _beyond((away**2)[there], stated[there], int(there.sum()) - count)
        return float(np.sqrt(tau2)), 0.0
    tau2 = float(np.nanmean(away**2))
    for _ in range(ROUNDS):
        weight = np.where(there, 1.0 / np.maximum(stated + tau2, 1e-300), 0.0)
        alike = np.nansum(weight * away, axis=1) / weight.sum(axis=1)
        tau2 = _beyond(((away - alike[:, None]) ** 2)[there], stated[there], free)
    common = np.sum(alike**2) / (n_tests - 1) - np.mean(1.0 / weight.sum(axis=1))
    return float(np.sqrt(tau2)), float(np.sqrt(max(0.0, common)))


def _beyond(rest: FloatArray, stated: FloatArray, free: int) -> float:
    """tau^2 of the module; 0 where the stated variances explain all."""
    from scipy.optimize import brentq  # slow to import

    def too_large(tau2: float) -> float:
        return float(np.sum(rest / np.maximum(stated + tau2, 1e-300))) - free

    if too_large(0.0) <= 0.0:
        return 0.0
    return float(brentq(too_large, 0.0, 1.001 * float(np.sum(rest)) / free, xtol=1e-24, rtol=1e-12))
