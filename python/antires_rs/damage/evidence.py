r"""The evidence of a set of damaged elements, from one view of the values.

.. math:: Z_S = \int_{[0, b]^k} p(\ln f_D \mid \beta_S) \, d\beta_S / b^k

About a point the mean of the values is linear in beta, so that the integral over the box is that of a
Gaussian with bounds. It is told only where the most probable severities are near enough to that point.

Reference: R. E. Kass and A. E. Raftery, J. Am. Stat. Assoc. 90 (1995) 773-795.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..support.validation import FloatArray
from .box import in_box
from .view import View

__all__ = ["HIGHEST", "Fit", "fitted"]

#: Largest severity.
HIGHEST = 0.99
#: Change of ln(1 - beta) up to which the roots count as linear.
_LINEAR = 0.12
#: Precision of a severity that nothing sees.
_BLIND = 1e-6


@dataclass(frozen=True)
class Fit:
    """A set of damaged elements: log evidence, most probable severities, the Gaussian within bounds."""

    elements: tuple[int, ...]
    log_evidence: float
    beta: FloatArray
    mean: FloatArray
    covariance: FloatArray
    view: View


def fitted(view: View, elements: tuple[int, ...]) -> Fit | None:
    """A set as it is seen from one point; None where its severities are too far from there."""
    at = np.array(elements, dtype=np.intp)
    if not at.size:
        none = np.empty(0)
        return Fit((), view.log_likelihood, none, none, np.empty((0, 0)), view)
    matrix = view.curvature[np.ix_(at, at)] + _BLIND * np.eye(at.size)
    covariance = np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    gain = view.gain[at]
    step = covariance @ gain
    mean = view.beta[at] + step
    beta, log_inside = in_box(mean, covariance, 0.0, HIGHEST)
    if np.any(np.abs(np.log1p(-beta) - np.log1p(-view.beta[at])) > _LINEAR):
        return None
    volume = 0.5 * (at.size * np.log(2.0 * np.pi) + np.linalg.slogdet(covariance)[1]) - at.size * np.log(
        HIGHEST
    )
    return Fit(
        elements,
        float(view.log_likelihood + 0.5 * gain @ step + volume + log_inside),
        beta,
        mean,
        covariance,
        view,
    )
