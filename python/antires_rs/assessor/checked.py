"""Does the prepared answer hold: the antiresonances of the answer, computed, against those of the tables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..damage.evidence import fitted
from ..damage.hypotheses import UNKNOWN
from ..damage.search import Elements
from .plan import Plan
from .quick_search import QuickSearch

__all__ = ["checked", "doubts"]

#: Errors of the interpolation that are corrected, and those that are too large (standard deviations of the
#: values).
_CORRECTED, _TOO_LARGE = 0.05, 0.5
#: Two hypotheses within this (log probability) may change places in a full run.
_CLOSE = 0.1
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
    u, t = search.u[best], plan.tables
    places = search.tables.places(best, u)
    exact, there = plan.exact(search.beta(best, u), search.band)
    inside = (t.all_log_f[t.identity] > search.band.low) & (t.all_log_f[t.identity] < search.band.high)
    counted = t.seen & inside
    reasons = []
    if np.any((there != places.there) & counted):
        reasons.append("antiresonances meet or part near the severities found")
    both = there & places.there & t.old
    off = np.where(both, exact - (places.place - places.beside), 0.0)
    usual = float(np.median(search.now.std))
    worst = float(np.abs(off[counted]).max(initial=0.0)) / usual
    if worst > _TOO_LARGE:
        reasons.append(
            f"antiresonances differ from the prepared ones by up to {worst:.1f} standard deviations"
        )
    if worst > _CORRECTED or reasons:
        there = np.where(t.old, there, places.there)
        corrected = replace(places, place=places.place + off, there=there & np.isfinite(places.place))
        fit = fitted(search.view(best, u, corrected), best, reach=np.inf)
        assert fit is not None
        search.keep(best, fit)
    return reasons


def doubts(search: QuickSearch, best: Elements, weights: dict[Elements, float], unknown: float) -> list[str]:
    """Why a full run is wanted; ``unknown`` is the probability of something else."""
    reasons = []
    fit, now = search.fits[best], search.now
    others = [w for s, w in weights.items() if s not in (best, UNKNOWN)]
    if search.cut:
        reasons.append("more hypotheses are likely than were judged")
    elif others and weights[best] - max(others) < _CLOSE:
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
        reasons.append("three damaged elements")
    low, high = search.band.low, search.band.high
    if np.any((now.log_f < low - _OUTSIDE) | (now.log_f > high + _OUTSIDE)):
        reasons.append("values are far outside of the band of the baseline")
    return reasons
