"""A model and its description: how it is built, copied and changed, and what its parts are called."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Self

from ..support.directions import point_of
from ..support.pickling import AroundCore, ReadOnly
from ..support.validation import reject
from .description import AppliedParameters, ModelDescription
from .dof_names import DofNames

if TYPE_CHECKING:
    from .._core import Model as CoreModel

__all__ = ["Described"]


class Described(AroundCore["CoreModel"], ReadOnly):
    """What a model is made of, and the core's model made of it. Read-only."""

    #: Kind of recipe that this class is built from.
    _recipe_type: ClassVar[type | None] = None
    _description: ModelDescription

    def _build(self, description: ModelDescription, core: CoreModel | None = None) -> None:
        """Fill the model; ``core`` where it is at hand already."""
        self._fill(_description=description, _core=description.core() if core is None else core)

    def _made_core(self) -> CoreModel:
        return self._description.core()

    @property
    def description(self) -> ModelDescription:
        """What the model was made of and the parameters applied since: all that a copy or a file needs.

        Examples
        --------
        >>> import antires_rs as ar
        >>> chain = ar.MassSpringChain([1.0, 2.0], [500.0])
        >>> chain.description.recipe.springs_n_per_m
        array([500.])
        >>> again = ar.MassSpringChain.from_description(chain.description)
        >>> again.description == chain.description
        True
        """
        return self._description

    @classmethod
    def from_description(cls, description: ModelDescription) -> Self:
        """Build a model of this class from its description, to the same bits.

        Parameters
        ----------
        description : ModelDescription
            As :attr:`description` gives it.

        Raises
        ------
        InvalidInputError
            The description of another kind of model.

        Examples
        --------
        >>> import antires_rs as ar
        >>> chain = ar.MassSpringChain([1.0, 2.0], [500.0])
        >>> ar.MassSpringChain.from_description(chain.description)
        MassSpringChain(2 masses)
        """
        wanted = cls._recipe_type
        if not isinstance(description, ModelDescription):
            reject("description", description, "a ModelDescription", "Take it from a model's .description.")
        if wanted is None or not isinstance(description.recipe, wanted):
            needed = "one" if wanted is None else f"a {wanted.__name__}"
            reject(
                "description",
                f"the recipe of another kind of model, a {type(description.recipe).__name__}",
                f"{needed} that a {cls.__name__} is made of",
                "Call from_description of the class that the description was taken from.",
            )
        model = object.__new__(cls)
        model._build(description)
        return model

    def with_parameters(self, parameters: Any, values: Any) -> Self:
        """The model with parameters applied, as an updating leaves it; this one stays as it is.

        Parameters
        ----------
        parameters : Parameter or sequence of Parameter
            From :func:`stiffness_factor`, :func:`stiffness_reduction`, :func:`thickness` and the others.
        values : float or array_like, (n,)
            One value for each, in its unit; not held to the bounds.

        Raises
        ------
        InvalidInputError
            Another number of values, a parameter that changes nothing, a value that leaves no structure.

        Examples
        --------
        >>> import antires_rs as ar
        >>> chain = ar.MassSpringChain([1.0, 2.0], [500.0])
        >>> chain.with_parameters(ar.stiffness_reduction(0), 0.4).stiffness()
        array([[ 300., -300.],
               [-300.,  300.]])
        """
        applied = AppliedParameters.checked(parameters, values)
        model = object.__new__(type(self))
        core = self._description.applied_to(self._core, applied)
        model._build(self._description.with_parameters(applied), core)
        return model

    def _core_for(self, dofs: Sequence[int]) -> tuple[CoreModel, list[int]]:
        """The core's model in which ``dofs`` are rows, and these rows."""
        return self._core, list(dofs)

    def _core_exactly(self, dofs: Sequence[int]) -> tuple[CoreModel, list[int]]:
        """The same with the motion over penalties, so that the highest roots are there too."""
        return self._core_for(dofs)

    @property
    def _needs_both_methods(self) -> bool:
        """Whether only poles and QZ together, each root confirmed, are right: few dofs, K / M far apart."""
        return False

    def _core_as_given(self, dofs: Sequence[int]) -> tuple[CoreModel, list[int]]:
        """The same with the penalties, which else are taken out."""
        return self._core_for(dofs)

    def _together(self, responses: Sequence[int], force: int) -> list[list[int]]:
        """Places of responses that one core has with the force, core by core."""
        return [list(range(len(responses)))]

    @property
    def n_dof(self) -> int:
        """Number of degrees of freedom."""
        return self._core.n_dof

    def element_label(self, element: int) -> str:
        """Name of stiffness term ``element`` in tables and pictures, with its number as an argument."""
        return f"element {element}"

    def dof_label(self, dof: int) -> str:
        """Name of a dof in tables and pictures: its zero-based number, where nothing else names it."""
        return f"dof {dof}"

    @cached_property
    def _names(self) -> DofNames:
        return DofNames(self._dof_labels())

    def _dof_labels(self) -> list[str]:
        """:meth:`dof_label` of all dofs."""
        return [self.dof_label(dof) for dof in range(self.n_dof)]

    @property
    def _free_dofs(self) -> list[int]:
        """Those that are not taken out of the matrices."""
        return list(range(self.n_dof))

    @property
    def _sensor_dofs(self) -> list[int]:
        """Where an accelerometer may be: all of these but rotations, where names tell them."""
        points = map(point_of, self._dof_labels())
        turning = {dof for dof, point in enumerate(points) if point is not None and abs(point[1]) > 3}
        return [dof for dof in self._free_dofs if dof not in turning]

    def mass_label(self, term: int) -> str:
        """Name of mass term ``term`` in tables, with its number as an argument."""
        return f"mass {term}"

    @property
    def default_elements(self) -> list[int]:
        """Stiffness terms that :func:`assess_damage` looks at unless told otherwise."""
        return list(range(self._core.n_stiffness_terms))

    @property
    def _springs(self) -> list[int]:
        """Stiffness terms that have a stiffness."""
        return list(range(self._core.n_stiffness_terms))
