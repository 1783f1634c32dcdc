"""What an assessment against a baseline comes to: damage, nothing, or what no candidate explains."""

from __future__ import annotations

from .assessment import Assessment
from .hypotheses import Hypothesis
from .percent import figure, percent
from .phrases import Label, alternatives, in_words, intervals, loss_of, named, others, unseen

__all__ = ["answer"]

#: From this probability on something is said without reserve.
_SURE, _EVEN = 0.9, 0.5
#: With fewer values to spare, sets with one element more explain them as well.
_BARELY = 2
_UNEXPLAINED = (
    "But that does not explain all of the values; something may have changed that no hypothesis knows."
)
_RISEN = (
    "Values have risen ({0.n_risen} of {0.n_moved} that moved): are the sets swapped, or has something been "
    "stiffened?"
)


def answer(found: Assessment, label: Label) -> list[str]:
    """Sentences, the first the answer."""
    if found.best.unknown and found.moved_alike:
        return _shifted(found, label)
    return [*_without_shift(found, label), *([_RISEN.format(found)] if found.n_risen else [])]


def _shifted(found: Assessment, label: Label) -> list[str]:
    """All values have moved alike."""
    way, share = "higher" if found.moved_alike > 0.0 else "lower", found.best.probability
    first = "No damage found" if share >= _SURE else "Probably no damage"
    lines = [
        f"{first}: all values are {figure(abs(found.moved_alike))} {way} than in the intact state, as "
        f"another temperature or sampling clock would have it (probability {percent(share)})."
    ]
    if share < _SURE:
        lines.append(f"What else it may be: {others(found, found.best, label)}.")
    return lines


def _without_shift(found: Assessment, label: Label) -> list[str]:
    if not found.best.candidate:
        return _unexplained(found, label)
    if not found.declared:
        return _nothing(found, label)
    declared = next(one for one in found.hypotheses if one.elements == found.declared)
    lines = _damage(found, declared, label)
    if not found.explained:
        lines.append("But it does not explain all of the values; something else may have changed as well.")
    return lines


def _unexplained(found: Assessment, label: Label) -> list[str]:
    best, share = found.best, percent(found.probability_elsewhere)
    if found.probability_elsewhere >= _SURE:
        lines = [f"Something has changed that none of the candidates explains (probability {share})."]
    else:
        lines = [
            f"{_change(found)}, perhaps what none of the candidates explains (probability {share}).",
            f"What else it may be: {others(found, best, label)}.",
        ]
    if not best.unknown:
        lines.append(
            f"What would explain it, and was no candidate: {loss_of(best, label)} ({intervals(best)})."
        )
    return lines


def _change(found: Assessment) -> str:
    """Whether something has changed, in as many words as it is sure."""
    changed = 1.0 - found.probability_of_nothing
    if changed >= _SURE:
        return f"Something has changed (probability {percent(changed)})"
    return f"It cannot be told whether something has changed (probability {percent(changed)})"


def _nothing(found: Assessment, label: Label) -> list[str]:
    none = found.probability_of_nothing
    left = [] if found.explained or found.best.elements else [_UNEXPLAINED]
    # What was no candidate and shows in no value stays as probable as before: no reason to doubt the test.
    blind = [one for one in found.hypotheses if not one.candidate and one.elements and unseen(one)]
    if found.best.elements:
        lines = [
            f"No damage declared: it is probable ({percent(1.0 - none)}), but not enough for the rate of "
            "false alarms asked for."
        ]
    elif none >= _SURE:
        return [f"No damage found: nothing has changed (probability {percent(none)}).", *left]
    elif none + sum(one.probability for one in blind) >= _SURE:
        return [
            f"No damage found: probably nothing has changed (probability {percent(none)}).",
            f"Not to be excluded: {in_words(blind, label)}.",
            *left,
        ]
    else:
        lines = [
            "It cannot be told whether there is damage; probably nothing has changed "
            f"(probability {percent(none)})."
        ]
    return [*lines, f"What else it may be: {alternatives(found, label)}.", *left]


def _damage(found: Assessment, declared: Hypothesis, label: Label) -> list[str]:
    changed = 1.0 - found.probability_of_nothing
    sized = f"Probability {percent(declared.probability)}; {intervals(declared)}."
    lost = loss_of(declared, label)
    if changed < _EVEN:
        return [
            f"Damage is declared for the rate of false alarms asked for, though it is improbable: {lost}.",
            f"{sized} Probability that nothing has changed: {percent(1.0 - changed)}.",
        ]
    if changed < _SURE:
        first = f"Perhaps damage ({percent(changed)}): {lost}."
        return [first, f"{sized} Probability that nothing has changed: {percent(1.0 - changed)}."]
    if declared.probability >= _SURE:
        k = len(declared.elements)
        if found.n_matched - k < _BARELY:
            only = "only one element is" if k == 1 else f"no more than {k} elements are"
            values = f"{found.n_matched} value{'s' if found.n_matched > 1 else ''}"
            return [f"Damage; if {only} damaged: {lost}.", f"{sized} {values} cannot tell more."]
        return [f"Damage: {lost}.", sized]
    unknown = sum(one.probability for one in found.hypotheses if one.unknown)
    what = "There is damage" if unknown < 1.0 - _SURE else "Something has changed"
    sure = f"{what} (probability {percent(changed)})"
    surely = _common(found)
    if not found.group and surely:
        return [
            f"{sure}: {_with_share(found, surely, label)}; perhaps others as well, the values cannot tell "
            "which.",
            f"First of many: {lost}. {sized}",
        ]
    if not found.group:
        return [f"{sure}, but the values cannot tell where.", f"First of many: {lost}. {sized}"]
    if len(found.group) == 1:
        return [
            f"{sure}, probably this: {lost}.",
            f"{sized} What else it may be: {others(found, declared, label)}.",
        ]
    group = sorted(found.group, key=lambda one: one.elements)
    where = " or ".join(named(one.elements, label) for one in group)
    share = sum(one.probability for one in found.group)
    first = f"{sure}: {where}. The values cannot tell which."
    if surely:
        rests = [named(each, label) for one in group if (each := _less(one.elements, surely))]
        beside = " or ".join(rests)
        alone = any(one.elements == surely for one in group)
        first = f"{sure}: {_with_share(found, surely, label)}; " + (
            f"perhaps {beside} as well." if alone else f"and {beside}, the values cannot tell which."
        )
    losses = "; ".join(
        f"{percent(one.probability)}: {loss_of(one, label)} ({intervals(one)})"
        for one in sorted(group, key=lambda one: -one.probability)
    )
    lines = [first, f"Together {percent(share)}. {losses}."]
    if share < _SURE:
        beyond = in_words([one for one in found.hypotheses if one not in group], label)
        lines.append(f"What else it may be: {beyond}.")
    return lines


def _common(found: Assessment) -> tuple[int, ...]:
    """Elements that are damaged in whatever the values cannot tell apart."""
    if found.group:
        return tuple(e for e in found.group[0].elements if all(e in one.elements for one in found.group))
    every = sorted({e for one in found.hypotheses if one.candidate for e in one.elements})
    return tuple(e for e in every if found.marginal(e) >= _SURE)


def _less(elements: tuple[int, ...], some: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(e for e in elements if e not in some)


def _with_share(found: Assessment, elements: tuple[int, ...], label: Label) -> str:
    """Elements, and the probability that they are damaged, whatever else is."""
    share = sum(
        one.probability for one in found.hypotheses if one.candidate and {*elements} <= {*one.elements}
    )
    return f"{named(elements, label)} ({percent(share)})"
