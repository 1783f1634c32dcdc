r"""What the intact structure tells of the model's errors, and what it leaves open.

The true structure is the model with unknown factors exp(theta) on every stiffness and mass term, and every
root m has an error eps_m of its own, which no factor explains and which is there in both states:

.. math:: \ln f_m = \ln r_m(\beta, \theta) + \epsilon_m + \mathrm{noise},
          \qquad \theta \sim N(0, s^2), \quad \epsilon \sim N(0, \tau^2).

s and tau are learned from the baseline: under them its values are most probable (with weak priors, ``S`` and
``TAU``). theta is then estimated by the values, in Gauss-Newton steps, each with values and roots associated
anew; and what remains open of theta and eps is carried into every prediction.

Reference: C. M. Bishop, Pattern Recognition and Machine Learning, 2006, section 3.5 (evidence).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support.validation import FloatArray
from .association import FALSE, FOUND_ONCE, associate
from .measured_states import Values
from .roots import Roots, roots_at

__all__ = ["ModelError", "learned"]

#: Median and logarithmic standard deviation of the priors of s and tau.
S, TAU = (0.05, 1.5), (1e-3, 1.5)
_S_GRID = np.geomspace(5e-4, 0.6, 22)
_TAU_GRID = np.geomspace(2e-6, 0.15, 18)
#: Without a baseline the roots' own errors are this share of what is assumed of the factors.
_TAU_SHARE = 0.2
#: Errors with which values and roots are associated, step by step; later ones are multiples of tau.
_FIRST = (0.1, 0.03, 0.01, 0.004)
_MULTIPLE = 3.0
#: Least and largest share of the model's error that no factor explains; and what it is where the baseline
#: has no value to spare that would tell.
_OUTSIDE, _UNTOLD = (0.01, 0.25), 0.08
_ITERATIONS, _SETTLED = 12, 1e-4
#: Largest step of ln factor in one iteration, and its bound.
_STEP, _REACH = 0.3, 1.6


@dataclass(frozen=True)
class ModelError:
    """The model after the baseline.

    Attributes
    ----------
    theta : (p,) ln factors at which the model is evaluated.
    s, tau : scatter of the factors, and of the roots' own errors.
    intact : the undamaged model's roots there.
    partner : root of each baseline value, -1 without one.
    spare : values beyond those that the factors took to be explained.
    mean : (p + r,) what is expected of the factors beyond ``theta``, and of the roots' own errors.
    """

    theta: FloatArray
    s: float
    tau: float
    intact: Roots
    partner: NDArray[np.intp]
    spare: float
    mean: FloatArray
    _rows: FloatArray = field(repr=False)
    _prior: FloatArray = field(repr=False)
    _factor: Any = field(repr=False)

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Which intact roots the baseline shows, (r,)."""
        found = np.zeros(self.intact.size, dtype=bool)
        found[self.partner[self.partner >= 0]] = True
        return found

    @property
    def outside(self) -> float:
        """Share of the model's error that no factor explains."""
        share = np.hypot(self.tau / self.s, _UNTOLD / (1.0 + self.spare))
        return float(np.clip(share, *_OUTSIDE))

    def predicted(self, slopes: FloatArray, identity: NDArray[np.intp]) -> tuple[FloatArray, FloatArray]:
        """Mean (m,) and covariance (m, m) of ln f of roots, beyond the model's.

        ``slopes`` (m, p) are by theta, ``identity`` (m,) the roots' numbers in the intact state, -1 for new
        ones.
        """
        from scipy.linalg import cho_solve

        rows = np.zeros((identity.size, self._prior.size))
        rows[:, : self.theta.size] = slopes
        old = np.flatnonzero(identity >= 0)
        rows[old, self.theta.size + identity[old]] = 1.0
        spread = (rows * self._prior) @ rows.T
        if self._rows.size:
            cross = (rows * self._prior) @ self._rows.T
            spread -= cross @ cho_solve(self._factor, cross.T)
        new = np.flatnonzero(identity < 0)
        spread[new, new] += self.tau**2
        return rows @ self.mean, spread


