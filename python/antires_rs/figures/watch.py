"""Charts of a watch: single tests, the slow mean, and the condition that they were corrected for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..support.checks import choice
from .canvas import COLOURS, GREY, below, new_axes, offer

if TYPE_CHECKING:
    from ..watch.monitor import Watched

PANELS = ("charts", "T2", "EWMA", "events", "condition")
#: Tests above the limit by more than this are drawn at the top.
HIGHEST, LOWEST = 100.0, 0.05
LABELS = {"T2": "Single tests", "EWMA": "Mean of tests", "events": "Lost and new"}


def plot_monitor(watched: Watched, *, panel: str = "charts", ax: Any = None) -> Any:
    """Draw the charts of a watch over its tests, each over its limit, and the first condition.

    Parameters
    ----------
    watched : Watched
        From :func:`~antires_rs.monitor`.
    panel : {"charts", "T2", "EWMA", "events", "condition"}
        All below one another, or one of them.
    ax : matplotlib.axes.Axes, optional
        Drawn into; then "charts" is "T2". A new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        The topmost; the others are in ``.figure.axes``. Alarms are crosses, the baseline is shaded, tests
        with a sensor at fault are triangles at the lower edge, failed ones ticks there.

    Raises
    ------
    InvalidInputError
        An unknown panel.
    MissingDependencyError
        matplotlib is not installed.

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
    names = panels(watched)
    top = new_axes(None, size_in(watched))
    figure = top.figure
    top.remove()
    axes = figure.subplots(len(names), 1, sharex=True)
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
    x, label = _when(watched)
    _shade(ax, watched, x)
    if name == "condition":
        _condition(ax, watched, x)
    else:
        _chart(ax, watched, name, x)
    ax.margins(x=0.01)
    ax.grid(axis="y", color="#E6E6E6", lw=0.6)
    ax.set_axisbelow(True)
    for side in ("top", "right"):
        ax.spines[side].set_visible(False)
    if last:
        ax.set_xlabel(label)
        ax.tick_params(labelbottom=True)
    if last or name == "T2":
        below(ax, drop_pt=34.0 if last else 8.0)


def _chart(ax: Any, watched: Watched, name: str, x: NDArray[Any]) -> None:
    chart = watched.charts[name]
    ratio = np.where(np.isnan(chart.statistic), np.nan, np.clip(chart.ratio, LOWEST, HIGHEST))
    above = chart.ratio > 1.0
    if name == "EWMA":
        ax.plot(x, ratio, color=COLOURS["blue"], lw=1.2, zorder=2)
    else:
        ax.plot(
            x[~above], ratio[~above], ls="", marker=".", ms=_size(x.size), color=GREY, zorder=2, label="test"
        )
    ax.plot(
        x[above],
        ratio[above],
        ls="",
        marker="x",
        ms=_size(x.size) + 2.0,
        mew=1.3,
        color=COLOURS["vermillion"],
        zorder=3,
        label="above the limit",
    )
    ax.axhline(1.0, color=COLOURS["black"], lw=1.1, ls="--", zorder=1, label="limit")
    ax.set_yscale("log")
    ax.set_ylim(LOWEST, max(3.0, 1.3 * float(np.nanmax(ratio, initial=1.0))))
    for tests, mark, what in ((watched.faults, "^", "sensor at fault"), (watched.failed, "|", "failed")):
        at = np.array(sorted(tests), dtype=int)
        if at.size and name == "T2":
            ax.plot(
                x[at],
                np.full(at.size, LOWEST * 1.15),
                ls="",
                marker=mark,
                ms=5,
                mfc="none",
                color=COLOURS["black"],
                clip_on=False,
                label=what,
            )
    ax.set_ylabel(f"{LABELS[name]} / limit")
    offer(ax, **{name: {"test": np.arange(x.size), "statistic": chart.statistic, "limit": chart.limit}})


def _condition(ax: Any, watched: Watched, x: NDArray[Any]) -> None:
    name = next(iter(watched.used), next(iter(watched.conditions)))
    column = watched.conditions[name]
    ax.plot(x, column, ls="", marker=".", ms=_size(x.size), color=GREY, label="test")
    out = watched.outside
    if out.any() and name in watched.used:
        ax.plot(
            x[out],
            column[out],
            ls="",
            marker=".",
            ms=_size(x.size),
            color=COLOURS["orange"],
            label="not in the baseline",
        )
    ax.set_ylabel(name)
    offer(ax, condition={"test": np.arange(x.size), name: column})


def _shade(ax: Any, watched: Watched, x: NDArray[Any]) -> None:
    """The baseline, as the stretches in which its tests follow each other."""
    own = watched.baseline
    breaks = np.flatnonzero(np.diff(own) > _gap(watched))
    for i, (a, b) in enumerate(zip([0, *(breaks + 1)], [*breaks, own.size - 1], strict=True)):
        ax.axvspan(
            x[own[a]], x[own[b]], color="#EDEDED", lw=0, zorder=0, label="baseline" if i == 0 else "_baseline"
        )


def _gap(watched: Watched) -> int:
    """Failed tests do not end a stretch."""
    return 2 + len(watched.failed)


def _when(watched: Watched) -> tuple[NDArray[Any], str]:
    """Where the tests are on the axis."""
    times = watched.times
    if times is not None and not np.isnat(times).any():
        return times, "Time"
    return np.arange(len(watched), dtype=np.float64), "Test"


def _size(count: int) -> float:
    """Of a dot, in points."""
    return float(np.clip(160.0 / np.sqrt(max(count, 1)), 2.0, 6.0))
