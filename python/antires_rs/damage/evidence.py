r"""The evidence of a set of damaged elements, from one view of the values.

.. math:: Z_S = \int_{[0, b]^k} p(\ln f_D \mid \beta_S) \, d\beta_S / b^k
          = \int p(\ln f_D \mid u) \, e^{-\sum u} \, du / b^k, \qquad u = -\ln(1 - \beta)

About a point ln f is linear in u (a frequency that one spring decides goes with its root), so that the
integral over the box is that of a Gaussian with bounds. It is told only where the most probable severities
are near enough to that point.

Reference: R. E. Kass and A. E. Raftery, J. Am. Stat. Assoc. 90 (1995) 773-795.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..support.validation import FloatArray
from .box import peak_in_box, quantiles
from .truncated import log_inside
from .view import View

__all__ = ["FURTHEST", "HIGHEST", "Fit", "fitted"]

#: Largest severity.
HIGHEST = 0.99
#: The same as u.
FURTHEST = -float(np.log1p(-HIGHEST))
#: Change of u up to which the roots count as linear.
_LINEAR = 0.12
#: Precision of u where nothing sees it.
_BLIND = 1e-2


@dataclass(frozen=True)
class Fit:
    """A set of damaged elements: log evidence, most probable severities, the Gaussian of u in bounds."""

    elements: tuple[int, ...]
    log_evidence: float
    beta: FloatArray
    mean: FloatArray
    covariance: FloatArray
    view: View

    def interval(self, nth: int, shares: tuple[float, float]) -> tuple[float, float]:
        """Quantiles of one severity, given the set."""
        std = float(np.sqrt(self.covariance[nth, nth]))
        if self.beta[nth] <= 0.0:  # at the bound: from there on
            shares = (0.0, shares[1] - shares[0])
        low, high = quantiles(float(self.mean[nth]), std, 0.0, FURTHEST, shares)
        return -float(np.expm1(-low)), -float(np.expm1(-high))


def fitted(view: View, elements: tuple[int, ...], reach: float = _LINEAR) -> Fit | None:
    """A set as it is seen from one point; None where its severities are too far from there, in u."""
    at = np.array(elements, dtype=np.intp)
    if not at.size:
        none = np.empty(0)
        return Fit((), view.log_likelihood, none, none, np.empty((0, 0)), view)
    room = 1.0 - view.beta[at]
    start = -np.log(room)
    matrix = view.curvature[np.ix_(at, at)] * np.outer(room, room) + _BLIND * np.eye(at.size)
    covariance = np.asarray(np.linalg.inv(matrix), dtype=np.float64)
    # All severities are equally probable, so that large u are less.
    gain = view.gain[at] * room - 1.0
    step = covariance @ gain
    best = peak_in_box(start + step, covariance, 0.0, FURTHEST)
    if np.any(np.abs(best - start) > reach):
        return None
    inside = log_inside(start + step, covariance, 0.0, FURTHEST)
    size = np.linalg.slogdet(covariance)[1]
    volume = 0.5 * (at.size * np.log(2.0 * np.pi) + size) - at.size * np.log(HIGHEST) - start.sum()
    return Fit(
        elements,
        float(view.log_likelihood + 0.5 * gain @ step + volume + inside),
        -np.expm1(-best),
        start + step,
        covariance,
        view,
    )
