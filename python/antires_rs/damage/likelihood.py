"""What is asked of two states: the model's errors as the intact one tells them, and the likelihood of now.

The page on theory has the formulas. The coordinates of shapes (:mod:`~.measured_modes`) are further values,
with a tau of their own. theta is estimated in Gauss-Newton steps, each with values and roots associated anew;
what remains open of theta and eps is carried into every prediction. kappa, the error of a predicted change
that no factor of the model explains, is a multiple of the share of the baseline's misfit that no factor
explained (tau / s), summed over ``ERRORS``.

Reference: C. M. Bishop, Pattern Recognition and Machine Learning, 2006, section 3.5 (evidence).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from operator import itemgetter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..exceptions import InvalidInputError, reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.parameters import Parameter, stiffness_reduction
from ..support.checks import FloatArray, members
from ..support.progress import step
from ..updating.problem import hint_of
from ..updating.targets import targets_of
from .hypotheses import figure
from .measured_modes import ModeResponses, ModeRoots, measured_modes
from .measured_states import (
    FOUND,
    FOUND_ONCE,
    Contradiction,
    Responses,
    Roots,
    Source,
    Values,
    contradiction,
    measured_states,
    moved_alike,
    price_alone,
    roots_at,
    scatter_between,
    without_shifts,
)
from .options import DamagePrior, SearchOptions
from .reduced_roots import ReducedRoots, Terms
from .shapes import BOUNDS, Chain, Joined, Structure, joined, parameters_of, structure_of

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

Core = Source | _core.Objective

# -- What may be wrong in a model: a factor on every stiffness and every mass term


def factors_of(model: StructuralModel, factors: tuple[Parameter, ...] | None = None) -> tuple[Parameter, ...]:
    """A factor for each stiffness and mass term that is not zero; of some ``factors`` those that may be
    anywhere within their bounds."""
    if factors is None:
        stiffness = [Parameter("stiffness_factor", (term,), BOUNDS) for term in model._springs]
        mass = [Parameter("mass_factor", (term,), BOUNDS) for term in model._masses]
        factors = (*stiffness, *mass)
    try:
        low, high = (np.full(len(factors), bound) for bound in BOUNDS)
        _core.check_bounds(model._core, model.description.core_parameters(factors), low, high)
        return factors
    except InvalidInputError:
        half = len(factors) // 2
        if not half:  # a term that is zero, or without which nothing holds together
            return ()
        return factors_of(model, factors[:half]) + factors_of(model, factors[half:])


#: Standard deviations of ln factor that the surroundings make: temperature of all and along the longer side,
#: supports, masses.
_WARMER, _ON_ONE_SIDE, _SUPPORTS, _LADEN = 0.02, 0.01, 0.1, 0.02
_LOOSE = 0.8  # a joint has not lost more where its warmth is judged


def surroundings(
    elements: set[int],
    n_terms: int,
    joints: Sequence[int],
    factors: Sequence[Parameter],
    values: FloatArray,
    named: Sequence[str],
    along: FloatArray | None,
) -> FloatArray:
    """Changes of ln factor (p, k) that go together, of standard deviation 1 each, where factors have these
    ``values``; of the model's ``n_terms`` of stiffness these are ``elements``, the others springs, and terms
    behind them ``joints``; ``along`` is the place of each term between -1 and 1."""
    stiff = [p.terms[0] if p.quantity == "stiffness_factor" else -1 for p in factors]
    warm = np.array([float(term in elements) for term in stiff])
    held = np.array([float(0 <= term < n_terms and term not in elements) for term in stiff])
    # A joint turns by the same angle for the same moment, however stiff the beam that it holds.
    lost = np.where(np.isin(stiff, joints), np.clip(1.0 - values, 0.0, _LOOSE), 0.0)
    warm -= lost * (2.0 - lost) / (1.0 - lost)
    columns = []
    if "temperature" in named:
        columns.append(_WARMER * warm)
        if along is not None:
            places = [along[term] if 0 <= term < along.size else 0.0 for term in stiff]
            columns.append(_ON_ONE_SIDE * warm * np.array(places))
    if "supports" in named:
        columns.append(_SUPPORTS * held)
    if "mass" in named:
        columns.append(_LADEN * np.array([float(p.quantity == "mass_factor") for p in factors]))
    return np.array(columns).reshape(-1, len(factors)).T


# -- What the baseline tells of the errors

#: Median and logarithmic standard deviation of the priors of s, of factors and of what joints and supports
#: yield, and of tau, of frequencies and of shapes.
S, S_JOINTS, TAU, TAU_SHAPE = (0.05, 1.5), (0.05, 1.5), (1e-3, 1.5), (5e-3, 1.5)
_MUCH = 10.0  # multiple of that scatter of joints from which on it is learned too
_S_GRID = np.geomspace(5e-4, 0.6, 22)
_TAU_GRID = np.geomspace(2e-6, 0.15, 18)
_TAU_SHARE = 0.2  # without a baseline the roots' own errors are this share of what is assumed of the factors
#: Errors with which values and roots are associated, step by step; later ones are multiples of tau.
_FIRST = (0.1, 0.03, 0.01, 0.004)
_MULTIPLE = 3.0
#: The same for coordinates of shapes; and the least of them later on.
_FIRST_SHAPE, _LEAST_SHAPE = (0.5, 0.3, 0.2, 0.1), 0.05
#: Least and largest share of the model's error that no factor explains; and what it is where the baseline
#: has no value to spare that would tell.
_OUTSIDE, _UNTOLD = (0.01, 0.25), 0.08
_ITERATIONS, _SETTLED = 12, 1e-4
#: The least of that share where the model lacks what its joints yield: it lacks more than that.
_LACKING = 0.05
#: ln of what joints and supports keep to begin with; so many of these that lead nearest to the values count.
_YIELDING, _NEAREST = np.array([0.0, -0.3, -0.6, -0.8, -1.0, -1.2, -1.5, -1.8]), 2
#: A model with more scatter of its factors, or a larger error beside them, may lack something else; what its
#: joints yield is believed where it makes the values so much more probable (ln).
_DOUBTED_S, _DOUBTED_TAU, _CLEARLY = 0.06, 2e-3, 4.0
#: The same of a base, and values for each mass that tell of it: a measured frame with three storeys gains 4.
_PLAINLY, _TELLING = 8.0, 2
#: A model with one support more makes the values so much more probable (ln) than all that it may learn: it
#: lacks that. Set on the portal and the propped beam of reference/forgotten_supports.py.
_FORGOTTEN = 10.0
_LOST = 0.05  # share of values without a root that asks for another first association
_YIELDS = 1.0  # the bound of what joints of chains and matrices may yield
_STEP, _REACH = 0.3, 1.6  # largest step of ln factor in one iteration, and its bound


@dataclass(frozen=True)
class ModelError:
    """The model after the baseline: p factors, r roots, m values of the intact structure."""

    theta: FloatArray  # ln factors at which the model is evaluated, (p,)
    s: float  # scatter of stiffness and mass factors
    taus: FloatArray  # scatter of the own errors of frequencies and of shapes
    intact: Roots  # the undamaged model's
    partner: NDArray[np.intp]  # root of each value, -1 without one
    place: FloatArray  # the values as seen from there
    spare: float  # values beyond those that the factors took to be explained
    mean: FloatArray  # expected of the factors beyond theta and of the roots' own errors, (p + r,)
    rows: FloatArray = field(repr=False)  # slopes of the values by both, (m, p + r)
    prior: FloatArray = field(repr=False)  # variances of both
    factor: Any = field(repr=False)  # Cholesky factor of the values' covariance
    log_evidence: float = 0.0
    lost: int = 0  # values without a root
    lacking: bool = False  # whether the model lacks what its joints and supports yield
    unlearned: float = 0.0  # error of every loss over the size of all, in u, by masses that no factor has

    @property
    def tau(self) -> float:
        """Scatter of the frequencies' own errors."""
        return float(self.taus[0])

    @property
    def gain_std(self) -> float:
        """Relative error of a loss, in u, beside what the baseline leaves of the factors."""
        return _GAIN_ERROR * self.s * (1.0 if self.lacking else min(1.0, self.tau / _FULLY) ** 2)

    @property
    def doubtful(self) -> bool:
        """Whether the model may lack more than factors of its stiffnesses and masses."""
        return self.s > _DOUBTED_S or self.tau > _DOUBTED_TAU or self.lost > 0

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
        return float(np.clip(share, _LACKING if self.lacking else _OUTSIDE[0], _OUTSIDE[1]))

    def predicted(
        self, slopes: FloatArray, identity: NDArray[np.intp], kind: NDArray[np.intp] | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Mean (m,) and covariance (m, m) of ln f of roots, beyond the model's; slopes (m, p) by theta."""
        from scipy.linalg import cho_solve

        rows = rows_of(slopes, identity, self.intact)
        spread = (rows * self.prior) @ rows.T
        if self.rows.size:
            cross = (rows * self.prior) @ self.rows.T
            spread -= cross @ cho_solve(self.factor, cross.T)
        new = np.flatnonzero(identity < 0)
        spread[new, new] += self.tau**2 if kind is None else self.taus[kind[new]] ** 2
        return rows @ self.mean, spread


def rows_of(slopes: FloatArray, identity: NDArray[np.intp], intact: Roots) -> FloatArray:
    """Slopes of roots by theta (m, p) and by the intact roots' own errors; -1 for what is none of these."""
    own = np.zeros((identity.size, intact.size))
    old = np.flatnonzero(identity >= 0)
    own[old, identity[old]] = 1.0
    return np.hstack([slopes, own])


def learned(
    core: Core,
    n_elements: int,
    group: NDArray[np.intp],
    values: Values,
    assumed: float | None,
    threads: int,
    low: FloatArray | None = None,
) -> ModelError:
    """Theta, s and taus from the baseline; ``assumed`` is s where it is not to be learned. Factors of one
    ``group`` (p,) have one scatter: 0 of stiffness and mass, 1 of joints and supports; ``low`` (p,) are
    their lower bounds (ln)."""
    n_factors = group.size
    low = np.full(n_factors, -_REACH) if low is None else low

    def undamaged(theta: FloatArray) -> tuple[Roots, FloatArray]:
        """The roots, and their slopes by theta."""
        x = np.concatenate([np.zeros(n_elements), np.exp(theta)])
        found = roots_at(core, x[None], slopes=True, threads=threads)[0]
        return found, found.slopes[:, n_elements:] * np.exp(theta)

    theta, s = np.zeros(n_factors), np.array([S[0], S_JOINTS[0]])[: int(group.max(initial=0)) + 1]
    taus = np.array([TAU[0], TAU_SHAPE[0]])
    if assumed is not None:
        s, taus = np.full(s.size, assumed), np.full(2, _TAU_SHARE * assumed)
    if not values.size:
        intact, _ = undamaged(theta)
        prior = np.concatenate([s[group] ** 2, taus[intact.kind] ** 2])
        none, partner = np.empty((0, prior.size)), np.empty(0, dtype=np.intp)
        untold = 0.0, np.zeros(prior.size), none, prior, None
        return ModelError(theta, float(s[0]), taus, intact, partner, values.log_f, *untold)
    fixed = assumed is not None
    rest = group, low, s, taus, fixed, values, undamaged
    starts = [theta]
    if group.any():
        rows = np.maximum(np.where(group == 1, _YIELDING[:, None], 0.0), low)
        x = np.hstack([np.zeros((len(rows), n_elements)), np.exp(rows)])
        seen = roots_at(core, x, slopes=False, threads=threads)
        left = [values.plain.unexplained(roots, roots.log_f) for roots in seen]
        starts = list(rows[np.argsort(left, kind="stable")[:_NEAREST]])
    found, log_evidence, settled = _from(0, starts[0], *rest)
    lost = np.count_nonzero(found.partner < 0)
    if settled and lost <= max(1, _LOST * values.size):
        return found
    # Among many roots a wide first association may join a whole run of values to their neighbours, which
    # wild factors then explain: the others begin narrower, and what makes the values most probable counts.
    # And where joints yield much, values are so far from the model's that they join others.
    more = [(first, start) for start in starts for first in range(len(_FIRST) - 1)]
    for first, start in more[1:]:
        step("learning the model's errors again")
        other, its_evidence, _ = _from(first, start, *rest)
        if its_evidence > log_evidence:
            found, log_evidence = other, its_evidence
    return found


def _from(
    first: int,
    theta: FloatArray,
    group: NDArray[np.intp],
    least: FloatArray,
    s: FloatArray,
    taus: FloatArray,
    fixed: bool,
    values: Values,
    undamaged: Callable[[FloatArray], tuple[Roots, FloatArray]],
) -> tuple[ModelError, float, bool]:
    """The errors learned from one width of the first association, the log evidence, whether it settled;
    s and taus are ``fixed`` where they are not to be learned."""
    from scipy.linalg import cho_factor, cho_solve

    def solved(b: FloatArray) -> FloatArray:
        """By the factor of this round; nothing where no value has a partner, which SciPy 1.12 refuses."""
        return cho_solve(factor, b) if b.size else b

    plain = values.plain.log_f
    low, high = plain.min(), plain.max()
    n, settled = theta.size, False
    for nth in range(first, _ITERATIONS + first + 1):
        intact, slopes = undamaged(theta)
        last = settled or nth == _ITERATIONS + first
        at = len(_FIRST) if last else nth
        if at < len(_FIRST):
            spread = np.array([_FIRST[at], _FIRST_SHAPE[at]])
        else:
            spread = np.maximum(_MULTIPLE * taus, [0.0, _LEAST_SHAPE])
        inside = (intact.kind == 0) & intact.between(low, high)
        missed = np.where(inside, -np.log(1.0 - FOUND_ONCE), 0.0)
        alone = price_alone(low, high)
        partner, place, _ = values.associated(intact, intact.log_f, spread[intact.kind], alone, missed)
        # Rows by theta and eps, and what they give: ln f_I - ln r + J theta.
        has = np.flatnonzero(partner >= 0)
        root, std = partner[has], values.std[has]
        rows = rows_of(slopes[root], root, intact)
        y = place[has] - intact.log_f[root] + slopes[root] @ theta
        if has.size and not fixed and not last:
            s, taus = _scales(rows, y, std, group, intact.kind)
        prior = np.concatenate([s[group] ** 2, taus[intact.kind] ** 2])
        factor = cho_factor((rows * prior) @ rows.T + np.diag(std**2), lower=True)
        mean = prior * (rows.T @ solved(y))
        if last:
            break
        step_by = mean[:n] - theta
        theta = np.clip(theta + np.clip(step_by, -_STEP, _STEP), least, _REACH)
        settled = nth >= len(_FIRST) and bool(np.abs(step_by).max(initial=0.0) < _SETTLED)
    log_evidence = -0.5 * float(y @ solved(y)) - float(np.log(np.diag(factor[0])).sum())
    log_evidence -= 0.5 * y.size * float(np.log(2.0 * np.pi)) + (values.size - y.size) * alone
    mean[:n] -= theta
    by_factors = (rows[:, :n] * s[group]) @ (rows[:, :n] * s[group]).T
    spare = y.size - float(np.trace(solved(by_factors)))
    lost = values.size - y.size
    log_evidence -= 0.5 * float(np.sum((np.log(s / np.array([S[0], S_JOINTS[0]])[: s.size]) / S[1]) ** 2))
    rest = mean, rows, prior, factor, log_evidence, lost
    found = ModelError(theta, float(s[0]), taus, intact, partner, place, spare, *rest)
    return found, log_evidence, settled


def _scales(
    rows: FloatArray, y: FloatArray, std: FloatArray, group: NDArray[np.intp], kind: NDArray[np.intp]
) -> tuple[FloatArray, FloatArray]:
    """s of each group and the taus under which y is most probable, by turns on their grids."""
    from scipy.linalg.lapack import dtrtrs

    theta, own = rows[:, : group.size], rows[:, group.size :]
    n_groups = int(group.max(initial=0)) + 1
    parts = [theta[:, group == each] @ theta[:, group == each].T for each in range(n_groups)]
    parts += [own[:, kind == each] @ own[:, kind == each].T for each in np.unique(kind)]
    priors = [*(S, S_JOINTS)[:n_groups], *(TAU, TAU_SHAPE)[: len(parts) - n_groups]]
    noise = np.diag(std**2)

    @cache
    def likeliest(nth: int, others: tuple[float, ...]) -> tuple[float, float]:
        """The scale of one part that makes y most probable beside ``others``, 0 in its place; and how
        probable (ln)."""
        rest = noise + sum(scale**2 * part for scale, part in zip(others, parts, strict=True))
        # With the rest whitened and this part diagonal, each value of the grid is a sum.
        triangle = np.linalg.cholesky(rest)
        half = dtrtrs(triangle, parts[nth], lower=1)[0]
        sizes, ways = np.linalg.eigh(dtrtrs(triangle, half.T, lower=1)[0])
        grid = _S_GRID if nth < n_groups else _TAU_GRID
        spread = 1.0 + grid[:, None] ** 2 * np.maximum(sizes, 0.0)
        square = (dtrtrs(triangle, y, lower=1)[0] @ ways) ** 2
        logs = -0.5 * np.sum(square / spread + np.log(spread), axis=1) - np.log(np.diag(triangle)).sum()
        known = [(np.log(x / p[0]) / p[1]) ** 2 for x, p in zip(others, priors, strict=True) if x]
        logs -= 0.5 * (sum(known) + (np.log(grid / priors[nth][0]) / priors[nth][1]) ** 2)
        best = int(np.argmax(logs))
        return float(grid[best]), float(logs[best])

    # By turns either group may take what is of the other: of joints it is begun from more as well.
    found = []
    for more in (1.0, _MUCH)[:n_groups]:
        scales = [p[0] * (more if nth == 1 else 1.0) for nth, p in enumerate(priors)]
        before: list[float] = []
        while scales != before:
            before = list(scales)
            for nth, _ in enumerate(parts):
                scales[nth] = 0.0
                scales[nth], log_evidence = likeliest(nth, tuple(scales))
        found.append((log_evidence, scales))
    _, scales = max(found, key=itemgetter(0))
    return np.array(scales[:n_groups]), np.array([*scales[n_groups:], TAU_SHAPE[0]][:2])


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
#: A change of all values alike, and one of temperature, may come with any hypothesis: the former's standard
#: deviation (ln f), the share of the probability of each, and the errors beside which they are looked at.
ALIKE_STD, _WITH_ALIKE, _BESIDE_ALIKE = 0.015, 0.025, ((0.0, 1.0), (0.5, 1.0), (1.0, 1.0), (1.0, 2.0))
_WARM, MANY = 2, 3  # which of the ways it is; and beside how many losses temperature is not looked at
#: Where a model is wrong in more than factors, its modes strain other elements than the structure's: a change
#: is wrong along the slopes of all elements. The size of that error over that of the change (root mean
#: square), its share of the probability, and the errors beside which it is looked at. Set on building.
_MIXED, _WITH_MIXED, _BESIDE_MIXED = (0.1, 0.3), 0.3, ((0.5, 1.0), (1.0, 1.0), (1.6, 1.0))
#: Error of a loss that the model's error makes, in u = -ln(1 - beta): so many times u and the scatter of the
#: factors, since what a wrong model lacks is not seen in how it explains the baseline; and the error of a
#: frequency beside the factors from which on all of it counts.
_GAIN_ERROR, _FULLY = 0.7, 1.5e-3
#: The same, and what other elements seem to lose beside it, where no factor has the masses: what is wrong in
#: them is not learned. Set on the first damages of six_storey_frame in benchmarks/fe_cases.py.
_UNLEARNED = 0.02
#: Share of the mean square of all changes that counts in the error of each one, however small its own.
_COMMON = 0.5
#: In the association, before anything is known of kappa; and by how much all errors are widened.
_FIRST_KAPPA, _WIDER = 0.1, (1.0, 3.0)
_EDGE = 0.06  # over so much of ln f from the edges of what was measured on, a root is ever more surely found


@dataclass(frozen=True)
class View:
    """The values of now (m,), seen from some severities (n,): all that is linear from there."""

    beta: FloatArray
    log_likelihood: float
    gain: FloatArray  # gradient of the log-likelihood by all severities
    curvature: FloatArray  # its Gauss-Newton Hessian
    kappa: float  # most probable error of predictions
    times: float  # most probable multiple of the standard deviations
    partner: NDArray[np.intp]  # root of each value, -1 without one
    beside: FloatArray  # how far that root lies beside the model's in the measured structure, ln f
    residual: FloatArray  # of the values that have a root, ln f
    std: FloatArray
    chi_square: float
    shift: float = 0.0  # of all values alike, ln f, where such a change is part of the most probable error
    gain_std: float = 0.0  # relative error of a loss (u) by that of the model
    #: What of the surroundings has changed, in the most probable error, in standard deviations.
    felt: FloatArray = field(default_factory=lambda: np.zeros(0))

    @property
    def gains(self) -> FloatArray:
        """What each severity would add to the log-likelihood, to second order, (n,)."""
        return 0.5 * np.clip(self.gain, 0.0, None) ** 2 / np.maximum(np.diag(self.curvature), 1e-300)

    @property
    def n_matched(self) -> int:
        """How many values have a root."""
        return int((self.partner >= 0).sum())


class Band(NamedTuple):
    """Where values were looked for, ln f."""

    low: float
    high: float


class Foreseen(NamedTuple):
    """Roots (r,) as they are expected in the measured structure at some severities."""

    roots: Roots
    place: FloatArray  # ln f
    beside: FloatArray  # less the model's
    spread: FloatArray  # covariance, (r, r)
    change: FloatArray  # from the intact state
    seen: NDArray[np.bool_]  # in the intact state
    gain_std: float  # relative error of a loss (u)
    n_elements: int  # first columns of the slopes
    #: Changes of all of standard deviation 1: all alike, by temperature, by the environment, (r, 1 + k).
    together: FloatArray
    n_warm: int  # of these by temperature
    shift: FloatArray  # what those that were found come to; place is without it
    known: FloatArray  # variance that they leave no more


def viewed(beta: FloatArray, now: Values, roots: Foreseen, band: Band, errors: FloatArray) -> View:
    """The most probable of the ways to associate values and roots."""
    change = roots.change + roots.shift
    variance = np.maximum(np.diag(roots.spread) - roots.known, 0.0) + (_FIRST_KAPPA * change) ** 2
    ways = [(np.sqrt(variance), wider) for wider in _WIDER]
    ambient = roots.together[:, 1 + roots.n_warm :]
    if ambient.shape[1] and not roots.known.any():  # as if the surroundings had not changed, too
        ways.insert(0, (np.sqrt(np.maximum(variance - np.sum(ambient**2, axis=1), 0.0)), 1.0))
    found: list[View] = []
    before: NDArray[np.intp] | None = None
    while ways:
        sigma, wider = ways.pop(0)
        partner, place, price = associated(now, roots, band, sigma, wider)
        if before is None or not np.array_equal(partner, before):
            found.append(_judged(beta, now, place, roots, partner, price, errors))
        if not ways and wider > 1.0 and (partner < 0).any():  # all may have moved alike
            ways.append((np.sqrt(variance + (roots.roots.kind == 0) * ALIKE_STD**2), 1.0))
        before = partner
    return max(found, key=lambda view: view.log_likelihood)


def associated(
    now: Values, roots: Foreseen, band: Band, sigma: FloatArray, wider: float
) -> tuple[NDArray[np.intp], FloatArray, float]:
    """Root of each value, the values as seen from there, and what those without a partner cost."""
    expected = roots.place + roots.shift
    # Near the edges of the band nobody knows whether a root would have been found; a shape is or is not.
    inside = np.clip(np.minimum(expected - band.low, band.high - expected) / _EDGE, 0.0, 1.0)
    found = np.where(roots.seen, FOUND, FOUND_ONCE)
    missed, present = np.where(roots.roots.kind == 0, -inside * np.log([1.0 - found, found]), 0.0)
    alone = price_alone(*band)
    partner, place, lost = now.associated(roots.roots, expected, sigma, alone, missed - present, wider)
    taken = partner[partner >= 0]
    price = lost + now.times_measured(roots.roots.response) @ missed - (missed - present)[taken].sum()
    return partner, place, float(price)


def _judged(
    beta: FloatArray,
    now: Values,
    place: FloatArray,
    roots: Foreseen,
    partner: NDArray[np.intp],
    price: float,
    errors: FloatArray,
) -> View:
    """Likelihood and slopes, for one way to associate."""
    from scipy.linalg.lapack import dtrtrs

    has = np.flatnonzero(partner >= 0)
    root = partner[has]
    residual = place[has] - roots.place[root]
    model, noise = roots.spread[np.ix_(root, root)], np.diag(now.std[has] ** 2)
    change = (roots.change + roots.shift)[root]
    kind = roots.roots.kind[root]
    usual = np.bincount(kind, change**2) / np.maximum(np.bincount(kind), 1)  # mean square of each kind
    size = np.sqrt(change**2 + _COMMON * usual[kind])
    # Two tests of one state share the error of a root's change.
    unmodelled = (root[:, None] == root) * np.outer(size, size)
    kappa, times, mixed = errors.T[:3, :, None, None]
    spread = model + times**2 * noise + kappa**2 * unmodelled
    by_elements = roots.roots.slopes[root, : roots.n_elements] * (1.0 - beta[: roots.n_elements])
    along = by_elements @ by_elements.T
    if has.size and mixed.any() and (total := float(np.trace(along))) > 0.0:
        spread = spread + mixed**2 * along * (float(np.sum(change**2)) / total)
    triangles = np.linalg.cholesky(spread)
    n_common, together = 1 + roots.n_warm, roots.together[root]
    ways = (together[:, :0], together[:, :1], together[:, 1:n_common])
    sides = np.hstack([residual[:, None], together[:, :n_common]])
    # A row-major lower triangle is a column-major upper one.
    solved = [dtrtrs(each.T, sides, trans=1)[0] for each in triangles] if has.size else []
    whole = np.reshape(solved, (len(errors), has.size, 1 + n_common))
    squares = whole.transpose(0, 2, 1) @ whole
    log_diagonal = np.log(np.diagonal(triangles, axis1=1, axis2=2)).sum(axis=1)
    logs = errors.T[3:] - log_diagonal - 0.5 * squares[:, 0, 0]
    logs[1] += _gained(squares, range(1, 2))
    logs[_WARM] += _gained(squares, range(2, 1 + n_common))
    way, best = divmod(int(np.argmax(logs)), len(errors))
    triangle, white = triangles[best], whole[best, :, 0]
    if way and has.size:
        triangle = np.linalg.cholesky(spread[best] + ways[way] @ ways[way].T)
        white = dtrtrs(triangle.T, residual, trans=1)[0]
    slopes = roots.roots.slopes[root, : beta.size]
    slope = dtrtrs(triangle.T, slopes, trans=1)[0] if has.size else slopes
    beside = np.zeros(now.size)
    beside[has] = roots.beside[root]
    shift, felt = 0.0, np.zeros(together.shape[1] - 1)
    if has.size and (way or n_common < together.shape[1]):
        pull = dtrtrs(triangle.T, white)[0]
        felt = together[:, 1:].T @ pull
        felt[: roots.n_warm] *= way == _WARM
        moved = ways[way] @ (ways[way].T @ pull)
        shift = float(np.median(moved[kind == 0])) if way else 0.0
    price += 0.5 * has.size * float(np.log(2.0 * np.pi))
    return View(
        beta=beta,
        log_likelihood=float(np.logaddexp.reduce(logs, axis=None)) - price,
        gain=slope.T @ white,
        curvature=slope.T @ slope,
        kappa=float(errors[best, 0]),
        times=float(errors[best, 1]),
        partner=partner,
        beside=beside,
        residual=residual,
        std=np.linalg.norm(triangle, axis=1),
        chi_square=float(white @ white),
        shift=shift,
        gain_std=roots.gain_std,
        felt=felt,
    )


def _gained(squares: FloatArray, columns: Iterable[int]) -> FloatArray:
    """What a density gains (ln) where changes of standard deviation 1 may come to values: products (e, k, k)
    of residuals, the first, and changes, all made independent, and which of these it is."""
    left, gained = squares, 0.5 * squares[:, 0, 0]
    for column in columns:
        own = left[:, column]
        size = 1.0 + own[:, column]
        left = left - own[:, :, None] * (own / size[:, None])[:, None]
        gained = gained - 0.5 * np.log(size)
    return gained - 0.5 * left[:, 0, 0]


def all_errors(outside: float, with_mixed: float) -> FloatArray:
    """Rows of kappa, multiple of the standard deviations, and the share of a change that is wrong along the
    slopes of all elements, which has the probability ``with_mixed``; ln of the probability of each, alone,
    where all values may move alike as well, and where they may by temperature; ``outside`` is
    :attr:`ModelError.outside`."""
    usual = 1.0 - 2.0 * _WITH_ALIKE - with_mixed
    total = sum(p for *each, p in ERRORS if tuple(each) in _BESIDE_ALIKE)
    found = []
    for *each, p in ERRORS:
        more = _WITH_ALIKE * p / total if tuple(each) in _BESIDE_ALIKE else 0.0
        found.append((outside * each[0], each[1], 0.0, usual * p, more, more))
    own = [each for each in ERRORS if with_mixed and each[:2] in _BESIDE_MIXED]
    each_of = with_mixed / (len(_MIXED) * sum(p for *_, p in own)) if own else 0.0
    found += [(outside * k, t, mixed, each_of * p, 0.0, 0.0) for mixed in _MIXED for k, t, p in own]
    rows = np.array(found)
    with np.errstate(divide="ignore"):
        rows[:, 3:] = np.log(rows[:, 3:])
    return rows


# -- Roots that the baseline shows and the model loses on the way to a damage: two that met
#
# Where they meet depends on the model's errors. So a structure may still have them where the model has not,
# and a value there is not simply a false one: it may be of such a root, found with the probability of one
# that only one state shows, as far from its intact place as a root goes until it meets another.

_MOVED = 0.1  # standard deviation of ln f of such a root from its intact place


def and_vanished(there: Foreseen, response: NDArray[np.intp], place: FloatArray) -> Foreseen:
    """The roots together with those that are gone, in ascending order within each response."""
    n, m = there.place.size, response.size
    both, places = np.concatenate([there.roots.response, response]), np.concatenate([there.place, place])
    order = np.lexsort((places, both))
    spread = np.zeros((n + m, n + m))
    spread[:n, :n] = there.spread
    spread[np.arange(n, n + m), np.arange(n, n + m)] = _MOVED**2

    def joined(own: Any) -> Any:
        return np.concatenate([own, np.zeros((m, *own.shape[1:]), dtype=own.dtype)])[order]

    by_root = ("beside", "change", "seen", "together", "shift", "known")
    more = {name: joined(getattr(there, name)) for name in by_root}
    more["roots"] = Roots(both[order], places[order], joined(there.roots.slopes))
    return there._replace(place=places[order], spread=spread[np.ix_(order, order)], **more)


# -- The likelihood, wherever the roots come from, and how probable changes are that are no damage

ANY_CHANGE = np.geomspace(3e-4, 0.3, 10)  # changes (standard deviations of ln f) that something else may make
#: The same for changes of all values alike, as of temperature, and their share of the
#: probability: small, since std_common allows for what is usual.
ALIKE, ALIKE_SHARE = (5e-3, 1.5e-2, 4e-2), 0.05
_NOTHING = 40.0  # what is so much less probable (ln) adds nothing in double precision
_NEW = 0.1  # change of a root that has just appeared
_MARGIN = 0.3  # roots so far outside of what was measured (ln f) are not looked at
_APART = 100.0  # responses on one line, so far apart


def _band(now: Values, intact: Values) -> Band:
    """Where there are values in one state or the other."""
    both = np.concatenate([now.plain.log_f, intact.plain.log_f])
    return Band(float(both.min()), float(both.max()))


class Likelihood:
    """p(values of a test | severities) from the roots of a model after the baseline, the core's or those of
    reduced models; and how probable other changes are."""

    def __init__(
        self,
        core: Core,
        n_elements: int,
        error: ModelError,
        intact: Values,
        now: Values,
        common: float,
        threads: int,
        ambient: FloatArray | None = None,
        warmer: FloatArray | None = None,
    ) -> None:
        self.core, self.n, self.error, self.now, self.threads = core, n_elements, error, now, threads
        self.common, self.nfev, self.n_elements = common, 0, n_elements
        #: What is added to severities: shapes behind the elements may have another amount that is no change.
        self.offset: FloatArray | float = 0.0
        self.band = _band(now, intact)
        self.factors = np.exp(error.theta)
        #: Changes of ln factor (p, k) that the surroundings make, of standard deviation 1 each.
        none = np.zeros((self.factors.size, 0))
        self.ambient = none if ambient is None else ambient
        #: The same of temperature, which may come with any hypothesis.
        self.warmer = none if warmer is None else warmer
        self.errors = all_errors(error.outside, _WITH_MIXED if error.doubtful or error.lacking else 0.0)
        self._not_warm = self.errors.copy()
        self._not_warm[:, 3 + _WARM] = -np.inf
        by_theta = error.intact.slopes[:, n_elements:] * self.factors
        self._beside = error.predicted(by_theta, np.arange(error.intact.size), error.intact.kind)[0]

    def of(self, now: Values, intact: Values) -> Likelihood:
        """The same of another test against the same baseline."""
        other = copy(self)
        other.now, other.band = now, _band(now, intact)
        for made in ("_undamaged", "start", "something_else", "_alike"):
            other.__dict__.pop(made, None)
        return other

    @cached_property
    def _undamaged(self) -> Roots:
        return self.roots(np.zeros((1, self.n)), slopes=True)[0]

    @cached_property
    def start(self) -> View:
        """The values as seen from no damage."""
        return self.without_damage(0.0, 0.0)

    def without_damage(self, extra: float | FloatArray, common: float) -> View:
        """The same, with an extra error of each value and one of all alike."""
        return self.views(np.zeros((1, self.n)), extra, common, [self._undamaged])[0]

    def log_without_damage(self, extra: float, common: float) -> float:
        """The log-likelihood of that."""
        return self.without_damage(extra, common).log_likelihood

    @cached_property
    def something_else(self) -> float:
        """Log evidence of a change of every value by any amount, or of all values alike."""
        found: list[float] = []
        for extra in ANY_CHANGE:
            found.append(self.log_without_damage(extra, 0.0))
            if found[-1] < max(found) - _NOTHING:  # the more a change exceeds the values', the less probable
                break
        by_itself = np.logaddexp.reduce(found) - np.log(ANY_CHANGE.size)
        return float(np.logaddexp(np.log1p(-ALIKE_SHARE) + by_itself, self._alike[1]))

    @property
    def moved_alike(self) -> float:
        """Relative change of all values, where that is what something else comes to; else 0.

        An error of all alike lets values differ from it as the model's own errors do: where half of them
        differ by more than half of the change, they have not moved alike.
        """
        likeliest, alike = self._alike
        if self.something_else > np.log(2.0) + alike:  # less than half of it
            return 0.0
        view = self.without_damage(0.0, likeliest)
        moved = view.residual[self.now.kind[view.partner >= 0] == 0]
        if not moved.size:
            return 0.0
        shift = float(np.median(moved))
        return float(np.expm1(shift)) if np.median(np.abs(moved - shift)) <= 0.5 * abs(shift) else 0.0

    @cached_property
    def _alike(self) -> tuple[float, float]:
        """The likeliest change of all values alike, and the log evidence of any such."""
        logs = [self.log_without_damage(0.0, each) for each in ALIKE]
        evidence = float(np.logaddexp.reduce(logs) - np.log(len(ALIKE)) + np.log(ALIKE_SHARE))
        return ALIKE[int(np.argmax(logs))], evidence

    def rows(self, elements: Iterable[int], severities: Any) -> FloatArray:
        """Severities of all elements (m, n) of those of some (m, k)."""
        rows = np.zeros((len(severities), self.n))
        rows[:, list(elements)] = severities
        return rows

    def roots(self, betas: FloatArray, *, slopes: bool, changed: FloatArray | None = None) -> list[Roots]:
        """The model's roots at each row of severities (m, n), where ln factors have ``changed`` by (m, p)."""
        self.nfev += len(betas)
        changed = np.zeros((len(betas), self.factors.size)) if changed is None else changed
        x = np.hstack([betas + self.offset, self.factors * np.exp(changed)])
        band_hz = (np.exp(self.band.low - 2.0 * _MARGIN), np.exp(self.band.high + 2.0 * _MARGIN))
        return roots_at(self.core, x, slopes=slopes, threads=self.threads, band_hz=band_hz)

    def settle(self, beta: FloatArray) -> float:
        """Give severities (n,) a reduced model of their own; how far its roots are from the full model's."""
        if not isinstance(self.core, ReducedRoots):
            return 0.0
        return self.core.settle(np.concatenate([beta, self.factors]))

    def views(
        self,
        betas: FloatArray,
        extra: float | FloatArray = 0.0,
        common: float = 0.0,
        found: list[Roots] | None = None,
    ) -> list[View]:
        """The values as seen from each row of severities (m, n), with an ``extra`` error of every value, an
        error of all alike, and roots that are ``found`` already.

        Where the surroundings have changed, the values are seen from where that leads to."""
        found = self.roots(betas, slopes=True) if found is None else found
        views = [self._view(*each, extra, common) for each in zip(betas, found, strict=True)]
        # Near where two roots meet they are not linear in a factor, nor is a loss seen alike everywhere.
        felt = [n for n, view in enumerate(views) if view.felt.any() and not np.any(extra)]
        if felt and isinstance(self.core, _core.Objective):
            change = np.array([views[n].felt for n in felt])
            changed = change @ np.hstack([self.warmer, self.ambient]).T
            there = self.roots(betas[felt], slopes=True, changed=changed)
            for nth, n in enumerate(felt):
                other = self._view(betas[n], there[nth], extra, common, change[nth], changed[nth])
                if other.log_likelihood > views[n].log_likelihood:
                    views[n] = other
        return views

    def strict(self, beta: FloatArray) -> View:
        """The values as seen from severities (n,), with errors as they are stated."""
        (roots,) = self.roots(beta[None], slopes=True)
        kappa, times, mixed = self.errors.T[:3]
        stated = self.errors[(kappa == 0.0) & (times == 1.0) & (mixed == 0.0)]
        stated[:, 4:] = -np.inf  # nothing moves alike
        return self._view(beta, roots, 0.0, errors=stated)

    def unexplained(self, betas: FloatArray) -> FloatArray:
        """How far the values are from the nearest roots at each row of severities, (m,); roots lie as far
        beside the model's as the intact ones do."""
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

    def _view(
        self,
        beta: FloatArray,
        roots: Roots,
        extra: float | FloatArray,
        common: float = 0.0,
        felt: FloatArray | None = None,
        changed: FloatArray | float = 0.0,
        errors: FloatArray | None = None,
    ) -> View:
        """``extra`` is the error of every value, or of those of each response; ``felt`` is the change of the
        surroundings at which the roots are, and ``changed`` that of ln factors."""
        roots, identity, followed = self.near(roots)
        error, log_f, slopes = self.error, roots.log_f, roots.slopes
        by_theta = slopes[:, self.n :] * self.factors * np.exp(changed)
        beside, spread = error.predicted(by_theta, identity, roots.kind)
        old, by_heat, moved = identity >= 0, by_theta @ self.warmer, by_theta @ self.ambient
        known, shift = np.zeros(log_f.size), np.zeros(log_f.size)
        if felt is not None:
            known, shift = np.sum(moved**2, axis=1), np.hstack([by_heat, moved]) @ felt
        log_f = log_f - shift
        alike = np.hypot(self.common, common) * (roots.kind == 0)
        if error.unlearned and beta.any():
            room = 1.0 - beta[: self.n_elements]
            astray = error.unlearned * np.linalg.norm(np.log(room)) * slopes[:, : self.n_elements] * room
            spread = spread + astray @ astray.T
        own = np.asarray(extra)[roots.response] if np.ndim(extra) else np.full(log_f.size, extra)
        foreseen = Foreseen(
            roots,
            log_f + beside,
            beside,
            spread + np.diag(own**2) + np.outer(alike, alike) + moved @ moved.T,
            np.where(old, log_f - error.intact.log_f[identity], _NEW),
            old & error.seen[identity],
            error.gain_std,
            self.n_elements,
            np.column_stack([ALIKE_STD * (roots.kind == 0), by_heat, moved]),
            by_heat.shape[1],
            shift,
            known,
        )
        if not isinstance(roots, ModeRoots):  # modes do not vanish
            gone = np.setdiff1d(np.flatnonzero(error.seen), followed)
            places = error.intact.log_f[gone] + self._beside[gone]
            if gone.size:
                foreseen = and_vanished(foreseen, error.intact.response[gone], places)
        # Warmth, its gradient and three losses together explain what a stiffened element does as well.
        many = np.count_nonzero(beta[: self.n_elements]) >= MANY
        usual = self._not_warm if many else self.errors
        return viewed(beta, self.now, foreseen, self.band, usual if errors is None else errors)


# -- Two states and what is assumed of them: all that decides how probable the values are

_DRIFTS = (
    "The intact tests differ by the stiffness of all elements together, as of temperature ({}, standard "
    "deviation): that was taken out of them, and may be in the values of now too."
)


class Prepared(NamedTuple):
    """The likelihood after the baseline, and what it was made of."""

    likelihood: Likelihood
    numbers: tuple[int, ...]
    factors: tuple[Parameter, ...]
    responses: Responses | ModeResponses
    intact: Values
    scatter: float
    odd: Contradiction
    #: The model with what its joints and supports may yield, which ``factors`` are of too.
    base: StructuralModel | Joined
    structure: Structure  # its geometry, and what its elements do between nodes
    plain: Core  # the roots of the model as it was given
    n_given: int  # factors that are of this
    missing_support: str  # where the model lacks one; '' where none is missed

    @property
    def stiffness_factors(self) -> dict[int, float]:
        """Factor of each element's stiffness after the baseline."""
        pairs = zip(self.factors, self.likelihood.factors.tolist(), strict=True)
        return {p.terms[0]: value for p, value in pairs if p.quantity == "stiffness_factor"}

    def corrected(self, severities: dict[int, float]) -> list[Any]:
        """The sets of now as the model after the baseline would have them: what is wrong in both states
        taken out."""
        likelihood, now = self.likelihood, self.likelihood.now
        betas = likelihood.rows([self.numbers.index(e) for e in severities], [list(severities.values())])
        view, roots = likelihood.views(betas)[0], likelihood.near(likelihood.roots(betas, slopes=False)[0])[0]
        responses: Any = self.responses
        beside = view.beside
        if self.plain is not likelihood.core:  # the tables are of the model as it was given
            x = np.concatenate([betas[0], likelihood.factors[: self.n_given]])
            given = roots_at(self.plain, x[None], slopes=False, threads=likelihood.threads)[0]
            was, has = roots.since(given)[1], np.flatnonzero(view.partner >= 0)
            shift = np.where(was >= 0, roots.log_f - given.log_f[was], 0.0)
            place = _APART * roots.response + roots.log_f
            order = np.argsort(place)
            own = _APART * now.response[has] + now.log_f[has] - view.residual - view.beside[has]
            at = order[np.clip(np.searchsorted(place[order], own - 1e-9), 0, place.size - 1)]
            beside = beside.copy()
            beside[has] += shift[at]
        return list(responses.corrected(now, roots, view.partner, beside))


class _Family(NamedTuple):
    """A model, the source of its roots, what may be wrong in it, which of these have one scatter, and their
    lower bounds (ln)."""

    structure: Structure
    base: StructuralModel | Joined
    core: Any
    factors: tuple[Parameter, ...]
    group: NDArray[np.intp]
    low: FloatArray
    along: FloatArray | None  # place of each stiffness term


class _Families(NamedTuple):
    """A model as it was given, and with what it may lack."""

    question: Question
    plain: _Family
    responses: Any
    intact: Values
    how: Any
    threads: int

    def of(self, structure: Structure, yields: bool) -> _Family:
        """The model with what its elements do between their nodes; and with springs, joints and supports
        that yield, each by a factor of its own, if there are any."""
        model, factors = self.question.model, self.plain.factors
        base = structure.finer or model
        joints, given = structure.joints(), {(p.quantity, p.terms) for p in factors}
        springs = [p for p in structure.yielding if (p.quantity, p.terms) not in given]
        more = (*springs, *parameters_of(base, joints, BOUNDS)) if yields else ()
        if base is model and not more:
            return self.plain
        base, every = joined(base, joints) if more and joints else base, (*factors, *more)
        reductions = stiffness_reduction(self.question.numbers)
        parts = model.description.core_parameters((*reductions, *every))
        core = self.responses.source(base, parts, **self.how)
        least = np.repeat([-_REACH, -_YIELDS], [len(springs), len(joints)])[: len(more)]
        group = np.pad(self.plain.group, (0, len(more)), constant_values=1)
        along = structure.along
        if along is not None:
            of = [shape.element for shape in joints if shape.kind != "mass"] if more else []
            places = np.zeros(base._core.n_stiffness_terms)
            places[: along.size] = along
            places[places.size - len(of) :] = [along[e] if e >= 0 else 0.0 for e in of]
            along = places
        return _Family(structure, base, core, every, group, np.concatenate([self.plain.low, least]), along)

    def left(self, structure: Structure) -> float:
        """How far the roots of a model that yields are from the intact values."""
        family = self.of(structure, True)
        x = np.repeat([0.0, 1.0], [len(self.question.numbers), len(family.factors)])
        roots = roots_at(family.core, x[None], slopes=False, threads=self.threads)[0]
        return self.intact.unexplained(roots, roots.log_f)

    def taught(self, family: _Family, intact: Values) -> ModelError:
        """The model's errors as the intact values tell them."""
        n, how = len(self.question.numbers), (self.question.model_error, self.threads, family.low)
        found = learned(family.core, n, family.group, intact, *how)
        weighed = any(p.quantity == "mass_factor" for p in family.factors)
        more = len(family.factors) > len(self.plain.factors)
        return replace(found, lacking=more, unlearned=0.0 if weighed else _UNLEARNED)

    def tried(self, family: _Family, intact: Values) -> ModelError | None:
        """The same; None where the values move its factors so far that rounding leaves no covariance."""
        try:
            return self.taught(family, intact)
        except np.linalg.LinAlgError:
            return None

    def around(
        self, family: _Family, error: ModelError, named: Sequence[str] = ("temperature",)
    ) -> FloatArray:
        """Changes of ln factor that the surroundings make, as :func:`surroundings` has them."""
        model, springs = self.question.model, self.plain.structure.springs
        # The ground spring of a chain is a storey where it is a candidate.
        elements = {*model.default_elements, *self.question.elements}.difference(*(p.terms for p in springs))
        n_terms, values = model._core.n_stiffness_terms, np.exp(error.theta)
        beyond = (p for p in family.factors if p.quantity == "stiffness_factor" and p.terms[0] >= n_terms)
        joints = [p.terms[0] for p in beyond if p not in family.structure.yielding]  # these are springs
        return surroundings(elements, n_terms, joints, family.factors, values, named, family.along)

    def learn(self) -> tuple[ModelError, Values, FloatArray, float, Contradiction, Structure, bool, str]:
        """What ``_taught`` holds."""
        step("learning the model's errors")
        question, responses, intact = self.question, self.responses, self.intact
        identified = isinstance(responses, Responses)
        # Which root each value belongs to is told without what moves all of a test.
        moved = moved_alike(intact, responses.tests) if identified else np.zeros(intact.size)
        still = replace(intact, log_f=intact.log_f - moved) if moved.any() else intact
        error, family = self.taught(self.plain, still), self.plain
        if not error.intact.size or (intact.size and not (error.partner >= 0).any()):
            got = f"one that does not explain the measurement: no {responses.noun} near the measured ones"
            remedy = "Check units, dofs and supports of the model, and the band of the measurement."
            reject("model", got, "a model of the tested structure", f"{question.hint()} {remedy}".lstrip())
        missing = ""
        if identified and not question.reduced and intact.size:
            error, family = self.likeliest(error, still)
            if question.model_error is None and error.doubtful:
                missing = self.missing_support(error, still)
        place = error.place + moved
        drift, scatter = np.zeros(0), scatter_between(intact, place, error.partner)
        if scatter > 1.0:
            if identified:
                by_factors = error.intact.slopes[:, len(question.numbers) :] * np.exp(error.theta)
                by_heat = by_factors @ self.around(family, error)
                intact, drift = without_shifts(intact, place, error.partner, by_heat)
                scatter = scatter_between(intact, intact.log_f, error.partner)
            error = self.taught(family, intact.noisier(scatter))
        odd = contradiction(intact.plain, responses.tests)
        yields = len(family.factors) > len(self.plain.factors)
        return error, intact, drift, scatter, odd, family.structure, yields, missing

    def missing_support(self, error: ModelError, intact: Values) -> str:
        """Where one more support makes the intact values far more probable than what was learned; else ''."""
        step("looking for a support that the model lacks")
        given = structure_of(self.question.model, float(np.exp(intact.plain.log_f.max())))
        dofs = {dof for part in self.responses.parts for end in part[:2] for dof in members(end)}
        for at_ends in (True, False):  # which is where supports are
            found: dict[str, tuple[float, Structure]] = {}
            for name, own in given.places(dofs, at_ends=at_ends):
                other = given.held(own)
                family = self.of(other, False)
                x = np.repeat([0.0, 1.0], [len(self.question.numbers), len(family.factors)])
                roots = roots_at(family.core, x[None], slopes=False, threads=self.threads)[0]
                left = intact.unexplained(roots, roots.log_f)
                if left < found.get(name, (np.inf,))[0]:
                    found[name] = left, other
            for name in sorted(found, key=lambda name: found[name][0])[:_NEAREST]:
                its = self.tried(self.of(found[name][1], False), intact)
                if its is None or its.log_evidence <= error.log_evidence + _FORGOTTEN:
                    continue
                if at_ends or 2.0 * its.tau < error.tau:
                    return name
        return ""

    def likeliest(self, error: ModelError, intact: Values) -> tuple[ModelError, _Family]:
        """The model under which the intact values are most probable; ``error`` is of the plain one."""
        family, structures = self.plain, [self.plain.structure]
        finer = structure_of(self.question.model, float(np.exp(intact.plain.log_f.max())))
        structures = [finer, *structures] if finer.finer else structures
        for stage, clearly in enumerate((0.0, _CLEARLY, _PLAINLY)):
            if stage and not (self.question.model_error is None and error.doubtful):
                break
            least = error.log_evidence + clearly
            for structure in structures:
                step("learning what its elements do between nodes, and what joints yield")
                if stage == 1:
                    structure = structure.hinged(self.left)
                elif stage:
                    many = intact.size >= _TELLING * self.question.model.n_dof
                    if not (many and isinstance(structure, Chain)):
                        continue
                    structure = structure.based(self.left)
                other = self.of(structure, stage > 0)
                its = None if other is self.plain else self.tried(other, intact)
                if its is not None and its.log_evidence > least:
                    error, family, least = its, other, its.log_evidence
                if stage and not error.doubtful:  # what resolves its waves needs no other
                    break
        return error, family


@dataclass(frozen=True)
class Question:
    """What was asked; ``elements`` are the candidates, zero-based."""

    model: StructuralModel
    baseline: tuple[AntiresonanceSet, ...] | tuple[ModalSet, ...]
    measured: tuple[AntiresonanceSet, ...] | tuple[ModalSet, ...]
    elements: tuple[int, ...]
    prior: DamagePrior
    options: SearchOptions = field(default_factory=SearchOptions)
    model_error: float | None = None
    reduced: bool = False
    #: What the baseline taught once it was asked, as intervals ask again: errors, the values without what
    #: moved all of a test, how that scatters, and the values beside, contradictions, whether elements move
    #: between their nodes and joints yield, and where a support is missing.
    _taught: list[tuple[ModelError, Values, FloatArray, float, Contradiction, Structure, bool, str]] = field(
        default_factory=list, init=False, repr=False, compare=False
    )

    @property
    def numbers(self) -> tuple[int, ...]:
        """All elements of the model, candidates first."""
        return (*self.elements, *(e for e in self.model._springs if e not in self.elements))

    def prepared(self, threads: int, *, silent: bool = False) -> Prepared:
        """Learn the model's errors from the baseline; ``silent`` keeps antiresonances of responses that have
        no value yet."""
        model, numbers, factors = self.model, self.numbers, factors_of(self.model)
        frame, surrounded = structure_of(model), self.options.environment or ()
        springs: tuple[Parameter, ...] = ()
        if "supports" in surrounded:  # what changes needs a factor, be it right in the model
            springs = tuple(p for p in frame.springs if p.terms[0] not in model._springs)
        group, factors = np.repeat([0, 1], [len(factors), len(springs)]), factors + springs
        sides: Any = measured_modes if isinstance(self.measured[0], ModalSet) else measured_states
        responses, intact, now = sides(model, self.baseline, self.measured)
        how: Any = {"silent": True} if silent else {}
        parts = model.description.core_parameters((*stiffness_reduction(numbers), *factors))
        core: Any = responses.source(model, parts, **how)
        plain = _Family(frame, model, core, factors, group, np.full(len(factors), -_REACH), frame.along)
        if self.reduced and isinstance(responses, Responses):
            plain = plain._replace(core=ReducedRoots(Terms(model, responses.parts, numbers, factors), core))
        families = _Families(self, plain, responses, intact, how, threads)
        if not self._taught:
            self._taught.append(families.learn())
        error, intact, drift, scatter, odd, structure, with_joints, missing = self._taught[0]
        family = families.of(structure, with_joints)
        if scatter > 1.0:
            intact, now = intact.noisier(scatter), now.noisier(scatter)
        ambient, heat = families.around(family, error, surrounded), families.around(family, error)
        if drift.any():
            ambient = np.hstack([ambient, heat * drift])
            left_out = (*responses.left_out, _DRIFTS.format(figure(_WARMER * float(drift[0]))))
            responses = replace(responses, left_out=left_out)
        rest: Any = (self.options.std_common, threads, ambient, heat)
        likelihood = Likelihood(family.core, len(numbers), error, intact, now, *rest)
        made = responses, intact, scatter, odd, family.base, structure, core, len(factors), missing
        return Prepared(likelihood, numbers, family.factors, *made)

    def hint(self) -> str:
        """A mistake that would account for a model that does not explain the intact structure, if any."""
        return hint_of(self.model, targets_of(self.model, self.baseline or self.measured, None))[0]
