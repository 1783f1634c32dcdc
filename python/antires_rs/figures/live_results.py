"""All figures of a result, by the names that its pictures have too."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..damage.assess import DamageResult
from ..damage.hypotheses import loss, percent, span
from ..damage.words import without_idle
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..signals.frequency_response import FrequencyResponse
from .canvas import COLOURS, GREY, SCALE, reach
from .damage import LEAST_PERCENT, MOST_VISIBLE, alternatives, element_names
from .live_canvas import DASHES, FONT, below, columns, hover, paper
from .responses import curves_db, named, summed_db
from .structure import ISOMETRIC, ROTATIONS, SHADES, _seen, spring_paths

if TYPE_CHECKING:
    from ..damage.assess import DamageResult
    from ..damage.hypotheses import Hypotheses, Hypothesis
    from ..models.frame import FrameModel
    from ..models.structural_model import StructuralModel
    from ..signals.frequency_response import FrequencyResponse
    from ..support.checks import FloatArray
    from ..updating.result import UpdateResult
    from ..updating.tables import FrequencyTable, ModalTable


# -- Stiffness losses by element, with intervals, probabilities and what would have been seen


#: From so many elements on their names stand upright.
UPRIGHT = 7


def losses_figure(result: DamageResult, truth: Mapping[int, float] | None = None) -> Any:
    """Bars of the losses found; hovering an element tells all that is known of it."""
    from bokeh.models import FactorRange

    names = element_names(result)
    loss = 100.0 * np.asarray(result.x)
    nowhere = np.full(loss.size, np.nan)
    visible = 100.0 * np.array([result.detectable[e] for e in result.elements])
    known = nowhere if truth is None else 100.0 * np.array([truth.get(e, np.nan) for e in result.elements])
    low, high, instead, said = nowhere, nowhere, nowhere, {}
    if result.has_baseline:
        low, high = 100.0 * np.array(list(result.interval.values())).T
        instead = alternatives(result.assessment, result.elements)
        said = {
            "probability": [percent(p) for p in result.probability.values()],
            "interval": [span(a, b) + " %" if b > 0.0 else "-" for a, b in result.interval.values()],
        }
    everything = np.concatenate([loss, known, high, instead, np.minimum(visible, MOST_VISIBLE)])
    top = max(LEAST_PERCENT, 1.12 * float(np.nanmax(everything[np.isfinite(everything)], initial=0.0)))
    fig = paper(
        "Candidate element (no bar: exactly 0)",
        "Stiffness loss (%)",
        height=400 if len(names) > UPRIGHT else 360,
        x_range=FactorRange(factors=names),
        y_range=(0.0, top),
        name="damage",
    )
    seen = [f"{value:.1f} %" if np.isfinite(value) else "none would be seen" for value in visible]
    table = columns(
        name=names,
        loss=loss,
        low=low,
        high=high,
        instead=instead,
        top=np.full(loss.size, top),
        seen=seen,
        truth=known,
        **said,
    )
    columns_of = fig.vbar(x="name", top="top", width=1.0, source=table, fill_alpha=0.0, line_alpha=0.0)
    _not_seen(fig, names, visible, top)
    if np.isfinite(instead).any():
        fig.vbar(
            x="name",
            top="instead",
            width=0.62,
            source=table,
            fill_alpha=0.0,
            line_color="black",
            line_dash="dashed",
            legend_label="what else it may be",
        )
    fig.vbar(
        x="name",
        top="loss",
        width=0.62,
        source=table,
        color=COLOURS["blue"],
        line_color="black",
        legend_label="found",
    )
    _smallest_seen(fig, names, visible, top)
    if (high > 0.0).any():
        _intervals(fig, [n for n, h in zip(names, high, strict=True) if h > 0.0], low, high)
    if truth is not None:
        fig.scatter(
            "name",
            "truth",
            source=table,
            marker="diamond",
            size=13,
            fill_alpha=0.0,
            line_color="black",
            line_width=1.6,
            legend_label="truth",
        )
    says = {"Element": "@name", "Stiffness loss": "@loss{0.0} %"}
    says |= {"90 % interval": "@interval", "Probability": "@probability"} if said else {}
    says |= {"Smallest that would be seen": "@seen"} | ({"Truth": "@truth{0.0} %"} if truth else {})
    hover(fig, [columns_of], says)
    if len(names) > UPRIGHT:
        fig.xaxis.major_label_orientation = np.pi / 2
    fig.xgrid.grid_line_color = None
    below(fig)
    return fig


def _intervals(fig: Any, names: list[str], low: FloatArray, high: FloatArray) -> None:
    """90 % intervals as whiskers of the elements that have one."""
    some = high > 0.0
    table = columns(name=names, low=low[some], high=high[some])
    look = {"source": table, "color": "black", "line_width": 1.6, "legend_label": "90 % interval"}
    fig.segment("name", "low", "name", "high", **look)
    for end in ("low", "high"):
        fig.scatter("name", end, marker="dash", size=13, **look)


def _smallest_seen(fig: Any, names: list[str], visible: FloatArray, top: float) -> None:
    """Ticks across at the smallest losses seen; triangles at the top where they lie above the axis."""
    on = visible <= 0.98 * top
    above = np.isfinite(visible) & ~on
    colour = COLOURS["vermillion"]
    if on.any():
        fig.scatter(
            "name",
            "seen",
            source=columns(name=_some(names, on), seen=visible[on]),
            marker="dash",
            size=22,
            color=colour,
            line_width=2,
            legend_label="smallest damage that would be seen",
        )
    if above.any():
        table = columns(
            name=_some(names, above),
            seen=np.full(int(above.sum()), 0.97 * top),
            label=[f"{value:.0f}" for value in visible[above]],
        )
        fig.scatter(
            "name",
            "seen",
            source=table,
            marker="triangle",
            size=8,
            color=colour,
            legend_label="seen only from this loss on, in %",
        )
        fig.text(
            "name",
            "seen",
            "label",
            source=table,
            y_offset=8,
            text_align="center",
            text_baseline="top",
            text_font_size="10px",
        )


def _not_seen(fig: Any, names: list[str], visible: FloatArray, top: float) -> None:
    """Elements whose damage no value would show."""
    none = ~np.isfinite(visible)
    if none.any():
        fig.vbar(
            x=_some(names, none),
            top=top,
            width=1.0,
            fill_color="white",
            line_alpha=0.0,
            hatch_pattern="dot",
            hatch_color="#BFBFBF",
            hatch_scale=8,
            legend_label="no damage could be seen",
        )


def _some(names: list[str], which: Any) -> list[str]:
    return [name for name, one in zip(names, which, strict=True) if one]


# -- Probabilities of what may explain the measurement


#: Hypotheses drawn in any case, those above this probability, and how many at most.
LEAST_ROWS, WORTH_A_ROW, MOST_ROWS = 3, 0.005, 12


def hypotheses_figure(hypotheses: Hypotheses) -> Any:
    """One bar a hypothesis, the most probable on top; hovering tells the losses with their intervals."""
    from bokeh.models import FactorRange

    rows = [
        one
        for nth, one in enumerate(hypotheses[:MOST_ROWS])
        if nth < LEAST_ROWS or one.probability >= WORTH_A_ROW
    ]
    names = [hypotheses.called(one) for one in rows]
    values = [one.probability for one in rows]
    says = [_losses(one) for one in rows]
    looks = [_look(one) for one in rows]
    others = len(hypotheses) - len(rows)
    if others:
        names.append(f"{others} other{'s' if others > 1 else ''} together")
        values.append(float(np.sum(hypotheses.probability[len(rows) :])))
        says.append("-")
        looks.append(("#BFBFBF", " "))
    fig = paper(
        "Probability (-)",
        "",
        height=90 + 34 * len(names),
        x_range=(0.0, 1.28),
        y_range=FactorRange(factors=names[::-1]),
        name="hypotheses",
    )
    table = columns(
        name=names,
        probability=np.array(values),
        shown=[
            f"{p:.3f}" if 0.0005 <= p <= 0.9995 else ("< 0.001" if p < 0.5 else "> 0.999") for p in values
        ],
        losses=says,
        percent=[percent(p) for p in values],
        fill=[fill for fill, _ in looks],
        hatch=[hatch for _, hatch in looks],
    )
    bars = fig.hbar(
        y="name",
        right="probability",
        height=0.66,
        source=table,
        fill_color="fill",
        line_color="black",
        hatch_pattern="hatch",
        hatch_color="#555555",
    )
    fig.text(
        "probability",
        "name",
        "shown",
        source=table,
        x_offset=6,
        text_baseline="middle",
        text_font_size="12px",
    )
    hover(
        fig, [bars], {"Explanation": "@name", "Probability": "@percent", "Stiffness loss (90 %)": "@losses"}
    )
    fig.ygrid.grid_line_color = None
    fig.xaxis.ticker = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
    return fig


def _losses(one: Hypothesis) -> str:
    return ", ".join(loss(*each, " %") for each in zip(one.severities, one.low, one.high, strict=True)) or "-"


def _look(one: Hypothesis) -> tuple[str, str]:
    """Fill and hatch: damage of candidates, no damage, what none of them explains."""
    if not one.candidate:
        return "white", "right_diagonal_line"
    return (COLOURS["blue"] if one.elements else "white"), " "


# -- Measured values beside those of the model: differences of each, before and after


#: Space between two responses, in widths of a value.
GAP = 0.8


def differences_figure(
    table: FrequencyTable | ModalTable, names: tuple[str, str] = ("before updating", "after updating")
) -> Any:
    """Bars of the difference of each frequency to the measured one in %, before and after."""
    modal = hasattr(table, "before_mac")
    of, starts = _groups(table, modal)
    x = np.arange(of.size) + GAP * (np.cumsum(starts) - 1)
    both = np.concatenate([table.before_percent, table.after_percent])
    most = reach(both)
    both = both[np.isfinite(both)]
    low, high = (
        float(np.clip(end, -most, most)) for end in (min(both.min(initial=0), 0), max(both.max(initial=0), 0))
    )
    room = 0.12 * max(high - low, 1e-6)
    fig = paper(
        f"{'Resonances' if modal else 'Antiresonances'}, by {'test' if modal else 'response'}, ascending",
        "Difference to the measurement (%)",
        height=360,
        x_range=(float(x[0]) - 0.9, float(x[-1]) + 0.9) if x.size else (0.0, 1.0),
        y_range=(low - (room if low < 0 else 0.02 * room), high + room),
        name="differences",
    )
    says = {"Of": "@of", "Measured": "@measured{0.000} Hz", "Model": "@model{0.000} Hz"}
    says |= {"Difference": "@difference{+0.00} %"} | ({"MAC": "@mac{0.000}"} if modal else {})
    for side, (state, name, colour) in enumerate(
        zip(("before", "after"), names, (COLOURS["vermillion"], COLOURS["blue"]), strict=True)
    ):
        percent = np.asarray(getattr(table, f"{state}_percent"))
        values = {
            "x": x + (-0.2, 0.2)[side],
            "difference": percent,
            "of": of.tolist(),
            "measured": table.measured_hz,
            "model": getattr(table, f"{state}_hz"),
        } | ({"mac": getattr(table, f"{state}_mac")} if modal else {})
        look: dict[str, Any] = {"fill_color": colour if side else "white", "line_color": colour}
        look |= (
            {} if side else {"hatch_pattern": "right_diagonal_line", "hatch_color": colour, "hatch_scale": 6}
        )
        _state(fig, values, percent, name, look, says, (low, high))
    _names_above(fig, x, of, starts, modal)
    fig.xaxis.major_label_text_font_size = "0px"
    fig.xaxis.major_tick_line_color = None
    fig.xgrid.grid_line_color = None
    below(fig, side_by_side=1)  # entries that name the largest are long
    return fig


def _state(
    fig: Any,
    values: dict[str, Any],
    percent: FloatArray,
    name: str,
    look: dict[str, Any],
    says: dict[str, str],
    ends: tuple[float, float],
) -> None:
    """The bars of one state, crosses where there is no partner, triangles for what lies beyond."""
    there = np.isfinite(percent)
    label = f"{name}, largest {np.abs(percent[there]).max():.2f} %" if there.any() else f"{name}, no partner"
    bars = fig.vbar(
        x="x", top="difference", width=0.38, source=_rows(values, there), legend_label=label, **look
    )
    drawn = [bars]
    if not there.all():
        lost = _rows(values | {"zero": np.zeros(percent.size)}, ~there)
        cross = fig.scatter(
            "x", "zero", source=lost, marker="x", size=9, line_width=2, color=look["line_color"],
            legend_label=f"{name}: no partner ({int(np.sum(~there))})",
        )  # fmt: skip
        drawn.append(cross)
    hover(fig, drawn, {"": name} | says)
    for up in (True, False):
        end = ends[1] if up else ends[0]
        beyond = there & ((percent > end) if up else (percent < end))
        if beyond.any():
            marks = _rows(values, beyond)
            marks.data["edge"] = np.full(int(beyond.sum()), end, dtype=np.float32)
            marks.data["label"] = [f"{value:+.0f} %" for value in percent[beyond]]
            fig.scatter(
                "x", "edge", source=marks, size=10, color=look["line_color"], line_color="white",
                marker="triangle" if up else "inverted_triangle", legend_label="beyond the axis",
            )  # fmt: skip
            # Upright, so that neighbours do not run into each other.
            fig.text(
                "x",
                "edge",
                "label",
                source=marks,
                angle=np.pi / 2,
                text_align="right" if up else "left",
                y_offset=9 if up else -9,
                text_baseline="middle",
                text_font_size="11px",
                background_fill_color="white",
            )


def _rows(values: dict[str, Any], which: Any) -> Any:
    picked = {
        name: np.asarray(column, dtype=object if name == "of" else None)[which]
        for name, column in values.items()
    }
    return columns(**(picked | {"of": picked["of"].tolist()}))


def _groups(table: Any, modal: bool) -> tuple[Any, Any]:
    """What each value is of, and where a group begins."""
    if modal:
        mode = np.asarray(table.mode)
        return np.array([f"mode {each}" for each in mode], dtype=object), np.r_[True, mode[1:] <= mode[:-1]][
            : mode.size
        ]
    dof, force = np.asarray(table.dof), np.asarray(table.excitation)

    def called(number: int) -> str:
        return str(table.dof_names.get(number, f"dof {number}"))

    several = np.unique(force).size > 1
    of = [
        called(int(d)) + (f", force at {called(int(k))}" if several else "")
        for d, k in zip(dof, force, strict=True)
    ]
    starts = np.r_[True, (dof[1:] != dof[:-1]) | (force[1:] != force[:-1])][: dof.size]
    return np.array(of, dtype=object), starts


def _names_above(fig: Any, x: FloatArray, of: Any, starts: Any, modal: bool) -> None:
    """Lines between the groups, and the name of each along the lower edge, upright."""
    from bokeh.core.properties import value
    from bokeh.models import LabelSet, Span

    firsts = np.flatnonzero(starts)
    for first in firsts[1:]:
        fig.add_layout(
            Span(location=float(x[first]) - 0.5 - GAP / 2, dimension="height", line_color="#BFBFBF")
        )
    if modal:
        return
    table = columns(x=x[firsts] - 0.45, name=[str(of[first]) for first in firsts])
    fig.add_layout(
        LabelSet(
            x="x",
            y=value(4),
            y_units="screen",
            text="name",
            source=table,
            angle=np.pi / 2,
            text_baseline="top",
            text_font_size=value("10px"),
            text_color="#444444",
        )
    )


# -- Measured curves beside those of the model, before and after


#: Colour, dash and width of the measured curve and of the two states of the model.
LOOKS: tuple[tuple[str, Any, float], ...] = (
    ("#B0B0B0", "solid", 3.4),
    (COLOURS["vermillion"], "dashed", 1.5),
    (COLOURS["blue"], "solid", 1.5),
)
#: Lines that a curve is drawn with at most: more than a screen has pixels.
MOST_LINES = 2500


def response_figure(
    measured: FrequencyResponse,
    before: StructuralModel,
    after: StructuralModel,
    excitation: int,
    names: tuple[str, str] = ("before updating", "after updating"),
) -> Any:
    """FRFs response by response, or transmissibilities summed, of the measurement and of the model."""
    three = ("measured", f"model {names[0]}", f"model {names[1]}")
    if measured.kind == "transmissibility":
        over = named(before, measured.reference)
        freq, levels = summed_db(measured, (before, after), excitation)
        fig = paper("Frequency (Hz)", f"Sum of T over {over} (dB re 1)", height=340, name="response")
        _three(fig, freq, [level[None] for level in levels], 0, three, legend=True)
        below(fig)
        return fig
    freq, levels = curves_db(measured, (before, after), excitation)
    fig = paper("Frequency (Hz)", "FRF (dB re unit of the data)", height=380, name="response")
    shown = {}
    for row, dof in enumerate(measured.dofs):
        lines = _three(fig, freq, levels, row, three, legend=False)
        for line in lines:
            line.visible = row == 0
        shown[before.dof_label(dof)] = lines
    _legends(fig, shown, three)
    return fig


def _three(
    fig: Any, freq: FloatArray, levels: Any, row: int, names: tuple[str, ...], *, legend: bool
) -> list[Any]:
    """Measured, before and after, of one response; the lines drawn."""
    step = max(1, -(-freq.size // MOST_LINES))
    drawn = []
    table = columns(freq=_thinned(freq, step, np.mean))
    for i, (level, (colour, dash, width)) in enumerate(zip(levels, LOOKS, strict=True)):
        # Of lines that share a pixel the one that counts is kept: the dip of an FRF, the peak of a sum.
        table.data[f"level_{i}"] = _thinned(level[row], step, np.max if legend else np.min).astype(np.float32)
        drawn.append(
            fig.line(
                "freq",
                f"level_{i}",
                source=table,
                color=colour,
                line_dash=dash,
                line_width=width,
                **({"legend_label": names[i]} if legend else {}),
            )
        )
    says = {"Frequency": "@freq{0.000} Hz"} | {name: f"@level_{i}{{0.0}} dB" for i, name in enumerate(names)}
    hover(fig, drawn[:1], says, mode="vline")
    return drawn


def _thinned(values: FloatArray, step: int, how: Any) -> FloatArray:
    whole = values[: values.size // step * step]
    return np.asarray(how(whole.reshape(-1, step), axis=1), dtype=np.float64)


def _legends(fig: Any, shown: dict[str, list[Any]], names: tuple[str, ...]) -> None:
    """One that tells the lines apart, and one whose entries show and hide a response."""
    from bokeh.models import Legend, LegendItem

    samples = [
        fig.line([np.nan], [np.nan], color=colour, line_dash=dash, line_width=width)
        for colour, dash, width in LOOKS
    ]
    look = {
        "border_line_color": None,
        "padding": 0,
        "margin": 0,
        "spacing": 10,
        "location": "left",
        "label_text_font": FONT,
        "label_text_font_size": "12px",
    }
    what = [LegendItem(label=name, renderers=[one]) for name, one in zip(names, samples, strict=True)]
    which = [LegendItem(label=name, renderers=lines) for name, lines in shown.items()]
    fig.add_layout(Legend(items=what, ncols=2, **look), "below")
    fig.add_layout(
        Legend(items=which, ncols=4, click_policy="hide", title="click to show or hide", **look), "below"
    )


# -- The structure: elements, nodes, sensors and force, and what each element has lost


#: Up to so many nodes and elements are numbered without hovering.
MOST_NUMBERS = 60


def structure_figure(
    model: MassSpringChain | FrameModel,
    loss_percent: Mapping[int, float] | None = None,
    sensors: Sequence[Any] = (),
    excitation: Any = None,
) -> Any:
    """A chain or a frame; hovering tells elements, nodes and sensors."""
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


# -- How a search went: best objective of each island


#: Points that a curve is drawn with at most.
MOST_POINTS = 1500


def convergence_figure(result: UpdateResult) -> Any:
    """Best J of each island against the evaluations of all."""
    history = result.history
    cost, nfev = np.asarray(history.cost), np.asarray(history.nfev, dtype=np.float64)
    kept = np.unique(np.linspace(0, len(nfev) - 1, min(len(nfev), MOST_POINTS)).round().astype(int))
    log = bool(np.isfinite(cost).all() and cost.min() > 0.0 and cost.max() > 3.0 * cost.min())
    fig = paper(
        "Evaluations of all islands (-)", "Best objective J (-)", height=340, y_log=log, name="convergence"
    )
    fig.xaxis.formatter.use_scientific = False
    colours = list(COLOURS.values())
    table = columns(nfev=nfev[kept], **{f"island_{i}": cost[kept, i] for i in range(cost.shape[1])})
    for i in range(cost.shape[1]):
        line = fig.step(
            "nfev",
            f"island_{i}",
            source=table,
            mode="after",
            color=colours[i % len(colours)],
            line_dash=DASHES[i % len(DASHES)],
            line_width=max(3.0 - 0.5 * i, 1.2),
            legend_label=f"island {i}",
        )
        says = {"": f"island {i}", "Evaluations": "@nfev{0,0}", "J": f"@island_{i}{{0.000000e+0}}"}
        hover(fig, [line], says)
    at = nfev[np.minimum(np.asarray(history.migrations, dtype=np.int64), len(nfev) - 1)]
    if at.size:
        table = columns(nfev=at, y=np.full(at.size, cost.min() if log else cost.min()))
        fig.scatter(
            "nfev",
            "y",
            source=table,
            marker="dash",
            angle=np.pi / 2,
            size=10,
            color="black",
            legend_label=f"exchange ({at.size} in all)",
        )
    below(fig)
    return fig


def result_figures(
    result: UpdateResult, response: FrequencyResponse | None = None, truth: Mapping[int, float] | None = None
) -> dict[str, Any]:
    """All figures of a result that there are, by name."""
    problem, model = result.problem, result.problem.model
    damage = isinstance(result, DamageResult)
    names = ("without damage", "with the damage found") if damage else ("before updating", "after updating")
    first = problem.measured[0]
    figures: dict[str, Any] = {}
    loss = None
    if isinstance(result, DamageResult):
        loss = {element: 100.0 * beta for element, beta in result.severity.items()}
        figures["damage"] = losses_figure(result, truth)
        if result.has_baseline:
            figures["hypotheses"] = hypotheses_figure(without_idle(result.assessment).hypotheses)
    if isinstance(model, MassSpringChain | FrameModel):
        at = (list(first), first.excitation) if isinstance(first, AntiresonanceSet) else ((), None)
        figures["model"] = structure_figure(model, loss, *at)
    if result.table.measured_hz.size:
        figures["differences"] = differences_figure(result.table, names)
    if response is not None and isinstance(first, AntiresonanceSet):
        figures["response"] = response_figure(response, model, result.model, first.excitation, names)
    if result.history.cost.size:
        figures["convergence"] = convergence_figure(result)
    return figures
