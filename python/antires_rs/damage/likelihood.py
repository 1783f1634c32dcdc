r"""How probable the values of now are, for given severities.

.. math:: \ln f_D \sim N\big(\ln r(\beta, \hat\theta) + \mu, \;
          C(\beta) + \sigma^2 + \kappa^2 g^2 + c^2 1 1^T\big)

mu and C come from :mod:`~antires_rs.damage.model_error`: what the baseline says about the model and the
roots, and what it leaves open. kappa is the error of a predicted change g that no factor of the model
explains, a multiple of the share of the baseline's misfit that no factor explained (tau / s); it is summed
over ``KAPPA``. c moves all values alike, as another temperature does. Values and roots are associated anew
at every beta (:mod:`~antires_rs.damage.association`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support.validation import FloatArray
from .association import FALSE, FOUND, FOUND_ONCE, associate
from .measured_states import Values
from .model_error import ModelError
from .roots import Roots, follow, roots_at

__all__ = ["Likelihood", "View"]

#: Errors of predictions and of values, each with a prior probability: multiples of the share of the model's
#: error that no factor explains, and of the values' standard deviations, which are estimates themselves. Set
#: on chain8 and the exhaust, seeds 0 to 3.
ERRORS = (
    (0.0, 0.7, 0.08),
    (0.0, 1.0, 0.20),
    (0.0, 1.6, 0.10),
    (0.0, 3.0, 0.05),
    (0.5, 1.0, 0.15),
    (0.5, 2.0, 0.06),
    (1.0, 1.0, 0.15),
    (1.0, 2.0, 0.06),
    (1.6, 1.0, 0.10),
    (1.6, 2.0, 0.05),
)
#: Least and largest share; and what it is where the baseline has no value to spare that would tell.
OUTSIDE, UNTOLD = (0.01, 0.25), 0.08
#: Share of the mean square of all changes that counts in the error of each one, however small its own.
_COMMON = 0.5
#: Changes (standard deviations of ln f) that something else may make.
ANY_CHANGE = np.geomspace(3e-4, 0.3, 10)
#: In the association, before anything is known of kappa; and change of a root that has just appeared.
_FIRST_KAPPA, _NEW = 0.1, 0.1
#: Roots so far outside of what was measured (ln f) are not looked at.
_MARGIN = 0.3
#: Over so much of ln f from the edges of what was measured on, a root is ever more surely found.
_EDGE = 0.06
#: The band has at least this width in ln f.
_LEAST_BAND = 0.1


@dataclass(frozen=True)
class View:
    """The values of now, seen from one point: all that is linear from there.

    Attributes
    ----------
    beta : (n,) severities there.
    log_likelihood : of the values.
    gain, curvature : gradient (n,) and Gauss-Newton Hessian (n, n) of the log-likelihood by all severities.
    kappa, times : the most probable error of predictions, and multiple of the standard deviations.
    matched : (m,) whether each value has a root.
    beside : (m,) how far that root lies beside the model's in the measured structure, ln f; 0 without one.
    residual, std : of those that have, in ln f.
    chi_square : of all together.
    """

    beta: FloatArray
    log_likelihood: float
    gain: FloatArray
    curvature: FloatArray
    kappa: float
    times: float
    matched: NDArray[np.bool_]
    beside: FloatArray
    residual: FloatArray
    std: FloatArray
    chi_square: float


class Likelihood:
    """p(values of now | severities), after the baseline."""

    def __init__(
        self,
        core: _core.Objective,
        n_elements: int,
        error: ModelError,
        intact: Values,
        now: Values,
        common: float,
        threads: int,
    ) -> None:
        self.core, self.n, self.error, self.now, self.threads = core, n_elements, error, now, threads
        #: Standard deviation of what moves all values alike between the two states, ln f.
        self.common = common
        both = np.concatenate([now.log_f, intact.log_f])
        self.low, self.high = float(both.min()), float(both.max())
        self._alone = -float(np.log(FALSE / max(self.high - self.low, _LEAST_BAND)))
        self._factors = np.exp(error.theta)
        outside = np.clip(np.hypot(error.tau / error.s, UNTOLD / (1.0 + error.spare)), *OUTSIDE)
        self._errors = tuple((float(outside) * kappa, times, p) for kappa, times, p in ERRORS)
        by_theta = error.intact.slopes[:, n_elements:] * self._factors
        self._beside = error.predicted(by_theta, np.arange(error.intact.size))[0]
        #: Evaluations of the model.
        self.nfev = 0
        self._undamaged = self.roots(np.zeros((1, n_elements)), slopes=True)[0]
        #: The undamaged model.
        self.start = self._view(np.zeros(n_elements), self._undamaged, 0.0)

    def roots(self, betas: FloatArray, *, slopes: bool) -> list[Roots]:
        """The model's roots at each row of severities (m, n)."""
        self.nfev += len(betas)
        factors = np.broadcast_to(self._factors, (len(betas), self._factors.size))
        return roots_at(self.core, np.hstack([betas, factors]), slopes=slopes, threads=self.threads)

    def views(self, betas: FloatArray, extra: float = 0.0) -> list[View]:
        """The values as seen from each row of severities, with an extra error of every value."""
        found = self.roots(betas, slopes=True)
        return [self._view(beta, roots, extra) for beta, roots in zip(betas, found, strict=True)]

    def expected(self, roots: Roots) -> FloatArray:
        """ln f of roots in the measured structure, as far beside the model's as the intact ones lie."""
        identity = follow(self.error.intact, roots)
        return np.asarray(roots.log_f + np.where(identity >= 0, self._beside[identity], 0.0))

    def something_else(self) -> float:
        """Log evidence of a change that has nothing to do with any element: of every value, by any amount."""
        from scipy.special import logsumexp

        zero = np.zeros(self.n)
        found = [self._view(zero, self._undamaged, extra).log_likelihood for extra in ANY_CHANGE]
        return float(logsumexp(found) - np.log(len(found)))

    def _view(self, beta: FloatArray, roots: Roots, extra: float) -> View:
        from scipy.linalg import solve_triangular
        from scipy.special import logsumexp

        near = (roots.log_f > self.low - _MARGIN) & (roots.log_f < self.high + _MARGIN)
        identity, log_f, slopes = (
            follow(self.error.intact, roots)[near],
            roots.log_f[near],
            roots.slopes[near],
        )
        mean, spread = self.error.predicted(slopes[:, self.n :] * self._factors, identity)
        place = log_f + mean
        change = np.where(identity >= 0, log_f - self.error.intact.log_f[identity], _NEW)
        variance = np.maximum(np.diag(spread), 0.0) + (_FIRST_KAPPA * change) ** 2
        variance += extra**2 + self.common**2
        partner, price = self._associated(roots.response[near], place, np.sqrt(variance), identity)
        has = np.flatnonzero(partner >= 0)
        root = partner[has]
        residual = self.now.log_f[has] - place[root]
        model = spread[np.ix_(root, root)] + extra**2 * np.eye(root.size) + self.common**2
        noise = np.diag(self.now.std[has] ** 2)
        size = np.sqrt(change[root] ** 2 + _COMMON * np.mean(change[root] ** 2)) if root.size else np.empty(0)
        # Two tests of one state share the error of a root's change.
        unmodelled = (root[:, None] == root) * np.outer(size, size)
        triangles = [
            np.linalg.cholesky(model + times**2 * noise + kappa**2 * unmodelled)
            for kappa, times, _ in self._errors
        ]
        white = [solve_triangular(t, residual, lower=True) for t in triangles]
        logs = [
            float(np.log(p) - 0.5 * w @ w - np.sum(np.log(np.diag(t))))
            for (_, _, p), t, w in zip(self._errors, triangles, white, strict=True)
        ]
        best = int(np.argmax(logs))
        slope = solve_triangular(triangles[best], slopes[root][:, : self.n], lower=True)
        return View(
            beta=beta,
            log_likelihood=float(logsumexp(logs)) - 0.5 * has.size * float(np.log(2.0 * np.pi)) - price,
            gain=slope.T @ white[best],
            curvature=slope.T @ slope,
            kappa=self._errors[best][0],
            times=self._errors[best][1],
            matched=partner >= 0,
            beside=np.where(partner >= 0, mean[partner], 0.0),
            residual=residual,
            std=np.linalg.norm(triangles[best], axis=1),
            chi_square=float(white[best] @ white[best]),
        )

    def _associated(
        self, response: NDArray[np.intp], place: FloatArray, sigma: FloatArray, identity: NDArray[np.intp]
    ) -> tuple[NDArray[np.intp], float]:
        """Root of each value, and what those without a partner cost."""
        seen = (identity >= 0) & self.error.seen[identity]
        found = np.where(seen, FOUND, FOUND_ONCE)
        # Near the edges of the band nobody knows whether a root would have been found.
        inside = np.clip(np.minimum(place - self.low, self.high - place) / _EDGE, 0.0, 1.0)
        missed, present = -inside * np.log([1.0 - found, found])
        partner, price = np.full(self.now.size, -1), 0.0
        for test in np.unique(self.now.test):
            own = np.flatnonzero(self.now.test == test)
            value = (self.now.response[own], self.now.log_f[own], self.now.std[own])
            partner[own] = associate(value, (response, place, sigma), self._alone, missed - present)
            taken = partner[own][partner[own] >= 0]
            price += self._alone * (own.size - taken.size) + missed.sum() - (missed - present)[taken].sum()
        return partner, float(price)
