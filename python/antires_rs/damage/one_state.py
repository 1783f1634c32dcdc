"""What a search without a baseline comes to, in words: it compares one state with the model."""

from __future__ import annotations

from collections.abc import Mapping

from ..updating.explained import Explained
from .phrases import Label

__all__ = ["all_lost", "headline_of_one_state"]

#: So large a loss in half of the elements, or in so many, is none: the model is another structure.
_LOST, _MOST_LOST = 0.8, 4

_CAVEAT = (
    "Without a baseline an error of the model comes out as damage, and the values cannot tell which it is: "
    "give the values of the intact structure as baseline=."
)
_NO_BEFORE = (
    "Without a baseline it is not known what was there before, and errors of the model may hide damage."
)


def headline_of_one_state(
    losses: Mapping[int, float],
    label: Label,
    fit: Explained | None = None,
    n_elements: int = 0,
    *,
    finished: bool,
) -> list[str]:
    """The first lines of a report; ``losses`` are the severities found, the worst first.

    ``fit`` is what the model with these explains; None where that is not known.
    """
    found = "; ".join(
        f"{label(e)} has lost {100.0 * beta:.1f} % of its stiffness" for e, beta in losses.items()
    )
    if not finished:
        best = f"the best so far, if the model is exact, is that {found}" if losses else "no damage so far"
        return [f"The search was stopped: {best}.", _CAVEAT if losses else _NO_BEFORE]
    if fit is not None and (not fit.enough or all_lost(losses, n_elements)):
        so = f"the search came to this, which is no finding: {found}" if losses else "no damage is to be seen"
        return [fit.sentence, f"If the model can be trusted at all, {so}."]
    if losses:
        return [f"{found[0].upper()}{found[1:]}, if the model is exact.", _CAVEAT]
    return ["No damage found.", _NO_BEFORE]


def all_lost(losses: Mapping[int, float], n_elements: int) -> bool:
    """Whether so many elements have lost nearly all stiffness that it is no damage but a wrong model."""
    nearly = sum(beta >= _LOST for beta in losses.values())
    return nearly >= min(_MOST_LOST, max(0.5 * n_elements, 2.0))
