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
from .box import given, peak_in_box, quantiles
from .truncated import log_inside
from .view import View

__all__ = ["FURTHEST", "HIGHEST", "Fit", "fitted"]

#: Largest severity.
HIGHEST = 0.99
#: The same as u.
FURTHEST = -float(np.log1p(-HIGHEST))
#: Change of u up to which the roots count as linear.
_LINEAR = 0.12
#: So near to the largest u counts as there.
_ON_BOUND = 1e-9
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
        """Quantiles of one severity, given the set, as :meth:`sides` has them."""
        low, high = self._quantiles(nth, self.sides(nth, shares))
        return -float(np.expm1(-low)), -float(np.expm1(-high))

    def sides(self, nth: int, shares: tuple[float, float]) -> tuple[float, float]:
        """Shares with the most probable severity between their quantiles: those given, else as much of the
        probability from the nearer bound on."""
        low, high = self._quantiles(nth, shares)
        best, whole = self._peak[nth], shares[1] - shares[0]
        if best <= 0.0 or best < low:
            return 0.0, whole
        return (1.0 - whole, 1.0) if best > high else shares

    @property
    def _peak(self) -> FloatArray:
        return np.asarray(-np.log1p(-self.beta))

    def _quantiles(self, nth: int, shares: tuple[float, float]) -> tuple[float, float]:
        """Of u; partners whose most probable severity is a bound stay on it."""
        on_bound = (self._peak <= 0.0) | (self._peak >= FURTHEST - _ON_BOUND)
        mean, std = given(self.mean, self.covariance, nth, self._peak, on_bound)
        return quantiles(mean, std, 0.0, FURTHEST, shares)


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
