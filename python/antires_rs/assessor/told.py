"""From a search to an :class:`~antires_rs.damage.assessment.Assessment`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..damage.assessment import Assessment
from ..damage.evidence import fitted
from ..damage.hypotheses import UNKNOWN, Hypotheses, Hypothesis
from ..damage.inference import note_of_shift
from ..damage.posterior import allowed, together
from ..damage.search import Elements
from ..measured.antiresonance_set import AntiresonanceSet
from .plan import Plan
from .quick_search import QuickSearch

__all__ = ["assessment_of", "declared_by", "weighed"]

#: Shares between which intervals lie; hypotheses of less than this probability are not listed.
_SHARES = (0.05, 0.95)
_LISTED, _MOST = 0.01, 6
#: The same for sets of several elements that were not judged from their own severities.
_CLEAR = 0.05


def weighed(search: QuickSearch) -> tuple[dict[Elements, float], float]:
    """Log of prior times evidence of all sets and of something else, and of their sum."""
    others = search.n - search.n_candidates
    weights = {**search.weights, UNKNOWN: search.something_else + search.prior.log_unknown(others)}
    return weights, allowed(float(np.logaddexp.reduce(list(weights.values()))))


def declared_by(search: QuickSearch, plan: Plan, weights: dict[Elements, float]) -> Elements:
    """The set that is declared damaged, numbered as in the search."""
    candidates = len(plan.question.elements)
    best = max(weights, key=lambda s: weights[s])
    if best == UNKNOWN or any(e >= candidates for e in best):
        return ()
    if plan.learned.threshold is None:
        return best
    damage = {s: w for s, w in weights.items() if s and s != UNKNOWN and max(s) < candidates}
    if not damage:
        return ()
    odds = float(np.logaddexp.reduce(list(damage.values()))) - weights[()]
    return max(damage, key=lambda s: damage[s]) if odds > plan.learned.threshold else ()


def assessment_of(
    search: QuickSearch,
    plan: Plan,
    weights: dict[Elements, float],
    total: float,
    declared: Elements,
    notes: list[str],
    assumed: bool,
    sets: tuple[AntiresonanceSet, ...],
) -> Assessment:
    """Hypotheses with their probabilities, and how well the best explains the values."""
    rows = _rows(search, plan, weights, total, declared)
    numbers, learned = plan.numbers, plan.learned
    own = tuple(numbers.index(e) for e in rows[0].elements) if not rows[0].unknown else ()
    fit = search.fit(own if own in search.fits else ())
    matched = int(fit.view.matched.sum())
    shift = search.moved_alike if rows[0].unknown else 0.0
    found = Assessment(
        hypotheses=Hypotheses(rows, plan.names),
        group=tuple(together(rows)),
        declared=tuple(numbers[e] for e in declared),
        chi_square=fit.view.chi_square / max(matched - len(own), 1) if matched else np.nan,
        n_values=search.now.size,
        n_matched=matched,
        kappa=fit.view.kappa,
        factor_std=learned.s,
        root_std=learned.tau,
        threshold=learned.threshold,
        detectable=learned.detectable,
        baseline=True,
        assumed_std=learned.assumed_std or assumed,
        n_intact=learned.n_intact,
        n_intact_matched=learned.n_intact_matched,
        n_intact_roots=learned.n_intact_roots,
        n_baselines=learned.n_baselines,
        scatter=learned.scatter,
        notes=(*learned.notes, *notes, *note_of_shift(shift)),
        odd_baselines=learned.odd_baselines,
        baseline_gap=learned.baseline_gap,
        usual_gap=learned.usual_gap,
        moved_alike=shift,
    )
    if not found.model_fits:
        return replace(found, hint=learned.hint)
    return replace(found, hint=plan.question.hint_between(sets)) if 2 * matched < found.n_values else found


def _rows(
    search: QuickSearch, plan: Plan, weights: dict[Elements, float], total: float, declared: Elements
) -> list[Hypothesis]:
    """The hypotheses that are listed, the most probable first."""
    least = total + np.log(_LISTED)
    clear = total + np.log(_CLEAR)
    listed = [
        s
        for s, w in weights.items()
        if w > (least if s in search.fits or len(s) == 1 else clear) and s not in search.rough
    ]
    listed = sorted(listed, key=lambda s: -weights[s])[:_MOST]
    listed = list(dict.fromkeys([*listed, (), declared]))
    rows = []
    for elements in listed:
        probability = min(float(np.exp(weights[elements] - total)), 1.0)
        if elements == UNKNOWN:
            rows.append(Hypothesis(UNKNOWN, probability, (), (), (), candidate=False))
            continue
        fit = search.fits.get(elements) or fitted(search.seen_from[elements], elements, reach=np.inf)
        assert fit is not None
        limits = [fit.interval(nth, _SHARES) for nth in range(len(elements))]
        rows.append(
            Hypothesis(
                tuple(plan.numbers[e] for e in elements),
                probability,
                tuple(float(b) for b in fit.beta),
                tuple(low for low, _ in limits),
                tuple(high for _, high in limits),
                candidate=not any(e >= search.n_candidates for e in elements),
            )
        )
    return sorted(rows, key=lambda one: (-one.probability, one.elements))
