"""A planned test: the smallest damage that it would show, by element."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import COLOURS, GREY, LINES, below, fit_across, new_axes, offer, plain_log, text_width_pt

if TYPE_CHECKING:
    from ..planning.detection_curves import DetectionCurves
    from ..planning.plan import SensorPlan


def plot_plan(plan: SensorPlan, ax: Any = None) -> Any:
    """Draw the smallest stiffness loss that each element must have to be seen, in %.

    Parameters
    ----------
    plan : SensorPlan
        From :func:`~antires_rs.plan_test`.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        Filled circles: with the planned sensors; open squares: with a sensor on every candidate. A hatched
        background marks elements whose damage the planned sensors do not show. Of parameters: standard
        deviations after the test in % of those before.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from matplotlib.figure import Figure
    >>> plan = ar.plan_test(ar.cases.chain8().model, n_sensors=3, excitations=0)
    >>> plan.plot(ax=Figure().subplots()).get_ylabel()
    'Smallest stiffness loss seen (%)'
    """
    severities = bool(plan.detectable)
    if severities:
        names = list(plan.names.values())
        planned = 100.0 * np.array(list(plan.detectable.values()))
        everywhere = 100.0 * np.array(list(plan.detectable_by_all.values()))
    else:
        names = list(plan.std)
        planned = 100.0 * np.array([plan.std[name] / plan.std_before[name] for name in names])
        everywhere = np.full(planned.size, np.nan)
    ax = new_axes(ax, (max(6.0, 0.32 * len(names) + 1.5), 4.4))
    upright = not fit_across(ax, names)
    x = np.arange(len(names))
    finite = [np.where(np.isfinite(values), values, np.nan) for values in (planned, everywhere)]
    count = len(plan.sensors)
    ax.vlines(x, finite[1], finite[0], color="#BFBFBF", lw=1.2, zorder=1)
    label = f"{count} planned sensors"
    ax.plot(x, finite[0], ls="", marker="o", ms=7, color=COLOURS["blue"], label=label, zorder=3)
    if severities:
        ax.plot(
            x,
            finite[1],
            ls="",
            marker="s",
            ms=6,
            mfc="white",
            mec=COLOURS["vermillion"],
            mew=1.3,
            label="a sensor on every candidate",
            zorder=2,
        )
    for number, i in enumerate(x[~np.isfinite(planned)]):
        ax.axvspan(
            i - 0.5,
            i + 0.5,
            facecolor="none",
            edgecolor="#BFBFBF",
            hatch="...",
            lw=0.0,
            zorder=0,
            label=None if number else "no damage would be seen",
        )
    shown = np.concatenate(finite)
    shown = shown[np.isfinite(shown)]
    if shown.size:
        ax.set_yscale("log")
        ax.set_ylim(shown.min() / 1.6, shown.max() * 1.6)
        plain_log(ax.yaxis, narrow=bool(shown.max() < 30.0 * shown.min()))
    ax.grid(axis="y", alpha=0.25)
    ax.set_axisbelow(True)
    ax.set_ylabel("Smallest stiffness loss seen (%)" if severities else "Std after / before (%)")
    ax.set_xticks(x, names, rotation=90 if upright else 0)
    ax.set_xlim(-0.6, len(names) - 0.4)
    ax.set_title(
        f"force at {plan.labels[plan.excitation]}, {plan.n_values} antiresonances", fontsize="medium"
    )
    below(ax, drop_pt=30.0 + (text_width_pt(max(names, key=len), 10.0) if upright else 0.0))
    column = "seen_percent" if severities else "std_percent"
    offer(ax, elements={"name": names, column: planned, f"{column}_by_all": everywhere})
    return ax


# -- Probability of detection against severity


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
