r"""Severities of one set of damaged elements drawn from their posterior, and its evidence, by sampling.

The density is that of :mod:`~antires_rs.damage.evidence`, p(ln f | u) exp(-sum u), with the model's roots at
every point and values and roots associated anew there. Points are drawn from the Gaussian of the fit, widened
and within its bounds, and weighted; where too few count, Gaussians of what was found so far are added, and
all points are weighted by the mixture of all Gaussians. Where that does not help either, particles go by
steps from the widest Gaussian to the density and walk there.

References: J.-M. Cornuet et al., Scand. J. Stat. 39 (2012) 798-812 (adaptive multiple importance sampling);
J. Ching and Y.-C. Chen, J. Eng. Mech. 133 (2007) 816-832 (the steps).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..support.progress import step
from ..support.validation import FloatArray
from .evidence import FURTHEST, HIGHEST
from .stepwise import stepwise
from .truncated import Truncated, truncated

if TYPE_CHECKING:
    from collections.abc import Callable

    from .evidence import Fit
    from .likelihood import Likelihood

__all__ = ["Sampled", "linear", "sampled"]

#: Standard deviations of the first Gaussians, in those of the fit, and the shares of the points in them.
_FIRST = ((1.25, 0.7), (3.0, 0.3))
#: Widening of Gaussians that were learned, and the least standard deviation of u.
_LEARNED, _LEAST = 1.3, 1e-6
#: Rounds; the share of the points that should count in the end, and that below which particles walk.
_ROUNDS, _WANTED, _POOR = 4, 0.4, 0.1
#: Points that are evaluated at once; Ctrl-C and progress come in between.
_BATCH = 64


@dataclass(frozen=True)
class Sampled:
    """Weighted severities of one set.

    Attributes
    ----------
    beta : (k, n) severities.
    weight : (k,) with the sum one.
    log_evidence : of the set.
    effective : how many independent draws the points are worth.
    stepwise : whether particles had to go by steps.
    """

    beta: FloatArray
    weight: FloatArray
    log_evidence: float
    effective: float
    stepwise: bool

    def resampled(self, count: int, rng: np.random.Generator) -> FloatArray:
        """So many severities (count, n) of equal weight, in random order."""
        places = (np.arange(count) + rng.random()) / count
        chosen = np.searchsorted(np.cumsum(self.weight), places)
        return np.asarray(self.beta[rng.permutation(np.minimum(chosen, self.weight.size - 1))])

    def quantiles(self, nth: int, shares: tuple[float, float]) -> tuple[float, float]:
        """Quantiles of one severity."""
        order = np.argsort(self.beta[:, nth])
        weight = self.weight[order]
        low, high = np.interp(shares, np.cumsum(weight) - 0.5 * weight, self.beta[order, nth])
        return float(low), float(high)


def linear(fit: Fit, count: int, rng: np.random.Generator) -> Sampled:
    """Severities of the Gaussian of ``fit``, without another look at the model."""
    gaussian = truncated(fit.mean, fit.covariance, 0.0, FURTHEST)
    u, log_weight = gaussian.draws(_evenly(count, fit.mean.size, rng))
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    return Sampled(-np.expm1(-u), weight, fit.log_evidence, float(1.0 / np.sum(weight**2)), False)


def sampled(
    likelihood: Likelihood,
    fit: Fit,
    wanted: int,
    rng: np.random.Generator,
    name: str = "",
    by_steps: bool = True,
) -> Sampled:
    """The posterior of the severities of ``fit``, of at least one element; points until ``wanted`` count.

    ``name`` is what progress calls the set; particles walk only if ``by_steps``.
    """
    n = len(fit.elements)

    def log_density(u: FloatArray) -> FloatArray:
        found = []
        for first in range(0, len(u), _BATCH):
            step(f"severities of {name}")
            part = u[first : first + _BATCH]
            betas = np.zeros((len(part), likelihood.n))
            betas[:, list(fit.elements)] = -np.expm1(-part)
            found += [view.log_likelihood for view in likelihood.views(betas)]
        return np.asarray(np.array(found) - u.sum(axis=1) - n * float(np.log(HIGHEST)))

    pool = _Pool(n, log_density, rng)
    sizes = [(truncated(fit.mean, s**2 * fit.covariance, 0.0, FURTHEST), share) for s, share in _FIRST]
    round_size = max(40, wanted // 2)
    for gaussian, share in sizes:
        pool.add(gaussian, int(np.ceil(share * round_size)))
    for _ in range(_ROUNDS):
        if pool.effective >= wanted:
            break
        rate = pool.effective / pool.size
        if rate < _WANTED:
            pool.add(pool.learned(), round_size)
        else:  # good enough: as many more as are missing
            missing = int(np.ceil(1.2 * (wanted - pool.effective) / rate))
            for gaussian, share in sizes if rate > 0.6 else [(pool.learned(), 1.0)]:
                pool.add(gaussian, int(np.ceil(share * missing)))
    if by_steps and pool.effective < _POOR * min(pool.size, 4 * wanted):
        u, log_evidence = stepwise(log_density, sizes[-1][0], 2 * wanted, rng)
        even = np.full(len(u), 1.0 / len(u))
        distinct = len(np.unique(u, axis=0))
        return Sampled(-np.expm1(-u), even, log_evidence, distinct, True)
    weight = pool.weight
    return Sampled(-np.expm1(-pool.u), weight, pool.log_evidence, pool.effective, False)


class _Pool:
    """Points of several Gaussians, each with the log density wanted, weighted by the mixture of all."""

    def __init__(
        self, n: int, log_density: Callable[[FloatArray], FloatArray], rng: np.random.Generator
    ) -> None:
        self.log_density, self.rng = log_density, rng
        self.u, self.target = np.empty((0, n)), np.empty(0)
        self.gaussians: list[tuple[Truncated, int]] = []

    @property
    def size(self) -> int:
        return len(self.u)

    def add(self, gaussian: Truncated, count: int) -> None:
        """Points of one Gaussian; evenly spread, from a random start."""
        u = gaussian.draws(_evenly(count, self.u.shape[1], self.rng))[0]
        self.u = np.vstack([self.u, u])
        self.target = np.concatenate([self.target, self.log_density(u)])
        self.gaussians.append((gaussian, count))
        self._weigh()

    def _weigh(self) -> None:
        from scipy.special import logsumexp

        shares = np.array([count for _, count in self.gaussians]) / self.size
        drawn = np.array([gaussian.log_density(self.u) for gaussian, _ in self.gaussians])
        log_weight = self.target - logsumexp(drawn, axis=0, b=shares[:, None])
        self.log_evidence = float(logsumexp(log_weight) - np.log(self.size))
        self.weight = np.exp(log_weight - logsumexp(log_weight))
        self.effective = float(1.0 / np.sum(self.weight**2))

    def learned(self) -> Truncated:
        """The Gaussian of what was found so far."""
        mean = self.weight @ self.u
        apart = self.u - mean
        covariance = (self.weight[:, None] * apart).T @ apart
        # With few points that count the covariance is too small; with that of the first one it is not.
        trust = min(self.effective / (10.0 * self.u.shape[1]), 1.0)
        first = self.gaussians[0][0]
        rough = np.empty_like(covariance)
        rough[np.ix_(first.order, first.order)] = first.factor @ first.factor.T
        covariance = trust * covariance + (1.0 - trust) * rough
        covariance = _LEARNED**2 * covariance + _LEAST**2 * np.eye(len(covariance))
        return truncated(mean, covariance, 0.0, FURTHEST)


def _evenly(count: int, n: int, rng: np.random.Generator) -> FloatArray:
    """Points that fill the unit cube evenly: multiples of powers of 1 / x, where x**(n + 1) = x + 1."""
    x = 1.0
    for _ in range(60):
        x = (1.0 + x) ** (1.0 / (n + 1))
    steps = x ** -np.arange(1.0, n + 1.0)
    points = (rng.random(n) + np.arange(count)[:, None] * steps) % 1.0
    return np.clip(points, 1e-12, 1.0 - 1e-12)
