"""An assessment in plain words: is there damage, where, how sure, how much, what else would explain it."""

from __future__ import annotations

from ..updating.explained import few_alone
from .answers import answer
from .assessment import Assessment
from .percent import figure
from .phrases import Label, loss_of, named
from .supersets import without_idle

__all__ = ["headline"]


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
