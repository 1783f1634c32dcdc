"""What all pictures share: axes, palette, legends, their numbers, and the way to a PNG without pyplot."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from io import BytesIO
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..exceptions import MissingDependencyError, reject
from ..support.checks import FloatArray, frequency_band, integer, real_array

Table = dict[str, NDArray[Any]]

#: Okabe and Ito's palette (2008), told apart by all common kinds of colour vision; yellow, too pale for lines
#: on white, is left out.
COLOURS = {
    "blue": "#0072B2",
    "vermillion": "#D55E00",
    "green": "#009E73",
    "purple": "#CC79A7",
    "orange": "#E69F00",
    "sky": "#56B4E9",
    "black": "#000000",
}
GREY = "#8C8C8C"
#: Dash patterns to go with the colours.
LINES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)), (0, (8, 3)))


def _require_matplotlib() -> None:
    try:
        import matplotlib  # noqa: F401 - only asked whether it is there
    except ImportError as exc:
        raise MissingDependencyError(
            'pictures need matplotlib; install it with: pip install "antires-rs[plot]"'
        ) from exc


def new_axes(ax: Any, size_in: tuple[float, float]) -> Any:
    """The axes given, or those of a new pyplot figure of this size in inches."""
    _require_matplotlib()
    if ax is not None:
        return ax
    from matplotlib import pyplot

    return pyplot.subplots(figsize=size_in, layout="constrained")[1]


def picture(
    draw: Callable[..., Any], size_in: tuple[float, float], *, rows: int = 1, dpi: int = 160
) -> bytes:
    """PNG of what ``draw`` puts into the axes of a figure of its own (an array of axes if ``rows > 1``).

    Reports and the demo use it: pyplot neither learns of the figure nor has to be told to forget it.
    """
    _require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=size_in, layout="constrained")
    draw(figure.subplots(rows, 1))
    _names_as_they_are(figure)
    file = BytesIO()
    # Without the version of matplotlib in the file the same picture has the same bytes.
    figure.savefig(file, format="png", dpi=dpi, metadata={"Software": None})
    return file.getvalue()


def _names_as_they_are(figure: Any) -> None:
    """Names of channels and sections are no formulas, whatever dollars they have; those of axes stay."""
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        if "$" in text.get_text() and "\\mathdefault" not in text.get_text():
            text.set_parse_math(False)


_offered: WeakKeyDictionary[Any, dict[str, Table]] = WeakKeyDictionary()


def offer(ax: Any, **tables: Mapping[str, Any]) -> None:
    """Keep the numbers of a picture for :func:`data_of`; a picture drawn over another adds its own."""
    made = {
        name: {column: np.array(values) for column, values in table.items()} for name, table in tables.items()
    }
    for column in (column for table in made.values() for column in table.values()):
        column.setflags(write=False)
    _offered.setdefault(ax, {}).update(made)


def data_of(ax: Any) -> dict[str, Table]:
    """Return the numbers behind a picture, for a table, a file or a picture of your own.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Returned by any function of this module.

    Returns
    -------
    dict of str to dict of str to ndarray
        Tables by name and their columns, all columns of a table of one length. The names of columns end in
        their unit (``freq_hz``, ``loss_percent``, ``level_db``); without one they are labels, counts or
        ratios. The arrays are read-only. ``pandas.DataFrame(data_of(ax)["bars"])`` makes a frame of a table.

    Raises
    ------
    InvalidInputError
        Axes that none of these functions has drawn into.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs import figures
    >>> from matplotlib.figure import Figure
    >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 500.0])
    >>> measured = ar.AntiresonanceSet(0, {0: [1.9, 5.2], 1: [3.1]})
    >>> ax = ar.assess_damage(intact, measured, rng=0).plot(ax=Figure().subplots())
    >>> bars = figures.data_of(ax)["bars"]
    >>> bars["element"].tolist(), list(bars)
    ([0, 1], ['element', 'name', 'loss_percent', 'smallest_seen_percent'])
    """
    try:
        return {name: dict(table) for name, table in _offered[ax].items()}
    except (KeyError, TypeError):
        reject(
            "ax",
            f"{type(ax).__name__} without a picture of antires_rs",
            "what a plot_ function returned",
            "Draw into it with a plot_ function first.",
        )


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

    return max(
        float(TextPath((0.0, 0.0), line.replace("$", r"\$"), size=size_pt).get_extents().width)
        if line.strip()
        else 0.0
        for line in text.split("\n")
    )


def fit_across(ax: Any, names: Sequence[str], size_pt: float = 10.0) -> bool:
    """Whether evenly spaced labels fit side by side under the axes."""
    longest = text_width_pt(max(names, key=len, default=""), size_pt)
    return len(names) * (longest + 8.0) <= width_pt(ax)


def _columns(widths: FloatArray, room: float) -> int:
    """Columns of a legend that fits into the room in as few rows as can be."""
    for rows in range(1, widths.size):
        count = -(-widths.size // rows)
        if sum(column.max() for column in np.array_split(widths, count)) <= room:
            return count
    return 1


def below(ax: Any, *, drop_pt: float = 40.0, first: Sequence[str] = (), **options: Any) -> None:
    """Legend ``drop_pt`` points under the axes, where it can hide nothing; as many columns as fit.

    The labels in ``first`` lead, in that order.
    """
    from matplotlib.transforms import ScaledTranslation

    entries = list(zip(*ax.get_legend_handles_labels(), strict=True))
    entries.sort(key=lambda entry: first.index(entry[1]) if entry[1] in first else len(first))
    # Points, not a share of the height: the tick labels in between do not grow with the axes.
    under = ax.transAxes + ScaledTranslation(0.0, -drop_pt / 72.0, ax.figure.dpi_scale_trans)
    handles, labels = [entry[0] for entry in entries], [entry[1] for entry in entries]
    widths = np.array([text_width_pt(label) + 45.0 for label in labels])  # with the handle and its gaps
    ax.legend(
        handles,
        labels,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=under,
        ncols=_columns(widths, 1.05 * width_pt(ax)),
        frameon=False,
        borderaxespad=0.0,
        fontsize="small",
        **options,
    )


def spread(positions: Sequence[float] | FloatArray, least: float, low: float, high: float) -> FloatArray:
    """Ascending positions moved as little as needed to be ``least`` apart and, if they fit, in the limits."""
    where = np.asarray(positions, dtype=np.float64)
    if where.size < 2:
        return where.copy()
    # With the ideal spacing taken off, "at least apart" reads "not descending": isotonic regression.
    shift = least * np.arange(where.size)
    blocks: list[tuple[float, int]] = []
    for value in where - shift:
        blocks.append((float(value), 1))
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            (b, m), (a, n) = blocks.pop(), blocks.pop()
            blocks.append(((a * n + b * m) / (n + m), n + m))
    level = np.concatenate([np.full(count, value) for value, count in blocks])
    top = high - shift[-1]
    return np.asarray((np.clip(level, low, top) if top > low else level) + shift)


def plain_log(axis: Any, *, narrow: bool) -> None:
    """Plain numbers on a logarithmic axis; on a narrow one between the decades too."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    plain = FuncFormatter(lambda value, _: f"{value:g}")
    axis.set_major_formatter(plain)
    if narrow:
        axis.set_minor_locator(LogLocator(subs=(2.0, 3.0, 5.0, 7.0)))
    axis.set_minor_formatter(plain if narrow else NullFormatter())


