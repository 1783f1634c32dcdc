r"""How probable the values of now are, for given severities.

.. math:: \ln f_D \sim N(\ln r(\beta, \hat\theta) + \mu, \;
          C(\beta) + \sigma^2 + \kappa^2 g^2 + c^2 1 1^T)

mu and C come from :mod:`~antires_rs.damage.model_error`: what the baseline says about the model and the
roots, and what it leaves open. kappa is the error of a predicted change g that no factor of the model
explains, a multiple of the share of the baseline's misfit that no factor explained (tau / s); it is summed
over ``KAPPA``. c moves all values alike, as another temperature does. Values and roots are associated anew
at every beta (:mod:`~antires_rs.damage.association`).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support.validation import FloatArray
from .measured_states import Values
from .mode_roots import ModeRoots
from .model_error import ModelError
from .reduced_roots import ReducedRoots
from .roots import Roots, Source, roots_at
from .vanished import and_vanished, vanished
from .view import ERRORS, Band, Foreseen, View, viewed

__all__ = ["Likelihood"]

#: Changes (standard deviations of ln f) that something else may make.
ANY_CHANGE = np.geomspace(3e-4, 0.3, 10)
#: The same for changes of all values alike, as of temperature, and their share of the
#: probability: small, since std_common allows for what is usual.
ALIKE, ALIKE_SHARE = (5e-3, 1.5e-2, 4e-2), 0.05
#: Change of a root that has just appeared.
_NEW = 0.1
#: Roots so far outside of what was measured (ln f) are not looked at.
_MARGIN = 0.3


class Likelihood:
    """p(values of now | severities), after the baseline."""

    def __init__(
        self,
        core: Source | _core.Objective,
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
        both = np.concatenate([now.frequencies, intact.frequencies])
        self.band = Band(float(both.min()), float(both.max()))
        #: Of the model, after the baseline.
        self.factors = np.exp(error.theta)
        self._errors = tuple((error.outside * kappa, times, p) for kappa, times, p in ERRORS)
        by_theta = error.intact.slopes[:, n_elements:] * self.factors
        self._beside = error.predicted(by_theta, np.arange(error.intact.size), error.intact.kind)[0]
        #: Evaluations of the model.
        self.nfev = 0
        self._undamaged = self.roots(np.zeros((1, n_elements)), slopes=True)[0]
        #: The undamaged model.
        self.start = self._view(np.zeros(n_elements), self._undamaged, 0.0)

    def roots(self, betas: FloatArray, *, slopes: bool) -> list[Roots]:
        """The model's roots at each row of severities (m, n)."""
        self.nfev += len(betas)
        factors = np.broadcast_to(self.factors, (len(betas), self.factors.size))
        band_hz = (np.exp(self.band.low - 2.0 * _MARGIN), np.exp(self.band.high + 2.0 * _MARGIN))
        x = np.hstack([betas, factors])
        return roots_at(self.core, x, slopes=slopes, threads=self.threads, band_hz=band_hz)

    def settle(self, beta: FloatArray) -> float:
        """Give severities (n,) a reduced model of their own; how far its roots are from the full model's."""
        if not isinstance(self.core, ReducedRoots):
            return 0.0
        return self.core.settle(np.concatenate([beta, self.factors]))

    def views(self, betas: FloatArray, extra: float = 0.0) -> list[View]:
        """The values as seen from each row of severities, with an extra error of every value."""
        found = self.roots(betas, slopes=True)
        return [self._view(beta, roots, extra) for beta, roots in zip(betas, found, strict=True)]

    def unexplained(self, roots: Roots) -> float:
        """Distance of the values from roots as far beside the model's as the intact ones lie."""
        roots, identity = roots.since(self.error.intact)
        place = roots.log_f + np.where(identity >= 0, self._beside[identity], 0.0)
        return self.now.unexplained(roots, place)

    def near(self, roots: Roots) -> tuple[Roots, NDArray[np.intp], NDArray[np.intp]]:
        """The roots near the band, which of the intact ones these have been, and which all have been."""
        roots, followed = roots.since(self.error.intact)
        kept = roots.between(self.band.low - _MARGIN, self.band.high + _MARGIN)
        return roots.only(kept), followed[kept], followed

    def something_else(self) -> float:
        """Log evidence of a change that has nothing to do with any element: of every value, by any amount,
        or of all values alike."""
        zero = np.zeros(self.n)
        found = [self._view(zero, self._undamaged, extra).log_likelihood for extra in ANY_CHANGE]
        by_itself = np.logaddexp.reduce(found) - np.log(len(found))
        alike = np.log(ALIKE_SHARE) + self._alike
        return float(np.logaddexp(np.log1p(-ALIKE_SHARE) + by_itself, alike))

    def moved_alike(self) -> float | None:
        """Relative change of all values, where that is what something else comes to."""
        if self.something_else() > np.log(2.0 * ALIKE_SHARE) + self._alike:  # less than half of it
            return None
        view = max(self._shifted, key=lambda view: view.log_likelihood)
        kind = self.near(self._undamaged)[0].kind[view.partner[view.matched]]
        return float(np.expm1(np.median(view.residual[kind == 0]))) if view.matched.any() else None

    @cached_property
    def _shifted(self) -> list[View]:
        """The values as seen from no damage, all of them moved alike by one of ``ALIKE``."""
        return [self._view(np.zeros(self.n), self._undamaged, 0.0, each) for each in ALIKE]

    @property
    def _alike(self) -> float:
        """Log evidence of a change of all values alike."""
        found = [view.log_likelihood for view in self._shifted]
        return float(np.logaddexp.reduce(found) - np.log(len(found)))

    def _view(self, beta: FloatArray, roots: Roots, extra: float, common: float = 0.0) -> View:
        roots, identity, followed = self.near(roots)
        log_f, slopes = roots.log_f, roots.slopes
        beside, spread = self.error.predicted(slopes[:, self.n :] * self.factors, identity, roots.kind)
        old = identity >= 0
        alike = np.hypot(self.common, common) * (roots.kind == 0)
        foreseen = Foreseen(
            response=roots.response,
            place=log_f + beside,
            beside=beside,
            spread=spread + extra**2 * np.eye(log_f.size) + np.outer(alike, alike),
            change=np.where(old, log_f - self.error.intact.log_f[identity], _NEW),
            slopes=slopes[:, : self.n],
            seen=old & self.error.seen[identity],
            modes=roots if isinstance(roots, ModeRoots) else None,
        )
        if foreseen.modes is None:  # modes do not vanish
            foreseen = and_vanished(foreseen, vanished(self.error, self._beside, followed))
        return viewed(beta, self.now, foreseen, self.band, self._errors)
