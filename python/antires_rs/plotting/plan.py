"""A planned test: the smallest damage that it would show, by element."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import COLOURS, below, fit_across, new_axes, offer, plain_log, text_width_pt

if TYPE_CHECKING:
    from ..planning.sensor_plan import SensorPlan

__all__ = ["plot_plan"]


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
