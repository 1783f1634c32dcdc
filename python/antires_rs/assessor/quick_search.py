"""Which elements may be damaged, as :func:`antires_rs.assess_damage` searches, by what was prepared.

All single elements and pairs are judged by the slopes of no damage. Where that leaves something unexplained,
a further element is tried at all its severities beside the likeliest sets (``starts``), as a full run does,
and in place of each element of the likeliest. The likeliest sets then are judged by the likelihood itself,
until no other one can be more probable.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..damage.evidence import FURTHEST, HIGHEST, Fit, fitted
from ..damage.measured_states import Values
from ..damage.prior import DamagePrior
from ..damage.search import Elements, explained
from ..damage.view import Band, View
from ..support.validation import FloatArray
from .anything import something_else
from .interpolated import Interpolated
from .linear import further_gains, pair_evidence, single_evidence
from .starts import starts

__all__ = ["QuickSearch"]

#: Sets within this of the likeliest (log probability) are judged by the likelihood; the same for those that a
#: scan has found, whose errors are those without damage, and for elements as they are seen where errors have
#: to be wider than stated, which hide what an element would explain.
_NEAR, _NEAR_ROUGH, _HIDDEN = 1.0, 2.5, 5.0
#: At most so many of each stage; so many of a scan are judged however likely they look, but not those so far
#: below the first of them.
_MOST, _FROM_SCAN, _HOPELESS = 8, 3, 12.0
#: A set is judged anew where its severities are further (u) than this from where it was judged; so often.
_RESTS, _LOOKS = 0.03, 5
#: Sets that get a further element, by their number of elements, and where nothing is better than a change
#: that no element explains.
_PARENTS, _UNTOLD = (1, 8, 4), 16
#: Sets of a scan that are judged, with the errors that the model has without damage, by their number of
#: elements; how often an element of the likeliest set is exchanged, and so many sets of that.
_LIKELIEST, _EXCHANGES, _EXCHANGED = (14, 8, 6), 3, 6
#: Gain of the log-likelihood from which on a third element is looked at, and how many of them.
_GAIN, _THIRDS = 3.0, 3


@dataclass
class QuickSearch:
    """A test of now; ``n`` elements, candidates first."""

    tables: Interpolated
    now: Values
    band: Band
    common: float
    errors: tuple[tuple[float, float, float], ...]
    outside: float
    n: int
    n_candidates: int
    prior: DamagePrior
    pairs: NDArray[np.intp]
    #: Sets that were judged from their own severities; but for those in ``views`` with the view of no damage.
    fits: dict[Elements, Fit] = field(default_factory=dict)
    views: set[Elements] = field(default_factory=set)
    #: Log evidence of each set that was looked at, and its most probable u.
    evidence: dict[Elements, float] = field(default_factory=dict)
    u: dict[Elements, FloatArray] = field(default_factory=dict)
    #: Sets whose evidence is that of a scan.
    rough: set[Elements] = field(default_factory=set)
    #: Sets judged from severities that a scan has left, and these.
    judged_before: dict[Elements, tuple[Fit, FloatArray, bool]] = field(default_factory=dict)
    #: The view that each set's evidence is from, where it is not one from its own severities.
    seen_from: dict[Elements, View] = field(default_factory=dict)
    #: Log of prior times evidence.
    weights: dict[Elements, float] = field(default_factory=dict)
    #: Log probability that the slopes of no damage promise a pair which they do not reach.
    pair_hint: float = -np.inf
    #: Whether sets that may be the most probable ones were not judged.
    cut: bool = False
    something_else: float = -np.inf
    #: Relative change of all values, where that is what something else comes to; else 0.
    moved_alike: float = 0.0

    def run(self) -> None:
        """Judge what may be the answer."""
        start = self.view((), np.empty(0))
        none = np.empty(0)
        self.fits[()] = Fit((), start.log_likelihood, none, none, np.empty((0, 0)), start)
        self.views.add(())
        self._keep((), start.log_likelihood, none)
        foreseen = self.tables.undamaged(self.band, self.common)
        self.something_else, self.moved_alike = something_else(self.now, foreseen, self.band)
        self._singles(start)
        self._pairs(start, self.pairs)
        best: Elements = ()
        if self.explained(()):
            best = self._settle()
        for size in (1, 2, 3):
            if size > self.n_candidates or not np.isfinite(self.log_prior[size]):
                break
            if len(best) < size and self.explained(best):
                break
            self._enlarge(size)
            best = self._settle()
            for _ in range(_EXCHANGES if size > 1 and len(best) == size else 0):
                before = best
                self._exchange(best)
                best = self._settle()
                if best == before:
                    break

    @cached_property
    def test(self) -> _core.PreparedTest:
        """The values, handed over."""
        now = self.now
        columns = (now.response.tolist(), now.log_f.tolist(), now.std.tolist(), now.test.tolist())
        times = now.times_measured(np.arange(int(self.tables.tables.response.max(initial=-1)) + 1)).tolist()
        band = (self.band.low, self.band.high)
        return _core.PreparedTest(
            self.tables.core, *columns, times, band, self.common, list(self.errors), self.outside
        )

    @cached_property
    def log_prior(self) -> tuple[float, ...]:
        """Of each set of none to three candidates, and of an element that is none."""
        n, others = self.n_candidates, self.n - self.n_candidates
        own = [self.prior.log_of(k, n) if k <= n else -np.inf for k in range(4)]
        return (*own, self.prior.log_elsewhere(others) if others else -np.inf)

    def explained(self, elements: Elements) -> bool:
        """Whether a judged set leaves nothing to be explained."""
        return explained(self.fit(elements), self.something_else)

    def beta(self, elements: Elements, u: FloatArray) -> FloatArray:
        """All severities (n,)."""
        beta = np.zeros(self.n)
        beta[list(elements)] = -np.expm1(-u)
        return beta

    def view(self, elements: Elements, u: FloatArray, *places: Any) -> View:
        """The values, as the likelihood has them; ``places`` are ln f of the roots (r,), whether they are
        there, and slopes, in place of those of the tables."""
        found = self.test.look(list(elements), u.tolist(), *places)
        log_likelihood, gain, curvature, error, partner, beside, residual, std, chi_square = found
        kappa, times, _ = self.errors[error]
        beta = self.beta(elements, u)
        return View(
            beta, log_likelihood, gain, curvature, kappa, times, partner, beside, residual, std, chi_square
        )

    def fit(self, elements: Elements) -> Fit:
        """A judged set, with the view from its own severities."""
        if elements not in self.views:
            self.keep(elements, self.u[elements], self.view(elements, self.u[elements]))
        return self.fits[elements]

    def keep(self, elements: Elements, u: FloatArray, view: View) -> None:
        """What the likelihood says of a set, from severities of its own."""
        fit = fitted(view, elements, reach=np.inf)
        assert fit is not None  # none is too far away
        self.fits[elements] = fit
        self.views.add(elements)
        self._keep(elements, fit.log_evidence, u)

    def _keep(self, elements: Elements, evidence: float, u: FloatArray) -> None:
        self.evidence[elements], self.u[elements] = evidence, u
        outside = any(e >= self.n_candidates for e in elements)
        self.weights[elements] = evidence + self.log_prior[4 if outside else len(elements)]

    def _singles(self, start: View) -> None:
        found = single_evidence(start)
        mean = (start.gain - 1.0) / (np.diag(start.curvature) + 1e-2)
        most = np.clip(mean, 0.0, FURTHEST)
        for e, one in enumerate(found.tolist()):
            self._keep((e,), one, most[e : e + 1])
            self.seen_from[(e,)] = start

    def _pairs(self, view: View, pairs: NDArray[np.intp]) -> None:
        """Pairs, as one view has them, where that is better than what is known."""
        if not len(pairs) or not np.isfinite(self.log_prior[2]):
            return
        found, best, beyond = pair_evidence(view, pairs)
        for nth in np.flatnonzero(np.isfinite(found)).tolist():
            key = (int(pairs[nth, 0]), int(pairs[nth, 1]))
            if key not in self.fits and found[nth] > self.evidence.get(key, -np.inf):
                self._keep(key, float(found[nth]), best[nth])
                self.seen_from[key] = view
                self.rough.discard(key)
        first = int(np.argmax(beyond))
        promised = float(beyond[first]) + self.log_prior[2]
        if view is self.fits[()].view:
            self.pair_hint = promised
        elif promised > max(self.weights.values()) - _NEAR:
            key = (int(pairs[first, 0]), int(pairs[first, 1]))
            if key not in self.fits:
                self.found_by_scan([(key, best[first])])

    def _thirds(self, elements: Elements, view: View) -> None:
        """Sets with one element more, as the view of a pair has them, where that may gain."""
        gains = further_gains(view, elements)[: self.n_candidates]
        for e in np.argsort(-gains, kind="stable")[:_THIRDS].tolist():
            key = tuple(sorted((*elements, e)))
            if gains[e] > _GAIN and key not in self.fits:
                fit = fitted(view, key)
                if fit and fit.log_evidence > self.evidence.get(key, -np.inf):
                    self._keep(key, fit.log_evidence, -np.log1p(-fit.beta))
                    self.seen_from[key] = view
                    self.rough.discard(key)

    def _enlarge(self, size: int) -> None:
        """Sets with one element more than the likeliest have."""
        known = [s for s in self.weights if len(s) == size - 1 and all(e < self.n_candidates for e in s)]
        told = max(self.evidence.values()) > self.something_else
        most = _PARENTS[size - 1] if told or size == 1 else _UNTOLD
        parents = sorted(known, key=lambda s: -self.weights[s])[:most]
        count = self.n if size == 1 else self.n_candidates
        known_to = [(s, self.u[s]) for s in parents]
        # A single element may have been judged where no slope leads on.
        known_sets = set(self.fits) if size > 1 else set()
        self.found_by_scan(starts(self.test, known_to, count, known_sets, _LIKELIEST[size - 1]))

    def _exchange(self, elements: Elements) -> None:
        """Sets with another element in place of one."""
        u = self.u[elements]
        parents = [(elements[:k] + elements[k + 1 :], np.delete(u, k)) for k in range(len(elements))]
        self.found_by_scan(starts(self.test, parents, self.n_candidates, set(self.fits), _EXCHANGED))

    def found_by_scan(self, sets: list[tuple[Elements, FloatArray]]) -> None:
        """Sets from severities near their own, with the errors that the model has without damage."""
        asked = [(list(s), u.tolist()) for s, u in sets]
        looks = 2 if sets and len(sets[0][0]) == 1 else 1
        settled = self.test.settle(asked, looks, _RESTS, False)
        for (elements, _), (_, u, _, _, log_evidence, _) in zip(sets, settled, strict=True):
            if elements in self.fits:
                if np.abs(self.u[elements] - u).max() <= _RESTS or log_evidence <= self.evidence[elements]:
                    continue
                judged = self.fits.pop(elements), self.u[elements], elements in self.views
                self.judged_before[elements] = judged
            self._keep(elements, log_evidence, np.array(u))
            self.rough.add(elements)
            self.seen_from.pop(elements, None)

    def _settle(self) -> Elements:
        """Judge the likeliest sets until the most probable one is sure; it is returned."""
        weights = self.weights
        looked = sorted(self.rough, key=lambda s: -weights[s])[:_FROM_SCAN]
        self.judge([s for s in looked if weights[s] > weights[looked[0]] - _HOPELESS])
        extended: set[Elements] = set()
        left = _MOST
        while True:
            best = max(self.fits, key=lambda s: weights[s])
            if 0 < len(best) < 3 and best not in extended and max(best) < self.n_candidates:
                extended.add(best)
                self._extend(best)
            top = weights[best]
            open_ = [s for s, w in weights.items() if s not in self.fits and w > top - self._room(s)]
            self.cut = len(open_) > left
            open_ = sorted(open_, key=lambda s: -weights[s])[: min(left, 3)]
            if not open_:
                return max(self.fits, key=lambda s: weights[s])
            left -= len(open_)
            self.judge(open_)

    def _room(self, elements: Elements) -> float:
        """How much likelier (log probability) a set may turn out."""
        if elements in self.rough:
            return _NEAR_ROUGH
        return _HIDDEN if len(elements) == 1 and self.seen_from[elements].times > 1.0 else _NEAR

    def _extend(self, elements: Elements) -> None:
        view = self.fit(elements).view
        if len(elements) > 1:
            self._thirds(elements, view)
            return
        others = np.array([e for e in range(self.n_candidates) if e != elements[0]], dtype=np.intp)
        self._pairs(view, np.sort(np.column_stack([np.full(others.size, elements[0]), others]), axis=1))

    def judge(self, sets: list[Elements]) -> None:
        """Sets from their own severities, by the likelihood."""
        start = self.fits[()].view
        asked = [(list(s), np.minimum(self.u[s], FURTHEST).tolist()) for s in sets]
        for s, found in zip(sets, self.test.settle(asked, _LOOKS, _RESTS, True), strict=True):
            at, ahead, mean, covariance, log_evidence, _ = found
            size = len(s)
            self.fits[s] = Fit(
                s,
                log_evidence,
                np.minimum(-np.expm1(-np.array(ahead)), HIGHEST),
                np.array(mean),
                np.array(covariance).reshape(size, size),
                start,
            )
            self._keep(s, log_evidence, np.array(at))
            self.rough.discard(s)
            self.views.discard(s)
            before = self.judged_before.pop(s, None)
            if before and before[0].log_evidence > log_evidence:
                self.fits[s] = before[0]
                self._keep(s, before[0].log_evidence, before[1])
                self.views.update([s] if before[2] else [])
