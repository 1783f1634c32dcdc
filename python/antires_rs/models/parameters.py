"""Updating parameters of any model: they act on the terms of its stiffness and mass.

Each function returns one :class:`Parameter` for a single element, or a list with one parameter for
each element of a sequence; add the lists to mix kinds. With ``together=True`` a sequence forms one
parameter that acts on all its elements. Several parameters on one element multiply. Those of frames are in
:mod:`antires_rs.models.parameters`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..exceptions import reject
from ..support.checks import integer, real_array, shape_of
from .parameter import Parameter, build

#: Largest stiffness loss by default: a lost element would leave the structure in two parts.
LARGEST_REDUCTION = 0.99


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


# -- Updating parameters of a :class:`~antires_rs.FrameModel`: sections, masses and supports
#
# Values have units, and replace those of the model; with ``relative=True`` they are factors on them, which
# also lets one parameter act on carriers of different values. Sections are named, or counted from zero.


def youngs_modulus(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Young's modulus of sections, in Pa.

    Parameters
    ----------
    sections : int or str, or a sequence of them
        Sections by index or name.
    bounds : (float, float)
        Positive; in Pa, or factors.
    relative : bool
        The value is a factor on the nominal one.
    together : bool
        One parameter for the whole sequence.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, a section listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.youngs_modulus("pipe", bounds=(1.9e11, 2.2e11))
    Parameter(quantity='youngs_modulus', terms=('pipe',), bounds=(190000000000.0, 220000000000.0))
    """
    return build("youngs_modulus", sections, bounds, together, name="sections", relative=relative)


def density(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Density of sections, in kg/m3.

    Parameters
    ----------
    sections, relative, together
        As in :func:`youngs_modulus`.
    bounds : (float, float)
        Positive; in kg/m3, or factors.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, a section listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.density(["pipe", "flange"], bounds=(0.95, 1.05), relative=True, together=True).terms
    ('pipe', 'flange')
    """
    return build("density", sections, bounds, together, name="sections", relative=relative)


def thickness(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Wall thickness of tubes, in m; area and second moments follow.

    Parameters
    ----------
    sections, relative, together
        As in :func:`youngs_modulus`; the sections must be tubes.
    bounds : (float, float)
        Positive; in m, or factors. At most half the outer diameter.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, a section listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.thickness(0, bounds=(0.0012, 0.002))
    Parameter(quantity='thickness', terms=(0,), bounds=(0.0012, 0.002))
    """
    return build("thickness", sections, bounds, together, name="sections", relative=relative)


def diameter(
    sections: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Outer diameter of tubes, in m; the wall keeps its thickness.

    Parameters
    ----------
    sections, relative, together
        As in :func:`youngs_modulus`; the sections must be tubes.
    bounds : (float, float)
        Positive; in m, or factors.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or not positive, a section listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> len(ar.diameter([0, 1], bounds=(0.036, 0.040)))
    2
    """
    return build("diameter", sections, bounds, together, name="sections", relative=relative)


def point_mass(
    masses: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Lumped mass at a node, in kg; its inertia stays.

    Parameters
    ----------
    masses : int or sequence of int
        Zero-based positions in the model's ``point_masses``.
    bounds : (float, float)
        In kg, at least 0; or positive factors.
    relative, together : bool
        As in :func:`youngs_modulus`.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or negative, a mass listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.point_mass(2, bounds=(0.8, 1.2), relative=True).relative
    True
    """
    return build("point_mass", masses, bounds, together, name="masses", relative=relative)


def inertia(
    masses: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Rotational inertia of a lumped mass, in kg m2; in space about all three axes.

    Parameters
    ----------
    masses : int or sequence of int
        Zero-based positions in the model's ``point_masses``.
    bounds : (float, float)
        In kg m2, at least 0; or positive factors.
    relative, together : bool
        As in :func:`youngs_modulus`.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or negative, a mass listed twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.inertia(0, bounds=(0.001, 0.004)).bounds
    (0.001, 0.004)
    """
    return build("inertia", masses, bounds, together, name="masses", relative=relative)


def support_stiffness(
    springs: Any, *, bounds: tuple[float, float], relative: bool = False, together: bool = False
) -> Any:
    """Stiffness of springs to ground, in N/m (N m/rad for rotations).

    Parameters
    ----------
    springs : int or sequence of int
        Zero-based positions in the model's ``ground_springs``.
    bounds : (float, float)
        In N/m, at least 0; or positive factors.
    relative, together : bool
        As in :func:`youngs_modulus`.

    Returns
    -------
    Parameter or list of Parameter

    Raises
    ------
    InvalidInputError
        Bounds out of order or negative, a spring listed twice.

    Examples
    --------
    >>> import antires_rs as ar
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
