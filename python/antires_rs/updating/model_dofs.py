"""Measured dofs as dofs of the model, and the core's objectives of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from .. import _core
from ..exceptions import InvalidInputError
from ..support.validation import FloatArray

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["antiresonance_objective", "known_dof", "model_dof"]

#: Response, force, values (Hz), what the set can see, number of the set.
Part = tuple[int, int, FloatArray, str | None, int]


def model_dof(model: StructuralModel, name: str, label: Any) -> int:
    """A dof of the model that a measured set names, by its number or its name."""
    return model._dof(name, label)


def known_dof(model: StructuralModel, label: Any) -> int | None:
    """The same; None where it is no dof of the model."""
    try:
        return model._dof("dof", label)
    except InvalidInputError:
        return None


def antiresonance_objective(
    model: StructuralModel, parameters: Any, parts: Sequence[Part], *rest: Any
) -> _core.Objective:
    """The core's objective of responses, by their rows."""
    core, rows = model._core_for([dof for part in parts for dof in part[:2]])
    ends = zip(rows[::2], rows[1::2], strict=True)
    placed = [(*end, *part[2:]) for end, part in zip(ends, parts, strict=True)]
    return _core.Objective.antiresonance(core, parameters, placed, *rest)
