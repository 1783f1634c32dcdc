"""Found against true values, one to one: what tests and benchmarks mean by found, missed and false."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: A true value counts as found when an identified one lies within 1 % of it.
HIT = 0.01


@dataclass(frozen=True)
class Matched:
    """One response: pairs (found, true) by ascending frequency, true values without partner, false values."""

    pairs: tuple[tuple[float, float], ...]
    missed: tuple[float, ...]
    false: tuple[float, ...]

    @property
    def errors(self) -> list[float]:
        """Relative error of each pair."""
        return [abs(value / true - 1.0) for value, true in self.pairs]


def match(found, truth, within=HIT):
    """Pair the closest first; each true and each found value serves once, a second hit is false."""
    found, truth = np.asarray(found, float), np.asarray(truth, float)
    off = np.abs(found[:, None] / truth[None, :] - 1.0)
    free_found, free_true = set(range(found.size)), set(range(truth.size))
    pairs = []
    for flat in np.argsort(off, axis=None, kind="stable"):
        i, k = divmod(int(flat), truth.size)
        if off[i, k] > within:
            break
        if i in free_found and k in free_true:
            free_found.remove(i)
            free_true.remove(k)
            pairs.append((float(found[i]), float(truth[k])))
    return Matched(
        tuple(sorted(pairs)),
        tuple(float(truth[k]) for k in sorted(free_true)),
        tuple(float(found[i]) for i in sorted(free_found)),
    )