# -- Where an axis ends when a few values are so far off that they would flatten all others


#: A value this many times the next smaller one stands apart.
APART = 2.5
#: At most this share of the values is cut off, one in any case, unless the others are next to nothing.
MOST_CUT, LEAST = 0.15, 0.01


def reach(values: Any, margin: float = 1.25) -> float:
    """Largest absolute value that an axis has to show, with its margin; infinite if it shows all.

    Values are cut off where a gap sets few of them apart: then the axis is made for the others.
    """
    size = np.abs(np.asarray(values, dtype=np.float64).ravel())
    size = np.sort(size[np.isfinite(size)])[::-1]
    most = min(max(1, int(MOST_CUT * size.size)), size.size - 1)
    for cut in range(most, 0, -1):
        if size[cut] > LEAST and size[cut - 1] > APART * size[cut]:
            return float(margin * size[cut])
    return float("inf")


def clip_bars(ax: Any, x: FloatArray, values: FloatArray, most: float, colour: str) -> None:
    """Arrows at the edges of the axes over bars that go on beyond them, with their values.

    ``ax`` shows -most to most, or 0 to most.
    """
    for at, value in zip(x, values, strict=True):
        if np.isfinite(value) and abs(value) > most:
            up = value > 0.0
            ax.annotate(
                f"{value:+.0f} %",
                (at, 1.0 if up else 0.0),
                xycoords=ax.get_xaxis_transform(),
                xytext=(0, -24 if up else 24),
                textcoords="offset points",
                ha="center",
                va="top" if up else "bottom",
                fontsize="x-small",
                rotation=90,
                color="black",
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
                arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.4, "shrinkA": 0, "shrinkB": 0},
                zorder=6,
            )


# -- Where the numbers of elements go: beside the element, clear of arrows, markers and each other


#: Distances from the element that are tried, the room that a number needs to be clear of things, in points.
AWAY, ROOM = (7.0, 11.0, 15.0), 7.0
#: Shares of the element's length at which a number may stand.
ALONG = (0.5, 0.3, 0.7)


def points_per_unit(ax: Any, points: FloatArray, margin: float) -> float:
    """Points that one unit of the data will take in these axes, with equal scales."""
    share, size = ax.get_position(), ax.figure.get_size_inches()
    room = 72.0 * np.array([share.width * size[0], share.height * size[1]])
    return float((room / np.maximum(np.ptp(points, axis=0) * (1.0 + 2.0 * margin), 1e-300)).min())


