"""The selection rule of the paper, once for all peers, on nothing but poles.

V. Meruane, J. Sound Vib. 332 (2013) 807-820: a pole is stable if the order before has one within 1 % in
frequency and 5 % in damping; a value is accepted if more than ten consecutive orders are stable. Poles with
negative damping, or with 10 % and more, are left out; accepted values closer than 1 % are one.
"""

from __future__ import annotations

import numpy as np

FREQ_TOL, DAMPING_TOL, MORE_ROWS_THAN, MAX_DAMPING = 0.01, 0.05, 10, 0.10


def select(sweep, band_hz):
    """Accepted frequencies (Hz, ascending) of poles (rad/s) by order."""
    before, chains = [], []
    for poles in sweep:
        rows = _physical(np.asarray(poles, dtype=complex), band_hz)
        now = [None] * len(rows)
        for _, i, k in sorted(_stable_pairs(rows, before)):
            # One to one, best pairs first; before[k] is None once it is taken.
            if now[i] is None and before[k] is not None:
                now[i], before[k] = before[k], None
                now[i].append(rows[i])
        for i, row in enumerate(rows):
            if now[i] is None:
                now[i] = [row]
                chains.append(now[i])
        before = now
    # n poles in a row are n - 1 stable orders and the one they start from.
    values = sorted(
        (float(np.median([f for f, _ in chain])), len(chain))
        for chain in chains
        if len(chain) - 1 > MORE_ROWS_THAN
    )
    merged = []
    for value, length in values:
        if merged and value - merged[-1][0] <= FREQ_TOL * value:
            merged[-1] = max(merged[-1], (value, length), key=lambda v: v[1])
        else:
            merged.append((value, length))
    return np.array([value for value, _ in merged])


def _physical(s, band_hz):
    """(frequency, damping ratio) of the poles that may be values."""
    s = s[np.isfinite(s)]
    s = s[(s.imag > 0.0) & (s.real < 0.0)]
    freq, damping = np.abs(s) / (2 * np.pi), -s.real / np.abs(s)
    keep = (damping < MAX_DAMPING) & (freq >= band_hz[0]) & (freq <= band_hz[1])
    return list(zip(freq[keep], damping[keep], strict=True))


def _stable_pairs(rows, before):
    """(distance, row, row before) of all pairs within the tolerances."""
    for i, (freq, damping) in enumerate(rows):
        for k, chain in enumerate(before):
            d_freq = abs(freq / chain[-1][0] - 1.0) / FREQ_TOL
            d_damping = abs(damping / chain[-1][1] - 1.0) / DAMPING_TOL
            if max(d_freq, d_damping) <= 1.0:
                yield d_freq + d_damping, i, k
