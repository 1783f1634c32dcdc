"""Draws of a density that no Gaussian is near, and its evidence: particles that go by steps and walk.

Transitional Markov chain Monte Carlo. Reference: J. Ching and Y.-C. Chen, J. Eng. Mech. 133 (2007) 816-832.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..support.progress import step
from ..support.validation import FloatArray
from .truncated import Truncated

__all__ = ["stepwise"]

#: Share of the particles that must count after a step, and walks of each particle in a step and in the last.
_COUNTING, _WALKS, _LAST = 0.5, 3, 10
#: Share of walks that should be accepted, and the least step.
_ACCEPTED, _SHORTEST = 0.3, 1e-5


def stepwise(
    log_density: Callable[[FloatArray], FloatArray], start: Truncated, count: int, rng: np.random.Generator
) -> tuple[FloatArray, float]:
    """Draws (count, n) of a density within the bounds of ``start``, and the log of its integral."""
    from scipy.special import logsumexp

    u = start.draws(np.clip(rng.random((count, start.mean.size)), 1e-12, 1.0 - 1e-12))[0]
    target, first = log_density(u), start.log_density(u)
    share, scale, total = 0.0, 2.4 / np.sqrt(start.mean.size), 0.0
    while share < 1.0:
        ahead = _ahead(target - first, 1.0 - share)
        share = min(1.0, share + ahead) if ahead < 1.0 - share else 1.0
        step(f"severities by steps: {100 * share:.0f} % of the way")
        log_weight = ahead * (target - first)
        total += float(logsumexp(log_weight) - np.log(count))
        weight = np.exp(log_weight - logsumexp(log_weight))
        mean = weight @ u
        covariance = (weight[:, None] * (u - mean)).T @ (u - mean)
        factor = np.linalg.cholesky(covariance + _SHORTEST**2 * np.eye(len(mean)))
        places = (np.arange(count) + rng.random()) / count
        chosen = np.minimum(np.searchsorted(np.cumsum(weight), places), count - 1)
        u, target, first = u[chosen], target[chosen], first[chosen]
        for _ in range(_LAST if share == 1.0 else _WALKS):
            walked = u + scale * rng.standard_normal(u.shape) @ factor.T
            inside = np.all((walked >= start.low) & (walked <= start.high), axis=1)
            walked = np.where(inside[:, None], walked, u)
            new_target, new_first = log_density(walked), start.log_density(walked)
            gain = share * (new_target - target) + (1.0 - share) * (new_first - first)
            taken = inside & (np.log(rng.random(count)) < gain)
            u = np.where(taken[:, None], walked, u)
            target, first = np.where(taken, new_target, target), np.where(taken, new_first, first)
            scale *= float(np.exp(taken.mean() - _ACCEPTED))
    return u, total


def _ahead(gain: FloatArray, most: float) -> float:
    """The longest step after which enough particles count."""

    def counting(ahead: float) -> float:
        weight = np.exp(ahead * (gain - gain.max()))
        return float(weight.sum() ** 2 / np.sum(weight**2)) / gain.size

    if counting(most) >= _COUNTING:
        return most
    low, high = 0.0, most
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if counting(middle) >= _COUNTING else (low, middle)
    return max(low, 1e-6)
