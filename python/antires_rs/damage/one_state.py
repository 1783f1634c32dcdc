"""What a search without a baseline comes to, in words: it compares one state with the model."""

from __future__ import annotations

from collections.abc import Mapping

from .phrases import Label

__all__ = ["headline_of_one_state"]

_CAVEAT = (
    "Without a baseline an error of the model comes out as damage, and the values cannot tell which it is: "
    "give the values of the intact structure as baseline=."
)
_NO_BEFORE = (
    "Without a baseline it is not known what was there before, and errors of the model may hide damage."
)


def headline_of_one_state(losses: Mapping[int, float], label: Label, *, finished: bool) -> list[str]:
    """The first lines of a report; ``losses`` are the severities found, the worst first."""
    found = "; ".join(
        f"{label(e)} has lost {100.0 * beta:.1f} % of its stiffness" for e, beta in losses.items()
    )
    if not finished:
        best = f"the best so far, if the model is exact, is that {found}" if losses else "no damage so far"
        return [f"The search was stopped: {best}.", _CAVEAT if losses else _NO_BEFORE]
    if losses:
        return [f"{found[0].upper()}{found[1:]}, if the model is exact.", _CAVEAT]
    return ["No damage found.", _NO_BEFORE]
