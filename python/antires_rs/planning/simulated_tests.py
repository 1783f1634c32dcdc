"""Tests that were not made: a structure beside its model, intact and damaged, and values with errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Any

import numpy as np

from .. import _core
from ..damage.assess import assess_damage
from ..damage.inference import HIGHEST, intact_slopes, log_odds_threshold
from ..damage.likelihood import ERRORS, Likelihood, ModelError, factors_of, learned
from ..damage.measured_states import FALSE, FOUND, Roots, Values, roots_at
from ..damage.options import DamagePrior, SearchOptions
from ..damage.shapes import BOUNDS
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.parameters import stiffness_reduction
from ..support.checks import BoolArray, FloatArray, IntArray
from ..support.progress import step
from ..support.workers import in_order
from ..updating.posterior import log_between
from .detection_curves import rising
from .placement import Layout

_MARGIN = 1.5  # roots are followed so far beyond the band: damage may bring them in


@dataclass(frozen=True)
class VirtualTest:
    """A kind of test, the elements in question, errors of values and of the model."""

    layout: Layout
    elements: tuple[int, ...]
    #: For every sensor ln f and relative standard deviation of the model's roots, between which it is linear.
    std: tuple[tuple[FloatArray, FloatArray], ...]
    model_error: float  # standard deviation of ln of every stiffness and mass about the model's

    def __getstate__(self) -> dict[str, Any]:
        # Without the core's objective, which each process makes again.
        return {name: held for name, held in self.__dict__.items() if name != "core"}

    @cached_property
    def numbers(self) -> list[int]:
        """Elements in the order of the core's parameters: candidates, then the others."""
        return [*self.elements, *(e for e in self.layout.model._springs if e not in self.elements)]

    @cached_property
    def core(self) -> tuple[_core.Objective, int]:
        """Roots by all severities and all factors; and the number of factors."""
        factors = factors_of(self.layout.model)
        parameters = (*stiffness_reduction(self.numbers), *factors)
        high_hz = _MARGIN * self.layout.band_hz[1]
        return self.layout.roots(parameters, high_hz, self.layout.sees), len(factors)

    def truth(self, rng: np.random.Generator) -> FloatArray:
        """Factors of a structure."""
        return np.clip(np.exp(self.model_error * rng.standard_normal(self.core[1])), *BOUNDS)

    def roots(self, factors: FloatArray, damage: Sequence[tuple[int, float]], threads: int) -> list[Roots]:
        """Roots of the structure with each damage: place of the element among the candidates, severity."""
        rows = np.zeros((len(damage), len(self.numbers) + factors.size))
        rows[:, len(self.numbers) :] = factors
        for row, (place, severity) in zip(rows, damage, strict=True):
            row[place] = severity
        return roots_at(self.core[0], rows, slopes=False, threads=threads)

    def values(self, roots: Roots, rng: np.random.Generator) -> Values:
        """What a test gives of roots in its band."""
        kept, std = self.layout.inside(roots), np.empty(roots.size)
        every = np.concatenate([own for _, own in self.std])
        for nth, (log_f, own) in enumerate(self.std):
            mine = roots.response == nth
            std[mine] = np.interp(roots.log_f[mine], log_f, own) if own.size else np.median(every)
        std = std[kept]
        log_f = roots.log_f[kept] + std * rng.standard_normal(std.size)
        return Values(roots.response[kept], log_f, std, np.zeros(std.size, dtype=np.intp))

    def measured(self, roots: Roots, rng: np.random.Generator) -> AntiresonanceSet:
        """The same as a set."""
        values, layout = self.values(roots, rng), self.layout
        own = {dof: values.response == nth for nth, dof in enumerate(layout.responses)}
        freq = {dof: np.exp(values.log_f[at]) for dof, at in own.items()}
        std = {dof: values.std[at] * freq[dof] for dof, at in own.items()}
        seen: Any = {"sees": layout.sees, "channels": layout.sensors}
        return AntiresonanceSet(layout.force, freq, std_hz=std, **seen)


def along(intact: Roots, states: Sequence[Roots]) -> list[IntArray]:
    """Number of the intact root that each root of each state has been, -1 for new ones; step by step."""
    found, identity = [], np.arange(intact.size)
    for before, state in zip([intact, *states], states, strict=False):
        step = state.since(before)[1]
        found.append(identity := np.where(step >= 0, identity[step], -1))
    return found


# -- A quick judge of virtual tests: the evidence of every single element, without a search
#
# After the baseline the model is evaluated once for each element on a grid of severities. Tests are then
# judged by linear algebra at the points next to the best one, with mean, covariance and evidence as in
# :mod:`antires_rs.damage`; a value that one of the states lacks costs what a root missed costs there.

