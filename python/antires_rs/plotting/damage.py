"""Damage: stiffness loss by element."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.validation import FloatArray, reject
from .canvas import COLOURS, below, fit_across, new_axes, offer, text_width_pt
from .judged import alternatives, draw_alternatives, draw_intervals, draw_probabilities, verdict

if TYPE_CHECKING:
    from ..damage.result import DamageResult

__all__ = ["plot_damage"]

#: The axis shows at least this much: on a finer scale nothing would look like something.
LEAST_PERCENT = 10.0
#: Smallest visible losses above this do not lengthen the axis, or small bars would vanish.
MOST_VISIBLE = 25.0


def plot_damage(result: DamageResult, ax: Any = None, truth: Mapping[int, float] | None = None) -> Any:
    """Draw the stiffness loss of each candidate element in %, with what could have been seen.

    Parameters
    ----------
    result : DamageResult
        From :func:`~antires_rs.assess_damage`.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    truth : mapping of int to float, optional
        True loss by zero-based element, where it is known; drawn as diamonds.

    Returns
    -------
    matplotlib.axes.Axes
        One bar an element. The ticks across are ``result.detectable``: damage below would come out as none; a
        triangle at the upper edge gives those that lie above the axis. A hatched background marks elements
        whose damage no value could show. Against a baseline bars have their 90 % intervals, the row above
        them is the probability of each element, and empty bars are losses of elements that may be the damaged
        ones instead.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.
    InvalidInputError
        A truth that is no mapping.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from matplotlib.figure import Figure
    >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 500.0])
    >>> measured = ar.AntiresonanceSet(0, {0: [1.9, 5.2], 1: [3.1]})
    >>> ax = ar.assess_damage(intact, measured, rng=0).plot(ax=Figure().subplots())
    >>> ax.get_ylabel()
    'Stiffness loss (%)'
    """
    if truth is not None and not isinstance(truth, Mapping):
        reject("truth", truth, "a mapping of zero-based element to loss, such as {4: 0.55}", "Pass a dict.")
    severity = 100.0 * np.asarray(result.x)
    names = element_names(result)
    ax = new_axes(ax, (max(6.0, 0.32 * len(names) + 1.5), 4.4))
    upright = not fit_across(ax, names)
    x = np.arange(len(names), dtype=np.float64)
    more = _judged(result) if result.has_baseline else {}
    nowhere = np.full(len(names), np.nan)
    high, instead = more.get("high_percent", nowhere), more.get("instead_percent", nowhere)
    draw_alternatives(ax, x, instead)
    ax.bar(x, severity, width=0.62, color=COLOURS["blue"], edgecolor="black", linewidth=0.6, label="found")
    visible = 100.0 * np.array([result.detectable[e] for e in result.elements])
    known = 100.0 * np.array([(truth or {}).get(e, np.nan) for e in result.elements])
    shown = (severity, known, high, instead, np.minimum(visible, MOST_VISIBLE))
    percent_axis(ax, np.concatenate(shown), upright)
    _smallest_seen(ax, x, visible)
    if truth is not None:
        mark_truth(ax, x, known, 8)
    if more:
        draw_intervals(ax, x, severity, more["low_percent"], high)
        draw_probabilities(ax, x, more["probability"], upright)
    _numbers(ax, severity, (severity, known, visible, high), known, upright)
    if not severity.any():
        if more:
            ax.text(0.5, 0.6, verdict(result), transform=ax.transAxes, ha="center", fontsize="medium")
        else:
            ax.set_title("no damage found", fontsize="medium")
    element_axis(ax, names, upright, first=("found", "90 % interval", "truth"))
    offer(
        ax,
        bars={
            "element": result.elements,
            "name": names,
            "loss_percent": severity,
            **({} if truth is None else {"truth_percent": known}),
            **more,
            "smallest_seen_percent": visible,
        },
    )
    return ax


def _judged(result: DamageResult) -> dict[str, FloatArray]:
    """Columns beside the losses: 90 % intervals, probabilities, losses of what may be damaged instead."""
    low, high = 100.0 * np.array(list(result.interval.values())).T
    return {
        "low_percent": low,
        "high_percent": high,
        "probability": np.array(list(result.probability.values())),
        "instead_percent": alternatives(result.assessment, result.elements),
    }


def _numbers(
    ax: Any, severity: FloatArray, marks: tuple[FloatArray, ...], known: FloatArray, upright: bool
) -> None:
    """Losses over their bars, and over marks close above, which would strike them out."""
    for i, value in enumerate(severity):
        if value > 0.0:
            reach = value + 0.12 * ax.get_ylim()[1]
            over = max(mark[i] for mark in marks if value <= mark[i] <= reach)
            diamond = abs(over - known[i]) < 0.05 * ax.get_ylim()[1]
            ax.annotate(
                f"{value:.1f} %",
                (i, over),
                xytext=(0, 8 if diamond else 3),
                ha="center",
                va="bottom",
                textcoords="offset points",
                fontsize="small",
                rotation=90 if upright else 0,
            )


def _smallest_seen(ax: Any, x: FloatArray, visible: FloatArray) -> None:
    """Ticks across at the smallest losses seen; what lies above the axis, or nowhere, is said so."""
    top = ax.get_ylim()[1]
    look = {"color": COLOURS["vermillion"], "zorder": 3}
    on = visible <= 0.98 * top
    above = np.isfinite(visible) & ~on
    # The white edge keeps a tick apart from the bar behind it, in grey as well.
    ax.hlines(visible[on], x[on] - 0.42, x[on] + 0.42, color="white", lw=3.0, zorder=2.9)
    ax.hlines(
        visible[on],
        x[on] - 0.42,
        x[on] + 0.42,
        lw=1.5,
        ls=(0, (3, 1)),
        clip_on=False,
        label="smallest damage that would be seen",
        **look,
    )
    if above.any():
        ax.plot(
            x[above],
            np.full(int(above.sum()), 0.975),
            ls="",
            marker="^",
            ms=5.5,
            mew=0.0,
            transform=ax.get_xaxis_transform(),
            label="seen only from this loss on, in %",
            **look,
        )
        for at, value in zip(x[above], visible[above], strict=True):
            ax.annotate(
                f"{value:.0f}",
                (at, 0.975),
                xycoords=ax.get_xaxis_transform(),
                xytext=(0, -5),
                textcoords="offset points",
                ha="center",
                va="top",
                fontsize="x-small",
            )
    for number, i in enumerate(x[~np.isfinite(visible)]):
        ax.axvspan(
            i - 0.5,
            i + 0.5,
            facecolor="none",
            edgecolor="#BFBFBF",
            hatch="...",
            lw=0.0,
            zorder=0,
            label="no damage could be seen" if number == 0 else None,
        )


def element_names(result: DamageResult) -> list[str]:
    """What the candidate elements are called."""
    label = result.problem.model.element_label
    return [", ".join(label(term) for term in p.terms) for p in result.problem.parameters]


def percent_axis(ax: Any, shown: FloatArray, upright: bool) -> None:
    """Scale of the losses, with room for the numbers over the bars; there is none above 100 %."""
    room = 1.36 if upright else 1.16
    top = max(LEAST_PERCENT, room * np.nanmax(shown[np.isfinite(shown)], initial=0.0))
    ax.set_ylim(0.0, top)
    if top > 100.0:
        ax.set_yticks(range(0, 101, 20))
    ax.set_ylabel("Stiffness loss (%)")
    ax.grid(axis="y", alpha=0.25)
    ax.set_axisbelow(True)


def mark_truth(ax: Any, x: Any, known: FloatArray, size: float) -> None:
    """Known losses as diamonds that leave the bars visible."""
    look = {"marker": "D", "mfc": "none", "mec": "black", "mew": 1.3, "clip_on": False}
    ax.plot(x, known, ls="", ms=size, label="truth", zorder=4, **look)


def element_axis(ax: Any, names: list[str], upright: bool, first: tuple[str, ...]) -> None:
    """Names of the elements across, and the legend below them."""
    ax.set_xticks(range(len(names)), names, rotation=90 if upright else 0)
    ax.tick_params(axis="x", pad=7)  # clear of diamonds at 0
    spare = max(0.6, 0.5 * (4 - len(names)))  # one or two bars are bars, not blocks
    ax.set_xlim(-spare, len(names) - 1 + spare)
    ax.set_xlabel("Candidate element (no bar: exactly 0)")
    length = text_width_pt(max(names, key=len), 10.0)
    below(ax, drop_pt=34.0 + length if upright else 44.0, first=first)
