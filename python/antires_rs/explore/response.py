"""Measured curves beside those of the model, before and after."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..plotting.responses import curves_db
from ..plotting.transmissibility import named, summed_db
from ..signals.frequency_response import FrequencyResponse
from .canvas import COLOURS, FONT, below, columns, hover, paper

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel
    from ..support.validation import FloatArray

__all__ = ["response_figure"]

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
    """FRFs response by response, or transmissibilities summed, of the measurement and of the model.

    Parameters
    ----------
    measured : FrequencyResponse
    before, after : StructuralModel
    excitation : int
        Dof of the force.
    names : (str, str)
        What the two models are called.

    Returns
    -------
    bokeh.plotting.figure
        Of FRFs the first response is shown; a click on the name of another shows it too.
    """
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