#: Severities of the grid: ln(1 - beta) in steps of a tenth.
GRID = -np.expm1(-np.array([0.0, 0.005, 0.015, 0.03, 0.05, *np.arange(0.1, 3.6, 0.1)]))
#: Points of the grid that each element is judged at, and how far from one its linear model reaches; points
#: that are judged under their own covariance to find these.
_POINTS, _LINEAR, _POOL = 3, 0.12, 6
#: Log likelihood by which a point may lie below the best before any error is drawn: so much below this
#: multiple of the best.
_HOPELESS = (50.0, 3.0)
_BLIND = 1e-6
#: What a value costs that has no root in reach, and a root that has no value; from how many standard
#: deviations on it is so.
_ALONE, _MISSED, _OUTSIDE = -float(np.log(FALSE)), -float(np.log1p(-FOUND)), 5.0
_COMMON = 0.5
_FAR = 1e3


@dataclass
class Judge:
    """After one baseline: hypotheses, a row of the arrays each, none first, then the grid of elements."""

    test: VirtualTest
    prior: DamagePrior
    baseline: Values
    threads: int
    options: SearchOptions
    rng: np.random.Generator

    def __post_init__(self) -> None:
        core, n_factors = self.test.core
        n = len(self.test.numbers)
        error = learned(core, n, np.zeros(n_factors, dtype=np.intp), self.baseline, None, self.threads)
        self.n = n
        rows = np.zeros((1 + n * GRID.size, n + n_factors))
        rows[:, n:] = np.exp(error.theta)
        self.element = np.repeat(np.arange(n), GRID.size)
        self.beta = np.concatenate([[0.0], np.tile(GRID, n)])
        rows[np.arange(1, rows.shape[0]), self.element] = self.beta[1:]
        self._tabulate(error, roots_at(core, rows, slopes=True, threads=self.threads))
        states = (self.baseline, self.baseline)
        likelihood = Likelihood(core, n, error, *states, self.options.std_common, self.threads)
        (slopes,) = intact_slopes(likelihood, len(self.test.elements))
        self.threshold = log_odds_threshold(slopes, self.prior, self.options, self.rng)

    def _tabulate(self, error: ModelError, found: list[Roots]) -> None:
        """Place, covariance and slope of every value under every hypothesis."""
        m, count = self.baseline.size, len(found)
        kappa = error.outside * sum(multiple * p for multiple, _, p in ERRORS)
        self.place, self.present = np.zeros((count, m)), np.zeros((count, m), dtype=bool)
        self.white, self.raw, self.scale = np.zeros((count, m, m)), np.zeros((count, m)), np.ones((count, m))
        self.log_det = np.zeros(count)
        factors = np.exp(error.theta)
        own = [0, *self.element.tolist()]
        identities = [np.arange(error.intact.size)]
        for states in np.split(np.arange(1, count), self.n):
            identities += along(error.intact, [found[h] for h in states])
        for h, (roots, identity) in enumerate(zip(found, identities, strict=True)):
            places = np.full(error.intact.size + 1, -1)  # the last one stands for none
            old = np.flatnonzero(identity >= 0)
            places[identity[old]] = old
            at = places[error.partner]
            has = np.flatnonzero((at >= 0) & (error.partner >= 0))
            root = at[has]
            by_theta = roots.slopes[root, self.n :] * factors
            mean, spread = error.predicted(by_theta, identity[root])
            change = roots.log_f[root] - error.intact.log_f[identity[root]]
            size = change**2 + _COMMON * np.mean(change**2) if root.size else change
            spread[np.diag_indices(root.size)] += self.baseline.std[has] ** 2 + kappa**2 * size
            spread += self.options.std_common**2
            triangle = np.linalg.cholesky(spread)
            self.white[h][np.ix_(has, has)] = np.linalg.inv(triangle)
            self.log_det[h] = float(np.log(np.diag(triangle)).sum())
            self.place[h, has], self.present[h, has] = roots.log_f[root] + mean, True
            self.raw[h, has] = roots.slopes[root, own[h]]
            self.scale[h, has] = np.sqrt(np.diag(spread))

    def found(self, log_f: FloatArray, there: BoolArray, draws: int) -> tuple[FloatArray, float]:
        """Share of tests in which each candidate is declared damaged, and in which any is."""
        values = log_f[:, None] + self.baseline.std[:, None] * self.rng.standard_normal((log_f.size, draws))
        paired = self._paired(log_f, there)
        self.missed = _ALONE * (there & ~paired).sum(axis=1) + _MISSED * (self.present & ~paired).sum(axis=1)
        at = self._near(log_f, paired)
        evidence = np.full((self.n, _POINTS, draws), -np.inf)
        evidence[at >= 0] = self._evidence(at[at >= 0], values, paired)
        evidence = evidence.max(axis=1)
        nothing = self._plain(np.array([0]), values, paired)[1][0]
        count = len(self.test.elements)
        evidence[:count] += self.prior.log_of(1, count)
        evidence[count:] += self.prior.log_elsewhere(max(self.n - count, 1))
        nothing = nothing + self.prior.log_of(0, count)
        best = np.argmax(evidence, axis=0)
        declared = (evidence.max(axis=0) > nothing) & (best < count)
        if self.threshold is not None:
            best = np.argmax(evidence[:count], axis=0)
            declared = np.logaddexp.reduce(evidence[:count], axis=0) - nothing > self.threshold
        share = np.bincount(best[declared], minlength=self.n)[:count] / draws
        return share, float(declared.mean())

    def _paired(self, log_f: FloatArray, there: BoolArray) -> BoolArray:
        """Values that each hypothesis explains, (hypotheses, m), at the severity that most ask for."""
        both = self.present & there
        residual = np.where(both, log_f - self.place, 0.0)
        weight = np.where(both, np.abs(self.raw) / self.scale, 0.0)
        asked = np.divide(residual, self.raw, out=np.zeros_like(residual), where=weight > 0.0)
        order = np.argsort(asked, axis=1)
        reached = np.cumsum(np.take_along_axis(weight, order, axis=1), axis=1)
        half = np.argmax(reached >= 0.5 * reached[:, -1:], axis=1)[:, None]
        step = np.take_along_axis(asked, np.take_along_axis(order, half, axis=1), axis=1)
        most = _LINEAR * (1.0 - self.beta[:, None])
        step = np.clip(step, -most, most)
        along = self.raw * step
        return np.asarray(both & (np.abs(residual - along) < _OUTSIDE * self.scale + _LINEAR * np.abs(along)))

    def _near(self, log_f: FloatArray, paired: BoolArray) -> IntArray:
        """Points of each element's grid that explain the true values best, (n, points); -1: hopeless."""
        residual = np.where(paired, log_f - self.place, 0.0)
        raw = np.where(paired, self.raw, 0.0)
        white = self.white[0].T
        intact = self._worth(residual @ white, raw @ white) - self.missed
        shape = (self.n, GRID.size)
        by_worth = np.argsort(-intact[1:].reshape(shape), axis=1)[:, :_POOL]
        by_count = np.lexsort((-intact[1:].reshape(shape), self.missed[1:].reshape(shape)))[:, :_POOL]
        at = 1 + np.hstack([by_worth, by_count]) + GRID.size * np.arange(self.n)[:, None]
        every = np.unique(at)
        left, slope = ((self.white[every] @ rows[every][:, :, None])[:, :, 0] for rows in (residual, raw))
        worth = np.full(intact.size, -np.inf)
        worth[every] = self._worth(left, slope, every) - self.missed[every] - self.log_det[every]
        order = np.argsort(-worth[1:].reshape(shape), axis=1)[:, :_POINTS]
        at = 1 + order + GRID.size * np.arange(self.n)[:, None]
        return np.where(worth[at] > _HOPELESS[1] * min(worth.max(), 0.0) - _HOPELESS[0], at, -1)

    def _worth(self, left: FloatArray, slope: FloatArray, at: Any = slice(None)) -> FloatArray:
        """Log likelihood at the best severity of each point; where that is too far, very little."""
        gain, curvature = (left * slope).sum(axis=1), (slope**2).sum(axis=1) + _BLIND
        step = np.clip(self.beta[at] + gain / curvature, 0.0, HIGHEST) - self.beta[at]
        worth = -0.5 * (left**2).sum(axis=1) + gain * step - 0.5 * curvature * step**2
        return np.asarray(worth - _FAR * _too_far(self.beta[at] + step, self.beta[at]))

    def _plain(self, at: IntArray, values: FloatArray, paired: BoolArray) -> tuple[FloatArray, FloatArray]:
        """Whitened residuals at these points (points, m, draws), and log likelihood there (points, draws)."""
        residual = np.where(paired[at][:, :, None], values - self.place[at][:, :, None], 0.0)
        left = self.white[at] @ residual
        likelihood = -0.5 * (left**2).sum(axis=1) - (self.log_det[at] + self.missed[at])[:, None]
        return left, likelihood

    def _evidence(self, at: IntArray, values: FloatArray, paired: BoolArray) -> FloatArray:
        """Log evidence at these points, (points, draws); where the best severity is too far, very little."""
        left, likelihood = self._plain(at, values, paired)
        slope = (self.white[at] @ np.where(paired[at], self.raw[at], 0.0)[:, :, None])[:, :, 0]
        gain = (slope[:, None, :] @ left)[:, 0, :]
        curvature, beta = (slope**2).sum(axis=1)[:, None] + _BLIND, self.beta[at][:, None]
        mean, sd = beta + gain / curvature, 1.0 / np.sqrt(curvature)
        inside = log_between(-mean / sd, (HIGHEST - mean) / sd)
        volume = np.log(np.sqrt(2.0 * np.pi) * sd / HIGHEST)
        far = _too_far(np.clip(mean, 0.0, HIGHEST), beta)
        return np.asarray(likelihood + 0.5 * gain**2 / curvature + volume + inside - _FAR * far)


