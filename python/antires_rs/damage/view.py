"""The values of now, seen from one point of the severities: which root each belongs to, and what it says.

Values and roots are associated twice, as their errors are stated and three times as large, and the more
probable way counts: a value that is off by many standard deviations is lost, or all of them are too small.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .association import FALSE, FOUND, FOUND_ONCE
from .measured_states import Values
from .roots import Roots

__all__ = ["ERRORS", "Band", "Foreseen", "View", "associated", "viewed"]

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
