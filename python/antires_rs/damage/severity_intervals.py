"""Intervals of severities as a value: ends, draws, and what sampling says of the hypotheses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..optimize.island_ga import seed_of, thread_count
from ..support.checks import FloatArray, choice, finite_scalar, integer
from ..support.progress import one_blas_thread, patient, step
from ..updating.posterior import (
    Method,
    ParameterIntervals,
    ProfileLikelihood,
    evenly_chosen,
    kind_of,
    longest_step,
    threshold,
)
from .evidence import FURTHEST, HIGHEST, Fit, Truncated, truncated
from .hypotheses import Assessment
from .inference import LEVEL, settled
from .likelihood import Likelihood, Question


@dataclass(frozen=True)
class SampledSet:
    """A hypothesis whose severities were drawn.

    Attributes
    ----------
    elements : tuple of int
        Damaged elements, zero-based.
    candidate : bool
        False for an element that was no candidate.
    probability : float
        As in ``result.hypotheses``.
    confirmed : float
        With the evidence by sampling; the same as ``probability`` where none was drawn (``'laplace'``).
    effective : float
        How many independent draws those of the severities are worth.
    points : int
        Draws before those of little weight were left out.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.SampledSet((4,), True, 0.970, 0.968, 250.0, 310).confirmed
    0.968
    """

    elements: tuple[int, ...]
    candidate: bool
    probability: float
    confirmed: float
    effective: float
    points: int


@dataclass(frozen=True, eq=False)
class SeverityIntervals(ParameterIntervals):
    """Intervals of severities after an assessment against a baseline. ``intervals[element]`` is one of them.

    What :class:`ParameterIntervals` has, of the severities **given the elements declared damaged**: (0, 0) of
    all others. ``words`` are "two-sided"; "from 0 on" or "up to 0.99", where the most probable severity is at
    that bound; "not damaged". ``model_error`` is what no factor of the model explains of the baseline.

    Attributes
    ----------
    elements : tuple of int, (n,)
        Candidates, in the order of ``names``.
    mixture : ndarray, (k, n)
        Draws of severities over no damage and all near sets of candidates, each as often as it is probable;
        exactly 0 where an element is not in the set drawn.
    sets : tuple of SampledSet
        Hypotheses of some probability, the most probable first.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8(perturbation=0.05, rng=3)
    >>> damage = ar.assess_damage(case.model, case.exact(level=1), baseline=case.exact(level=0))
    >>> quick = damage.intervals()
    >>> quick[4] == damage.interval[4], quick.words[4], quick.mixture.shape
    (True, 'two-sided', (1000, 7))
    """

    elements: tuple[int, ...]
    mixture: FloatArray
    sets: tuple[SampledSet, ...]

    def __getitem__(self, name: Any) -> tuple[float, float]:
        if isinstance(name, str):
            return super().__getitem__(name)
        if name not in self.elements:
            reject("element", name, "a candidate", f"One of {', '.join(map(str, self.elements))}.")
        nth = self.elements.index(name)
        return float(self.low[nth]), float(self.high[nth])


# -- Draws of a density that no Gaussian is near, and its evidence: particles that go by steps and walk
#
# Transitional Markov chain Monte Carlo. Reference: J. Ching and Y.-C. Chen, J. Eng. Mech. 133 (2007) 816-832.

Density = Callable[[FloatArray], FloatArray]
#: Walks of each particle in a step and in the last.
_WALKS, _LAST = 3, 10
#: Share of walks that should be accepted, and the least step.
_ACCEPTED, _SHORTEST = 0.3, 1e-5


def stepwise(
    log_density: Density, start: Truncated, count: int, rng: np.random.Generator
) -> tuple[FloatArray, float]:
    """Draws (count, n) of a density within the bounds of ``start``, and the log of its integral."""
    from scipy.special import logsumexp

    u = start.draws(np.clip(rng.random((count, start.mean.size)), 1e-12, 1.0 - 1e-12))[0]
    target, first = log_density(u), start.log_density(u)
    share, scale, total = 0.0, 2.4 / np.sqrt(start.mean.size), 0.0
    while share < 1.0:
        ahead = longest_step(target - first, 1.0 - share)
        share = min(1.0, share + ahead) if ahead < 1.0 - share else 1.0
        step(f"severities by steps: {100 * share:.0f} % of the way")
        log_weight = ahead * (target - first)
        total += float(logsumexp(log_weight) - np.log(count))
        weight = np.exp(log_weight - logsumexp(log_weight))
        _, covariance = _moments(weight, u)
        factor = np.linalg.cholesky(covariance + _SHORTEST**2 * np.eye(len(covariance)))
        chosen = evenly_chosen(weight, count, rng)
        u, target, first = u[chosen], target[chosen], first[chosen]
        for _ in range(_LAST if share == 1.0 else _WALKS):
            walked = u + scale * rng.standard_normal(u.shape) @ factor.T
            inside = np.all((walked >= 0.0) & (walked <= FURTHEST), axis=1)
            walked = np.where(inside[:, None], walked, u)
            new_target, new_first = log_density(walked), start.log_density(walked)
            gain = share * (new_target - target) + (1.0 - share) * (new_first - first)
            taken = inside & (np.log(rng.random(count)) < gain)
            u = np.where(taken[:, None], walked, u)
            target, first = np.where(taken, new_target, target), np.where(taken, new_first, first)
            scale *= float(np.exp(taken.mean() - _ACCEPTED))
    return u, total


def _moments(weight: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean and covariance of weighted points."""
    mean = weight @ u
    return mean, (weight[:, None] * (u - mean)).T @ (u - mean)


