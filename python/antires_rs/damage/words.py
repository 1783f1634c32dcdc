"""An assessment in plain words: is there damage, where, how sure, how much, what else would explain it."""

from __future__ import annotations

from collections.abc import Callable

from .assessment import Assessment
from .hypotheses import Hypothesis

__all__ = ["headline", "percent", "reservations"]

Label = Callable[[int], str]
#: From this probability on something is said without reserve.
_SURE = 0.9
#: Intervals wider than this tell nothing.
_UNSEEN = 0.8


def headline(found: Assessment, label: Label) -> list[str]:
    """The first lines of a report."""
    best = found.best
    changed = 1.0 - found.probability_of_nothing
    if not best.candidate:
        lines = [
            "Something changed that none of the candidates explains "
            f"(probability {percent(found.probability_elsewhere)})."
        ]
        if not best.unknown:
            lines.append(f"{_loss(best, label, capital=True)}, which was no candidate, would explain it.")
        return lines
    if not found.declared:
        none = found.probability_of_nothing
        if not best.elements:
            lines = [f"No damage found: probability of no damage {percent(none)}."]
        else:
            lines = [
                f"No damage declared: its odds do not reach the threshold (probability {percent(changed)})."
            ]
        if none < _SURE:
            lines.append(f"Not excluded: {_alternatives(found, label)}.")
        return lines
    declared = next(one for one in found.hypotheses if one.elements == found.declared)
    if declared.probability >= _SURE or len(found.group) == 1:
        return [f"Damage: {_loss(declared, label)}; probability {percent(declared.probability)}."]
    sure = f"Damage is {'certain' if changed > 0.995 else 'probable'} ({percent(changed)})"
    if not found.group:
        return [f"{sure}, but the values cannot tell where.", f"First of many: {_loss(declared, label)}."]
    where = " or ".join(" and ".join(label(e) for e in one.elements) for one in found.group)
    share = sum(one.probability for one in found.group)
    return [
        f"{sure}: {where} (together {percent(share)}).",
        f"Most probable: {_loss(declared, label)}; probability {percent(declared.probability)}.",
    ]


def reservations(found: Assessment, label: Label) -> list[str]:
    """What a reader should know before trusting it."""
    notes = list(found.notes)
    if not found.baseline:
        notes.append(
            "Without a baseline every error of the model counts as damage. The probabilities assume "
            f"stiffnesses and masses within about {100 * found.factor_std:.0f} %; give the values of the "
            "intact structure as baseline= to have the model's errors taken out."
        )
    if found.best.candidate and not found.explained:
        notes.append(
            f"The most probable hypothesis does not explain the values (reduced chi-square "
            f"{found.chi_square:.1f}): something else may have changed as well."
        )
    lost = found.n_values - found.n_matched
    if lost:
        notes.append(
            f"{lost} of {found.n_values} values have no partner in the model: new ones, or false ones."
        )
    if found.baseline and found.kappa > 0.0:
        notes.append(
            f"The model predicts changes to about {100 * found.kappa:.0f} %: it explained the baseline to "
            f"{100 * found.root_std:.1f} %."
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
    others = [one for one in found.hypotheses if one.elements and one.probability > 0.01][:3]
    if not others:
        return "many small damages, none of them probable"
    return ", ".join(
        "a change that no element explains"
        if one.unknown
        else f"damage of {label(one.elements[0])}, which these values do not show "
        f"({percent(one.probability)})"
        if one.high[0] - one.low[0] > _UNSEEN
        else f"{_loss(one, label)} ({percent(one.probability)})"
        for one in others
    )


def _loss(one: Hypothesis, label: Label, *, capital: bool = False) -> str:
    words = " and ".join(
        f"{label(e)} has lost {100 * s:.1f} % of its stiffness (90 %: {100 * low:.1f} to {100 * high:.1f} %)"
        for e, s, low, high in zip(one.elements, one.severities, one.low, one.high, strict=True)
    )
    return words[0].upper() + words[1:] if capital else words


def percent(probability: float) -> str:
    """A probability in percent; what is nearly 0 or 1 is not rounded to it."""
    if probability > 0.999:
        return "above 99.9 %"
    return "below 0.1 %" if probability < 0.001 else f"{100 * probability:.1f} %"
