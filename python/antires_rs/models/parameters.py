"""Updating parameters of any model: they act on the terms of its stiffness and mass.

Each function returns one :class:`Parameter` for a single element, or a list with one parameter for
each element of a sequence; add the lists to mix kinds. With ``together=True`` a sequence forms one
parameter that acts on all its elements. Several parameters on one element multiply. Those of frames are in
:mod:`antires_rs.models.parameters`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from inspect import getdoc, signature
from typing import Any, Literal, Protocol, TypeVar, cast

import numpy as np

from ..exceptions import part, reject
from ..support.checks import FloatArray, choice, finite_scalar, integer, real_array, shape_of
from ..support.messages import warn

# -- One updating parameter: what it may act on, within which bounds, and what the core takes of it


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


#: Largest stiffness loss by default: a lost element would leave the structure in two parts.
LARGEST_REDUCTION = 0.99

Maker = TypeVar("Maker", bound=Callable[..., Any])


def _documented(terms: str, bounds: str, one: str, wrong: str = "not positive") -> Callable[[Maker], Maker]:
    """Adds to the first sentence and the example of a function what all functions of parameters share."""

    def add(function: Maker) -> Maker:
        first, *rest = signature(function).parameters
        relative = "    relative : bool\n        The value is a factor on the nominal one.\n"
        head, _, example = (getdoc(function) or "").partition("\n\n")
        function.__doc__ = f"""{head}

    Parameters
    ----------
    {first} : {terms}
    bounds : (float, float)
        {bounds}
{relative if "relative" in rest else ""}    together : bool
        One parameter for the whole sequence.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or {wrong}, a {one} listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    {example.replace(chr(10), chr(10) + "    ")}
    """
        return function

    return add


_TERMS = "int or sequence of int\n        Zero-based {}."
_STIFFNESS_TERMS, _MASS_TERMS = _TERMS.format("stiffness terms"), _TERMS.format("mass terms")
_SECTIONS = "int or str, or a sequence of them\n        Sections by index or name."
_TUBES = "int or str, or a sequence of them\n        Sections by index or name, which must be tubes."
_MASSES = _TERMS.format("positions in the model's ``point_masses``")
_FACTORS = "Positive, for example ``(0.9, 1.1)``."


@_documented(_STIFFNESS_TERMS, "Within [0, 1].", "element", "outside [0, 1]")
def stiffness_reduction(
    elements: Any, *, bounds: tuple[float, float] = (0.0, LARGEST_REDUCTION), together: bool = False
) -> Any:
    """Damage: loss ``beta`` of an element's stiffness, ``K = sum (1 - beta_i) K_i``.

    >>> ar.stiffness_reduction(4)
    Parameter(quantity='stiffness_reduction', terms=(4,), bounds=(0.0, 0.99))
    >>> len(ar.stiffness_reduction(range(7)))
    7
    """
    return build("stiffness_reduction", elements, bounds, together)


@_documented(_STIFFNESS_TERMS, _FACTORS, "element")
def stiffness_factor(elements: Any, *, bounds: tuple[float, float], together: bool = False) -> Any:
    """Factor on the stiffness of elements; 1 leaves them as they are.

    >>> ar.stiffness_factor([0, 1], bounds=(0.8, 1.2), together=True)
    Parameter(quantity='stiffness_factor', terms=(0, 1), bounds=(0.8, 1.2))
    """
    return build("stiffness_factor", elements, bounds, together)


@_documented(_MASS_TERMS, _FACTORS, "term")
def mass_factor(terms: Any, *, bounds: tuple[float, float], together: bool = False) -> Any:
    """Factor on mass terms; for a :class:`MassSpringChain`, term i is mass i.

    >>> ar.mass_factor(0, bounds=(0.9, 1.1))
    Parameter(quantity='mass_factor', terms=(0,), bounds=(0.9, 1.1))
    """
    return build("mass_factor", terms, bounds, together)


# -- Updating parameters of a :class:`~antires_rs.FrameModel`: sections, masses and supports
#
# Values have units, and replace those of the model; with ``relative=True`` they are factors on them, which
# also lets one parameter act on carriers of different values. Sections are named, or counted from zero.


@_documented(_SECTIONS, "Positive; in Pa, or factors.", "section")
def youngs_modulus(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Young's modulus of sections, in Pa.

    >>> ar.youngs_modulus("pipe", bounds=(1.9e11, 2.2e11))
    Parameter(quantity='youngs_modulus', terms=('pipe',), bounds=(190000000000.0, 220000000000.0))
    """
    return build("youngs_modulus", sections, bounds, together, name="sections", relative=relative)