# -- Severities of one set of damaged elements drawn from their posterior, and its evidence, by sampling
#
# The density is that of :mod:`~antires_rs.damage.evidence`, p(ln f | u) exp(-sum u), with the model's roots
# at every point and values and roots associated anew there. Points are drawn from the Gaussian of the fit,
# widened and within its bounds, and weighted; where too few count, Gaussians of what was found so far are
# added, and all points are weighted by the mixture of all Gaussians. Where that does not help either,
# particles go by steps from the widest Gaussian to the density and walk there.
#
# Reference: J.-M. Cornuet et al., Scand. J. Stat. 39 (2012) 798-812 (adaptive multiple importance sampling).

#: Standard deviations of the first Gaussians, in those of the fit, and the shares of the points in them.
_FIRST = ((1.25, 0.7), (3.0, 0.3))
#: Widening of Gaussians that were learned, and the least standard deviation of u.
_LEARNED, _LEAST_STD = 1.3, 1e-6
#: Rounds; the share of the points that should count in the end, and that below which particles walk.
_ROUNDS, _WANTED, _POOR = 4, 0.4, 0.1
#: Points that are evaluated at once; Ctrl-C and progress come in between.
_BATCH = 64


@dataclass(frozen=True)
class Sampled:
    """Severities (k, n) of one set with weights (k,) of the sum one, its log evidence, and how many
    independent draws they are worth."""

    beta: FloatArray
    weight: FloatArray
    log_evidence: float
    effective: float

    def resampled(self, count: int, rng: np.random.Generator) -> FloatArray:
        """So many severities (count, n) of equal weight, in random order."""
        chosen = evenly_chosen(self.weight, count, rng)
        return np.asarray(self.beta[rng.permutation(chosen)])

    def quantiles(self, nth: int, shares: tuple[float, float]) -> tuple[float, float]:
        """Quantiles of one severity."""
        order = np.argsort(self.beta[:, nth])
        weight = self.weight[order]
        low, high = np.interp(shares, np.cumsum(weight) - 0.5 * weight, self.beta[order, nth])
        return float(low), float(high)


def linear(fit: Fit, count: int, rng: np.random.Generator) -> Sampled:
    """Severities of the Gaussian of ``fit``, without another look at the model."""
    gaussian = truncated(fit.mean, fit.covariance)
    u, log_weight = gaussian.draws(_evenly(count, fit.mean.size, rng))
    weight = np.exp(log_weight - log_weight.max())
    weight /= weight.sum()
    return Sampled(-np.expm1(-u), weight, fit.log_evidence, float(1.0 / np.sum(weight**2)))


