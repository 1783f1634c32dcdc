"""Edits made by hand on one set, made again on another: after a change of band or of orders none is lost."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..support.checks import FloatArray
from .antiresonance_set import AntiresonanceSet, damaged
from .edits import NAMED_WITHIN, SAME, Edit, edit_of


@dataclass(frozen=True)
class Asked:
    """An edit, how many values were identified ``near`` it, and how far ``within`` one is taken for it."""

    edit: Edit
    near: int  # within 1 % in the set before all edits: an added value with more has been identified itself
    within: float = NAMED_WITHIN  # or half way to the neighbour, which is not to be taken along

    @classmethod
    def on(cls, base: AntiresonanceSet, edit: Edit) -> Asked:
        """An edit made on a set."""
        off = _off(base, edit)
        within = 0.5 * float(off[off > SAME].min(initial=np.inf))
        return cls(edit, _near(off), min(NAMED_WITHIN, within))


def asked_of(zeros: AntiresonanceSet) -> tuple[Asked, ...]:
    """What a set records of edits."""
    return tuple(Asked.on(zeros.original(), edit) for edit in zeros.edits)


def replayed(base: AntiresonanceSet, asked: Iterable[Asked]) -> tuple[AntiresonanceSet, Sequence[str | None]]:
    """The set with all edits that it can take, and for each why it waits, None where it was made."""
    made = base
    waits: list[str | None] = []
    for each in asked:
        edit = each.edit
        why = _why_not(base, made, each)
        waits.append(why)
        if why is None and edit.action == "drop":
            made = made.drop(edit.dof, edit.freq_hz, reason=edit.reason)
        elif why is None:
            companions = {"damping_ratio": edit.damping_ratio, "std_hz": edit.std_hz}
            made = made.add(edit.dof, edit.freq_hz, reason=edit.reason, **companions)
    return made, waits


def _why_not(base: AntiresonanceSet, made: AntiresonanceSet, asked: Asked) -> str | None:
    edit = asked.edit
    if edit.dof not in made:
        return "this response is not there now"
    nearest = _off(made, edit).min(initial=np.inf)
    if edit.action == "drop":
        return None if nearest <= asked.within else "no value there now"
    found = nearest <= SAME or _near(_off(base, edit)) > asked.near
    return "identified there now" if found else None


def _near(off: FloatArray) -> int:
    return int(np.count_nonzero(off <= NAMED_WITHIN))


def _off(zeros: AntiresonanceSet, edit: Edit) -> FloatArray:
    """How far the values of its dof are from that of an edit, relative."""
    return np.abs(np.asarray(zeros.get(edit.dof, ()), dtype=np.float64) / edit.freq_hz - 1.0)


# -- The file of a set with edits that wait beside it: readers of sets leave those aside

KEY = "waiting_edits"  # where they stand in the JSON of the set


def to_json(zeros: AntiresonanceSet, waiting: Sequence[Asked]) -> str:
    """The text of :meth:`AntiresonanceSet.save`, with what could not be done to this set beside it."""
    text = zeros.to_json()
    if not waiting:
        return text
    rows = [{**asdict(each.edit), "near": each.near, "within": each.within} for each in waiting]
    return json.dumps(json.loads(text) | {KEY: rows}, indent=1, allow_nan=False) + "\n"


def asked_in(path: str | os.PathLike[str]) -> tuple[AntiresonanceSet, tuple[Asked, ...]]:
    """The set of a file, and all edits that were asked for: those it has, then those that wait."""
    zeros = AntiresonanceSet.load(path)
    try:
        rows = json.loads(Path(path).read_text(encoding="utf-8")).get(KEY, ())
        return zeros, (*asked_of(zeros), *map(_asked, rows))
    except (KeyError, TypeError, ValueError, AttributeError) as exc:
        raise damaged(str(path), exc) from exc


def _asked(row: dict[str, Any]) -> Asked:
    near, within = row.pop("near"), row.pop("within")
    if not isinstance(near, int) or not isinstance(within, int | float) or not 0 <= within <= NAMED_WITHIN:
        raise ValueError(f"edit with near = {near!r}, within = {within!r}")
    return Asked(edit_of(row), near, within)
