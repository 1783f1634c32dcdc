"""Frames: their elements numbered, sensors, shaker, and colours by any value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .._validation import FloatArray, integer, real_array, reject
from .canvas import COLOURS, GREY, LINES, below, new_axes

if TYPE_CHECKING:
    from ..frame import FrameModel

__all__ = ["plot_frame"]

#: Isometric view of frames in space: x to the lower right, y to the upper right, z up.
ISOMETRIC = np.array([[np.sqrt(0.5), np.sqrt(0.5), 0.0],
                      [-np.sqrt(1 / 6), np.sqrt(1 / 6), np.sqrt(2 / 3)]])
#: Up to this many elements are numbered unless told otherwise.
MOST_NUMBERS = 120
#: Length of an arrow, and distance of a number from its element, in points.
ARROW, NUMBER = 26.0, 7.0
#: Colours of sections; vermillion and black are those of the arrows.
SHADES = [COLOURS[name] for name in ("blue", "orange", "sky", "purple", "green")]


def plot_frame(model: FrameModel, values: Any = None, ax: Any = None, *, sensors: Sequence[int] = (),
               excitation: int | None = None, numbers: bool | None = None,
               label: str = "Value by element") -> Any:
    """Draw a frame with its elements numbered, coloured by section or by a value of each element.

    Parameters
    ----------
    model : FrameModel
    values : array_like, (n_elements,), or mapping of int to float, optional
        Value of each element, for example ``DamageResult.severity``; elements without one are grey. By
        default the colours tell the sections apart.
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
    if numbers or (numbers is None and len(ends) <= MOST_NUMBERS):
        for i, (a, b) in enumerate(ends):
            across = np.array([a[1] - b[1], b[0] - a[0]])
            beside = NUMBER * across / max(float(np.linalg.norm(across)), 1e-300)
            ax.annotate(str(i + 1), 0.5 * (a + b), xytext=tuple(beside), textcoords="offset points",
                        ha="center", va="center", fontsize=6.5, zorder=4)
    _carried(ax, model, points)
    frame_names = model._frame.dof_names()
    for dof in sensors:
        _arrow(ax, points, frame_names[model._dof("sensors", dof)], COLOURS["vermillion"], 0.7, space)
    if len(sensors):
        ax.plot([], [], ls="", marker=r"$\rightarrow$", ms=11, color=COLOURS["vermillion"],
                label="accelerometer")
    if excitation is not None:
        _arrow(ax, points, frame_names[model._dof("excitation", excitation)], COLOURS["black"], 1.3, space)
        ax.plot([], [], ls="", marker=r"$\rightarrow$", ms=15, color=COLOURS["black"], label="force")
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08)
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
    known = np.isfinite(values)
    ax.add_collection(LineCollection(list(ends[~known]), colors=GREY, linewidths=2.0, zorder=2))
    coloured = LineCollection(list(ends[known]), cmap="cividis_r", linewidths=5.0, zorder=2)
    coloured.set_array(values[known])
    if known.any() and np.ptp(values[known]) == 0.0:
        coloured.set_clim(min(0.0, values[known][0]), max(values[known][0], 1e-12))
    ax.add_collection(coloured)
    ax.autoscale_view()
    if known.any():
        ax.figure.colorbar(coloured, ax=ax, label=label, shrink=0.8)


def _carried(ax: Any, model: FrameModel, points: FloatArray) -> None:
    """Point masses, springs to ground and fixed nodes."""
    for nodes, marker, size, name in (
            ([m.node for m in model.point_masses], "o", 9.0, "point mass"),
            ([s.node for s in model.ground_springs], "v", 7.0, "spring to ground"),
            ([node for node, _ in model.fixed], "s", 7.0, "fixed")):
        if nodes:
            at = points[sorted(set(nodes))]
            ax.plot(at[:, 0], at[:, 1], ls="", marker=marker, ms=size, mfc="white", mec="black", mew=1.2,
                    zorder=3, label=name)


def _arrow(ax: Any, points: FloatArray, dof: tuple[int, str], colour: str, length: float,
           space: bool) -> None:
    node, direction = dof
    at = points[node]
    if direction in ("theta", "rx", "ry", "rz"):
        ax.plot(*at, ls="", marker=r"$\circlearrowleft$", ms=14.0 * length, color=colour, zorder=5)
        return
    axis = np.eye(3)["uvw".index(direction)]
    along = ISOMETRIC @ axis if space else axis[:2]
    ax.annotate("", at, xytext=tuple(-ARROW * length * along / np.linalg.norm(along)),
                textcoords="offset points", zorder=5,
                arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.6 * length, "shrinkA": 0,
                            "shrinkB": 2})
