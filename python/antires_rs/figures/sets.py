"""Several tests: the differences of two sets, antiresonances over many, and the charts of a watch."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from ..support.checks import forces_at
from ..support.messages import keywords_left
from .canvas import draw, new_axes
from .live_canvas import explored, stacked
from .marks import Axis, Bands, Heads, Line, Mark, Panel, Points, Rules, turn

if TYPE_CHECKING:
    from ..measured.compare import Comparison
    from ..measured.track import Tracks
    from ..watch.monitor import Watched

__all__ = ["plot_comparison", "plot_monitor", "plot_tracks"]

MOST_LABELS = 64  # above so many pairs their frequencies do not fit under the axis


def plot_comparison(compared: Comparison, ax: Any = None) -> Any:
    """Draw the differences in % with 90 % intervals, response by response.

    Filled: changed at the rate of false alarms of the comparison; open: not.

    Examples
    --------
    >>> import antires_rs as ar
    >>> a, b = (ar.AntiresonanceSet(0, {0: f}, std_hz={0: [0.01, 0.01]}) for f in ([8.7, 23.9], [8.6, 23.9]))
    >>> ar.figures.plot_comparison(ar.compare(a, b)).get_ylabel()
    'b less a (%), 90 % intervals'
    """
    dof = list(map(str, compared.dof))
    starts = np.array([i > 0 and dof[i] != dof[i - 1] for i in range(len(dof))], dtype=bool)
    x = np.arange(len(dof)) + 0.8 * np.cumsum(starts)
    interval = 1.645 * np.nan_to_num(compared.std_percent)
    marks: list[Mark] = [Rules(0.0), Rules(x[starts] - 0.9, upright=True, colour="pale", width=0.7)]
    for chosen, name, marker, colour, face in (
        (~compared.changed, "no change seen", "o", "blue", "white"),
        (compared.changed, "changed", "s", "vermillion", None),
    ):
        if chosen.any():
            y, error = compared.difference_percent[chosen], interval[chosen]
            marks.append(Points(x[chosen], y, marker, colour=colour, face=face, error=error, label=name))
    firsts = np.flatnonzero(np.r_[bool(len(dof)), starts[1:]])
    marks.append(Heads(x[firsts], [f"dof {dof[i]}" if i == 0 else dof[i] for i in firsts]))
    labelled = len(dof) <= MOST_LABELS
    names = [f"{f:.1f}" for f in compared.a_hz] if labelled else []
    label = "Antiresonance of a (Hz), by response dof (above)"
    x_axis = Axis(label, names=names, at=x if labelled else [], upright=True)
    panel = Panel("comparison", x_axis, Axis("b less a (%), 90 % intervals"), marks, grid="y")
    ax = draw(panel, new_axes(ax, (9.5, 4.2)), drop_pt=56.0 if labelled else 32.0)
    ax.tick_params(axis="x", labelsize="x-small")
    return ax


# -- Antiresonances over many tests: how far each has moved

MARKERS = ("o", "s", "^", "D", "v", "P", "X")
ROOM = 60  # texts of conditions longer than this, all together, are turned


@keywords_left(kind="changes are drawn")
def plot_tracks(tracks: Tracks, dof: Any = None, *, ax: Any = None) -> Any:
    """Draw how the antiresonances of one response changed since the first test of each, in %.

    A line a track with its standard deviations, over numbers as conditions to scale, over texts evenly.

    Parameters
    ----------
    dof : int or str, optional
        A response that has antiresonances; by default the first.

    Examples
    --------
    >>> import antires_rs as ar
    >>> tests = [ar.AntiresonanceSet(0, {0: values}) for values in ([8.7, 23.9], [8.6, 23.8])]
    >>> ar.figures.plot_tracks(ar.track(tests)).get_xlabel()
    'Test'
    """
    if dof is None and len(tracks):
        dof = tracks.dof[0]
    some = tracks.of(dof)
    if not some.size:
        known = tuple(dict.fromkeys(tracks.dof.tolist()))
        reject("dof", dof, f"one of {known}", "Name a response that has antiresonances.")
    numeric = not any(isinstance(condition, str) for condition in tracks.conditions)
    counted = tracks.conditions == tuple(range(len(tracks.conditions)))
    x = np.array(tracks.conditions if numeric else range(len(tracks.conditions)), dtype=np.float64)
    change = tracks.change_percent
    std = tracks.std_hz / tracks.freq_hz * (100.0 + change)
    rank = np.argsort(x, kind="stable")
    names = [f"{tracks.freq_hz[~np.isnan(tracks.freq_hz[:, i]), i][0]:.2f} Hz" for i in some]
    marks: list[Mark] = []
    for n, (i, name) in enumerate(zip(some, names, strict=True)):
        error, marker, look = np.nan_to_num(std[rank, i]), MARKERS[n % len(MARKERS)], turn(n)
        more = {"error": error, "link": look["dash"], "label": name}
        marks.append(Points(x[rank], change[rank, i], marker, 4.5, look["colour"], **more))
    x_axis = Axis("Test" if counted else "Condition", names=None if numeric else tracks.conditions)
    y_axis = Axis("Change since its first test (%)")
    title = f"Response at dof {dof}, {forces_at(tracks.excitation)}"
    panel = Panel("tracks", x_axis, y_axis, marks, title=title, grid="both", first=names)
    turned = not numeric and len("".join(tracks.conditions)) > ROOM
    ax = draw(panel, new_axes(ax, (7.5, 4.5)), drop_pt=62.0 if turned else 36.0)
    if turned:
        ax.set_xticks(x, tracks.conditions, rotation=45, ha="right")
    if counted:
        ax.xaxis.get_major_locator().set_params(integer=True)
    ax.margins(x=0.04, y=0.08)
    return ax


# -- Charts of a watch: single tests, the slow mean, and the condition that they were corrected for

HIGHEST, LOWEST = 100.0, 0.05  # tests above the limit by more than this are drawn at the top
LABELS = {"T2": "Single tests", "EWMA": "Mean of tests", "events": "Lost and new"}
MOST_TESTS = 20_000  # so many tests at most are on a page: of more, the alarms and the latest of the others


@keywords_left(panel="all charts are drawn; single tests into ax")
def plot_monitor(watched: Watched, *, ax: Any = None) -> Any:
    """Draw the charts of a watch over its tests, each over its limit, and the first condition.

    Alarms are crosses, the baseline is shaded, tests with a sensor at fault are triangles at the lower edge,
    failed ones ticks there. The topmost axes are returned; the others are in ``.figure.axes``. Into ``ax``
    the chart of single tests is drawn alone.

    Examples
    --------
    >>> import antires_rs as ar
    >>> sets = [ar.AntiresonanceSet(0, {0: [8.7 + 0.001 * (test % 7)]}) for test in range(60)]
    >>> ar.monitor(sets, baseline=50).plot().get_ylabel()
    'Single tests / limit'
    """
    top = new_axes(ax, size_in(watched))
    if ax is not None:
        return _one(ax, watched, "T2", last=True)
    figure = top.figure
    top.remove()
    axes = figure.subplots(len(panels(watched)), 1, sharex=True)
    draw_monitor(axes, watched)
    return axes[0]


def panels(watched: Watched) -> list[str]:
    """What there is to draw; the chart of lost and new values where it has anything to say."""
    events, condition = np.any(watched.charts["events"].ratio > 1.0), bool(watched.conditions)
    return ["T2", "EWMA", *(["events"] if events else []), *(["condition"] if condition else [])]


def size_in(watched: Watched) -> tuple[float, float]:
    """Width and height of all panels."""
    return 9.0, 1.2 + 1.8 * len(panels(watched))


def draw_monitor(axes: Any, watched: Watched) -> None:
    """All panels into as many axes, top to bottom."""
    for ax, name in zip(axes, panels(watched), strict=True):
        _one(ax, watched, name, last=ax is axes[-1])


def _one(ax: Any, watched: Watched, name: str, *, last: bool) -> Any:
    chart = _chart(watched, name, np.arange(len(watched)))
    draw(chart, ax, drop_pt=34.0 if last else 8.0, legend=last or name == "T2")
    ax.margins(x=0.01)
    ax.spines[["top", "right"]].set_visible(False)
    ax.tick_params(labelbottom=last)
    if not last:
        ax.set_xlabel("")
    return ax


def watched_figure(watched: Watched) -> Any:
    """All panels below one another, to be explored; zooming one zooms all."""
    kept = np.arange(len(watched))
    if kept.size > MOST_TESTS:
        loud = np.flatnonzero(watched.alarm)[-MOST_TESTS // 2 :]
        kept = np.sort(np.r_[loud, np.flatnonzero(~watched.alarm)[loud.size - MOST_TESTS :]])
    figures: list[Any] = []
    for name in panels(watched):
        x_range = figures[0].x_range if figures else None
        figures.append(explored(_chart(watched, name, kept), height=240, x_range=x_range))
    return stacked(figures)


def _chart(watched: Watched, name: str, kept: Any) -> Panel:
    """One of the panels, of the tests that are ``kept``."""
    count, times = len(watched), watched.times
    dated = times is not None and not np.isnat(times).any()
    x = times if times is not None and dated else np.arange(count, dtype=np.float64)
    size = float(np.clip(160.0 / np.sqrt(max(count, 1)), 2.0, 6.0))
    # The baseline, as the stretches in which its tests follow each other; failed tests end none.
    own = watched.baseline
    breaks = np.flatnonzero(np.diff(own) > 2 + len(watched.failed))
    first, last = x[own[np.r_[0, breaks + 1]]], x[own[np.r_[breaks, own.size - 1]]]
    marks: list[Mark] = [Bands(first, last, "#EDEDED", label="baseline")]
    axis = Axis("Time" if dated else "Test", dated=dated)

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
        return Panel("chart_condition", axis, Axis(called), marks, grid="y")
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
    return Panel(f"chart_{name}", axis, Axis(f"{LABELS[name]} / limit", limits, log=True), marks, grid="y")
