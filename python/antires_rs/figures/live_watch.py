"""Charts of a watch, each over its limit, on one axis of tests or times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import COLOURS, GREY
from .live_canvas import below, columns, hover, paper, stacked
from .watch import HIGHEST, LABELS, LOWEST, panels

if TYPE_CHECKING:
    from ..watch.monitor import Watched

#: So many tests at most are drawn: of more, the alarms and the latest of the others.
MOST_TESTS = 20_000


def watched_figure(watched: Watched) -> Any:
    """Single tests, slow mean and condition below one another; zooming one zooms all."""
    times, count = watched.times, len(watched)
    if times is not None and np.isnat(times).any():
        times = None
    dated = times is not None
    kept = np.arange(count)
    if count > MOST_TESTS:
        calm = np.flatnonzero(~watched.alarm)[
            -(MOST_TESTS - min(int(watched.alarm.sum()), MOST_TESTS // 2)) :
        ]
        kept = np.sort(np.concatenate([np.flatnonzero(watched.alarm)[-MOST_TESTS // 2 :], calm]))
    x = np.arange(count, dtype=np.float64)
    if times is not None:
        x = times.astype("datetime64[ms]").astype(np.float64)
    figures: list[Any] = []
    for name in panels(watched):
        shared = {"x_range": figures[0].x_range} if figures else {}
        what = next(iter(watched.used), next(iter(watched.conditions))) if name == "condition" else ""
        fig = paper(
            "Time" if dated else "Test",
            what or f"{LABELS[name]} / limit",
            height=240,
            y_log=not what,
            name=f"chart_{name}",
            **shared,
        )
        if dated:
            _dates(fig)
        _shade(fig, watched, x)
        table = columns(name=[watched.names[i] for i in kept])
        table.data["x"] = x[kept]  # times need all their digits
        if what:
            table.data["y"] = np.asarray(watched.conditions[what], dtype=np.float32)[kept]
            dots = fig.scatter("x", "y", source=table, size=4, color=GREY, legend_label=what)
            hover(fig, [dots], {"Test": "@name", what: "@y{0.00}"})
        else:
            _chart(fig, watched, name, kept, table)
        below(fig)
        figures.append(fig)
    return stacked(figures)


def _chart(fig: Any, watched: Watched, name: str, kept: Any, table: Any) -> None:
    from bokeh.models import BooleanFilter, CDSView, Span

    chart = watched.charts[name]
    ratio = np.where(np.isnan(chart.statistic), np.nan, np.clip(chart.ratio, LOWEST, HIGHEST))[kept]
    above = np.asarray(chart.ratio > 1.0)[kept]
    table.data["y"] = ratio.astype(np.float32)
    table.data["why"] = [
        ", ".join(watched.why(int(i))) if up else "-" for i, up in zip(kept, above, strict=True)
    ]
    drawn = []
    if name == "EWMA":
        drawn.append(fig.line("x", "y", source=table, color=COLOURS["blue"], line_width=1.5))
    else:
        calm = CDSView(filter=BooleanFilter((~above).tolist()))
        drawn.append(fig.scatter("x", "y", source=table, view=calm, size=4, color=GREY, legend_label="test"))
    loud = CDSView(filter=BooleanFilter(above.tolist()))
    drawn.append(
        fig.scatter(
            "x",
            "y",
            source=table,
            view=loud,
            marker="x",
            size=8,
            line_width=2,
            color=COLOURS["vermillion"],
            legend_label="above the limit",
        )  # fmt: skip
    )
    fig.add_layout(
        Span(location=1.0, dimension="width", line_color="black", line_dash="dashed", line_width=1.2)
    )
    fig.y_range.start, fig.y_range.end = LOWEST, max(3.0, 1.3 * float(np.nanmax(ratio, initial=1.0)))
    says = {"Test": "@name", "Statistic / limit": "@y{0.00}", "Alarm by": "@why"}
    hover(fig, drawn, says)


def _shade(fig: Any, watched: Watched, x: Any) -> None:
    """The baseline, as the stretches in which its tests follow each other."""
    from bokeh.models import BoxAnnotation

    own = watched.baseline
    breaks = np.flatnonzero(np.diff(own) > 2 + len(watched.failed))
    for a, b in zip([0, *(breaks + 1)], [*breaks, own.size - 1], strict=True):
        fig.add_layout(
            BoxAnnotation(
                left=float(x[own[a]]), right=float(x[own[b]]), fill_color="#EDEDED", level="underlay"
            )
        )


def _dates(fig: Any) -> None:
    from bokeh.models import DatetimeTicker, DatetimeTickFormatter

    fig.xaxis.ticker = DatetimeTicker()
    fig.xaxis.formatter = DatetimeTickFormatter()
