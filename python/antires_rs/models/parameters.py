"""Updating parameters: what may change in a model, and within which bounds.

Those of this module act on the terms of any model; :mod:`antires_rs.models.frame_parameters` has those of
frames.

Each function returns one :class:`Parameter` for a single element, or a list with one parameter for
each element of a sequence; add the lists to mix kinds. With ``together=True`` a sequence forms one
parameter that acts on all its elements. Several parameters on one element multiply.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np

from ..exceptions import AntiresWarning
from ..support.validation import FloatArray, choice, finite_scalar, integer, part, reject, shape_of

if TYPE_CHECKING:
    from .frame import FrameModel
    from .structural_model import StructuralModel

__all__ = ["Parameter", "mass_factor", "stiffness_factor", "stiffness_reduction"]

Quantity = Literal[
    "stiffness_reduction",
    "stiffness_factor",
    "mass_factor",
    "youngs_modulus",
    "density",
    "thickness",
    "diameter",
    "point_mass",
    "inertia",
    "support_stiffness",
    "angle",
]

#: What each quantity is called, its unit, and the least value it may have (and whether that is excluded).
_QUANTITIES: dict[Quantity, tuple[str, str, float, bool]] = {
    "stiffness_reduction": ("stiffness loss", "", 0.0, False),
    "stiffness_factor": ("stiffness", "", 0.0, True),
    "mass_factor": ("mass", "", 0.0, True),
    "youngs_modulus": ("Young's modulus", "Pa", 0.0, True),
    "density": ("density", "kg/m3", 0.0, True),
    "thickness": ("thickness", "m", 0.0, True),
    "diameter": ("outer diameter", "m", 0.0, True),
    "point_mass": ("mass", "kg", 0.0, False),
    "inertia": ("inertia", "kg m2", 0.0, False),
    "support_stiffness": ("stiffness", "N/m", 0.0, False),
    "angle": ("angle", "deg", -np.inf, False),
}
#: Their terms are sections, which may have names.
_OF_SECTIONS = ("youngs_modulus", "density", "thickness", "diameter")
#: Values of these quantities have units and need a model to have a nominal value.
_PROPERTIES = (*_OF_SECTIONS, "point_mass", "inertia", "support_stiffness")

#: (quantity, terms, relative, (pivot, axis)) as the core takes it.
CoreParameter = tuple[str, list[int], bool, tuple[int, tuple[float, float, float]] | None]

#: A nominal value this factor outside the bounds is taken for a slip.
FAR = 5.0

#: Largest stiffness loss by default: a lost element would leave the structure in two parts.
LARGEST_REDUCTION = 0.99


@dataclass(frozen=True)
class Parameter:
    """One scalar unknown of a model.

    Attributes
    ----------
    quantity : str
        ``'stiffness_reduction'`` (K_i scaled by 1 - beta), ``'stiffness_factor'``, ``'mass_factor'``; of
        frames ``'youngs_modulus'`` (Pa), ``'density'`` (kg/m3), ``'thickness'`` and ``'diameter'`` (m),
        ``'point_mass'`` (kg), ``'inertia'`` (kg m2), ``'support_stiffness'`` (N/m), ``'angle'`` (degrees).
    terms : tuple of int or str
        Zero-based: stiffness or mass terms of the model; sections (or their names), point masses or springs
        to ground; the elements of an angle's group.
    bounds : (float, float)
        Lower and upper bound of the value, in the unit above.
    relative : bool
        The value of a frame's property is a factor on the nominal one.
    pivot, axis
        Of an angle: the node about which, and the axis around which the group turns.

    Examples
    --------
    >>> import antires_rs as ar
    >>> one = ar.mass_factor(0, bounds=(0.9, 1.1))   # the functions make them
    >>> one == ar.Parameter("mass_factor", (0,), (0.9, 1.1)), one.nominal
    (True, 1.0)
    """

    quantity: Quantity
    terms: tuple[Any, ...]
    bounds: tuple[float, float]
    relative: bool = field(default=False, repr=False)
    pivot: int | None = field(default=None, repr=False)
    axis: tuple[float, float, float] = field(default=(0.0, 0.0, 1.0), repr=False)

    def __post_init__(self) -> None:
        choice("quantity", self.quantity, tuple(_QUANTITIES))
        if not isinstance(self.terms, tuple) or not self.terms:
            reject(
                "terms",
                self.terms,
                "a tuple of at least one zero-based term",
                "Make parameters by stiffness_factor, mass_factor and the like.",
            )
        for i, term in enumerate(self.terms):
            if not (isinstance(term, str) and self.quantity in _OF_SECTIONS):
                integer(part("terms", i), term, low=0)
        if (self.pivot is None) == (self.quantity == "angle"):
            reject(
                "pivot",
                self.pivot,
                "a node for an angle, and None for anything else",
                "Make parameters of angles by antires_rs.angle.",
            )
        if self.relative and self.quantity not in _PROPERTIES:
            reject(
                "relative",
                self.relative,
                f"False for '{self.quantity}'",
                "Only properties of sections, masses and supports can be relative.",
            )
        _bounds(self.bounds, self.quantity, self.relative)

    @property
    def nominal(self) -> float | None:
        """Value at which the model is as it was given: 0 for a reduction or angle, 1 for a factor.

        None for a property with a unit, whose nominal value is the model's; see ``UpdatingProblem.nominal``.
        """
        if self.quantity in ("stiffness_reduction", "angle"):
            return 0.0
        return None if self.quantity in _PROPERTIES and not self.relative else 1.0

    def common_scale(self, value: float) -> float:
        """Rate of this value when all stiffness and mass grow by one common factor.

        A factor or an amount grows with it, so does what a reduction leaves; lengths and angles do not.
        """
        if self.quantity == "stiffness_reduction":
            return value - 1.0
        return 0.0 if self.quantity in ("thickness", "diameter", "angle") else value


def core_parameters(model: StructuralModel, parameters: Iterable[Parameter]) -> list[CoreParameter]:
    """Parameters as the core takes them, the names of sections resolved, none listed twice."""
    parts: list[CoreParameter] = []
    for p in parameters:
        turn = None if p.pivot is None else (p.pivot, p.axis)
        parts.append((p.quantity, [_index(model, term) for term in p.terms], p.relative, turn))
    acting = [
        (quantity, turn, tuple(terms)) if turn else (quantity, term)
        for quantity, terms, _, turn in parts
        for term in (terms[:1] if turn else terms)
    ]
    twice = {pair for pair in acting if acting.count(pair) > 1}
    if twice:
        reject(
            "parameters",
            f"{sorted(twice)} more than once",
            "each quantity of a term once",
            "Leave one of the two parameters out.",
        )
    return parts


def _index(model: StructuralModel, term: int | str) -> int:
    if isinstance(term, int):
        return term
    if not hasattr(model, "section_index"):
        reject(
            "parameters",
            f"the section {term!r}",
            "zero-based terms, as the model is not a FrameModel",
            "Count the terms from 0, or build a FrameModel, which has named sections.",
        )
    return cast("FrameModel", model).section_index(term)


def parameter_name(model: StructuralModel, parameter: Parameter) -> str:
    """Name for tables, with the unit of the value."""
    quantity = parameter.quantity
    what, unit, *_ = _QUANTITIES[quantity]
    if parameter.relative:
        what, unit = f"{what} factor", ""
    terms = [_index(model, term) for term in parameter.terms]
    if quantity in _OF_SECTIONS:
        labels = [cast("FrameModel", model).section_label(term) for term in terms]
    elif quantity in ("mass_factor", "point_mass", "inertia"):
        labels = [
            model.mass_label(term + (0 if quantity == "mass_factor" else len(model.default_elements)))
            for term in terms
        ]
    elif quantity == "support_stiffness":
        labels = [model.element_label(term + len(model.default_elements)) for term in terms]
    else:
        labels = [model.element_label(term) for term in terms]
    about = f" about node {parameter.pivot}" if quantity == "angle" else ""
    name = f"{what} of {', '.join(labels)}{about}".replace("mass of mass", "mass")
    return f"{name} ({unit})" if unit else name


def warn_far(parameters: Iterable[Parameter], names: list[str], nominal: FloatArray) -> None:
    """Bounds in another unit than the model's value are a slip that no search can mend."""
    for parameter, name, value in zip(parameters, names, nominal, strict=True):
        low, high = parameter.bounds
        if value > 0.0 and not low / FAR <= value <= FAR * high:
            factors = parameter.nominal is None and high < 100.0
            hint = (
                "Bounds that are factors need relative=True." if factors else "Check the unit of the bounds."
            )
            warnings.warn(
                f"{name}: the model has {value:g}, far outside the bounds ({low:g}, {high:g}). " + hint,
                AntiresWarning,
                stacklevel=4,
            )


