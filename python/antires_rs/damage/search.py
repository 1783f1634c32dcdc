"""Which elements may be damaged: a beam search over sets of elements.

Each set is made from one with an element less. A scan of the new element's severity, the others kept, finds
where to begin; Newton steps with an error of the values that falls to nothing lead to the most probable
severities; there the evidence is told. From every point on the way the sets with one element more are judged
too, as far as the linear model goes. Elements that are no candidates are judged one by one only.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations, product

import numpy as np

from ..support.checks import FloatArray
from ..support.progress import step
from .evidence import HIGHEST, Fit, fitted
from .likelihood import Likelihood, View

# -- Which elements a scan looks at, where there are many: those that would explain most to first order
#
# The likelihood's slope and curvature along each severity are at hand from the sensitivities of one point.
# All other elements stay judged by the linear model alone.


#: More elements than these are not all scanned; of one damage, and of a further one, so many are.
_MANY_SCREENING, _SCANNED_SCREENING = 60, (40, 16)
#: Severities of a scan for a further damage among many elements.
COARSE = np.array([0.05, 0.16, 0.4, 0.7, 0.93])


def worth_a_scan(view: View, elements: list[int], size: int) -> list[int] | None:
    """The elements to scan for a set of ``size``, ascending; None for all of them."""
    if len(elements) <= _MANY_SCREENING:
        return None
    gains: FloatArray = np.clip(view.gain, 0.0, None) ** 2 / np.maximum(np.diag(view.curvature), 1e-300)
    best = sorted(elements, key=lambda e: -gains[e])[
        : _SCANNED_SCREENING[min(size, len(_SCANNED_SCREENING)) - 1]
    ]
    return sorted(best)


Elements = tuple[int, ...]

_GRID = np.array([0.02, 0.05, 0.1, 0.16, 0.23, 0.31, 0.4, 0.5, 0.6, 0.7, 0.79, 0.87, 0.93, 0.97])
#: Sets of each size that get another element; and new sets that are refined.
_PARENTS, _REFINED = (1, 8, 4), (12, 40, 10)
#: Sets that get another one where nothing found so far is better than no element at all.
_UNTOLD = 16
#: Errors added on the way to the most probable severities.
_TEMPERED = (0.03, 0.01, 0.003, 0.0, 0.0)
#: Sets so far below the likeliest of their size (log-likelihood) are given up on the way, but for so many.
_HOPELESS, _KEPT = 30.0, 8
#: Largest step of ln(1 - beta).
_LONGEST = 0.7
#: Gain of the log-likelihood below which no further element can win against its prior.
_GAIN = 7.0
#: Chi-square so many standard deviations above what is expected is too much.
_TOO_MUCH = 3.0
#: Sets so near to the likeliest (log evidence), and so many of them, are judged from their own severities.
_NEAR, _RENEWED = 12.0, 24
#: Severity below which an element of a set may as well be undamaged.
_HARDLY = 0.02
#: About so many points of a scan of pairs; where even so there are too many, pairs of so many elements.
_SCANNED, _ALONE = 4000, 40
#: Multiple of the stated errors up to which a damage explains the values.
_WIDER = 2.0
#: Share of values without a partner that is usual.
_LOST = 0.05
#: With fewer values to spare two damages are looked at, however well one explains the values.
_MANY = 8


@dataclass
class Search:
    """The sets found so far, by elements; ``n_candidates`` first, then those that are none."""

    likelihood: Likelihood
    n_candidates: int
    most: int = 3
    fits: dict[Elements, Fit] = field(default_factory=dict)
    interrupted: bool = False
    #: How many elements were scanned for a single damage, of how many; none where all were.
    screened: tuple[int, int] | None = None
    #: Sets that explain far less than others wherever they came to, without coming to rest, and single
    #: elements that the sensitivities rule out.
    hopeless: set[Elements] = field(default_factory=set)

    @cached_property
    def something_else(self) -> float:
        """Log evidence of a change that no element explains."""
        return self.likelihood.something_else()

    def run(self) -> None:
        """Judge sets of up to ``most`` elements; after Ctrl-C those judged so far stay."""
        self._judge((), self.likelihood.start)
        try:
            for size in range(1, min(self.most, self.n_candidates) + 1):
                step(f"sets of {size}")
                likeliest = max(self.fits.values(), key=lambda fit: fit.log_evidence)
                # No single element may be missing from the answer because it was not looked at.
                singles = all((e,) in self.fits or (e,) in self.hopeless for e in range(self.likelihood.n))
                if self._explained(likeliest) and singles:
                    break
                parents = self._parents(size - 1)
                self._refine(self._starts(parents, size))
                if size == 2 and not self._any():
                    self._refine(self._pairs())
            self._smaller()
            self._renew()
        except KeyboardInterrupt:
            self.interrupted = True

    def _any(self) -> bool:
        """Whether some set is more probable than a change that has nothing to do with elements."""
        return max(fit.log_evidence for fit in self.fits.values()) > self.something_else

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
        roots = self.likelihood.roots(rows.reshape(-1, self.likelihood.n), slopes=False)
        left = np.array([self.likelihood.unexplained(each) for each in roots]).reshape(len(pairs), -1)
        best = np.argsort(left.min(axis=1), kind="stable")[: _REFINED[0]]
        return {pairs[nth]: rows[nth, np.argmin(left[nth])] for nth in best}

    def _smaller(self) -> None:
        """Judge the likeliest sets without those of their elements that have hardly a damage."""
        starts: dict[Elements, FloatArray] = {}
        for elements in self._near():
            severities = dict(zip(elements, self.fits[elements].beta, strict=True))
            kept = tuple(e for e in elements if severities[e] >= _HARDLY)
            if kept and kept != elements:
                row = starts.setdefault(kept, np.zeros(self.likelihood.n))
                row[list(kept)] = [min(severities[e], HIGHEST) for e in kept]
        if starts:
            views = self.likelihood.views(np.array(list(starts.values())))
            for elements, view in zip(starts, views, strict=True):
                self._judge(elements, view)

    def _near(self) -> list[Elements]:
        """The likeliest sets, first the likeliest."""
        top = max(fit.log_evidence for fit in self.fits.values())
        near = [s for s, fit in self.fits.items() if s and fit.log_evidence > top - _NEAR]
        return sorted(near, key=lambda s: -self.fits[s].log_evidence)[:_RENEWED]

    def _renew(self) -> None:
        """Judge the likeliest sets anew, each from its own severities."""
        sets = self._near()
        if not sets:
            return
        betas = np.zeros((len(sets), self.likelihood.n))
        for row, elements in enumerate(sets):
            betas[row, list(elements)] = np.minimum(self.fits[elements].beta, HIGHEST)
        for elements, view in zip(sets, self.likelihood.views(betas), strict=True):
            fit = fitted(view, elements)
            if fit:
                self.fits[elements] = fit

    def _parents(self, size: int) -> list[Fit]:
        own = [
            fit
            for elements, fit in self.fits.items()
            if len(elements) == size and all(e < self.n_candidates for e in elements)
        ]
        most = _PARENTS[min(size, len(_PARENTS) - 1)] if self._any() else _UNTOLD
        return sorted(own, key=lambda fit: -fit.log_evidence)[:most]

    def _further(self, elements: Elements) -> list[int]:
        """Elements that may join a set."""
        count = self.n_candidates if elements else self.likelihood.n
        return [e for e in range(count) if e not in elements]

    def _judge(self, elements: Elements, view: View) -> None:
        """Tell the evidence of a set, and of those with one element more, as seen from one point."""
        larger = self._further(elements) if len(elements) < self.most else []
        if any(e >= self.n_candidates for e in elements):
            larger = []
        for each in (elements, *(tuple(sorted((*elements, e))) for e in larger)):
            fit = fitted(view, each)
            if fit and (each not in self.fits or fit.log_evidence > self.fits[each].log_evidence):
                self.fits[each] = fit

    def _explained(self, parent: Fit) -> bool:
        """Whether a set leaves nothing to be explained."""
        return explained(parent, self.something_else)

    def _starts(self, parents: list[Fit], size: int) -> dict[Elements, FloatArray]:
        """The sets that explain most in a scan, and the severities at which they do."""
        found: list[tuple[float, Elements, FloatArray]] = []
        for parent in parents:
            base = np.zeros(self.likelihood.n)
            base[list(parent.elements)] = np.clip(parent.beta, 0.0, HIGHEST)
            further = self._further(parent.elements)
            chosen_few = worth_a_scan(parent.view, further, size)
            if chosen_few is not None and size == 1:
                self.screened = len(chosen_few), len(further)
                self.hopeless.update((e,) for e in set(further) - set(chosen_few))
            grid = _GRID if chosen_few is None or size == 1 else COARSE
            further = further if chosen_few is None else chosen_few
            rows = np.repeat(base[None], len(further) * grid.size, axis=0)
            for nth, e in enumerate(further):
                rows[nth * grid.size : (nth + 1) * grid.size, e] = grid
            left = [self.likelihood.unexplained(roots) for roots in self.likelihood.roots(rows, slopes=False)]
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
        sets, betas = list(chosen), np.array(list(chosen.values()))
        for extra in _TEMPERED:
            views = self.likelihood.views(betas, extra)
            if not extra:
                near = _worth(sets, views)
                sets, views, betas = [sets[n] for n in near], [views[n] for n in near], betas[near]
            for row, (elements, view) in enumerate(zip(sets, views, strict=True)):
                at = np.array(elements)
                matrix = view.curvature[np.ix_(at, at)]
                ridge = 1e-9 * np.trace(matrix) + 1e-6
                newton = np.linalg.solve(matrix + ridge * np.eye(at.size), view.gain[at])
                # The nearer to 1, the faster the model changes: steps in ln(1 - beta) do not overshoot.
                room = 1.0 - betas[row, at]
                ahead = np.clip(-newton / room, -_LONGEST, _LONGEST)
                betas[row, at] = np.clip(1.0 - room * np.exp(ahead), 0.0, HIGHEST)
        views = self.likelihood.views(betas)
        for elements, view in zip(sets, views, strict=True):
            self._judge(elements, view)
        top = max(fit.view.log_likelihood for fit in self.fits.values())
        far = (s for s, view in zip(sets, views, strict=True) if view.log_likelihood < top - _HOPELESS)
        self.hopeless.update(elements for elements in far if elements not in self.fits)


def explained(parent: Fit, something_else: float) -> bool:
    """Whether a set leaves nothing to be explained; ``something_else`` is the log evidence of a change that
    no element explains."""
    view = parent.view
    gains = 0.5 * np.clip(view.gain, 0.0, None) ** 2 / np.maximum(np.diag(view.curvature), 1e-300)
    gains[list(parent.elements)] = 0.0
    count = int(view.matched.sum())
    fits = view.chi_square <= count + _TOO_MUCH * np.sqrt(2.0 * count)
    all_there = view.matched.size - count <= max(1, _LOST * view.matched.size)
    # Errors as they are stated: larger ones would explain anything.
    stated = view.times <= (_WIDER if parent.elements else 1.0)
    # A few values are explained by much that is not so, and what is no damage may explain them better.
    many = not parent.elements or count >= _MANY + len(parent.elements)
    whole = bool(fits and all_there and gains.max() < _GAIN and stated and many)
    return whole and parent.log_evidence > something_else


def _worth(sets: list[Elements], views: list[View]) -> list[int]:
    """Those that may still win, and all single elements."""
    logs = np.array([view.log_likelihood for view in views])
    order = np.argsort(-logs, kind="stable")
    kept = [n for rank, n in enumerate(order) if rank < _KEPT or logs[n] > logs[order[0]] - _HOPELESS]
    return sorted({*kept, *(n for n, elements in enumerate(sets) if len(elements) == 1)})
