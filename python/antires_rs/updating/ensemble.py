"""Draws of the parameters given the measured values, with the residuals as the model has them.

Sequential Monte Carlo, as the transitional Markov chain Monte Carlo of Ching & Chen (J. Eng. Mech. 133 (2007)
816-832): particles go by steps from one density to another, weighted, drawn anew and moved. Two things are
other than there. They set out not from the prior but from the linear posterior with twice its errors, so that
few steps are enough; and most moves are proposed by the linear posterior of the step itself, along its axes
there and back, and accepted by what the true residuals say (Christen & Fox, J. Comput. Graph. Stat. 14 (2005)
795-810), so that where the residuals are nearly linear every move goes anywhere. Random walks do the rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..support.progress import step
from ..support.validation import FloatArray
from .error_model import drawn, normalized
from .fit import Fit
from .posterior import Linear

__all__ = ["Ensemble", "ensemble_draws"]

#: How much wider than the linear posterior the particles set out, and the proposals are.
_START, _WIDER = 2.0, 1.1
#: Share of the particles that must count after a step, and sweeps that draw the first ones.
_COUNTING, _SWEEPS = 0.5, 8
#: Accepted moves of a particle, on average, that a step and the last one end with; and rounds at most.
_MOVES, _LAST, _MOST = 2.0, 5.0, 30


@dataclass(frozen=True)
class Ensemble:
    """Draws in the unit box (k, n), number of the model's error (k,), steps, and share of moves accepted."""

    u: FloatArray
    which: NDArray[np.intp]
    steps: int
    accepted: float


class _Particles:
    """Particles with their residuals on the way from the linear posterior to the true one."""

    def __init__(self, fit: Fit, count: int, rng: np.random.Generator, workers: int) -> None:
        self.fit, self.rng, self.workers = fit, rng, workers
        self.wide = _START**2 * fit.errors.variance[fit.middle]
        start = Linear(fit, self.wide[None], 0)
        one = np.zeros(count, dtype=np.intp)
        self.u = start.spread(count, rng)
        for _ in range(_SWEEPS):
            self.u = start.swept(self.u, one, rng)
        self.linear = start.residuals
        self.which = drawn(fit.chances, rng.random(count))
        self.e = fit.residuals.many(self.u, workers)
        self.log_chances = np.log(np.maximum(fit.chances, 1e-300))
        self.b, self.scale = 0.0, 0.5

    def heat(self) -> None:
        """The next step: as far as half of the particles still count, then drawn anew by their weights."""
        count = len(self.u)
        target = self.fit.errors.log_density(self.e**2)[np.arange(count), self.which]
        gain = (
            target + 0.5 * np.sum(self.linear(self.u) ** 2 / self.wide, axis=1) - self.log_chances[self.which]
        )

        def counting(share: float) -> float:
            return 1.0 / float(np.sum(normalized(share * gain) ** 2)) / count

        low, high = 0.0, 1.0 - self.b
        if counting(high) < _COUNTING:
            for _ in range(40):
                middle = 0.5 * (low + high)
                low, high = (middle, high) if counting(middle) >= _COUNTING else (low, middle)
            high = max(low, 1e-6)
        self.b = min(1.0, self.b + high)
        places = (np.arange(count) + self.rng.random()) / count
        cumulative = np.cumsum(normalized(high * gain))
        chosen = np.minimum(np.searchsorted(cumulative, places), count - 1)
        self.u, self.e, self.which = self.u[chosen], self.e[chosen], self.which[chosen]

    def settle(self, moves: float) -> tuple[float, int]:
        """Moves of all particles until each was accepted ``moves`` times on average; moves and rounds."""
        fit, b = self.fit, self.b
        true = fit.errors.variance
        variance = _WIDER**2 / ((1.0 - b) / self.wide + b / true)
        linear = Linear(fit, variance, fit.middle)
        n = self.u.shape[1]
        axes = linear.axes[:n]
        factor = _root(np.cov(self.u.T).reshape(n, n))
        done, rounds = 0.0, 0
        while done < moves and rounds < _MOST:
            logits = (1.0 - b) * self.log_chances + b * fit.errors.log_density(self.e**2)
            self.which = drawn(normalized(logits), self.rng.random(len(self.u)))
            guide = variance[self.which]
            proposed = linear.swept(self.u, self.which, self.rng, np.vstack([axes, axes[::-1]]))
            bias = [
                0.5 * np.sum(self.linear(u) ** 2 / guide, axis=1) - u @ fit.residuals.tilt
                for u in (proposed, self.u)
            ]
            done += self._accept(proposed, bias[0] - bias[1])
            walked = self.u + self.scale * self.rng.standard_normal(self.u.shape) @ factor.T
            share = self._accept(walked, np.zeros(len(walked)))
            self.scale = float(np.clip(self.scale * np.exp(share - 0.25), 1e-3, 2.0))
            done += 0.2 * share  # a short way
            rounds += 1
        return done, rounds

    def _accept(self, proposed: FloatArray, correction: FloatArray) -> float:
        """Take the proposals that chance and the density allow; the share that was taken."""
        inside = np.all((proposed >= 0.0) & (proposed <= 1.0), axis=1)
        e = self.e.copy()
        if inside.any():
            e[inside] = self.fit.residuals.many(proposed[inside], self.workers)
        gain = self._log_density(np.where(inside[:, None], proposed, self.u), e) - self._log_density(
            self.u, self.e
        )
        taken = inside & (np.log(self.rng.random(len(e))) < gain + correction)
        self.u = np.where(taken[:, None], proposed, self.u)
        self.e = np.where(taken[:, None], e, self.e)
        return float(taken.mean())

    def _log_density(self, u: FloatArray, e: FloatArray) -> FloatArray:
        """Logarithm of the density of the step at fixed errors of the model, (k,)."""
        start = np.sum(self.linear(u) ** 2 / self.wide, axis=1)
        end = np.sum(e**2 / self.fit.errors.variance[self.which], axis=1)
        prior = u @ self.fit.residuals.tilt
        return np.asarray(prior - 0.5 * ((1.0 - self.b) * start + self.b * end))


def ensemble_draws(fit: Fit, count: int, rng: np.random.Generator, workers: int) -> Ensemble:
    """Draws of the free parameters and of the error of the model; the same bits for any number of workers."""
    if fit.u.size == 0:
        return Ensemble(np.empty((count, 0)), drawn(fit.chances, rng.random(count)), 0, 1.0)
    particles = _Particles(fit, count, rng, workers)
    steps, accepted, rounds = 0, 0.0, 0
    while particles.b < 1.0:
        particles.heat()
        steps += 1
        step(f"ensemble, step {steps}: {100 * particles.b:.0f} % of the way")
        moved, passed = particles.settle(_LAST if particles.b == 1.0 else _MOVES)
        accepted, rounds = accepted + moved, rounds + passed
    return Ensemble(particles.u, particles.which, steps, min(1.0, accepted / max(rounds, 1)))


def _root(covariance: FloatArray) -> FloatArray:
    """A matrix whose product with its transpose is the covariance, which may be singular."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))
