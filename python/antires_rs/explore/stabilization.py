"""Stabilization diagram to be zoomed into and clicked on: model order against frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..plotting.stabilization import CURVE, pole_table
from .canvas import COLOURS, below, columns, hover, paper
from .marks import draw_marks, mark_columns

if TYPE_CHECKING:
    from ..order_sweep.diagram import StabilizationDiagram

__all__ = ["stabilization_figure"]


def stabilization_figure(
    diagram: StabilizationDiagram,
    zeros: AntiresonanceSet | None = None,
    dof: Any = 0,
    *,
    height: int = 400,
    x_range: Any = None,
    every_kind: bool = False,
) -> Any:
    """Poles of every order, the stable ones, the values, and the summed curve behind them.

    Parameters
    ----------
    diagram : StabilizationDiagram
    zeros, dof : AntiresonanceSet, int or str, optional
        The values marked are those of the set, with what was dropped and added by hand; by default those
        that the diagram accepts.
    height : int
        In pixels.
    x_range : range of another figure, optional
        To tie the two together.
    every_kind : bool
        Have a place for values of every kind, for pages in which they change.

    Returns
    -------
    bokeh.plotting.figure

    Raises
    ------
    MissingDependencyError
        bokeh is not installed.
    """
    order, freq, damping, stable = pole_table(diagram)
    first, last = float(diagram.orders[0]), float(diagram.orders[-1])
    fig = paper(
        "Frequency (Hz)",
        "Model order (-)",
        height=height,
        x_range=diagram.band_hz if x_range is None else x_range,
        y_range=(first - 1.5, last + 1.0),
        name="stabilization",
    )
    _curve_behind(fig, diagram)
    if zeros is None:
        zeros = AntiresonanceSet.from_tables(dof, {dof: diagram.accepted})
    draw_marks(fig, mark_columns(zeros, dof, diagram.band_hz), labels=True, every_kind=every_kind)
    drawn = [
        fig.scatter(
            "freq",
            "order",
            source=_poles(order, freq, damping, ~stable),
            marker="x",
            size=5,
            color=COLOURS["orange"],
            legend_label="pole, not stable",
        ),
        fig.scatter(
            "freq",
            "order",
            source=_poles(order, freq, damping, stable),
            marker="circle",
            size=5,
            color=COLOURS["blue"],
            legend_label="stable pole",
        ),
    ]
    hover(
        fig, drawn, {"Frequency": "@freq{0.000} Hz", "Model order": "@order", "Damping": "@damping{0.00} %"}
    )
    left = diagram.left_out
    if len(left):
        why = left.scores.get("why", np.full(len(left), ""))
        table = columns(freq=left.freq_hz, order=np.full(len(left), last + 0.2), why=why.tolist())
        seen = fig.scatter(
            "freq",
            "order",
            source=table,
            marker="inverted_triangle",
            size=9,
            fill_color="white",
            line_color=COLOURS["black"],
            legend_label="seen, not accepted",
        )
        hover(fig, [seen], {"Seen, not accepted": "@freq{0.000} Hz", "Why": "@why"})
    below(fig)
    return fig


def _poles(order: Any, freq: Any, damping: Any, which: Any) -> Any:
    return columns(freq=freq[which], order=order[which].astype(np.float32), damping=100.0 * damping[which])


def _curve_behind(fig: Any, diagram: StabilizationDiagram) -> None:
    """The summed curves, pale, on a logarithmic axis of their own at the right."""
    from bokeh.models import LinearAxis, LogAxis, LogScale, Range1d

    size = np.asarray(diagram.background, dtype=np.float64)
    there = np.isfinite(size) & (size > 0.0)
    if not there.any():
        return
    low, high = float(size[there].min()), float(size[there].max())
    fig.extra_y_ranges = {"curve": Range1d(0.7 * low, 1.4 * high)}
    fig.extra_y_scales = {"curve": LogScale()}
    axis: LinearAxis = LogAxis(
        y_range_name="curve",
        axis_label="Summed curves (unit of the data)",
        axis_label_text_font_style="normal",
        axis_label_text_color="#595959",
        major_label_text_color="#595959",
        axis_label_text_font_size="12px",
    )
    fig.add_layout(axis, "right")
    fig.line(
        "freq",
        "size",
        source=columns(freq=diagram.background_freq_hz, size=np.where(there, size, np.nan)),
        y_range_name="curve",
        color=CURVE,
        line_width=1.2,
        legend_label="summed curves, peaks at poles",
    )