def beside(ends: FloatArray, lines: FloatArray) -> FloatArray:
    """Places of the numbers, (n, 2), of elements ``ends`` (n, 2, 2), clear of ``lines``, all in points.

    The middle of the left side is taken unless something is in its way.
    """
    placed = np.empty((0, 2))
    for i, (a, b) in enumerate(ends):
        across = np.array([a[1] - b[1], b[0] - a[0]])
        across = across / max(float(np.linalg.norm(across)), 1e-300)
        options = np.array(
            [
                a + share * (b - a) + side * away * across
                for share in ALONG
                for away in AWAY
                for side in (1.0, -1.0)
            ]
        )
        others = np.concatenate([lines, np.delete(ends, i, axis=0), np.stack([placed, placed], axis=1)])
        clear = _distances(options, others).min(axis=1) if len(others) else np.full(len(options), np.inf)
        # The first that is clear of all, or else the one that is clearest.
        best = options[int(np.argmax(np.minimum(clear, ROOM)))]
        placed = np.vstack([placed, best])
    return placed


def around(points: FloatArray, lines: FloatArray) -> FloatArray:
    """Places of the numbers of points (n, 2), clear of ``lines`` and of each other, all in points.

    Below to the right is taken unless something is in its way.
    """
    angles = np.radians([-45.0, 135.0, 45.0, -135.0, -90.0, 90.0, 180.0, 0.0])
    ways = np.column_stack([np.cos(angles), np.sin(angles)])
    placed = np.empty((0, 2))
    for point in points:
        options = np.concatenate([point + away * ways for away in (8.0, 11.0, 15.0)])
        others = np.concatenate([lines, np.stack([placed, placed], axis=1)])
        clear = _distances(options, others).min(axis=1) if len(others) else np.full(len(options), np.inf)
        placed = np.vstack([placed, options[int(np.argmax(np.minimum(clear, 0.8 * ROOM)))]])
    return placed


def _distances(points: FloatArray, lines: FloatArray) -> FloatArray:
    """Of every point from every line, (n_points, n_lines)."""
    start, span = lines[:, 0], lines[:, 1] - lines[:, 0]
    square = np.maximum(np.sum(span**2, axis=1), 1e-300)
    off = points[:, None] - start
    share = np.clip(np.sum(off * span, axis=2) / square, 0.0, 1.0)
    return np.asarray(np.linalg.norm(off - share[:, :, None] * span, axis=2))


# -- Colours of elements by a value of each


#: From nothing, which is to be quiet, to much; lightness falls evenly, so that it reads in grey as well.
SCALE = ("#DADADA", "#A9BFD6", "#5F8DBD", "#1F5A94", "#0B2C57", "#050B16")


def value_by_element(values: Any, count: int) -> FloatArray | None:
    """A value for each of ``count`` elements, NaN where there is none; None if there are no values at all."""
    if values is None:
        return None
    if isinstance(values, Mapping):
        given = np.full(count, np.nan)
        for element, value in values.items():
            given[integer("values", element, low=0, high=count - 1)] = value
        return given
    wanted = f"a mapping from element to value, or an array ({count},)"
    array = real_array("values", values, ndim=1, wanted=wanted)
    if array.size != count:
        reject("values", f"{array.size} values", wanted, "Give a value for each element, in their order.")
    return array


def coloured(ax: Any, paths: list[FloatArray], values: FloatArray, label: str, *, width: float = 5.0) -> None:
    """Elements, each a path (n, 2), in the colour of its value, with the scale; thin where there is none."""
    from matplotlib.collections import LineCollection
    from matplotlib.colors import LinearSegmentedColormap

    known = np.isfinite(values)
    if not known.all():
        ax.add_collection(
            LineCollection(
                [paths[e] for e in np.flatnonzero(~known)],
                colors=GREY,
                linewidths=1.2,
                zorder=2,
                label="without a value",
            )
        )
    # The largest last, so that it lies on top where elements meet.
    order = np.flatnonzero(known)[np.argsort(values[known], kind="stable")]
    lines = LineCollection(
        [paths[e] for e in order],
        zorder=2,
        linewidths=width,
        cmap=LinearSegmentedColormap.from_list("loss", SCALE),
    )
    lines.set_array(values[order])
    ax.add_collection(lines)
    ax.autoscale_view()
    if not values[known].any():  # a scale from 0 to 0 would say nothing
        lines.set_clim(0.0, 1.0)
        ax.set_title(f"{label}: {'0 in every element' if known.any() else 'none given'}", fontsize="medium")
        return
    lines.set_clim(min(0.0, float(values[known].min())), max(0.0, float(values[known].max())))
    ax.figure.colorbar(lines, ax=ax, label=label, shrink=0.8)
