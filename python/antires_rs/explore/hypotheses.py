"""Probabilities of what may explain the measurement."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..damage.percent import loss, percent
from .canvas import COLOURS, columns, hover, paper

if TYPE_CHECKING:
    from ..damage.hypotheses import Hypotheses, Hypothesis

__all__ = ["hypotheses_figure"]

#: Hypotheses drawn in any case, those above this probability, and how many at most.
LEAST_ROWS, WORTH_A_ROW, MOST_ROWS = 3, 0.005, 12


def hypotheses_figure(hypotheses: Hypotheses) -> Any:
    """One bar a hypothesis, the most probable on top; hovering tells the losses with their intervals.

    Parameters
    ----------
    hypotheses : Hypotheses
        ``result.hypotheses``.

    Returns
    -------
    bokeh.plotting.figure
    """
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
