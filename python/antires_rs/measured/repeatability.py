r"""How much repeats of one test scatter beyond their stated deviations.

With r_tk the relative distance of value k in test t from the mean of k over the tests, and s_tk its stated
relative deviation, the part that all values of a test have in common is their weighted mean

    a_t = sum_k w_tk r_tk / sum_k w_tk,      w_tk = 1 / (s_tk^2 + tau^2).

The scatter of single values, tau, is that with which the rest is as large as it should be,

    sum_tk w_tk (r_tk - a_t)^2 = degrees of freedom,

so that values known well tell most (R. C. Paule and J. Mandel, J. Res. Natl. Bur. Stand. 87 (1982) 377-385);
a and tau are found in turn. The variance of a_t over the tests, less that of the mean, is the square of the
common scatter.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import FloatArray

__all__ = ["scatter"]

# Bisections: the root of a falling function to ten digits.
STEPS = 40
# Common part and scatter of the rest settle in a few rounds.
ROUNDS = 8


def scatter(freq_hz: FloatArray, std_hz: FloatArray) -> tuple[float, float]:
    """Scatter of single values and common scatter, relative; NaN where no value is there twice.

    Parameters
    ----------
    freq_hz, std_hz : (n_tests, n_values)
        NaN where a test does not have a value, or its deviation is not known.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.measured.repeatability import scatter
    >>> rng = np.random.default_rng(0)
    >>> alike, each = 1e-3 * rng.standard_normal((50, 1)), 2e-4 * rng.standard_normal((50, 20))
    >>> [f"{s:.1e}" for s in scatter(100.0 * (1.0 + alike + each), np.full((50, 20), 0.01))]
    ['1.7e-04', '9.2e-04']
    """
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
    low, high = 0.0, float(np.sum(rest) / free)
    if np.sum(rest / np.maximum(stated, 1e-300)) <= free:
        return 0.0
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        if np.sum(rest / np.maximum(stated + middle, 1e-300)) > free:
            low = middle
        else:
            high = middle
    return high