@_documented(_SECTIONS, "Positive; in kg/m3, or factors.", "section")
def density(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Density of sections, in kg/m3.

    >>> ar.density(["pipe", "flange"], bounds=(0.95, 1.05), relative=True, together=True).terms
    ('pipe', 'flange')
    """
    return build("density", sections, bounds, together, name="sections", relative=relative)


@_documented(_TUBES, "Positive; in m, or factors. At most half the outer diameter.", "section")
def thickness(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Wall thickness of tubes, in m; area and second moments follow.

    >>> ar.thickness(0, bounds=(0.0012, 0.002))
    Parameter(quantity='thickness', terms=(0,), bounds=(0.0012, 0.002))
    """
    return build("thickness", sections, bounds, together, name="sections", relative=relative)


@_documented(_TUBES, "Positive; in m, or factors.", "section")
def diameter(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Outer diameter of tubes, in m; the wall keeps its thickness.

    >>> len(ar.diameter([0, 1], bounds=(0.036, 0.040)))
    2
    """
    return build("diameter", sections, bounds, together, name="sections", relative=relative)


@_documented(_MASSES, "In kg, at least 0; or positive factors.", "mass", "negative")
def point_mass(
    masses: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Lumped mass at a node, in kg; its inertia stays.

    >>> ar.point_mass(2, bounds=(0.8, 1.2), relative=True).relative
    True
    """
    return build("point_mass", masses, bounds, together, name="masses", relative=relative)


@_documented(_MASSES, "In kg m2, at least 0; or positive factors.", "mass", "negative")
def inertia(
    masses: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Rotational inertia of a lumped mass, in kg m2; in space about all three axes.

    >>> ar.inertia(0, bounds=(0.001, 0.004)).bounds
    (0.001, 0.004)
    """
    return build("inertia", masses, bounds, together, name="masses", relative=relative)


@_documented(
    _TERMS.format("positions in the model's ``ground_springs``"),
    "In N/m, at least 0; or positive factors.",
    "spring",
    "negative",
)
def support_stiffness(
    springs: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Stiffness of springs to ground, in N/m (N m/rad for rotations).

    >>> ar.support_stiffness([0, 1], bounds=(500.0, 4000.0), together=True).terms
    (0, 1)
    """
    return build("support_stiffness", springs, bounds, together, name="springs", relative=relative)


# -- Updating parameters that move nodes of a :class:`~antires_rs.FrameModel`: angles, lengths and positions
#
# The elements are formed again from the moved nodes, so that a free structure stays free. Parameters act in
# their order, each on the nodes where they then are; supports and sensors keep their directions.


#: Names of directions.
_AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def angle(
    elements: Any, pivot: int, *, bounds_deg: tuple[float, float], axis: Any = (0.0, 0.0, 1.0)
) -> Parameter:
    """Angle in degrees by which a group of elements, and all downstream of it, turns about a node.

    The nodes of the group and all that are reached from them without passing the pivot are rotated, and the
    elements formed again from the new coordinates: a free structure stays free at any angle. Supports and
    sensors keep their directions. Several angles act in their order, each about its pivot where it then is.

    Parameters
    ----------
    elements : int or sequence of int
        Zero-based elements of the group; one of them ends at the pivot.
    pivot : int
        Zero-based node that stays.
    bounds_deg : (float, float)
        Degrees, positive from x to y; 0 is the model as it was given.
    axis : (float, float, float)
        Axis of the rotation, for frames in space.

    Returns
    -------
    Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order, an element listed twice, a zero axis. (That the group lies in a loop, or away
        from the pivot, is found when the parameter meets its model.)

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.angle([4, 5], pivot=5, bounds_deg=(-5.0, 5.0)).bounds
    (-5.0, 5.0)
    """
    made: Parameter = build(
        "angle",
        [elements] if shape_of(elements) == () else elements,
        bounds_deg,
        together=True,
        pivot=integer("pivot", pivot, low=0),
        axis=_direction("axis", axis, "Leave it out for (0, 0, 1)."),
    )
    return made


def length(elements: Any, pivot: int, *, bounds: tuple[float, float]) -> Parameter:
    """Factor on the length of a group of elements, which keep their directions.

    Seen from the pivot, the far end of each element of the group moves away along the element; all that is
    reached beyond it moves along as it is.

    Parameters
    ----------
    elements : int or sequence of int
        Zero-based elements of the group; one of them ends at the pivot.
    pivot : int
        Zero-based node that stays.
    bounds : (float, float)
        Positive factors; 1 is the model as it was given.

    Returns
    -------
    Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, an element listed twice. (That the group lies in a loop, or away
        from the pivot, is found when the parameter meets its model.)

    Examples
    --------
    >>> import antires_rs as ar
    >>> bar = ar.Rectangle(0.03, 0.01, 7.0e10, 2700.0)
    >>> beam = ar.FrameModel([[0, 0], [0.5, 0], [1, 0]], [(0, 1), (1, 2)], bar)
    >>> longer = beam.with_parameters(ar.length([0, 1], pivot=0, bounds=(0.9, 1.1)), [1.04])
    >>> longer.nodes_m[:, 0].round(3).tolist()
    [0.0, 0.52, 1.04]
    """
    made: Parameter = build(
        "length",
        [elements] if shape_of(elements) == () else elements,
        bounds,
        together=True,
        pivot=integer("pivot", pivot, low=0),
    )
    return made


def position(nodes: Any, direction: Any, *, bounds_m: tuple[float, float], together: bool = False) -> Any:
    """Shift of nodes along a direction, in m; the elements that end there change length and direction.

    Parameters
    ----------
    nodes : int or sequence of int
        Zero-based nodes.
    direction : {"x", "y", "z"} or (float, float, float)
        Its length does not matter.
    bounds_m : (float, float)
        In m; 0 is the model as it was given.
    together : bool
        One parameter for the whole sequence.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order, a node listed twice, a direction that is none. (That a node can come onto its
        neighbour is found when the parameter meets its model.)

    Examples
    --------
    >>> import antires_rs as ar
    >>> bar = ar.Rectangle(0.03, 0.01, 7.0e10, 2700.0)
    >>> beam = ar.FrameModel([[0, 0], [0.5, 0], [1, 0]], [(0, 1), (1, 2)], bar)
    >>> moved = beam.with_parameters(ar.position(1, "x", bounds_m=(-0.1, 0.1)), [0.02])
    >>> moved.nodes_m[:, 0].round(3).tolist()
    [0.0, 0.52, 1.0]
    """
    along = _AXES.get(direction) if isinstance(direction, str) else direction
    if along is None:
        reject("direction", repr(direction), "'x', 'y', 'z' or a vector", "Take one of the axes.")
    return build(
        "position",
        nodes,
        bounds_m,
        together,
        name="nodes",
        axis=_direction("direction", along, "Take one of 'x', 'y' and 'z'.", unit=True),
    )


def _direction(name: str, value: Any, remedy: str, unit: bool = False) -> tuple[float, float, float]:
    wanted = "a direction (x, y, z)"
    direction = real_array(name, value, ndim=1, wanted=wanted)
    if direction.shape != (3,) or not np.any(direction):
        reject(name, value, f"{wanted} that is not zero", remedy)
    x, y, z = (direction / np.linalg.norm(direction) if unit else direction).tolist()
    return x, y, z
