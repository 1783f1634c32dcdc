"""An assessment in plain words: is there damage, where, how sure, how much, what else would explain it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..updating.model_check import few_alone
from ..updating.reduced_search import ReductionReport
from .hypotheses import Assessment, Hypotheses, Hypothesis, figure, percent, span
from .inference import together

if TYPE_CHECKING:
    from ..updating.tables import FrequencyTable, ModalTable


# -- Losses, names and alternatives in words


Label = Callable[[int], str]
#: Alternatives from this probability on are named, so many of them.
_WORTH_A_WORD, _MOST_WORDS = 0.01, 3
#: Intervals wider than this tell nothing.
_UNSEEN = 0.8
#: A loss that is printed as 0.0 %.
_NO_LOSS = 5e-4


def alternatives(found: Assessment, label: Label) -> str:
    """Every damage worth a word."""
    return in_words([one for one in found.hypotheses if one.elements], label)


def others(found: Assessment, declared: Hypothesis, label: Label) -> str:
    """Whatever else is worth a word."""
    return in_words([one for one in found.hypotheses if one is not declared], label)


def in_words(hypotheses: list[Hypothesis], label: Label) -> str:
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
            if unseen(one) or max(one.severities) < _NO_LOSS
            else loss_of(one, label)
        )
        + f" ({percent(one.probability)})"
        for one in worth
    )


def unseen(one: Hypothesis) -> bool:
    """Whether the values tell nothing of a loss."""
    return not one.unknown and one.high[0] - one.low[0] > _UNSEEN


def loss_of(one: Hypothesis, label: Label) -> str:
    """Losses in words, without intervals."""
    first, *rest = (
        (label(e), f"{100 * severity:.1f} %")
        for e, severity in zip(one.elements, one.severities, strict=True)
    )
    more = [f"{name} {loss}" for name, loss in rest]
    return " and ".join([f"{first[0]} has lost {first[1]} of its stiffness", *more])


def intervals(one: Hypothesis) -> str:
    """The intervals of all losses."""
    spans = [span(low, high) for low, high in zip(one.low, one.high, strict=True)]
    return f"90 % interval{'s' if len(spans) > 1 else ''} of the loss {' and '.join(spans)} %"


def named(elements: tuple[int, ...], label: Label) -> str:
    """Elements by name."""
    return " and ".join(label(e) for e in elements)


# -- What an assessment against a baseline comes to: damage, nothing, or what no candidate explains


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


# -- Sets whose further elements lose next to nothing are the same answer as the smaller set


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


def headline(found: Assessment, label: Label) -> list[str]:
    """The first lines of a report: is there damage, where, how sure, how much, and what else it may be."""
    doubts = [_contradiction(found)] if found.odd_baselines else []
    if not found.model_fits:
        doubts.append(_no_model(found))
    elif not found.states_fit:
        doubts.append(_no_partners(found))
    found, many = without_idle(found), len(found.hypotheses)
    if found.interrupted:
        return [*_stopped(found, many, label), *doubts]
    return [*doubts, _if_trusted(found, label)] if doubts else answer(found, label)


def _no_model(found: Assessment) -> str:
    """The model cannot be that of the structure: why, and what to look at."""
    why = f"{found.n_intact_matched} of {found.n_intact} values of the intact structure have a partner in it"
    if few_alone(found.n_intact_matched, found.n_intact):
        why = (
            f"its stiffnesses and masses would have to be off by {figure(found.factor_std)}, and its "
            f"frequencies by {figure(found.root_std)} beyond that"
        )
        if found.near:
            why = f"it has {found.n_intact_roots} roots where {found.n_intact} values were measured"
    hint = f"{found.hint} " if found.hint else ""
    return (
        f"The model does not explain the measurement: {why}. {hint}Check its units, dofs, force and supports."
    )


def _no_partners(found: Assessment) -> str:
    """The values of now have nothing to do with those of the intact structure."""
    hint = f"{found.hint} " if found.hint else ""
    have = "has" if found.n_matched == 1 else "have"
    return (
        f"The model does not explain the measurement: {found.n_matched} of {found.n_values} values of now "
        f"{have} a partner in it, damaged or not. {hint}Check units, dofs, force and band of both tests."
    )


def _stopped(found: Assessment, many: int, label: Label) -> list[str]:
    """What was judged before Ctrl-C; without the others no probability holds."""
    judged = f"{many} hypotheses were" if many > 1 else "1 hypothesis was"
    if found.best.unknown:
        best = "none of these explains the values"
    elif found.best.elements:
        best = f"the likeliest of these is that {loss_of(found.best, label)}"
    else:
        best = "the likeliest of these is that nothing has changed"
    return [
        f"The search was stopped: {judged} judged, and {best}.",
        "Others may explain the values better, so that the probabilities say little: let it finish.",
    ]


def _if_trusted(found: Assessment, label: Label) -> str:
    """The answer in one sentence, where what it rests on is in doubt."""
    trusted = "baseline" if found.odd_baselines else "model"
    if found.best.unknown and found.moved_alike:
        what = "all values have moved alike, which is temperature or clock rather than damage"
    elif not found.best.candidate:
        what = "something has changed that none of the candidates explains"
    elif not found.declared:
        what = "no damage is to be seen"
    else:
        group = sorted(found.group, key=lambda one: one.elements)
        alike = found.declared in [one.elements for one in group]
        where = (
            " or ".join(named(one.elements, label) for one in group)
            if alike
            else named(found.declared, label)
        )
        what = f"the values point to damage of {where}"
    return f"If the {trusted} can be trusted at all, {what}; the table has the figures."


def _contradiction(found: Assessment) -> str:
    """Which of the intact tests cannot be of the same structure as the others."""
    sets = [f"baseline set {nth}" for nth in found.odd_baselines]
    gap = figure(found.baseline_gap)
    if len(sets) == 1:
        return (
            f"The baseline contradicts itself: {sets[0]} differs from the others by {gap}, these among "
            f"themselves by {figure(found.usual_gap)}. Leave it out, or find out what was different."
        )
    return (
        f"The baseline contradicts itself: {', '.join(sets[:-1])} and {sets[-1]} differ by up to {gap}, and "
        "which of them is wrong cannot be told. Test the intact structure again, or leave out what is not "
        "of it."
    )


# -- What a reader should know before trusting an assessment


#: With fewer values to spare a fit says little.
_FEW = 4


def reservations(found: Assessment, label: Label) -> list[str]:
    """What a reader should know before trusting it."""
    notes = list(found.notes)
    if not found.baseline:
        notes.append(
            "Without a baseline every error of the model counts as damage. The probabilities assume "
            f"stiffnesses and masses within about {figure(found.factor_std)}; give the values of the "
            "intact structure as baseline= to have the model's errors taken out."
        )
    if not found.n_matched:
        notes.append(
            "No value of now has a partner in the model: there is no chi-square, and nothing tells whether "
            "the answer holds. Compare the bands and dofs of both tests."
        )
    elif not found.best.unknown and not found.explained:
        notes.append(
            f"The most probable hypothesis does not explain the values (reduced chi-square "
            f"{found.chi_square:.1f}): something else may have changed as well."
        )
    lost = found.n_values - found.n_matched
    if lost and found.n_matched:
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


def note_of_reduction(found: ReductionReport) -> str:
    """How a reduced model served."""
    if found.agreed:
        return found.note
    return (
        f"Sought on a reduced model, {found.size} dofs for {found.n_dof}: at the answer its antiresonances "
        f"still differ from the full model's by {found.difference:.0e}, which moves severities and "
        "probabilities by as much. reduction=False assesses on the full model, which takes long."
    )


# -- What the most probable hypothesis leaves unexplained, in words


_NAMED = 3
#: Differences below it, in %, are no news.
_LEAST_PERCENT = 0.05


def largest_left(table: FrequencyTable | ModalTable) -> str:
    """The values that the model with the damage found misses most; '' where it misses none."""
    missed = np.nan_to_num(np.abs(table.after_percent))
    worst = [i for i in np.argsort(-missed)[:_NAMED] if missed[i] >= _LEAST_PERCENT]
    return ", ".join(
        f"{table.measured_hz[i]:.2f} Hz {_where(table, int(i))} ({missed[i]:.1f} %)" for i in worst
    )


def _where(table: FrequencyTable | ModalTable, row: int) -> str:
    if hasattr(table, "mode"):
        return f"of mode {table.mode[row]}"
    dof = int(table.dof[row])
    return f"at {table.dof_names.get(dof, f'dof {dof}')}"
