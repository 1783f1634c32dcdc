"""One test against a plan."""

from __future__ import annotations

import numpy as np

from ..damage.hypotheses import UNKNOWN
from ..damage.view import Band
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.pickling import FrozenDict
from .answer import AssessedTest
from .checked import CLOSE, checked, doubts
from .new_values import values_of
from .plan import Plan
from .quick_search import QuickSearch
from .told import assessment_of, declared_by, weighed

__all__ = ["assess_at_once"]


def assess_at_once(plan: Plan, sets: tuple[AntiresonanceSet, ...]) -> AssessedTest:
    """Judge a test by what was prepared."""
    learned, question = plan.learned, plan.question
    now, notes, strange, assumed = values_of(sets, plan.expected, learned.scatter)
    band = Band(min(learned.low, float(now.log_f.min())), max(learned.high, float(now.log_f.max())))
    search = QuickSearch(
        plan.interpolated,
        now,
        band,
        question.std_common,
        plan.errors,
        learned.outside,
        len(plan.numbers),
        len(question.elements),
        question.prior,
        plan.pairs,
    )
    search.run()
    strange_of = {}
    while True:
        known = max(search.fits, key=lambda s: search.weights[s])
        near = [s for s in search.fits if search.weights[s] >= search.weights[known] - CLOSE]
        unknown = [s for s in sorted(near, key=lambda s: -search.weights[s])[:2] if s not in strange_of]
        if not unknown:
            break
        for each in unknown:
            strange_of[each] = checked(search, plan, each)
    strange += strange_of[known]
    weights, total = weighed(search)
    declared = declared_by(search, plan, weights)
    if declared not in search.fits:
        search.judge([declared])
        weights, total = weighed(search)
    strange += doubts(search, known, weights, float(np.exp(weights[UNKNOWN] - total)))
    assessment = assessment_of(search, plan, weights, total, declared, notes, assumed, sets)
    elements = question.elements
    of = {each.elements: each for each in assessment.hypotheses}.get(assessment.declared)
    severity = dict.fromkeys(elements, 0.0)
    interval = dict.fromkeys(elements, (0.0, 0.0))
    if of is not None:
        severity |= dict(zip(of.elements, of.severities, strict=True))
        interval |= dict(zip(of.elements, zip(of.low, of.high, strict=True), strict=True))
    share = np.zeros(search.n)
    for each, weight in weights.items():
        if each and each != UNKNOWN:
            share[list(each)] += np.exp(weight - total)
    return AssessedTest(
        bool(strange),
        tuple(dict.fromkeys(strange)),
        FrozenDict(severity),
        FrozenDict(interval),
        FrozenDict(zip(elements, np.minimum(share, 1.0).tolist(), strict=False)),
        assessment,
        FrozenDict(plan.names),
    )
