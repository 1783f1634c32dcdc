"""A second way to accept a value: it is there in most orders, though it does not stand still.

Where a response lies near its noise, the pole of one antiresonance moves by more than the stability
tolerance from order to order, and its damping may come out slightly negative; yet nearly every order has it.
Such a value is accepted if, of all orders from its first appearance on, three quarters have a dominant pole
within 2 % of
it, and if the channel's response rises clearly out of its noise on both sides. Without that last
condition the edge of the band, where only noise is left, collects poles just as faithfully.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..support.validation import FloatArray
from .diagram import StabilizationDiagram, Sweep
from .rule import Rule
from .table import ResponseTable

WIDTH = 0.02
PRESENCE = 0.75
# Superfluous poles of a noisy fit are not all weak: here a pole must own the curve at its frequency.
DOMINANCE = 0.7
MAX_DAMPING = 0.05
# Signal-to-noise power on either side, from 2 to 20 % away; 4 is 6 dB.
FLANK_SNR = 4.0
FLANK = (0.02, 0.20)


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
        # The second appearance opens the count: a single early hit may be chance.
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
    flanked = _flanked(grid, snr)
    for order in orders:
        s = sweep.roots(int(order))
        moved = s + added
        size = np.abs(moved)
        freq = size / (2 * np.pi)
        near = (
            (s.imag > 0)
            & (freq >= found.band_hz[0])
            & (freq <= found.band_hz[1])
            & (np.abs(moved.real) <= MAX_DAMPING * size)
            & flanked[np.clip(np.searchsorted(grid, freq), 0, grid.size - 1)]
        )
        if found.identified.size:
            near &= np.abs(freq[:, None] / found.identified - 1.0).min(axis=1) > WIDTH
        if near.any():
            for i in np.flatnonzero(near)[sweep.dominances(int(order), s[near]) >= DOMINANCE]:
                rows.append((float(freq[i]), float(order), float(-moved[i].real / size[i])))
    return np.array(sorted(rows)).reshape(-1, 3)


def _flanked(freq_hz: FloatArray, snr: FloatArray) -> Any:
    """For every line, whether the response on both sides of it rises out of its noise (medians)."""
    good = np.concatenate([[0.0], np.cumsum(snr >= FLANK_SNR)])

    def share(low: float, high: float) -> FloatArray:
        a, b = (
            np.searchsorted(freq_hz, freq_hz * (1.0 + low)),
            np.searchsorted(freq_hz, freq_hz * (1.0 + high)),
        )
        # The median reaches the limit exactly if at least half the lines do.
        return np.asarray((good[b] - good[a]) / np.maximum(b - a, 1))

    return (share(-FLANK[1], -FLANK[0]) >= 0.5) & (share(FLANK[0], FLANK[1]) >= 0.5)
