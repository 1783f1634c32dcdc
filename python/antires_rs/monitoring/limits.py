r"""Limits of a chart, from the statistics of baseline tests that were left out.

A chi-square over its degrees of freedom p is made nearly normal by

.. math:: w = \frac{(T^2 / p)^{1/3} - (1 - 2 / (9 p))}{\sqrt{2 / (9 p)}},

so that tests with other values missing can be compared. The limit for a rate a is the larger of two: that of
a normal variable whose mean and variance are known from n tests (Student's t), and that of a generalized
Pareto tail fitted to the highest fifth, whose shape few tests tell little of: it is drawn to that of a normal
tail.

References: E. B. Wilson, M. M. Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684-688; J. R. M. Hosking,
J. R. Wallis, Technometrics 29 (1987) 339-349.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import FloatArray

__all__ = ["chi_square", "needed", "upper_limit", "wilson_hilferty"]

#: The tail is fitted to so large a part.
TAIL = 0.2
#: The shape of a normal tail there, and for how many tests of the tail it counts.
NORMAL_SHAPE, PRIOR = -0.12, 30.0
_STEEPEST, _HEAVIEST = -0.25, 0.5
#: Baseline tests over the inverse of the rate, at least; and beside the coefficients that are fitted.
_SHARE, _BESIDE = 0.5, 20


def wilson_hilferty(t2: FloatArray, p: FloatArray) -> FloatArray:
    """w of the module; NaN without any value."""
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = 2.0 / (9.0 * p)
        return np.asarray(
            np.where(p > 0, ((t2 / p) ** (1.0 / 3.0) - (1.0 - spread)) / np.sqrt(spread), np.nan)
        )


def chi_square(w: float, p: FloatArray) -> FloatArray:
    """T^2 of a given w."""
    with np.errstate(divide="ignore", invalid="ignore"):
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