def learned(
    core: _core.Objective,
    n_elements: int,
    n_factors: int,
    values: Values,
    assumed: float | None,
    threads: int,
) -> ModelError:
    """Theta, s and tau from the baseline; ``assumed`` is s where it is not to be learned."""
    from scipy.linalg import cho_solve

    theta = np.zeros(n_factors)
    s, tau = (S[0], TAU[0]) if assumed is None else (assumed, _TAU_SHARE * assumed)
    intact, slopes = _undamaged(core, n_elements, theta, threads)
    if not values.size:
        prior = np.concatenate([np.full(n_factors, s**2), np.full(intact.size, tau**2)])
        nothing = np.empty((0, prior.size))
        partner = np.empty(0, dtype=np.intp)
        return ModelError(theta, s, tau, intact, partner, 0.0, np.zeros(prior.size), nothing, prior, None)
    for nth in range(_ITERATIONS):
        spread = _FIRST[nth] if nth < len(_FIRST) else _MULTIPLE * tau
        partner = _partners(values, intact, spread)
        std = values.std[partner >= 0]
        rows, y = _observed(values, intact, slopes, partner, theta)
        if assumed is None:
            s, tau = _scales(rows, y, std, n_factors)
        factor, prior = _factored(rows, std, s, tau, n_factors)
        step = (prior * (rows.T @ cho_solve(factor, y)))[:n_factors] - theta
        theta = np.clip(theta + np.clip(step, -_STEP, _STEP), -_REACH, _REACH)
        intact, slopes = _undamaged(core, n_elements, theta, threads)
        if nth >= len(_FIRST) and np.abs(step).max(initial=0.0) < _SETTLED:
            break
    partner = _partners(values, intact, _MULTIPLE * tau)
    rows, y = _observed(values, intact, slopes, partner, theta)
    factor, prior = _factored(rows, values.std[partner >= 0], s, tau, n_factors)
    mean = prior * (rows.T @ cho_solve(factor, y))
    mean[:n_factors] -= theta
    by_factors = (rows[:, :n_factors] * s) @ (rows[:, :n_factors] * s).T
    spare = y.size - float(np.trace(cho_solve(factor, by_factors)))
    return ModelError(theta, s, tau, intact, partner, spare, mean, rows, prior, factor)


def _partners(values: Values, intact: Roots, spread: float) -> NDArray[np.intp]:
    """Root of each value, test by test."""
    low, high = values.log_f.min(), values.log_f.max()
    inside = (intact.log_f > low) & (intact.log_f < high)
    missed = np.where(inside, -np.log(1.0 - FOUND_ONCE), 0.0)
    alone = -float(np.log(FALSE / max(high - low, 0.1)))
    root = (intact.response, intact.log_f, np.full(intact.size, spread))
    found = np.full(values.size, -1)
    for test in np.unique(values.test):
        own = np.flatnonzero(values.test == test)
        found[own] = associate(
            (values.response[own], values.log_f[own], values.std[own]), root, alone, missed
        )
    return found


def _undamaged(
    core: _core.Objective, n_elements: int, theta: FloatArray, threads: int
) -> tuple[Roots, FloatArray]:
    """The roots, and their slopes by theta."""
    x = np.concatenate([np.zeros(n_elements), np.exp(theta)])
    found = roots_at(core, x[None], slopes=True, threads=threads)[0]
    return found, found.slopes[:, n_elements:] * np.exp(theta)


def _observed(
    values: Values, intact: Roots, slopes: FloatArray, partner: NDArray[np.intp], theta: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rows by theta and eps, and what they give: ln f_I - ln r + J theta."""
    has = np.flatnonzero(partner >= 0)
    root = partner[has]
    rows = np.zeros((has.size, theta.size + intact.size))
    rows[:, : theta.size] = slopes[root]
    rows[np.arange(has.size), theta.size + root] = 1.0
    return rows, values.log_f[has] - intact.log_f[root] + slopes[root] @ theta


def _factored(rows: FloatArray, std: FloatArray, s: float, tau: float, n: int) -> tuple[Any, FloatArray]:
    """Cholesky factor of the values' covariance, and the prior variances of theta and eps."""
    from scipy.linalg import cho_factor

    prior = np.concatenate([np.full(n, s**2), np.full(rows.shape[1] - n, tau**2)])
    return cho_factor((rows * prior) @ rows.T + np.diag(std**2), lower=True), prior


def _scales(rows: FloatArray, y: FloatArray, std: FloatArray, n: int) -> tuple[float, float]:
    """s and tau under which y is most probable, by turns on their grids."""
    from scipy.linalg import cho_factor, cho_solve

    by_theta, by_root = rows[:, :n] @ rows[:, :n].T, rows[:, n:] @ rows[:, n:].T
    noise = np.diag(std**2)

    def log_evidence(s: float, tau: float) -> float:
        factor = cho_factor(s**2 * by_theta + tau**2 * by_root + noise, lower=True)
        priors = (np.log(s / S[0]) / S[1]) ** 2 + (np.log(tau / TAU[0]) / TAU[1]) ** 2
        return float(-0.5 * (y @ cho_solve(factor, y) + priors) - np.sum(np.log(np.diag(factor[0]))))

    s, tau = S[0], TAU[0]
    while True:
        before = (s, tau)
        s = float(max(_S_GRID, key=lambda each: log_evidence(each, tau)))
        tau = float(max(_TAU_GRID, key=lambda each: log_evidence(s, each)))
        if (s, tau) == before:
            return s, tau
