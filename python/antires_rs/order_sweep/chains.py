"""Which roots of successive orders belong together."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.validation import ComplexArray
from .limits import SMALL_DAMPING
from .rule import Rule

__all__ = ["link", "physical"]


def physical(
    every: list[ComplexArray], band: tuple[float, float], rule: Rule, added: float
) -> list[ComplexArray]:
    """Of each order: upper half, left half plane, in the band, lightly damped; ascending."""
    order = np.repeat(np.arange(len(every)), [s.size for s in every])
    s = np.concatenate([np.empty(0, dtype=np.complex128), *every])
    size = np.abs(s)
    freq = size / (2 * np.pi)
    keep = np.flatnonzero(
        (s.imag > 0)
        & ((s.real < 0) | rule.both_sides)
        & (np.abs(s.real + added) <= rule.max_damping * size)
        & (freq >= band[0])
        & (freq <= band[1])
    )
    keep = keep[np.lexsort((freq[keep], order[keep]))]
    return np.split(s[keep], np.searchsorted(order[keep], np.arange(1, len(every))))


def link(rows: list[ComplexArray], rule: Rule) -> tuple[list[list[tuple[int, int]]], list[Any]]:
    """Chains of (row, index) over consecutive orders, one to one, best pairs first; and the stable marks."""
    chains: list[list[tuple[int, int]]] = []
    marks: list[Any] = []
    before: list[list[tuple[int, int]]] = []
    for row, s in enumerate(rows):
        own: list[list[tuple[int, int]] | None] = [None] * s.size
        mark = np.zeros(s.size, dtype=bool)
        if row and s.size and rows[row - 1].size:
            size, old_size = np.abs(s), np.abs(rows[row - 1])
            damping, old_damping = -s.real / size, -rows[row - 1].real / old_size
            d_freq = np.abs(size[:, None] / old_size - 1.0) / rule.freq_tol
            # About zero damping a relative change says nothing.
            scale = np.maximum(np.abs(old_damping), SMALL_DAMPING if rule.both_sides else 0.0)
            d_damping = np.abs(damping[:, None] - old_damping) / scale / rule.damping_tol
            near = np.nonzero((d_freq <= 1.0) & (d_damping <= 1.0))
            best_first = np.argsort((d_freq + d_damping)[near], kind="stable")
            taken: set[int] = set()
            for i, k in zip(near[0][best_first].tolist(), near[1][best_first].tolist(), strict=True):
                if own[i] is None and k not in taken:
                    own[i], mark[i] = before[k], True
                    taken.add(k)
        before = []
        for i, chain in enumerate(own):
            if chain is None:
                chain = []
                chains.append(chain)
            chain.append((row, i))
            before.append(chain)
        marks.append(mark)
    return chains, marks
