"""What all figures to be explored share: paper, palette, hover, legends, and the ways into a page.

A figure file holds one function, ``NAME_figure(value, ...)``, which returns a figure of Bokeh (or a column of
them, :func:`stacked`)::

    def losses_figure(result):
        fig = paper("Element (-)", "Stiffness loss (%)", height=320)
        table = columns(element=elements, loss=100.0 * losses, name=names)
        bars = fig.vbar(x="element", top="loss", width=0.8, source=table, color=COLOURS["blue"])
        hover(fig, [bars], {"Element": "@name", "Loss": "@loss{0.0} %"})
        below(fig)
        return fig

Units stand in the labels of axes and in what hover says. Kinds of things differ by marker, dash or hatch as
well as by colour, so that they are told apart in grey. What stands in ``columns`` goes to the browser in
single precision. A page takes :func:`item` of a figure and loads :func:`script_files`; a file that stands
alone takes :func:`parts` and the texts of :func:`script_files`. bokeh is imported in functions only.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import MissingDependencyError

#: Dash patterns to go with the colours.
DASHES: tuple[Any, ...] = ("solid", "dashed", "dashdot", "dotted", [12, 4], [2, 6])
#: Ink of text and axes, grid lines.
INK, GRID = "#222222", "#E3E3E3"
FONT = "system-ui, 'Segoe UI', 'Liberation Sans', Arial, sans-serif"
#: Along an upright axis.
PX_A_LETTER = 6
#: Of a text above a figure.
MOST_LETTERS = 40
#: Room left of and right of the plotted area in pixels, the same for figures that stand on each other.
LEFT_PX, RIGHT_PX = 64, 58


def require_bokeh() -> None:
    """Refuse with the name of the extra where bokeh is not there."""
    known = sys.modules.get("bokeh", ...)
    # Without importing it, which takes half a second.
    there = find_spec("bokeh") is not None if known is ... else known is not None
    if not there:
        raise MissingDependencyError(
            'figures to be explored need bokeh; install it with: pip install "antires-rs[look]"'
        )


def paper(
    x: str,
    y: str,
    *,
    height: int = 320,
    x_range: Any = None,
    y_range: Any = None,
    x_log: bool = False,
    y_log: bool = False,
    name: str | None = None,
    equal: bool = False,
) -> Any:
    """An empty figure as wide as its place."""
    require_bokeh()
    from bokeh.models import BoxZoomTool, PanTool, ResetTool, SaveTool, WheelZoomTool
    from bokeh.plotting import figure

    given = {"x_range": x_range, "y_range": y_range}
    fig = figure(
        height=height,
        sizing_mode="stretch_width",
        x_axis_type="log" if x_log else "auto",
        y_axis_type="log" if y_log else "auto",
        x_axis_label=x,
        y_axis_label=y,
        tools=[],
        toolbar_location="above",
        match_aspect=equal,
        min_border_left=LEFT_PX,
        min_border_right=18,
        name=name,
        **{key: value for key, value in given.items() if value is not None},
    )
    box, wheel = BoxZoomTool(), WheelZoomTool(dimensions="both" if equal else "width")
    fig.add_tools(box, PanTool(), wheel, ResetTool(), SaveTool())
    fig.toolbar.active_drag = box
    fig.toolbar.logo = None
    fig.outline_line_color = "#9A9A9A"
    for axis in fig.axis:
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_font_size = axis.major_label_text_font_size = "12px"
        axis.axis_label_text_font = axis.major_label_text_font = FONT
        axis.axis_label_text_color = axis.major_label_text_color = INK
        axis.minor_tick_line_color = None
    fig.grid.grid_line_color = GRID
    if len(y) > height // PX_A_LETTER:
        said, _, unit = y.rpartition(" (")
        fig.title.text, fig.title.text_font_style = _shortened(said or y), "normal"
        fig.title.text_font, fig.title.text_font_size, fig.title.text_color = FONT, "12px", INK
        fig.yaxis.axis_label = f"({unit}" if said else ""
    return fig


def _shortened(text: str) -> str:
    """A text without its middle, where it would push the tools out of a narrow window."""
    return text if len(text) <= MOST_LETTERS else f"{text[: MOST_LETTERS - 16]}…{text[-15:]}"


def columns(**values: Any) -> Any:
    """A table behind glyphs, ``bokeh.models.ColumnDataSource``: one length, numbers in single precision."""
    require_bokeh()
    from bokeh.models import ColumnDataSource

    return ColumnDataSource({name: _slim(column) for name, column in values.items()})


def _slim(column: Any) -> Any:
    """Numbers as the browser needs them; text stays a list."""
    array = np.asarray(column)
    if array.dtype.kind == "f":
        return array.astype(np.float32)
    return array.tolist() if array.dtype.kind in "USObiu" else array


def hover(fig: Any, renderers: Sequence[Any], says: Mapping[str, str], **options: Any) -> Any:
    """Say something of what the pointer is on."""
    from bokeh.models import HoverTool

    tool = HoverTool(renderers=list(renderers), tooltips=list(says.items()), visible=False, **options)
    fig.add_tools(tool)
    return tool


def below(fig: Any, *, side_by_side: int = 2) -> None:
    """Move the legend under the figure, where it hides nothing; a click on an entry hides what it is of.

    So many entries stand ``side_by_side``: two fit on a telephone.
    """
    for legend in list(fig.legend):
        fig.add_layout(legend, "below")
        legend.ncols = side_by_side
        legend.location = "left"
        legend.click_policy = "hide"
        legend.border_line_color = None
        legend.padding = legend.margin = 0
        legend.spacing = 5
        legend.label_text_font, legend.label_text_font_size = FONT, "12px"
        legend.label_text_color = INK


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


def parts(figures: Mapping[str, Any]) -> tuple[str, dict[str, str]]:
    """One script for all figures of a page, and by name the element that stands where the figure goes."""
    from bokeh.embed import components

    script, places = components(dict(figures))
    return str(script), dict(places)


def script_files() -> list[Path]:
    """What a browser needs to draw the figures: a file of the installed package, no address."""
    require_bokeh()
    from bokeh.resources import Resources

    made = Resources(mode="absolute", components=["bokeh"], minified=True)
    return [Path(file) for file in made.js_files]
