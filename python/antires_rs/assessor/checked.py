"""Does the prepared answer hold: the antiresonances of the answer, computed, against those of the tables."""

from __future__ import annotations

import numpy as np

from ..damage.evidence import HIGHEST
from ..damage.hypotheses import UNKNOWN
from ..damage.search import Elements
from .plan import Plan
from .quick_search import QuickSearch

__all__ = ["CLOSE", "checked", "doubts"]

#: Sets so near to the likeliest (log probability) are checked like it.
CLOSE = 0.7
#: Errors of the interpolation that are corrected, and those that are too large (standard deviations of the
#: values).
_CORRECTED, _TOO_LARGE = 0.05, 0.5
#: Change of u, from where the answer was judged, after which it is judged again.
_MOVED = 2e-3
#: How often the answer is judged at most.
_ROUNDS = 4
#: What is so much likelier than all others (log probability) is the answer even with such errors.
_SURE = 2.0
#: Two hypotheses within this (log probability) may change places in a full run, by the number of elements.
_CLOSE = (0.1, 0.2, 0.5)
#: The same of damage of several elements, where one is the answer.
_SEVERAL = 0.05
#: Probability of something else from which on the full run is to look for it.
_UNKNOWN = 0.1
#: Share of values without a root that is too much, and how many are usual.
_LOST, _USUALLY_LOST = 0.1, 2
#: Severity beyond which the slopes say little.
_LARGE = 0.97
#: Values so far outside of the baseline's band (ln f) are not looked at.
_OUTSIDE = 0.3


def checked(search: QuickSearch, plan: Plan, best: Elements) -> list[str]:
    """Judge the answer with its exact antiresonances; what is wrong with the tables there."""
    if not best:
        return []
    t, usual = plan.tables, float(np.median(search.now.std))
    inside = (t.all_log_f[t.identity] > search.band.low) & (t.all_log_f[t.identity] < search.band.high)
    counted = t.seen & inside & (search.now.times_measured(t.response) > 0.0)
    other, worst, slopes = False, 0.0, False
    for _ in range(_ROUNDS):
        before = search.u[best]
        u = -np.log1p(-np.minimum(search.fits[best].beta, HIGHEST))
        placed, beside, known = search.test.places(list(best), u.tolist())
        exact, by = plan.exact(search.beta(best, u), search.band, slopes=slopes)
        there = np.isfinite(exact)
        other |= bool(np.any((there != known) & counted))
        off = np.where(there & known & t.old, exact - (placed - beside), 0.0)
        worst = max(worst, float(np.abs(off[counted]).max(initial=0.0)) / usual)
        moved = float(np.abs(u - before).max())
        if worst <= _CORRECTED and moved <= _MOVED and not other:
            return []
        there = np.where(t.old, there, known)
        place = np.where(there & ~known, exact + t.beside[0, 0], placed + off)
        search.keep(best, u, search.view(best, u, place.tolist(), there.tolist(), by))
        ahead = -np.log1p(-np.minimum(search.fits[best].beta, HIGHEST)) - u
        if np.abs(ahead).max() <= _MOVED:
            break
        slopes = True  # those of the tables do not lead there
    others = max(w for s, w in search.weights.items() if s != best)
    if search.weights[best] - others > _SURE:
        return []
    reasons = ["antiresonances meet or part near the severities found"] if other else []
    if worst > _TOO_LARGE:
        reasons.append(
            f"antiresonances differ from the prepared ones by up to {worst:.1f} standard deviations"
        )
    return reasons


def doubts(search: QuickSearch, best: Elements, weights: dict[Elements, float], unknown: float) -> list[str]:
    """Why a full run is wanted; ``unknown`` is the probability of something else."""
    reasons = []
    fit, now = search.fit(best), search.now
    others = [w for s, w in weights.items() if s not in (best, UNKNOWN)]
    if search.cut:
        reasons.append("more hypotheses are likely than were judged")
    elif others and weights[best] - max(others) < _CLOSE[min(len(best), 2)]:
        reasons.append("two hypotheses are about equally probable")
    if unknown > _UNKNOWN:
        reasons.append("something else than damage of the elements may have changed")
    if not search.explained(best):
        reasons.append("what was found does not explain all values")
    lost = now.size - int(fit.view.matched.sum())
    if lost > max(_USUALLY_LOST, _LOST * now.size):
        reasons.append(f"{lost} of {now.size} values have no antiresonance of the model")
    if fit.beta.max(initial=0.0) > _LARGE:
        reasons.append(f"a loss above {100 * _LARGE:.0f} %")
    if len(best) > 2:
        reasons.append("more than two damaged elements, of which a full run judges more sets")
    elif len(best) < 2 and (search.pair_hint > weights[best] or _of_several(search, weights) > _SEVERAL):
        reasons.append("two damaged elements may explain the values better")
    low, high = search.band.low, search.band.high
    if np.any((now.log_f < low - _OUTSIDE) | (now.log_f > high + _OUTSIDE)):
        reasons.append("values are far outside of the band of the baseline")
    return reasons


def _of_several(search: QuickSearch, weights: dict[Elements, float]) -> float:
    """Probability of sets of several elements that all have a loss."""
    own = [w for s, w in weights.items() if len(s) > 1 and np.all(search.u[s] > 0.0)]
    total = np.logaddexp.reduce(list(weights.values()))
    return float(np.exp(np.logaddexp.reduce([-np.inf, *own]) - total))
