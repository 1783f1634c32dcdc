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
    return _governing(model, (*stiffness, *mass))


def _governing(model: StructuralModel, factors: tuple[Parameter, ...]) -> tuple[Parameter, ...]:
    """Those that may be anywhere within their bounds: all, or halves of them looked at anew."""
    if not factors or _governs(model, factors):
        return factors
    half = len(factors) // 2
    if not half:  # a term that is zero, or without which nothing holds together
        return ()
    return _governing(model, factors[:half]) + _governing(model, factors[half:])


def _governs(model: StructuralModel, factors: tuple[Parameter, ...]) -> bool:
    low, high = (np.full(len(factors), bound) for bound in BOUNDS)
    try:
        parts = model.description.core_parameters(factors)
        _core.check_bounds(model._core, parts, low, high)
    except InvalidInputError:
        return False
    return True
