"""Panels as pictures: their axes, marks and legends with matplotlib, and the way to a PNG."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from io import BytesIO
from typing import Any

import numpy as np

from ..io.common import require
from ..support.checks import FloatArray, frequency_band
from . import marks


def new_axes(ax: Any, size_in: tuple[float, float]) -> Any:
    """The axes given, or those of a new pyplot figure of this size in inches."""
    require("a picture", "matplotlib", "plot")
    if ax is not None:
        return ax
    from matplotlib import pyplot

    return pyplot.subplots(figsize=size_in, layout="constrained")[1]


def picture(draw: Callable[..., Any], size_in: tuple[float, float], rows: int = 1, dpi: int = 160) -> bytes:
    """PNG of what ``draw`` puts into axes of their own, an array for ``rows``; pyplot learns of nothing."""
    require("a picture", "matplotlib", "plot")
    from matplotlib.figure import Figure
    from matplotlib.text import Text

    figure = Figure(figsize=size_in, layout="constrained")
    draw(figure.subplots(rows, 1))
    # Names of channels and sections are no formulas, whatever dollars they have; those of axes stay.
    for text in figure.findobj(Text):
        if "$" in text.get_text() and "\\mathdefault" not in text.get_text():
            text.set_parse_math(False)
    file = BytesIO()
    # Without the version of matplotlib in the file the same picture has the same bytes.
    figure.savefig(file, format="png", dpi=dpi, metadata={"Software": None})
    return file.getvalue()


# -- A panel drawn into axes


def draw(panel: marks.Panel, ax: Any, *, drop_pt: float | None = None, legend: bool = True) -> Any:
    """Draw a panel; its legend stands ``drop_pt`` points under the axes."""
    draw_marks(ax, panel.marks)
    for which, axis in (("x", panel.x), ("y", panel.y)):
        ax.set(**{f"{which}label": axis.label} | ({f"{which}scale": "log"} if axis.log else {}))
        if axis.at is not None or axis.names is not None:
            look = {"rotation": 90} if axis.upright else {}
            getattr(ax, f"set_{which}ticks")(axis.places, axis.names, **look)
            ax.tick_params(axis="x", pad=7)  # clear of what stands at 0
        if axis.limits is not None:
            ax.set(**{f"{which}lim": axis.limits})
    if panel.grid:
        ax.grid(axis=panel.grid, alpha=0.25)
        ax.set_axisbelow(True)
    if panel.equal:
        ax.set_aspect("equal", adjustable="datalim")
    if panel.title:
        ax.set_title(panel.title, fontsize="medium")
    if panel.behind is not None:  # on a twin axis, but in the legend of the front one
        axis, curve = panel.behind
        behind = ax.twinx()
        behind.plot(curve.x, curve.y, color=curve.colour, lw=curve.width)
        behind.set_yscale("log" if np.isfinite(curve.y).any() else "linear")
        behind.set_ylabel(axis.label, color="#595959")
        ax.set_zorder(behind.get_zorder() + 1)
        ax.patch.set_visible(False)
        ax.plot([], [], color=curve.colour, lw=curve.width, label=curve.label)
    if drop_pt is None:
        names = panel.x.names or [""]
        drop_pt = 34.0 + text_width_pt(max(names, key=len), 10.0) if panel.x.upright else 42.0
    if legend and ax.get_legend_handles_labels()[1]:
        below(ax, drop_pt=drop_pt, first=panel.first)
    return ax


def draw_marks(ax: Any, drawn: Sequence[marks.Mark], zorder: float = 2.0) -> None:
    """Draw marks on each other, from ``zorder`` on."""
    for nth, mark in enumerate(drawn):
        if mark.only != "page":
            getattr(_Drawn(ax), type(mark).__name__.lower())(mark, zorder + 0.05 * nth)


def dash_of(dash: Any) -> Any:
    """A dash of the marks as matplotlib has it."""
    return dash if isinstance(dash, str) else (0, dash)


class _Drawn:
    """How each mark is drawn, by its name."""

    def __init__(self, ax: Any) -> None:
        self.ax = ax

    def points(self, mark: marks.Points, zorder: float) -> None:
        look: dict[str, Any] = {} if mark.face is None else {"mfc": mark.face}
        look |= {"marker": mark.marker, "ms": mark.size, "color": mark.colour, "mew": mark.stroke}
        look |= {"ls": dash_of(mark.link), "clip_on": not mark.spill, "zorder": zorder, "label": mark.label}
        if mark.error is None:
            self.ax.plot(mark.x, mark.y, **look)
        else:
            self.ax.errorbar(mark.x, mark.y, mark.error, elinewidth=1.2, capsize=3.0, **look)

    def line(self, mark: marks.Line, zorder: float) -> None:
        look = {"color": mark.colour, "ls": dash_of(mark.dash), "lw": mark.width, "label": mark.label}
        look |= {"drawstyle": "steps-post"} if mark.steps else {}
        self.ax.plot(mark.x, mark.y, zorder=zorder, **look)

    def bars(self, mark: marks.Bars, zorder: float) -> None:
        look = {"facecolor": mark.face, "edgecolor": mark.edge, "hatch": mark.hatch, "ls": dash_of(mark.dash)}
        draw_bars = self.ax.barh if mark.sideways else self.ax.bar
        draw_bars(mark.at, mark.length, mark.width, linewidth=0.8, zorder=zorder, label=mark.label, **look)

    def rules(self, mark: marks.Rules, zorder: float) -> None:
        for nth, at in enumerate(np.atleast_1d(mark.at)):
            label = mark.label if nth == 0 else None
            look = {"color": mark.colour, "ls": dash_of(mark.dash), "lw": mark.width, "label": label}
            (self.ax.axvline if mark.upright else self.ax.axhline)(at, zorder=zorder, **look)

    def bands(self, mark: marks.Bands, zorder: float) -> None:
        look = {"facecolor": mark.face, "edgecolor": "#BFBFBF", "hatch": mark.hatch, "lw": 0.0, "zorder": 0}
        for nth, (low, high) in enumerate(zip(mark.low, mark.high, strict=True)):
            self.ax.axvspan(low, high, label=mark.label if nth == 0 else f"_{mark.label}", **look)

    def words(self, mark: marks.Words, zorder: float) -> None:
        from matplotlib.patheffects import withStroke

        way, across, along = marks.BESIDE[mark.where]
        look = {"fontsize": mark.size, "color": mark.colour, "ha": across, "va": along, "zorder": zorder}
        look |= {"fontstyle": "italic" if mark.slanted else "normal", "rotation": 90 if mark.turned else 0}
        if mark.halo:
            look["path_effects"] = [withStroke(linewidth=4.0, foreground="white")]
        for x, y, text in zip(mark.x, mark.y, mark.texts, strict=True):
            offset = (mark.away * way[0], mark.away * way[1])
            self.ax.annotate(text, (x, y), xytext=offset, textcoords="offset points", **look)

    def heads(self, mark: marks.Heads, zorder: float) -> None:
        look: dict[str, Any] = {"xytext": (0, 4), "textcoords": "offset points", "fontsize": "small"}
        look |= {"ha": "center", "va": "bottom", "xycoords": self.ax.get_xaxis_transform()}
        for nth, (x, text) in enumerate(zip(mark.x, mark.texts, strict=True)):
            look["fontweight"] = "bold" if nth < len(mark.bold) and mark.bold[nth] else "normal"
            self.ax.annotate(text, (x, 1.0), **look)

    def paths(self, mark: marks.Paths, zorder: float) -> None:
        if mark.values is not None:
            _coloured(self.ax, mark, zorder)
            return
        # One line with gaps, so that dashes go on over elements that follow each other.
        points: list[FloatArray] = []
        for path in mark.paths:
            if not points or np.any(points[-1] != path[0]):
                points += [np.full(2, np.nan), path[0]]
            points += list(path[1:])
        whole = np.array(points[1:]).reshape(-1, 2).T
        look = {"lw": mark.width, "solid_capstyle": "round", "dash_capstyle": "butt"}
        if mark.dash != "-":  # what is pale underneath keeps the structure in one piece
            self.ax.plot(*whole, color="#D5D5D5", zorder=zorder - 0.1, **look)
        look |= {"color": mark.colour, "ls": dash_of(mark.dash)}
        self.ax.plot(*whole, zorder=zorder, label=mark.label, **look)

    def faces(self, mark: marks.Faces, zorder: float) -> None:
        from matplotlib.cm import ScalarMappable
        from matplotlib.collections import PolyCollection

        edges = np.where((mark.widths >= 1.0)[:, None], mark.colours, 0.3)
        look = {"linewidths": mark.widths, "edgecolors": edges, "capstyle": "round", "zorder": zorder}
        smooth = bool(mark.widths.all())  # else gaps would show between faces without an outline
        corners: Any = mark.corners  # as an array they are taken many times as fast
        drawn = PolyCollection(corners, facecolors=mark.colours, antialiaseds=smooth, **look)
        self.ax.add_collection(drawn)
        self.ax.autoscale_view()
        if mark.values is not None:
            shades = ScalarMappable(cmap=_colour_map())
            _scale(self.ax, shades, mark.values[np.isfinite(mark.values)], mark.scale)

    def arrows(self, mark: marks.Arrows, zorder: float) -> None:
        from matplotlib.patheffects import withStroke

        look = {"arrowstyle": "-|>", "color": mark.colour, "lw": mark.width, "shrinkA": 0, "shrinkB": 2}
        if mark.halo:
            look["path_effects"] = [withStroke(linewidth=mark.width + 2.5, foreground="white")]
        for tail, head in zip(mark.tails, mark.heads, strict=True):
            self.ax.annotate("", head, xytext=tail, arrowprops=look, zorder=zorder)
        self.ax.update_datalim([*mark.tails, *mark.heads])  # which annotations do not count for
        self.ax.autoscale_view()
        self.ax.plot([], [], ls="", marker=r"$\rightarrow$", ms=13, color=mark.colour, label=mark.label)


def _coloured(ax: Any, mark: marks.Paths, zorder: float) -> None:
    """Elements, each in the colour of its value, with the scale; thin where there is none."""
    from matplotlib.collections import LineCollection

    values = np.asarray(mark.values)
    known = np.isfinite(values)
    if not known.all():
        rest = [path for path, one in zip(mark.paths, known, strict=True) if not one]
        look = {"colors": marks.INKS["grey"], "linewidths": 1.2, "label": "without a value"}
        ax.add_collection(LineCollection(rest, zorder=zorder, **look))
    # The largest last, so that it lies on top where elements meet.
    order = np.flatnonzero(known)[np.argsort(values[known], kind="stable")]
    look = {"linewidths": mark.width, "cmap": _colour_map()}
    lines = LineCollection([mark.paths[e] for e in order], zorder=zorder, **look)
    lines.set_array(values[order])
    ax.add_collection(lines)
    ax.autoscale_view()
    _scale(ax, lines, values[known], mark.scale)


def _colour_map() -> Any:
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("loss", marks.SCALE)


def _scale(ax: Any, drawn: Any, values: FloatArray, label: str) -> None:
    """Limits of the colours of what was drawn, and the bar that tells them."""
    if not values.any():  # a scale from 0 to 0 would say nothing
        drawn.set_clim(0.0, 1.0)
        nothing = "0 in every element" if values.size else "none given"
        ax.set_title(f"{label}: {nothing}", fontsize="medium")
        return
    drawn.set_clim(min(0.0, float(values.min())), max(0.0, float(values.max())))
    ax.figure.colorbar(drawn, ax=ax, label=label, shrink=0.8)


def width_pt(ax: Any) -> float:
    """Width that the axes will have, roughly: a constrained layout gives them more than they have now."""
    wide = 1.15 if ax.figure.get_layout_engine() is not None else 1.0
    return float(72.0 * wide * ax.get_position().width * ax.figure.bbox.width / ax.figure.dpi)


def band_shown(freq_hz: FloatArray, band_hz: Sequence[float] | None) -> tuple[float, float]:
    """The band asked for, inside the data; all of them by default."""
    low, high = float(freq_hz[0]), float(freq_hz[-1])
    return (low, high) if band_hz is None else frequency_band("band_hz", band_hz, low_hz=low, high_hz=high)


@lru_cache(maxsize=1000)
def text_width_pt(text: str, size_pt: float = 8.33) -> float:
    """Width of the longest line of a text, small by default."""
    from matplotlib.textpath import TextPath

    lines = [line.replace("$", r"\$") for line in text.split("\n") if line.strip()]
    widths = [TextPath((0.0, 0.0), line, size=size_pt).get_extents().width for line in lines]
    return float(max(widths, default=0.0))


def fit_across(ax: Any, names: Sequence[str], size_pt: float = 10.0) -> bool:
    """Whether evenly spaced labels fit side by side under the axes."""
    return len(names) * (text_width_pt(max(names, key=len, default=""), size_pt) + 8.0) <= width_pt(ax)


def below(ax: Any, *, drop_pt: float = 40.0, first: Sequence[str] = ()) -> None:
    """Legend ``drop_pt`` points under the axes, in as many columns as fit; ``first`` leads in that order."""
    from matplotlib.transforms import ScaledTranslation

    entries = list(zip(*ax.get_legend_handles_labels(), strict=True))
    entries.sort(key=lambda entry: first.index(entry[1]) if entry[1] in first else len(first))
    # Points, not a share of the height: the tick labels in between do not grow with the axes.
    under = ax.transAxes + ScaledTranslation(0.0, -drop_pt / 72.0, ax.figure.dpi_scale_trans)
    handles, labels = [entry[0] for entry in entries], [entry[1] for entry in entries]
    widths = np.array([text_width_pt(label) + 45.0 for label in labels])  # with the handle and its gaps
    counts = [-(-widths.size // rows) for rows in range(1, widths.size)]  # in as few rows as can be
    fits = (sum(each.max() for each in np.array_split(widths, n)) <= 1.05 * width_pt(ax) for n in counts)
    columns = next((n for n, fit in zip(counts, fits, strict=True) if fit), 1)
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.0), "bbox_transform": under}
    look = {"frameon": False, "borderaxespad": 0.0, "fontsize": "small"}
    ax.legend(handles, labels, ncols=columns, **place, **look)


def plain_log(axis: Any) -> None:
    """Plain numbers on a logarithmic axis; on one of less than two decades between these too."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axis.get_view_interval()
    narrow = high < 80.0 * low
    plain = FuncFormatter(lambda value, _: f"{value:g}")
    axis.set_major_formatter(plain)
    if narrow:
        axis.set_minor_locator(LogLocator(subs=(2.0, 3.0, 5.0, 7.0)))
    axis.set_minor_formatter(plain if narrow else NullFormatter())
