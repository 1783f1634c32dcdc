"""Wide bands with many lines are fitted piece by piece.

A band of many thousand lines holds more modes, sideways and local ones included, than orders up to 60 can
carry; then weak antiresonances drown. It is cut into windows that overlap by half, so that every frequency
lies well inside one of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..signals.segment_length import MOST_LINES
from ..support.pickling import frozen
from ..support.validation import FloatArray
from .diagram import StabilizationDiagram
from .table import ResponseTable

WINDOW_LINES = 2500
# Values this close to a cut, as a share of the window's width, are left to the neighbour.
MARGIN = 0.05


@dataclass(frozen=True)
class Window:
    """Lines ``first`` to ``last`` (exclusive), and the frequencies whose values and poles it may report."""

    first: int
    last: int
    report_hz: tuple[float, float]
    core_hz: tuple[float, float]


def windows(freq_hz: FloatArray, band_hz: tuple[float, float]) -> list[Window]:
    """One window, or several that overlap by half."""
    n = freq_hz.size
    if n <= MOST_LINES:
        return [Window(0, n, band_hz, band_hz)]
    count = int(np.ceil(2.0 * n / WINDOW_LINES)) - 1
    width = 2.0 * n / (count + 1)
    cuts = [(round(i * width / 2), min(round(i * width / 2 + width), n)) for i in range(count)]
    edges = [(freq_hz[a], freq_hz[b - 1]) for a, b in cuts]
    middles = [0.5 * (edges[i][1] + edges[i + 1][0]) for i in range(count - 1)]
    made = []
    for i, (low, high) in enumerate(edges):
        margin = MARGIN * (high - low)
        report = (
            band_hz[0] if i == 0 else float(low + margin),
            band_hz[1] if i == count - 1 else float(high - margin),
        )
        core = (
            band_hz[0] if i == 0 else float(middles[i - 1]),
            band_hz[1] if i == count - 1 else float(middles[i]),
        )
        made.append(Window(*cuts[i], report, core))
    return made


def join(
    parts: list[StabilizationDiagram], cut: list[Window], band_hz: tuple[float, float], tol: float
) -> StabilizationDiagram:
    """One diagram of all windows: each shows the poles of its core; values found twice count once."""
    if len(parts) == 1:
        return parts[0]
    orders = parts[0].orders
    inside = [
        [(f >= w.core_hz[0]) & (f < w.core_hz[1]) for f in d.freq_hz] for d, w in zip(parts, cut, strict=True)
    ]

    def rows(name: str) -> tuple[FloatArray, ...]:
        return tuple(
            frozen(
                np.concatenate([getattr(d, name)[k][keep[k]] for d, keep in zip(parts, inside, strict=True)])
            )
            for k in range(orders.size)
        )

    lines = [
        (d.background_freq_hz >= w.core_hz[0]) & (d.background_freq_hz < w.core_hz[1])
        for d, w in zip(parts, cut, strict=True)
    ]
    return replace(
        parts[0],
        freq_hz=rows("freq_hz"),
        damping_ratio=rows("damping_ratio"),
        stable=rows("stable"),
        band_hz=band_hz,
        background_freq_hz=frozen(
            np.concatenate([d.background_freq_hz[k] for d, k in zip(parts, lines, strict=True)])
        ),
        background=frozen(np.concatenate([d.background[k] for d, k in zip(parts, lines, strict=True)])),
        accepted=_once([d.accepted for d in parts], tol),
    )


def _once(tables: list[ResponseTable], tol: float) -> ResponseTable:
    """All antiresonances of the windows; of those found twice the better one."""
    every = [(part, i) for part, table in enumerate(tables) for i in range(len(table))]
    # Poles that stand still before those that only stay near; long chains before short ones.
    every.sort(key=lambda at: (tables[at[0]].how[at[1]] != "chain", -tables[at[0]].rows[at[1]]))
    kept: list[list[int]] = [[] for _ in tables]
    freq: list[float] = []
    for part, i in every:
        value = tables[part].freq_hz[i]
        if all(abs(value / other - 1.0) > tol for other in freq):
            freq.append(value)
            kept[part].append(i)
    return ResponseTable.concatenated([table.take(some) for table, some in zip(tables, kept, strict=True)])
