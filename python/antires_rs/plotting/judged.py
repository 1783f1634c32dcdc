"""What a bar chart of losses shows where hypotheses were judged: intervals, probabilities, alternatives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.validation import FloatArray

if TYPE_CHECKING:
    from ..damage.assessment import Assessment
    from ..damage.result import DamageResult

__all__ = ["alternatives", "draw_alternatives", "draw_intervals", "draw_probabilities", "verdict"]

#: From this probability on an element that was not declared has a bar of its own.
_WORTH_A_BAR = 0.02


def alternatives(found: Assessment, elements: list[int]) -> FloatArray:
    """Losses in % of elements that may be the damaged ones instead, NaN elsewhere."""
    losses = np.full(len(elements), np.nan)
    for one in found.hypotheses:
        if not one.candidate or one.probability < _WORTH_A_BAR:
            continue
        for element, severity in zip(one.elements, one.severities, strict=True):
            at = elements.index(element)
            if element not in found.declared and np.isnan(losses[at]):
                losses[at] = 100.0 * severity
    return losses


def draw_alternatives(ax: Any, x: FloatArray, losses: FloatArray) -> None:
    """Empty bars behind the others."""
    some = np.isfinite(losses)
    if some.any():
        ax.bar(
            x[some],
            losses[some],
            width=0.62,
            facecolor="none",
            edgecolor="black",
            linewidth=0.9,
            linestyle="--",
            label="what else it may be",
        )


def draw_intervals(ax: Any, x: FloatArray, loss: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """90 % intervals of the bars."""
    some = high > 0.0
    if some.any():
        reach = np.maximum([loss[some] - low[some], high[some] - loss[some]], 0.0)
        ax.errorbar(
            x[some],
            loss[some],
            reach,
            fmt="none",
            ecolor="black",
            elinewidth=1.4,
            capsize=5,
            capthick=1.4,
            zorder=4,
            label="90 % interval",
        )


def draw_probabilities(ax: Any, x: FloatArray, probability: FloatArray, upright: bool) -> None:
    """A row of numbers over the axes, from the probable down to what is left out as below 0.5 %."""
    for at, p in zip(x, probability, strict=True):
        shown = _percent(p)
        ax.annotate(
            shown,
            (at, 1.0),
            xycoords=ax.get_xaxis_transform(),
            xytext=(0, 4),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize="x-small" if upright else "small",
            fontweight="bold" if p >= 0.5 else "normal",
            color="black" if p >= 0.005 else "#6E6E6E",
        )
    ax.set_title("Probability that it is damaged (%)", fontsize="small", loc="left", pad=18)


def verdict(result: DamageResult) -> str:
    """Why there is no bar."""
    elsewhere = result.probability_elsewhere
    if not result.assessment.best.candidate:
        return f"something has changed that no candidate explains\n(probability {_percent(elsewhere)} %)"
    changed = _percent(result.probability_of_damage)
    return f"no damage declared\n(probability that anything has changed: {changed} %)"


def _percent(p: float) -> str:
    """In whole percent; what is nearly 0 or 1 is not rounded to it."""
    return "<1" if p < 0.005 else ">99" if p > 0.995 else f"{100 * p:.0f}"
