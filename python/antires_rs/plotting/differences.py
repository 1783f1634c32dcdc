"""Differences of antiresonances, or of resonances with their MAC, before and after updating."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import COLOURS, below, new_axes, offer, text_width_pt, width_pt
from .clipping import clip_bars, reach

if TYPE_CHECKING:
    from ..support.validation import FloatArray
    from ..updating.tables import FrequencyTable, ModalTable

__all__ = ["plot_differences"]

#: Above this many antiresonances their frequencies no longer fit under the bars.
MOST_LABELS = 64
#: Space between two responses, in widths of an antiresonance.
GAP = 0.8
#: A picture has room for so many at least: a single bar is a bar, not a block.
LEAST_WIDTH = 8.0
#: Vermillion, pale.
PALE = "#F2B48A"
#: What is offered, as far as the table has it.
COLUMNS = (
    "excitation",
    "dof",
    "mode",
    "measured_hz",
    "before_hz",
    "before_percent",
    "before_mac",
    "after_hz",
    "after_percent",
    "after_mac",
)


def plot_differences(
    table: FrequencyTable | ModalTable,
    ax: Any = None,
    names: tuple[str, str] = ("before updating", "after updating"),
) -> Any:
    """Draw the difference of each frequency to the measured one in %, before and after.

    Parameters
    ----------
    table : FrequencyTable or ModalTable
        ``UpdateResult.table``.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    names : (str, str), optional
        What the two states of the model are called in the legend.

    Returns
    -------
    matplotlib.axes.Axes
        Bars grouped by response and force, in the order of the table; a cross where the model has no partner.
        Where few values stand apart the axis is made for the others, and theirs are written at its edge.
        Of modes, one group for those measured together, with the MAC before and after above each.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> from antires_rs.plotting import plot_differences
    >>> from matplotlib.figure import Figure
    >>> columns = [0, 0], [0, 0], [10.0, 20.0], [10.4, 19.0], [10.01, 20.0]
    >>> table = ar.FrequencyTable(*map(np.array, columns))
    >>> ax = plot_differences(table, ax=Figure().subplots())
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['before updating, largest 5.00 %', 'after updating, largest 0.10 %']
    """
    ax = new_axes(ax, (9.5, 4.6))
    count = table.measured_hz.size
    starts, named, across = (_modes if hasattr(table, "before_mac") else _responses)(table)
    x = np.arange(count) + GAP * (np.cumsum(starts) - 1)
    labelled = count <= MOST_LABELS
    # Before is hatched, or pale where bars are thin, and after is dark: told apart in grey too.
    colour, dark = COLOURS["vermillion"], COLOURS["blue"]
    before = (
        {"facecolor": "white", "hatch": "/////", "edgecolor": colour}
        if labelled
        else {"facecolor": PALE, "edgecolor": PALE}
    )
    leading = (
        _bars(ax, x - 0.2, table.before_percent, names[0], colour, **before),
        _bars(ax, x + 0.2, table.after_percent, names[1], dark, facecolor=dark, edgecolor=dark),
    )
    ax.axhline(0.0, color="black", lw=0.8)
    ax.set_xticks(
        x if labelled else [],
        [f"{f:.1f}" for f in table.measured_hz] if labelled else [],
        rotation=90,
        fontsize="x-small",
    )
    ax.grid(axis="y", alpha=0.25)
    ax.set_axisbelow(True)
    firsts = np.flatnonzero(starts)
    for first in firsts[1:]:
        ax.axvline(x[first] - 0.5 - GAP / 2, color="#BFBFBF", lw=0.7)
    most = max(x[-1] - x[0] + 1.0 + GAP, LEAST_WIDTH) if count else 1.0
    free = -np.inf
    for first, end, name in named:
        # A name that would run into the one before it is left out.
        half = 0.5 * most * (text_width_pt(name) + 2.0) / width_pt(ax)
        if x[first:end].mean() - half < free:
            continue
        free = x[first:end].mean() + half
        ax.annotate(
            name,
            (x[first:end].mean(), 1.0),
            xytext=(0, 4),
            xycoords=ax.get_xaxis_transform(),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize="small",
        )
    if count:
        middle = 0.5 * (x[0] + x[-1])
        ax.set_xlim(middle - most / 2, middle + most / 2)
    ax.set_xlabel(across if labelled else across.replace(" (Hz)", "s, ascending"))
    ax.set_ylabel("Difference to the measurement (%)")
    _limits(ax, x, table)
    below(ax, drop_pt=56.0 if labelled else 32.0, first=leading)
    offer(ax, bars={name: getattr(table, name) for name in COLUMNS if hasattr(table, name)})
    return ax


def _limits(ax: Any, x: FloatArray, table: FrequencyTable | ModalTable) -> None:
    """An axis for the many; bars that go on beyond it have an arrow and their number."""
    both = np.concatenate([table.before_percent, table.after_percent])
    most = reach(both)
    ax.margins(y=0.08)
    if not np.isfinite(most):
        return
    low, high = np.nanmin(both), np.nanmax(both)
    ax.set_ylim(max(1.08 * min(low, 0.0), -most), min(1.08 * max(high, 0.0), most))
    clip_bars(ax, x - 0.2, table.before_percent, most, COLOURS["vermillion"])
    clip_bars(ax, x + 0.2, table.after_percent, most, COLOURS["blue"])


def _responses(table: Any) -> tuple[Any, list[tuple[int, int, str]], str]:
    """Where a group begins, (first, end, name) of each, and the label of the axis."""
    dof, force, names = np.asarray(table.dof), np.asarray(table.excitation), table.dof_names
    several = np.unique(force).size > 1
    starts = np.r_[True, (dof[1:] != dof[:-1]) | (force[1:] != force[:-1])][: dof.size]
    firsts = np.flatnonzero(starts)
    # "mass" or "dof" once: beside it there is no room over a response with a single antiresonance.
    masses = bool(names) and all(str(each).startswith("mass ") for each in names.values())
    title = "mass " if masses else "" if names else "dof "

    def name(which: int) -> str:
        return str(names.get(which, which)).removeprefix("mass ")

    named = [
        (
            first,
            end,
            f"{name(int(dof[first]))}, {name(int(force[first]))}"
            if several
            else f"{title if first == 0 else ''}{name(int(dof[first]))}",
        )
        for first, end in zip(firsts.tolist(), [*firsts[1:].tolist(), dof.size], strict=True)
    ]
    groups = "response and force dof" if several else "response dof"
    return starts, named, f"Measured antiresonance (Hz), by {groups} (above)"


def _modes(table: Any) -> tuple[Any, list[tuple[int, int, str]], str]:
    """The same of modes, whose MAC stands above each."""
    mode = np.asarray(table.mode)
    starts = np.r_[True, mode[1:] <= mode[:-1]][: mode.size]
    if mode.size > MOST_LABELS // 4:
        return starts, [], "Measured resonance (Hz)"
    pairs = zip(table.before_mac, table.after_mac, strict=True)
    named = [(r, r + 1, f"{before:.3f} \u2192\n{after:.3f}") for r, (before, after) in enumerate(pairs)]
    return starts, named, "Measured resonance (Hz); above: MAC before and after"


def _bars(ax: Any, x: FloatArray, percent: FloatArray, name: str, colour: str, **look: Any) -> str:
    """Draw them, and crosses where there is no partner; returns the label of the bars."""
    found = np.isfinite(percent)
    largest = f"largest {np.abs(percent[found]).max():.2f} %" if found.any() else "no partner at all"
    label = f"{name}, {largest}"
    ax.bar(x[found], percent[found], width=0.4, linewidth=0.8, label=label, **look)
    if not found.all():
        lost = int(np.count_nonzero(~found))
        ax.plot(
            x[~found],
            np.zeros(lost),
            ls="",
            marker="x",
            ms=6,
            mew=1.6,
            clip_on=False,
            color=colour,
            label=f"{name}: no partner ({lost})",
            zorder=5,
        )
    return label
