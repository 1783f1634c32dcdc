"""From two measured states to an assessment: sets of damaged elements weighed and searched."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cache, cached_property
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..support.checks import FloatArray
from ..support.progress import step
from ..updating.posterior import between, log_between
from ..updating.problem import Pairs, hint_between_states, roots_between, shown_in_frfs
from ..updating.reduced_model import ReductionReport
from .hypotheses import UNKNOWN, Assessment, Hypotheses, Hypothesis, Taught, figure, together, without_idle
from .likelihood import ERRORS, Likelihood, Prepared, Question, View
from .measured_states import Responses, Values, mostly_risen, roots_at
from .options import DamagePrior, SearchOptions
from .reduced_roots import TOLERANCE, ReducedRoots
from .shapes import BOUNDS, CRACKED, Found, Shaped

# -- The evidence of a set of damaged elements, from one view of the values
#
# In u = -ln(1 - beta) the density is p(ln f | u) exp(-sum u). About a point ln f is linear in u, so that the
# integral over the box is that of a Gaussian with bounds; it is formed only where the most probable
# severities are near enough to that point.

#: Largest severity, and the same as u: Gaussians of u are those of what lies in the box [0, FURTHEST]^n.
HIGHEST = 0.99
FURTHEST = -float(np.log1p(-HIGHEST))

# -- Gaussians within bounds: where in the box the peak is


def peak_in_box(mean: FloatArray, covariance: FloatArray) -> FloatArray:
    """Most probable points (k, n) of Gaussians in the box."""
    best, spread, free = mean.copy(), covariance.copy(), np.ones(mean.shape, dtype=bool)
    for _ in range(mean.shape[1]):
        sd = np.sqrt(np.diagonal(spread, axis1=1, axis2=2))
        below, above = -best / sd, (best - FURTHEST) / sd
        outside = np.where(free, np.maximum(below, above), -np.inf)
        worst = np.argmax(outside, axis=1)
        row = np.flatnonzero(outside[np.arange(worst.size), worst] > 0.0)
        if not row.size:
            break
        at = worst[row]
        gain = spread[row, :, at] / spread[row, at, at][:, None]
        bound = np.where(below[row, at] > above[row, at], 0.0, FURTHEST)
        best[row] += gain * (bound - best[row, at])[:, None]
        spread[row] -= gain[:, :, None] * spread[row, at][:, None, :]
        free[row, at], spread[row, at, at] = False, 1.0
    return best


# -- Gaussians of which only a box is left: their probability, densities, and draws
#
# One coordinate after the other, those with the least room first, each given those before: within its limits
# it is a normal one; the product of the conditional probabilities, averaged over draws, is the probability of
# the box (A. Genz, J. Comput. Graph. Stat. 1 (1992) 141-149).

_POINTS = 16  # points of the rule of quadrature along each coordinate but the last
_TO_ROUNDING = 1e-8  # share of a variance that may be lost in rounding
_FAR = 5.0  # coordinates so many standard deviations from both bounds do not count
_HALF_LOG_TAU = 0.5 * float(np.log(2.0 * np.pi))


@dataclass(frozen=True)
class Truncated:
    """Gaussians within the box: mean (..., n), Cholesky factor, both in the order of ``order``."""

    mean: FloatArray
    factor: FloatArray
    order: NDArray[np.intp]

    def draws(self, uniform: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points (k, n) of uniform numbers (k, n), and ln of the weights that make them one Gaussian's."""
        z, log_weight = self.transformed(uniform)
        found = np.empty_like(z)
        found[:, self.order] = np.clip(self.mean + z @ self.factor.T, 0.0, FURTHEST)
        return found, log_weight

    def log_density(self, points: FloatArray) -> FloatArray:
        """Of the points of :meth:`draws` without their weights, anywhere in the box; (k,)."""
        apart = points[:, self.order] - self.mean
        z = np.asarray(np.linalg.solve(self.factor, apart.T).T, dtype=np.float64)
        total = np.zeros(len(points))
        for i in range(self.mean.size):
            below, above = self._limits(z, i)
            total -= 0.5 * z[:, i] ** 2 + _HALF_LOG_TAU + np.log(self.factor[i, i])
            total -= log_between(below, above)
        return total

    def _limits(self, z: FloatArray, i: int) -> tuple[FloatArray, FloatArray]:
        """Limits of coordinate i in standard deviations, given those before."""
        before = (z[..., :i] @ self.factor[..., i, :i, None])[..., 0]
        middle, scale = self.mean[..., i, None] + before, self.factor[..., i, i, None]
        return -middle / scale, (FURTHEST - middle) / scale

    def transformed(self, uniform: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Standard normal coordinates of as many uniform numbers as there are, and ln of the product."""
        z = np.zeros((*self.mean.shape[:-1], len(uniform), self.mean.shape[-1]))
        total = np.zeros(z.shape[:-1])
        for i in range(self.mean.shape[-1]):
            below, above = self._limits(z, i)
            total += log_between(below, above)
            if i < uniform.shape[1]:
                z[..., i] = between(below, above, uniform[:, i])
        return z, total


def truncated(mean: FloatArray, covariance: FloatArray) -> Truncated:
    """Gaussians of mean (..., n) within the box."""
    sd = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    order = np.argsort(log_between(-mean / sd, (FURTHEST - mean) / sd), axis=-1, kind="stable")
    rows = np.take_along_axis(covariance, order[..., :, None], axis=-2)
    ordered = np.take_along_axis(rows, order[..., None, :], axis=-1)
    try:
        factor = np.linalg.cholesky(ordered)
    except np.linalg.LinAlgError:  # losses that the values do not tell apart, to rounding
        least = _TO_ROUNDING * np.diagonal(ordered, axis1=-2, axis2=-1)
        factor = np.linalg.cholesky(ordered + least[..., None] * np.eye(ordered.shape[-1]))
    return Truncated(np.take_along_axis(mean, order, axis=-1), np.asarray(factor), order)


def log_inside(mean: FloatArray, covariance: FloatArray) -> FloatArray:
    """ln of the probability that each Gaussian of mean (k, n) gives to the box, by a fixed rule."""
    from scipy.special import logsumexp

    sd = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    near = np.minimum(mean, FURTHEST - mean) < _FAR * sd
    alone = log_between(-mean / sd, (FURTHEST - mean) / sd)
    found: FloatArray = np.where(near, alone, 0.0).sum(axis=1)
    count = near.sum(axis=1)
    for size in range(2, mean.shape[1] + 1):
        row = np.flatnonzero(count == size)
        if row.size:
            at = np.nonzero(near[row])[1].reshape(-1, size)
            own = covariance[row[:, None, None], at[:, :, None], at[:, None, :]]
            points, weights = _rule(size - 1)
            found[row] = logsumexp(
                truncated(mean[row[:, None], at], own).transformed(points)[1], b=weights, axis=-1
            )
    return found


@cache
def _rule(n: int) -> tuple[FloatArray, FloatArray]:
    """Points (k, n) and weights (k,) of Gauss and Legendre's rule in the unit cube."""
    x, w = np.polynomial.legendre.leggauss(_POINTS)
    points, weights = (np.array(list(product(each, repeat=n))) for each in (0.5 * (x + 1.0), 0.5 * w))
    return points, weights.prod(axis=1)


LINEAR = 0.12  # change of u up to which the roots count as linear
_ON_BOUND = 1e-9  # so near to the largest u counts as there
BLIND = 1e-2  # precision of u where nothing sees it


@dataclass(frozen=True)
class Fit:
    """A set of damaged elements: log evidence, most probable severities, the Gaussian of u in bounds; its
    covariance has what the model's own error makes of a loss."""

    elements: tuple[int, ...]
    log_evidence: float
    beta: FloatArray
    mean: FloatArray
    covariance: FloatArray
    view: View

    def interval(
        self, nth: int, shares: tuple[float, float]
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        """Quantiles of one severity, given the set, and their shares: those asked for if the likeliest
        severity is between them, else as much from the nearer bound on."""
        low, high = self._quantiles(nth, shares)
        best, whole = self.u[nth], shares[1] - shares[0]
        if best <= 0.0 or best < low:
            shares = 0.0, whole
            low, high = self._quantiles(nth, shares)
        elif best > high:
            shares = 1.0 - whole, 1.0
            low, high = self._quantiles(nth, shares)
        return (-float(np.expm1(-low)), -float(np.expm1(-high))), shares

    @property
    def u(self) -> FloatArray:
        """Most probable u."""
        return np.asarray(-np.log1p(-self.beta))

    def _quantiles(self, nth: int, shares: tuple[float, float]) -> tuple[float, float]:
        """Of u; partners whose most probable severity is a bound stay on it."""
        on_bound = (self.u <= 0.0) | (self.u >= FURTHEST - _ON_BOUND)
        at = np.array([k for k in np.flatnonzero(on_bound) if k != nth], dtype=np.intp)
        mean, variance = self.mean[nth], self.covariance[nth, nth]
        if at.size:
            gain = np.linalg.solve(self.covariance[np.ix_(at, at)], self.covariance[at, nth])
            mean, variance = (
                mean + gain @ (self.u[at] - self.mean[at]),
                variance - gain @ self.covariance[at, nth],
            )
        std = np.sqrt(variance)
        z = between(np.full(2, -mean / std), (FURTHEST - mean) / std, np.array(shares))
        low, high = np.clip(mean + std * z, 0.0, FURTHEST).tolist()
        return low, high


def fitted(
    view: View, sets: Sequence[tuple[int, ...]], reach: float = LINEAR, *, at_peak: bool = False
) -> list[Fit]:
    """Sets of one size as seen from one point; not those whose severities are too far from there, in u."""
    at = np.array(sets, dtype=np.intp).reshape(len(sets), -1)
    size = at.shape[1]
    room = 1.0 - view.beta[at]
    start = -np.log(room)
    matrix = view.curvature[at[:, :, None], at[:, None, :]] * room[:, :, None] * room[:, None, :]
    covariance: FloatArray = np.asarray(np.linalg.inv(matrix + BLIND * np.eye(size)), dtype=np.float64)
    # All severities are equally probable, so that large u are less.
    gain = np.zeros(at.shape) if at_peak else view.gain[at] * room - 1.0
    step = (covariance @ gain[:, :, None])[:, :, 0]
    mean = start + step
    best = peak_in_box(mean, covariance)
    near = np.flatnonzero(np.all(np.abs(best - start) <= reach, axis=1))
    inside = log_inside(mean[near], covariance[near])
    spread = np.linalg.slogdet(covariance[near])[1] - 2.0 * start[near].sum(axis=1)
    volume = 0.5 * (size * np.log(2.0 * np.pi) + spread) - size * np.log(HIGHEST)
    # With the error that a wrong model makes of a loss.
    wider = covariance[near] + ((view.gain_std * best[near]) ** 2)[:, :, None] * np.eye(size)
    evidence = view.log_likelihood + 0.5 * np.sum(gain * step, axis=1)[near] + volume + inside
    return [
        Fit(tuple(sets[nth]), log_evidence, -np.expm1(-best[nth]), mean[nth], wide, view)
        for nth, log_evidence, wide in zip(near.tolist(), evidence.tolist(), wider, strict=True)
    ]


def refitted(view: View, elements: tuple[int, ...], *, at_peak: bool = False) -> Fit:
    """One set, however far its severities are; ``at_peak``: where it is seen from, whatever slopes say."""
    (fit,) = fitted(view, [elements], np.inf, at_peak=at_peak)
    return fit


# -- Which elements may be damaged: a beam search over sets of elements
#
# Each set is made from one with an element less. A scan of the new element's severity finds where to begin;
# Newton steps with an error of the values that falls to nothing lead to the most probable severities. From
# every point on the way the sets with one element more are judged too, as far as the linear model goes. Where
# there are many elements a scan looks at those that would explain most to first order.

Elements = tuple[int, ...]


#: More elements than these are not all scanned; of one damage, and of a further one, so many are.
_MANY_ELEMENTS, _SCANNED_ELEMENTS = 60, (40, 16)
#: Severities of a scan, and of one for a further damage among many elements.
_GRID = np.array([0.02, 0.05, 0.1, 0.16, 0.23, 0.31, 0.4, 0.5, 0.6, 0.7, 0.79, 0.87, 0.93, 0.97])
_COARSE = np.array([0.05, 0.16, 0.4, 0.7, 0.93])
LARGEST = 3  # elements of the largest sets
#: Sets of each size that get another element; and new sets that are refined.
_PARENTS, _REFINED = (1, 8, 4), (12, 40, 10)
_UNTOLD = 16  # sets that get another one where nothing found so far is better than no element at all
_TEMPERED = (0.03, 0.01, 0.003, 0.0, 0.0)  # errors added on the way to the most probable severities
_FURTHER = 6  # more steps of what has not come to rest after them, and may be the answer
#: Sets so far below the likeliest of their size (log-likelihood) are given up on the way, but for so many.
_HOPELESS, _KEPT = 30.0, 8
_LOST_ON_THE_WAY = 0.5  # a set is not at rest where the last step lost more of the log-likelihood
_LONGEST = 0.7  # largest step of ln(1 - beta)
#: Gain of the log-likelihood, to second order, below which no further element can win against its prior; and
#: below which no pair is looked for where one element explains the values: of a large loss slopes show less.
_GAIN, _PAIR_GAIN = 7.0, 5.0
_MOSTLY = 0.5  # share of what errors as they are stated do not explain, above which one more element may
_TOO_MUCH = 3.0  # chi-square so many standard deviations above what is expected is too much
#: Sets so near to the likeliest (log evidence), and so many of them, are judged from their own severities.
_NEAR, _RENEWED = 12.0, 24
_HARDLY = 0.02  # severity below which an element of a set may as well be undamaged
#: About so many points of a scan of pairs; where even so there are too many, pairs of so many elements.
_SCANNED, _ALONE = 4000, 40
_WIDER = 2.0  # multiple of the stated errors up to which a damage explains the values
USUALLY_LOST = 0.05  # share of values without a partner that is usual
_MANY = 8  # with fewer values to spare two damages are looked at, however well one explains the values


@dataclass
class Search:
    """The sets found so far, by elements; candidates have the first numbers."""

    likelihood: Likelihood
    n_candidates: int
    prior: DamagePrior = field(default_factory=DamagePrior)
    fits: dict[Elements, Fit] = field(default_factory=dict)
    interrupted: bool = False
    screened: tuple[int, int] | None = None  # scanned for a single damage, of how many, unless all were
    #: Sets that explain far less than others without coming to rest; elements that sensitivities rule out.
    hopeless: set[Elements] = field(default_factory=set)
    shaped: Found = field(default_factory=Found)
    ends_by_slopes: bool = False  # whether a pair that one element's slopes show may end it

    def run(self) -> None:
        """Judge sets of up to three elements; after Ctrl-C those judged so far stay."""
        self._judge((), self.likelihood.start)
        try:
            for size in range(1, min(LARGEST, self.n_candidates) + 1):
                step(f"sets of {size}")
                # Nothing is left to explain, and no single element may be missing from the answer because it
                # was not looked at; pairs are, unless slopes are trusted to show them.
                looked = all((e,) in self.fits or (e,) in self.hopeless for e in range(self.likelihood.n))
                looked &= (self.ends_by_slopes and size > 1) or len(self._likeliest.elements) < size
                if looked and self._explains(_PAIR_GAIN if size == 2 else _GAIN):
                    break
                self._refine(self._starts(size))
                if size == 2 and not self._any():
                    self._refine(self._pairs())
            self._smaller()
            self._renew()
        except KeyboardInterrupt:
            self.interrupted = True

    def _any(self) -> bool:
        """Whether some set is more probable than a change that has nothing to do with elements."""
        return self._likeliest.log_evidence > self.likelihood.something_else

    @property
    def _likeliest(self) -> Fit:
        return max(self.fits.values(), key=lambda fit: fit.log_evidence)

    def _row(self, elements: Elements, severities: Any) -> FloatArray:
        """Severities of all elements, (n,)."""
        (row,) = self.likelihood.rows(elements, np.minimum([severities], HIGHEST))
        return np.asarray(row)

    def _pairs(self) -> dict[Elements, FloatArray]:
        """Pairs that explain most, both severities scanned: of two large damages one may not show alone."""
        pairs = list(combinations(range(self.n_candidates), 2))
        n_levels = int(np.clip(np.sqrt(_SCANNED / len(pairs)), 2, _GRID.size))
        levels = _GRID[np.unique(np.linspace(2, _GRID.size - 1, n_levels).round().astype(int))]
        if len(pairs) * levels.size**2 > 2 * _SCANNED:  # so many candidates: those that explain most alone
            alone = sorted(range(self.n_candidates), key=lambda e: -self.fits[(e,)].log_evidence)
            pairs = list(combinations(sorted(alone[:_ALONE]), 2))
        severities = np.array(list(product(levels, levels)))
        rows = np.zeros((len(pairs), len(severities), self.likelihood.n))
        for nth, pair in enumerate(pairs):
            rows[nth][:, pair] = severities
        left = self.likelihood.unexplained(rows.reshape(-1, self.likelihood.n)).reshape(len(pairs), -1)
        best = np.argsort(left.min(axis=1), kind="stable")[: _REFINED[0]]
        return {pairs[nth]: rows[nth, np.argmin(left[nth])] for nth in best}

    def _smaller(self) -> None:
        """Judge the likeliest sets without those of their elements that have hardly a damage."""
        starts: dict[Elements, FloatArray] = {}
        for elements in self._near():
            severities = dict(zip(elements, self.fits[elements].beta, strict=True))
            kept = tuple(e for e in elements if severities[e] >= _HARDLY)
            if kept and kept != elements:
                starts[kept] = self._row(kept, [severities[e] for e in kept])
        if starts:
            self._judge_smaller(starts)

    def _judge_smaller(self, starts: dict[Elements, FloatArray]) -> None:
        """Judge sets from these severities of all elements (n,)."""
        views = self.likelihood.views(np.array(list(starts.values())))
        for elements, view in zip(starts, views, strict=True):
            self._judge(elements, view)

    def _near(self) -> list[Elements]:
        """The most probable sets, the first first."""
        # By evidence alone each set has others beside it, with an undamaged element more: they fill the list.
        weights = self._weights()
        least = max((weight for s, weight in weights.items() if s), default=0.0) - _NEAR
        near = (s for s, weight in weights.items() if s and weight > least)
        return sorted(near, key=lambda s: -weights[s])[:_RENEWED]

    def _renew(self) -> None:
        """Judge the likeliest sets anew, each from its own severities or where it rests from there."""
        sets = self._near()
        if sets:
            betas = np.array([self._row(elements, self.fits[elements].beta) for elements in sets])
            for elements, view in zip(sets, self.likelihood.views(betas), strict=True):
                climb = Climb(elements)
                for _ in range(1 + _FURTHER):
                    climb.sees(view)
                    if fits := fitted(climb.view, [elements]):
                        self.fits[elements] = fits[0]
                        break
                    (view,) = self.likelihood.views(climb.ahead()[None])
                else:
                    if climb.share < 1.0:
                        self.fits[elements] = refitted(climb.view, elements, at_peak=True)

    def _most_parents(self, size: int) -> int:
        """How many sets of a size get another element."""
        return _PARENTS[min(size, len(_PARENTS) - 1)] if self._any() else _UNTOLD

    def _further(self, elements: Elements, view: View | None = None) -> list[int]:
        """Elements that may join a set; those that are judged with it, where it is seen from a point."""
        del view
        return [e for e in range(self.n_candidates if elements else self.likelihood.n) if e not in elements]

    def _judge(self, elements: Elements, view: View, *, itself: bool = True) -> None:
        """Tell the evidence of a set ``itself`` and of those with one element more, as seen from a point."""
        self._keep(fitted(view, [elements]) if itself else [])
        larger = [] if len(elements) == LARGEST or self.outside(elements) else self._further(elements, view)
        if larger:
            self._keep(fitted(view, [tuple(sorted((*elements, e))) for e in larger]))

    def _keep(self, fits: Sequence[Fit]) -> None:
        """Sets as judged now, unless they were judged likelier before."""
        for fit in fits:
            known = self.fits.get(fit.elements)
            if known is None or fit.log_evidence > known.log_evidence:
                self.fits[fit.elements] = fit

    @property
    def finished(self) -> bool:
        """Whether the likeliest set leaves nothing to be explained."""
        return self._explains(_GAIN)

    def _explains(self, gain: float) -> bool:
        """Whether the likeliest set explains the values, so that no further element gains so much."""
        fit = self._likeliest
        view, count = fit.view, fit.view.n_matched
        gains = view.gains
        gains[list(fit.elements)] = 0.0
        fits = not too_much(view)
        all_there = view.partner.size - count <= max(1, USUALLY_LOST * view.partner.size)
        # Errors as they are stated: larger ones would explain anything.
        stated = view.times <= (_WIDER if fit.elements else 1.0)
        # A few values are explained by much that is not so, and what is no damage may explain them better.
        many = not fit.elements or count >= _MANY + len(fit.elements)
        ends = fits and all_there and gains.max() < gain and stated and many and self._any()
        return bool(ends) and not self._hidden(fit, gain)

    def _hidden(self, fit: Fit, gain: float) -> bool:
        """Whether another element may explain with errors as they are stated what now takes larger ones."""
        if not fit.elements or (fit.view.kappa == 0.0 and fit.view.times <= 1.0):
            return False
        sets = np.array([(*fit.elements, e) for e in self._further(fit.elements)], dtype=np.intp)
        if not sets.size:
            return False
        view = self.likelihood.strict(fit.view.beta)
        matrix = view.curvature[sets[:, :, None], sets[:, None, :]] + BLIND * np.eye(sets.shape[1])
        slope = view.gain[sets]
        more = 0.5 * np.einsum("ij,ij->i", slope, np.linalg.solve(matrix, slope[:, :, None])[:, :, 0])
        return bool(more.max() > max(gain, _MOSTLY * 0.5 * (view.chi_square - view.n_matched)))

    def outside(self, elements: Elements) -> bool:
        """Whether a set has an element that is no candidate."""
        return max(elements, default=-1) >= self.n_candidates

    @cached_property
    def _log_priors(self) -> tuple[float, ...]:
        """Of each set of none to three candidates, of one element that is none, and of something else."""
        n, others = self.n_candidates, self.likelihood.n - self.n_candidates
        own = [self.prior.log_of(k, n) if k <= n else -np.inf for k in range(4)]
        return (*own, self.prior.log_elsewhere(others) if others else -np.inf, self.prior.log_unknown(others))

    def log_weights(self) -> dict[Elements, float]:
        """Log of prior times evidence by elements, and of what is in none of them, by -2 and down."""
        found = self._weights()
        for s, one in self.shaped.cracked.items():
            whole = found.get(s, -np.inf) + np.log1p(-CRACKED)
            found[s] = float(np.logaddexp(whole, one.log_evidence + np.log(CRACKED) + self.log_prior(s)))
        # What is of a known kind takes half of what is elsewhere; of an unknown kind it is without elements.
        unknown = self._log_priors[-1]
        if self.shaped.others:
            elsewhere = 0.5 * self.prior.elsewhere
            found = {s: weight - np.log(2.0) * self.outside(s) for s, weight in found.items()}
            with np.errstate(divide="ignore"):
                if self.likelihood.n == self.n_candidates:
                    unknown = float(np.log(self.prior.unknown + elsewhere))
                for nth, one in enumerate(self.shaped.others):
                    if one.halves:
                        found[one.halves] -= np.log(2.0)
                        found[-2 - nth,] = found[one.halves]
                    else:
                        found[-2 - nth,] = one.log_evidence + float(np.log(elsewhere))
        return found | {UNKNOWN: self.likelihood.something_else + unknown}

    def shaped_as(self, key: Elements) -> Shaped | None:
        """What is more probable than the loss of these whole elements, or is in none of them."""
        if key and key[0] < -1:
            return self.shaped.others[-2 - key[0]]
        one, whole = self.shaped.cracked.get(key), self.fits.get(key)
        if one is None or whole is None:
            return one
        odds = one.log_evidence - whole.log_evidence
        return one if odds > np.log1p(-CRACKED) - np.log(CRACKED) else None

    def _weights(self) -> dict[Elements, float]:
        return {s: fit.log_evidence + self.log_prior(s) for s, fit in self.fits.items()}

    def log_prior(self, elements: Elements) -> float:
        """Log probability of a set before the test."""
        outside = elements and elements[-1] >= self.n_candidates  # they ascend
        return self._log_priors[4 if outside else len(elements)]

    def _starts(self, size: int) -> dict[Elements, FloatArray]:
        """The sets that explain most in a scan, and the severities at which they do."""
        own = [fit for s, fit in self.fits.items() if len(s) == size - 1 and not self.outside(s)]
        parents = sorted(own, key=lambda fit: -fit.log_evidence)[: self._most_parents(size - 1)]
        found: list[tuple[float, Elements, FloatArray]] = []
        for parent in parents:
            further, grid = self._further(parent.elements), _GRID
            if len(further) > _MANY_ELEMENTS:
                gains = parent.view.gains
                most = _SCANNED_ELEMENTS[min(size, len(_SCANNED_ELEMENTS)) - 1]
                few = sorted(sorted(further, key=lambda e: -gains[e])[:most])
                if size == 1:
                    self.screened = len(few), len(further)
                    self.hopeless.update((e,) for e in set(further) - set(few))
                else:
                    grid = _COARSE
                further = few
            base = self._row(parent.elements, np.maximum(parent.beta, 0.0))
            rows = np.repeat(base[None], len(further) * grid.size, axis=0)
            for nth, e in enumerate(further):
                rows[nth * grid.size : (nth + 1) * grid.size, e] = grid
            left = self.likelihood.unexplained(rows)
            for nth, e in enumerate(further):
                at = nth * grid.size + int(np.argmin(left[nth * grid.size : (nth + 1) * grid.size]))
                found.append((left[at], tuple(sorted((*parent.elements, e))), rows[at]))
        chosen: dict[Elements, FloatArray] = {}
        most = _REFINED[min(size, len(_REFINED)) - 1]
        for _, elements, beta in sorted(found, key=lambda each: each[0]):
            if elements not in chosen and (len(chosen) < most or (size == 1 and elements not in self.fits)):
                chosen[elements] = beta
        return chosen

    def _refine(self, chosen: dict[Elements, FloatArray]) -> None:
        """Newton steps of all sets together, then their evidence."""
        if not chosen:
            return
        betas, climbs = np.array(list(chosen.values())), {elements: Climb(elements) for elements in chosen}
        for extra in _TEMPERED:
            views = dict(zip(climbs, self.likelihood.views(betas, extra), strict=True))
            if not extra:  # those that may still win, and all single elements
                for elements, view in views.items():
                    climbs[elements].sees(view)
                likeliest = sorted(climbs, key=lambda s: -climbs[s].height)
                least = climbs[likeliest[0]].height - _HOPELESS
                given_up = {s for s in likeliest[_KEPT:] if len(s) > 1 and climbs[s].height <= least}
                climbs = {elements: climb for elements, climb in climbs.items() if elements not in given_up}
            betas = np.array([climb.ahead(views[elements]) for elements, climb in climbs.items()])
        self._rest(climbs, betas)
        top = max(fit.view.log_likelihood for fit in self.fits.values())
        far = (elements for elements, climb in climbs.items() if climb.height < top - _HOPELESS)
        self.hopeless.update(elements for elements in far if elements not in self.fits)

    def _rest(self, climbs: dict[Elements, Climb], betas: FloatArray) -> None:
        """Judge sets from these severities (k, n), and after further steps those that may still win and have
        not come to rest."""
        moving = list(climbs.values())
        for nth in range(1 + _FURTHER):
            if nth:
                top = max(climb.height for climb in climbs.values())
                moving = [
                    climb
                    for elements, climb in climbs.items()
                    if not climb.rests and climb.height > top - (_HOPELESS if len(elements) == 1 else _NEAR)
                ]
                if not moving:
                    return
                betas = np.array([climb.ahead() for climb in moving])
            for climb, view in zip(moving, self.likelihood.views(betas), strict=True):
                climb.sees(view)
                self._judge(climb.elements, view)
                if climb.lost:
                    self._judge(climb.elements, climb.view)
                climb.rests = not climb.lost and bool(fitted(view, [climb.elements]))
        for climb in moving:
            if not climb.rests and climb.share < 1.0:
                self._keep([refitted(climb.view, climb.elements, at_peak=True)])


def too_much(view: View) -> bool:
    """Whether chi-square is more than errors as they are make it."""
    count = view.n_matched
    return bool(view.chi_square > count + _TOO_MUCH * np.sqrt(2.0 * count))


@dataclass
class Climb:
    """Steps of one set to its most probable severities.

    Slopes do not see how the errors of predictions and the partners of values change on the way: where modes
    veer a whole step may lose, and lead from one side of the peak to the other for ever. Then half of it
    is taken.
    """

    elements: Elements
    share: float = 1.0
    lost: bool = False  # much of the likelihood, in the last step
    rests: bool = False
    view: View = field(init=False)  # from the likeliest severities so far
    height: float = -np.inf

    def sees(self, view: View) -> None:
        """Take a view if it is the likeliest so far; else the next step is shorter."""
        self.lost = view.log_likelihood < self.height - _LOST_ON_THE_WAY
        if view.log_likelihood > self.height:
            self.view, self.height, self.share = view, view.log_likelihood, 1.0
        else:
            self.share *= 0.5

    def ahead(self, view: View | None = None) -> FloatArray:
        """Severities of all elements (n,) a Newton step ahead; from another ``view`` a whole one."""
        view, share = (self.view, self.share) if view is None else (view, 1.0)
        beta, at = view.beta.copy(), np.array(self.elements)
        matrix = view.curvature[np.ix_(at, at)]
        ridge = 1e-9 * np.trace(matrix) + 1e-6
        newton = np.linalg.solve(matrix + ridge * np.eye(at.size), view.gain[at])
        # The nearer to 1, the faster the model changes: steps in ln(1 - beta) do not overshoot.
        room = 1.0 - beta[at]
        step_by = share * np.clip(-newton / room, -_LONGEST, _LONGEST)
        beta[at] = np.clip(1.0 - room * np.exp(step_by), 0.0, HIGHEST)
        return beta


# -- The threshold at which damage is declared, and the smallest severity that a pair of tests would show
#
# Intact tests are simulated with noise and the errors that the baseline leaves, and judged as real ones are,
# by prior times evidence of all single elements over that of no damage, with the linear model at no damage.
# Damage of one element outweighs no damage where, sigma being the standard deviation of its severity,
#
# .. math:: \tfrac{1}{2} z^2 + \ln\frac{\sqrt{2 \pi} \sigma p_1}{0.99 \, p_0} > 0, \qquad z = \beta / \sigma,
#
# z^2 / 2 standing for what the errors of ERRORS make of it. It is found in nine of ten tests from 1.28 sigma
# above the beta of equality on, further where the model errs in how much a loss moves, and where another
# element moves the values alike: of two whose slopes have the correlation rho the right one is the likelier
# with the probability Phi(z sqrt((1 - rho) / 2)), as large as the two are.

#: Intact tests that are simulated; heights at which a severity is looked at, rivals of each element, those
#: most alike, structures that the baseline allows, and share of tests that find it.
_DRAWS, _HEIGHTS, _RIVALS, _STRUCTURES, _NINE_OF_TEN = 4000, 200, 12, 16, 0.9
_ALLOWED = 0.05  # largest distance (ln f) of roots that the baseline shows, in a structure that it allows
#: Least error of how much a loss moves the values, in scatters of the factors: those of a wrong model explain
#: a baseline that they do not describe. Set on grillage.
_ERRS = 0.5
#: What else asks for a larger loss: cracks, sensors and masses that explain as much. Set there too.
_BESIDES = 1.12


def log_odds_threshold(
    slopes: FloatArray, prior: DamagePrior, options: SearchOptions, rng: np.random.Generator
) -> float | None:
    """Log odds of damage that the wanted share of intact tests exceeds, None where probabilities decide;
    ``slopes`` are ``intact_slopes``."""
    from scipy.special import logsumexp

    rate = options.false_alarm_rate
    if rate is None:
        return None
    n = slopes.shape[1]
    size = np.maximum(np.linalg.norm(slopes, axis=0), 1e-6)
    # Height of each severity's peak over its standard deviation, and the room that it has from 0 on.
    height = rng.standard_normal((_DRAWS, slopes.shape[0])) @ slopes / size
    room = size * HIGHEST
    evidence = 0.5 * height**2 + log_between(-height, room - height) + np.log(np.sqrt(2.0 * np.pi) / room)
    odds = logsumexp(evidence, axis=1)
    least = float(np.quantile(odds, 1.0 - rate))
    return least + prior.log_of(1, n) - prior.log_of(0, n)


def intact_slopes(likelihood: Likelihood, n_candidates: int, draws: int = 0) -> FloatArray:
    """Changes of the baseline's values by each severity, over the errors they will have, made independent,
    (1 + k, m, n): of the model after the baseline, and of those of some draws that it allows."""
    from scipy.linalg import cho_solve, solve_triangular

    error, n, now = likelihood.error, likelihood.n, likelihood.now
    root = np.flatnonzero(error.seen)
    if not root.size:
        root = np.arange(error.intact.size)
    slopes = error.intact.slopes[root]
    kind = error.intact.kind[root]
    by_theta = slopes[:, n:] * np.exp(error.theta)
    _, spread = error.predicted(by_theta, root, kind)
    moved = by_theta @ likelihood.ambient
    usual = float(np.median(now.std))
    # Values of now have about the errors of those of the same response.
    own = [now.std[now.response == error.intact.response[r]] for r in root]
    std = np.array([float(np.median(each)) if each.size else usual for each in own])
    alike = likelihood.common * (kind == 0)
    triangle = np.linalg.cholesky(spread + np.diag(std**2) + np.outer(alike, alike) + moved @ moved.T)
    every = [slopes[:, :n_candidates]]
    if draws:
        p = error.theta.size
        cross = error.rows[:, :p] * error.prior[:p]
        left = np.diag(error.prior[:p]) - (cross.T @ cho_solve(error.factor, cross) if cross.size else 0.0)
        size, ways = np.linalg.eigh(left)
        # By the symmetric root: the same structures in whatever order the sensors come.
        scatter = np.random.default_rng(0).standard_normal((draws, p)) @ ways * np.sqrt(np.maximum(size, 0.0))
        theta = np.clip(error.theta + scatter @ ways.T, *np.log(BOUNDS))
        x = np.hstack([np.zeros((draws, n)), np.exp(theta)])
        for each in roots_at(likelihood.core, x, slopes=True, threads=likelihood.threads):
            found, identity = each.since(error.intact)
            old = identity >= 0
            rows, moved_by = np.zeros((error.intact.size, n_candidates)), np.zeros(error.intact.size)
            rows[identity[old]] = found.slopes[old, :n_candidates]
            moved_by[identity[old]] = np.abs(found.log_f[old] - error.intact.log_f[identity[old]])
            # One that has lost a root, or has another, so that those beyond are taken for each other, is not
            # a structure that the baseline allows.
            if moved_by[root].max() < _ALLOWED:
                every.append(rows[root])
    return np.array([solve_triangular(triangle, one, lower=True) for one in every])


def smallest_found(
    slopes: FloatArray,
    prior: DamagePrior,
    gain_std: float = 0.0,
    others: FloatArray | None = None,
    n_values: int | None = None,
) -> FloatArray:
    """Severity of each candidate at which nine of ten tests declare it; infinity where none would be.
    ``slopes`` (m, n) are over errors, ``others`` (k, m, n) what they may be in the structure; of another
    matrix that has their product give the ``n_values``."""
    from scipy.special import ndtr

    n = slopes.shape[1]
    m = slopes.shape[0] if n_values is None else n_values
    size = np.maximum(np.linalg.norm(slopes, axis=0), 1e-12)
    against = prior.log_of(0, n) - prior.log_of(1, n) + np.log(size * HIGHEST / np.sqrt(2.0 * np.pi))
    # Height of a loss over its standard deviation, and how much less probable no damage is there.
    height = np.geomspace(0.5, 500.0, _HEIGHTS)
    chi_square = np.append(0.0, height**2) + m
    times, share = np.array([each[1:] for each in ERRORS]).T  # errors as they may be: multiples of the stated
    logs = np.log(share) - m * np.log(times) - 0.5 * chi_square[:, None] / times**2
    probable = np.logaddexp.reduce(logs, axis=1)
    least = np.interp(np.maximum(against, 0.0), probable[0] - probable[1:], height)
    unit = slopes / size
    alike = np.clip(unit.T @ unit, -1.0, 1.0)
    found = np.full(n, np.inf)
    for e in range(n):
        moves = (slopes if others is None else others)[..., e].reshape(-1, slopes.shape[0]) / size[e]
        shows = moves @ unit  # of each structure, by each element, (k, n)
        rises = height[:, None] * shows[:, e]
        shown = ndtr((rises - least[e]) / np.sqrt(1.0 + (gain_std * rises) ** 2))
        for other in np.argsort(-alike[e])[: _RIVALS + 1]:  # each is to be less probable, too
            if other != e:
                apart = max(1.0 - alike[e, other], 1e-12)
                both = np.maximum(height[:, None] * (shows[:, e] + shows[:, other]), 1e-6)
                lead = 2.0 * np.log(size[other] / size[e]) / both
                ahead = height[:, None] * (shows[:, e] - shows[:, other]) + lead
                shown *= ndtr(ahead / np.sqrt(2.0 * apart))
        shown = np.maximum.accumulate(shown.mean(axis=1))
        if shown[-1] >= _NINE_OF_TEN:
            found[e] = np.interp(_NINE_OF_TEN, shown, height) / size[e]
    return np.where(_BESIDES * found <= HIGHEST, _BESIDES * found, np.inf)


# -- The answers of a search on reduced models, judged anew where full and reduced model agree
#
# Each hypothesis that has a share in the answer gets a basis at its own severities, whose roots are
# compared with those of the full model there, and is judged from it; so is no damage. All others stay as
# the search has them.

_SHARE, _MOST = 0.01, 6  # hypotheses of at least this probability are confirmed, so many of them
_STEPS, _RESTS = 4, 1e-4  # Newton steps of each, and when it has come to rest, in u


def confirmed(search: Search, likelihood: Likelihood, source: ReducedRoots) -> ReductionReport:
    """Judge what matters of a search anew, and tell how full and reduced model agree."""
    apart: dict[Elements, float] = {}
    try:
        while len(apart) < _MOST:
            weights = search.log_weights()
            least = float(np.logaddexp.reduce(list(weights.values()))) + np.log(_SHARE)
            near = [s for s, weight in weights.items() if s and s in search.fits and weight > least]
            likeliest = [(), *sorted(near, key=lambda s: -weights[s])]
            new = next((elements for elements in likeliest if elements not in apart), None)
            if new is None:
                break
            step("the answers on the full model")
            search.fits[new], apart[new] = settled(likelihood, new, search.fits[new].beta)
    except KeyboardInterrupt:
        search.interrupted = True
    worst = max(apart.values(), default=float("inf"))
    return ReductionReport(
        n_dof=source.terms.core.n_dof,
        size=source.largest,
        rounds=source.bases,
        difference=worst,
        agreed=worst <= TOLERANCE,
        full_evaluations=source.full_evaluations,
    )


def settled(likelihood: Likelihood, elements: Elements, beta: FloatArray) -> tuple[Fit, float]:
    """A set from its own severities, begun at ``beta``; how far a reduced model, made anew there, is off."""
    for _ in range(_STEPS):
        betas = likelihood.rows(elements, np.minimum(beta, HIGHEST)[None])
        apart = likelihood.settle(betas[0])
        fit = refitted(likelihood.views(betas)[0], elements)
        moved = np.log1p(-np.minimum(fit.beta, HIGHEST)) - np.log1p(-betas[0, list(elements)])
        beta = fit.beta
        if np.abs(moved).max(initial=0.0) < _RESTS:
            break
    return fit, apart


# -- From a search to an assessment

LEVEL = 0.9  # probability of the intervals, and the shares between which they lie
SHARES = (0.05, 0.95)
_LEAST = 1e-9  # hypotheses below this probability are dropped


@dataclass(frozen=True, kw_only=True)
class Learned(Taught):
    """What the baseline has told, and what a likelihood is made of."""

    factors: FloatArray  # of the model's stiffnesses and masses
    tau: float  # scatter of the roots' own errors
    s: float  # scatter of the factors
    outside: float  # share of a change that counts as its error
    low: float  # band, ln f
    high: float
    hint: str | None = None


def learned_from(
    prepared: Prepared, question: Question, rng: np.random.Generator, hint: str | None = None
) -> Learned:
    """What is known before the values of now are looked at."""
    likelihood, intact, prior = prepared.likelihood, prepared.intact, question.prior
    error, odd = likelihood.error, prepared.odd
    draws = 0 if question.reduced else _STRUCTURES
    slopes, *others = intact_slopes(likelihood, len(question.elements), draws)
    gain_std = max(error.gain_std, _ERRS * error.s)
    smallest = smallest_found(slopes, prior, gain_std, np.array(others) if others else None)
    own = [prepared.responses.tests[nth] for nth in intact.tests.tolist()]
    between = []
    if isinstance(prepared.responses, Responses):  # modes have shapes
        there = error.intact.response, error.intact.log_f
        kept = shown_in_frfs(prepared.responses.parts, *there)
        for test in intact.tests:
            at = intact.test == test
            values = intact.response[at], intact.log_f[at]
            between.append(roots_between(*values, there[0][kept], there[1][kept]))
    return Learned(
        factors=likelihood.factors,
        tau=error.tau,
        s=error.s,
        outside=error.outside,
        low=likelihood.band.low,
        high=likelihood.band.high,
        threshold=log_odds_threshold(slopes, prior, question.options, rng),
        detectable=tuple(smallest.tolist()),
        assumed_std=prepared.responses.assumed,
        n_intact=intact.size,
        n_intact_matched=int((error.partner >= 0).sum()),
        n_intact_roots=sum(between),
        hint=hint,
        n_baselines=max(map(own.count, own), default=0),
        scatter=prepared.scatter,
        notes=tuple(dict.fromkeys(prepared.responses.left_out)),
        missing_support=prepared.missing_support,
        odd_baselines=odd.tests,
        baseline_gap=odd.apart,
        usual_gap=odd.usual,
    )


def posterior(
    search: Search, weights: dict[Elements, float], numbers: Sequence[int], kept: Elements, least: float
) -> list[tuple[Elements, Hypothesis]]:
    """Keys and hypotheses, the most probable first; ``numbers`` are the elements' own numbers.
    Those of less than the ``least`` probability are dropped, but for no damage and ``kept``."""
    from scipy.special import logsumexp

    total = float(logsumexp(list(weights.values())))
    if not np.isfinite(total):
        got = "one that allows none of the hypotheses that were judged"
        remedy = "Leave the prior out, or give nothing, one and unknown more than 0."
        reject("prior", got, "some probability for no damage or one element", remedy)
    rows = []
    for elements, weight in weights.items():
        probability = min(float(np.exp(weight - total)), 1.0)
        if probability < least and elements and elements != kept:
            continue
        own = UNKNOWN if elements and elements[0] < 0 else tuple(numbers[e] for e in elements)
        if elements == UNKNOWN:
            row = Hypothesis(own, probability, (), (), (), candidate=False, kind="unknown")
        elif one := search.shaped_as(elements):
            losses = one.severities, one.low, one.high
            row = Hypothesis(own, probability, *losses, own != UNKNOWN, kind=one.kind, place=one.place)
        else:
            fit = search.fits[elements]
            ends = [fit.interval(nth, SHARES)[0] for nth in range(len(elements))]
            low, high = (tuple(end[side] for end in ends) for side in (0, 1))
            losses = tuple(fit.beta.tolist()), low, high
            row = Hypothesis(own, probability, *losses, not search.outside(elements))
        rows.append((elements, row))
    return sorted(rows, key=lambda row: (-row[1].probability, row[1].unknown, row[0]))


def concluded(
    search: Search,
    question: Question,
    learned: Learned,
    intact: Values,
    *,
    notes: Sequence[str] = (),
    least: float = _LEAST,
) -> Assessment:
    """Hypotheses with their probabilities, and how well the best explains the values."""
    likelihood, now, numbers = search.likelihood, search.likelihood.now, question.numbers
    weights = search.log_weights()
    damage = {s: w for s, w in weights.items() if s and s[0] >= 0 and not search.outside(s)}
    likeliest = max(damage, key=lambda s: damage[s], default=())
    judged = posterior(search, weights, numbers, likeliest, least)
    rows = [one for _, one in judged]
    key, best = judged[0]
    declared = best.elements if best.candidate else ()
    if best.candidate and learned.threshold is not None:
        odds = float(np.logaddexp.reduce([-np.inf, *damage.values()])) - weights[()]
        declared = tuple(numbers[e] for e in likeliest) if odds > learned.threshold else ()
    shaped = search.shaped_as(key)  # The values as the likeliest hypothesis sees them.
    view: View = search.fits[() if key == UNKNOWN else key].view if shaped is None else shaped.view
    matched, n_free = view.n_matched, 1 if key[:1] < (-1,) else len(best.severities)
    shift = likelihood.moved_alike if key == UNKNOWN else float(np.expm1(view.shift))
    taught = {each.name: getattr(learned, each.name) for each in fields(Taught)}
    taught["notes"] = (*learned.notes, *notes, *_notes(search, shift))
    found = Assessment(
        **taught,
        hypotheses=Hypotheses(rows, {e: question.model.element_label(e) for e in numbers}),
        group=tuple(together(rows)),
        declared=declared,
        chi_square=view.chi_square / max(matched - n_free, 1) if matched else np.nan,
        n_values=now.size,
        n_matched=matched,
        kappa=view.kappa,
        factor_std=learned.s,
        root_std=learned.tau,
        baseline=bool(question.baseline),
        interrupted=search.interrupted,
        moved_alike=shift,
    )
    if not found.model_fits:
        found = replace(found, hint=question.hint() if learned.hint is None else learned.hint)
    elif question.baseline and 2 * matched < now.size:
        found = replace(found, hint=hint_between_states(_usual(intact), _usual(now)))
    if question.baseline and not shift and not found.explained:  # a change of unknown kind explains nothing
        up, moved = mostly_risen(intact.plain, now.plain)
        found = replace(found, n_risen=up, n_moved=moved)
    return without_idle(found)


def _usual(values: Values) -> Pairs:
    """Response and ln f of the test of each response that has the most: repeated tests are as good as one."""
    plain = values.plain
    kept = np.zeros(plain.size, dtype=bool)
    for number in np.unique(plain.response):
        tests = [(plain.response == number) & (plain.test == test) for test in plain.tests]
        kept |= max(tests, key=np.count_nonzero)
    return plain.response[kept], plain.log_f[kept]


def _notes(search: Search, shift: float) -> list[str]:
    """On a shift of all values, which is no damage, and on elements that were looked at less closely."""
    notes = []
    if shift:
        way = "higher" if shift > 0.0 else "lower"
        notes.append(
            f"All values are {figure(abs(shift))} {way} than in the intact state, as at another temperature "
            "or by another sampling clock: correct them for it, or raise std_common."
        )
    if search.screened is not None:
        closely, count = search.screened
        notes.append(
            f"Of {count} elements the {closely} that would explain most to first order were scanned from 2 "
            "to 97 % loss; the others were judged from the slopes of the undamaged model."
        )
    return notes
