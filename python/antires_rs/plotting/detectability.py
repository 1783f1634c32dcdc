"""Probability of detection against severity."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import COLOURS, GREY, LINES, below, new_axes, offer, plain_log

if TYPE_CHECKING:
    from ..planning.detection_curves import DetectionCurves

__all__ = ["plot_detectability"]

#: Above so many elements only three curves are told apart.
_MOST = 7
_LEVEL = 90.0
#: A curve as high as this has reached the top.
_REACHED = 0.995


def plot_detectability(curves: DetectionCurves, ax: Any = None) -> Any:
    """Draw the probability of detection of each element against its stiffness loss, both in %.

    Parameters
    ----------
    curves : DetectionCurves
        From :func:`~antires_rs.detectability`.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        A curve an element; of more than seven, all in grey but those that are seen best, worst and in
        between. Simulated tests are ticks, above the curves where the damage was found, below where not.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from matplotlib.figure import Figure
    >>> model = ar.MassSpringChain([1.0, 1.2, 1.0], [500.0, 450.0])
    >>> curves = ar.detectability(model, excitation=0, std=5e-4, n_tests=1, rng=0)
    >>> curves.plot(ax=Figure().subplots()).get_xlabel()
    'Stiffness loss (%)'
    """
    ax = new_axes(ax, (7.5, 4.6))
    elements = list(curves.pod)
    order = sorted(elements, key=lambda e: (curves.a90[e], curves.a50[e]))
    named = elements
    if len(elements) > _MOST:
        named = [order[0], order[len(order) // 2], order[-1]]
        for e in elements:
            if e not in named:
                ax.plot(100.0 * curves.severity[e], 100.0 * curves.pod[e], color="#BFBFBF", lw=0.9, zorder=1)
        ax.plot([], [], color="#BFBFBF", lw=0.9, label="the other elements")
    colours = list(COLOURS.values())
    for nth, e in enumerate(named):
        colour = colours[nth % len(colours)]
        found = curves.a90[e]
        told = "90 % never reached" if found == float("inf") else f"a90 {100.0 * found:.2g} %"
        look = {"color": colour, "ls": LINES[nth % len(LINES)], "lw": 1.9, "zorder": 3}
        label = f"{curves.names[e]}: {told}"
        ax.plot(100.0 * curves.severity[e], 100.0 * curves.pod[e], label=label, **look)
        if e in curves.tests:
            severity, hit = curves.tests[e]
            for at, level in ((hit > 0.5, 103.0), (hit < 0.5, -3.0)):
                ax.plot(100.0 * severity[at], np.full(int(at.sum()), level), ls="", marker="|", color=colour)
    ax.axhline(_LEVEL, color=GREY, lw=1.0, ls=(0, (4, 2)), zorder=2)
    ax.annotate(
        "90 %",
        (1.0, _LEVEL),
        xycoords=ax.get_yaxis_transform(),
        xytext=(4, 0),
        textcoords="offset points",
        va="center",
        fontsize="small",
    )
    shown = 100.0 * np.concatenate([curves.severity[e] for e in elements])
    ax.set_xscale("log")
    # Where every curve has reached the top there is nothing to see.
    open_ones = [100.0 * a for e in elements for a, p in _pairs(curves, e) if p < _REACHED]
    last = min(max([*open_ones, 2.0 * shown.min()]) * 1.6, shown.max())
    shown = shown[shown <= last]
    ax.set_xlim(shown.min(), last)
    plain_log(ax.xaxis, narrow=bool(shown.max() < 30.0 * shown.min()))
    ax.set_ylim(-6.0, 106.0)
    ax.set_yticks(range(0, 101, 20))
    ax.grid(alpha=0.25)
    ax.set_axisbelow(True)
    ax.set_xlabel("Stiffness loss (%)")
    ax.set_ylabel("Probability of detection (%)")
    below(ax)
    rows = [(e, a, p) for e in elements for a, p in _pairs(curves, e)]
    column = [np.array(values) for values in zip(*rows, strict=True)]
    offer(ax, curves={"element": column[0], "loss_percent": 100 * column[1], "pod_percent": 100 * column[2]})
    return ax


def _pairs(curves: DetectionCurves, element: int) -> Iterable[tuple[float, float]]:
    return zip(curves.severity[element].tolist(), curves.pod[element].tolist(), strict=True)
