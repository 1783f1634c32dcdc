"""The model, the elements and the prior that a question about damage names."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..models.structural_model import StructuralModel
from ..support.validation import finite_scalar, integer, part, reject, shape_of
from .prior import DamagePrior

__all__ = ["checked_model", "checked_prior", "elements_of"]


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


def checked_prior(prior: Any, false_alarm_rate: Any) -> DamagePrior:
    """What is believed before the test; a rate of false alarms needs some that there is none."""
    if prior is not None and not isinstance(prior, DamagePrior):
        reject("prior", prior, "a DamagePrior", "Leave it out for DamagePrior().")
    if false_alarm_rate is not None:
        finite_scalar("false_alarm_rate", false_alarm_rate, low=0.0, high=0.5, low_open=True)
        if prior is not None and not (prior.nothing and prior.one):
            reject(
                "false_alarm_rate",
                false_alarm_rate,
                "None: by this prior there is "
                + ("always damage" if prior.nothing == 0.0 else "never damage of one element alone"),
                "Give prior.nothing and prior.one more than 0.",
            )
    return prior or DamagePrior()


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
