"""Damage: stiffness loss by element."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import COLOURS, below, new_axes

if TYPE_CHECKING:
    from ..results import DamageResult

__all__ = ["plot_damage"]

#: The axis shows at least this much: on a finer scale nothing would look like something.
LEAST_PERCENT = 10.0


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
        One bar an element. The ticks across are ``result.detectable``: damage below would come out as none. A
        hatched background marks elements whose damage no value could show.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.

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
    severity = 100.0 * np.asarray(result.x)
    label = result.problem.model.element_label
    names = [", ".join(label(term) for term in p.terms) for p in result.problem.parameters]
    ax = new_axes(ax, (max(6.0, 0.32 * len(names) + 1.5), 4.4))
    x = np.arange(len(names))
    ax.bar(x, severity, width=0.62, color=COLOURS["blue"], edgecolor="black", linewidth=0.6, label="found")
    visible = 100.0 * np.array([result.detectable[e] for e in result.elements])
    known = 100.0 * np.array([(truth or {}).get(e, np.nan) for e in result.elements])
    shown = np.concatenate([severity, known, np.minimum(visible, 25.0)])
    crowded = len(names) > 12
    room = 1.28 if crowded else 1.14  # for the numbers over the bars
    ax.set_ylim(0.0, max(LEAST_PERCENT, room * np.nanmax(shown[np.isfinite(shown)], initial=0.0)))

    seen = np.isfinite(visible)
    ax.hlines(visible[seen], x[seen] - 0.42, x[seen] + 0.42, color=COLOURS["vermillion"], lw=1.4,
              ls=(0, (3, 1.5)), label="smallest damage that would be seen")
    for number, i in enumerate(x[~seen]):
        ax.axvspan(i - 0.5, i + 0.5, facecolor="none", edgecolor="#BFBFBF", hatch="...", lw=0.0, zorder=0,
                   label="no damage could be seen" if number == 0 else None)
    if truth is not None:
        ax.plot(x, known, ls="", marker="D", ms=8, mfc="none", mec="black", mew=1.3, label="truth", zorder=4,
                clip_on=False)
    for i, value in enumerate(severity):
        if value > 0.0:
            # A diamond or a tick close above the bar would strike the number out: it goes above them.
            reach = value + 0.12 * ax.get_ylim()[1]
            over = max(m for m in (value, known[i], visible[i]) if value <= m <= reach)
            ax.annotate(f"{value:.1f} %", (i, over), xytext=(0, 7), textcoords="offset points", ha="center",
                        va="bottom", fontsize="small", rotation=90 if crowded else 0)
    if not severity.any():
        ax.set_title("no damage found", fontsize="medium")
    ax.set_xticks(x, names, rotation=90 if crowded else 0)
    ax.tick_params(axis="x", pad=7)  # clear of diamonds at 0
    ax.set_xlim(-0.6, len(names) - 0.4)
    ax.set_xlabel("Candidate element (no bar: exactly 0)")
    ax.set_ylabel("Stiffness loss (%)")
    below(ax, 3, drop_pt=44.0 + (5.5 * max(map(len, names)) if crowded else 0.0), first=("found", "truth"))
    return ax
