"""An assessment in plain words: is there damage, where, how sure, how much, what else would explain it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from ..updating.problem import NOT_EXPLAINED, Explained, few_alone
from ..updating.targets import FrequencyTable, ModalTable
from .hypotheses import Assessment, Hypothesis, figure, percent, span

# -- Losses, names and alternatives in words

_WORTH_A_WORD, _MOST_WORDS = 0.01, 3  # alternatives from this probability on are named, so many of them
_UNSEEN = 0.8  # intervals wider than this tell nothing
_NO_LOSS = 5e-4  # a loss that is printed as 0.0 %


def _else(found: Assessment, hypotheses: Iterable[Hypothesis], first: str = "What else it may be") -> str:
    """Those worth a word, each with its probability."""
    worth = [one for one in hypotheses if one.probability > _WORTH_A_WORD][:_MOST_WORDS]
    told = "; ".join(f"{_explanation(found, one)} ({percent(one.probability)})" for one in worth)
    return f"{first}: {told or 'many explanations, none of them probable'}."


def _explanation(found: Assessment, one: Hypothesis) -> str:
    if not one.elements:
        return "nothing"
    if one.unknown:
        return one.place or "a change that no element explains"
    if _unseen(one) or max(one.severities) < _NO_LOSS:
        return f"damage of {found.hypotheses.named(one.elements[:1])}, which these values do not show"
    return _loss_of(found, one) + ("" if one.candidate else ", which was no candidate")


def _unseen(one: Hypothesis) -> bool:
    """Whether the values tell nothing of a loss."""
    return not one.unknown and one.high[0] - one.low[0] > _UNSEEN


def _loss_of(found: Assessment, one: Hypothesis) -> str:
    """Losses in words, without intervals."""
    rows = zip(map(found.hypotheses.named, zip(one.elements, strict=True)), one.severities, strict=True)
    (name, loss), *others = ((name, f"{100 * severity:.1f} %") for name, severity in rows)
    more = [f"{name} {loss}" for name, loss in others]
    if one.place:
        return " and ".join([f"{one.place}, as flexible as {name} with {loss} less stiffness", *more])
    return " and ".join([f"{name} has lost {loss} of its stiffness", *more])


def _intervals(one: Hypothesis) -> str:
    """The intervals of all losses."""
    spans = [span(low, high) for low, high in zip(one.low, one.high, strict=True)]
    return f"90 % interval{'s' if len(spans) > 1 else ''} of the loss {' and '.join(spans)} %"


# -- What an assessment against a baseline comes to: damage, nothing, or what no candidate explains

_SURE, _EVEN = 0.9, 0.5  # from this probability on something is said without reserve
_BARELY = 2  # with fewer values to spare, sets with one element more explain them as well
_OF_TRIED = (
    "Nothing that was tried explains all of the values: something unknown may have changed, and "
    "probabilities compare only what was tried."
)


def _answer(found: Assessment) -> list[str]:
    """Sentences, the first the answer."""
    if found.moved_alike and not (found.best.severities or found.best.place):
        return _shifted(found)
    declared = found.answer
    if not found.best.candidate:
        lines = _unexplained(found)
    else:
        lines = _nothing(found) if declared is None else _damage(found, declared)
        lines = lines if found.explained else [_OF_TRIED, *lines]
    if found.n_risen:
        risen = f"Values have risen ({found.n_risen} of {found.n_moved} that moved)"
        lines.append(f"{risen}: are the sets swapped, or has something been stiffened?")
    return lines


def _shifted(found: Assessment) -> list[str]:
    """All values have moved alike."""
    way, share = "higher" if found.moved_alike > 0.0 else "lower", found.best.probability
    first = "No damage found" if share >= _SURE else "Probably no damage"
    first += f": all values are {figure(abs(found.moved_alike))} {way} than in the intact state, as another "
    first += f"temperature or sampling clock would have it (probability {percent(share)})."
    return [first] if share >= _SURE else [first, _else(found, found.hypotheses[1:])]


def _unexplained(found: Assessment) -> list[str]:
    best, share, changed = found.best, found.probability_elsewhere, 1.0 - found.probability_of_nothing
    if best.place and best.probability >= _SURE:
        sure = f"probability {percent(best.probability)}"
        if found.explained:
            return [f"No damage of the candidates explains the values, but this does ({sure}): {best.place}."]
        return [_OF_TRIED, f"The likeliest is this ({sure}): {best.place}."]
    if share >= _SURE:
        sure = f"probability {percent(share)}"
        lines = [f"Something has changed that none of the candidates explains ({sure})."]
    else:
        what = "Something" if changed >= _SURE else "It cannot be told whether something"
        perhaps = f"perhaps what none of the candidates explains (probability {percent(share)})"
        first = f"{what} has changed (probability {percent(changed)}), {perhaps}."
        lines = [first, _else(found, found.hypotheses[1:])]
    if best.place:
        lines.append(f"First of what would explain it: {best.place} ({percent(best.probability)}).")
    elif not best.unknown:
        loss = f"{_loss_of(found, best)} ({_intervals(best)})"
        lines.append(f"What would explain it, and was no candidate: {loss}.")
    return lines


def _nothing(found: Assessment) -> list[str]:
    none = found.probability_of_nothing
    # What was no candidate and shows in no value stays as probable as before: no reason to doubt the test.
    blind = [one for one in found.hypotheses if not one.candidate and one.elements and _unseen(one)]
    if found.best.elements:
        enough = "but not enough for the rate of false alarms asked for"
        first = f"No damage declared: it is probable ({percent(1.0 - none)}), {enough}."
    elif none >= _SURE:
        what = "nothing has changed" if found.explained else "the likeliest is that nothing has changed"
        return [f"No damage found: {what} (probability {percent(none)})."]
    elif none + sum(one.probability for one in blind) >= _SURE:
        first = f"No damage found: probably nothing has changed (probability {percent(none)})."
        return [first, _else(found, blind, "Not to be excluded")]
    else:
        first = "It cannot be told whether there is damage; probably nothing has changed (probability "
        first += f"{percent(none)})."
    return [first, _else(found, (one for one in found.hypotheses if one.elements))]


def _damage(found: Assessment, declared: Hypothesis) -> list[str]:
    changed = 1.0 - found.probability_of_nothing
    sized = f"Probability {percent(declared.probability)}; {_intervals(declared)}."
    lost = _loss_of(found, declared)
    if changed < _SURE:
        first = f"Perhaps damage ({percent(changed)})"
        if changed < _EVEN:
            first = "Damage is declared for the rate of false alarms asked for, though it is improbable"
        nothing = f"Probability that nothing has changed: {percent(1.0 - changed)}."
        return [f"{first}: {lost}.", f"{sized} {nothing}"]
    if declared.probability >= _SURE:
        k, matched = len(declared.elements), found.n_matched
        if matched - k < _BARELY:
            only = "only one element is" if k == 1 else f"no more than {k} elements are"
            values = f"{matched} value{'s' if matched > 1 else ''}"
            return [f"Damage; if {only} damaged: {lost}.", f"{sized} {values} cannot tell more."]
        return [f"{'Damage' if found.explained else 'Likeliest damage'}: {lost}.", sized]
    unknown = sum(one.probability for one in found.hypotheses if one.unknown)
    what = "There is damage" if unknown < 1.0 - _SURE else "Something has changed"
    sure = f"{what} (probability {percent(changed)})"
    if not found.group:
        where = ", but the values cannot tell where."
        if common := _common(found):
            where = f": {_with_share(found, common)}; perhaps others as well, the values cannot tell which."
        return [sure + where, f"First of many: {lost}. {sized}"]
    if len(found.group) == 1:
        others = (one for one in found.hypotheses if one is not declared)
        return [f"{sure}, probably this: {lost}.", f"{sized} {_else(found, others)}"]
    return [f"{sure}: {_alike(found)}", *_shares(found)]


def _alike(found: Assessment) -> str:
    """Where damage is, if several sets explain the values alike."""
    group = sorted(found.group, key=lambda one: one.elements)
    named, surely = found.hypotheses.named, _common(found)
    if not surely:
        return f"{' or '.join(named(one.elements) for one in group)}. The values cannot tell which."
    rests = [tuple(e for e in one.elements if e not in surely) for one in group]
    beside = " or ".join(named(rest) for rest in rests if rest)
    more = f"and {beside}, the values cannot tell which." if all(rests) else f"perhaps {beside} as well."
    return f"{_with_share(found, surely)}; {more}"


def _shares(found: Assessment) -> list[str]:
    """How probable each set of the group is, and what it has lost."""
    share = sum(one.probability for one in found.group)
    group = sorted(found.group, key=lambda one: (-one.probability, one.elements))
    losses = [f"{percent(one.probability)}: {_loss_of(found, one)} ({_intervals(one)})" for one in group]
    lines = [f"Together {percent(share)}. {'; '.join(losses)}."]
    if share < _SURE:
        lines.append(_else(found, (one for one in found.hypotheses if one not in found.group)))
    return lines


def _common(found: Assessment) -> tuple[int, ...]:
    """Elements that are damaged in whatever the values cannot tell apart."""
    if found.group:
        return tuple(e for e in found.group[0].elements if all(e in one.elements for one in found.group))
    every = sorted({e for one in found.hypotheses if one.candidate for e in one.elements})
    return tuple(e for e in every if found.marginal(e) >= _SURE)


def _with_share(found: Assessment, elements: tuple[int, ...]) -> str:
    """Elements, and the probability that they are damaged, whatever else is."""
    every = (one for one in found.hypotheses if one.candidate and {*elements} <= {*one.elements})
    return f"{found.hypotheses.named(elements)} ({percent(sum(one.probability for one in every))})"


# -- The first lines of a report

_CANNOT = "It cannot be told whether there is damage: {}"


def headline(found: Assessment) -> list[str]:
    """Is there damage, where, how sure, how much, and what else it may be."""
    doubts = [_CANNOT.format(found.unfit)] if found.unfit else []
    doubts += [_contradiction(found)] if found.odd_baselines else []
    if not (found.model_fits and found.states_fit):
        doubts.append(_not_explained(found))
    if found.interrupted:
        return [*_stopped(found), *doubts]
    return [*doubts, _if_trusted(found)] if doubts else _answer(found)


def _not_explained(found: Assessment) -> str:
    """The model cannot be that of the structure, or of both tests: why, and what to look at."""
    check = "its units, dofs, force and supports"
    if found.model_fits:  # the values of now have nothing to do with those of the intact structure
        have = "has" if found.n_matched == 1 else "have"
        why = f"{found.n_matched} of {found.n_values} values of now {have} a partner in it, damaged or not"
        check = "units, dofs, force and band of both tests"
    elif found.missing_support and not found.hint:
        why = f"held at {found.missing_support} as well, it would explain the intact structure far better"
        check = "its supports: one may be missing"
    elif not few_alone(found.n_intact_matched, found.n_intact):
        why = f"{found.n_intact_matched} of {found.n_intact} values of the intact structure"
        why += " have a partner in it"
    elif found.near:
        why = f"it has {found.n_intact_roots} roots where {found.n_intact} values were measured"
    else:
        why = f"its stiffnesses and masses would have to be off by {figure(found.factor_std)}, and its "
        why += f"frequencies by {figure(found.root_std)} beyond that"
    return NOT_EXPLAINED.format(why, f"{found.hint} " if found.hint else "", check)


def _stopped(found: Assessment) -> list[str]:
    """What was judged before Ctrl-C; without the others no probability holds."""
    many = len(found.hypotheses)
    judged = f"{many} hypotheses were" if many > 1 else "1 hypothesis was"
    lost = _loss_of(found, found.best) if found.best.severities else "nothing has changed"
    best = f"the likeliest of these is that {lost}"
    if found.best.place:
        best = f"the likeliest of these is this: {_explanation(found, found.best)}"
    elif found.best.unknown:
        best = "none of these explains the values"
    return [
        f"The search was stopped: {judged} judged, and {best}.",
        "Others may explain the values better, so that the probabilities say little: let it finish.",
    ]


def _if_trusted(found: Assessment) -> str:
    """The answer in one sentence, where what it rests on is in doubt."""
    trusted = "data" if found.unfit else "baseline" if found.odd_baselines else "model"
    if found.moved_alike and not (found.best.severities or found.best.place):
        what = "all values have moved alike, which is temperature or clock rather than damage"
    elif found.best.place and found.best.unknown:
        what = f"the values point to this: {found.best.place}"
    elif not found.best.candidate:
        what = "something has changed that none of the candidates explains"
    elif not found.declared:
        what = "no damage is to be seen"
    else:
        alike = sorted(one.elements for one in found.group)
        sets = alike if found.declared in alike else [found.declared]
        what = f"the values point to damage of {' or '.join(map(found.hypotheses.named, sets))}"
    return f"If the {trusted} can be trusted at all, {what}; the table has the figures."


def _contradiction(found: Assessment) -> str:
    """Which of the intact tests cannot be of the same structure as the others."""
    sets = [f"baseline set {nth}" for nth in found.odd_baselines]
    gap = figure(found.baseline_gap)
    if len(sets) == 1:
        said = f"{sets[0]} differs from the others by {gap}, these among themselves by "
        said += f"{figure(found.usual_gap)}. Leave it out, or find out what was different."
    else:
        said = f"{', '.join(sets[:-1])} and {sets[-1]} differ by up to {gap}, and which of them is wrong"
        said += " cannot be told. Test the intact structure again, or leave out what is not of it."
    return f"The baseline contradicts itself: {said}"


# -- Without a baseline: one state is compared with the model

#: So large a loss in half of the elements, or in so many, is none: the model is another structure.
_LOST, _MOST_LOST = 0.8, 4

_CAVEAT = (
    "Without a baseline an error of the model comes out as damage, and the values cannot tell which it is: "
    "give the values of the intact structure as a baseline."
)
_NO_BEFORE = "Without a baseline it is not known what was there before; errors of the model may hide damage."


def headline_of_one_state(
    losses: Mapping[int, float],
    label: Callable[[int], str],
    fit: Explained | None = None,
    n_elements: int = 0,
    unfit: str = "",
    *,
    finished: bool,
) -> list[str]:
    """The first lines of a report; ``losses`` are the severities found, the worst first."""
    each = [f"{label(e)} has lost {100.0 * beta:.1f} % of its stiffness" for e, beta in losses.items()]
    found = "; ".join(each)
    if not finished:
        best = f"the best so far, if the model is exact, is that {found}" if losses else "no damage so far"
        return [f"The search was stopped: {best}.", _CAVEAT if losses else _NO_BEFORE]
    if unfit:
        so = f"and the model is exact: {found}" if losses else "no damage is to be seen"
        return [_CANNOT.format(unfit), f"If the data can be trusted at all, {so}."]
    if fit is not None and (not fit.enough or all_lost(losses, n_elements)):
        so = f"the search came to this, which is no finding: {found}" if losses else "no damage is to be seen"
        return [fit.sentence, f"If the model can be trusted at all, {so}."]
    if fit is not None and fit.left:
        missed = f"the model misses values by up to {figure(fit.left)}, far more than their errors"
        so = f"the losses that come nearest leave most of it: {found}" if losses else "no loss explains it"
        return [_CANNOT.format(f"{missed}, and {so}."), _CAVEAT if losses else _NO_BEFORE]
    if losses:
        return [f"{found[0].upper()}{found[1:]}, if the model is exact.", _CAVEAT]
    return ["No damage found.", _NO_BEFORE]


def all_lost(losses: Mapping[int, float], n_elements: int) -> bool:
    """Whether so many elements have lost nearly all stiffness that it is no damage but a wrong model."""
    return sum(beta >= _LOST for beta in losses.values()) >= min(_MOST_LOST, max(0.5 * n_elements, 2.0))


_FEW = 4  # with fewer values to spare a fit says little


def reservations(found: Assessment) -> list[str]:
    """What a reader should know before trusting it."""
    matched, lost = found.n_matched, found.n_values - found.n_matched
    spare = matched - len(found.best.severities)
    notes = {
        "Without a baseline every error of the model counts as damage. The probabilities assume stiffnesses "
        f"and masses within about {figure(found.factor_std)}; a baseline, the values of the intact "
        "structure, takes the model's errors out.": not found.baseline,
        "No value of now has a partner in the model: there is no chi-square, and nothing tells whether the "
        "answer holds. Compare the bands and dofs of both tests.": not matched,
        f"The most probable hypothesis does not explain the values (reduced chi-square {found.chi_square:.1f}"
        "): something else may have changed as well.": (
            matched and (not found.best.unknown or found.best.place) and not found.explained
        ),
        f"{lost} of {found.n_values} values {'has' if lost == 1 else 'have'} no partner in the model: new or "
        "false.": lost and matched,
        f"{matched} value{'s' * (matched != 1)} {'cannot' if matched <= _FEW // 2 else 'hardly'} locate"
        " damage. Measure at more dofs, or in a wider band.": (found.n_values and spare < _FEW),
        f"The model predicts changes to about {figure(found.kappa)}: it explained the baseline to "
        f"{figure(found.root_std)}.": found.baseline and found.kappa > 0.0,
        "One test of the intact structure: how far values scatter from test to test is not known, their own "
        "standard deviations count. Test it again, and give both.": found.n_baselines == 1,
        f"Values scatter between the intact tests {found.scatter:.1f} times as much as their standard "
        "deviations say; all of them were multiplied by that.": (
            found.n_baselines != 1 and found.scatter > 1.0
        ),
        "Values without standard deviation count as known to 0.05 %.": found.assumed_std,
    }
    return [*found.notes, *(note for note, holds in notes.items() if holds)]


#: In place of the smallest damage that would be seen, after one test of the intact structure.
UNSEEN_OF_ONE = (
    "How small a damage such tests would show is not known from one test of the intact structure: the "
    "smallest losses assume that values scatter no more than their own standard deviations say."
)
#: What to do about reduced models that differ from the full one.
UNREDUCED = "Severities and probabilities move by as much; reduction=False takes the full model, and long."


_NAMED, _LEAST_PERCENT = 3, 0.05  # values that are named, with differences (in %) of at least so much


def largest_left(table: FrequencyTable | ModalTable) -> str:
    """The values that the model with the damage found misses most; '' where it misses none."""
    missed = np.nan_to_num(np.abs(table.after_percent))
    worst = [i for i in np.argsort(-missed)[:_NAMED] if missed[i] >= _LEAST_PERCENT]
    if isinstance(table, FrequencyTable):
        places = [f"at {table.dof_names.get(dof, f'dof {dof}')}" for dof in table.dof.tolist()]
    else:
        places = [f"of mode {mode}" for mode in table.mode]
    return ", ".join(f"{table.measured_hz[i]:.2f} Hz {places[i]} ({missed[i]:.1f} %)" for i in worst)
