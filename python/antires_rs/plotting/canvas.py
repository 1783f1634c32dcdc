"""What all pictures share: axes, palette, and the way to a PNG without pyplot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from io import BytesIO
from typing import Any

import numpy as np

from .._validation import FloatArray
from ..exceptions import MissingDependencyError

__all__ = ["COLOURS", "GREY", "LINES", "below", "new_axes", "picture", "spread"]

#: Okabe and Ito's palette (2008), told apart by all common kinds of colour vision; yellow, too pale for lines
#: on white, is left out.
COLOURS = {"blue": "#0072B2", "vermillion": "#D55E00", "green": "#009E73", "purple": "#CC79A7",
           "orange": "#E69F00", "sky": "#56B4E9", "black": "#000000"}
GREY = "#8C8C8C"
#: Dash patterns to go with the colours.
LINES: tuple[Any, ...] = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)), (0, (8, 3)))


def _require_matplotlib() -> None:
    try:
        import matplotlib  # noqa: F401 - only asked whether it is there
    except ImportError as exc:
        raise MissingDependencyError(
            'pictures need matplotlib; install it with: pip install "antires-rs[plot]"') from exc


def new_axes(ax: Any, size_in: tuple[float, float]) -> Any:
    """The axes given, or those of a new pyplot figure of this size in inches."""
    _require_matplotlib()
    if ax is not None:
        return ax
    from matplotlib import pyplot
    return pyplot.subplots(figsize=size_in, layout="constrained")[1]


def picture(draw: Callable[..., Any], size_in: tuple[float, float], *, rows: int = 1,
            dpi: int = 160) -> bytes:
    """PNG of what ``draw`` puts into the axes of a figure of its own (an array of axes if ``rows > 1``).

    Reports and the demo use it: pyplot neither learns of the figure nor has to be told to forget it.
    """
    _require_matplotlib()
    from matplotlib.figure import Figure
    figure = Figure(figsize=size_in, layout="constrained")
    draw(figure.subplots(rows, 1))
    file = BytesIO()
    # Without the version of matplotlib in the file the same picture has the same bytes.
    figure.savefig(file, format="png", dpi=dpi, metadata={"Software": None})
    return file.getvalue()


def below(ax: Any, columns: int, *, drop_pt: float = 40.0, first: Sequence[str] = (),
          **options: Any) -> None:
    """Legend ``drop_pt`` points under the axes, where it can hide nothing."""
    from matplotlib.transforms import ScaledTranslation
    entries = list(zip(*ax.get_legend_handles_labels(), strict=True))
    entries.sort(key=lambda entry: first.index(entry[1]) if entry[1] in first else len(first))
    # Points, not a share of the height: the tick labels in between do not grow with the axes.
    under = ax.transAxes + ScaledTranslation(0.0, -drop_pt / 72.0, ax.figure.dpi_scale_trans)
    handles, labels = [entry[0] for entry in entries], [entry[1] for entry in entries]
    ax.legend(handles, labels, loc="upper center", bbox_to_anchor=(0.5, 0.0), bbox_transform=under,
              ncols=columns, frameon=False, borderaxespad=0.0, fontsize="small", **options)


def spread(positions: Sequence[float] | FloatArray, least: float, low: float, high: float) -> FloatArray:
    """Ascending positions moved as little as needed to be ``least`` apart and, if they fit, in the limits.

    Examples
    --------
    >>> spread([1.0, 5.0, 5.5], 1.0, 0.0, 6.0).tolist()
    [1.0, 4.75, 5.75]
    """
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
