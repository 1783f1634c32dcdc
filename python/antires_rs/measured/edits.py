"""What a person took out of a set of antiresonances, or put in, and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..support.validation import FloatArray, finite_scalar, real_array, reject
from .columns import unknown_scores

__all__ = ["Edit", "added", "described", "dropped"]

#: Distance of a frequency named by hand from the value it means, relative.
NAMED_WITHIN = 0.01
#: Values closer than this are one and the same.
SAME = 1e-9


@dataclass(frozen=True)
class Edit:
    """One value dropped from a set or added to it by hand.

    Attributes
    ----------
    action : {"drop", "add"}
    dof : int or str
    freq_hz : float
        The value itself, to the last bit, not the number typed.
    reason : str
    damping_ratio, std_hz : float or None
        What the value had, or was given; None where not known.
    scores : mapping of name to score
        What spoke for a dropped value.
    """

    action: str
    dof: Any
    freq_hz: float
    reason: str = ""
    damping_ratio: float | None = None
    std_hz: float | None = None
    scores: Mapping[str, Any] = field(default_factory=dict, hash=False)

    def __str__(self) -> str:
        verb = {"drop": "dropped", "add": "added"}[self.action]
        why = f" ({self.reason})" if self.reason else ""
        return f"{verb} {self.freq_hz:.2f} Hz at dof {self.dof}{why}"


#: Columns, scores and records of one dof after an edit.
Edited = tuple[dict[str, FloatArray], dict[str, Any], list[Edit]]


def described(edits: Sequence[Edit]) -> str:
    """One line for all edits."""
    return "edited by hand: " + "; ".join(map(str, edits))


def dropped(
    dof: Any,
    there: Mapping[str, FloatArray],
    scores: Mapping[str, Any],
    freq_hz: Any,
    reason: Any,
    tol_hz: float | None,
) -> Edited:
    """The columns ``there`` of a dof and their scores without the values meant by ``freq_hz``."""
    chosen = _nearest(_values_hz(freq_hz), there["freq_hz"], dof, tol_hz)
    reason = _check_reason(reason)
    records = []
    for i in chosen:
        known = {
            name: float(there[name][i])
            for name in ("damping_ratio", "std_hz")
            if not np.isnan(there[name][i])
        }
        own = {
            name: column[i].item() for name, column in scores.items() if column[i] == column[i]
        }  # NaN is not equal to itself
        records.append(Edit("drop", dof, float(there["freq_hz"][i]), reason, **known, scores=own))
    left = np.delete(np.arange(there["freq_hz"].size), chosen)
    return (
        {name: column[left] for name, column in there.items()},
        {name: column[left] for name, column in scores.items()},
        records,
    )


def added(
    dof: Any,
    there: Mapping[str, FloatArray],
    scores: Mapping[str, Any],
    freq_hz: Any,
    damping_ratio: Any,
    std_hz: Any,
    reason: Any,
) -> Edited:
    """The columns ``there`` of a dof and their scores with new values among them."""
    new = _values_hz(freq_hz)
    _clash(new, there["freq_hz"], dof)
    given = {
        "damping_ratio": _companion("damping_ratio", damping_ratio, new.size, ""),
        "std_hz": _companion("std_hz", std_hz, new.size, " in Hz"),
    }
    reason = _check_reason(reason)
    records = [
        Edit("add", dof, float(f), reason, damping, std)
        for f, damping, std in zip(new, given["damping_ratio"], given["std_hz"], strict=True)
    ]
    columns = {"freq_hz": new, **{name: np.array(v, dtype=np.float64) for name, v in given.items()}}
    rank = np.argsort(np.concatenate([there["freq_hz"], new]), kind="stable")
    return (
        {name: np.concatenate([column, columns[name]])[rank] for name, column in there.items()},
        {
            name: np.concatenate([column, unknown_scores(column, new.size)])[rank]
            for name, column in scores.items()
        },
        records,
    )


def _values_hz(value: Any) -> FloatArray:
    """One or more positive frequencies, in the order given."""
    wanted = "one or more positive frequencies in Hz"
    array = np.atleast_1d(real_array("freq_hz", value, ndim=None, wanted=wanted)).ravel()
    if array.min() <= 0.0:
        reject("freq_hz", f"{array.min():g} Hz", wanted)
    return array


def _check_reason(reason: Any) -> str:
    """A text, possibly empty."""
    if not isinstance(reason, str):
        reject("reason", reason, "a text")
    return reason


def _nearest(asked_hz: FloatArray, there_hz: FloatArray, dof: Any, tol_hz: float | None) -> list[int]:
    """Index of the value meant by each frequency, every value once."""
    there = ", ".join(f"{f:.3f}" for f in there_hz) + " Hz" if there_hz.size else "no value"
    if tol_hz is not None:
        finite_scalar("tol_hz", tol_hz, low=0.0, unit="Hz")
    chosen: list[int] = []
    for asked in asked_hz:
        within = NAMED_WITHIN * asked if tol_hz is None else tol_hz
        gap = np.abs(there_hz - asked)
        if not gap.size or gap.min() > within:
            reject(
                "freq_hz",
                f"{asked:g} Hz at dof {dof!r}, which has {there}",
                f"a frequency within {within:.3g} Hz of a value",
                "Name one of them, or widen tol_hz.",
            )
        at = int(np.argmin(gap))
        if at in chosen:
            reject(
                "freq_hz",
                f"{there_hz[at]:.3f} Hz of dof {dof!r} meant twice",
                "each value once",
                f"Dof {dof!r} has {there}.",
            )
        chosen.append(at)
    return chosen


def _companion(name: str, value: Any, count: int, unit: str) -> list[float | None]:
    """One number for all new values, or one each; None where not known."""
    if value is None:
        return [None] * count
    wanted = f"one finite number{unit}, or {count}, one for each frequency"
    array = np.atleast_1d(real_array(name, value, ndim=None, wanted=wanted)).ravel()
    if array.size not in (1, count):
        reject(name, f"{array.size} values", wanted)
    if name == "std_hz" and array.min() < 0.0:
        reject(name, f"{array.min():g} Hz", "standard deviations of at least 0 Hz")
    return [float(v) for v in np.broadcast_to(array, count)]


def _clash(new_hz: FloatArray, there_hz: FloatArray, dof: Any) -> None:
    """Refuse values that are there already, or come twice."""
    for i, value in enumerate(new_hz):
        for other, where in ((there_hz, "there already"), (new_hz[:i], "given twice")):
            if other.size and np.abs(other / value - 1.0).min() <= SAME:
                reject(
                    "freq_hz",
                    f"{value:g} Hz at dof {dof!r}, which is {where}",
                    "a value that is new",
                    "Drop the old one first if it is to be replaced.",
                )
