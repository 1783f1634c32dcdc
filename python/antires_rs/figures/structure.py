"""Frames: their elements numbered, sensors, shaker, and colours by any value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.checks import FloatArray
from .canvas import (
    COLOURS,
    around,
    below,
    beside,
    coloured,
    fit_across,
    new_axes,
    offer,
    points_per_unit,
    value_by_element,
    width_pt,
)

if TYPE_CHECKING:
    from ..models.chain import MassSpringChain
    from ..models.frame import FrameModel


# -- Chains of masses and springs, coloured by any value


#: Share of a free end's stiffness that rounding may leave.
ROUNDING = 1e-9
#: Up to this many masses the springs are drawn as coils, so high.
MOST_COILS, HEIGHT = 20, 0.16


def plot_chain(
    model: MassSpringChain,
    values: Any = None,
    ax: Any = None,
    *,
    sensors: Sequence[int] = (),
    excitation: int | None = None,
    label: str = "Value by spring",
) -> Any:
    """Draw a chain with its springs numbered and coloured by a value of each.

    Parameters
    ----------
    model : MassSpringChain
    values : array_like, (n_masses - 1,), or mapping of int to float, optional
        Value of each spring between masses, for example ``DamageResult.severity``: light grey at 0, dark blue
        at the largest; springs without one are thin. Those to ground have theirs in a mapping.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    sensors : sequence of int, optional
        Dofs of the accelerometers; arrows above their masses.
    excitation : int, optional
        Dof of the force; a heavier arrow below its mass.
    label : str
        Name of the values, with their unit.

    Returns
    -------
    matplotlib.axes.Axes
        Masses and springs with their numbers from 0, as tables have them.

    Raises
    ------
    InvalidInputError
        Values that do not fit the springs, dofs outside the model.
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs.figures import plot_chain
    >>> from matplotlib.figure import Figure
    >>> ax = plot_chain(ar.cases.chain8().model, {4: 55.0}, ax=Figure().subplots(), excitation=0)
    >>> ax.get_xlabel()
    'Mass (number of each spring above it)'
    """
    n = model.n_dof
    force = [] if excitation is None else [model._dof("excitation", excitation)]
    measured = [model._dof("sensors", dof) for dof in sensors]
    given = value_by_element(values, n + 1 if values is None or isinstance(values, Mapping) else n - 1)
    ax = new_axes(ax, (max(6.0, 0.5 * n + 1.5), 2.8))
    springs = spring_paths(model)
    paths = list(springs.values())
    by_spring = np.full(n + 1, np.nan)
    if given is None:
        for path in paths:
            ax.plot(*path.T, color=COLOURS["blue"], lw=1.6, zorder=2)
    else:
        by_spring[: given.size] = given
        coloured(ax, paths, by_spring[list(springs)], label, width=2.6 if n <= MOST_COILS else 5.0)
    size = float(np.clip(0.4 * width_pt(ax) / (n + 1), 4.0, 22.0))
    ax.plot(range(n), np.zeros(n), ls="", marker="s", ms=size, mfc="white", mec="black", mew=1.2, zorder=3)
    for element in springs.keys() & {n - 1, n}:
        wall = springs[element][-1, 0]
        ax.plot([wall, wall], [-0.4, 0.4], color="black", lw=2.5, zorder=3)
    _arrows(ax, measured, 0.5 * size + 8.0, COLOURS["vermillion"], 11.0, "accelerometer")
    _arrows(ax, force, -0.5 * size - 9.0, COLOURS["black"], 15.0, "force")
    every = next(step for step in (1, 2, 5, 10, n) if fit_across(ax, [str(n)] * (n // step), 8.0))
    for element in list(springs)[::every]:
        name = str(element) if element < n - 1 else "ground"
        ax.annotate(
            name,
            (springs[element][:, 0].mean(), HEIGHT),
            xytext=(0, 4),
            ha="center",
            va="bottom",
            textcoords="offset points",
            fontsize="small",
        )
    ax.set_xticks(range(0, n, every), [str(i) for i in range(0, n, every)])
    reach = np.array([[0.0, n - 1.0], *([path[:, 0].min(), path[:, 0].max()] for path in paths)])
    ax.set_xlim(reach.min() - 0.6, reach.max() + 0.6)
    ax.set_ylim(-0.8, 0.8)
    ax.set_yticks([])
    ax.set_xlabel("Mass (number of each spring above it)")
    if ax.get_legend_handles_labels()[1]:
        below(ax)
    offer(
        ax,
        springs={
            "element": list(springs),
            "name": [model.element_label(e) for e in springs],
            **({} if given is None else {"value": by_spring[list(springs)]}),
        },
    )
    return ax


def coil(a: FloatArray, b: FloatArray, amplitude: float) -> FloatArray:
    """A spring as it is drawn from a to b, (n, 2): straight ends and a zigzag."""
    share = np.array([0.0, 0.25, *np.linspace(0.29, 0.71, 8), 0.75, 1.0])
    off = amplitude * np.array([0.0, 0.0, *np.tile([1.0, -1.0], 4), 0.0, 0.0])
    across = np.array([a[1] - b[1], b[0] - a[0]])
    return np.asarray(a + share[:, None] * (b - a) + off[:, None] * across)


def spring_paths(model: MassSpringChain) -> dict[int, FloatArray]:
    """The springs that there are, by element: those between masses, then those to ground."""
    n, stiffness = model.n_dof, model.stiffness()
    ends = {i: (i, i + 1) for i in range(n - 1)}
    for element, mass, wall in ((n - 1, 0, -1), (n, n - 1, n)):
        if stiffness[mass].sum() > ROUNDING * stiffness[mass, mass]:
            ends[element] = (mass, wall)
    high = HEIGHT if n <= MOST_COILS else 0.0
    return {element: coil(np.array([a, 0.0]), np.array([b, 0.0]), high) for element, (a, b) in ends.items()}


def _arrows(ax: Any, dofs: list[int], offset_pt: float, colour: str, size: float, name: str) -> None:
    """Arrows to the right, the positive direction, so many points above their masses."""
    from matplotlib.transforms import ScaledTranslation

    if dofs:
        lifted = ax.transData + ScaledTranslation(0.0, offset_pt / 72.0, ax.figure.dpi_scale_trans)
        ax.plot(
            dofs,
            np.zeros(len(dofs)),
            ls="",
            marker=r"$\rightarrow$",
            ms=size,
            color=colour,
            zorder=4,
            transform=lifted,
            label=name,
        )


#: Isometric view of frames in space: x to the lower right, y to the upper right, z up.
ISOMETRIC = np.array([[np.sqrt(0.5), np.sqrt(0.5), 0.0], [-np.sqrt(1 / 6), np.sqrt(1 / 6), np.sqrt(2 / 3)]])
#: Up to this many elements are numbered unless told otherwise.
MOST_NUMBERS, MOST_NODES = 120, 60
#: Length of an arrow in points, and the room around the frame as a share of its extent.
ARROW, MARGIN = 26.0, 0.08
#: Colours of sections; vermillion and black are those of the arrows.
SHADES = [COLOURS[name] for name in ("blue", "orange", "sky", "purple", "green")]
#: Dashes of sections, in the same turn, closer than those of curves: a section may be short.
DASHES: tuple[Any, ...] = (
    "-",
    (0, (4, 1)),
    (0, (2, 1)),
    (0, (4, 1, 1, 1)),
    (0, (1, 1)),
    (0, (6, 1, 1, 1, 1, 1)),
)
#: Ink of the numbers of nodes: paler than that of elements in grey too.
NODES = "#7A3E9D"
ROTATIONS = ("theta", "rx", "ry", "rz")


def plot_frame(
    model: FrameModel,
    values: Any = None,
    ax: Any = None,
    *,
    sensors: Sequence[int] = (),
    excitation: int | None = None,
    numbers: bool | None = None,
    label: str = "Value by element",
) -> Any:
    """Draw a frame with its elements numbered, coloured by section or by a value of each element.

    Parameters
    ----------
    model : FrameModel
    values : array_like, (n_elements,), or mapping of int to float, optional
        Value of each element, for example ``DamageResult.severity``: light grey at 0, dark blue at the
        largest; elements without one are thin. By default the colours tell the sections apart.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    sensors : sequence of int, optional
        Dofs of the accelerometers; drawn as arrows along their direction.
    excitation : int, optional
        Dof of the force; a longer arrow.
    numbers : bool, optional
        Whether to number elements and nodes, from 0 as tables do; those of nodes are slanted, in grey. By
        default elements up to 120 and nodes up to 60.
    label : str
        Name of the values, with their unit.

    Returns
    -------
    matplotlib.axes.Axes
        Equal scales in metres; frames in space are seen isometrically.

    Raises
    ------
    InvalidInputError
        Values that do not fit the elements, dofs outside the model.
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from matplotlib.figure import Figure
    >>> pipe = ar.Tube(0.038, 0.0015, 2.1e11, 7850.0)
    >>> frame = ar.FrameModel([(0, 0), (1, 0), (1, 1)], [(0, 1), (1, 2)], pipe, fixed=[0])
    >>> ax = frame.plot({1: 0.4}, ax=Figure().subplots(), excitation=frame.dof(2, "u"))
    >>> ax.get_xlabel()
    'x (m)'
    """
    given = value_by_element(values, len(model.elements))
    ax = new_axes(ax, (9.0, 4.6))
    space = model.nodes_m.shape[1] == 3
    points = model.nodes_m @ ISOMETRIC.T if space else model.nodes_m
    ends = points[model.elements]
    if given is None:
        _by_section(ax, model, ends)
    else:
        coloured(ax, list(ends), given, label)
    _carried(ax, model, points)
    names = model._frame.dof_names()
    arrows = [
        _arrow(ax, points, names[model._dof("sensors", dof)], COLOURS["vermillion"], 0.7, space)
        for dof in sensors
    ]
    if arrows:
        ax.plot(
            [], [], ls="", marker=r"$\rightarrow$", ms=11, color=COLOURS["vermillion"], label="accelerometer"
        )
    if excitation is not None:
        force = names[model._dof("excitation", excitation)]
        arrows.append(_arrow(ax, points, force, COLOURS["black"], 1.3, space))
        ax.plot([], [], ls="", marker=r"$\rightarrow$", ms=15, color=COLOURS["black"], label="force")
    if numbers or (numbers is None and len(ends) <= MOST_NUMBERS):
        placed = _numbered(ax, points, ends, arrows)
        if numbers or len(points) <= MOST_NODES:
            _numbered_nodes(ax, points, ends, arrows, placed)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(MARGIN)
    ax.set_xlabel("isometric view (m)" if space else "x (m)")
    ax.set_ylabel("" if space else "y (m)")
    if ax.get_legend_handles_labels()[1]:
        below(ax, drop_pt=44.0, handlelength=3.0)
    offer(
        ax,
        elements={
            "element": np.arange(len(ends)),
            "start_node": model.elements[:, 0],
            "end_node": model.elements[:, 1],
            "section": [str(name) for name in model.element_sections],
            **({} if given is None else {"value": given}),
        },
    )
    return ax


def _by_section(ax: Any, model: FrameModel, ends: FloatArray) -> None:
    of = np.array([model.section_index(name) for name in model.element_sections])
    several = len(model.sections) > 1
    for i in range(len(model.sections)):
        path = _path(ends[of == i]).T
        # Dashes tell sections apart without colour; what is pale underneath keeps the frame in one piece.
        ax.plot(*path, color="#D5D5D5", lw=3.2, zorder=1.9, solid_capstyle="round")
        ax.plot(
            *path,
            color=SHADES[i % len(SHADES)],
            lw=3.2,
            zorder=2,
            ls=DASHES[i % len(DASHES)],
            solid_capstyle="round",
            dash_capstyle="butt",
            label=model.section_label(i) if several else None,
        )


def _path(ends: FloatArray) -> FloatArray:
    """Elements (n, 2, 2) one after the other, (m, 2), with a gap where one does not go on."""
    points: list[FloatArray] = []
    for start, end in ends:
        if not points or np.any(points[-1] != start):
            points += [np.full(2, np.nan), start]
        points.append(end)
    return np.array(points[1:]).reshape(-1, 2)


def _carried(ax: Any, model: FrameModel, points: FloatArray) -> None:
    """Fixed nodes, point masses, springs to ground and between nodes; smaller markers over larger ones."""
    space = model.nodes_m.shape[1] == 3
    held: dict[int, list[str]] = {}
    for node, direction in model.fixed:
        held.setdefault(node, []).append(direction)
    whole = 6 if space else 3
    _marked(ax, points, [node for node, of in held.items() if len(of) == whole], "s", 11.0, "fixed")
    partly = [(node, direction) for node, of in held.items() if len(of) < whole for direction in of]
    for i, (node, direction) in enumerate(partly):
        # A stroke across the direction that is held.
        along = None if direction in ROTATIONS else _seen(direction, space)
        marker = "x" if along is None else (2, 2, float(np.degrees(np.arctan2(along[1], along[0]))))
        ax.plot(
            *points[node],
            ls="",
            marker=marker,
            ms=8.0 if along is None else 17.0,
            mec="black",
            mew=2.0,
            zorder=3,
            label="partly fixed" if i == 0 else None,
        )
    _marked(ax, points, [m.node for m in model.point_masses], "o", 9.0, "point mass")
    _marked(ax, points, [s.node for s in model.ground_springs], "v", 6.5, "spring to ground")
    for i, spring in enumerate(model.node_springs):
        ax.plot(
            *coil(points[spring.node], points[spring.other], 0.03).T,
            color="black",
            lw=1.0,
            marker="D",
            ms=3.5,
            markevery=[0, -1],
            zorder=2.5,
            label="node spring" if i == 0 else None,
        )


def _marked(ax: Any, points: FloatArray, nodes: list[int], marker: str, size: float, name: str) -> None:
    if nodes:
        at = points[sorted(set(nodes))]
        ax.plot(
            at[:, 0],
            at[:, 1],
            ls="",
            marker=marker,
            ms=size,
            mfc="white",
            mec="black",
            mew=1.2,
            zorder=3,
            label=name,
        )


def _lines_pt(arrows: list[FloatArray], scale: float) -> FloatArray:
    """Arrows in points, (n, 2, 2)."""
    lines = np.array(arrows).reshape(-1, 2, 2)
    lines[:, 0] *= scale
    lines[:, 1] += lines[:, 0]
    return lines


def _numbered_nodes(
    ax: Any, points: FloatArray, ends: FloatArray, arrows: list[FloatArray], taken: FloatArray
) -> None:
    """Numbers of the nodes near them, slanted, out of the way of all else."""
    scale = points_per_unit(ax, points, MARGIN)
    lines = np.concatenate([_lines_pt(arrows, scale), scale * ends, np.stack([taken, taken], axis=1)])
    for i, (at, node) in enumerate(zip(around(scale * points, lines), points, strict=True)):
        ax.annotate(
            str(i),
            node,
            xytext=tuple(at - scale * node),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=6.5 if len(points) <= 30 else 5.5,
            fontstyle="italic",
            color=NODES,
            zorder=4,
        )
    ax.plot([], [], ls="", marker="$0$", ms=5, color="black", label="number of an element")
    ax.plot([], [], ls="", marker="$\\it{0}$", ms=5, color=NODES, label="number of a node")


def _numbered(ax: Any, points: FloatArray, ends: FloatArray, arrows: list[FloatArray]) -> FloatArray:
    """Numbers from 0 beside the elements, out of the way of arrows; their places in points."""
    size = 7.5 if len(ends) <= 30 else 6.5
    scale = points_per_unit(ax, points, MARGIN)
    places = beside(scale * ends, _lines_pt(arrows, scale))
    for i, (at, middle) in enumerate(zip(places, ends.mean(axis=1), strict=True)):
        ax.annotate(
            str(i),
            middle,
            xytext=tuple(at - scale * middle),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=size,
            zorder=4,
        )
    return places


def _seen(direction: str, space: bool) -> FloatArray:
    """A direction as it is seen in the picture, of unit length."""
    axis = np.eye(3)["uvw".index(direction)]
    along = ISOMETRIC @ axis if space else axis[:2]
    return np.asarray(along / np.linalg.norm(along))


def _arrow(
    ax: Any, points: FloatArray, dof: tuple[int, str], colour: str, length: float, space: bool
) -> FloatArray:
    """Draw it; the node it points to, and where its tail is from there in points, (2, 2)."""
    node, direction = dof
    at = points[node]
    if direction in ROTATIONS:
        ax.plot(*at, ls="", marker=r"$\circlearrowleft$", ms=14.0 * length, color=colour, zorder=5)
        return np.array([at, np.zeros(2)])
    tail = -ARROW * length * _seen(direction, space)
    ax.annotate(
        "",
        at,
        xytext=tuple(tail),
        textcoords="offset points",
        zorder=5,
        arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.6 * length, "shrinkA": 0, "shrinkB": 2},
    )
    return np.array([at, tail])
