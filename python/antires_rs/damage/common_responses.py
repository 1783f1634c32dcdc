"""Which responses both states have, and what to say of the others."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..support.validation import reject

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel
    from ..updating.antiresonance_targets import AntiresonanceTargets

__all__ = ["not_in_both"]

#: So many are named.
_NAMED = 6

Response = tuple[int, int]


def not_in_both(
    model: StructuralModel, before: Sequence[AntiresonanceTargets], after: Sequence[AntiresonanceTargets]
) -> list[str]:
    """Notes on responses with values in one state only.

    Raises
    ------
    InvalidInputError
        No response has values in both.
    """
    intact, now = _with_values(before), _with_values(after)
    if not before or not now:
        return []
    if not set(intact) & set(now):
        reject(
            "baseline",
            f"values at {_named(model, intact)}",
            f"values at some of the dofs of measured: {_named(model, now)}",
            "Number the dofs of both tests alike, or test the intact structure at these dofs.",
        )
    notes = []
    new, gone = [r for r in now if r not in intact], [r for r in intact if r not in now]
    if new:
        notes.append(
            f"Measured now only: {_named(model, new)} ({_values(new, now)}). Without an intact state they "
            "are compared with the model alone and count less."
        )
    if gone:
        notes.append(
            f"Measured intact only: {_named(model, gone)} ({_values(gone, intact)}). They tell of the "
            "model's errors, not of damage."
        )
    return notes


def _with_values(targets: Sequence[AntiresonanceTargets]) -> dict[Response, int]:
    """Responses (dof, force) and how many values they have."""
    found: dict[Response, int] = {}
    for target in targets:
        for dof, force, freq, _, _ in target.parts:
            if freq.size:
                found[dof, force] = found.get((dof, force), 0) + freq.size
    return found


def _values(some: Sequence[Response], counts: dict[Response, int]) -> str:
    total = sum(counts[response] for response in some)
    return f"{total} value{'s' if total > 1 else ''}"


def _named(model: StructuralModel, responses: Sequence[Response] | dict[Response, int]) -> str:
    forces = {force for _, force in responses}
    names = [
        model.dof_label(dof) + (f" (force at {model.dof_label(force)})" if len(forces) > 1 else "")
        for dof, force in sorted(responses, key=lambda one: (one[1], one[0]))
    ]
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more
