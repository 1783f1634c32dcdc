"""The evidence of a set of damaged elements, from one view of the values.

In u = -ln(1 - beta) the density is p(ln f | u) exp(-sum u). About a point ln f is linear in u, so that the
integral over the box is that of a Gaussian with bounds; it is formed only where the most probable severities
are near enough to that point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ..support.checks import FloatArray
from ..updating.posterior import between, log_between
from .likelihood import View

#: Largest severity, and the same as u: Gaussians of u are those of what lies in the box [0, FURTHEST]^n.
HIGHEST = 0.99
FURTHEST = -float(np.log1p(-HIGHEST))

# -- Gaussians within bounds: where in the box the peak is


def peak_in_box(mean: FloatArray, covariance: FloatArray) -> FloatArray:
    """Most probable points (k, n) of Gaussians in the box."""
    best, spread, free = mean.copy(), covariance.copy(), np.ones(mean.shape, dtype=bool)
    for _ in range(mean.shape[1]):
        sd = np.sqrt(np.diagonal(spread, axis1=1, axis2=2))
        below, above = -best / sd, (best - FURTHEST) / sd
        outside = np.where(free, np.maximum(below, above), -np.inf)
        worst = np.argmax(outside, axis=1)
        row = np.flatnonzero(outside[np.arange(worst.size), worst] > 0.0)
        if not row.size:
            break
        at = worst[row]
        gain = spread[row, :, at] / spread[row, at, at][:, None]
        bound = np.where(below[row, at] > above[row, at], 0.0, FURTHEST)
        best[row] += gain * (bound - best[row, at])[:, None]
        spread[row] -= gain[:, :, None] * spread[row, at][:, None, :]
        free[row, at], spread[row, at, at] = False, 1.0
    return best


# -- Gaussians of which only a box is left: their probability, densities, and draws
#
# One coordinate after the other, those with the least room first, each given those before: within its limits
# it is a normal one; the product of the conditional probabilities, averaged over draws, is the probability of
# the box (A. Genz, J. Comput. Graph. Stat. 1 (1992) 141-149).

_POINTS = 16  # points of the rule of quadrature along each coordinate but the last
_FAR = 5.0  # coordinates so many standard deviations from both bounds do not count
_HALF_LOG_TAU = 0.5 * float(np.log(2.0 * np.pi))


@dataclass(frozen=True)
class Truncated:
    """Gaussians within the box: mean (..., n), Cholesky factor, both in the order of ``order``."""

    mean: FloatArray
    factor: FloatArray
    order: NDArray[np.intp]

    def draws(self, uniform: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points (k, n) of uniform numbers (k, n), and ln of the weights that make them one Gaussian's."""
        z, log_weight = self.transformed(uniform)
        found = np.empty_like(z)
        found[:, self.order] = np.clip(self.mean + z @ self.factor.T, 0.0, FURTHEST)
        return found, log_weight

    def log_density(self, points: FloatArray) -> FloatArray:
        """Of the points of :meth:`draws` without their weights, anywhere in the box; (k,)."""
        apart = points[:, self.order] - self.mean
        z = np.asarray(np.linalg.solve(self.factor, apart.T).T, dtype=np.float64)
        total = np.zeros(len(points))
        for i in range(self.mean.size):
            below, above = self._limits(z, i)
            total -= 0.5 * z[:, i] ** 2 + _HALF_LOG_TAU + np.log(self.factor[i, i])
            total -= log_between(below, above)
        return total

    def _limits(self, z: FloatArray, i: int) -> tuple[FloatArray, FloatArray]:
        """Limits of coordinate i in standard deviations, given those before."""
        before = (z[..., :i] @ self.factor[..., i, :i, None])[..., 0]
        middle, scale = self.mean[..., i, None] + before, self.factor[..., i, i, None]
        return -middle / scale, (FURTHEST - middle) / scale

    def transformed(self, uniform: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Standard normal coordinates of as many uniform numbers as there are, and ln of the product."""
        z = np.zeros((*self.mean.shape[:-1], len(uniform), self.mean.shape[-1]))
        total = np.zeros(z.shape[:-1])
        for i in range(self.mean.shape[-1]):
            below, above = self._limits(z, i)
            total += log_between(below, above)
            if i < uniform.shape[1]:
                z[..., i] = between(below, above, uniform[:, i])
        return z, total


def truncated(mean: FloatArray, covariance: FloatArray) -> Truncated:
    """Gaussians of mean (..., n) within the box."""
    sd = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    order = np.argsort(log_between(-mean / sd, (FURTHEST - mean) / sd), axis=-1, kind="stable")
    rows = np.take_along_axis(covariance, order[..., :, None], axis=-2)
    factor = np.linalg.cholesky(np.take_along_axis(rows, order[..., None, :], axis=-1))
    return Truncated(np.take_along_axis(mean, order, axis=-1), np.asarray(factor), order)


def log_inside(mean: FloatArray, covariance: FloatArray) -> FloatArray:
    """ln of the probability that each Gaussian of mean (k, n) gives to the box, by a fixed rule."""
    from scipy.special import logsumexp

    sd = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    near = np.minimum(mean, FURTHEST - mean) < _FAR * sd
    alone = log_between(-mean / sd, (FURTHEST - mean) / sd)
    found: FloatArray = np.where(near, alone, 0.0).sum(axis=1)
    count = near.sum(axis=1)
    for size in range(2, mean.shape[1] + 1):
        row = np.flatnonzero(count == size)
        if row.size:
            at = np.nonzero(near[row])[1].reshape(-1, size)
            own = covariance[row[:, None, None], at[:, :, None], at[:, None, :]]
            points, weights = _rule(size - 1)
            found[row] = logsumexp(
                truncated(mean[row[:, None], at], own).transformed(points)[1], b=weights, axis=-1
            )
    return found


@cache
def _rule(n: int) -> tuple[FloatArray, FloatArray]:
    """Points (k, n) and weights (k,) of Gauss and Legendre's rule in the unit cube."""
    x, w = np.polynomial.legendre.leggauss(_POINTS)
    points, weights = (np.array(list(product(each, repeat=n))) for each in (0.5 * (x + 1.0), 0.5 * w))
    return points, weights.prod(axis=1)


LINEAR = 0.12  # change of u up to which the roots count as linear
_ON_BOUND = 1e-9  # so near to the largest u counts as there
BLIND = 1e-2  # precision of u where nothing sees it


@dataclass(frozen=True)
class Fit:
    """A set of damaged elements: log evidence, most probable severities, the Gaussian of u in bounds; its
    covariance has what the model's own error makes of a loss."""

    elements: tuple[int, ...]
    log_evidence: float
    beta: FloatArray
    mean: FloatArray
    covariance: FloatArray
    view: View

    def interval(self, nth: int, shares: tuple[float, float]) -> tuple[float, float]:
        """Quantiles of one severity, given the set, as :meth:`sides` has them."""
        _, (low, high) = self._between(nth, shares)
        return -float(np.expm1(-low)), -float(np.expm1(-high))

    def sides(self, nth: int, shares: tuple[float, float]) -> tuple[float, float]:
        """Shares between whose quantiles the likeliest severity is, else as much from the nearer bound on."""
        return self._between(nth, shares)[0]

    def _between(
        self, nth: int, shares: tuple[float, float]
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        """These shares and their quantiles of u."""
        low, high = self._quantiles(nth, shares)
        best, whole = self.u[nth], shares[1] - shares[0]
        if best <= 0.0 or best < low:
            shares = 0.0, whole
        elif best > high:
            shares = 1.0 - whole, 1.0
        else:
            return shares, (low, high)
        return shares, self._quantiles(nth, shares)

    @property
    def u(self) -> FloatArray:
        """Most probable u."""
        return np.asarray(-np.log1p(-self.beta))

    def _quantiles(self, nth: int, shares: tuple[float, float]) -> tuple[float, float]:
        """Of u; partners whose most probable severity is a bound stay on it."""
        on_bound = (self.u <= 0.0) | (self.u >= FURTHEST - _ON_BOUND)
        at = np.array([k for k in np.flatnonzero(on_bound) if k != nth], dtype=np.intp)
        mean, variance = self.mean[nth], self.covariance[nth, nth]
        if at.size:
            gain = np.linalg.solve(self.covariance[np.ix_(at, at)], self.covariance[at, nth])
            mean, variance = (
                mean + gain @ (self.u[at] - self.mean[at]),
                variance - gain @ self.covariance[at, nth],
            )
        std = np.sqrt(variance)
        z = between(np.full(2, -mean / std), (FURTHEST - mean) / std, np.array(shares))
        low, high = np.clip(mean + std * z, 0.0, FURTHEST).tolist()
        return low, high


def fitted(
    view: View, sets: Sequence[tuple[int, ...]], reach: float = LINEAR, *, at_peak: bool = False
) -> list[Fit]:
    """Sets of one size as seen from one point; not those whose severities are too far from there, in u."""
    at = np.array(sets, dtype=np.intp).reshape(len(sets), -1)
    size = at.shape[1]
    room = 1.0 - view.beta[at]
    start = -np.log(room)
    matrix = view.curvature[at[:, :, None], at[:, None, :]] * room[:, :, None] * room[:, None, :]
    covariance: FloatArray = np.asarray(np.linalg.inv(matrix + BLIND * np.eye(size)), dtype=np.float64)
    # All severities are equally probable, so that large u are less.
    gain = np.zeros(at.shape) if at_peak else view.gain[at] * room - 1.0
    step = (covariance @ gain[:, :, None])[:, :, 0]
    mean = start + step
    best = peak_in_box(mean, covariance)
    near = np.flatnonzero(np.all(np.abs(best - start) <= reach, axis=1))
    inside = log_inside(mean[near], covariance[near])
    spread = np.linalg.slogdet(covariance[near])[1] - 2.0 * start[near].sum(axis=1)
    volume = 0.5 * (size * np.log(2.0 * np.pi) + spread) - size * np.log(HIGHEST)
    evidence = view.log_likelihood + 0.5 * np.sum(gain * step, axis=1)[near] + volume + inside
    return [
        Fit(tuple(sets[nth]), log_evidence, -np.expm1(-best[nth]), mean[nth], wide, view)
        for nth, log_evidence, wide in zip(
            near.tolist(), evidence.tolist(), _widened(covariance[near], best[near], view), strict=True
        )
    ]


def _widened(covariance: FloatArray, u: FloatArray, view: View) -> FloatArray:
    """Covariances (k, n, n) of u with the error that a wrong model makes of a loss."""
    wide = covariance.copy()
    at = np.arange(u.shape[1])
    wide[:, at, at] += (view.gain_std * u) ** 2
    return wide


def refitted(view: View, elements: tuple[int, ...], *, at_peak: bool = False) -> Fit:
    """One set, however far its severities are; ``at_peak``: where it is seen from, whatever slopes say."""
    (fit,) = fitted(view, [elements], np.inf, at_peak=at_peak)
    return fit
