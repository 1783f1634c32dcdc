"""The model and the elements that a question about damage names."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..models.structural_model import StructuralModel
from ..support.validation import integer, part, reject, shape_of

__all__ = ["checked_model", "elements_of"]


def checked_model(model: Any) -> StructuralModel:
    """A model of ours."""
    if not isinstance(model, StructuralModel):
        reject(
            "model",
            model,
            "a MassSpringChain, FrameModel or MatrixModel",
            "Build the model as one of these first.",
        )
    return model


def elements_of(model: StructuralModel, elements: Any) -> list[int]:
    """Candidate elements by number: all springs between masses, all beams or all terms by default."""
    terms = model._core.n_stiffness_terms
    if elements is None:
        chosen = list(model.default_elements)
    elif isinstance(elements, str) or (shape_of(elements) == () and not np.isscalar(elements)):
        reject("elements", elements, "numbers of elements", "As in elements=[3, 4].")
    else:
        chosen = [elements] if shape_of(elements) == () else list(elements)
    if not chosen:
        reject(
            "elements",
            "no candidate",
            "at least one stiffness term",
            f"Name some of 0 to {terms - 1}." if terms else "Give the MatrixModel its stiffness_terms.",
        )
    return [integer(part("elements", i), e, low=0, high=terms - 1) for i, e in enumerate(chosen)]
