r"""How probable the values of now are, for given severities.

.. math:: \ln f_D \sim N(\ln r(\beta, \hat\theta) + \mu, \;
          C(\beta) + \sigma^2 + \kappa^2 g^2 + c^2 1 1^T)

mu and C come from :mod:`~antires_rs.damage.model_error`: what the baseline says about the model and the
roots, and what it leaves open. kappa is the error of a predicted change g that no factor of the model
explains, a multiple of the share of the baseline's misfit that no factor explained (tau / s); it is summed
over ``KAPPA``. c moves all values alike, as another temperature does. Values and roots are associated anew
at every beta (``measured_states``).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support.checks import FloatArray
from .measured_modes import ModeRoots
from .measured_states import FALSE, FOUND, FOUND_ONCE, Roots, Source, Values, roots_at
from .model_error import ModelError
from .reduced_roots import ReducedRoots

# -- The values of now, seen from one point of the severities: which root each belongs to, and what it says
#
# Values and roots are associated twice, as their errors are stated and three times as large, and the more
# probable way counts: a value that is off by many standard deviations is lost, or all of them are too small.


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
#: Share of the mean square of all changes that counts in the error of each one, however small its own.
_COMMON = 0.5
#: In the association, before anything is known of kappa; and by how much all errors are widened.
_FIRST_KAPPA, _WIDER = 0.1, (1.0, 3.0)
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
    partner : (m,) root of each value, -1 without one.
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
    partner: NDArray[np.intp]
    beside: FloatArray
    residual: FloatArray
    std: FloatArray
    chi_square: float

    @property
    def matched(self) -> NDArray[np.bool_]:
        """Whether each value has a root, (m,)."""
        return self.partner >= 0


@dataclass(frozen=True)
class Band:
    """Where values were looked for, ln f."""

    low: float
    high: float

    @property
    def alone(self) -> float:
        """Price of a value without a root: a false one, anywhere in the band."""
        return -float(np.log(FALSE / max(self.high - self.low, _LEAST_BAND)))

    def prices(self, place: FloatArray, seen: NDArray[np.bool_]) -> tuple[FloatArray, FloatArray]:
        """Prices of roots that are missed, and of those that are found; ``seen`` in the other state."""
        found = np.where(seen, FOUND, FOUND_ONCE)
        # Near the edges of the band nobody knows whether a root would have been found.
        inside = np.clip(np.minimum(place - self.low, self.high - place) / _EDGE, 0.0, 1.0)
        missed, present = -inside * np.log([1.0 - found, found])
        return missed, present


@dataclass(frozen=True)
class Foreseen:
    """Roots as they are expected in the measured structure at some severities; (r,) each.

    ``place`` ln f with covariance ``spread``, ``beside`` the model's, ``change`` from the intact state, with
    ``slopes`` (r, n) by the severities; ``seen`` in the intact state; ``modes`` where they are of modes.
    """

    response: NDArray[np.intp]
    place: FloatArray
    beside: FloatArray
    spread: FloatArray
    change: FloatArray
    slopes: FloatArray
    seen: NDArray[np.bool_]
    modes: Roots | None = None

    @property
    def roots(self) -> Roots:
        """What values are associated with."""
        return self.modes or Roots(self.response, self.place, self.slopes)


def viewed(
    beta: FloatArray, now: Values, roots: Foreseen, band: Band, errors: tuple[tuple[float, float, float], ...]
) -> View:
    """The more probable of the two ways to associate values and roots."""
    variance = np.maximum(np.diag(roots.spread), 0.0) + (_FIRST_KAPPA * roots.change) ** 2
    found: list[View] = []
    before: NDArray[np.intp] | None = None
    for wider in _WIDER:
        partner, place, price = associated(now, roots, band, np.sqrt(variance), wider)
        if before is None or not np.array_equal(partner, before):
            found.append(_judged(beta, now, place, roots, partner, price, errors))
        before = partner
    return max(found, key=lambda view: view.log_likelihood)


def associated(
    now: Values, roots: Foreseen, band: Band, sigma: FloatArray, wider: float
) -> tuple[NDArray[np.intp], FloatArray, float]:
    """Root of each value, the values as seen from there, and what those without a partner cost."""
    missed, present = (np.where(roots.roots.kind == 0, p, 0.0) for p in band.prices(roots.place, roots.seen))
    partner, place, lost = now.associated(
        roots.roots, roots.place, sigma, band.alone, missed - present, wider
    )
    taken = partner[partner >= 0]
    price = lost + now.times_measured(roots.response) @ missed - (missed - present)[taken].sum()
    return partner, place, float(price)


def _judged(
    beta: FloatArray,
    now: Values,
    place: FloatArray,
    roots: Foreseen,
    partner: NDArray[np.intp],
    price: float,
    errors: tuple[tuple[float, float, float], ...],
) -> View:
    """Likelihood and slopes, for one way to associate."""
    from scipy.linalg.lapack import dtrtrs

    has = np.flatnonzero(partner >= 0)
    root = partner[has]
    residual = place[has] - roots.place[root]
    model, noise = roots.spread[np.ix_(root, root)], np.diag(now.std[has] ** 2)
    change = roots.change[root]
    size = np.sqrt(change**2 + _COMMON * _mean_of_kind(change**2, roots.roots.kind[root]))
    # Two tests of one state share the error of a root's change.
    unmodelled = (root[:, None] == root) * np.outer(size, size)
    kappa, times, share = np.array(errors).T[..., None, None]
    triangles = np.linalg.cholesky(model + times**2 * noise + kappa**2 * unmodelled)
    # A row-major lower triangle is a column-major upper one.
    solved = [dtrtrs(each.T, residual, trans=1)[0] for each in triangles] if has.size else []
    white = np.reshape(solved, (len(errors), has.size))
    log_diagonal = np.log(np.diagonal(triangles, axis1=1, axis2=2)).sum(axis=1)
    logs = np.log(share[:, 0, 0]) - 0.5 * np.einsum("ei,ei->e", white, white) - log_diagonal
    best = int(np.argmax(logs))
    slopes = roots.slopes[root]
    slope = dtrtrs(triangles[best].T, slopes, trans=1)[0] if has.size else slopes
    beside = np.zeros(now.size)
    beside[has] = roots.beside[root]
    return View(
        beta=beta,
        log_likelihood=float(np.logaddexp.reduce(logs)) - 0.5 * has.size * float(np.log(2.0 * np.pi)) - price,
        gain=slope.T @ white[best],
        curvature=slope.T @ slope,
        kappa=errors[best][0],
        times=errors[best][1],
        partner=partner,
        beside=beside,
        residual=residual,
        std=np.linalg.norm(triangles[best], axis=1),
        chi_square=float(white[best] @ white[best]),
    )


def _mean_of_kind(squares: FloatArray, kind: NDArray[np.intp]) -> FloatArray:
    """The mean of those of the same kind, for each."""
    if not kind.any():
        return np.full(squares.size, squares.mean() if squares.size else 0.0)
    found = np.zeros(squares.size)
    for each in np.unique(kind):
        found[kind == each] = np.mean(squares[kind == each])
    return found


# -- Roots that the baseline shows and the model loses on the way to a damage: two that met
#
# Where they meet depends on the model's errors. So a structure may still have them where the model has not,
# and a value there is not simply a false one: it may be of such a root, found with the probability of one
# that only one state shows, as far from its intact place as a root goes until it meets another.


#: Standard deviation of ln f of such a root from its intact place.
_MOVED = 0.1

Gone = tuple[NDArray[np.intp], FloatArray]


def vanished(error: ModelError, beside: FloatArray, followed: NDArray[np.intp]) -> Gone:
    """Response and ln f, in the measured structure, of roots that are gone; ``followed`` are those left."""
    left = np.zeros(error.intact.size, dtype=bool)
    left[followed[followed >= 0]] = True
    gone = np.flatnonzero(error.seen & ~left)
    return error.intact.response[gone], error.intact.log_f[gone] + beside[gone]


def and_vanished(roots: Foreseen, gone: Gone) -> Foreseen:
    """The roots together with those that are gone, in ascending order within each response."""
    response, place = gone
    n, m = roots.place.size, response.size
    if not m:
        return roots
    both, places = np.concatenate([roots.response, response]), np.concatenate([roots.place, place])
    order = np.lexsort((places, both))
    spread = np.zeros((n + m, n + m))
    spread[:n, :n] = roots.spread
    spread[np.arange(n, n + m), np.arange(n, n + m)] = _MOVED**2
    none = np.zeros(m)
    return replace(
        roots,
        response=both[order],
        place=places[order],
        beside=np.concatenate([roots.beside, none])[order],
        spread=spread[np.ix_(order, order)],
        change=np.concatenate([roots.change, none])[order],
        slopes=np.vstack([roots.slopes, np.zeros((m, roots.slopes.shape[1]))])[order],
        seen=np.concatenate([roots.seen, np.zeros(m, dtype=bool)])[order],
    )


#: Changes (standard deviations of ln f) that something else may make.
ANY_CHANGE = np.geomspace(3e-4, 0.3, 10)
#: The same for changes of all values alike, as of temperature, and their share of the
#: probability: small, since std_common allows for what is usual.
ALIKE, ALIKE_SHARE = (5e-3, 1.5e-2, 4e-2), 0.05
#: Change of a root that has just appeared.
_NEW = 0.1
#: Roots so far outside of what was measured (ln f) are not looked at.
_MARGIN = 0.3


class ValueLikelihood(ABC):
    """p(values of a test | severities), wherever the roots come from; and how probable other changes are."""

    #: How many severities; of the model without damage.
    n: int
    start: View
    now: Values

    @abstractmethod
    def views(self, betas: FloatArray, extra: float = 0.0) -> list[View]:
        """The values as seen from each row of severities (m, n), with an extra error of every value."""

    @abstractmethod
    def unexplained(self, betas: FloatArray) -> FloatArray:
        """How far the values are from the nearest roots at each row of severities, (m,)."""

    @abstractmethod
    def without_damage(self, extra: float, common: float) -> View:
        """The values as seen from no damage, with an extra error of each and one of all alike."""

    @abstractmethod
    def of_frequencies(self, view: View) -> NDArray[np.bool_]:
        """Which of the values that have a root in the undamaged model are frequencies."""

    @cached_property
    def something_else(self) -> float:
        """Log evidence of a change that has nothing to do with any element: of every value, by any amount,
        or of all values alike."""
        found = [self.log_without_damage(extra, 0.0) for extra in ANY_CHANGE]
        by_itself = np.logaddexp.reduce(found) - np.log(len(found))
        return float(np.logaddexp(np.log1p(-ALIKE_SHARE) + by_itself, self._alike))

    @property
    def moved_alike(self) -> float:
        """Relative change of all values, where that is what something else comes to; else 0."""
        if self.something_else > np.log(2.0) + self._alike:  # less than half of it
            return 0.0
        view = self.without_damage(0.0, ALIKE[int(np.argmax(self._shifted))])
        moved = view.residual[self.of_frequencies(view)]
        return float(np.expm1(np.median(moved))) if moved.size else 0.0

    def log_without_damage(self, extra: float, common: float) -> float:
        """The log-likelihood of that."""
        return self.without_damage(extra, common).log_likelihood

    @cached_property
    def _shifted(self) -> list[float]:
        """Log-likelihood without damage, all values moved alike by each of ``ALIKE``."""
        return [self.log_without_damage(0.0, each) for each in ALIKE]

    @property
    def _alike(self) -> float:
        """Log evidence of a change of all values alike, with its share of the probability."""
        return float(np.logaddexp.reduce(self._shifted) - np.log(len(ALIKE)) + np.log(ALIKE_SHARE))


class Likelihood(ValueLikelihood):
    """From the roots of a model after the baseline: the core's, or those of reduced models."""

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

    def unexplained(self, betas: FloatArray) -> FloatArray:
        """Distance of the values from roots as far beside the model's as the intact ones lie, (m,)."""
        left = []
        for each in self.roots(betas, slopes=False):
            roots, identity = each.since(self.error.intact)
            place = roots.log_f + np.where(identity >= 0, self._beside[identity], 0.0)
            left.append(self.now.unexplained(roots, place))
        return np.array(left)

    def near(self, roots: Roots) -> tuple[Roots, NDArray[np.intp], NDArray[np.intp]]:
        """The roots near the band, which of the intact ones these have been, and which all have been."""
        roots, followed = roots.since(self.error.intact)
        kept = roots.between(self.band.low - _MARGIN, self.band.high + _MARGIN)
        return roots.only(kept), followed[kept], followed

    def of_frequencies(self, view: View) -> NDArray[np.bool_]:
        """Which of the values that have a root in the undamaged model are frequencies."""
        return np.asarray(self.near(self._undamaged)[0].kind[view.partner[view.matched]] == 0)

    def without_damage(self, extra: float, common: float) -> View:
        """The values as seen from no damage, with an extra error of each and one of all alike."""
        return self._view(np.zeros(self.n), self._undamaged, extra, common)

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
