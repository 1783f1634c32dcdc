"""Frames: their elements numbered, sensors, shaker, and colours by any value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .._validation import FloatArray, integer, real_array, reject
from .canvas import COLOURS, GREY, LINES, below, new_axes
from .numbers import beside, points_per_unit

if TYPE_CHECKING:
    from ..frame import FrameModel

__all__ = ["plot_frame"]

#: Isometric view of frames in space: x to the lower right, y to the upper right, z up.
ISOMETRIC = np.array([[np.sqrt(0.5), np.sqrt(0.5), 0.0],
                      [-np.sqrt(1 / 6), np.sqrt(1 / 6), np.sqrt(2 / 3)]])
#: Up to this many elements are numbered unless told otherwise.
MOST_NUMBERS = 120
#: Length of an arrow in points, and the room around the frame as a share of its extent.
ARROW, MARGIN = 26.0, 0.08
#: Colours of sections; vermillion and black are those of the arrows.
SHADES = [COLOURS[name] for name in ("blue", "orange", "sky", "purple", "green")]
#: From nothing, which is to be quiet, to much; lightness falls evenly, so that it reads in grey as well.
SCALE = ("#DADADA", "#A9BFD6", "#5F8DBD", "#1F5A94", "#0B2C57", "#050B16")
ROTATIONS = ("theta", "rx", "ry", "rz")


def plot_frame(model: FrameModel, values: Any = None, ax: Any = None, *, sensors: Sequence[int] = (),
               excitation: int | None = None, numbers: bool | None = None,
               label: str = "Value by element") -> Any:
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
        Whether to number the elements, from 1 as tables do; by default up to 120 elements.
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
    given = _values(model, values)
    ax = new_axes(ax, (9.0, 4.6))
    space = model.nodes_m.shape[1] == 3
    points = model.nodes_m @ ISOMETRIC.T if space else model.nodes_m
    ends = points[model.elements]
    if given is None:
        _by_section(ax, model, ends)
    else:
        _by_value(ax, ends, given, label)
    _carried(ax, model, points)
    names = model._frame.dof_names()
    arrows = [_arrow(ax, points, names[model._dof("sensors", dof)], COLOURS["vermillion"], 0.7, space)
              for dof in sensors]
    if arrows:
        ax.plot([], [], ls="", marker=r"$\rightarrow$", ms=11, color=COLOURS["vermillion"],
                label="accelerometer")
    if excitation is not None:
        force = names[model._dof("excitation", excitation)]
        arrows.append(_arrow(ax, points, force, COLOURS["black"], 1.3, space))
        ax.plot([], [], ls="", marker=r"$\rightarrow$", ms=15, color=COLOURS["black"], label="force")
    if numbers or (numbers is None and len(ends) <= MOST_NUMBERS):
        _numbered(ax, points, ends, arrows)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(MARGIN)
    ax.set_xlabel("isometric view (m)" if space else "x (m)")
    ax.set_ylabel("" if space else "y (m)")
    if ax.get_legend_handles_labels()[1]:
        below(ax, 4, drop_pt=44.0)
    return ax


def _values(model: FrameModel, values: Any) -> FloatArray | None:
    """A value for each beam, NaN where there is none."""
    if values is None:
        return None
    n = len(model.elements)
    if isinstance(values, Mapping):
        given = np.full(n, np.nan)
        for element, value in values.items():
            given[integer("values", element, low=0, high=n - 1)] = value
        return given
    wanted = f"a mapping from element to value, or an array ({n},)"
    array = real_array("values", values, ndim=1, wanted=wanted)
    if array.size != n:
        reject("values", f"{array.size} values", wanted)
    return array


def _by_section(ax: Any, model: FrameModel, ends: FloatArray) -> None:
    of = model.element_sections
    for i, name in enumerate(model.sections):
        chosen = [e for e, section in enumerate(of) if section == name]
        for number, element in enumerate(chosen):
            ax.plot(*ends[element].T, color=SHADES[i % len(SHADES)], lw=3.0, zorder=2,
                    ls=LINES[i // len(SHADES) % len(LINES)], solid_capstyle="round",
                    label=model.section_label(i) if number == 0 and len(model.sections) > 1 else None)


def _by_value(ax: Any, ends: FloatArray, values: FloatArray, label: str) -> None:
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap
    known = np.isfinite(values)
    ax.add_collection(LineCollection(list(ends[~known]), colors=GREY, linewidths=1.2, zorder=2))
    # The largest last, so that it lies on top where elements meet.
    order = np.flatnonzero(known)[np.argsort(values[known], kind="stable")]
    coloured = LineCollection(list(ends[order]), cmap=LinearSegmentedColormap.from_list("loss", SCALE),
                              linewidths=5.0, zorder=2)
    coloured.set_array(values[order])
    if known.any():
        low, high = min(0.0, float(values[known].min())), max(0.0, float(values[known].max()))
        coloured.set_clim(low, high if high > low else low + 1.0)
    ax.add_collection(coloured)
    ax.autoscale_view()
    if known.any():
        ax.figure.colorbar(coloured, ax=ax, label=label, shrink=0.8)


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
        ax.plot(*points[node], ls="", marker=marker, ms=8.0 if along is None else 17.0, mec="black", mew=2.0,
                zorder=3, label="partly fixed" if i == 0 else None)
    _marked(ax, points, [m.node for m in model.point_masses], "o", 9.0, "point mass")
    _marked(ax, points, [s.node for s in model.ground_springs], "v", 6.5, "spring to ground")
    for i, spring in enumerate(model.node_springs):
        ax.plot(*_coil(points[spring.node], points[spring.other]).T, color="black", lw=1.0, marker="D",
                ms=3.5, markevery=[0, -1], zorder=2.5, label="node spring" if i == 0 else None)


def _marked(ax: Any, points: FloatArray, nodes: list[int], marker: str, size: float, name: str) -> None:
    if nodes:
        at = points[sorted(set(nodes))]
        ax.plot(at[:, 0], at[:, 1], ls="", marker=marker, ms=size, mfc="white", mec="black", mew=1.2,
                zorder=3, label=name)


def _coil(a: FloatArray, b: FloatArray) -> FloatArray:
    """A spring as it is drawn, (n, 2): straight ends and a zigzag."""
    share = np.array([0.0, 0.25, *np.linspace(0.29, 0.71, 8), 0.75, 1.0])
    off = 0.03 * np.array([0.0, 0.0, *np.tile([1.0, -1.0], 4), 0.0, 0.0])
    across = np.array([a[1] - b[1], b[0] - a[0]])
    return np.asarray(a + share[:, None] * (b - a) + off[:, None] * across)


def _numbered(ax: Any, points: FloatArray, ends: FloatArray, arrows: list[FloatArray]) -> None:
    """Numbers from 1 beside the elements, out of the way of arrows."""
    scale = points_per_unit(ax, points, MARGIN)
    lines = np.array(arrows).reshape(-1, 2, 2)
    lines[:, 0] *= scale
    lines[:, 1] += lines[:, 0]
    for i, (at, middle) in enumerate(zip(beside(scale * ends, lines), ends.mean(axis=1), strict=True)):
        ax.annotate(str(i + 1), middle, xytext=tuple(at - scale * middle), textcoords="offset points",
                    ha="center", va="center", fontsize=6.5, zorder=4)


def _seen(direction: str, space: bool) -> FloatArray:
    """A direction as it is seen in the picture, of unit length."""
    axis = np.eye(3)["uvw".index(direction)]
    along = ISOMETRIC @ axis if space else axis[:2]
    return np.asarray(along / np.linalg.norm(along))


def _arrow(ax: Any, points: FloatArray, dof: tuple[int, str], colour: str, length: float,
           space: bool) -> FloatArray:
    """Draw it; the node it points to, and where its tail is from there in points, (2, 2)."""
    node, direction = dof
    at = points[node]
    if direction in ROTATIONS:
        ax.plot(*at, ls="", marker=r"$\circlearrowleft$", ms=14.0 * length, color=colour, zorder=5)
        return np.array([at, np.zeros(2)])
    tail = -ARROW * length * _seen(direction, space)
    ax.annotate("", at, xytext=tuple(tail), textcoords="offset points", zorder=5,
                arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.6 * length, "shrinkA": 0,
                            "shrinkB": 2})
    return np.array([at, tail])
