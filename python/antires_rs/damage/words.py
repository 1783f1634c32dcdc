"""An assessment in plain words: is there damage, where, how sure, how much, what else would explain it."""

from __future__ import annotations

from collections.abc import Callable

from .assessment import Assessment
from .hypotheses import Hypothesis
from .percent import figure, percent, span

__all__ = ["headline", "reservations"]

Label = Callable[[int], str]
#: From this probability on something is said without reserve.
_SURE, _EVEN = 0.9, 0.5
#: Alternatives from this probability on are named, so many of them.
_WORTH_A_WORD, _MOST_WORDS = 0.01, 3
#: Intervals wider than this tell nothing.
_UNSEEN = 0.8
#: A loss that is printed as 0.0 %.
_NO_LOSS = 5e-4
#: With fewer values to spare a fit says little.
_FEW = 4
#: With fewer, sets with one element more explain them as well.
_BARELY = 2
_UNEXPLAINED = (
    "But that does not explain all of the values; something may have changed that no hypothesis knows."
)
_NO_MODEL = (
    "The model does not explain the intact structure, so that what follows is worth little: check its units, "
    "dofs and supports."
)


def headline(found: Assessment, label: Label) -> list[str]:
    """The first lines of a report: is there damage, where, how sure, how much, and what else it may be."""
    lines = [_contradiction(found)] if found.odd_baselines else []
    lines += [] if found.model_fits else [_NO_MODEL]
    return [*lines, *_answer(found, label)]


def _contradiction(found: Assessment) -> str:
    """Which of the intact tests cannot be of the same structure as the others."""
    sets = [f"baseline set {nth + 1}" for nth in found.odd_baselines]
    gap = figure(found.baseline_gap)
    if len(sets) == 1:
        return (
            f"The baseline contradicts itself: {sets[0]} differs from the others by {gap}, these among "
            f"themselves by {figure(found.usual_gap)}. Leave it out, or find out what was different; what "
            "follows is worth little."
        )
    return (
        f"The baseline contradicts itself: {', '.join(sets[:-1])} and {sets[-1]} differ by up to {gap}, and "
        "which of them is wrong cannot be told. Test the intact structure again, or leave out what is not "
        "of it; what follows is worth little."
    )


def _answer(found: Assessment, label: Label) -> list[str]:
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
            f"What else it may be: {_others(found, best, label)}.",
        ]
    if not best.unknown:
        lines.append(
            f"What would explain it, and was no candidate: {_lost(best, label)} ({_intervals(best)})."
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
    blind = [one for one in found.hypotheses if not one.candidate and one.elements and _unseen(one)]
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
            f"Not to be excluded: {_in_words(blind, label)}.",
            *left,
        ]
    else:
        lines = [
            "It cannot be told whether there is damage; probably nothing has changed "
            f"(probability {percent(none)})."
        ]
    return [*lines, f"What else it may be: {_alternatives(found, label)}.", *left]


def _damage(found: Assessment, declared: Hypothesis, label: Label) -> list[str]:
    changed = 1.0 - found.probability_of_nothing
    sized = f"Probability {percent(declared.probability)}; {_intervals(declared)}."
    lost = _lost(declared, label)
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
            f"{sized} What else it may be: {_others(found, declared, label)}.",
        ]
    group = sorted(found.group, key=lambda one: one.elements)
    where = " or ".join(_named(one.elements, label) for one in group)
    share = sum(one.probability for one in found.group)
    first = f"{sure}: {where}. The values cannot tell which."
    if surely:
        rests = [_named(each, label) for one in group if (each := _less(one.elements, surely))]
        beside = " or ".join(rests)
        alone = any(one.elements == surely for one in group)
        first = f"{sure}: {_with_share(found, surely, label)}; " + (
            f"perhaps {beside} as well." if alone else f"and {beside}, the values cannot tell which."
        )
    losses = "; ".join(
        f"{percent(one.probability)}: {_lost(one, label)} ({_intervals(one)})" for one in group
    )
    lines = [first, f"Together {percent(share)}. {losses}."]
    if share < _SURE:
        beyond = _in_words([one for one in found.hypotheses if one not in group], label)
        lines.append(f"What else it may be: {beyond}.")
    return lines