def stiffness_reduction(
    elements: Any, *, bounds: tuple[float, float] = (0.0, LARGEST_REDUCTION), together: bool = False
) -> Any:
    """Damage: loss ``beta`` of an element's stiffness, ``K = sum (1 - beta_i) K_i``.

    Parameters
    ----------
    elements : int or sequence of int
        Zero-based stiffness terms.
    bounds : (float, float)
        Within [0, 1].
    together : bool
        One parameter for the whole sequence.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or outside [0, 1], an element listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.stiffness_reduction(4)
    Parameter(quantity='stiffness_reduction', terms=(4,), bounds=(0.0, 0.99))
    >>> len(ar.stiffness_reduction(range(7)))
    7
    """
    return build("stiffness_reduction", elements, bounds, together)


def stiffness_factor(elements: Any, *, bounds: tuple[float, float], together: bool = False) -> Any:
    """Factor on the stiffness of elements; 1 leaves them as they are.

    Parameters
    ----------
    elements : int or sequence of int
        Zero-based stiffness terms.
    bounds : (float, float)
        Positive, for example ``(0.9, 1.1)``.
    together : bool
        One parameter for the whole sequence.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, an element listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.stiffness_factor([0, 1], bounds=(0.8, 1.2), together=True)
    Parameter(quantity='stiffness_factor', terms=(0, 1), bounds=(0.8, 1.2))
    """
    return build("stiffness_factor", elements, bounds, together)


