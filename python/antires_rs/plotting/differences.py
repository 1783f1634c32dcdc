"""Antiresonance differences before and after updating."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import COLOURS, below, new_axes

if TYPE_CHECKING:
    from .._validation import FloatArray
    from ..results import FrequencyTable

__all__ = ["plot_differences"]

#: Above this many antiresonances their frequencies no longer fit under the bars.
MOST_LABELS = 64
#: Space between two responses, in widths of an antiresonance.
GAP = 0.8


def plot_differences(table: FrequencyTable, ax: Any = None,
                     names: tuple[str, str] = ("before updating", "after updating")) -> Any:
    """Draw the difference of each antiresonance to the measured one in %, before and after.

    Parameters
    ----------
    table : FrequencyTable
        ``UpdateResult.table``.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    names : (str, str), optional
        What the two states of the model are called in the legend.

    Returns
    -------
    matplotlib.axes.Axes
        Bars grouped by response and force, in the order of the table; a cross where the model has no partner.

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
    dof, force = np.asarray(table.dof), np.asarray(table.excitation)
    several = np.unique(force).size > 1
    starts = np.r_[True, (dof[1:] != dof[:-1]) | (force[1:] != force[:-1])][:dof.size]
    x = np.arange(dof.size) + GAP * (np.cumsum(starts) - 1)
    # Before is hatched and after is solid: told apart in grey too.
    _bars(ax, x - 0.2, table.before_percent, names[0], facecolor="white", hatch="/////",
          edgecolor=COLOURS["vermillion"], linewidth=0.8)
    _bars(ax, x + 0.2, table.after_percent, names[1], facecolor=COLOURS["blue"],
          edgecolor=COLOURS["blue"], linewidth=0.8)
    ax.axhline(0.0, color="black", lw=0.8)
    labelled = dof.size <= MOST_LABELS
    ax.set_xticks(x, [f"{f:.1f}" for f in table.measured_hz] if labelled else [""] * dof.size, rotation=90,
                  fontsize="x-small")
    firsts = np.flatnonzero(starts)
    for number, (first, end) in enumerate(zip(firsts, np.r_[firsts[1:], dof.size], strict=True)):
        if number:
            ax.axvline(x[first] - 0.5 - GAP / 2, color="#BFBFBF", lw=0.7)
        # "dof" once: beside it there is no room over a response with a single antiresonance.
        name = f"{dof[first]}, {force[first]}" if several else (
            f"dof {dof[first]}" if number == 0 else f"{dof[first]}")
        ax.annotate(name, (x[first:end].mean(), 1.0), xytext=(0, 4), xycoords=ax.get_xaxis_transform(),
                    textcoords="offset points", ha="center", va="bottom", fontsize="small")
    if dof.size:
        ax.set_xlim(x[0] - 0.5 - GAP / 2, x[-1] + 0.5 + GAP / 2)
    groups = "response and force dof" if several else "response dof"
    ax.set_xlabel(f"Measured antiresonance (Hz), by {groups} (above)")
    ax.set_ylabel("Difference to the measurement (%)")
    ax.margins(y=0.08)
    below(ax, 2, drop_pt=56.0 if labelled else 40.0)
    return ax


def _bars(ax: Any, x: FloatArray, percent: FloatArray, name: str, **look: Any) -> None:
    found = np.isfinite(percent)
    largest = f"largest {np.abs(percent[found]).max():.2f} %" if found.any() else "no partner at all"
    ax.bar(x[found], percent[found], width=0.4, label=f"{name}, {largest}", **look)
    if not found.all():
        lost = int(np.count_nonzero(~found))
        ax.plot(x[~found], np.zeros(lost), ls="", marker="x", ms=6, mew=1.6, clip_on=False,
                color=look["edgecolor"], label=f"{name}: no partner ({lost})", zorder=5)
