"""A planned test: the smallest damage that it would show, by element, and with which probability."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import draw, fit_across, new_axes, plain_log
from .marks import Axis, Bands, Line, Mark, Panel, Paths, Points, Rules, turn

if TYPE_CHECKING:
    from ..planning.detection_curves import DetectionCurves
    from ..planning.plan import SensorPlan

__all__ = ["plot_detectability", "plot_plan"]


def plot_plan(plan: SensorPlan, ax: Any = None) -> Any:
    """Draw the smallest stiffness loss that each element must have to be seen, in %.

    Filled circles: with the planned sensors; open squares: with a sensor on every candidate. A hatched
    background marks elements whose damage the planned sensors do not show. Of parameters: standard
    deviations after the test in % of those before.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.plan_test(ar.cases.chain8().model, n_sensors=3, excitations=0).plot().get_ylabel()
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
    x = np.arange(len(names))
    with_plan, with_all = (np.where(np.isfinite(values), values, np.nan) for values in (planned, everywhere))
    spans = [np.array([(i, a), (i, b)]) for i, a, b in zip(x, with_plan, with_all, strict=True)]
    marks: list[Mark] = [Paths(spans, "pale", width=1.2)]
    nowhere = x[~np.isfinite(planned)]
    if nowhere.size:
        marks.append(Bands(nowhere - 0.5, nowhere + 0.5, hatch="...", label="no damage would be seen"))
    if severities:
        label = "a sensor on every candidate"
        marks.append(Points(x, with_all, "s", 6.0, "vermillion", "white", 1.3, label=label))
    marks.append(Points(x, with_plan, "o", 7.0, "blue", label=f"{len(plan.sensors)} planned sensors"))
    shown = np.concatenate([with_plan, with_all])
    shown = shown[np.isfinite(shown)]
    limits = (shown.min() / 1.6, shown.max() * 1.6) if shown.size else None
    upright = not fit_across(ax, names)
    label = "Smallest stiffness loss seen (%)" if severities else "Std after / before (%)"
    x_axis = Axis("", (-0.6, len(names) - 0.4), names=names, upright=upright)
    y_axis, first = Axis(label, limits, log=bool(limits)), (f"{len(plan.sensors)} planned sensors",)
    title = f"force at {plan.labels[plan.excitation]}, {plan.n_values} antiresonances"
    panel = Panel("plan", x_axis, y_axis, marks, title=title, grid="y", first=first)
    draw(panel, ax, drop_pt=None if upright else 30.0)
    if shown.size:
        plain_log(ax.yaxis)
    return ax


# -- Probability of detection against severity

_MOST = 7  # above so many elements only three curves are told apart
_LEVEL = 90.0
_REACHED = 0.995  # a curve as high as this has reached the top


def plot_detectability(curves: DetectionCurves, ax: Any = None) -> Any:
    """Draw the probability of detection of each element against its stiffness loss, both in %.

    Of more than seven elements all are in grey but those seen best, worst and in between. Simulated tests
    are ticks, above the curves where the damage was found, below where not.

    Examples
    --------
    >>> import antires_rs as ar
    >>> model = ar.MassSpringChain([1.0, 1.2, 1.0], [500.0, 450.0])
    >>> ar.detectability(model, excitation=0, std=5e-4, n_tests=1, rng=0).plot().get_xlabel()
    'Stiffness loss (%)'
    """
    elements = list(curves.pod)
    order = sorted(elements, key=lambda e: (curves.a90[e], curves.a50[e]))
    named = elements if len(elements) <= _MOST else [order[0], order[len(order) // 2], order[-1]]
    percent = {e: (100.0 * curves.severity[e], 100.0 * curves.pod[e]) for e in elements}
    others = [e for e in elements if e not in named]
    rest = zip(others, [None if i else "the other elements" for i in range(len(others))], strict=True)
    marks: list[Mark] = [Line(*percent[e], "pale", width=0.9, label=name) for e, name in rest]
    marks.append(Rules(_LEVEL, colour="grey", dash=(4, 2), width=1.0))
    for nth, e in enumerate(named):
        found, look = curves.a90[e], turn(nth)
        reached = "90 % never reached" if found == float("inf") else f"a90 {100.0 * found:.2g} %"
        marks.append(Line(*percent[e], width=1.9, label=f"{curves.names[e]}: {reached}", **look))
        severity, hit = curves.tests.get(e, (np.empty(0), np.empty(0)))
        for at, level in ((hit > 0.5, 103.0), (hit < 0.5, -3.0)):
            y = np.full(int(at.sum()), level)
            marks.append(Points(100.0 * severity[at], y, "|", colour=look["colour"]))
    shown = np.concatenate([severity for severity, _ in percent.values()])
    # Where every curve has reached the top there is nothing to see.
    climbing = [severity[pod < 100.0 * _REACHED].max(initial=0.0) for severity, pod in percent.values()]
    last = min(max([*climbing, 2.0 * shown.min()]) * 1.6, shown.max())
    shown = shown[shown <= last]
    x_axis = Axis("Stiffness loss (%)", (shown.min(), last), log=True)
    y_axis = Axis("Probability of detection (%)", (-6.0, 106.0), at=range(0, 101, 20))
    ax = draw(Panel("detectability", x_axis, y_axis, marks, grid="both"), new_axes(ax, (7.5, 4.6)))
    plain_log(ax.xaxis)
    look = {"xytext": (4, 0), "textcoords": "offset points", "va": "center", "fontsize": "small"}
    ax.annotate("90 %", (1.0, _LEVEL), xycoords=ax.get_yaxis_transform(), **look)
    return ax
