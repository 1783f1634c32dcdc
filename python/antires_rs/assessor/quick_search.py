"""Which elements may be damaged, by as few looks at the likelihood as tell the most probable set.

All single elements and pairs are judged by the slopes of no damage. Where that leaves something unexplained,
severities are scanned in the tables. The likeliest sets then are judged by the likelihood itself, as
:func:`antires_rs.assess_damage` does, until no other one can be more probable.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..damage.evidence import FURTHEST, Fit, fitted
from ..damage.measured_states import Values
from ..damage.prior import DamagePrior
from ..damage.search import Elements, explained
from ..damage.view import Band, View, viewed
from ..support.validation import FloatArray
from .anything import something_else
from .interpolated import Interpolated, Places
from .linear import pair_evidence, single_evidence
from .rough import Rough

__all__ = ["QuickSearch"]

#: Sets within this of the likeliest (log probability) are judged by the likelihood; at most so many.
_NEAR, _MOST = 1.0, 3
#: Sets from a scan that are judged however likely they look.
_FROM_SCAN = 2
#: Sets from a scan so far below the first of them (log probability) are not judged for that.
_HOPELESS = 25.0
#: A set is judged anew where its severities are further (u) than this from where it was judged.
_RESTS, _LOOKS, _LONGEST = 0.02, 4, 0.7
#: A set from a scan may turn out so much likelier (log probability) than it looked; and one as it is seen
#: where errors have to be wider than stated, which hide what an element would explain.
_ROUGH, _HIDDEN = 3.0, 5.0
#: Change of u up to which the slopes of one point serve.
_REACH = 0.12


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
    fits: dict[Elements, Fit] = field(default_factory=dict)
    #: Log evidence of each set that was looked at, and its most probable u.
    evidence: dict[Elements, float] = field(default_factory=dict)
    u: dict[Elements, FloatArray] = field(default_factory=dict)
    #: Sets whose evidence is that of a scan.
    rough: set[Elements] = field(default_factory=set)
    #: Sets judged from severities that a scan has left, and these.
    judged_before: dict[Elements, tuple[Fit, FloatArray]] = field(default_factory=dict)
    #: The view that each set's evidence is from.
    seen_from: dict[Elements, View] = field(default_factory=dict)
    #: Log of prior times evidence.
    weights: dict[Elements, float] = field(default_factory=dict)
    looks: int = 0
    #: Log probability that the slopes of no damage promise a pair which they do not reach.
    pair_hint: float = -np.inf
    #: Whether sets that may be the most probable ones were not judged.
    cut: bool = False
    something_else: float = -np.inf
    #: Relative change of all values, where that is what something else comes to; else 0.
    moved_alike: float = 0.0

    def run(self) -> None:
        """Judge what may be the answer."""
        start = self._view((), np.empty(0))
        none = np.empty(0)
        self.fits[()] = Fit((), start.log_likelihood, none, none, np.empty((0, 0)), start)
        self._keep((), start.log_likelihood, none)
        foreseen = self.tables.foreseen(self.tables.start, np.zeros(self.n), self.band, self.common)
        self.something_else, self.moved_alike = something_else(self.now, foreseen, self.band)
        self._singles(start)
        self._pairs(start, self.pairs)
        scanned: set[Elements] = set()
        best = max(self.weights, key=lambda s: self.weights[s])
        count = int(start.matched.sum())
        left = start.chi_square - 2.0 * (self.evidence[best] - start.log_likelihood)
        far = self.u[best].max(initial=0.0) > _REACH or left > 2.0 * count
        if far and not self.explained(()):
            scanned.add(())
            self._scan(())
        while True:
            best = self._settle()
            large = len(best) > 2 or any(e >= self.n_candidates for e in best)
            if self.explained(best) or (best in scanned) or (large and () in scanned):
                return
            # Where nothing is known beyond the reach of slopes, single elements come first.
            parent: Elements = best if () in scanned else ()
            scanned.add(parent)
            self._scan(parent)

    @cached_property
    def _rough(self) -> Rough:
        return Rough(self.tables, self.now, self.common, self.outside)

    def _keep(self, elements: Elements, evidence: float, u: FloatArray) -> None:
        self.evidence[elements], self.u[elements] = evidence, u
        self.weights[elements] = evidence + self._prior(elements)

    def keep(self, elements: Elements, fit: Fit) -> None:
        """What the likelihood says of a set."""
        self.fits[elements] = fit
        self._keep(elements, fit.log_evidence, self.u[elements])

    def _prior(self, elements: Elements) -> float:
        if any(e >= self.n_candidates for e in elements):
            return self.log_prior[4]
        return self.log_prior[len(elements)]

    @cached_property
    def log_prior(self) -> tuple[float, ...]:
        """Of each set of none to three candidates, and of an element that is none."""
        n, others = self.n_candidates, self.n - self.n_candidates
        own = [self.prior.log_of(k, n) if k <= n else -np.inf for k in range(4)]
        return (*own, self.prior.log_elsewhere(others) if others else -np.inf)

    def explained(self, elements: Elements) -> bool:
        """Whether a judged set leaves nothing to be explained."""
        return explained(self.fits[elements], self.something_else)

    def beta(self, elements: Elements, u: FloatArray) -> FloatArray:
        """All severities (n,)."""
        beta = np.zeros(self.n)
        beta[list(elements)] = -np.expm1(-u)
        return beta

    def _view(self, elements: Elements, u: FloatArray) -> View:
        return self.view(elements, u, self.tables.places(elements, u))

    def view(self, elements: Elements, u: FloatArray, places: Places) -> View:
        """The values, as the likelihood has them, with the roots at some places."""
        self.looks += 1
        beta = self.beta(elements, u)
        return viewed(
            beta, self.now, self.tables.foreseen(places, beta, self.band, self.common), self.band, self.errors
        )

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
                self._look(key, best[first])

    def _scan(self, elements: Elements) -> None:
        """Sets with one element more, all its severities tried."""
        if not np.isfinite(self.log_prior[len(elements) + 1]):
            return
        rough = self._rough
        count = self.n if not elements else self.n_candidates
        further = np.array([e for e in range(count) if e not in elements], dtype=np.intp)
        if not further.size:
            return
        u = self.u[elements]
        for key, begin in rough.scan(elements, u, further).items():
            self._look(key, begin)

    def _look(self, key: Elements, begin: FloatArray) -> None:
        """A set from severities near its own, in the tables."""
        found, evidence = self._rough.refined(key, begin)
        # The slopes of no damage tell nothing of severities that they do not reach, nor those of roots that
        # no value belongs to.
        reach = _RESTS if key in self.fits and not self.fits[key].view.matched.all() else _REACH
        beyond = key in self.u and np.abs(self.u[key] - found).max() > reach
        if key in self.fits:
            if not beyond:
                return
            self.judged_before[key] = self.fits.pop(key), self.u[key]
        if beyond or key not in self.evidence or evidence > self.evidence[key]:
            self._keep(key, evidence, found)
            self.rough.add(key)

    def _settle(self) -> Elements:
        """Judge the likeliest sets until the most probable one is sure; it is returned."""
        budget = self.looks + _MOST + _LOOKS
        weights = self.weights
        before = np.inf
        for _ in range(_FROM_SCAN):
            # What a scan tells of a set is far from the likelihood, but about as far for all of them.
            if not self.rough:
                break
            first = max(self.rough, key=lambda s: weights[s])
            if before < np.inf and weights[first] < before - _HOPELESS:
                break
            before = weights[first]
            self.judge(first)
        while True:
            top = max((weights[s] for s in self.fits), default=-np.inf)
            open_ = [s for s, w in weights.items() if s not in self.fits and w > top - self._room(s)]
            self.cut = bool(open_) and self.looks >= budget
            if not open_ or self.cut:
                return max(self.fits, key=lambda s: weights[s])
            self.judge(max(open_, key=lambda s: weights[s]))

    def _room(self, elements: Elements) -> float:
        """How much likelier (log probability) a set may turn out."""
        if elements in self.rough:
            return _ROUGH
        return _HIDDEN if len(elements) == 1 and self.seen_from[elements].times > 1.0 else _NEAR

    def judge(self, elements: Elements) -> None:
        """A set from its own severities, by the likelihood."""
        u = np.minimum(self.u[elements], FURTHEST)
        if u.max() > _REACH and elements not in self.rough:
            u, _ = self._rough.refined(elements, u)
        fit: Fit | None = None
        for nth in range(_LOOKS):
            view = self._view(elements, u)
            fit = fitted(view, elements, reach=np.inf)
            assert fit is not None  # none is too far away
            ahead = -np.log1p(-np.minimum(fit.beta, 0.99)) - u
            if np.abs(ahead).max() < _RESTS or nth == _LOOKS - 1:
                break
            u = u + np.clip(ahead, -_LONGEST, _LONGEST)
        assert fit is not None
        before, at = self.judged_before.pop(elements, (fit, u))
        if before.log_evidence > fit.log_evidence:
            fit, u = before, at
        self.u[elements] = u
        self.keep(elements, fit)
        self.rough.discard(elements)
        if len(elements) == 1 and elements[0] < self.n_candidates:
            others = np.array([e for e in range(self.n_candidates) if e != elements[0]], dtype=np.intp)
            self._pairs(view, np.sort(np.column_stack([np.full(others.size, elements[0]), others]), axis=1))
