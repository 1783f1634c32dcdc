r"""The scatter between repeats of a test, in the variance of an identified value.

R records of one test, R impacts, or the curves of R tests are R independent draws. What each would move a
zero by, summed over the record, gives

    b^2 = R / (R - 1) sum_r (u_r - mean u)^2

which holds whatever differs from record to record: noise, the strength of the force, temperature, mounting.
But it has R - 1 degrees of freedom only. The scatter inside the records (of their segments; of an impact or a
curve, in blocks of neighbouring lines) has many, and knows noise and leakage alone: w^2. Their ratio is much
the same for all zeros of a test, so that all tell of it together:

    q = max(1, median of b^2 / w^2 over all zeros / median of chi^2_{R-1} / (R - 1)),

and the variance of one zero is the average of what it says itself and what the test says, by their degrees of
freedom,

    ((R - 1) b^2 + n_0 q w^2) / (R - 1 + n_0),      n_0 = 8.

Reference: G. K. Smyth, Stat. Appl. Genet. Mol. Biol. 3 (2004) article 3 (moderated variances).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..signals.spectra import CrossSpectra
from ..support.validation import FloatArray

__all__ = ["combined", "excess", "freedom", "independent_averages", "sums_by_draw"]

# Degrees of freedom with which the whole test speaks on the variance of one zero.
PRIOR = 8.0


def sums_by_draw(push: FloatArray, draws: NDArray[np.int64]) -> FloatArray:
    """Columns of ``push`` (n_coefficients, n_segments), less their mean, summed by draw: R columns."""
    centred = push - push.mean(axis=1, keepdims=True)
    return np.stack([centred[:, draws == draw].sum(axis=1) for draw in np.unique(draws)], axis=1)


def excess(between: FloatArray, within: FloatArray, n_draws: int) -> float:
    """q of the module, from the variances of many zeros, (n,) each."""
    from scipy.stats import chi2  # slow to import

    if not between.size:
        return 1.0
    middle = float(chi2.ppf(0.5, n_draws - 1)) / (n_draws - 1)
    return max(1.0, float(np.median(between / np.maximum(within, 1e-300))) / middle)


def independent_averages(spectra: CrossSpectra) -> float:
    """How many independent averages stand behind the standard deviations that these spectra give."""
    if spectra.draws is None:
        return spectra.n_effective
    return min(freedom(np.unique(spectra.draws).size), max(spectra.n_effective, PRIOR))


def freedom(n_draws: int) -> float:
    """Degrees of freedom of a variance that :func:`combined` gives."""
    return n_draws - 1.0 + PRIOR


def combined(between: FloatArray, within: FloatArray, n_draws: int, q: float) -> FloatArray:
    """Variance of each zero.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.identification.repeat_scatter import combined
    >>> combined(np.array([0.0, 9.0]), np.array([1.0, 1.0]), 9, 1.0).tolist()
    [0.5, 5.0]
    """
    return np.asarray(((n_draws - 1.0) * between + PRIOR * q * within) / freedom(n_draws))
