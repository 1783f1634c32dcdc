"""The structure: elements, nodes, sensors and force, and what each element has lost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..models.chain import MassSpringChain
from ..plotting.chain import spring_paths
from ..plotting.frame import ISOMETRIC, ROTATIONS, SHADES, _seen
from ..plotting.values import SCALE
from .canvas import COLOURS, DASHES, GREY, below, columns, hover, paper

if TYPE_CHECKING:
    from ..models.frame import FrameModel
    from ..support.validation import FloatArray

__all__ = ["structure_figure"]

#: Up to so many nodes and elements are numbered without hovering.
MOST_NUMBERS = 60


def structure_figure(
    model: MassSpringChain | FrameModel,
    loss_percent: Mapping[int, float] | None = None,
    sensors: Sequence[Any] = (),
    excitation: Any = None,
) -> Any:
    """A chain or a frame; hovering tells elements, nodes and sensors.

    Parameters
    ----------
    model : MassSpringChain or FrameModel
    loss_percent : mapping of int to float, optional
        Stiffness loss by element; light grey at 0, dark blue at the largest. Frames without it show their
        sections.
    sensors : sequence of dofs
        Where the accelerometers are.
    excitation : dof, optional
        Where the force acts.

    Returns
    -------
    bokeh.plotting.figure
    """
    if isinstance(model, MassSpringChain):
        return _chain(model, loss_percent, sensors, excitation)
    return _frame(model, loss_percent, sensors, excitation)


def _chain(model: MassSpringChain, loss: Mapping[int, float] | None, sensors: Any, excitation: Any) -> Any:
    n, paths = model.n_dof, spring_paths(model)
    fig = paper("Mass", "", height=260, y_range=(-1.0, 1.0), name="model")
    drawn = _elements(fig, model, list(paths), list(paths.values()), loss, 3)
    mass = np.asarray(model.mass()).diagonal()
    table = columns(x=np.arange(n), y=np.zeros(n), name=[model.dof_label(i) for i in range(n)], mass=mass)
    table.data["number"] = [str(i) for i in range(n)]
    marks = fig.scatter(
        "x", "y", source=table, marker="square", size=min(22, 400 / n), fill_color="white", line_color="black"
    )
    for element in paths.keys() & {n - 1, n}:
        wall = float(paths[element][-1, 0])
        fig.line([wall, wall], [-0.4, 0.4], color="black", line_width=3)
    hover(fig, drawn, _says_element(loss))
    hover(fig, [marks], {"": "@name", "Mass": "@mass{0.000000} kg"})
    few = range(0, n, -(-n // 24))
    _texts(fig, [(i, 0.0, str(i)) for i in few], "black")
    _texts(
        fig, [(p[:, 0].mean(), 0.24, str(e)) for e, p in paths.items() if e < n - 1 and e in few], "#444444"
    )
    _arrows(fig, [(model._dof("sensors", d), 0.52, 0.4, 0.0) for d in sensors], "vermillion", "accelerometer",
            [model.dof_label(model._dof("sensors", d)) for d in sensors])  # fmt: skip
    if excitation is not None:
        at = model._dof("excitation", excitation)
        _arrows(fig, [(at, -0.55, 0.6, 0.0)], "black", "force", [model.dof_label(at)])
    fig.xaxis.ticker = list(few)
    fig.yaxis.visible = False
    fig.grid.grid_line_color = None
    if fig.legend:
        below(fig)
    return fig


def _frame(model: FrameModel, loss: Mapping[int, float] | None, sensors: Any, excitation: Any) -> Any:
    space = model.nodes_m.shape[1] == 3
    points = np.asarray(model.nodes_m @ ISOMETRIC.T if space else model.nodes_m, dtype=np.float64)
    size = np.ptp(points, axis=0)
    flat = float(size[1] / max(size[0], 1e-300))
    fig = paper(
        "isometric view (m)" if space else "x (m)",
        "" if space else "y (m)",
        height=int(np.clip(700 * flat, 320, 620)),
        equal=True,
        name="model",
    )
    paths = list(points[model.elements])
    drawn = _elements(fig, model, list(range(len(paths))), paths, loss, 6)
    hover(fig, drawn, _says_element(loss) | {"Nodes": "@ends", "Section": "@section"})
    _held(fig, model, points)
    where = [", ".join(f"{x:g}" for x in node) + " m" for node in model.nodes_m]
    nodes = columns(x=points[:, 0], y=points[:, 1], number=[str(i) for i in range(len(points))], where=where)
    dots = fig.scatter("x", "y", source=nodes, size=5, fill_color="white", line_color="black")
    hover(fig, [dots], {"Node": "@number", "At": "@where"})
    if len(points) <= MOST_NUMBERS:
        away = 0.022 * float(size.max())
        _texts(fig, [(*(p.mean(axis=0) + _across(p, away)), str(e)) for e, p in enumerate(paths)], "black")
        numbers = [(x, y, str(i)) for i, (x, y) in enumerate(points)]
        _texts(fig, numbers, "#7A3E9D", offset=-11, italic=True)
    names = model._frame.dof_names()
    reach = 0.07 * float(size.max())
    for dofs, colour, label, length in (
        (list(sensors), "vermillion", "accelerometer", 1.0),
        ([] if excitation is None else [excitation], "black", "force", 1.7),
    ):
        found = [names[model._dof("dof", dof)] for dof in dofs]
        arrows = [
            (*points[node], *(length * reach * _seen(direction, space)))
            for node, direction in found
            if direction not in ROTATIONS
        ]
        _arrows(
            fig,
            arrows,
            colour,
            label,
            [f"node {node} {way}" for node, way in found if way not in ROTATIONS],
            to=True,
        )
    if fig.legend:
        below(fig)
    return fig


def _says_element(loss: Any) -> dict[str, str]:
    return {"": "@name"} | ({} if loss is None else {"Stiffness loss": "@loss"})


def _elements(
    fig: Any,
    model: Any,
    numbers: list[int],
    paths: list[FloatArray],
    loss: Mapping[int, float] | None,
    width: int,
) -> list[Any]:
    """Lines of the elements, coloured by loss with a scale at the right, or by section."""
    from bokeh.models import ColorBar, LinearColorMapper

    frame = hasattr(model, "elements")
    section = [str(name) for name in model.element_sections] if frame else [""] * len(numbers)

    def rows(some: list[int]) -> Any:
        table = _lines(paths, some)
        table.data["name"] = [model.element_label(numbers[i]) for i in some]
        table.data["section"] = [section[i] for i in some]
        table.data["ends"] = [" to ".join(map(str, model.elements[i])) if frame else "" for i in some]
        return table

    if loss is None:
        kinds = list(dict.fromkeys(section))
        drawn = []
        for nth, kind in enumerate(kinds):
            table = rows([i for i, own in enumerate(section) if own == kind])
            look = {"line_color": SHADES[nth % len(SHADES)], "line_dash": DASHES[nth % len(DASHES)]}
            label = (
                {"legend_label": model.section_label(nth) if kind.isdigit() else kind}
                if len(kinds) > 1
                else {}
            )
            drawn.append(fig.multi_line("xs", "ys", source=table, line_width=width, **look, **label))
        return drawn
    value = np.array([loss.get(number, np.nan) for number in numbers])
    table = rows(list(range(len(numbers))))
    table.data["value"] = np.where(np.isnan(value), 0.0, value).astype(np.float32)
    table.data["width"] = np.where(np.isnan(value), 1.5, width).astype(np.float32)
    table.data["loss"] = ["no candidate" if np.isnan(v) else f"{v:.1f} %" for v in value]
    top = float(np.nanmax(value, initial=0.0))
    mapper = LinearColorMapper(palette=_palette(), low=0.0, high=top or 1.0)
    lines = fig.multi_line(
        "xs", "ys", source=table, line_width="width", line_color={"field": "value", "transform": mapper}
    )
    if top > 0.0:
        bar = ColorBar(color_mapper=mapper, width=10, title="%", padding=2, major_label_text_font_size="11px")
        fig.add_layout(bar, "right")
    else:
        fig.title.text = "stiffness loss: 0 in every element"
        fig.title.text_font_style = "normal"
    return [lines]


def _lines(paths: list[FloatArray], some: list[int]) -> Any:
    from bokeh.models import ColumnDataSource

    return ColumnDataSource(
        {"xs": [paths[i][:, 0].tolist() for i in some], "ys": [paths[i][:, 1].tolist() for i in some]}
    )


def _palette() -> list[str]:
    """The scale of the static pictures, in 64 steps."""
    knots = np.array([[int(c[i : i + 2], 16) for i in (1, 3, 5)] for c in SCALE], dtype=np.float64)
    at = np.linspace(0.0, len(SCALE) - 1.0, 64)
    rgb = np.stack([np.interp(at, np.arange(len(SCALE)), knots[:, c]) for c in range(3)], axis=1)
    return ["#" + "".join(f"{int(round(v)):02X}" for v in each) for each in rgb]


def _held(fig: Any, model: FrameModel, points: FloatArray) -> None:
    """Where the frame is held and what it carries."""
    for nodes, marker, size, label in (
        (sorted({node for node, _ in model.fixed}), "square", 13, "fixed, wholly or partly"),
        (sorted({m.node for m in model.point_masses}), "circle", 12, "point mass"),
        (sorted({s.node for s in model.ground_springs}), "inverted_triangle", 11, "spring to ground"),
    ):
        if nodes:
            fig.scatter(
                points[nodes, 0], points[nodes, 1], marker=marker, size=size, fill_color="white",
                line_color="black", line_width=1.5, legend_label=label,
            )  # fmt: skip
    for spring in model.node_springs:
        a, b = points[spring.node], points[spring.other]
        fig.line(
            [a[0], b[0]],
            [a[1], b[1]],
            color=GREY,
            line_dash="dotted",
            line_width=2,
            legend_label="node spring",
        )


def _across(path: FloatArray, away: float) -> FloatArray:
    along = path[-1] - path[0]
    return away * np.array([-along[1], along[0]]) / max(float(np.linalg.norm(along)), 1e-300)


def _texts(fig: Any, places: list[Any], colour: str, *, offset: int = 0, italic: bool = False) -> None:
    table = columns(
        x=[float(p[0]) for p in places], y=[float(p[1]) for p in places], text=[p[2] for p in places]
    )
    fig.text(
        "x", "y", "text", source=table, y_offset=-offset, x_offset=0 if not offset else 6, text_color=colour,
        text_align="center", text_baseline="middle", text_font_size="11px",
        text_font_style="italic" if italic else "normal",
    )  # fmt: skip


def _arrows(
    fig: Any, arrows: list[Any], colour: str, label: str, says: list[str], *, to: bool = False
) -> None:
    """Arrows (x, y, along x, along y), from there or, with ``to``, ending there."""
    if not arrows:
        return
    from bokeh.models import Arrow, NormalHead

    x, y, dx, dy = (np.array([each[i] for each in arrows], dtype=np.float64) for i in range(4))
    x0, y0 = (x - dx, y - dy) if to else (x - 0.5 * dx, y)
    table = columns(x0=x0, y0=y0, x1=x0 + dx, y1=y0 + dy, says=says)
    shaft = fig.segment(
        "x0", "y0", "x1", "y1", source=table, color=COLOURS[colour], line_width=2 if label != "force" else 3,
        legend_label=label,
    )  # fmt: skip
    fig.add_layout(
        Arrow(
            end=NormalHead(size=9, fill_color=COLOURS[colour], line_color=COLOURS[colour]),
            x_start="x0",
            y_start="y0",
            x_end="x1",
            y_end="y1",
            source=table,
            line_alpha=0.0,
        )  # fmt: skip
    )
    hover(fig, [shaft], {label.capitalize(): "@says"})
