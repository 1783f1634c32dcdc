"""What may be wrong in a model: a factor on every stiffness and every mass term."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .. import _core
from ..exceptions import InvalidInputError
from ..models.parameter import Parameter

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["BOUNDS", "factors_of"]

#: Bounds of a factor, exp(-1.6) to exp(1.6): no model of an engineer is as wrong as that.
BOUNDS = (0.2, 5.0)


def factors_of(model: StructuralModel) -> tuple[Parameter, ...]:
    """A factor for each stiffness and mass term that is not zero."""
    stiffness = [Parameter("stiffness_factor", (term,), BOUNDS) for term in model._springs]
    mass = [Parameter("mass_factor", (term,), BOUNDS) for term in range(model._core.n_mass_terms)]
    return tuple(factor for factor in (*stiffness, *mass) if _governs(model, factor))


def _governs(model: StructuralModel, factor: Parameter) -> bool:
    try:
        parts = model.description.core_parameters((factor,))
        _core.check_bounds(model._core, parts, np.array(BOUNDS[:1]), np.array(BOUNDS[1:]))
    except InvalidInputError:  # a term that is zero, or without which nothing holds together
        return False
    return True
