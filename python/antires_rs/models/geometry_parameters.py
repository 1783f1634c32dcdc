"""Updating parameters that move nodes of a :class:`~antires_rs.FrameModel`: angles, lengths and positions.

The elements are formed again from the moved nodes, so that a free structure stays free. Parameters act in
their order, each on the nodes where they then are; supports and sensors keep their directions.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.validation import integer, real_array, reject, shape_of
from .parameter import Parameter, build

__all__ = ["angle", "length", "position"]

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
