"""On which sides the data leave a parameter open, and in which words that is said.

A side is open if the sum of squares over the errors' variances, with the parameter held at that bound and the
others fitted again, rises by less than the chi-square quantile (Raue et al., Bioinformatics 25 (2009)
1923-1929).
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from ..support.validation import FloatArray
from .fit import Fit, least_squares

__all__ = ["Kind", "covariance", "kind_of", "open_sides", "squares", "threshold", "words_of"]

Kind = Literal["two-sided", "one-sided", "flat", "fixed"]

#: A combination that is seen this little, relative to the best seen, has no covariance of its own.
_RIDGE = 1e-12


def threshold(level: float) -> float:
    """Rise of the sum of squares at the ends of an interval: chi-square with one degree of freedom."""
    from scipy.special import ndtri

    return float(ndtri(0.5 + level / 2.0) ** 2)


def covariance(fit: Fit) -> FloatArray:
    """Covariance of the free parameters as if nothing bounded them, (n, n); huge where nothing is seen."""
    weighted = fit.jacobian / fit.sigma[:, None]
    precision = weighted.T @ weighted
    values, vectors = np.linalg.eigh(precision)
    least = _RIDGE * max(float(values.max(initial=0.0)), 1.0)
    return np.asarray((vectors / np.maximum(values, least)) @ vectors.T)


def open_sides(fit: Fit, level: float, refit: bool) -> list[tuple[bool, bool, bool]]:
    """For every free parameter: open below, open above, and closed only by the bounds of others.

    By the linear residuals, or with ``refit`` by least squares with the parameter held at its bound.
    """
    limit, spread = threshold(level), np.diag(covariance(fit))
    least = squares(fit, fit.u)
    sides = []
    for j, center in enumerate(fit.u):
        opened, by_others = [], False
        for bound in (0.0, 1.0):
            alone = (bound - center) ** 2 / spread[j]  # as if the others had no bounds
            if alone > 4.0 * limit or (not refit and alone > limit):
                opened.append(False)
                continue
            rise = _rise_at(fit, j, bound, refit) - least
            opened.append(bool(rise < limit))
            by_others |= rise >= limit > alone
        sides.append((opened[0], opened[1], by_others))
    return sides


def words_of(low_open: bool, high_open: bool, by_others: bool) -> str:
    """What the data say of a parameter."""
    kind = kind_of(low_open, high_open)
    if kind == "one-sided":
        side = "lower" if low_open else "upper"
        return f"one-sided: its {side} bound fits as well"
    if kind == "two-sided" and by_others:
        return "two-sided, through the bounds of others"
    return kind


def kind_of(low_open: bool, high_open: bool) -> Kind:
    """Which it is by the sides that are open."""
    return "flat" if low_open and high_open else "one-sided" if low_open or high_open else "two-sided"


def _rise_at(fit: Fit, j: int, bound: float, refit: bool) -> float:
    """Sum of squares with parameter j at a bound and the others fitted within theirs."""
    from scipy.optimize import lsq_linear

    others = np.delete(np.arange(fit.u.size), j)
    weighted = fit.jacobian / fit.sigma[:, None]
    shifted = fit.e / fit.sigma + weighted[:, j] * (bound - fit.u[j])
    u = fit.u.copy()
    u[j] = bound
    if others.size:
        ends = (np.minimum(-u[others], -1e-12), np.maximum(1.0 - u[others], 1e-12))
        found = lsq_linear(weighted[:, others], -shifted, ends, method="bvls")
        if not refit:
            return float(2.0 * found.cost)
        u[others] = np.clip(u[others] + found.x, 0.0, 1.0)
    elif not refit:
        return float(shifted @ shifted)
    return squares(fit, least_squares(fit.residuals, u, fit.sigma, held=[j]))


def squares(fit: Fit, u: FloatArray) -> float:
    """Sum of squares over the errors' variances at u."""
    return float(np.sum((fit.residuals.at(u) / fit.sigma) ** 2))
