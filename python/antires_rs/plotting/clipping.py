"""Where an axis ends when a few values are so far off that they would flatten all others."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.validation import FloatArray

__all__ = ["clip_bars", "reach"]

#: A value this many times the next smaller one stands apart.
APART = 2.5
#: At most this share of the values is cut off, one in any case, unless the others are next to nothing.
MOST_CUT, LEAST = 0.15, 0.01


def reach(values: Any, margin: float = 1.25) -> float:
    """Largest absolute value that an axis has to show, with its margin; infinite if it shows all.

    Values are cut off where a gap sets few of them apart: then the axis is made for the others.

    Examples
    --------
    >>> reach([517.0, 12.0, -8.0, 3.0, 1.0])
    15.0
    >>> reach([12.0, -8.0, 3.0, 1.0])
    inf
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
