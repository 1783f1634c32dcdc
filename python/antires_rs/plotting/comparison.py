"""Differences of two sets of antiresonances, with their errors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import COLOURS, below, new_axes, offer

if TYPE_CHECKING:
    from ..measured.compare import Comparison

__all__ = ["plot_comparison"]

#: Above so many pairs their frequencies do not fit under the axis.
MOST_LABELS = 64


def plot_comparison(compared: Comparison, ax: Any = None) -> Any:
    """Draw the differences in % with 90 % intervals, response by response.

    Parameters
    ----------
    compared : Comparison
        Made by :func:`~antires_rs.compare`.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        Filled: changed at the rate of false alarms of the comparison; open: not.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs.plotting import plot_comparison
    >>> from matplotlib.figure import Figure
    >>> a, b = (ar.AntiresonanceSet(0, {0: f}, std_hz={0: [0.01, 0.01]}) for f in ([8.7, 23.9], [8.6, 23.9]))
    >>> ax = plot_comparison(ar.compare(a, b), ax=Figure().subplots())
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['no change seen', 'changed']
    """
    ax = new_axes(ax, (9.5, 4.2))
    dof = [str(each) for each in compared.dof]
    starts = np.array([i > 0 and dof[i] != dof[i - 1] for i in range(len(dof))], dtype=bool)
    x = np.arange(len(dof)) + 0.8 * np.cumsum(starts)
    interval = 1.645 * np.nan_to_num(compared.std_percent)
    kinds = (
        (~compared.changed, "no change seen", COLOURS["blue"], "white", "o"),
        (compared.changed, "changed", COLOURS["vermillion"], COLOURS["vermillion"], "s"),
    )
    for chosen, name, colour, face, mark in kinds:
        if chosen.any():
            ax.errorbar(
                x[chosen],
                compared.difference_percent[chosen],
                yerr=interval[chosen],
                ls="none",
                marker=mark,
                ms=6,
                color=colour,
                mfc=face,
                elinewidth=1.1,
                capsize=2.5,
                label=name,
            )
    ax.axhline(0.0, color="black", lw=0.8)
    for first in np.flatnonzero(starts):
        ax.axvline(x[first] - 0.9, color="#BFBFBF", lw=0.7)
    labelled = len(dof) <= MOST_LABELS
    for first in np.flatnonzero(np.r_[bool(len(dof)), starts[1:]]):
        name = f"dof {dof[first]}" if first == 0 else dof[first]
        ax.annotate(
            name,
            (x[first], 1.0),
            xytext=(0, 4),
            xycoords=ax.get_xaxis_transform(),
            textcoords="offset points",
            ha="center",
            fontsize="small",
        )
    ax.set_xticks(
        x if labelled else [],
        [f"{f:.1f}" for f in compared.a_hz] if labelled else [],
        rotation=90,
        fontsize="x-small",
    )
    ax.set_xlabel("Antiresonance of a (Hz), by response dof (above)")
    ax.set_ylabel("b less a (%), 90 % intervals")
    ax.grid(axis="y", alpha=0.25)
    below(ax, drop_pt=56.0 if labelled else 32.0)
    names = ("dof", "a_hz", "b_hz", "difference_percent", "std_percent", "changed")
    offer(ax, pairs={name: getattr(compared, name) for name in names})
    return ax
