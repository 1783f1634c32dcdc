"""Sets whose further elements lose next to nothing are the same answer as the smaller set."""

from __future__ import annotations

from dataclasses import replace

from .assessment import Assessment
from .hypotheses import Hypotheses, Hypothesis
from .posterior import together

__all__ = ["without_idle"]

#: A loss below it is none, in words.
_IDLE = 0.005


def without_idle(found: Assessment) -> Assessment:
    """The same with the probability of each such set added to the smaller one; for words and first tables.

    The answer stays the first, and what all of its elements lose next to nothing stays itself.
    """
    rows: list[Hypothesis] = list(found.hypotheses)
    smaller = [_smaller(one) for one in rows]
    if smaller == rows:
        return found
    own = {one.elements: one for one in rows}
    merged: dict[tuple[int, ...], list[Hypothesis]] = {}
    for one, less in zip(rows, smaller, strict=True):
        merged.setdefault(less.elements, [own.get(less.elements, less)]).append(one)
    told = {
        elements: replace(first, probability=sum(one.probability for one in all_of_it))
        for elements, (first, *all_of_it) in merged.items()
    }
    of = {one.elements: told[less.elements] for one, less in zip(rows, smaller, strict=True)}
    first = of[rows[0].elements]
    ordered = sorted(told.values(), key=lambda one: (one is not first, -one.probability, one.elements))
    group = [*dict.fromkeys(of[one.elements] for one in found.group)] or together(ordered)
    return replace(
        found,
        hypotheses=Hypotheses(ordered, found.hypotheses.names),
        group=tuple(group),
        declared=of[found.declared].elements if found.declared in of else found.declared,
    )


def _smaller(one: Hypothesis) -> Hypothesis:
    """The set without the elements that lose next to nothing; itself where all of them do."""
    kept = [nth for nth, loss in enumerate(one.severities) if loss >= _IDLE]
    if not kept or len(kept) == len(one.severities):
        return one
    elements = tuple(one.elements[nth] for nth in kept)
    severities, low, high = (
        tuple(column[nth] for nth in kept) for column in (one.severities, one.low, one.high)
    )
    return replace(one, elements=elements, severities=severities, low=low, high=high)