def mass_factor(terms: Any, *, bounds: tuple[float, float], together: bool = False) -> Any:
    """Factor on mass terms; for a :class:`MassSpringChain`, term i is mass i.

    Parameters
    ----------
    terms : int or sequence of int
        Zero-based mass terms.
    bounds : (float, float)
        Positive, for example ``(0.9, 1.1)``.
    together : bool
        One parameter for the whole sequence.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, a term listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.mass_factor(0, bounds=(0.9, 1.1))
    Parameter(quantity='mass_factor', terms=(0,), bounds=(0.9, 1.1))
    """
    return build("mass_factor", terms, bounds, together)


def build(
    quantity: Quantity,
    terms: Any,
    bounds: Any,
    together: bool,
    *,
    name: str = "elements",
    relative: bool = False,
    pivot: int | None = None,
) -> Any:
    """One parameter of a single term, or one each of a sequence, or one of all together."""
    limits = _bounds(bounds, quantity, relative)

    def checked(where: str, term: Any) -> int | str:
        if isinstance(term, str) and quantity in _OF_SECTIONS:
            return term
        return integer(where, term, low=0)

    if shape_of(terms) == ():
        return Parameter(quantity, (checked(name, terms),), limits, relative, pivot)
    indices = [checked(part(name, i), t) for i, t in enumerate(terms)]
    if not indices:
        reject(
            name,
            "an empty sequence",
            f"at least one {name.rstrip('s')}",
            f"Name the {name} on which it acts.",
        )
    twice = sorted({t for t in indices if indices.count(t) > 1}, key=str)
    if twice:
        reject(
            name,
            f"{name.rstrip('s')}(s) {twice} more than once",
            f"each {name.rstrip('s')} once",
            "Remove the repeated ones.",
        )
    groups: Iterable[tuple[int | str, ...]] = [tuple(indices)] if together else [(t,) for t in indices]
    built = [Parameter(quantity, group, limits, relative, pivot) for group in groups]
    return built[0] if together else built


def _bounds(bounds: Any, quantity: Quantity, relative: bool) -> tuple[float, float]:
    _, unit, least, excluded = ("", "", 0.0, True) if relative else _QUANTITIES[quantity]
    most = 1.0 if quantity == "stiffness_reduction" else np.inf
    sign = "<" if excluded else "<="
    left = f"{least:g} {sign} " if np.isfinite(least) else ""
    wanted = f"a pair (lower, upper) with {left}lower <= upper{' <= 1' if most == 1.0 else ''}"
    wanted += f" in {unit}" if unit else ""
    if shape_of(bounds) != (2,):
        reject("bounds", bounds, wanted, "Write them as in (0.9, 1.1).")
    lower, upper = (
        finite_scalar(part("bounds", i), b, low=least, high=most, low_open=excluded)
        for i, b in enumerate(bounds)
    )
    if lower > upper:
        reject("bounds", (lower, upper), wanted, "Swap them.")
    return lower, upper