def sampled(
    likelihood: Likelihood,
    fit: Fit,
    wanted: int,
    rng: np.random.Generator,
    name: str = "",
    by_steps: bool = True,
) -> Sampled:
    """The posterior of the severities of ``fit``, of at least one element; points until ``wanted`` count."""
    n = len(fit.elements)

    def log_density(u: FloatArray) -> FloatArray:
        found = []
        for first in range(0, len(u), _BATCH):
            step(f"severities of {name}")
            part = u[first : first + _BATCH]
            views = likelihood.views(likelihood.rows(fit.elements, -np.expm1(-part)))
            found += [view.log_likelihood for view in views]
        return np.asarray(np.array(found) - u.sum(axis=1) - n * float(np.log(HIGHEST)))

    pool = _Pool(n, log_density, rng)
    sizes = [(truncated(fit.mean, s**2 * fit.covariance), share) for s, share in _FIRST]
    round_size = max(40, wanted // 2)
    for gaussian, share in sizes:
        pool.add(gaussian, int(np.ceil(share * round_size)))
    for _ in range(_ROUNDS):
        if pool.effective >= wanted:
            break
        rate = pool.effective / len(pool.u)
        if rate < _WANTED:
            pool.add(pool.learned(), round_size)
        else:  # good enough: as many more as are missing
            missing = int(np.ceil(1.2 * (wanted - pool.effective) / rate))
            for gaussian, share in sizes if rate > 0.6 else [(pool.learned(), 1.0)]:
                pool.add(gaussian, int(np.ceil(share * missing)))
    if by_steps and pool.effective < _POOR * min(len(pool.u), 4 * wanted):
        u, log_evidence = stepwise(log_density, sizes[-1][0], 2 * wanted, rng)
        even = np.full(len(u), 1.0 / len(u))
        return Sampled(-np.expm1(-u), even, log_evidence, len(np.unique(u, axis=0)))
    return Sampled(-np.expm1(-pool.u), pool.weight, pool.log_evidence, pool.effective)


class _Pool:
    """Points of several Gaussians, each with the log density wanted, weighted by the mixture of all."""

    def __init__(self, n: int, log_density: Density, rng: np.random.Generator) -> None:
        self.log_density, self.rng = log_density, rng
        self.u, self.target = np.empty((0, n)), np.empty(0)
        self.gaussians: list[tuple[Truncated, int]] = []

    def add(self, gaussian: Truncated, count: int) -> None:
        """Points of one Gaussian; evenly spread, from a random start."""
        from scipy.special import logsumexp

        u = gaussian.draws(_evenly(count, self.u.shape[1], self.rng))[0]
        self.u = np.vstack([self.u, u])
        self.target = np.concatenate([self.target, self.log_density(u)])
        self.gaussians.append((gaussian, count))
        shares = np.array([count for _, count in self.gaussians]) / len(self.u)
        drawn = np.array([gaussian.log_density(self.u) for gaussian, _ in self.gaussians])
        log_weight = self.target - logsumexp(drawn, axis=0, b=shares[:, None])
        self.log_evidence = float(logsumexp(log_weight) - np.log(len(self.u)))
        self.weight = np.exp(log_weight - logsumexp(log_weight))
        self.effective = float(1.0 / np.sum(self.weight**2))

    def learned(self) -> Truncated:
        """The Gaussian of what was found so far."""
        mean, covariance = _moments(self.weight, self.u)
        # With few points that count the covariance is too small; with that of the first one it is not.
        trust = min(self.effective / (10.0 * self.u.shape[1]), 1.0)
        first = self.gaussians[0][0]
        rough = np.empty_like(covariance)
        rough[np.ix_(first.order, first.order)] = first.factor @ first.factor.T
        covariance = trust * covariance + (1.0 - trust) * rough
        covariance = _LEARNED**2 * covariance + _LEAST_STD**2 * np.eye(len(covariance))
        return truncated(mean, covariance)


def _evenly(count: int, n: int, rng: np.random.Generator) -> FloatArray:
    """Points that fill the unit cube evenly: multiples of powers of 1 / x, where x**(n + 1) = x + 1."""
    x = 1.0
    for _ in range(60):
        x = (1.0 + x) ** (1.0 / (n + 1))
    steps = x ** -np.arange(1.0, n + 1.0)
    points = (rng.random(n) + np.arange(count)[:, None] * steps) % 1.0
    return np.clip(points, 1e-12, 1.0 - 1e-12)


# -- Intervals of severities after an assessment against a baseline: quick ones, and sure ones by sampling

#: Hypotheses of at least this probability are sampled, so many of them.
_NEAR, _MOST = 0.01, 4
#: Share of the draws that the points of the severities declared should be worth; least number of any set.
_WORTH, _LEAST = 0.15, 30
#: Sets of at least this probability are worth particles, where no Gaussian serves.
_MAIN = 0.2
#: Change of a probability that is worth a word, and share of the wanted draws that are too few.
_CHANGED, _FEW = 0.02, 0.5


@patient("intervals")
@one_blas_thread
def severity_intervals(
    question: Question,
    found: Assessment,
    names: list[str],
    *,
    method: Method,
    level: float,
    draws: int,
    rng: int | np.random.Generator | None,
    workers: int | None,
    progress: bool | None = None,
) -> SeverityIntervals:
    """Intervals given the elements declared damaged; see ``DamageResult.intervals``."""
    choice("method", method, ("laplace", "ensemble"))
    finite_scalar("level", level, low=0.5, high=0.999)
    integer("draws", draws, low=50, high=1_000_000)
    seed, sure, declared = seed_of(rng), method == "ensemble", found.answer
    prepared = question.prepared(thread_count(workers))
    near = [h for h in found.hypotheses if h.elements and not h.unknown and h.probability >= _NEAR][:_MOST]
    if declared is not None and declared not in near:
        near.append(declared)
    parts: list[tuple[Fit, Sampled]] = []
    notes: list[str] = []
    for nth, one in enumerate(near):
        fit, _ = settled(
            prepared.likelihood, tuple(map(prepared.numbers.index, one.elements)), np.array(one.severities)
        )
        own = np.random.default_rng([seed, nth])
        few = max(int(_WORTH * draws * (1.0 if one is declared else one.probability)), _LEAST)
        name, main = found.hypotheses.called(one), one is declared or one.probability >= _MAIN
        part = sampled(prepared.likelihood, fit, few, own, name, main) if sure else linear(fit, draws, own)
        if sure and part.effective < _FEW * few:
            notes.append(f"Draws of {name} are worth {part.effective:.0f} independent ones: take more.")
        parts.append((fit, part))
    # Probabilities with the evidence of the draws; the weights of the others as they were.
    weights = np.array(
        [
            h.probability * float(np.exp(p.log_evidence - fit.log_evidence))
            for h, (fit, p) in zip(near, parts, strict=True)
        ]
    )
    others = sum(one.probability for one in found.hypotheses) - sum(one.probability for one in near)
    total = float(weights.sum()) + max(others, 0.0)
    confirmed, nothing = (weights / total).tolist(), found.probability_of_nothing / total
    sets = tuple(
        SampledSet(h.elements, h.candidate, h.probability, c, part.effective, part.weight.size)
        for h, c, (_, part) in zip(near, confirmed, parts, strict=True)
    )
    column = {e: nth for nth, e in enumerate(question.elements)}
    rng = np.random.default_rng([seed, len(near)])
    own_draws, low, high = np.zeros((draws, len(column))), np.zeros(len(column)), np.zeros(len(column))
    words = ["not damaged"] * len(column)
    if declared is not None:
        fit, part = parts[near.index(declared)]
        values = part.resampled(draws, rng)
        central = 0.5 - 0.5 * level, 0.5 + 0.5 * level
        for nth, e in enumerate(declared.elements):
            at, shares = column[e], fit.sides(nth, central)
            own_draws[:, at] = values[:, nth]
            upper = f"up to {HIGHEST:g}" if shares[1] == 1.0 else "two-sided"
            words[at] = "from 0 on" if shares[0] == 0.0 else upper
            low[at], high[at] = part.quantiles(nth, shares) if sure else fit.interval(nth, central)
            if not sure and level == LEVEL:  # as the assessment has it, from where its search came to rest
                low[at], high[at] = declared.low[nth], declared.high[nth]
    changes = [abs(each - one.probability) for one, each in zip(near, confirmed, strict=True)]
    changed = [
        f"{found.hypotheses.called(one)} {each:.2f} instead of {one.probability:.2f}"
        for one, each, by in zip(near, confirmed, changes, strict=True)
        if by >= _CHANGED
    ]
    if sure and changed:
        notes.insert(0, f"Sampling changes probabilities: {'; '.join(changed)}.")
    elif sure and changes:
        notes.insert(0, f"Sampling confirms the probabilities to within {max(*changes, 0.001):.3f}.")
    # Draws of no damage and of the near sets of candidates, each as often as it is probable.
    mixture, mine = np.zeros_like(own_draws), [k for k, one in enumerate(near) if one.candidate]
    p = np.array([nothing, *(confirmed[k] for k in mine)])
    which = rng.choice(p.size, size=draws, p=p / p.sum()) if p.sum() else np.zeros(draws)
    for at_set, k in enumerate(mine, start=1):
        rows = np.flatnonzero(which == at_set)
        if rows.size:
            columns = [column[e] for e in near[k].elements]
            mixture[rows[:, None], columns] = parts[k][1].resampled(rows.size, rng)
    return SeverityIntervals(
        tuple(names),
        method,
        float(level),
        low,
        high,
        np.median(own_draws, axis=0),
        np.std(own_draws, axis=0),
        tuple(words),
        own_draws,
        found.chi_square,
        2.0 * found.root_std,
        tuple(notes),
        question.elements,
        mixture,
        sets,
    )


# -- Profile likelihood of one severity, after an assessment against a baseline
#
# The severity is held at points of u = -ln(1 - beta), the others of the set declared damaged are fitted
# again, and the likelihood is that of the assessment, with the errors of values and model in it.
#
# Reference: A. Raue et al., Bioinformatics 25 (2009) 1923-1929.

#: Standard deviations within which the points lie, and Newton steps of the other severities at each.
_REACH, _STEPS = 4.0, 4
#: Largest step of u.
_LONGEST = 0.3


@patient("profile")
@one_blas_thread
def severity_profile(
    question: Question,
    found: Assessment,
    names: list[str],
    name: str,
    *,
    level: float,
    points: int,
    progress: bool | None = None,
) -> ProfileLikelihood:
    """Profile of the severity called ``name``; see ``DamageResult.profile``."""
    finite_scalar("level", level, low=0.5, high=0.999)
    integer("points", points, low=5, high=1001)
    if name not in names:
        reject("name", repr(name), "a severity of the result", f"One of {', '.join(names)}.")
    element, one = question.elements[names.index(name)], found.answer
    if one is None or element not in one.elements:
        remedy = "The others are 0: result.probability tells how probable their damage is."
        reject("name", repr(name), "a severity of an element declared damaged", remedy)
    prepared = question.prepared(thread_count(None))
    held = one.elements.index(element)
    at = np.array([prepared.numbers.index(e) for e in one.elements])
    start = -np.log1p(-np.minimum(one.severities, HIGHEST))[None]
    best, (u,), curvature = _fitted_again(prepared.likelihood, at, start, None)
    std = float(np.sqrt(np.linalg.inv(curvature)[held, held]))
    around = u[held] + std * _REACH * np.linspace(-1.0, 1.0, points)
    inside = around[(around > 0.0) & (around < FURTHEST)]
    places = np.unique(np.concatenate([[0.0], inside, [FURTHEST]]))
    step(f"{name} held at {places.size} points")
    start = np.repeat(u[None], places.size, axis=0)
    start[:, held] = places
    logs, others, _ = _fitted_again(prepared.likelihood, at, start, held)
    rise = 2.0 * (max(float(logs.max()), float(best[0])) - logs)
    limit = threshold(level)
    low, low_open = _end(places, rise, limit, -1)
    high, high_open = _end(places, rise, limit, 1)
    own = [names[question.elements.index(e)] for e in one.elements]
    on_bound = [
        tuple(own[nth] for nth in range(len(own)) if nth != held and row[nth] <= 0.0) for row in others
    ]
    return ProfileLikelihood(
        name,
        -np.expm1(-places),
        rise,
        limit,
        level,
        -float(np.expm1(-low)),
        -float(np.expm1(-high)),
        kind_of(low_open, high_open),
        tuple(on_bound),
    )


def _fitted_again(
    likelihood: Likelihood, at: NDArray[np.intp], start: FloatArray, held: int | None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Log-likelihood at rows of u and the rows, all but the one held fitted; curvature at the first."""
    u = np.clip(start, 0.0, FURTHEST)
    free = np.array([nth for nth in range(at.size) if nth != held], dtype=np.intp)
    for nth in range(_STEPS + 1):
        views = likelihood.views(likelihood.rows(at, -np.expm1(-u)))
        if nth == _STEPS or not free.size:
            break
        for row, view in zip(u, views, strict=True):
            room = np.exp(-row[free])
            matrix = view.curvature[np.ix_(at[free], at[free])] * np.outer(room, room)
            ahead = np.linalg.solve(matrix + 1e-6 * np.eye(free.size), view.gain[at[free]] * room)
            row[free] = np.clip(row[free] + np.clip(ahead, -_LONGEST, _LONGEST), 0.0, FURTHEST)
    room = np.exp(-u[0])
    curvature = views[0].curvature[np.ix_(at, at)] * np.outer(room, room) + 1e-6 * np.eye(at.size)
    return np.array([view.log_likelihood for view in views]), u, curvature


def _end(places: FloatArray, rise: FloatArray, limit: float, side: int) -> tuple[float, bool]:
    """Where the rise passes the limit on one side of its least, and whether it never does."""
    best = int(np.argmin(rise))
    own = range(best, places.size) if side > 0 else range(best, -1, -1)
    for before, here in pairwise(own):
        if rise[here] > limit:
            first, second = np.sqrt(rise[[before, here]])  # a parabola's root is a line
            share = (np.sqrt(limit) - first) / (second - first)
            return float(places[before] + share * (places[here] - places[before])), False
    return float(places[0 if side < 0 else -1]), True