def reservations(found: Assessment, label: Label) -> list[str]:
    """What a reader should know before trusting it."""
    notes = list(found.notes)
    if not found.baseline:
        notes.append(
            "Without a baseline every error of the model counts as damage. The probabilities assume "
            f"stiffnesses and masses within about {figure(found.factor_std)}; give the values of the "
            "intact structure as baseline= to have the model's errors taken out."
        )
    if not found.best.unknown and not found.explained:
        notes.append(
            f"The most probable hypothesis does not explain the values (reduced chi-square "
            f"{found.chi_square:.1f}): something else may have changed as well."
        )
    lost = found.n_values - found.n_matched
    if lost:
        notes.append(
            f"{lost} of {found.n_values} values {'has' if lost == 1 else 'have'} no partner in the model: "
            "new or false."
        )
    spare = found.n_matched - len(found.best.severities)
    if found.n_values and spare < _FEW:
        notes.append(
            f"Only {found.n_matched} value{'s are' if found.n_matched != 1 else ' is'} compared, "
            f"{max(spare, 0)} more than there are losses to tell: the answer rests on what the prior says of "
            "how many elements are damaged, and hardly anything is left to check it by. Measure at more "
            "dofs, or in a wider band."
        )
    if found.baseline and found.kappa > 0.0:
        notes.append(
            f"The model predicts changes to about {figure(found.kappa)}: it explained the baseline to "
            f"{figure(found.root_std)}."
        )
    if found.n_baselines == 1:
        notes.append(
            "One test of the intact structure: how far values scatter from test to test is not known, their "
            "own standard deviations count."
        )
    elif found.scatter > 1.0:
        notes.append(
            f"Values scatter between the intact tests {found.scatter:.1f} times as much as their standard "
            "deviations say; all of them were multiplied by that."
        )
    if found.assumed_std:
        notes.append("Values without standard deviation count as known to 0.05 %.")
    return notes


def _alternatives(found: Assessment, label: Label) -> str:
    return _in_words([one for one in found.hypotheses if one.elements], label)


def _others(found: Assessment, declared: Hypothesis, label: Label) -> str:
    return _in_words([one for one in found.hypotheses if one is not declared], label)


def _in_words(hypotheses: list[Hypothesis], label: Label) -> str:
    """Those worth a word, each with its probability."""
    worth = [one for one in hypotheses if one.probability > _WORTH_A_WORD][:_MOST_WORDS]
    if not worth:
        return "many explanations, none of them probable"
    return "; ".join(
        (
            "nothing"
            if not one.elements
            else "a change that no element explains"
            if one.unknown
            else f"damage of {label(one.elements[0])}, which these values do not show"
            if _unseen(one) or max(one.severities) < _NO_LOSS
            else _lost(one, label)
        )
        + f" ({percent(one.probability)})"
        for one in worth
    )


def _unseen(one: Hypothesis) -> bool:
    """Whether the values tell nothing of a loss."""
    return not one.unknown and one.high[0] - one.low[0] > _UNSEEN


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
    return f"{_named(elements, label)} ({percent(share)})"


def _named(elements: tuple[int, ...], label: Label) -> str:
    return " and ".join(label(e) for e in elements)


def _lost(one: Hypothesis, label: Label) -> str:
    """Losses in words, without intervals."""
    first, *rest = (
        (label(e), f"{100 * severity:.1f} %")
        for e, severity in zip(one.elements, one.severities, strict=True)
    )
    more = [f"{name} {loss}" for name, loss in rest]
    return " and ".join([f"{first[0]} has lost {first[1]} of its stiffness", *more])


def _intervals(one: Hypothesis) -> str:
    spans = [span(low, high) for low, high in zip(one.low, one.high, strict=True)]
    return f"90 % interval{'s' if len(spans) > 1 else ''} of the loss {' and '.join(spans)} %"