def _too_far(best: FloatArray, beta: FloatArray) -> FloatArray:
    """By how much a severity lies beyond the reach of the linear model about another one."""
    return np.asarray(np.maximum(np.abs(np.log1p(-best) - np.log1p(-beta)) - _LINEAR, 0.0))


# -- Probability of detection by linear algebra: some structures with their baselines, many tests of each

_DRAWS = 64  # tests of each structure and damage


def predicted(
    test: VirtualTest,
    severities: Sequence[FloatArray],
    prior: DamagePrior,
    options: SearchOptions,
    seeds: Sequence[np.random.SeedSequence],
    threads: int,
) -> tuple[list[FloatArray], float, int]:
    """Share of tests that find each severity of each candidate, rate of false calls, structures judged."""
    # Between the severities asked for there are others, so that no root goes far in one step.
    steps = [np.unique(np.concatenate([betas, GRID[betas[-1] > GRID]])) for betas in severities]
    damage = [(place, float(beta)) for place, betas in enumerate(steps) for beta in betas]

    def of_structure(rng: np.random.Generator) -> tuple[list[FloatArray], float]:
        intact, *damaged = test.roots(test.truth(rng), [(0, 0.0), *damage], threads)
        judge = Judge(test, prior, test.values(intact, rng), threads, options, rng)
        kept, left = np.flatnonzero(test.layout.inside(intact)), iter(damaged)
        found = []
        for place, (betas, asked) in enumerate(zip(steps, severities, strict=True)):
            states = list(islice(left, betas.size))
            identities = along(intact, states)
            shares = []
            for nth in np.searchsorted(betas, asked):
                log_f = np.full(intact.size, np.nan)
                seen = (identities[nth] >= 0) & test.layout.inside(states[nth])
                log_f[identities[nth][seen]] = states[nth].log_f[seen]
                there = np.isfinite(log_f[kept])
                share, _ = judge.found(np.where(there, log_f[kept], 0.0), there, _DRAWS)
                shares.append(share[place])
            found.append(np.array(shares))
        _, call = judge.found(intact.log_f[kept], np.ones(kept.size, dtype=bool), 4 * _DRAWS)
        return found, call

    found: list[tuple[list[FloatArray], float]] = []
    try:
        for nth, seed in enumerate(seeds):
            step(f"structure {nth + 1} of {len(seeds)}")
            found.append(of_structure(np.random.default_rng(seed)))
    except KeyboardInterrupt:
        if not found:
            raise
    shares, calls = zip(*found, strict=True)
    mean = [rising(np.mean(of_element, axis=0)) for of_element in zip(*shares, strict=True)]
    return mean, float(np.mean(calls)), len(shares)


