r"""A quick judge of virtual tests: the evidence of every single element, without a search.

What :func:`assess_damage` would find is decided between "nothing" and single elements. The model after the
baseline is evaluated once for each element on a grid of severities; there mean, covariance and slopes of all
values are known as :mod:`antires_rs.damage.likelihood` has them. Any number of tests is then judged by linear
algebra: at the points of the grid next to the best one, the evidence of the severity's Gaussian within its
bounds (:mod:`antires_rs.damage.evidence`). A value that one of the two states lacks costs what a root missed
costs there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..damage.association import FALSE, FOUND
from ..damage.box import log_between
from ..damage.calibration import log_odds_threshold
from ..damage.evidence import HIGHEST
from ..damage.inference import STD_COMMON
from ..damage.likelihood import Likelihood
from ..damage.limits import intact_slopes
from ..damage.measured_states import Values
from ..damage.model_error import ModelError, learned
from ..damage.prior import DamagePrior
from ..damage.roots import Roots, roots_at
from ..damage.view import ERRORS
from ..support.validation import FloatArray
from .virtual_test import VirtualTest, along

__all__ = ["GRID", "Judge"]

#: Severities of the grid: ln(1 - beta) in steps of a tenth.
GRID = -np.expm1(-np.array([0.0, 0.005, 0.015, 0.03, 0.05, *np.arange(0.1, 3.6, 0.1)]))
#: Points of the grid that each element is judged at, and how far from one its linear model reaches.
_POINTS, _LINEAR = 3, 0.12
#: Points of each element that are judged under their own covariance to find these.
_POOL = 6
#: Log likelihood by which a point may lie below the best before any error is drawn: so much below this
#: multiple of the best.
_HOPELESS = (50.0, 3.0)
_BLIND = 1e-6
#: What a value costs that has no root in reach, and a root that has no value; from how many standard
#: deviations on it is so.
_ALONE, _MISSED, _OUTSIDE = -float(np.log(FALSE)), -float(np.log1p(-FOUND)), 5.0
_COMMON = 0.5
_FAR = 1e3


@dataclass
class Judge:
    """After one baseline: what is known of the structure, and the grid of hypotheses.

    Rows of the arrays are hypotheses, "nothing" first, then the grid of each element.
    """

    test: VirtualTest
    prior: DamagePrior
    baseline: Values
    threads: int
    false_alarm_rate: float | None
    rng: np.random.Generator

    def __post_init__(self) -> None:
        core, n_factors = self.test.core
        n = len(self.test.numbers)
        error = learned(core, n, n_factors, self.baseline, None, self.threads)
        self.n = n
        rows = np.zeros((1 + n * GRID.size, n + n_factors))
        rows[:, n:] = np.exp(error.theta)
        self.element = np.repeat(np.arange(n), GRID.size)
        self.beta = np.concatenate([[0.0], np.tile(GRID, n)])
        rows[np.arange(1, rows.shape[0]), self.element] = self.beta[1:]
        found = roots_at(core, rows, slopes=True, threads=self.threads)
        self._tabulate(error, found)
        self.threshold = None
        if self.false_alarm_rate is not None:
            likelihood = Likelihood(core, n, error, self.baseline, self.baseline, STD_COMMON, self.threads)
            slopes = intact_slopes(likelihood, len(self.test.elements))
            self.threshold = log_odds_threshold(slopes, self.prior, self.false_alarm_rate, self.rng)

    def _tabulate(self, error: ModelError, found: list[Roots]) -> None:
        """Place, covariance and slope of every value under every hypothesis."""
        m, count = self.baseline.size, len(found)
        kappa = error.outside * sum(multiple * p for multiple, _, p in ERRORS)
        self.place, self.present = np.zeros((count, m)), np.zeros((count, m), dtype=bool)
        self.white, self.raw, self.scale = np.zeros((count, m, m)), np.zeros((count, m)), np.ones((count, m))
        self.log_det = np.zeros(count)
        factors = np.exp(error.theta)
        own = [0, *self.element.tolist()]
        identities = [np.arange(error.intact.size)]
        for states in np.split(np.arange(1, count), self.n):
            identities += along(error.intact, [found[h] for h in states])
        for h, (roots, identity) in enumerate(zip(found, identities, strict=True)):
            at = _places(identity, error.intact.size)[error.partner]
            has = np.flatnonzero((at >= 0) & (error.partner >= 0))
            root = at[has]
            by_theta = roots.slopes[root, self.n :] * factors
            mean, spread = error.predicted(by_theta, identity[root])
            change = roots.log_f[root] - error.intact.log_f[identity[root]]
            size = change**2 + _COMMON * np.mean(change**2) if root.size else change
            spread[np.diag_indices(root.size)] += self.baseline.std[has] ** 2 + kappa**2 * size
            spread += STD_COMMON**2
            triangle = np.linalg.cholesky(spread)
            self.white[h][np.ix_(has, has)] = np.linalg.inv(triangle)
            self.log_det[h] = float(np.log(np.diag(triangle)).sum())
            self.place[h, has], self.present[h, has] = roots.log_f[root] + mean, True
            self.raw[h, has] = roots.slopes[root, own[h]]
            self.scale[h, has] = np.sqrt(np.diag(spread))

    def found(self, log_f: FloatArray, there: NDArray[np.bool_], draws: int) -> tuple[FloatArray, float]:
        """Share of tests in which each candidate is declared damaged, and in which any is.

        ``log_f`` (m,) are the true values of the damaged state, where ``there``.
        """
        values = log_f[:, None] + self.baseline.std[:, None] * self.rng.standard_normal((log_f.size, draws))
        paired = self._paired(log_f, there)
        self.missed = _ALONE * (there & ~paired).sum(axis=1) + _MISSED * (self.present & ~paired).sum(axis=1)
        at = self._near(log_f, paired)
        evidence = np.full((self.n, _POINTS, draws), -np.inf)
        evidence[at >= 0] = self._evidence(at[at >= 0], values, paired)
        evidence = evidence.max(axis=1)
        nothing = self._plain(np.array([0]), values, paired)[1][0]
        count = len(self.test.elements)
        evidence[:count] += self.prior.log_of(1, count)
        evidence[count:] += self.prior.log_elsewhere(max(self.n - count, 1))
        nothing = nothing + self.prior.log_of(0, count)
        best = np.argmax(evidence, axis=0)
        declared = (evidence.max(axis=0) > nothing) & (best < count)
        if self.threshold is not None:
            best = np.argmax(evidence[:count], axis=0)
            declared = np.logaddexp.reduce(evidence[:count], axis=0) - nothing > self.threshold
        share = np.bincount(best[declared], minlength=self.n)[:count] / draws
        return share, float(declared.mean())

    def _paired(self, log_f: FloatArray, there: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which values each hypothesis explains, (hypotheses, m), at the severity that most of them ask for.

        The others count as missed, as values far from every root do in an assessment.
        """
        both = self.present & there
        residual = np.where(both, log_f - self.place, 0.0)
        weight = np.where(both, np.abs(self.raw) / self.scale, 0.0)
        asked = np.divide(residual, self.raw, out=np.zeros_like(residual), where=weight > 0.0)
        order = np.argsort(asked, axis=1)
        reached = np.cumsum(np.take_along_axis(weight, order, axis=1), axis=1)
        middle = np.take_along_axis(
            order, np.argmax(reached >= 0.5 * reached[:, -1:], axis=1)[:, None], axis=1
        )
        step = np.take_along_axis(asked, middle, axis=1)
        step = np.clip(step, -_LINEAR * (1.0 - self.beta[:, None]), _LINEAR * (1.0 - self.beta[:, None]))
        along = self.raw * step
        return np.asarray(both & (np.abs(residual - along) < _OUTSIDE * self.scale + _LINEAR * np.abs(along)))

    def _near(self, log_f: FloatArray, paired: NDArray[np.bool_]) -> NDArray[np.intp]:
        """The points of each element's grid that explain the true values best, (n, points); -1 for hopeless.

        First under the covariance of the intact state for all; it is never larger, and where values are
        known very well it condemns points a little beside the severity for what the linear model leaves. So
        the best by it and those that explain most values are judged again, each under its own.
        """
        residual = np.where(paired, log_f - self.place, 0.0)
        raw = np.where(paired, self.raw, 0.0)
        white = self.white[0].T
        intact = self._worth(residual @ white, raw @ white) - self.missed
        shape = (self.n, GRID.size)
        by_worth = np.argsort(-intact[1:].reshape(shape), axis=1)[:, :_POOL]
        by_count = np.lexsort((-intact[1:].reshape(shape), self.missed[1:].reshape(shape)))[:, :_POOL]
        at = 1 + np.hstack([by_worth, by_count]) + GRID.size * np.arange(self.n)[:, None]
        every = np.unique(at)
        left, slope = ((self.white[every] @ rows[every][:, :, None])[:, :, 0] for rows in (residual, raw))
        worth = np.full(intact.size, -np.inf)
        worth[every] = self._worth(left, slope, every) - self.missed[every] - self.log_det[every]
        order = np.argsort(-worth[1:].reshape(shape), axis=1)[:, :_POINTS]
        at = 1 + order + GRID.size * np.arange(self.n)[:, None]
        return np.where(worth[at] > _HOPELESS[1] * min(worth.max(), 0.0) - _HOPELESS[0], at, -1)

    def _worth(self, left: FloatArray, slope: FloatArray, at: Any = slice(None)) -> FloatArray:
        """Log likelihood at the best severity of each point; where that is too far, very little."""
        gain, curvature = (left * slope).sum(axis=1), (slope**2).sum(axis=1) + _BLIND
        step = np.clip(self.beta[at] + gain / curvature, 0.0, HIGHEST) - self.beta[at]
        worth = -0.5 * (left**2).sum(axis=1) + gain * step - 0.5 * curvature * step**2
        return np.asarray(worth - _FAR * self._too_far(self.beta[at] + step, self.beta[at]))

    def _plain(
        self, at: NDArray[np.intp], values: FloatArray, paired: NDArray[np.bool_]
    ) -> tuple[FloatArray, FloatArray]:
        """Whitened residuals at these points (points, m, draws), and log likelihood there (points, draws)."""
        residual = np.where(paired[at][:, :, None], values - self.place[at][:, :, None], 0.0)
        left = self.white[at] @ residual
        likelihood = -0.5 * (left**2).sum(axis=1) - (self.log_det[at] + self.missed[at])[:, None]
        return left, likelihood

    def _evidence(self, at: NDArray[np.intp], values: FloatArray, paired: NDArray[np.bool_]) -> FloatArray:
        """Log evidence at these points, (points, draws); where the best severity is too far, very little."""
        left, likelihood = self._plain(at, values, paired)
        slope = (self.white[at] @ np.where(paired[at], self.raw[at], 0.0)[:, :, None])[:, :, 0]
        gain = (slope[:, None, :] @ left)[:, 0, :]
        curvature, beta = (slope**2).sum(axis=1)[:, None] + _BLIND, self.beta[at][:, None]
        mean, sd = beta + gain / curvature, 1.0 / np.sqrt(curvature)
        inside = log_between(-mean / sd, (HIGHEST - mean) / sd)
        volume = np.log(np.sqrt(2.0 * np.pi) * sd / HIGHEST)
        far = self._too_far(np.clip(mean, 0.0, HIGHEST), beta)
        return np.asarray(likelihood + 0.5 * gain**2 / curvature + volume + inside - _FAR * far)

    @staticmethod
    def _too_far(best: FloatArray, beta: FloatArray) -> FloatArray:
        """By how much a severity lies beyond the reach of the linear model about another one."""
        return np.asarray(np.maximum(np.abs(np.log1p(-best) - np.log1p(-beta)) - _LINEAR, 0.0))


def _places(identity: NDArray[np.intp], n_intact: int) -> NDArray[np.intp]:
    """Root of each intact one, -1 where it is gone; the last row stands for none."""
    at = np.full(n_intact + 1, -1)
    old = np.flatnonzero(identity >= 0)
    at[identity[old]] = old
    return at
