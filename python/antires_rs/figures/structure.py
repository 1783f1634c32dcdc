"""Chains and frames: their elements numbered, sensors, shaker, and colours by any value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from ..io.points import MatchedPoints
from ..models.frame_parts import PARTS
from ..support.checks import FloatArray, integer, members, real_array
from .canvas import draw, fit_across, new_axes, width_pt
from .marks import Arrows, Axis, Line, Mark, Panel, Paths, Points, Words, xy

if TYPE_CHECKING:
    from ..models.chain import MassSpringChain
    from ..models.frame import FrameModel

__all__ = ["plot_chain", "plot_frame"]


def _value_by_element(values: Any, count: int) -> FloatArray | None:
    """A value for each of ``count`` elements, NaN where there is none; None if there are no values at all."""
    if values is None:
        return None
    if isinstance(values, Mapping):
        given = np.full(count, np.nan)
        for element, value in values.items():
            given[integer("values", element, low=0, high=count - 1)] = value
        return given
    wanted = f"a mapping from element to value, or an array ({count},)"
    array = real_array("values", values, ndim=1, wanted=wanted)
    if array.size != count:
        reject("values", f"{array.size} values", wanted, "Give a value for each element, in their order.")
    return array


def forces_of(sensors: Sequence[Any] | MatchedPoints, excitation: Any) -> list[Any]:
    """Dofs of forces, of which matched points may be some; those without a dof are left out."""
    if excitation is None:
        return []
    forces = [*excitation] if isinstance(excitation, list | tuple | np.ndarray) else [excitation]
    if not isinstance(sensors, MatchedPoints):
        return forces
    known = {name: None for name in sensors.points} | sensors.dofs
    dofs = [known.get(force, force) if isinstance(force, int | str) else force for force in forces]
    return [dof for dof in dofs if dof is not None]


def without_dof(sensors: Any) -> list[str]:
    """A line for each point that has no dof, with the reason."""
    unmatched = sensors.unmatched if isinstance(sensors, MatchedPoints) else {}
    return [f"\u00d7 {name}: {reason}" for name, reason in unmatched.items()]


def _hovered(names: list[str], values: FloatArray | None, **columns: Any) -> dict[str, Any]:
    says = {"": "@name"} | {name.capitalize(): f"@{name}" for name in columns}
    more = {"name": names} | columns
    if values is not None:
        says |= {"Stiffness loss": "@loss"}
        more["loss"] = ["no candidate" if np.isnan(v) else f"{v:.1f} %" for v in values]
    return {"says": says, "more": more}


# -- Chains of masses and springs, coloured by any value

ROUNDING = 1e-9  # share of a free end's stiffness that rounding may leave
MOST_COILS, HEIGHT = 20, 0.16  # up to this many masses the springs are drawn as coils, so high


def plot_chain(
    model: MassSpringChain,
    values: Any = None,
    ax: Any = None,
    *,
    sensors: Sequence[int] = (),
    excitation: int | None = None,
    label: str = "Value by spring",
) -> Any:
    """Draw a chain with its springs numbered from 0, as tables have them, and coloured by a value of each.

    Parameters
    ----------
    values : array_like, (n_masses - 1,), or mapping of int to float, optional
        Value of each spring between masses, for example ``DamageResult.severity``: light grey at 0, dark blue
        at the largest; springs without one are thin. Those to ground have theirs in a mapping.
    sensors : sequence of int, optional
        Dofs of the accelerometers; arrows above their masses.
    excitation : int, optional
        Dof of the force; a heavier arrow below its mass.
    label : str
        Name of the values, with their unit.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.figures.plot_chain(ar.cases.chain8().model, {4: 55.0}, excitation=0).get_xlabel()
    'Mass (number of each spring above it)'
    """
    n = model.n_dof
    ax = new_axes(ax, (max(6.0, 0.5 * n + 1.5), 2.8))
    every = next(step for step in (1, 2, 5, 10, n) if fit_across(ax, [str(n)] * (n // step), 8.0))
    return draw(chain(model, values, sensors, excitation, label, width_pt(ax), every), ax)


def chain(
    model: MassSpringChain,
    values: Any,
    sensors: Sequence[Any],
    excitation: Any,
    label: str,
    wide_pt: float,
    every: int,
) -> Panel:
    """A chain in a figure ``wide_pt`` points wide, each so-manyth mass numbered."""
    n, stiffness = model.n_dof, model.stiffness()
    # The springs that there are, by element: those between masses, then those to ground.
    between = {i: (i, i + 1) for i in range(n - 1)}
    for element, mass, wall in ((n - 1, 0, -1), (n, n - 1, n)):
        if stiffness[mass].sum() > ROUNDING * stiffness[mass, mass]:
            between[element] = (mass, wall)
    high = HEIGHT if n <= MOST_COILS else 0.0
    springs = {e: _coil(np.array([a, 0.0]), np.array([b, 0.0]), high) for e, (a, b) in between.items()}
    dofs = [model._dof("sensors", dof) for dof in sensors]
    force = [] if excitation is None else members(model._end("excitation", excitation))
    given = _value_by_element(values, n + 1 if values is None or isinstance(values, Mapping) else n - 1)
    paths, names = list(springs.values()), [model.element_label(element) for element in springs]
    width = 1.6
    if given is not None:
        by_spring = np.full(n + 1, np.nan)
        by_spring[: given.size] = given
        given = by_spring[list(springs)]
        width = 2.6 if n <= MOST_COILS else 5.0
    marks: list[Mark] = [Paths(paths, "blue", given, label, width=width, **_hovered(names, given))]
    walls = [springs[element][-1, 0] for element in springs.keys() & {n - 1, n}]
    marks += [Line([at, at], [-0.4, 0.4], width=2.5) for at in walls]
    size = float(np.clip(0.4 * wide_pt / (n + 1), 4.0, 22.0))
    more: dict[str, Any] = {"name": [model.dof_label(i) for i in range(n)]}
    more["mass"], says = np.asarray(model.mass()).diagonal(), {"": "@name", "Mass": "@mass{0.000000} kg"}
    marks.append(Points(np.arange(n), np.zeros(n), "s", size, face="white", says=says, more=more))
    long = max(0.18, 6.0 * (n + 1) / wide_pt)
    for where, y, half, width, colour, name in (
        (dofs, 0.36, long, 1.4, "vermillion", "accelerometer"),
        (force, -0.36, 1.4 * long, 2.0, "black", "force"),
    ):
        if where:
            tails, heads = (np.array([(i + side * half, y) for i in where]) for side in (-1.0, 1.0))
            says, more = {name.capitalize(): "@at"}, {"at": [model.dof_label(i) for i in where]}
            marks.append(Arrows(tails, heads, colour, width, label=name, says=says, more=more))
    shown = list(springs)[::every]
    numbers = [str(element) if element < n - 1 else "ground" for element in shown]
    middles = [springs[element][:, 0].mean() for element in shown]
    marks.append(Words(middles, np.full(len(shown), HEIGHT), numbers, away=4.0))
    ends = np.concatenate([[0.0, n - 1.0], *(path[:, 0] for path in paths)])
    few = range(0, n, every)
    across = (ends.min() - 0.6, ends.max() + 0.6)
    x_axis = Axis("Mass (number of each spring above it)", across, names=list(map(str, few)), at=few)
    return Panel("model", x_axis, Axis("", (-0.8, 0.8), at=[]), marks)


def _coil(a: FloatArray, b: FloatArray, amplitude: float) -> FloatArray:
    """A spring as it is drawn from a to b, (n, 2): straight ends and a zigzag."""
    share = np.array([0.0, 0.25, *np.linspace(0.29, 0.71, 8), 0.75, 1.0])
    off = amplitude * np.array([0.0, 0.0, *np.tile([1.0, -1.0], 4), 0.0, 0.0])
    return np.asarray(a + share[:, None] * (b - a) + off[:, None] * np.array([a[1] - b[1], b[0] - a[0]]))


# -- Frames, coloured by section or by any value

#: Isometric view of frames in space: x to the lower right, y to the upper right, z up.
ISOMETRIC = np.array([[np.sqrt(0.5), np.sqrt(0.5), 0.0], [-np.sqrt(1 / 6), np.sqrt(1 / 6), np.sqrt(2 / 3)]])
MOST_NUMBERS, MOST_NODES = 120, 60  # up to this many elements are numbered unless told otherwise
ARROW, MARGIN = 26.0, 0.08  # length in points; room around the frame as a share of its extent
#: Looks of sections; vermillion and black are those of the arrows. Dashes are close: a section may be short.
SHADES = ("blue", "orange", "sky", "purple", "green")
DASHES: tuple[Any, ...] = ("-", (4, 1), (2, 1), (4, 1, 1, 1), (1, 1), (6, 1, 1, 1, 1, 1))
NODES = "#7A3E9D"  # ink of the numbers of nodes: paler than that of elements in grey too
ROTATIONS = ("theta", "rx", "ry", "rz")


def plot_frame(
    model: FrameModel,
    values: Any = None,
    ax: Any = None,
    *,
    sensors: Sequence[int | str] | MatchedPoints = (),
    excitation: int | str | None = None,
    numbers: bool | None = None,
    label: str = "Value by element",
) -> Any:
    """Draw a frame with its elements numbered, coloured by section or by a value of each element.

    Equal scales in metres; frames in space are seen isometrically.

    Parameters
    ----------
    values : array_like, (n_elements,), or mapping of int to float, optional
        As in :func:`plot_chain`, of each element. By default the colours tell the sections apart.
    sensors, excitation
        As in :func:`plot_mesh`; arrows along their direction.
    label : str
        Name of the values, with their unit.
    numbers : bool, optional
        Whether to number elements and nodes (slanted); by default up to 120 elements and 60 nodes.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.cases.exhaust().model.plot({1: 0.4}).get_xlabel()
    'x (m)'
    """
    ax = new_axes(ax, (9.0, 4.6))
    share, size = ax.get_position(), ax.figure.get_size_inches()
    room = 72.0 * np.array([share.width * size[0], share.height * size[1]])
    shown, told = frame(model, values, sensors, excitation, label, room, numbers), without_dof(sensors)
    shown = replace(shown, x=replace(shown.x, label="\n".join([shown.x.label, *told])))
    draw(shown, ax, drop_pt=44.0 + 14.0 * len(told))
    ax.margins(MARGIN)
    return ax


def seen_points(model: FrameModel) -> FloatArray:
    """The nodes as they are seen, (n, 2)."""
    space = model.nodes_m.shape[1] == 3
    return np.asarray(model.nodes_m @ ISOMETRIC.T if space else model.nodes_m, dtype=np.float64)


def frame(
    model: FrameModel,
    values: Any,
    sensors: Sequence[Any] | MatchedPoints,
    excitation: Any,
    label: str,
    room_pt: FloatArray,
    numbers: bool | None = None,
) -> Panel:
    """A frame in axes as wide and high as ``room_pt``."""
    given = _value_by_element(values, len(model.elements))
    space, points = model.nodes_m.shape[1] == 3, seen_points(model)
    # Points that one unit of the data will take, with equal scales.
    scale = float((room_pt / np.maximum(np.ptp(points, axis=0) * (1.0 + 2.0 * MARGIN), 1e-300)).min())
    ends = points[model.elements]
    marks = [*_elements(model, ends, given, label), *_carried(model, points)]
    where = [", ".join(f"{x:g}" for x in node) + " m" for node in model.nodes_m]
    says = {"Node": "@node", "At": "@where"}
    more = {"node": list(map(str, range(len(points)))), "where": where}
    marks.append(Points(*xy(points), size=3.0, face="white", only="page", says=says, more=more))
    force, names = members(model._end("excitation", forces_of(sensors, excitation))), model._frame.dof_names()
    if isinstance(sensors, MatchedPoints):
        told = [name if name not in sensors.unmatched else f"\u00d7 {name}" for name in sensors.points]
        at = np.array([place for place, _ in sensors.points.values()])
        marks.append(Words(*xy(at @ ISOMETRIC.T if space else at[:, :2]), told, "right", 6.0, halo=True))
        sensors = list(sensors.weights)
    dofs = [model._dof("sensors", dof) for dof in sensors]
    for found, colour, length, name in (
        (dofs, "vermillion", 0.7, "accelerometer"),
        (force, "black", 1.3, "force"),
    ):
        turning = [points[node] for node, way in map(names.__getitem__, found) if way in ROTATIONS]
        along = [(node, way) for node, way in map(names.__getitem__, found) if way not in ROTATIONS]
        if turning:
            look: dict[str, Any] = {"size": 14.0 * length, "colour": colour, "label": None if along else name}
            marks.append(Points(*xy(turning), r"$\circlearrowleft$", **look))
        if along:
            heads = points[[node for node, _ in along]]
            tails = heads - ARROW * length / scale * np.array([_seen(way, space) for _, way in along])
            says, more = {name.capitalize(): "@dof"}, {"dof": [f"node {node} {way}" for node, way in along]}
            marks.append(Arrows(tails, heads, colour, 1.6 * length, label=name, says=says, more=more))
    if numbers or (numbers is None and len(ends) <= MOST_NUMBERS):
        marks += _numbers(model.elements, scale * points, scale, numbers or len(points) <= MOST_NODES)
    x, y = ("isometric view (m)", "") if space else ("x (m)", "y (m)")
    sections = map(model.section_label, range(len(model.sections)))
    first = (*sections, "fixed", "partly fixed", "point mass", "spring to ground", "node spring")
    return Panel("model", Axis(x), Axis(y), marks, equal=True, first=first)


def _elements(model: FrameModel, ends: FloatArray, values: FloatArray | None, label: str) -> list[Mark]:
    """In the colours of their values, or by section."""
    names = [model.element_label(i) for i in range(len(ends))]
    joined = [" to ".join(map(str, pair)) for pair in model.elements]
    section = [str(name) for name in model.element_sections]
    if values is not None:
        hovered = _hovered(names, values, nodes=joined, section=section)
        return [Paths(list(ends), values=values, scale=label, width=5.0, **hovered)]
    of = np.array([model.section_index(name) for name in model.element_sections])
    marks: list[Mark] = []
    for i in range(len(model.sections)):
        own = np.flatnonzero(of == i).tolist()
        columns = ([column[e] for e in own] for column in (names, joined, section))
        hovered = _hovered(next(columns), None, nodes=next(columns), section=next(columns))
        called = model.section_label(i) if len(model.sections) > 1 else None
        look = {"colour": SHADES[i % len(SHADES)], "dash": DASHES[i % len(DASHES)]}
        marks.append(Paths([ends[e] for e in own], label=called, **look, **hovered))
    return marks


def _carried(model: FrameModel, points: FloatArray) -> list[Mark]:
    """Fixed nodes and parts, those between nodes as coils; smaller markers over larger ones."""
    held: dict[int, list[str]] = {}
    for node, direction in model.fixed:
        held.setdefault(node, []).append(direction)
    marks: list[Mark] = []
    for kind in PARTS:
        joined = [points[[each.node, each.other]] for each in model._parts(kind) if hasattr(each, "other")]
        for nth, (a, b) in enumerate(joined):
            label = None if nth else kind.replace("_", " ").removesuffix("s")
            marks.append(Paths([_coil(a, b, 0.03)], "black", width=1.0, label=label))
            marks.append(Points(*xy([a, b]), "D", 3.5))
    whole = 6 if model.nodes_m.shape[1] == 3 else 3
    for nodes, sign, size, name in (
        ([node for node, of in held.items() if len(of) == whole], "s", 11.0, "fixed"),
        ([node for node, of in held.items() if len(of) < whole], "x", 9.0, "partly fixed"),
        ([m.node for m in model.point_masses], "o", 9.0, "point mass"),
        ([s.node for s in model.ground_springs], "v", 6.5, "spring to ground"),
    ):
        if nodes:
            marks.append(Points(*xy(points[sorted(set(nodes))]), sign, size, face="white", label=name))
    return marks


def _numbers(elements: Any, points: FloatArray, scale: float, nodes: bool) -> list[Mark]:
    """Numbers from 0, those of elements left of their middles, those of nodes at the right; in points."""
    ends = points[elements]
    along = ends[:, 1] - ends[:, 0]
    along *= 7.0 / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    across = np.column_stack([-along[:, 1], along[:, 0]])
    places, size = ends.mean(axis=1) + across, 7.5 if len(ends) <= 30 else 6.5
    marks: list[Mark] = [Words(*xy(places / scale), list(map(str, range(len(ends)))), "centre", size=size)]
    if nodes:
        places, size = points.copy(), 6.5 if len(points) <= 30 else 5.5
        for end in (1, 0):
            places[elements[:, end]] = ends[:, end] + 0.75 * (along - across)
        look: dict[str, Any] = {"size": size, "colour": NODES, "slanted": True}
        marks.append(Words(*xy(places / scale), list(map(str, range(len(points)))), "centre", **look))
        marks.append(Points([], [], "$0$", 5.0, only="picture", label="number of an element"))
        marks.append(Points([], [], "$\\it{0}$", 5.0, NODES, only="picture", label="number of a node"))
    return marks


def _seen(direction: str, space: bool) -> FloatArray:
    """A direction as it is seen in the picture, of unit length."""
    axis = np.eye(3)["uvw".index(direction)]
    along = ISOMETRIC @ axis if space else axis[:2]
    return np.asarray(along / np.linalg.norm(along))
