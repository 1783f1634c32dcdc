"""A second way to accept a value: it is there in most orders, though it does not stand still.

Where a response lies near its noise, the pole of one antiresonance moves by more than the stability
tolerance from order to order, and its damping may come out slightly negative; yet nearly every order has it.
Such a value is accepted if, of all orders from its first appearance on, three quarters have a dominant pole
within 2 % of it, and if the channel's response rises clearly out of its noise on both sides. Without that
last condition the edge of the band, where only noise is left, collects poles just as faithfully.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..support.validation import FloatArray
from .diagram import StabilizationDiagram, Sweep
from .flanks import flanked
from .limits import PERSISTENT_DAMPING, PERSISTENT_DOMINANCE, PERSISTENT_SNR, PRESENCE, WIDTH
from .rule import Rule
from .table import ResponseTable

__all__ = ["add_persistent"]


def add_persistent(
    found: StabilizationDiagram, sweep: Sweep, rule: Rule, channel_snr: FloatArray, added_decay_per_s: float
) -> StabilizationDiagram:
    """The diagram with persistent values added to the stable ones.

    ``channel_snr`` is the signal-to-noise power of the response itself at ``found.background_freq_hz``.
    """
    orders = found.orders.astype(int)
    pool = _dominant(sweep, orders, found, channel_snr, added_decay_per_s)
    new: list[tuple[float, float, int, float]] = []
    while len(pool):
        first = np.searchsorted(pool[:, 0], pool[:, 0] * (1.0 - WIDTH))
        last = np.searchsorted(pool[:, 0], pool[:, 0] * (1.0 + WIDTH))
        counts = np.array([np.unique(pool[a:b, 1]).size for a, b in zip(first, last, strict=True)])
        best = int(np.argmax(counts))
        if counts[best] <= rule.min_rows:
            break
        group = pool[first[best] : last[best]]
        value = float(np.median(group[:, 0]))
        # The second appearance opens the count: a single early one may be chance.
        opened = np.unique(group[:, 1])[1]
        present = (counts[best] - 1) / (orders[-1] - opened + 1)
        if present >= PRESENCE:
            new.append(
                (value, float(np.median(group[:, 2])), int(counts[best]), float(np.std(group[:, 0]) / value))
            )
        keep = (pool[:, 0] < value * (1.0 - WIDTH)) | (pool[:, 0] > value * (1.0 + WIDTH))
        keep[first[best] : last[best]] = False
        pool = pool[keep]
    if not new:
        return found
    freq, damping, rows, spread = np.array(new).T
    more = ResponseTable.of_sweep(
        freq, damping, rows=rows, spread=spread, dominance=np.full(len(new), np.nan), how="persistent"
    )
    return replace(found, accepted=ResponseTable.concatenated([found.accepted, more]))


def _dominant(
    sweep: Sweep, orders: Any, found: StabilizationDiagram, snr: FloatArray, added: float
) -> FloatArray:
    """(n, 3) of frequency, order, damping of the poles that may count, by frequency.

    Left out, before anything is computed for them: what is already identified, and what has no signal beside
    it.
    """
    rows: list[tuple[float, float, float]] = []
    grid = found.background_freq_hz
    beside = flanked(grid, snr, grid, PERSISTENT_SNR)
    for order in orders:
        s = sweep.roots(int(order))
        moved = s + added
        size = np.abs(moved)
        freq = size / (2 * np.pi)
        near = (
            (s.imag > 0)
            & (freq >= found.band_hz[0])
            & (freq <= found.band_hz[1])
            & (np.abs(moved.real) <= PERSISTENT_DAMPING * size)
            & beside[np.clip(np.searchsorted(grid, freq), 0, grid.size - 1)]
        )
        if found.identified.size:
            near &= np.abs(freq[:, None] / found.identified - 1.0).min(axis=1) > WIDTH
        if near.any():
            for i in np.flatnonzero(near)[sweep.dominances(int(order), s[near]) >= PERSISTENT_DOMINANCE]:
                rows.append((float(freq[i]), float(order), float(-moved[i].real / size[i])))
    return np.array(sorted(rows)).reshape(-1, 3)
