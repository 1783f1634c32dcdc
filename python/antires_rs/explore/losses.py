"""Stiffness losses by element, with intervals, probabilities and what would have been seen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..damage.percent import percent, span
from ..plotting.damage import LEAST_PERCENT, MOST_VISIBLE, element_names
from ..plotting.judged import alternatives
from .canvas import COLOURS, below, columns, hover, paper

if TYPE_CHECKING:
    from ..damage.result import DamageResult
    from ..support.validation import FloatArray

__all__ = ["losses_figure"]

#: From so many elements on their names stand upright.
UPRIGHT = 7


def losses_figure(result: DamageResult, truth: Mapping[int, float] | None = None) -> Any:
    """Bars of the losses found; hovering an element tells all that is known of it.

    Parameters
    ----------
    result : DamageResult
    truth : mapping of int to float, optional
        True loss by element, where it is known.

    Returns
    -------
    bokeh.plotting.figure
    """
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
