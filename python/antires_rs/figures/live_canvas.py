"""Panels as figures to be explored, with bokeh: paper, marks, hover, legends, and the ways into a page.

What stands in :func:`columns` goes to the browser in single precision. A page takes :func:`item` of a figure
and loads :func:`script_files`, or holds their texts. bokeh is imported in functions only.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..io.common import require
from . import marks

INK, GRID = "#222222", "#E3E3E3"  # ink of text and axes, grid lines
FONT = "system-ui, 'Segoe UI', 'Liberation Sans', Arial, sans-serif"
LEGEND: dict[str, Any] = {"location": "left", "border_line_color": None, "padding": 0, "margin": 0}
LEGEND |= {"spacing": 5, "label_text_font": FONT, "label_text_font_size": "12px"}
PX_A_LETTER = 6  # along an upright axis
MOST_LETTERS = 40  # of a text above a figure
LEFT_PX, RIGHT_PX = 64, 58  # room beside the plotted area, the same for figures that stand on each other


def require_bokeh() -> None:
    """Refuse with the name of the extra where bokeh is not there."""
    require("a figure to be explored", "bokeh", "look")


def columns(**values: Any) -> Any:
    """A table behind glyphs, ``bokeh.models.ColumnDataSource``: one length, numbers in single precision."""
    require_bokeh()
    from bokeh.models import ColumnDataSource

    table = {}
    for name, column in values.items():
        array = np.asarray(column)
        slim = array.astype(np.float32) if array.dtype.kind == "f" else array
        table[name] = array.tolist() if array.dtype.kind in "USObiu" else slim
    return ColumnDataSource(table)


def hover(fig: Any, renderers: Sequence[Any], says: Mapping[str, str], **options: Any) -> Any:
    """Say something of what the pointer is on."""
    from bokeh.models import HoverTool

    tool = HoverTool(renderers=list(renderers), tooltips=list(says.items()), visible=False, **options)
    fig.add_tools(tool)
    return tool


def below(fig: Any, *, side_by_side: int = 2) -> None:
    """Move the legend under the figure; a click on an entry hides what it is of. Two fit on a telephone."""
    for legend in list(fig.legend):
        fig.center.remove(legend)  # bokeh 3.4 leaves it there too
        fig.add_layout(legend, "below")
        legend.update(ncols=side_by_side, click_policy="hide", label_text_color=INK, **LEGEND)


LINE_PX, MARKER_PX = 1.25, 1.6  # pixels for a point of a line, and of a marker
#: Names of dashes, markers and hatches, by those of the marks.
_DASHES = {"-": "solid", "--": "dashed", "-.": "dashdot", ":": "dotted"}
_MARKERS = {"o": "circle", ".": "circle", "x": "x", "s": "square", "D": "diamond"}
_MARKERS |= {"^": "triangle", "v": "inverted_triangle", "|": "dash"}
_HATCHES = {"": " ", "/": "right_diagonal_line", ".": "dot", "x": "cross"}


def explored(panel: marks.Panel, *, height: int = 320, x_range: Any = None, side_by_side: int = 2) -> Any:
    """A panel as a figure as wide as its place; ``x_range`` ties it to another one."""
    require_bokeh()
    from bokeh.models import BoxZoomTool, PanTool, ResetTool, SaveTool, WheelZoomTool
    from bokeh.plotting import figure

    x, y = panel.x, panel.y
    given: dict[str, Any] = {"x_range": x.limits if x_range is None else x_range, "y_range": y.limits}
    given = {key: value for key, value in given.items() if value is not None}
    given |= {"x_axis_type": "datetime" if x.dated else "log" if x.log else "auto", "x_axis_label": x.label}
    given |= {"y_axis_type": "log" if y.log else "auto", "y_axis_label": y.label, "match_aspect": panel.equal}
    given |= {"sizing_mode": "stretch_width", "min_border_left": LEFT_PX, "min_border_right": 18}
    fig = figure(height=height, tools=[], toolbar_location="above", name=panel.name, **given)
    box, wheel = BoxZoomTool(), WheelZoomTool(dimensions="both" if panel.equal else "width")
    fig.add_tools(box, PanTool(), wheel, ResetTool(), SaveTool())
    fig.toolbar.active_drag, fig.toolbar.logo = box, None
    fig.outline_line_color, fig.grid.grid_line_color = "#9A9A9A", GRID
    for axis in fig.axis:
        axis.axis_label_text_font_style, axis.minor_tick_line_color = "normal", None
        axis.axis_label_text_font_size = axis.major_label_text_font_size = "12px"
        axis.axis_label_text_font = axis.major_label_text_font = FONT
        axis.axis_label_text_color = axis.major_label_text_color = INK
    fig.title.text_font, fig.title.text_font_size, fig.title.text_color = FONT, "12px", INK
    fig.title.text, fig.title.text_font_style = panel.title, "normal"
    if len(y.label) > height // PX_A_LETTER and not panel.title:
        said, _, unit = y.label.rpartition(" (")
        said = said or y.label  # without its middle, where it would push the tools out of a narrow window
        fig.title.text = said if len(said) <= MOST_LETTERS else f"{said[: MOST_LETTERS - 16]}…{said[-15:]}"
        fig.yaxis.axis_label = f"({unit}" if " (" in y.label else ""
    if panel.behind is not None:
        _draw_behind(fig, *panel.behind)
    curves = sum(isinstance(mark, marks.Line) and bool(mark.says) for mark in panel.marks)
    for mark in panel.marks:
        if mark.only != "picture":
            draw = getattr(_Drawn(fig), type(mark).__name__.lower())
            drawn = draw(mark, {} if mark.label is None else {"legend_label": mark.label})
            if mark.says:
                mode = "vline" if isinstance(mark, marks.Line) and curves == 1 else "mouse"
                hover(fig, drawn, mark.says, mode=mode)
    for axis, of, grid in ((fig.xaxis, x, fig.xgrid), (fig.yaxis, y, fig.ygrid)):
        if of.at is not None or of.names is not None:
            axis.ticker = ticks = [float(place) for place in of.places]
        if of.names is not None:
            axis.major_label_overrides = dict(zip(ticks, of.names, strict=True))
            axis.major_label_orientation = np.pi / 2 if of.upright else "horizontal"
            grid.grid_line_color = None
    if fig.legend:
        below(fig, side_by_side=side_by_side)
    return fig


def _draw_behind(fig: Any, axis: marks.Axis, curve: marks.Line) -> None:
    """On a logarithmic axis of its own at the right."""
    from bokeh.models import LogAxis, LogScale, Range1d

    size = np.asarray(curve.y)
    if not np.isfinite(size).any():
        return
    fig.extra_y_ranges = {"behind": Range1d(0.7 * float(np.nanmin(size)), 1.4 * float(np.nanmax(size)))}
    fig.extra_y_scales = {"behind": LogScale()}
    look = {"axis_label_text_font_style": "normal", "axis_label_text_font_size": "12px"}
    grey = {"axis_label_text_color": "#595959", "major_label_text_color": "#595959"}
    fig.add_layout(LogAxis(y_range_name="behind", axis_label=axis.label, **look, **grey), "right")
    _Drawn(fig).line(curve, {"legend_label": curve.label, "y_range_name": "behind"})


def dash_of(dash: Any) -> Any:
    """A dash of the marks as bokeh names it; versions of 3.6 and before take a list for data."""
    return _DASHES[dash] if isinstance(dash, str) else " ".join(str(2 * length) for length in dash)


def _stroke(mark: marks.Line | marks.Rules | marks.Paths) -> dict[str, Any]:
    return {"line_color": mark.colour, "line_dash": dash_of(mark.dash), "line_width": LINE_PX * mark.width}


def _fill(mark: marks.Bars | marks.Bands, ink: str | None) -> dict[str, Any]:
    face = {"fill_alpha": 0.0} if mark.face == "none" else {"fill_color": mark.face}
    return face | {"hatch_pattern": _HATCHES[mark.hatch[:1]], "hatch_color": ink, "hatch_scale": 8}


class _Drawn:
    """How each mark is drawn, by its name; what there is to hover over."""

    def __init__(self, fig: Any) -> None:
        self.fig = fig

    def points(self, mark: marks.Points, label: dict[str, Any]) -> list[Any]:
        table = columns(x=mark.x, y=mark.y, **mark.more)
        share = 0.8 if mark.marker == "." else 1.0
        look = {"size": share * MARKER_PX * mark.size, "line_color": mark.colour, "line_width": mark.stroke}
        look |= {"fill_alpha": 0.0} if mark.face == "none" else {"fill_color": mark.face or mark.colour}
        look |= {"angle": np.pi / 2} if mark.marker == "|" else {}
        marker = _MARKERS.get(mark.marker, "circle_dot")
        if mark.error is not None:
            ends = {"low": mark.y - np.asarray(mark.error), "high": mark.y + np.asarray(mark.error)}
            bars = {"source": columns(x=mark.x, **ends), "color": mark.colour, "line_width": 1.6} | label
            tips = [self.fig.scatter("x", end, marker="dash", size=13, **bars) for end in ends]
            drawn = [self.fig.segment("x", "low", "x", "high", **bars), *tips]
            if not mark.marker:
                return drawn
        return [self.fig.scatter("x", "y", source=table, marker=marker, **look, **label)]

    def line(self, mark: marks.Line, label: dict[str, Any]) -> list[Any]:
        table = columns(x=mark.x, y=mark.y, **mark.more)
        draw, how = (self.fig.step, {"mode": "after"}) if mark.steps else (self.fig.line, {})
        return [draw("x", "y", source=table, **how, **_stroke(mark), **label)]

    def bars(self, mark: marks.Bars, label: dict[str, Any]) -> list[Any]:
        table = columns(x=mark.at, y=mark.length, **mark.more)
        look = _fill(mark, mark.edge) | {"line_color": mark.edge, "line_dash": dash_of(mark.dash)}
        if mark.sideways:
            return [self.fig.hbar(y="x", right="y", height=mark.width, source=table, **look, **label)]
        return [self.fig.vbar(x="x", top="y", width=mark.width, source=table, **look, **label)]

    def rules(self, mark: marks.Rules, label: dict[str, Any]) -> list[Any]:
        table = columns(at=np.atleast_1d(mark.at), **mark.more)
        draw, which = (self.fig.vspan, "x") if mark.upright else (self.fig.hspan, "y")
        return [draw(**{which: "at"}, source=table, **_stroke(mark), **label)]

    def bands(self, mark: marks.Bands, label: dict[str, Any]) -> list[Any]:
        table = columns(low=mark.low, high=mark.high, **mark.more)
        look = _fill(mark, marks.INKS["pale"]) | label
        return [self.fig.vstrip(x0="low", x1="high", source=table, line_alpha=0.0, **look)]

    def words(self, mark: marks.Words, label: dict[str, Any]) -> list[Any]:
        (x, y), across, along = marks.BESIDE[mark.where]
        look = {"x_offset": 1.3 * x * mark.away, "y_offset": -1.3 * y * mark.away, "text_color": mark.colour}
        look |= {"text_font_size": f"{1.3 * mark.size:.0f}px", "text_align": across}
        look |= {"text_baseline": along.replace("center", "middle")}
        look |= {"text_font_style": "italic"} if mark.slanted else {}
        table = columns(x=mark.x, y=mark.y, text=list(mark.texts))
        return [self.fig.text("x", "y", "text", source=table, **look)]

    def heads(self, mark: marks.Heads, label: dict[str, Any]) -> list[Any]:
        table = columns(x=mark.x, label=list(mark.texts))
        edge_labels(self.fig, table, text_font_size="10px", text_color="#444444")
        return []

    def paths(self, mark: marks.Paths, label: dict[str, Any]) -> list[Any]:
        from bokeh.models import ColorBar, LinearColorMapper
        from bokeh.palettes import interp_palette

        table = columns(**mark.more)
        for name, column in (("xs", 0), ("ys", 1)):
            table.data[name] = [path[:, column].tolist() for path in mark.paths]
        if mark.values is None:
            return [self.fig.multi_line("xs", "ys", source=table, **_stroke(mark), **label)]
        value = np.asarray(mark.values)
        known = np.isfinite(value)
        table.data["value"] = np.where(known, value, 0.0).astype(np.float32)
        table.data["width"] = np.where(known, LINE_PX * mark.width, 1.5).astype(np.float32)
        top = float(value[known].max(initial=0.0))
        mapper = LinearColorMapper(palette=interp_palette(marks.SCALE, 64), low=0.0, high=top or 1.0)
        colour = {"field": "value", "transform": mapper}
        if top > 0.0:
            look = {"width": 10, "title": mark.scale.rpartition("(")[2].rstrip(")"), "padding": 2}
            look |= {"major_label_text_font_size": "11px"}
            self.fig.add_layout(ColorBar(color_mapper=mapper, **look), "right")
        else:
            self.fig.title.update(text=f"{mark.scale}: 0 in every element", text_font_style="normal")
        return [self.fig.multi_line("xs", "ys", source=table, line_width="width", line_color=colour)]

    def arrows(self, mark: marks.Arrows, label: dict[str, Any]) -> list[Any]:
        from bokeh.models import Arrow, NormalHead

        (x0, y0), (x1, y1) = np.transpose(mark.tails), np.transpose(mark.heads)
        ends = {"x_start": "x0", "y_start": "y0", "x_end": "x1", "y_end": "y1"}
        table = columns(x0=x0, y0=y0, x1=x1, y1=y1, **mark.more)
        width = LINE_PX * mark.width
        look = {"source": table, "color": mark.colour, "line_width": width} | label
        shaft = self.fig.segment("x0", "y0", "x1", "y1", **look)
        head = NormalHead(size=9, fill_color=mark.colour, line_color=mark.colour)
        self.fig.add_layout(Arrow(end=head, source=table, line_alpha=0.0, **ends))
        return [shaft]


def edge_labels(fig: Any, table: Any, **look: Any) -> None:
    """Upright texts of a table's column ``label`` at its ``x``, on the lower edge of whatever is shown."""
    from bokeh.core.properties import value
    from bokeh.models import LabelSet

    given = {name: value(one) for name, one in {"text_font": FONT, **look}.items()}
    upright = {"angle": np.pi / 2, "text_baseline": "bottom", "x_offset": -3, "y_units": "screen"}
    fig.add_layout(LabelSet(x="x", y=value(5), text="label", source=table, **upright, **given))


def stacked(figures: Sequence[Any]) -> Any:
    """Figures on top of each other, as wide as their place; give them one ``x_range`` to tie them."""
    from bokeh.models import Column

    for fig in figures:
        fig.min_border_right = RIGHT_PX
    return Column(children=list(figures), sizing_mode="stretch_width")


def item(figure: Any) -> dict[str, Any]:
    """A figure as plain data, for ``Bokeh.embed.embed_item`` of a page."""
    from bokeh.embed import json_item

    return dict(json_item(figure))


def script_files() -> list[Path]:
    """What a browser needs to draw the figures: a file of the installed package, no address."""
    require_bokeh()
    from bokeh.resources import Resources

    return [Path(file) for file in Resources(mode="absolute", components=["bokeh"], minified=True).js_files]
