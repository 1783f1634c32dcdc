"""All figures of a result to be explored, by the names that its pictures have too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..damage.result import DamageResult
from ..damage.words import without_idle
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.chain import MassSpringChain
from ..models.frame import FrameModel
from ..signals.frequency_response import FrequencyResponse
from .damage import losses, probabilities
from .live_canvas import FONT, dash_of, explored
from .marks import Axis, Line, Panel
from .responses import LOOKS, curve_names, curves_db, transmissibilities
from .structure import chain, frame, seen_points
from .updating import convergence, differences

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel
    from ..support.checks import FloatArray
    from ..updating.result import UpdateResult

#: From so many elements on their names stand upright.
UPRIGHT = 7
#: Masses of a chain that are numbered, and the width of a figure in points, roughly.
MOST_NUMBERS, WIDE_PT = 24, 600.0
#: Lines that a curve is drawn with at most: more than a screen has pixels.
MOST_LINES = 2500


def result_figures(
    result: UpdateResult, response: FrequencyResponse | None = None, truth: Mapping[int, float] | None = None
) -> dict[str, Any]:
    """All figures of a result that there are."""
    problem, model = result.problem, result.problem.model
    damage = result if isinstance(result, DamageResult) else None
    names = ("without damage", "with the damage found") if damage else ("before updating", "after updating")
    first = problem.measured[0]
    figures: dict[str, Any] = {}
    loss = None
    if damage is not None:
        loss = {element: 100.0 * beta for element, beta in damage.severity.items()}
        upright = len(damage.elements) > UPRIGHT
        figures["damage"] = explored(losses(damage, truth, upright), height=400 if upright else 360)
        if damage.has_baseline:
            panel = probabilities(without_idle(damage.assessment).hypotheses)
            figures["hypotheses"] = explored(panel, height=90 + 40 * len(panel.y.names or ()))
    seen = first if isinstance(first, AntiresonanceSet) else None
    sensors, force = ([], None) if seen is None else (list(seen), seen.excitation)
    if isinstance(model, MassSpringChain):
        every = -(-model.n_dof // MOST_NUMBERS)
        panel = chain(model, loss, sensors, force, "Stiffness loss (%)", WIDE_PT, every)
        figures["model"] = explored(panel, height=260)
    elif isinstance(model, FrameModel):
        wide, high = np.ptp(seen_points(model), axis=0)
        height = int(np.clip(700.0 * high / max(wide, 1e-300), 320, 620))
        beams = None if loss is None else {e: beta for e, beta in loss.items() if e < len(model.elements)}
        room = np.array([WIDE_PT, 0.7 * height])
        figures["model"] = explored(
            frame(model, beams, sensors, force, "Stiffness loss (%)", room), height=height
        )
    if result.table.measured_hz.size:
        panel = differences(result.table, names)
        figures["differences"] = explored(panel, height=360, side_by_side=1)  # entries are long
    if response is not None and isinstance(first, AntiresonanceSet):
        figures["response"] = response_figure(response, model, result.model, first.excitation, names)
    if result.history.cost.size:
        figures["convergence"] = explored(convergence(result), height=340)
    return figures


def response_figure(
    measured: FrequencyResponse,
    before: StructuralModel,
    after: StructuralModel,
    excitation: int,
    names: tuple[str, str],
) -> Any:
    """FRFs response by response, or transmissibilities summed, of the measurement and of the model."""
    if measured.kind == "transmissibility":
        panel = transmissibilities(measured, before, after, None, excitation, names=names)
        # Of lines that share a pixel the peak counts.
        return explored(replace(panel, marks=[_thinned(mark, np.max) for mark in panel.marks]), height=340)
    freq, levels = curves_db(measured, (before, after), excitation)
    called = curve_names(names, both=True)
    says = {"Frequency": "@x{0.000} Hz"} | {name: f"@level_{i}{{0.0}} dB" for i, name in enumerate(called)}
    marks = []
    for row in range(len(measured.dofs)):
        lines = [Line(freq, level[row], **look) for level, look in zip(levels, LOOKS, strict=True)]
        more = {f"level_{i}": level[row] for i, level in enumerate(levels)}
        lines[0] = replace(lines[0], says=says, more=more)
        marks += [_thinned(line, np.min) for line in lines]  # the dip counts
    x, y = Axis("Frequency (Hz)", (freq[0], freq[-1])), Axis("FRF (dB re unit of the data)")
    fig = explored(Panel("response", x, y, marks), height=380)
    drawn = [fig.renderers[3 * row : 3 * row + 3] for row in range(len(measured.dofs))]
    for line in fig.renderers[3:]:
        line.visible = False
    samples = [fig.line([np.nan], [np.nan], **_look(one)) for one in marks[:3]]
    _legend(fig, dict(zip(called, ([one] for one in samples), strict=True)), ncols=2)
    by_dof = dict(zip(map(before.dof_label, measured.dofs), drawn, strict=True))
    _legend(fig, by_dof, ncols=4, click_policy="hide", title="click to show or hide")
    return fig


def _thinned(line: Any, how: Any) -> Any:
    """A line of no more points than can be seen, the one that counts of those that share a pixel."""
    step = max(1, -(-len(line.x) // MOST_LINES))

    def few(values: FloatArray, how: Any) -> FloatArray:
        return np.asarray(how(values[: len(values) // step * step].reshape(-1, step), axis=1))

    more = {name: few(column, how) for name, column in line.more.items()}
    return replace(line, x=few(line.x, np.mean), y=few(line.y, how), more=more)


def _look(line: Any) -> dict[str, Any]:
    return {"color": line.colour, "line_dash": dash_of(line.dash), "line_width": line.width}


def _legend(fig: Any, entries: Mapping[str, list[Any]], **look: Any) -> None:
    """A legend whose entries stand for several lines each."""
    from bokeh.models import Legend, LegendItem

    items = [LegendItem(label=name, renderers=lines) for name, lines in entries.items()]
    look |= {"border_line_color": None, "padding": 0, "margin": 0, "spacing": 10, "location": "left"}
    fig.add_layout(Legend(items=items, label_text_font=FONT, label_text_font_size="12px", **look), "below")
