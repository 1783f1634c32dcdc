"""Updating parameters of any model: they act on the terms of its stiffness and mass.

Each function returns one :class:`Parameter` for a single element, or a list of one for each element of a
sequence, or with ``together=True`` one that acts on all of them; add the lists to mix kinds. Several
parameters on one element multiply.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from inspect import getdoc, signature
from typing import Any, Literal, NamedTuple, TypeVar

import numpy as np

from ..exceptions import Name, part, reject
from ..support.checks import FloatArray, choice, finite_scalar, integer, real_array, shape_of
from ..support.messages import warn
from ..support.values import Value

# -- One updating parameter: what it may act on, within which bounds, and what the core takes of it

Quantity = Literal[
    "stiffness_reduction", "stiffness_factor", "mass_factor", "youngs_modulus", "density", "thickness",
    "diameter", "point_mass", "inertia", "support_stiffness", "angle", "length", "position",
]  # fmt: skip
Bounds = tuple[float, float]
Vector = tuple[float, float, float]


class Kind(NamedTuple):
    """What a quantity is called, its unit, the argument that lists its terms, and what values it may have."""

    what: str
    unit: str
    terms: str
    least: float = 0.0
    excluded: bool = True  # whether the least value itself is excluded
    #: Value of the model as it was given; None where that is the model's own, in the unit.
    nominal: float | None = 1.0


#: Their terms are sections, which may have names; they move nodes; of these, those that have a pivot.
OF_SECTIONS = ("youngs_modulus", "density", "thickness", "diameter")
_OF_TERMS = ("stiffness_reduction", "stiffness_factor", "mass_factor")  # which a MatrixModel may name
MOVES, _ABOUT_A_NODE = ("angle", "length", "position"), ("angle", "length")

KINDS: dict[Quantity, Kind] = {
    "stiffness_reduction": Kind("stiffness loss", "", "elements", excluded=False, nominal=0.0),
    "stiffness_factor": Kind("stiffness", "", "elements"),
    "mass_factor": Kind("mass", "", "elements"),
    "youngs_modulus": Kind("Young's modulus", "Pa", "sections", nominal=None),
    "density": Kind("density", "kg/m3", "sections", nominal=None),
    "thickness": Kind("thickness", "m", "sections", nominal=None),
    "diameter": Kind("outer diameter", "m", "sections", nominal=None),
    "point_mass": Kind("mass", "kg", "masses", excluded=False, nominal=None),
    "inertia": Kind("inertia", "kg m2", "masses", excluded=False, nominal=None),
    "support_stiffness": Kind("stiffness", "N/m", "springs", excluded=False, nominal=None),
    "angle": Kind("angle", "deg", "elements", -np.inf, excluded=False, nominal=0.0),
    "length": Kind("length", "", "elements"),
    "position": Kind("position", "m", "nodes", -np.inf, excluded=False, nominal=0.0),
}

#: (quantity, terms, relative, more) as the core takes it; more is (pivot or 0, axis or zeros) of what moves
#: nodes, and the nominal value of a group with (whether of the mass, power) for each term.
CoreParameter = tuple[str, list[int], bool, tuple[int, Vector] | tuple[float, list[tuple[bool, int]]] | None]
_MAKERS = "Make them by stiffness_factor, mass_factor and the like."


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
        Zero-based: stiffness or mass terms of the model or sections (or their names), point masses or springs
        to ground; the elements of an angle's or length's group; the nodes of a position. Of a MatrixModel
        names of groups stand in place of sections.
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
    bounds: Bounds
    relative: bool = field(default=False, repr=False)
    pivot: int | None = field(default=None, repr=False)
    axis: Vector = field(default=(0.0, 0.0, 1.0), repr=False)

    def __post_init__(self) -> None:
        choice("quantity", self.quantity, tuple(KINDS))
        if not isinstance(self.terms, tuple) or not self.terms:
            reject("terms", self.terms, "a tuple of at least one zero-based term", _MAKERS)
        for i, term in enumerate(self.terms):
            _term(self.quantity, ("terms", i), term)
        if (self.pivot is None) == (self.quantity in _ABOUT_A_NODE):
            got, wanted = self.pivot, "a node for an angle or a length, and None for anything else"
            reject("pivot", got, wanted, "Make such parameters by antires_rs.angle and antires_rs.length.")
        if self.relative and KINDS[self.quantity].nominal is not None:
            remedy = "Only properties of sections, masses and supports can be relative."
            reject("relative", self.relative, f"False for '{self.quantity}'", remedy)
        _bounds(self.bounds, self.quantity, self.relative)

    def __add__(self, other: Any) -> list[Parameter]:
        """A list of this and another, or those of a list."""
        return [self, *parameter_tuple(other)]

    def __radd__(self, other: Any) -> list[Parameter]:
        return [*parameter_tuple(other), self]

    @property
    def nominal(self) -> float | None:
        """Value at which the model is as it was given: 0 for a reduction, angle or position, 1 for a factor.

        None for a property with a unit, whose nominal value is the model's; see ``UpdatingProblem.nominal``.
        """
        return 1.0 if self.relative else KINDS[self.quantity].nominal

    def common_scale(self, value: float) -> float:
        """Rate of this value when all stiffness and mass grow by one common factor.

        A factor or an amount grows with it, so does what a reduction leaves; lengths and angles do not.
        """
        if self.quantity == "stiffness_reduction":
            return value - 1.0
        return 0.0 if self.quantity in ("thickness", "diameter", *MOVES) else value


@dataclass(frozen=True, eq=False)
class AppliedParameters(Value):
    """Parameters and their values (n,), as one updating leaves them."""

    parameters: tuple[Parameter, ...]
    values: FloatArray


def parameter_tuple(parameters: Any) -> tuple[Parameter, ...]:
    """One parameter or several, as a tuple."""
    wanted = "Parameters, from stiffness_factor, mass_factor, stiffness_reduction and the like"
    if isinstance(parameters, Parameter):
        return (parameters,)
    try:
        chosen = tuple(parameters)
    except TypeError:
        reject("parameters", parameters, wanted, _MAKERS)
    for i, parameter in enumerate(chosen):
        if not isinstance(parameter, Parameter):
            reject(("parameters", i), parameter, wanted, "Join lists with +, without nesting them.")
    return chosen


def _term(quantity: Quantity, name: Name, term: Any) -> int | str:
    if isinstance(term, str) and quantity in (*OF_SECTIONS, *_OF_TERMS):
        return term
    return integer(name, term, low=0)


def _made(
    quantity: Quantity,
    terms: Any,
    bounds: Any,
    together: bool,
    relative: bool = False,
    pivot: int | None = None,
    axis: Vector = (0.0, 0.0, 1.0),
) -> Any:
    """One parameter of a single term, or one each of a sequence, or one of all together."""
    limits, name = _bounds(bounds, quantity, relative), KINDS[quantity].terms
    if shape_of(terms) == ():
        return Parameter(quantity, (_term(quantity, name, terms),), limits, relative, pivot, axis)
    indices = [_term(quantity, (name, i), term) for i, term in enumerate(terms)]
    one = name.rstrip("s")
    if not indices:
        reject(name, "an empty sequence", f"at least one {one}", f"Name the {name} it acts on.")
    twice = sorted({t for t in indices if indices.count(t) > 1}, key=str)
    if twice:
        reject(name, f"{one}(s) {twice} more than once", f"each {one} once", "Remove the repeated ones.")
    groups: Iterable[tuple[int | str, ...]] = [tuple(indices)] if together else [(t,) for t in indices]
    built = [Parameter(quantity, group, limits, relative, pivot, axis) for group in groups]
    return built[0] if together else built


def _bounds(bounds: Any, quantity: Quantity, relative: bool) -> Bounds:
    kind = KINDS["stiffness_factor" if relative else quantity]
    most = 1.0 if quantity == "stiffness_reduction" else np.inf
    left = f"{kind.least:g} {'<' if kind.excluded else '<='} " if np.isfinite(kind.least) else ""
    wanted = f"a pair (lower, upper) with {left}lower <= upper{' <= 1' if most == 1.0 else ''}"
    wanted += f" in {kind.unit}" if kind.unit else ""
    if shape_of(bounds) != (2,):
        reject("bounds", bounds, wanted, "Write them as in (0.9, 1.1).")
    limits: Any = {"low": kind.least, "high": most, "low_open": kind.excluded}
    lower, upper = (finite_scalar(("bounds", i), b, **limits) for i, b in enumerate(bounds))
    if lower > upper:
        reject("bounds", (lower, upper), wanted, "Swap them.")
    return lower, upper


# -- What parameters are called in tables, and values far from those of the model

FAR = 5.0  # a nominal value this factor outside the bounds is taken for a slip
FACTORS = (0.1, 10.0)  # bounds about 1 within these are then taken for factors


def parameter_name(model: Any, parameter: Parameter) -> str:
    """Name for tables, with the unit of the value; the model knows what its parts are called."""
    quantity, terms, about = parameter.quantity, parameter.terms, ""
    what, unit = KINDS[quantity][:2]
    if parameter.relative:
        what, unit = f"{what} factor", ""
    if quantity in _ABOUT_A_NODE:
        about = f" {'about' if quantity == 'angle' else 'from'} node {parameter.pivot}"
    if quantity in OF_SECTIONS:
        labels = [term if isinstance(term, str) else model.section_label(term) for term in terms]
        unit = "" if hasattr(model, "groups") else unit  # a group is in the unit of its code
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


def check_far(parameters: Iterable[Parameter], names: Sequence[str], nominal: FloatArray) -> None:
    """Bounds in another unit than the model's value are a slip that no search can mend; those of factors that
    are not said to be some are refused."""
    for nth, (parameter, name, value) in enumerate(zip(parameters, names, nominal, strict=True)):
        low, high = parameter.bounds
        if value > 0.0 and not low / FAR <= value <= FAR * high:
            span = f"({low:g}, {high:g})"
            if parameter.nominal is None and FACTORS[0] <= low <= 1.0 <= high <= FACTORS[1]:
                argument = part("parameters", nth).attribute("bounds")
                wanted = f"bounds of {name} about the {value:g} that the model has, or factors"
                reject(argument, span, wanted, "Factors need relative=True.")
            far = f"{name}: the model has {value:g}, far outside the bounds {span}. Check their unit."
            warn("far_outside_bounds", far)


#: Largest stiffness loss by default: a lost element would leave the structure in two parts.
LARGEST_REDUCTION = 0.99

Maker = TypeVar("Maker", bound=Callable[..., Any])

_TERMS = "int or sequence of int\n        Zero-based {}."
_NAMED = _TERMS.replace("int or", "int, str or").replace(".", ", or names of a MatrixModel.")
_STIFFNESS_TERMS, _MASS_TERMS = _NAMED.format("stiffness terms"), _NAMED.format("mass terms")
_OR_GROUPS = "; of a MatrixModel its groups by name, in the unit of their code."
_SECTIONS = f"int or str, or a sequence of them\n        Sections by index or name{_OR_GROUPS}"
_TUBES = _SECTIONS.replace("name;", "name, which must be tubes;")
_MASSES = _TERMS.format("positions in the model's ``point_masses``")
_SPRINGS = _TERMS.format("positions in the model's ``ground_springs``")
_FACTORS = "Positive, for example ``(0.9, 1.1)``."
_AMOUNT = "In {}, at least 0; or positive factors."
_OF_GROUP = _TERMS.format("elements of the group; one of them ends at the pivot")
#: What arguments mean that several functions have.
_SHARED = {
    "relative": "bool\n        The value is a factor on the nominal one.",
    "together": "bool\n        One parameter for the whole sequence.",
    "pivot": "int\n        Zero-based node that stays.",
    "axis": "(float, float, float)\n        Axis of the rotation, for frames in space.",
    "direction": "{'x', 'y', 'z'} or (float, float, float)\n        Its length does not matter.",
}


def _documented(terms: str, bounds: str, wrong: str = "not positive") -> Callable[[Maker], Maker]:
    """Adds to the sentences and the example of a function what all functions of parameters share."""

    def add(function: Maker) -> Maker:
        names = list(signature(function).parameters)
        known = dict.fromkeys(("bounds", "bounds_deg", "bounds_m"), f"(float, float)\n        {bounds}")
        known |= _SHARED | {names[0]: terms}
        arguments = "\n    ".join(f"{name} : {known[name]}" for name in names)
        head, _, example = (getdoc(function) or "").partition("\n\n>>> ")
        function.__doc__ = f"""{head.replace(chr(10), chr(10) + "    ")}

    Parameters
    ----------
    {arguments}

    Returns
    -------
    Parameter{" or list of Parameter" if "together" in names else ""}

    Raises
    ------
    InvalidInputError
        Bounds out of order or {wrong}, one of the {names[0]} listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> {example.replace(chr(10), chr(10) + "    ")}
    """
        return function

    return add


@_documented(_STIFFNESS_TERMS, "Within [0, 1].", "outside [0, 1]")
def stiffness_reduction(
    elements: Any, *, bounds: Bounds = (0.0, LARGEST_REDUCTION), together: bool = False
) -> Any:
    """Damage: loss ``beta`` of an element's stiffness, ``K = sum (1 - beta_i) K_i``.

    >>> ar.stiffness_reduction(4)
    Parameter(quantity='stiffness_reduction', terms=(4,), bounds=(0.0, 0.99))
    >>> len(ar.stiffness_reduction(range(7)))
    7
    """
    return _made("stiffness_reduction", elements, bounds, together)


@_documented(_STIFFNESS_TERMS, _FACTORS)
def stiffness_factor(elements: Any, *, bounds: Bounds, together: bool = False) -> Any:
    """Factor on the stiffness of elements; 1 leaves them as they are.

    >>> ar.stiffness_factor([0, 1], bounds=(0.8, 1.2), together=True)
    Parameter(quantity='stiffness_factor', terms=(0, 1), bounds=(0.8, 1.2))
    """
    return _made("stiffness_factor", elements, bounds, together)


@_documented(_MASS_TERMS, _FACTORS)
def mass_factor(terms: Any, *, bounds: Bounds, together: bool = False) -> Any:
    """Factor on mass terms; for a :class:`MassSpringChain`, term i is mass i.

    >>> ar.mass_factor(0, bounds=(0.9, 1.1))
    Parameter(quantity='mass_factor', terms=(0,), bounds=(0.9, 1.1))
    """
    return _made("mass_factor", terms, bounds, together)


# -- Of a :class:`~antires_rs.FrameModel`: sections, masses and supports. Values replace those of the model;
# with ``relative=True`` they are factors on them, and one parameter may act on carriers of different values


@_documented(_SECTIONS, "Positive; in Pa, or factors.")
def youngs_modulus(sections: Any, *, bounds: Bounds, relative: bool = False, together: bool = False) -> Any:
    """Young's modulus of sections, in Pa.

    >>> ar.youngs_modulus("pipe", bounds=(1.9e11, 2.2e11))
    Parameter(quantity='youngs_modulus', terms=('pipe',), bounds=(190000000000.0, 220000000000.0))
    """
    return _made("youngs_modulus", sections, bounds, together, relative)


@_documented(_SECTIONS, "Positive; in kg/m3, or factors.")
def density(sections: Any, *, bounds: Bounds, relative: bool = False, together: bool = False) -> Any:
    """Density of sections, in kg/m3.

    >>> ar.density(["pipe", "flange"], bounds=(0.95, 1.05), relative=True, together=True).terms
    ('pipe', 'flange')
    """
    return _made("density", sections, bounds, together, relative)


@_documented(_TUBES, "Positive; in m, or factors. At most half the outer diameter.")
def thickness(sections: Any, *, bounds: Bounds, relative: bool = False, together: bool = False) -> Any:
    """Wall thickness of tubes, in m; area and second moments follow.

    Or of shells of a code, or what else a number of its input means (a group of quantity ``"value"``): all
    terms of the group move by their powers of the value.

    >>> ar.thickness(0, bounds=(0.0012, 0.002))
    Parameter(quantity='thickness', terms=(0,), bounds=(0.0012, 0.002))
    """
    return _made("thickness", sections, bounds, together, relative)


@_documented(_TUBES, "Positive; in m, or factors.")
def diameter(sections: Any, *, bounds: Bounds, relative: bool = False, together: bool = False) -> Any:
    """Outer diameter of tubes, in m; the wall keeps its thickness.

    >>> len(ar.diameter([0, 1], bounds=(0.036, 0.040)))
    2
    """
    return _made("diameter", sections, bounds, together, relative)


@_documented(_MASSES, _AMOUNT.format("kg"), "negative")
def point_mass(masses: Any, *, bounds: Bounds, relative: bool = False, together: bool = False) -> Any:
    """Lumped mass at a node, in kg; its inertia stays.

    >>> ar.point_mass(2, bounds=(0.8, 1.2), relative=True).relative
    True
    """
    return _made("point_mass", masses, bounds, together, relative)


@_documented(_MASSES, _AMOUNT.format("kg m2"), "negative")
def inertia(masses: Any, *, bounds: Bounds, relative: bool = False, together: bool = False) -> Any:
    """Rotational inertia of a lumped mass, in kg m2; in space about all three axes.

    >>> ar.inertia(0, bounds=(0.001, 0.004)).bounds
    (0.001, 0.004)
    """
    return _made("inertia", masses, bounds, together, relative)


@_documented(_SPRINGS, _AMOUNT.format("N/m"), "negative")
def support_stiffness(springs: Any, *, bounds: Bounds, relative: bool = False, together: bool = False) -> Any:
    """Stiffness of springs to ground, in N/m (N m/rad for rotations).

    >>> ar.support_stiffness([0, 1], bounds=(500.0, 4000.0), together=True).terms
    (0, 1)
    """
    return _made("support_stiffness", springs, bounds, together, relative)


# -- Angles, lengths and positions move nodes, and the elements are formed again: a free structure stays free.
# They act in their order, each on the nodes where these then are; supports and sensors keep their directions

_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}  # names of directions


def _group(
    quantity: Quantity, elements: Any, bounds: Any, pivot: Any, axis: Vector = _AXES["z"]
) -> Parameter:
    """One parameter of all elements, which turn or grow about a node."""
    group = [elements] if shape_of(elements) == () else elements
    stays = integer("pivot", pivot, low=0)
    made: Parameter = _made(quantity, group, bounds, together=True, pivot=stays, axis=axis)
    return made


@_documented(_OF_GROUP, "Degrees, positive from x to y; 0 is the model as it was given.", "a zero axis")
def angle(elements: Any, pivot: int, *, bounds_deg: Bounds, axis: Any = (0.0, 0.0, 1.0)) -> Parameter:
    """Angle in degrees by which a group of elements, and all downstream of it, turns about a node.

    The nodes of the group and all that are reached from them without passing the pivot are rotated, and the
    elements formed again: a free structure stays free at any angle. Supports and sensors keep their
    directions. Several angles act in their order, each about its pivot where it then is. That the group lies
    in a loop, or away from the pivot, is found when the parameter meets its model.

    >>> ar.angle([4, 5], pivot=5, bounds_deg=(-5.0, 5.0)).bounds
    (-5.0, 5.0)
    """
    turned = _direction("axis", axis, "Leave it out for (0, 0, 1).")
    return _group("angle", elements, bounds_deg, pivot, axis=turned)


@_documented(_OF_GROUP, "Positive factors; 1 is the model as it was given.")
def length(elements: Any, pivot: int, *, bounds: Bounds) -> Parameter:
    """Factor on the length of a group of elements, which keep their directions.

    Seen from the pivot, the far end of each element of the group moves away along the element; all that is
    reached beyond it moves along as it is.

    >>> bar = ar.Rectangle(0.03, 0.01, 7.0e10, 2700.0)
    >>> beam = ar.FrameModel([[0, 0], [0.5, 0], [1, 0]], [(0, 1), (1, 2)], bar)
    >>> longer = beam.with_parameters(ar.length([0, 1], pivot=0, bounds=(0.9, 1.1)), [1.04])
    >>> longer.nodes_m[:, 0].round(3).tolist()
    [0.0, 0.52, 1.04]
    """
    return _group("length", elements, bounds, pivot)


@_documented(_TERMS.format("nodes"), "In m; 0 is the model as it was given.", "a direction that is zero")
def position(nodes: Any, direction: Any, *, bounds_m: Bounds, together: bool = False) -> Any:
    """Shift of nodes along a direction, in m; the elements that end there change length and direction.

    >>> bar = ar.Rectangle(0.03, 0.01, 7.0e10, 2700.0)
    >>> beam = ar.FrameModel([[0, 0], [0.5, 0], [1, 0]], [(0, 1), (1, 2)], bar)
    >>> moved = beam.with_parameters(ar.position(1, "x", bounds_m=(-0.1, 0.1)), [0.02])
    >>> moved.nodes_m[:, 0].round(3).tolist()
    [0.0, 0.52, 1.0]
    """
    along = _AXES.get(direction) if isinstance(direction, str) else direction
    if along is None:
        reject("direction", repr(direction), "'x', 'y', 'z' or a vector", "Take one of the axes.")
    axis = _direction("direction", along, "Take one of 'x', 'y' and 'z'.", unit=True)
    return _made("position", nodes, bounds_m, together, axis=axis)


def _direction(name: str, value: Any, remedy: str, unit: bool = False) -> Vector:
    wanted = "a direction (x, y, z)"
    direction = real_array(name, value, ndim=1, wanted=wanted)
    if direction.shape != (3,) or not np.any(direction):
        reject(name, value, f"{wanted} that is not zero", remedy)
    x, y, z = (direction / np.linalg.norm(direction) if unit else direction).tolist()
    return x, y, z
