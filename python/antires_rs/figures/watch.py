"""Charts of a watch: single tests, the slow mean, and the condition that they were corrected for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.checks import choice
from .canvas import draw, new_axes
from .live_canvas import explored, stacked
from .marks import Axis, Bands, Line, Mark, Panel, Points, Rules

if TYPE_CHECKING:
    from ..watch.monitor import Watched

PANELS = ("charts", "T2", "EWMA", "events", "condition")
#: Tests above the limit by more than this are drawn at the top.
HIGHEST, LOWEST = 100.0, 0.05
LABELS = {"T2": "Single tests", "EWMA": "Mean of tests", "events": "Lost and new"}
#: So many tests at most are on a page: of more, the alarms and the latest of the others.
MOST_TESTS = 20_000


def plot_monitor(watched: Watched, *, panel: str = "charts", ax: Any = None) -> Any:
    """Draw the charts of a watch over its tests, each over its limit, and the first condition.

    The topmost; the others are in ``.figure.axes``. Alarms are crosses, the baseline is shaded, tests
    with a sensor at fault are triangles at the lower edge, failed ones ticks there.

    Parameters
    ----------
    watched : Watched
        From :func:`~antires_rs.monitor`.
    panel : {"charts", "T2", "EWMA", "events", "condition"}
        All below one another, or one of them.
    ax : matplotlib.axes.Axes, optional
        With it "charts" is "T2".

    Raises
    ------
    InvalidInputError
        An unknown panel.

    Examples
    --------
    >>> import antires_rs as ar
    >>> import numpy as np
    >>> from matplotlib.figure import Figure
    >>> rng = np.random.default_rng(0)
    >>> sets = [ar.AntiresonanceSet(0, {0: [8.7, 23.9] + 0.01 * rng.standard_normal(2)}) for _ in range(60)]
    >>> ar.monitor(sets, baseline=50).plot(ax=Figure().subplots()).get_ylabel()
    'Single tests / limit'
    """
    choice("panel", panel, PANELS)
    if ax is not None or panel != "charts":
        ax = new_axes(ax, (9.0, 3.0))
        _one(ax, watched, "T2" if panel == "charts" else panel, last=True)
        return ax
    top = new_axes(None, size_in(watched))
    figure = top.figure
    top.remove()
    axes = figure.subplots(len(panels(watched)), 1, sharex=True)
    draw_monitor(axes, watched)
    return axes[0]


def panels(watched: Watched) -> list[str]:
    """What there is to draw; the chart of lost and new values where it has anything to say."""
    names = ["T2", "EWMA"]
    if np.any(watched.charts["events"].ratio > 1.0):
        names.append("events")
    if watched.conditions:
        names.append("condition")
    return names


def size_in(watched: Watched) -> tuple[float, float]:
    """Width and height of all panels."""
    return 9.0, 1.2 + 1.8 * len(panels(watched))


def draw_monitor(axes: Any, watched: Watched) -> None:
    """All panels into as many axes, top to bottom."""
    names = panels(watched)
    for ax, name in zip(axes, names, strict=False):
        _one(ax, watched, name, last=ax is axes[len(names) - 1])


def _one(ax: Any, watched: Watched, name: str, *, last: bool) -> None:
    draw(chart(watched, name), ax, drop_pt=34.0 if last else 8.0, legend=last or name == "T2")
    ax.margins(x=0.01)
    ax.spines[["top", "right"]].set_visible(False)
    ax.tick_params(labelbottom=last)
    if not last:
        ax.set_xlabel("")


def watched_figure(watched: Watched) -> Any:
    """All panels below one another, to be explored; zooming one zooms all."""
    kept = np.arange(len(watched))
    if kept.size > MOST_TESTS:
        loud = np.flatnonzero(watched.alarm)[-MOST_TESTS // 2 :]
        kept = np.sort(np.r_[loud, np.flatnonzero(~watched.alarm)[loud.size - MOST_TESTS :]])
    figures: list[Any] = []
    for name in panels(watched):
        x_range = figures[0].x_range if figures else None
        figures.append(explored(chart(watched, name, kept), height=240, x_range=x_range))
    return stacked(figures)


def chart(watched: Watched, name: str, kept: Any = None) -> Panel:
    """One of the panels, of the tests that are ``kept``."""
    count = len(watched)
    kept = np.arange(count) if kept is None else kept
    times = watched.times
    dated = times is not None and not np.isnat(times).any()
    x = times if times is not None and dated else np.arange(count, dtype=np.float64)
    size = float(np.clip(160.0 / np.sqrt(max(count, 1)), 2.0, 6.0))
    # The baseline, as the stretches in which its tests follow each other; failed tests end none.
    own = watched.baseline
    breaks = np.flatnonzero(np.diff(own) > 2 + len(watched.failed))
    marks: list[Mark] = [
        Bands(x[own[np.r_[0, breaks + 1]]], x[own[np.r_[breaks, own.size - 1]]], "#EDEDED", label="baseline")
    ]
    axis = Axis("Time" if dated else "Test", dated=dated)
    tables: dict[str, dict[str, Any]]

    def hovered(some: Any, **says: str) -> dict[str, Any]:
        names = [watched.names[i] for i in some]
        why = [", ".join(watched.why(int(i))) if watched.statistic[i] > 1.0 else "-" for i in some]
        return {"says": {"Test": "@name"} | says, "more": {"name": names, "why": why}}

    if name == "condition":
        called = next(iter(watched.used), next(iter(watched.conditions)))
        column = np.asarray(watched.conditions[called])
        out = np.asarray(watched.outside) & (called in watched.used)
        for which, label, colour in ((~out, "test", "grey"), (out, "not in the baseline", "orange")):
            some = kept[which[kept]]
            if which.any():
                look = {"label": label, "colour": colour} | hovered(some, **{called: "@y{0.00}"})
                marks.append(Points(x[some], column[some], ".", size, **look))
        tables = {name: {"test": np.arange(count), called: column}}
        return Panel("chart_condition", axis, Axis(called), marks, grid="y", tables=tables)
    of = watched.charts[name]
    ratio = np.where(np.isnan(of.statistic), np.nan, np.clip(of.ratio, LOWEST, HIGHEST))
    above = np.asarray(of.ratio > 1.0)
    says = {"Statistic / limit": "@y{0.00}", "Alarm by": "@why"}
    loud, calm = kept[above[kept]], kept[~above[kept]]
    if name == "EWMA":
        marks.append(Line(x[kept], ratio[kept], "blue", **hovered(kept, **says)))
    else:
        marks.append(Points(x[calm], ratio[calm], ".", size, "grey", label="test", **hovered(calm, **says)))
    look = {"label": "above the limit", "stroke": 1.3} | hovered(loud, **says)
    marks.append(Points(x[loud], ratio[loud], "x", size + 2.0, "vermillion", **look))
    marks.append(Rules(1.0, dash="--", width=1.1, label="limit"))
    for tests, marker, label in ((watched.faults, "^", "sensor at fault"), (watched.failed, "|", "failed")):
        at = np.array(sorted(tests), dtype=int)
        if at.size and name == "T2":
            foot = np.full(at.size, LOWEST * 1.15)
            marks.append(Points(x[at], foot, marker, 5.0, face="none", spill=True, label=label))
    limits = LOWEST, max(3.0, 1.3 * float(np.nanmax(ratio, initial=1.0)))
    tables = {name: {"test": np.arange(count), "statistic": of.statistic, "limit": of.limit}}
    y_axis = Axis(f"{LABELS[name]} / limit", limits, log=True)
    return Panel(f"chart_{name}", axis, y_axis, marks, grid="y", tables=tables)
