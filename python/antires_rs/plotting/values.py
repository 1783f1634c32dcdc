"""Colours of elements by a value of each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..support.validation import FloatArray, integer, real_array, reject
from .canvas import GREY

__all__ = ["coloured", "value_by_element"]

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
