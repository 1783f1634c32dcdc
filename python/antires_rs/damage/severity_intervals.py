"""Intervals of severities as a value: ends, draws, and what sampling says of the hypotheses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..optimize.island_ga import thread_count
from ..support.checks import FloatArray
from ..support.progress import step
from ..updating.posterior import (
    Method,
    ParameterIntervals,
    ProfileLikelihood,
    Section,
    evenly_chosen,
    stepwise,
)
from .hypotheses import Assessment, Hypothesis
from .inference import FURTHEST, HIGHEST, LEVEL, Fit, settled, truncated
from .likelihood import Likelihood, Prepared, Question


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

    ``'laplace'`` takes ln f as linear in ln(1 - severity) around the most probable severities; ``'ensemble'``
    has the model's antiresonances at every draw, and estimates also how probable the hypotheses are. The
    result of an older file lacks the values of the baseline, and has neither.

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


# -- Severities of one set of damaged elements drawn from their posterior, and its evidence, by sampling
#
# The density is that of :mod:`~antires_rs.damage.inference`, p(ln f | u) exp(-sum u), with values and roots
# associated anew at every point. Points are drawn from the Gaussian of the fit, widened and within its
# bounds, and weighted; where hardly any count, particles go by steps from the widest Gaussian to the density.

#: Standard deviations of the Gaussians, in those of the fit, and the shares of the points in them.
_WIDER = ((1.25, 0.7), (3.0, 0.3))
#: Rounds; share of the points that should count, below which particles walk; most points, in those wanted.
_ROUNDS, _POOR, _MOST_POINTS = 3, 0.15, 6
_BATCH = 64  # points that are evaluated at once; Ctrl-C and progress come in between


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
        return np.asarray(self.beta[rng.permutation(evenly_chosen(self.weight, count, rng))])

    def widened(self, gain_std: float, rng: np.random.Generator) -> Sampled:
        """With the error that a wrong model makes of a loss, which the likelihood does not know."""
        u = -np.log1p(-self.beta) * (1.0 + gain_std * rng.standard_normal(self.beta.shape))
        return replace(self, beta=-np.expm1(-np.clip(u, 0.0, FURTHEST)))

    def quantiles(self, nth: int, shares: tuple[float, float]) -> tuple[float, float]:
        """Quantiles of one severity."""
        order = np.argsort(self.beta[:, nth])
        weight = self.weight[order]
        low, high = np.interp(shares, np.cumsum(weight) - 0.5 * weight, self.beta[order, nth])
        return float(low), float(high)


def linear(fit: Fit, count: int, rng: np.random.Generator) -> Sampled:
    """Severities of the Gaussian of ``fit``, without another look at the model."""
    u, log_weight = truncated(fit.mean, fit.covariance).draws(_evenly(count, fit.mean.size, rng))
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
    from scipy.special import logsumexp

    n = len(fit.elements)

    def log_density(u: FloatArray) -> FloatArray:
        found = []
        for first in range(0, len(u), _BATCH):
            step(f"severities of {name}")
            beta = -np.expm1(-u[first : first + _BATCH])
            found += [view.log_likelihood for view in likelihood.views(likelihood.rows(fit.elements, beta))]
        return np.asarray(np.array(found) - u.sum(axis=1) - n * float(np.log(HIGHEST)))

    gaussians = [truncated(fit.mean, s**2 * fit.covariance) for s, _ in _WIDER]
    u, target, counts = np.empty((0, n)), np.empty(0), np.zeros((len(_WIDER), 1))
    missing = float(max(40, wanted // 2))
    for _ in range(_ROUNDS):
        for nth, (gaussian, (_, share)) in enumerate(zip(gaussians, _WIDER, strict=True)):
            count = int(np.ceil(share * missing))
            new = gaussian.draws(_evenly(count, n, rng))[0]
            u, target = np.vstack([u, new]), np.concatenate([target, log_density(new)])
            counts[nth] += count
        drawn = logsumexp([gaussian.log_density(u) for gaussian in gaussians], axis=0, b=counts)
        log_weight = target - drawn
        log_evidence = float(logsumexp(log_weight))
        weight = np.exp(log_weight - log_evidence)
        effective = float(1.0 / np.sum(weight**2))
        missing = min(1.2 * (wanted - effective) * len(u) / effective, _MOST_POINTS * wanted)
        if missing <= 0.0 or (by_steps and effective < _POOR * len(u)):
            break
    if by_steps and effective < min(_POOR * len(u), wanted):
        uniform = np.clip(rng.random((2 * wanted, n)), 1e-12, 1.0 - 1e-12)
        start = gaussians[-1]
        u, log_evidence, _ = stepwise(start.draws(uniform)[0], start.log_density, log_density, FURTHEST, rng)
        weight, effective = np.full(len(u), 1.0 / len(u)), float(len(np.unique(u, axis=0)))
    return Sampled(-np.expm1(-u), weight, log_evidence, effective)


def _evenly(count: int, n: int, rng: np.random.Generator) -> FloatArray:
    """Points that fill the unit cube evenly: multiples of powers of 1 / x, where x**(n + 1) = x + 1."""
    x = 1.0
    for _ in range(60):
        x = (1.0 + x) ** (1.0 / (n + 1))
    points = (rng.random(n) + np.arange(count)[:, None] * x ** -np.arange(1.0, n + 1.0)) % 1.0
    return np.clip(points, 1e-12, 1.0 - 1e-12)


# -- Intervals of severities after an assessment against a baseline: quick ones, and sure ones by sampling

#: Hypotheses of at least this probability are sampled, so many of them; and by particles, where no Gaussian
#: serves, from the last on.
_NEAR, _MOST, _MAIN = 0.01, 4, 0.2
#: Share of the draws that the points of the severities declared should be worth; least number of any set.
_WORTH, _LEAST = 0.15, 30
#: Change of a probability that is worth a word, and share of the wanted draws that are too few.
_CHANGED, _FEW = 0.02, 0.5


def severity_intervals(
    question: Question,
    found: Assessment,
    names: list[str],
    method: Method,
    level: float,
    draws: int,
    seed: int,
    threads: int,
) -> SeverityIntervals:
    """Intervals given the elements declared damaged; see ``UpdateResult.intervals``."""
    sure, declared = method == "ensemble", found.answer
    prepared = question.prepared(threads)
    near = [h for h in found.hypotheses if h.elements and not h.unknown and h.probability >= _NEAR][:_MOST]
    if declared is not None and declared not in near:
        near.append(declared)
    parts: list[tuple[Fit, Sampled]] = []
    notes: list[str] = []
    for nth, one in enumerate(near):
        rng = np.random.default_rng([seed, nth])
        few = max(int(_WORTH * draws * (1.0 if one is declared else one.probability)), _LEAST)
        name, main = found.hypotheses.called(one), one is declared or one.probability >= _MAIN
        fit = _fit_of(one, prepared)
        part = linear(fit, draws, rng)
        if sure and one.place:
            notes.append(f"Cracks are not sampled: the severities of {name} are the quick ones.")
        elif sure:
            drawn = sampled(prepared.likelihood, fit, few, rng, name, main)
            part = drawn.widened(fit.view.gain_std, rng)
            if part.effective < _FEW * few:
                notes.append(f"Draws of {name} are worth {part.effective:.0f} independent ones: take more.")
        parts.append((fit, part))
    # Probabilities with the evidence of the draws; the weights of the others as they were.
    own = np.array([one.probability for one in near])
    weights = own * np.exp([p.log_evidence - fit.log_evidence for fit, p in parts])
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
            at, (quick, shares) = column[e], fit.interval(nth, central)
            own_draws[:, at] = values[:, nth]
            upper = f"up to {HIGHEST:g}" if shares[1] == 1.0 else "two-sided"
            words[at] = "from 0 on" if shares[0] == 0.0 else upper
            drawn_ends = sure and not declared.place
            low[at], high[at] = part.quantiles(nth, shares) if drawn_ends else quick
            # As the assessment has it, from where its search came to rest.
            if not drawn_ends and level == LEVEL:
                low[at], high[at] = declared.low[nth], declared.high[nth]
    moved = [(h, c) for h, c in zip(near, confirmed, strict=True) if abs(c - h.probability) >= _CHANGED]
    changed = [f"{found.hypotheses.called(h)} {c:.2f} instead of {h.probability:.2f}" for h, c in moved]
    if sure and changed:
        notes.insert(0, f"Sampling changes probabilities: {'; '.join(changed)}.")
    elif sure and near:
        most = max(np.abs(own - confirmed).max(), 0.001)
        notes.insert(0, f"Sampling confirms the probabilities to within {most:.3f}.")
    # Draws of no damage and of the near sets of candidates, each as often as it is probable.
    mixture, mine = np.zeros_like(own_draws), [k for k, one in enumerate(near) if one.candidate]
    p = np.array([nothing, *(confirmed[k] for k in mine)])
    which = rng.choice(p.size, size=draws, p=p / p.sum()) if p.sum() else np.zeros(draws)
    for at_set, k in enumerate(mine, start=1):
        rows = np.flatnonzero(which == at_set)
        if rows.size:
            columns = [column[e] for e in near[k].elements]
            mixture[rows[:, None], columns] = parts[k][1].resampled(rows.size, rng)
    ends = low, high, np.median(own_draws, axis=0), np.std(own_draws, axis=0), tuple(words), own_draws
    rests = found.chi_square, 2.0 * found.root_std, tuple(notes), question.elements, mixture, sets
    return SeverityIntervals(tuple(names), method, level, *ends, *rests)


def _fit_of(one: Hypothesis, prepared: Prepared) -> Fit:
    """A hypothesis from its own severities. The likelihood of a crack is not that of a whole element: it has
    the Gaussian of u of its intervals."""
    from scipy.special import ndtri

    if not one.place:
        places = tuple(map(prepared.numbers.index, one.elements))
        return settled(prepared.likelihood, places, np.array(one.severities))[0]
    low, u, high = (-np.log1p(-np.minimum(b, HIGHEST)) for b in (one.low, one.severities, one.high))
    std = np.maximum(high - low, 1e-9) / (2.0 * float(ndtri(0.5 + 0.5 * LEVEL)))
    return Fit(one.elements, 0.0, np.array(one.severities), u, np.diag(std**2), prepared.likelihood.start)


# -- Profile likelihood of one severity, in u = -ln(1 - beta), by the likelihood of the assessment

#: Newton steps of the other severities, the longest of them, and one that ends them.
_STEPS, _LONGEST, _RESTS = 4, 0.3, 1e-4


def severity_profile(
    question: Question, found: Assessment, names: list[str], name: str, level: float, points: int
) -> ProfileLikelihood:
    """Profile of the severity called ``name``; see ``UpdateResult.profile``."""
    element, one = question.elements[names.index(name)], found.answer
    if one is None or element not in one.elements:
        remedy = "The others are 0: result.probability tells how probable their damage is."
        reject("name", repr(name), "a severity of an element declared damaged", remedy)
    if one.place:
        remedy = "result.interval has its interval."
        reject("name", repr(name), "a loss of a whole element: this is a crack", remedy)
    prepared, j = question.prepared(thread_count(None)), one.elements.index(element)
    at, own = np.array([prepared.numbers.index(e) for e in one.elements]), np.arange(len(one.elements))
    called = [names[question.elements.index(e)] for e in one.elements]

    def refitted(free: NDArray[np.bool_], u: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Twice the log-likelihood, negative, with those ``free`` fitted; the place, and the curvature."""
        u = u.copy()
        for nth in range(_STEPS + 1):
            view = prepared.likelihood.views(prepared.likelihood.rows(at, -np.expm1(-u[None])))[0]
            room = np.exp(-u)
            curvature = view.curvature[np.ix_(at, at)] * np.outer(room, room) + 1e-6 * np.eye(at.size)
            gain = view.gain[at] * room
            ahead = np.clip(np.linalg.solve(curvature[np.ix_(free, free)], gain[free]), -_LONGEST, _LONGEST)
            moved = np.clip(u[free] + ahead, 0.0, FURTHEST) - u[free]
            if nth == _STEPS or np.abs(moved).max(initial=0.0) < _RESTS:
                break
            u[free] += moved
        return -2.0 * view.log_likelihood, u, curvature

    def resting(u: FloatArray) -> tuple[str, ...]:
        return tuple(called[nth] for nth in own if nth != j and u[nth] <= 0.0)

    begin = -np.log1p(-np.minimum(one.severities, HIGHEST))
    squares, u, curvature = refitted(np.ones(at.size, dtype=bool), begin)
    std = float(np.sqrt(np.linalg.inv(curvature)[j, j]))
    held = (lambda u: refitted(own != j, u)[:2]), (lambda place: -float(np.expm1(-place))), resting
    return Section(j, u, squares, std, FURTHEST, *held).profile(name, level, points)
