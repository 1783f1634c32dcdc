"""One updating parameter: what it may act on, within which bounds, and what the core takes of it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol, cast

import numpy as np

from ..exceptions import part, reject
from ..support.checks import FloatArray, choice, finite_scalar, integer, shape_of
from ..support.messages import warn

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
    "length",
    "position",
]

#: What each quantity is called, its unit, and the least value it may have (and whether that is excluded).
QUANTITIES: dict[Quantity, tuple[str, str, float, bool]] = {
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
    "length": ("length", "", 0.0, True),
    "position": ("position", "m", -np.inf, False),
}
#: Their terms are sections, which may have names.
OF_SECTIONS = ("youngs_modulus", "density", "thickness", "diameter")
#: Values of these quantities have units and need a model to have a nominal value.
_PROPERTIES = (*OF_SECTIONS, "point_mass", "inertia", "support_stiffness")

#: They move nodes; of these, those that have a pivot.
_MOVES, _ABOUT_A_NODE = ("angle", "length", "position"), ("angle", "length")

#: (quantity, terms, relative, (pivot or 0, axis or zeros)) as the core takes it; None for what moves no node.
CoreParameter = tuple[str, list[int], bool, tuple[int, tuple[float, float, float]] | None]


@dataclass(frozen=True)
class Parameter:
    """One scalar unknown of a model.

    Attributes
    ----------
    quantity : str
        ``'stiffness_reduction'`` (K_i scaled by 1 - beta), ``'stiffness_factor'``, ``'mass_factor'``; of
        frames ``'youngs_modulus'`` (Pa), ``'density'`` (kg/m3), ``'thickness'`` and ``'diameter'`` (m),
        ``'point_mass'`` (kg), ``'inertia'`` (kg m2), ``'support_stiffness'`` (N/m), ``'angle'`` (degrees),
        ``'length'`` (a factor), ``'position'`` (m).
    terms : tuple of int or str
        Zero-based: stiffness or mass terms of the model; sections (or their names), point masses or springs
        to ground; the elements of an angle's or length's group; the nodes of a position.
    bounds : (float, float)
        Lower and upper bound of the value, in the unit above.
    relative : bool
        The value of a frame's property is a factor on the nominal one.
    pivot, axis
        Of an angle: the node about which, and the axis around which the group turns. Of a length: the node
        that stays. Of a position: the direction, as a unit vector.

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
        choice("quantity", self.quantity, tuple(QUANTITIES))
        if not isinstance(self.terms, tuple) or not self.terms:
            reject(
                "terms",
                self.terms,
                "a tuple of at least one zero-based term",
                "Make parameters by stiffness_factor, mass_factor and the like.",
            )
        for i, term in enumerate(self.terms):
            if not (isinstance(term, str) and self.quantity in OF_SECTIONS):
                integer(part("terms", i), term, low=0)
        if (self.pivot is None) == (self.quantity in _ABOUT_A_NODE):
            reject(
                "pivot",
                self.pivot,
                "a node for an angle or a length, and None for anything else",
                "Make such parameters by antires_rs.angle and antires_rs.length.",
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
        """Value at which the model is as it was given: 0 for a reduction, angle or position, 1 for a factor.

        None for a property with a unit, whose nominal value is the model's; see ``UpdatingProblem.nominal``.
        """
        if self.quantity in ("stiffness_reduction", "angle", "position"):
            return 0.0
        return None if self.quantity in _PROPERTIES and not self.relative else 1.0

    def common_scale(self, value: float) -> float:
        """Rate of this value when all stiffness and mass grow by one common factor.

        A factor or an amount grows with it, so does what a reduction leaves; lengths and angles do not.
        """
        if self.quantity == "stiffness_reduction":
            return value - 1.0
        geometry = ("thickness", "diameter", "angle", "length", "position")
        return 0.0 if self.quantity in geometry else value


def parameter_tuple(parameters: Any) -> tuple[Parameter, ...]:
    """One parameter or several, as a tuple."""
    wanted = "Parameters, from stiffness_factor, mass_factor, stiffness_reduction and the like"
    if isinstance(parameters, Parameter):
        return (parameters,)
    try:
        chosen = tuple(parameters)
    except TypeError:
        reject("parameters", parameters, wanted, "Make them by stiffness_factor, mass_factor and the like.")
    for i, parameter in enumerate(chosen):
        if not isinstance(parameter, Parameter):
            reject(part("parameters", i), parameter, wanted, "Join lists with +, without nesting them.")
    return chosen


def core_parameters(
    section_index: Callable[[int | str], int], parameters: Iterable[Parameter]
) -> list[CoreParameter]:
    """Parameters as the core takes them, the names of sections resolved, none listed twice."""
    parts: list[CoreParameter] = []
    for p in parameters:
        moves = (p.pivot or 0, p.axis) if p.quantity in _MOVES else None
        indices = [term if isinstance(term, int) else section_index(term) for term in p.terms]
        parts.append((p.quantity, indices, p.relative, moves))
    # Several angles, lengths and positions may move one node.
    acting = [
        (quantity, moves, tuple(terms)) if moves else (quantity, term)
        for quantity, terms, _, moves in parts
        for term in (terms[:1] if moves else terms)
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


def build(
    quantity: Quantity,
    terms: Any,
    bounds: Any,
    together: bool,
    *,
    name: str = "elements",
    relative: bool = False,
    pivot: int | None = None,
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0),
) -> Any:
    """One parameter of a single term, or one each of a sequence, or one of all together."""
    limits = _bounds(bounds, quantity, relative)

    def checked(where: str, term: Any) -> int | str:
        if isinstance(term, str) and quantity in OF_SECTIONS:
            return term
        return integer(where, term, low=0)

    if shape_of(terms) == ():
        return Parameter(quantity, (checked(name, terms),), limits, relative, pivot, axis)
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
    built = [Parameter(quantity, group, limits, relative, pivot, axis) for group in groups]
    return built[0] if together else built


def _bounds(bounds: Any, quantity: Quantity, relative: bool) -> tuple[float, float]:
    _, unit, least, excluded = ("", "", 0.0, True) if relative else QUANTITIES[quantity]
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


# -- What parameters are called in tables, and values far from those of the model


#: A nominal value this factor outside the bounds is taken for a slip.
FAR = 5.0


class _Labelled(Protocol):
    """What a model calls its parts: with their numbers as arguments, from 0."""

    @property
    def default_elements(self) -> list[int]: ...
    def element_label(self, element: int) -> str: ...
    def mass_label(self, term: int) -> str: ...


class _LabelledFrame(_Labelled, Protocol):
    def section_index(self, name: str | int) -> int: ...
    def section_label(self, section: int) -> str: ...


def parameter_name(model: _Labelled, parameter: Parameter) -> str:
    """Name for tables, with the unit of the value."""
    quantity = parameter.quantity
    what, unit, *_ = QUANTITIES[quantity]
    if parameter.relative:
        what, unit = f"{what} factor", ""
    terms = parameter.terms
    about = {"angle": f" about node {parameter.pivot}", "length": f" from node {parameter.pivot}"}.get(
        quantity, ""
    )
    if quantity in OF_SECTIONS:
        frame = cast(_LabelledFrame, model)
        labels = [frame.section_label(frame.section_index(term)) for term in terms]
    elif quantity in ("mass_factor", "point_mass", "inertia"):
        # Point masses are the mass terms after those of the beams.
        first = 0 if quantity == "mass_factor" else len(model.default_elements)
        labels = [model.mass_label(first + term) for term in terms]
    elif quantity == "position":
        axis = ", ".join(f"{x:g}" for x in parameter.axis)
        labels = [f"node {term}" for term in terms]
        about = f" along ({axis})"
    else:
        # Springs to ground are the stiffness terms after the beams.
        first = len(model.default_elements) if quantity == "support_stiffness" else 0
        labels = [model.element_label(first + term) for term in terms]
    name = f"{what} of {', '.join(labels)}{about}".replace("mass of mass", "mass")
    return f"{name} ({unit})" if unit else name


def warn_far(parameters: Iterable[Parameter], names: Sequence[str], nominal: FloatArray) -> None:
    """Bounds in another unit than the model's value are a slip that no search can mend."""
    for parameter, name, value in zip(parameters, names, nominal, strict=True):
        low, high = parameter.bounds
        if value > 0.0 and not low / FAR <= value <= FAR * high:
            factors = parameter.nominal is None and high < 100.0
            hint = (
                "Bounds that are factors need relative=True." if factors else "Check the unit of the bounds."
            )
            warn(
                "far_outside_bounds",
                f"{name}: the model has {value:g}, far outside the bounds ({low:g}, {high:g}). " + hint,
            )
