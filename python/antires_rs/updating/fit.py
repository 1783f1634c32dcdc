"""The weighted least-squares solution near the parameters found: where the posterior is expanded.

The search minimizes what the problem says, by default the paper's sum of abs(e); the posterior lies around
the minimum of the sum of squares over the errors' variances. Both are near each other where the model fits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..support.progress import step
from ..support.validation import FloatArray
from .box_residuals import BoxResiduals
from .error_model import FLOOR, ErrorModel

if TYPE_CHECKING:
    from .problem import UpdatingProblem

__all__ = ["FAR", "SAME", "UNSEEN", "Fit", "fitted", "least_squares"]

#: A combination whose residuals move less than this over the bounds' distance is not seen; see
#: ``identifiability``.
UNSEEN = 1e-5
#: Rounds of weights from residuals and residuals from weights, and steps of each.
_ROUNDS, _STEPS = 3, 20
#: A solution is another than the one found if a value differs by more standard deviations than this, and by
#: more than this share of omega squared.
FAR, SAME = 4.0, 2e-3
#: Share of the steepest column that a step costs: what no value sees stays where it is.
_DAMPED = 1e-6


@dataclass(frozen=True, eq=False)
class Fit:
    """Solution u (n,), residuals e (m,) and Jacobian (m, n) there, and the errors that they suggest.

    ``tau`` is the median error of the model, ``chances`` (G,) the probabilities of all on the grid.
    """

    residuals: BoxResiduals
    u: FloatArray
    e: FloatArray
    jacobian: FloatArray
    rank: int
    errors: ErrorModel
    chances: FloatArray

    @property
    def tau(self) -> float:
        """Median error of the model, of omega squared."""
        return float(self.errors.tau[self.middle])

    @property
    def middle(self) -> int:
        """Number of the median error of the model."""
        return int(np.clip(np.searchsorted(np.cumsum(self.chances), 0.5), 0, self.chances.size - 1))

    @property
    def sigma(self) -> FloatArray:
        """Standard deviations of the residuals at the median error of the model, (m,)."""
        return np.asarray(np.sqrt(self.errors.variance[self.middle]))

    @property
    def chi_square(self) -> float:
        """Reduced chi-square by the stated errors; NaN where none are stated or nothing is left over."""
        stated, spare = self.residuals.stated, self.e.size - self.rank
        if stated is None or spare <= 0:
            return float("nan")
        return float(np.sum((self.e / np.maximum(stated, FLOOR)) ** 2) / spare)


def fitted(problem: UpdatingProblem, x: FloatArray) -> Fit:
    """Least squares within the bounds from ``x``, with the errors that its residuals suggest."""
    residuals = BoxResiduals(problem, x)
    u = residuals.place(x)
    stated, size = residuals.stated, residuals.size
    sigma = size * max(_rms(residuals.at(u) / size), FLOOR) if stated is None else np.maximum(stated, FLOOR)
    for _ in range(_ROUNDS):
        step("least squares")
        u = _best(residuals, u, sigma)
        e, jacobian = residuals.at(u), residuals.jacobian(u)
        rank = int(np.count_nonzero(np.linalg.svd(jacobian, compute_uv=False) > UNSEEN)) if u.size else 0
        size = residuals.size * _kinds(residuals, e / residuals.size)
        guess = _rms(e / size) * np.sqrt(e.size / max(e.size - rank, 1))
        errors = ErrorModel.around(stated, size, float(guess), e.size - rank)
        fit = Fit(residuals, u, e, jacobian, rank, errors, errors.marginal(e, jacobian))
        ratio = fit.sigma / sigma
        if ratio.max() < 1.05 * ratio.min():
            break  # a common factor moves no minimum
        sigma = fit.sigma
    return fit


def least_squares(
    residuals: BoxResiduals, start: FloatArray, sigma: FloatArray, held: Sequence[int] = ()
) -> FloatArray:
    """Least squares of the residuals over ``sigma`` within the unit box, by Gauss-Newton; ``held`` stay.

    Each step solves the linear problem within the box and is halved until the sum falls.
    """
    from scipy.optimize import lsq_linear

    u = start.copy()
    free = np.setdiff1d(np.arange(u.size), np.array(held, dtype=int))
    if free.size == 0:
        return u
    z = residuals.at(u) / sigma
    for _ in range(_STEPS):
        slope = residuals.jacobian(u)[:, free] / sigma[:, None]
        damped = _DAMPED * max(np.linalg.norm(slope, axis=0).max(), 1.0)
        rows = np.vstack([slope, damped * np.eye(free.size)])
        ends = (np.minimum(-u[free], -1e-12), np.maximum(1.0 - u[free], 1e-12))
        move = lsq_linear(rows, np.append(-z, np.zeros(free.size)), ends, method="bvls").x
        cost, share = float(z @ z), 1.0
        while True:
            tried = u.copy()
            tried[free] = np.clip(u[free] + share * move, 0.0, 1.0)
            now = residuals.at(tried) / sigma
            if now @ now < cost:
                break
            share /= 2.0
            if share < 1e-3:
                return u
        u, z = tried, now
        if cost - z @ z < 1e-6 * cost + 1e-6:
            break  # less than any probability would show
    return u


def _best(residuals: BoxResiduals, start: FloatArray, sigma: FloatArray) -> FloatArray:
    """Least squares from the start; if that leads far, the best of it and of those from two more starts."""
    found = [least_squares(residuals, start, sigma)]
    if np.any(np.abs(residuals.at(found[0]) - residuals.at(start)) > np.maximum(FAR * sigma, SAME)):
        others = residuals.place(residuals.problem.nominal), np.full(start.size, 0.5)
        found += [least_squares(residuals, u, sigma) for u in others]
    return min(found, key=lambda u: float(np.sum((residuals.at(u) / sigma) ** 2)))


def _kinds(residuals: BoxResiduals, e: FloatArray) -> FloatArray:
    """Error of each kind of value relative to that of the frequencies, (m,): they have units of their own."""
    if residuals.stated is not None or not residuals.kind.any():
        return np.ones(e.size)
    shape = residuals.kind == 1
    ratio = max(_rms(e[shape]), FLOOR) / max(_rms(e[~shape]), FLOOR)
    return np.where(shape, ratio, 1.0)


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2))) if values.size else 0.0
