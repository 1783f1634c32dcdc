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
from ..support.checks import FloatArray
from .assessor_plan import LEVELS, Interpolated
from .evidence import FURTHEST, HIGHEST, Fit, fitted, log_between
from .inference import Elements, explained
from .likelihood import ALIKE, ALIKE_SHARE, ANY_CHANGE, Band, Foreseen, View, associated
from .measured_states import Values
from .options import DamagePrior

# -- Evidence of many sets of one or two elements at once, as one view has them
#
# The same integrals as :func:`antires_rs.damage.evidence.fitted`, without its Python loop.


#: As in the evidence: precision of u where nothing sees it, change of u up to which roots are linear.
_BLIND, _LINEAR = 1e-2, 0.12
#: Pairs so far below the likeliest get no evidence.
_HOPELESS_LINEAR = 6.0
#: Least severity (u) of either element for a pair that the slopes do not reach.
_IDLE = 0.01


def single_evidence(view: View) -> FloatArray:
    """Log evidence of each element alone, (n,); the view is one without damage. Where the most probable
    severity is out of reach of the slopes it is what they say nevertheless."""
    gain, precision = view.gain - 1.0, np.diag(view.curvature) + _BLIND
    mean, std = gain / precision, 1.0 / np.sqrt(precision)
    inside = log_between(-mean / std, (FURTHEST - mean) / std)
    volume = np.log(np.sqrt(2.0 * np.pi) * std / HIGHEST)
    return np.asarray(view.log_likelihood + 0.5 * gain * mean + volume + inside)


def further_gains(view: View, elements: tuple[int, ...]) -> FloatArray:
    """Rise of the log-likelihood by each element (n,) beside those of a view from their own severities."""
    own = list(elements)
    known = view.curvature[np.ix_(own, own)] + _BLIND * np.eye(len(own))
    share = np.linalg.solve(known, np.column_stack([view.gain[own], view.curvature[own]]))
    gain = view.gain - view.curvature[:, own] @ share[:, 0]
    precision = np.diag(view.curvature) - np.sum(view.curvature[own] * share[:, 1:], axis=0)
    found = 0.5 * np.clip(gain, 0.0, None) ** 2 / np.maximum(precision, _BLIND)
    found[own] = 0.0
    return np.asarray(found)


