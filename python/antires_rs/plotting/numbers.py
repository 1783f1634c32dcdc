"""Where the numbers of elements go: beside the element, clear of arrows, markers and each other."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.validation import FloatArray

__all__ = ["around", "beside", "points_per_unit"]

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

    Examples
    --------
    >>> import numpy as np
    >>> element, arrow = [[0.0, 0.0], [100.0, 0.0]], [[50.0, 25.0], [50.0, 0.0]]
    >>> beside(np.array([element]), np.empty((0, 2, 2))).tolist()
    [[50.0, 7.0]]
    >>> beside(np.array([element]), np.array([arrow])).tolist()
    [[50.0, -7.0]]
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

    Examples
    --------
    >>> import numpy as np
    >>> (place,) = around(np.zeros((1, 2)), np.array([[[0.0, 0.0], [50.0, 0.0]]]))
    >>> float(np.abs(place).max()) < 15.0 and bool(place[1] < 0.0)
    True
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
