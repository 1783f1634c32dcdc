"""Draws of the parameters given the measured values: the residuals taken as linear around the fit.

Laplace's approximation with what it usually leaves out: the bounds, which cut it off, and the error of the
model, which is drawn along with the parameters. Chains go through both in turn (Gibbs); each gives one draw.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..support.progress import step
from ..support.validation import FloatArray
from .box_gaussian import axes_of, sweep
from .error_model import drawn, normalized
from .fit import Fit

__all__ = ["Linear", "linear_draws"]

#: Sweeps of every chain, along all axes, and the error of the model after each.
_SWEEPS = 10


class Linear:
    """Gaussians of the linear residuals within the box, times the prior, one a row of ``variance`` (G, m)."""

    def __init__(self, fit: Fit, variance: FloatArray, middle: int) -> None:
        self.fit, self.variance = fit, variance
        weighted = fit.jacobian.T[None] / variance[:, None, :]  # (G, n, m)
        self.precisions = weighted @ fit.jacobian
        self.slopes = weighted @ fit.e - fit.residuals.tilt
        self.axes = axes_of(self.precisions[middle])
        self.typical = self.precisions[middle]

    def residuals(self, u: FloatArray) -> FloatArray:
        """Linear residuals at every row, (k, m)."""
        return np.asarray(self.fit.e + (u - self.fit.u) @ self.fit.jacobian.T)

    def swept(
        self, u: FloatArray, which: NDArray[np.intp], rng: np.random.Generator, axes: FloatArray | None = None
    ) -> FloatArray:
        """Every chain moved once along each axis within the Gaussian that ``which`` names."""
        along = self.axes if axes is None else axes
        return sweep(u, self.fit.u, self.precisions, self.slopes, which, along, rng)

    def spread(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Points to start from, (count, n): of the Gaussian without its box, put on the box where outside."""
        values, axes = np.linalg.eigh(self.typical)
        std = np.minimum(1.0 / np.sqrt(np.maximum(values, 1e-12)), 0.5)
        noise = rng.standard_normal((count, values.size)) * std
        return np.asarray(np.clip(self.fit.u + noise @ axes.T, 0.0, 1.0))


def linear_draws(fit: Fit, count: int, rng: np.random.Generator) -> tuple[FloatArray, NDArray[np.intp]]:
    """Draws of the free parameters in the unit box, (count, n), and the number of the error, (count,)."""
    which = drawn(fit.chances, rng.random(count))
    if fit.u.size == 0:
        return np.empty((count, 0)), which
    linear = Linear(fit, fit.errors.variance, fit.middle)
    u = linear.spread(count, rng)
    for nth in range(_SWEEPS):
        step(f"linear posterior, sweep {nth + 1} of {_SWEEPS}")
        u = linear.swept(u, which, rng)
        chances = normalized(fit.errors.log_density(linear.residuals(u) ** 2))
        which = drawn(chances, rng.random(count))
    return u, which
