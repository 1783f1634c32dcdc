r"""Is a difference more than its errors? A test of each value and of all.

A standard deviation told by k independent averages is itself known to about 1 / sqrt(2 k) only, so that a
difference over its standard deviation follows Student's t, not the normal law; nu is the smaller k of the two
sets (Welch's conservative choice). With p_i of each, the test of all is

    chi^2 = sum_i z_i^2,      z_i = the normal deviate of probability p_i,

with as many degrees of freedom as values. It takes the values of different responses for independent; on the
eight-mass chain their correlations are below 0.5, and 0.08 at the root mean square.

What moves all values alike from test to test (temperature, mostly), with a relative standard deviation c, is
no difference. With l_i = sqrt(2) c f_i / std_i its likeliest size and what it leaves are

    g = sum_i l_i d_i / (1 + sum_i l_i^2),      d_i - l_i g      (d_i: the difference over its own deviation),

and chi^2 is that of the rests plus g^2: the quadratic form of d in the inverse of its covariance 1 + l l'.

Which single values have changed is told at the same rate of false alarms for all of them together (Holm).

References: B. L. Welch, Biometrika 34 (1947) 28-35; R. A. Fisher, Statistical Methods for Research Workers,
1932, sec. 21.1 (joining tests); S. Holm, Scand. J. Stat. 6 (1979) 65-70.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..order_sweep.table import ResponseTable
from ..support.validation import FloatArray

__all__ = ["AVERAGES", "averages_of", "common_part", "holm", "of_all", "of_each"]

#: Independent averages behind a standard deviation where a set does not tell.
AVERAGES = 15.0


def averages_of(table: ResponseTable) -> FloatArray:
    """Independent averages behind each standard deviation."""
    known = table.scores.get("averages")
    told = np.full(len(table), np.nan) if known is None else np.asarray(known, dtype=np.float64)
    return np.where(np.isnan(told), AVERAGES, told)


def of_each(difference: FloatArray, std: FloatArray, averages: FloatArray) -> FloatArray:
    """Probability of a difference as large by chance, NaN where no deviation is known."""
    from scipy.stats import t  # slow to import

    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(2.0 * t.sf(np.abs(difference) / std, averages))


def of_all(p: FloatArray, common: float = 0.0) -> tuple[float, int, float]:
    """Chi-square, its degrees of freedom, and the probability of one as large by chance.

    ``common`` is g of the module, whose square is added.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.measured.significance import of_all
    >>> chi_square, n, p = of_all(np.array([0.5, 0.3, 0.8, np.nan]))
    >>> round(chi_square, 2), n, round(p, 2)
    (1.59, 3, 0.66)
    """
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
    passed = p[rank] <= alpha / np.arange(rank.size, 0, -1)
    found = np.zeros(p.size, dtype=bool)
    found[rank[: int(np.argmin(passed)) if not passed.all() else rank.size]] = True
    return found
