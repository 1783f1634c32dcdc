r"""What the intact structure tells of the model's errors, and what it leaves open.

The true structure is the model with unknown factors exp(theta) on every stiffness and mass term, and every
root m has an error eps_m of its own, which no factor explains and which is there in both states:

.. math:: \ln f_m = \ln r_m(\beta, \theta) + \epsilon_m + \mathrm{noise},
          \qquad \theta \sim N(0, s^2), \quad \epsilon \sim N(0, \tau^2).

The coordinates of shapes (:mod:`~.measured_modes`) are further such values, with a tau of their
own. s and tau are learned from the baseline: under them its values are most probable (with weak priors, ``S``
and ``TAU``). theta is then estimated by the values, in Gauss-Newton steps, each with values and roots
associated anew, begun more narrowly where that does not come to rest; and what remains open of theta and eps
is carried into every prediction.

Reference: C. M. Bishop, Pattern Recognition and Machine Learning, 2006, section 3.5 (evidence).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..exceptions import InvalidInputError
from ..models.parameters import Parameter
from ..support.checks import FloatArray
from ..support.progress import step
from .measured_states import FALSE, FOUND_ONCE, Roots, Source, Values, roots_at

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..models.structural_model import StructuralModel

#: Median and logarithmic standard deviation of the priors of s and tau, of frequencies and of shapes.
S, TAU, TAU_SHAPE = (0.05, 1.5), (1e-3, 1.5), (5e-3, 1.5)
_S_GRID = np.geomspace(5e-4, 0.6, 22)
_TAU_GRID = np.geomspace(2e-6, 0.15, 18)
#: Without a baseline the roots' own errors are this share of what is assumed of the factors.
_TAU_SHARE = 0.2
#: Errors with which values and roots are associated, step by step; later ones are multiples of tau.
_FIRST = (0.1, 0.03, 0.01, 0.004)
_MULTIPLE = 3.0
#: The same for coordinates of shapes; and the least of them later on.
_FIRST_SHAPE, _LEAST_SHAPE = (0.5, 0.3, 0.2, 0.1), 0.05
#: Least and largest share of the model's error that no factor explains; and what it is where the baseline
#: has no value to spare that would tell.
_OUTSIDE, _UNTOLD = (0.01, 0.25), 0.08
_ITERATIONS, _SETTLED = 12, 1e-4
#: Share of values without a root that asks for another first association.
_LOST = 0.05
#: Largest step of ln factor in one iteration, and its bound.
_STEP, _REACH = 0.3, 1.6


@dataclass(frozen=True)
class ModelError:
    """The model after the baseline.

    Attributes
    ----------
    theta : (p,) ln factors at which the model is evaluated.
    s, tau : scatter of the factors, and of the roots' own errors; ``taus`` of frequencies and of shapes.
    intact : the undamaged model's roots there.
    partner : root of each baseline value, -1 without one; ``place`` the values as seen from there.
    spare : values beyond those that the factors took to be explained.
    mean : (p + r,) what is expected of the factors beyond ``theta``, and of the roots' own errors.
    rows : (m, p + r) slopes of the baseline's values by both; ``prior`` their prior variances, ``factor`` the
        Cholesky factor of the values' covariance.
    """

    theta: FloatArray
    s: float
    taus: FloatArray
    intact: Roots
    partner: NDArray[np.intp]
    place: FloatArray
    spare: float
    mean: FloatArray
    rows: FloatArray = field(repr=False)
    prior: FloatArray = field(repr=False)
    factor: Any = field(repr=False)

    @property
    def tau(self) -> float:
        """Scatter of the frequencies' own errors."""
        return float(self.taus[0])

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

    def predicted(
        self, slopes: FloatArray, identity: NDArray[np.intp], kind: NDArray[np.intp] | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Mean (m,) and covariance (m, m) of ln f of roots, beyond the model's.

        ``slopes`` (m, p) are by theta, ``identity`` (m,) the roots' numbers in the intact state, -1 for new
        ones; ``kind`` is 0 for frequencies, which is the default, 1 for shapes.
        """
        from scipy.linalg import cho_solve

        rows = np.zeros((identity.size, self.prior.size))
        rows[:, : self.theta.size] = slopes
        old = np.flatnonzero(identity >= 0)
        rows[old, self.theta.size + identity[old]] = 1.0
        spread = (rows * self.prior) @ rows.T
        if self.rows.size:
            cross = (rows * self.prior) @ self.rows.T
            spread -= cross @ cho_solve(self.factor, cross.T)
        new = np.flatnonzero(identity < 0)
        spread[new, new] += self.tau**2 if kind is None else self.taus[kind[new]] ** 2
        return rows @ self.mean, spread


def learned(
    core: Source | _core.Objective,
    n_elements: int,
    n_factors: int,
    values: Values,
    assumed: float | None,
    threads: int,
) -> ModelError:
    """Theta, s and taus from the baseline; ``assumed`` is s where it is not to be learned."""
    theta = np.zeros(n_factors)
    s, taus = S[0], np.array([TAU[0], TAU_SHAPE[0]])
    if assumed is not None:
        s, taus = assumed, np.full(2, _TAU_SHARE * assumed)
    intact, slopes = _undamaged(core, n_elements, theta, threads)
    if not values.size:
        prior = np.concatenate([np.full(n_factors, s**2), taus[intact.kind] ** 2])
        nothing = np.empty((0, prior.size))
        partner = np.empty(0, dtype=np.intp)
        mean = np.zeros(prior.size)
        return ModelError(theta, s, taus, intact, partner, values.log_f, 0.0, mean, nothing, prior, None)

    def undamaged(theta: FloatArray) -> tuple[Roots, FloatArray]:
        return _undamaged(core, n_elements, theta, threads)

    begin = _Begin(s, taus, intact, slopes, assumed is None)
    found, log_evidence, settled = _from(0, begin, values, undamaged)
    lost = np.count_nonzero(found.partner < 0)
    if settled and lost <= max(1, _LOST * values.size):
        return found
    # Among many roots a wide first association may join a whole run of values to their neighbours, which
    # wild factors then explain: the others begin narrower, and what makes the values most probable counts.
    for first in range(1, len(_FIRST) - 1):
        step("learning the model's errors again")
        other, its_evidence, _ = _from(first, begin, values, undamaged)
        if its_evidence > log_evidence:
            found, log_evidence = other, its_evidence
    return found


@dataclass(frozen=True)
class _Begin:
    """What is assumed, the roots of the model as it is with their slopes, and whether scales are learned."""

    s: float
    taus: FloatArray
    intact: Roots
    slopes: FloatArray
    scales: bool


def _from(
    first: int, begin: _Begin, values: Values, undamaged: Callable[[FloatArray], tuple[Roots, FloatArray]]
) -> tuple[ModelError, float, bool]:
    """The errors learned from one width of the first association, the log evidence, whether it settled."""
    from scipy.linalg import cho_solve

    s, taus, intact, slopes = begin.s, begin.taus, begin.intact, begin.slopes
    n_factors = slopes.shape[1]
    theta, settled = np.zeros(n_factors), False
    for nth in range(first, _ITERATIONS + first):
        partner, place = _partners(values, intact, _spread(nth, taus)[intact.kind])
        std = values.std[partner >= 0]
        rows, y = _observed(place, intact, slopes, partner, theta)
        kind = intact.kind
        if begin.scales:
            s, taus = _scales(rows, y, std, n_factors, kind)
        factor, prior = _factored(rows, std, s, taus[kind])
        step_by = (prior * (rows.T @ cho_solve(factor, y)))[:n_factors] - theta
        theta = np.clip(theta + np.clip(step_by, -_STEP, _STEP), -_REACH, _REACH)
        intact, slopes = undamaged(theta)
        if nth >= len(_FIRST) and np.abs(step_by).max(initial=0.0) < _SETTLED:
            settled = True
            break
    partner, place = _partners(values, intact, _spread(len(_FIRST), taus)[intact.kind])
    rows, y = _observed(place, intact, slopes, partner, theta)
    factor, prior = _factored(rows, values.std[partner >= 0], s, taus[intact.kind])
    mean = prior * (rows.T @ cho_solve(factor, y))
    log_evidence = -0.5 * float(y @ cho_solve(factor, y)) - float(np.log(np.diag(factor[0])).sum())
    log_evidence -= 0.5 * y.size * float(np.log(2.0 * np.pi)) + (values.size - y.size) * _alone(values)
    mean[:n_factors] -= theta
    by_factors = (rows[:, :n_factors] * s) @ (rows[:, :n_factors] * s).T
    spare = y.size - float(np.trace(cho_solve(factor, by_factors)))
    found = ModelError(theta, s, taus, intact, partner, place, spare, mean, rows, prior, factor)
    return found, log_evidence, settled


def _spread(nth: int, taus: FloatArray) -> FloatArray:
    """Errors of frequencies and of shapes in the association."""
    if nth < len(_FIRST):
        return np.array([_FIRST[nth], _FIRST_SHAPE[nth]])
    return np.maximum(_MULTIPLE * taus, [0.0, _LEAST_SHAPE])


def _partners(values: Values, intact: Roots, spread: FloatArray) -> tuple[NDArray[np.intp], FloatArray]:
    """Root of each value, and the values as seen from there."""
    inside = (intact.kind == 0) & intact.between(values.frequencies.min(), values.frequencies.max())
    missed = np.where(inside, -np.log(1.0 - FOUND_ONCE), 0.0)
    return values.associated(intact, intact.log_f, spread, _alone(values), missed)[:2]


def _alone(values: Values) -> float:
    """Price of a value without a root: a false one, anywhere in the band."""
    width = values.frequencies.max() - values.frequencies.min()
    return -float(np.log(FALSE / max(width, 0.1)))


def _undamaged(
    core: Source | _core.Objective, n_elements: int, theta: FloatArray, threads: int
) -> tuple[Roots, FloatArray]:
    """The roots, and their slopes by theta."""
    x = np.concatenate([np.zeros(n_elements), np.exp(theta)])
    found = roots_at(core, x[None], slopes=True, threads=threads)[0]
    return found, found.slopes[:, n_elements:] * np.exp(theta)


def _observed(
    place: FloatArray, intact: Roots, slopes: FloatArray, partner: NDArray[np.intp], theta: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Rows by theta and eps, and what they give: ln f_I - ln r + J theta."""
    has = np.flatnonzero(partner >= 0)
    root = partner[has]
    rows = np.zeros((has.size, theta.size + intact.size))
    rows[:, : theta.size] = slopes[root]
    rows[np.arange(has.size), theta.size + root] = 1.0
    return rows, place[has] - intact.log_f[root] + slopes[root] @ theta


def _factored(rows: FloatArray, std: FloatArray, s: float, own: FloatArray) -> tuple[Any, FloatArray]:
    """Cholesky factor of the values' covariance, and the prior variances of theta and eps."""
    from scipy.linalg import cho_factor

    prior = np.concatenate([np.full(rows.shape[1] - own.size, s**2), own**2])
    return cho_factor((rows * prior) @ rows.T + np.diag(std**2), lower=True), prior


def _scales(
    rows: FloatArray, y: FloatArray, std: FloatArray, n: int, kind: NDArray[np.intp]
) -> tuple[float, FloatArray]:
    """s and the taus under which y is most probable, by turns on their grids."""
    from scipy.linalg import cho_factor, cho_solve

    own = rows[:, n:]
    parts = [rows[:, :n] @ rows[:, :n].T]
    parts += [own[:, kind == each] @ own[:, kind == each].T for each in np.unique(kind)]
    priors = [S, TAU, TAU_SHAPE]
    noise = np.diag(std**2)

    def log_evidence(scales: list[float]) -> float:
        spread = scales[0] ** 2 * parts[0]
        for scale, part in zip(scales[1:], parts[1:], strict=True):
            spread = spread + scale**2 * part
        factor = cho_factor(spread + noise, lower=True)
        prior = sum((np.log(x / p[0]) / p[1]) ** 2 for x, p in zip(scales, priors, strict=False))
        return float(-0.5 * (y @ cho_solve(factor, y) + prior) - np.sum(np.log(np.diag(factor[0]))))

    scales = [p[0] for p, _ in zip(priors, parts, strict=False)]
    grids = [_S_GRID, _TAU_GRID, _TAU_GRID]
    while True:
        before = list(scales)
        for nth, _ in enumerate(parts):
            trial = [[*scales[:nth], each, *scales[nth + 1 :]] for each in grids[nth].tolist()]
            scales = max(trial, key=log_evidence)
        if scales == before:
            return scales[0], np.array([*scales[1:], TAU_SHAPE[0]][:2])


# -- What may be wrong in a model: a factor on every stiffness and every mass term


#: Bounds of a factor, exp(-1.6) to exp(1.6): no model of an engineer is as wrong as that.
BOUNDS = (0.2, 5.0)


def factors_of(model: StructuralModel) -> tuple[Parameter, ...]:
    """A factor for each stiffness and mass term that is not zero."""
    stiffness = [Parameter("stiffness_factor", (term,), BOUNDS) for term in model._springs]
    mass = [Parameter("mass_factor", (term,), BOUNDS) for term in range(model._core.n_mass_terms)]
    return _governing(model, (*stiffness, *mass))


def _governing(model: StructuralModel, factors: tuple[Parameter, ...]) -> tuple[Parameter, ...]:
    """Those that may be anywhere within their bounds: all, or halves of them looked at anew."""
    if not factors or _governs(model, factors):
        return factors
    half = len(factors) // 2
    if not half:  # a term that is zero, or without which nothing holds together
        return ()
    return _governing(model, factors[:half]) + _governing(model, factors[half:])


def _governs(model: StructuralModel, factors: tuple[Parameter, ...]) -> bool:
    low, high = (np.full(len(factors), bound) for bound in BOUNDS)
    try:
        parts = model.description.core_parameters(factors)
        _core.check_bounds(model._core, parts, low, high)
    except InvalidInputError:
        return False
    return True