def pair_evidence(view: View, pairs: NDArray[np.intp]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Log evidence of pairs (k, 2), -inf where it is hopeless or out of reach; most probable u (k, 2); and
    the log evidence (k,) of those that are out of reach, as far as slopes tell it."""
    room = 1.0 - view.beta[pairs]
    start = -np.log(room)
    i, j = pairs.T
    a = view.curvature[i, i] * room[:, 0] ** 2 + _BLIND
    c = view.curvature[j, j] * room[:, 1] ** 2 + _BLIND
    b = view.curvature[i, j] * room[:, 0] * room[:, 1]
    determinant = a * c - b**2
    gain = view.gain[pairs] * room - 1.0
    step = np.stack([c * gain[:, 0] - b * gain[:, 1], a * gain[:, 1] - b * gain[:, 0]], axis=1)
    step /= determinant[:, None]
    mean = start + step
    best = _peaks(mean, a, b, c)
    evidence = view.log_likelihood + 0.5 * np.sum(gain * step, axis=1) - start.sum(axis=1)
    evidence += np.log(2.0 * np.pi) - 0.5 * np.log(determinant) - 2.0 * np.log(HIGHEST)
    within = np.all(np.abs(best - start) <= _LINEAR, axis=1)
    # What lies outside of the box costs at least what its peak does.
    apart = best - mean
    cost = 0.5 * (a * apart[:, 0] ** 2 + 2.0 * b * apart[:, 0] * apart[:, 1] + c * apart[:, 1] ** 2)
    both = np.all(best > _IDLE, axis=1)
    likely = np.where(both & ~within, evidence - cost, -np.inf)
    bound = np.where(within, evidence - cost, -np.inf)
    worth = np.flatnonzero(bound > bound.max(initial=-np.inf) - _HOPELESS_LINEAR)
    found = np.full(len(pairs), -np.inf)
    found[worth] = evidence[worth] + _log_inside(mean[worth], a[worth], b[worth], c[worth])
    return found, best, likely


def _peaks(mean: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Most probable points in [0, FURTHEST]^2, of precisions [[a, b], [b, c]]."""
    first = np.clip(mean[:, 0], 0.0, FURTHEST)
    second = np.clip(mean[:, 1], 0.0, FURTHEST)
    # With one on its bound, the other follows; the better of both ways.
    other = np.clip(mean[:, 1] - b / c * (first - mean[:, 0]), 0.0, FURTHEST)
    one = np.clip(mean[:, 0] - b / a * (second - mean[:, 1]), 0.0, FURTHEST)
    ways = np.stack([np.stack([first, other], axis=1), np.stack([one, second], axis=1)])
    apart = ways - mean
    cost = a * apart[..., 0] ** 2 + 2.0 * b * apart[..., 0] * apart[..., 1] + c * apart[..., 1] ** 2
    return np.asarray(np.where((cost[0] <= cost[1])[:, None], ways[0], ways[1]))


#: Rule of quadrature along the first coordinate.
_X, _W = np.polynomial.legendre.leggauss(12)


def _log_inside(mean: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """ln of the probability of [0, FURTHEST]^2, of precisions [[a, b], [b, c]]."""
    determinant = a * c - b**2
    std = np.sqrt(c / determinant)
    # The first coordinate over where it has any probability in the box, the second given it in closed form.
    top = np.clip(mean[:, 0], 0.0, FURTHEST)
    decay = std**2 / np.maximum(np.abs(mean[:, 0] - top), std)
    low = np.maximum(0.0, top - 7.0 * decay)
    high = np.minimum(FURTHEST, top + 7.0 * decay)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    x = middle[:, None] + half[:, None] * _X
    given = mean[:, 1, None] - (b / c)[:, None] * (x - mean[:, 0, None])
    own = 1.0 / np.sqrt(c)[:, None]
    logs = -0.5 * ((x - mean[:, 0, None]) / std[:, None]) ** 2 - np.log(np.sqrt(2.0 * np.pi) * std)[:, None]
    logs += log_between(-given / own, (FURTHEST - given) / own) + np.log(_W * half[:, None])
    return np.asarray(np.logaddexp.reduce(logs, axis=1))


# -- Sets with one element more that are worth a look by the likelihood: all its severities tried


Start = tuple[Elements, FloatArray]

#: Sets of a scan that are refined, by the distances of the values and by their misfit; all single elements.
_BY_DISTANCE, _BY_MISFIT = 12, 14
#: Steps of the refinement, and sets so far below the likeliest (log-likelihood) that are given up.
_STEPS, _HOPELESS_STARTS = 2, 25.0


def starts(
    test: _core.PreparedTest, parents: list[Start], count: int, known: set[Elements], most: int
) -> list[Start]:
    """At most so many sets of a parent and one of ``count`` elements, but for those known, the likeliest
    first; with severities (u) of theirs."""
    of_parent: list[NDArray[np.intp]] = []
    of_further: list[NDArray[np.intp]] = []
    scans: tuple[list[FloatArray], list[FloatArray]] = ([], [])
    for nth, (parent, u) in enumerate(parents):
        further = np.array([e for e in range(count) if e not in parent], dtype=np.intp)
        if further.size:
            scan_of = test.scan(list(parent), u.tolist(), further.tolist())
            of_parent.append(np.full(further.size, nth))
            of_further.append(further)
            for known_so_far, one in zip(scans, scan_of, strict=True):
                known_so_far.append(one)
    if not of_parent:
        return []
    parent_of, further_of = np.concatenate(of_parent), np.concatenate(of_further)
    chosen: dict[tuple[Elements, int], list[float]] = {}
    for scan, few in zip(scans, (_BY_DISTANCE, _BY_MISFIT if parents[0][0] else count), strict=True):
        left = np.concatenate(scan)
        level = np.argmin(left, axis=1)
        order = np.argsort(left[np.arange(level.size), level], kind="stable")
        for elements, at, u_of in _sets(parents, parent_of, further_of, level, order, few, known):
            chosen.setdefault((elements, at), u_of)
    best: dict[Elements, tuple[float, FloatArray]] = {}
    asked = [(list(elements), u_of) for (elements, _), u_of in chosen.items()]
    for (elements, _), (u_now, score) in zip(chosen, test.refine(asked, _STEPS), strict=True):
        if elements not in best or score < best[elements][0]:
            best[elements] = (score, np.array(u_now))
    likeliest = sorted(best, key=lambda s: best[s][0])[:most]
    return [(s, best[s][1]) for s in likeliest if best[s][0] < best[likeliest[0]][0] + _HOPELESS_STARTS]


def _sets(
    parents: list[Start],
    parent_of: NDArray[np.intp],
    further_of: NDArray[np.intp],
    level: NDArray[np.intp],
    order: NDArray[np.intp],
    most: int,
    known: set[Elements],
) -> list[tuple[Elements, int, list[float]]]:
    """The first of a scan: elements, level of the new one, severities."""
    found: list[tuple[Elements, int, list[float]]] = []
    for nth in order.tolist():
        parent, u = parents[parent_of[nth]]
        u_new = float(LEVELS[level[nth]])
        joined = sorted([*zip(parent, u.tolist(), strict=True), (int(further_of[nth]), u_new)])
        elements = tuple(e for e, _ in joined)
        if elements not in known:
            found.append((elements, int(level[nth]), [x for _, x in joined]))
        if len(found) == most:
            break
    return found


# -- A change that no element explains: of every value by any amount, or of all values alike
#
# The evidence that :meth:`antires_rs.damage.likelihood.Likelihood.something_else` has, from one eigenvalue
# problem for each way to associate values and roots: an error of every value is added to the eigenvalues, one
# of all alike is of rank one.


#: Errors of the roots and multiples of all errors with which values and roots are associated.
_PATTERNS = ((0.0, 1.0), (0.01, 1.0), (0.06, 3.0))


def something_else(now: Values, start: Foreseen, band: Band) -> tuple[float, float]:
    """Log evidence, and the relative change of all values where it is mostly that; else 0."""
    by_itself = np.full(ANY_CHANGE.size, -np.inf)
    alike = np.full(len(ALIKE), -np.inf)
    shift, likeliest = 0.0, -np.inf
    known: list[NDArray[np.intp]] = []
    for extra, wider in _PATTERNS:
        sigma = np.sqrt(np.maximum(np.diag(start.spread), 0.0) + extra**2)
        partner, place, price = associated(now, start, band, sigma, wider)
        if any(np.array_equal(partner, each) for each in known):
            continue
        known.append(partner)
        has = np.flatnonzero(partner >= 0)
        root = partner[has]
        residual = place[has] - start.place[root]
        if not has.size:
            continue
        covariance = start.spread[np.ix_(root, root)]
        covariance[np.diag_indices(root.size)] += now.std[has] ** 2
        size, vectors = np.linalg.eigh(covariance)
        size = np.maximum(size, 1e-16)
        y, ones = residual @ vectors, vectors.sum(axis=0)
        usual = -0.5 * has.size * np.log(2.0 * np.pi) - price
        more = size + (ANY_CHANGE**2)[:, None]
        by_itself = np.maximum(by_itself, usual - 0.5 * np.sum(np.log(more) + y**2 / more, axis=1))
        plain = usual - 0.5 * np.sum(np.log(size) + y**2 / size)
        s, q, c2 = np.sum(ones**2 / size), np.sum(ones * y / size), np.array(ALIKE) ** 2
        own = plain - 0.5 * np.log1p(c2 * s) + 0.5 * c2 * q**2 / (1.0 + c2 * s)
        if own.max() > likeliest:
            shift, likeliest = float(np.expm1(np.median(residual))), float(own.max())
        alike = np.maximum(alike, own)
    of_each = np.log1p(-ALIKE_SHARE) + np.logaddexp.reduce(by_itself) - np.log(by_itself.size)
    of_all = np.log(ALIKE_SHARE) + np.logaddexp.reduce(alike) - np.log(alike.size)
    return float(np.logaddexp(of_each, of_all)), shift if of_all > of_each else 0.0


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