# -- Probability of detection by whole assessments: structures drawn, values drawn, ``assess_damage`` asked


@dataclass(frozen=True)
class Task:
    """One virtual test: place of the damaged element among the candidates (None: intact), its severity."""

    place: int | None
    severity: float
    prior: DamagePrior
    options: SearchOptions
    seed: np.random.SeedSequence
    threads: int


def judged(test: VirtualTest, task: Task) -> tuple[int, ...]:
    """Elements that ``assess_damage`` declares damaged."""
    rng = np.random.default_rng(task.seed)
    factors = test.truth(rng)
    damage = (0, 0.0) if task.place is None else (task.place, task.severity)
    intact, now = test.roots(factors, [(0, 0.0), damage], task.threads)
    measured: Any = {"measured": test.measured(now, rng), "baseline": test.measured(intact, rng)}
    asked: Any = {"elements": list(test.elements), "prior": task.prior, "search": task.options}
    how: Any = {"rng": int(rng.integers(2**32)), "workers": task.threads, "progress": False}
    return assess_damage(test.layout.model, **measured, **asked, **how).assessment.declared


def simulated(test: VirtualTest, tasks: Sequence[Task], workers: Any) -> list[tuple[int, ...]]:
    """What each test declares, in order; after Ctrl-C those that are there."""
    found: list[tuple[int, ...]] = []
    try:
        found.extend(in_order(judged, tasks, workers, shared=test, what="test"))
    except KeyboardInterrupt:
        if not found:
            raise
    return found
