"""The search of :mod:`~antires_rs.damage.inference` with antiresonances from tables, for one test.

A scan, its refinement and the errors of predictions come from the tables; the antiresonances of the sets that
are judged are computed, so that what is most probable is what a full run has.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np

from .. import _core
from ..support.checks import FloatArray
from .assessor_plan import LEVELS, Plan
from .evidence import FURTHEST, HIGHEST, Fit, refitted
from .inference import Elements, Search
from .likelihood import Band, Errors, ValueLikelihood, View
from .measured_states import Values

#: Errors with which extra ones of every value are seen: as they are stated.
_STATED: Errors = ((0.0, 1.0, 1.0),)


class TabulatedLikelihood(ValueLikelihood):
    """p(values of a test | severities), errors of predictions and slopes from tables."""

    def __init__(self, plan: Plan, now: Values) -> None:
        self.plan, self.now, self.n = plan, now, len(plan.question.numbers)
        low, high = float(now.log_f.min()), float(now.log_f.max())
        self.band = Band(min(plan.learned.low, low), max(plan.learned.high, high))
        self._asked = np.arange(int(plan.tables.response.max(initial=-1)) + 1)
        self.test = self._test(0.0, 0.0)
        self.start = self.seen((), np.empty(0))

    def _errors(self, extra: float) -> Errors:
        return _STATED if extra else self.plan.errors

    def _test(self, extra: float, common: float) -> _core.PreparedTest:
        now, plan = self.now, self.plan
        return _core.PreparedTest(
            plan.tables_in_core,
            now.response.tolist(),
            now.log_f.tolist(),
            (np.hypot(now.std, extra) if extra else now.std).tolist(),
            now.test.tolist(),
            now.times_measured(self._asked).tolist(),
            (self.band.low, self.band.high),
            float(np.hypot(plan.question.options.std_common, common)),
            list(self._errors(extra)),
            plan.learned.outside,
        )

    def without_damage(self, extra: float, common: float) -> View:
        """See the base class."""
        found = self._test(extra, common).look([], [])
        return self._view(np.zeros(self.n), found, self._errors(extra))

    def log_without_damage(self, extra: float, common: float) -> float:
        """The same without slopes."""
        return float(self._test(extra, common).settle([([], [])], 1, 0.0, True)[0][-1])

    def of_frequencies(self, view: View) -> Any:
        """All values are."""
        return np.ones(view.residual.size, dtype=bool)

    def views(self, betas: FloatArray, extra: float = 0.0) -> list[View]:
        """See the base class; with computed antiresonances."""
        sets = [tuple(np.flatnonzero(beta).tolist()) for beta in betas]
        return [self.computed(s, -np.log1p(-beta[list(s)])) for s, beta in zip(sets, betas, strict=True)]

    def unexplained(self, betas: FloatArray) -> FloatArray:
        """See the base class; by the roots of the tables."""
        sets = [np.flatnonzero(beta) for beta in betas]
        asked = [(s.tolist(), (-np.log1p(-b[s])).tolist()) for s, b in zip(sets, betas, strict=True)]
        return np.array([left for _, left in self.test.refine(asked, 0)])

    def seen(self, elements: Elements, u: FloatArray, *places: Any) -> View:
        """From severities of some elements; ``places`` are ln f of the roots (r,), whether they are there,
        and slopes, in place of those of the tables."""
        beta = np.zeros(self.n)
        beta[list(elements)] = -np.expm1(-u)
        return self._view(beta, self.test.look(list(elements), u.tolist(), *places), self.plan.errors)

    def computed(self, elements: Elements, u: FloatArray, *, slopes: bool = False) -> View:
        """The same with computed antiresonances, and slopes where they are asked for."""
        _, beside, _ = self.test.places(list(elements), u.tolist())
        beta = np.zeros(self.n)
        beta[list(elements)] = -np.expm1(-u)
        log_f, by_u = self.plan.exact(beta, self.band, slopes=slopes)
        there = np.isfinite(log_f)
        return self.seen(elements, u, np.where(there, log_f + beside, 0.0).tolist(), there.tolist(), by_u)

    def _view(self, beta: FloatArray, found: Any, errors: Errors) -> View:
        log_likelihood, gain, curvature, error, *rest = found
        return View(beta, log_likelihood, gain, curvature, *errors[error][:2], *rest)


#: Sets so near to the likeliest (log probability) are judged, at most so many of each size; more of them may
#: be found than are.
_NEAR, _MOST = 2.5, 8
#: The same of sets in the linear model of another one's view.
_NEAR_LINEAR = 1.0
#: Sets that a scan leaves, by their number of elements; what it refines, by distances and by misfits.
_LIKELIEST, _BY_DISTANCE, _BY_MISFIT = (14, 8, 6), 12, 14
#: Steps of the refinement; sets so far behind the first of them (log-likelihood) are given up.
_STEPS, _HOPELESS = 2, 25.0
#: So many elements join a set of one and of two in the linear model of its view.
_JOINED = (0, 10, 3)
#: A set is judged anew where its severities are further (u) than this from where it was judged; so often; and
#: the same for those of the answer.
_RESTS, _LOOKS, _SURE_RESTS = 0.03, 3, 2e-3
#: Sets within this of the likeliest are judged at the end, so many.
_CLOSE, _LAST = 1.0, 3


@dataclass
class QuickSearch(Search):
    """A search in tables, which judges the few sets that may be the answer.

    ``rough`` are log evidence and severities (u) of sets as the tables have them, ``judged`` those that were
    judged from their own severities; ``cut`` tells whether sets that may be the most probable ones were not.
    """

    likelihood: TabulatedLikelihood
    rough: dict[Elements, tuple[float, FloatArray]] = field(default_factory=dict)
    judged: set[Elements] = field(default_factory=set)
    cut: bool = False

    def _pairs(self) -> dict[Elements, FloatArray]:
        """Too many for a quick search."""
        return {}

    def _starts(self, size: int) -> dict[Elements, FloatArray]:
        """The sets with one element more that explain most at any severity, and their severities (u)."""
        chosen = self._scanned(size)
        asked = [(list(elements), u) for (elements, _), u in chosen.items()]
        best: dict[Elements, tuple[float, FloatArray]] = {}
        for (elements, _), (u, score) in zip(chosen, self.likelihood.test.refine(asked, _STEPS), strict=True):
            if elements not in best or score < best[elements][0]:
                best[elements] = score, np.array(u)
        likeliest = sorted(best, key=lambda s: best[s][0])[: _LIKELIEST[size - 1]]
        if size == 1:
            self.hopeless.update((e,) for e in range(self.likelihood.n) if (e,) not in likeliest)
        return {s: best[s][1] for s in likeliest if best[s][0] < best[likeliest[0]][0] + _HOPELESS}

    def _scanned(self, size: int) -> dict[tuple[Elements, int], list[float]]:
        """What a scan refines: sets with the level of their last element, and all severities (u)."""
        known = {s: one[0] for s, one in self.rough.items()}
        known |= {s: fit.log_evidence for s, fit in self.fits.items()}
        own = [s for s in (*self.fits, *self.rough) if len(s) == size - 1 and not self.outside(s)]
        parents = sorted(dict.fromkeys(own), key=lambda s: -known[s])[: self._most_parents(size - 1)]
        scans: tuple[list[FloatArray], ...] = ([], [])
        joined: list[tuple[Elements, int]] = []
        for parent in parents:
            further = self._further(parent)
            if further:
                found = self.likelihood.test.scan(list(parent), self._u(parent).tolist(), further)
                for scan, one in zip(scans, found, strict=True):
                    scan.append(one)
                joined += [(parent, e) for e in further]
        chosen: dict[tuple[Elements, int], list[float]] = {}
        few = (_BY_DISTANCE, _BY_MISFIT if size > 1 else len(joined))
        for scan, most in zip(scans if joined else (), few, strict=False):
            left = np.concatenate(scan)
            level = np.argmin(left, axis=1)
            order = np.argsort(left[np.arange(level.size), level], kind="stable").tolist()
            sets = (self._with(joined[nth][0], joined[nth][1], int(level[nth])) for nth in order)
            for elements, at, u in islice((one for one in sets if one[0] not in self.judged), most):
                chosen.setdefault((elements, at), u)
        return chosen

    def _with(self, parent: Elements, further: int, level: int) -> tuple[Elements, int, list[float]]:
        """A set with one element more, the level of its severity, and all severities (u)."""
        own = zip(parent, self._u(parent).tolist(), strict=True)
        joined = sorted([*own, (further, float(LEVELS[level]))])
        return tuple(e for e, _ in joined), level, [u for _, u in joined]

    def _larger(self, elements: Elements, view: View) -> list[int]:
        """Elements that would gain something, and those without damage all."""
        further, gains = self._further(elements), view.gains
        return sorted(further, key=lambda e: -gains[e])[: _JOINED[len(elements)]] if elements else further

    def _u(self, elements: Elements) -> FloatArray:
        fit, rough = self.fits.get(elements), self.rough.get(elements)
        if rough and (fit is None or rough[0] > fit.log_evidence):
            return rough[1]
        return _within(self.fits[elements])

    def _refine(self, chosen: dict[Elements, FloatArray]) -> None:
        """Judge those that may be the most probable ones, the likeliest first."""
        asked = [(list(s), u.tolist()) for s, u in chosen.items()]
        looks = 2 if chosen and len(next(iter(chosen))) == 1 else 1
        settled = self.likelihood.test.settle(asked, looks, _RESTS, False)
        for elements, (_, ahead, _, _, log_evidence, _) in zip(chosen, settled, strict=True):
            if elements not in self.judged:
                self.rough[elements] = log_evidence, np.minimum(ahead, FURTHEST)
        for _ in range(_MOST):
            near = self._open()
            if not near:
                return
            self._settle(near[0])
        self.cut = bool(self._open())

    def _weights(self) -> dict[Elements, float]:
        return {s: fit.log_evidence + self.log_prior(s) for s, fit in self.fits.items()}

    def _open(self) -> list[Elements]:
        """Sets that may be the answer and were not judged from their own severities, the likeliest first."""
        weights = self._weights()
        top = max(weights.values())
        room = {s: _NEAR_LINEAR for s in weights}
        for s, (log_evidence, _) in self.rough.items():
            weight = log_evidence + self.log_prior(s)
            if s not in weights or weight + _NEAR > weights[s] + _NEAR_LINEAR:
                weights[s], room[s] = weight, _NEAR
        near = (s for s, w in weights.items() if s and s not in self.judged and w > top - room[s])
        return sorted(near, key=lambda s: -weights[s])

    def _settle(self, elements: Elements) -> None:
        """Judge a set from its own severities."""
        u = self._u(elements)
        ((_, ahead, *_),) = self.likelihood.test.settle([(list(elements), u.tolist())], 5, _RESTS, True)
        u = np.minimum(ahead, FURTHEST)
        for _ in range(_LOOKS):
            view = self.likelihood.computed(elements, u)
            fit = refitted(view, elements)
            moved = _within(fit) - u
            if np.abs(moved).max() <= _RESTS:
                break
            u = u + moved
        self.rough.pop(elements, None)
        self.judged.add(elements)
        self.fits[elements] = fit
        self._judge(elements, view)

    def _renew(self) -> None:
        """Judge the likeliest sets anew, with computed slopes, until none that was not may be the answer."""
        done: set[Elements] = set()
        while len(done) < _LAST:
            weights = self._weights()
            top = max(weights.values())
            near = [s for s, w in weights.items() if s and s not in done and w > top - _CLOSE]
            if not near:
                return
            best = max(near, key=lambda s: weights[s])
            for _ in range(_LOOKS):
                u = self._u(best)
                self.fits[best] = refitted(self.likelihood.computed(best, u, slopes=len(best) > 1), best)
                if np.abs(self._u(best) - u).max() <= _SURE_RESTS:
                    break
            done.add(best)


def _within(fit: Fit) -> FloatArray:
    """Most probable severities of a set (u), within their bounds."""
    return np.asarray(-np.log1p(-np.minimum(fit.beta, HIGHEST)))
