"""Measured dofs as dofs of the model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..support.validation import integer, reject

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["model_dof"]


def model_dof(model: StructuralModel, name: str, label: Any) -> int:
    """A dof of the model that a measured set names."""
    if isinstance(label, str):
        reject(
            name,
            repr(label),
            f"a zero-based dof of the model, 0..{model.n_dof - 1}",
            "Name the channels by the model's dofs: Recording(..., dofs=[0, 1, ...]).",
        )
    return integer(name, label, low=0, high=model.n_dof - 1)
