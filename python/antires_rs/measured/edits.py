"""What a person took out of a set of antiresonances, or put in, and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..exceptions import reject
from ..support.checks import Dofs
from ..support.values import FrozenDict
from .response_table import ResponseTable, companion, frequencies_hz

NAMED_WITHIN = 0.01  # distance of a frequency named by hand from the value it means, relative
SAME = 1e-9  # values closer than this are one and the same
BY_HAND = "by hand"  # the source of what was added by hand, and what its text scores say
VERBS = {"drop": "dropped", "add": "added"}  # what an edit does, and how it is told


@dataclass(frozen=True)
class Edit:
    """One value dropped from a set or added to it by hand."""

    action: str  # "drop" or "add"
    dof: Any
    freq_hz: float  # the value itself, to the last bit, not the number typed
    reason: str = ""
    damping_ratio: float | None = None  # what it had, or was given; None where not known
    std_hz: float | None = None
    scores: Mapping[str, Any] = field(default_factory=dict, hash=False)  # what spoke for a dropped value

    def __post_init__(self) -> None:
        object.__setattr__(self, "scores", FrozenDict(self.scores))

    def __str__(self) -> str:
        why = f" ({self.reason})" if self.reason else ""
        return f"{VERBS[self.action]} {self.freq_hz:.2f} Hz at dof {self.dof}{why}"


def edit_of(row: dict[str, Any]) -> Edit:
    """An edit as a file has it; ValueError or TypeError for what is none."""
    edit = Edit(**row | {"dof": Dofs.of_file(row["dof"])})
    known = isinstance(row.get("scores", {}), dict) and isinstance(edit.reason, str)
    if edit.action not in VERBS or not known:
        raise ValueError(f"edit {row!r}")
    if not isinstance(edit.freq_hz, int | float) or not edit.freq_hz > 0.0:
        raise ValueError(f"edit of {edit.freq_hz!r} Hz")
    return edit


def dropped(dof: Any, table: ResponseTable, freq_hz: Any, reason: Any) -> tuple[ResponseTable, list[Edit]]:
    """The table of a dof without the rows meant by ``freq_hz``, and the record of it."""
    given_hz = frequencies_hz("freq_hz", freq_hz, empty=False)
    there = ", ".join(f"{f:.3f}" for f in table.freq_hz) + " Hz" if len(table) else "no value"
    _check_reason(reason)
    chosen: list[int] = []
    for asked in given_hz:
        within = NAMED_WITHIN * asked
        gap = np.abs(table.freq_hz - asked)
        if not gap.size or gap.min() > within:
            got = f"{asked:g} Hz at dof {dof!r}, which has {there}"
            reject("freq_hz", got, f"a frequency within {within:.3g} Hz of a value", "Name one of them.")
        at = int(np.argmin(gap))
        if at in chosen:
            got = f"{table.freq_hz[at]:.3f} Hz of dof {dof!r} meant twice"
            reject("freq_hz", got, "each value once", f"Dof {dof!r} has {there}.")
        chosen.append(at)
    records = []
    for i in chosen:
        # NaN is not equal to itself
        scores = {name: values[i].item() for name, values in table.scores.items() if values[i] == values[i]}
        known = reason, _known(table.damping_ratio[i]), _known(table.std_hz[i]), scores
        records.append(Edit("drop", dof, float(table.freq_hz[i]), *known))
    return table.take(np.delete(np.arange(len(table)), chosen)), records


def added(
    dof: Any, table: ResponseTable, freq_hz: Any, damping_ratio: Any, std_hz: Any, reason: Any
) -> tuple[ResponseTable, list[Edit]]:
    """The table of a dof with new rows, and the record of it."""
    new = frequencies_hz("freq_hz", freq_hz, empty=False)
    for i, value in enumerate(new):
        for other, where in ((table.freq_hz, "there already"), (new[:i], "given twice")):
            if other.size and np.abs(other / value - 1.0).min() <= SAME:
                got = f"{value:g} Hz at dof {dof!r}, which is {where}"
                remedy = "Drop the old one first if it is to be replaced."
                reject("freq_hz", got, "a value that is new", remedy)

    def column(name: str, own: Any) -> Any:
        value = np.full(new.size, np.nan if own is None else own) if np.ndim(own) == 0 else own
        return companion(name, value, new.size, std=name == "std_hz")

    damping, std = column("damping_ratio", damping_ratio), column("std_hz", std_hz)
    _check_reason(reason)
    # No method found them: their scores are not known.
    unknown = {name: BY_HAND if own.dtype.kind == "U" else np.nan for name, own in table.scores.items()}
    scores = {name: np.full(new.size, value) for name, value in unknown.items()}
    rows = ResponseTable(new, damping, std, scores, np.full(new.size, True))
    each = zip(new, damping, std, strict=True)
    records = [Edit("add", dof, float(f), reason, _known(zeta), _known(s)) for f, zeta, s in each]
    return ResponseTable.concatenated([table, rows]), records


def marked(table: ResponseTable, dof: Any, edits: Sequence[Edit]) -> ResponseTable:
    """The table as a file has it, with the rows marked that the edits added and did not drop again."""
    made: set[float] = set()
    for edit in edits:
        if edit.dof == dof:
            (made.add if edit.action == "add" else made.discard)(edit.freq_hz)
    return replace(table, by_hand=np.isin(table.freq_hz, list(made)))


def _known(value: float) -> float | None:
    return None if np.isnan(value) else float(value)


def _check_reason(reason: Any) -> None:
    if not isinstance(reason, str):
        reject("reason", reason, "a text", "Say in words why the value is changed.")
