r"""Gaussians of which only a box is left: their probability, densities, and draws.

One coordinate after the other, each given those before (Genz's transformation): within its limits the
conditional distribution is a normal one, of which uniform numbers give draws; the product of the conditional
probabilities, averaged over them, is the probability of the box. Coordinates with the least room come first.

Reference: A. Genz, J. Comput. Graph. Stat. 1 (1992) 141-149.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .box import log_between

__all__ = ["Truncated", "log_inside", "truncated"]

#: Points of the rule of quadrature along each coordinate but the last.
_POINTS = 16
#: Coordinates so many standard deviations from both bounds do not count.
_FAR = 5.0
_HALF_LOG_TAU = 0.5 * float(np.log(2.0 * np.pi))


@dataclass(frozen=True)
class Truncated:
    """A Gaussian within [low, high]^n: mean, Cholesky factor, both in the order of ``order``."""

    mean: FloatArray
    factor: FloatArray
    order: NDArray[np.intp]
    low: float
    high: float

    def draws(self, uniform: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points (k, n) of uniform numbers (k, n), and ln of the weights that make them the Gaussian's."""
        z, log_weight = self._transformed(uniform)
        found = np.empty_like(z)
        found[:, self.order] = np.clip(self.mean + z @ self.factor.T, self.low, self.high)
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

    def log_probability(self) -> float:
        """ln of the probability of the box under the whole Gaussian."""
        from scipy.special import logsumexp

        points, weights = _rule(self.mean.size - 1)
        return float(logsumexp(self._transformed(points)[1], b=weights))

    def _limits(self, z: FloatArray, i: int) -> tuple[FloatArray, FloatArray]:
        """Limits of coordinate i in standard deviations, given those before."""
        middle = self.mean[i] + z[:, :i] @ self.factor[i, :i]
        return (self.low - middle) / self.factor[i, i], (self.high - middle) / self.factor[i, i]

    def _transformed(self, uniform: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Standard normal coordinates of as many uniform numbers as there are, and ln of the product."""
        z = np.zeros((len(uniform), self.mean.size))
        total = np.zeros(len(uniform))
        for i in range(self.mean.size):
            below, above = self._limits(z, i)
            total += log_between(below, above)
            if i < uniform.shape[1]:
                z[:, i] = _between(below, above, uniform[:, i])
        return z, total


def truncated(mean: FloatArray, covariance: FloatArray, low: float, high: float) -> Truncated:
    """A Gaussian within [low, high]^n."""
    sd = np.sqrt(np.diag(covariance))
    order = np.argsort(log_between((low - mean) / sd, (high - mean) / sd), kind="stable")
    factor = np.asarray(np.linalg.cholesky(covariance[np.ix_(order, order)]), dtype=np.float64)
    return Truncated(mean[order], factor, order, low, high)


def log_inside(mean: FloatArray, covariance: FloatArray, low: float, high: float) -> float:
    """ln of the probability that a Gaussian gives to [low, high]^n, by a fixed rule."""
    sd = np.sqrt(np.diag(covariance))
    near = np.flatnonzero(np.minimum(mean - low, high - mean) < _FAR * sd)
    if near.size < 2:
        return float(np.sum(log_between((low - mean[near]) / sd[near], (high - mean[near]) / sd[near])))
    return truncated(mean[near], covariance[np.ix_(near, near)], low, high).log_probability()


def _between(low: FloatArray, high: FloatArray, p: FloatArray) -> FloatArray:
    """Quantiles p of the standard normal distribution between two limits."""
    from scipy.special import log_ndtr, ndtri_exp

    flip = low > 0.0  # the tail is resolved on the negative side
    a, b = np.where(flip, -high, low), np.where(flip, -low, high)
    share = np.where(flip, 1.0 - p, p)
    bottom, top = log_ndtr(a), log_ndtr(b)
    # ln of (1 - share) e^bottom + share e^top
    z = ndtri_exp(top + np.log(share + (1.0 - share) * np.exp(np.minimum(bottom - top, 0.0))))
    z = np.clip(z, a, b)
    return np.asarray(np.where(flip, -z, z))


@cache
def _rule(n: int) -> tuple[FloatArray, FloatArray]:
    """Points (k, n) and weights (k,) of Gauss and Legendre's rule in the unit cube."""
    x, w = np.polynomial.legendre.leggauss(_POINTS)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    axes = np.meshgrid(*[x] * n, indexing="ij")
    weights = np.ones(_POINTS**n)
    for each in np.meshgrid(*[w] * n, indexing="ij"):
        weights = weights * each.ravel()
    return np.stack([a.ravel() for a in axes], axis=1) if n else np.empty((1, 0)), weights
