"""One description of a model: what it was made of, and the parameters that were applied to it since.

Every model is built from its description, copied, pickled and saved by it. Rebuilding gives the same bits:
first the recipe's matrices, then each set of parameters in its order, on the state that those before it left.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.validation import FloatArray, real_array, reject
from ..support.values import Value
from .parameter import CoreParameter, Parameter, core_parameters, parameter_tuple
from .recipes import ChainRecipe, FrameRecipe, MatrixRecipe

if TYPE_CHECKING:
    from .._core import Model as CoreModel

__all__ = ["AppliedParameters", "ModelDescription", "Recipe"]

Recipe = ChainRecipe | MatrixRecipe | FrameRecipe


@dataclass(frozen=True, eq=False)
class AppliedParameters(Value):
    """Parameters and the values that they were given, as one updating leaves them.

    Attributes
    ----------
    parameters : tuple of Parameter
    values : ndarray, (n,)
    """

    parameters: tuple[Parameter, ...]
    values: FloatArray

    @classmethod
    def checked(cls, parameters: Any, values: Any) -> AppliedParameters:
        """Of what a caller gave: one finite value for each parameter."""
        chosen = parameter_tuple(parameters)
        n = len(chosen)
        wanted = f"an array ({n},), one value for each parameter"
        vector = np.atleast_1d(real_array("values", values, ndim=None, wanted=wanted))
        if vector.shape != (n,):
            reject(
                "values",
                f"an array of shape {np.shape(values)}",
                wanted,
                "Give a value for each parameter, in their order.",
            )
        return cls(chosen, vector)


@dataclass(frozen=True, eq=False)
class ModelDescription(Value):
    """What a model is: its recipe, and the parameters applied to it, in order.

    Attributes
    ----------
    recipe : ChainRecipe, MatrixRecipe or FrameRecipe
        What the constructor was given; see :mod:`antires_rs.models.recipes`.
    applied : tuple of AppliedParameters
        One for each updating that the model went through; none for a model as it was made.

    Examples
    --------
    >>> import antires_rs as ar
    >>> chain = ar.MassSpringChain([1.0, 2.0], [500.0])
    >>> damaged = chain.with_parameters(ar.stiffness_reduction(0), 0.4)
    >>> damaged.description.recipe == chain.description.recipe
    True
    >>> [(one.parameters[0].quantity, one.values.tolist()) for one in damaged.description.applied]
    [('stiffness_reduction', [0.4])]
    """

    recipe: Recipe
    applied: tuple[AppliedParameters, ...] = ()

    def with_parameters(self, applied: AppliedParameters) -> ModelDescription:
        """The description of this model with further parameters applied."""
        return ModelDescription(self.recipe, (*self.applied, applied))

    def core_parameters(self, parameters: Iterable[Parameter]) -> list[CoreParameter]:
        """Parameters as the core takes them."""
        return core_parameters(self.recipe.section_index, parameters)

    def core(self) -> CoreModel:
        """The core's model, made from nothing but this description."""
        core = self.recipe.core()
        for applied in self.applied:
            core = self.applied_to(core, applied)
        return core

    def applied_to(self, core: CoreModel, applied: AppliedParameters) -> CoreModel:
        """The core's model with parameters applied to the state that ``core`` is."""
        return core.at(self.core_parameters(applied.parameters), applied.values)
