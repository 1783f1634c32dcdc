"""Frames: their elements numbered, sensors, shaker, and colours by any value."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.validation import FloatArray
from .canvas import COLOURS, below, new_axes, offer
from .chain import coil
from .numbers import around, beside, points_per_unit
from .values import coloured, value_by_element

if TYPE_CHECKING:
    from ..models.frame import FrameModel

__all__ = ["plot_frame"]

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
