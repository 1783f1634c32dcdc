"""The selection of values from poles by order: the rule of the paper, the same for all, and a peer's own.

V. Meruane, J. Sound Vib. 332 (2013) 807-820: a pole is stable if the order before has one within 1 % in
frequency and 5 % in damping; a value is accepted if more than ten consecutive orders are stable. Poles with
negative damping, or with 10 % and more, are left out; accepted values closer than 1 % are one.

The peers mark stable poles likewise and leave the picking to their user. Their documentation offers both
tolerances and the largest damping; how many orders must agree is where the user's eye would be. So a peer's
own rule is the best of this family for it, found by ``python -m benchmarks.peers_identification --choose`` on
seeds 100 to 102.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

#: Accepted values closer than this are one.
MERGED = 0.01


@dataclass(frozen=True)
class Rule:
    """Tolerances from order to order, orders that must be stable (more than), largest damping."""

    freq_tol: float = 0.01
    damping_tol: float = 0.05
    more_rows_than: int = 10
    max_damping: float = 0.10

    def __str__(self):
        return (
            f"{100 * self.freq_tol:g} %, {100 * self.damping_tol:g} %, over {self.more_rows_than} orders, "
            f"damping to {100 * self.max_damping:g} %"
        )


COMMON = Rule()
#: What ``--choose`` tries.
FAMILY = tuple(
    itertools.starmap(
        Rule, itertools.product((0.003, 0.01), (0.05, 0.1, 0.3), (4, 7, 10, 15), (0.02, 0.05, 0.10))
    )
)


def select(sweep, band_hz, rule=COMMON):
    """Accepted frequencies (Hz, ascending) of poles (rad/s) by order."""
    before, chains = [], []
    for poles in sweep:
        rows = _physical(np.asarray(poles, dtype=complex), band_hz, rule)
        now = [None] * len(rows)
        for _, i, k in sorted(_stable_pairs(rows, before, rule)):
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
        if len(chain) - 1 > rule.more_rows_than
    )
    merged = []
    for value, length in values:
        if merged and value - merged[-1][0] <= MERGED * value:
            merged[-1] = max(merged[-1], (value, length), key=lambda v: v[1])
        else:
            merged.append((value, length))
    return np.array([value for value, _ in merged])


def _physical(s, band_hz, rule):
    """(frequency, damping ratio) of the poles that may be values."""
    s = s[np.isfinite(s)]
    s = s[(s.imag > 0.0) & (s.real < 0.0)]
    freq, damping = np.abs(s) / (2 * np.pi), -s.real / np.abs(s)
    keep = (damping < rule.max_damping) & (freq >= band_hz[0]) & (freq <= band_hz[1])
    return list(zip(freq[keep], damping[keep], strict=True))


def _stable_pairs(rows, before, rule):
    """(distance, row, row before) of all pairs within the tolerances."""
    if not rows or not before:
        return
    now, last = np.array(rows), np.array([chain[-1] for chain in before])
    apart = np.abs(now[:, None] / last - 1.0) / (rule.freq_tol, rule.damping_tol)
    for i, k in zip(*np.nonzero(apart.max(axis=2) <= 1.0), strict=True):
        yield float(apart[i, k].sum()), int(i), int(k)
