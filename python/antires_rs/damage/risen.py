"""Values that have risen since the intact state: lost stiffness lowers most of them, so it is something else.

Values of one response are paired with those of the intact state in their order, as between intact tests.
"""

from __future__ import annotations

import numpy as np

from .association import align
from .measured_states import Values

__all__ = ["mostly_risen"]

#: Difference of ln f up to which values are paired.
_PAIRED = 0.3
#: A value has moved if it differs by so many standard deviations, and by this share at least.
_DEVIATIONS, _MOVED = 4.0, 1e-3
#: So many values must have moved, and this share of them upwards.
_LEAST, _MOST = 3, 0.75


def mostly_risen(intact: Values, now: Values) -> tuple[int, int]:
    """How many values have risen, of how many that have moved; (0, 0) where these are not most of them."""
    up = moved = 0
    for number in np.unique(now.response):
        for test in np.unique(now.test):
            here = np.flatnonzero((now.response == number) & (now.test == test))
            for other in np.unique(intact.test):
                there = np.flatnonzero((intact.response == number) & (intact.test == other))
                if not here.size or not there.size:
                    continue
                by = now.log_f[here][:, None] - intact.log_f[there]
                alone = 0.5 * _PAIRED
                partner = align(np.abs(by), np.full(here.size, alone), np.full(there.size, alone))
                has = np.flatnonzero(partner >= 0)
                change = by[has, partner[has]]
                error = np.hypot(now.std[here[has]], intact.std[there[partner[has]]])
                far = np.abs(change) > np.maximum(_DEVIATIONS * error, _MOVED)
                moved += int(far.sum())
                up += int((far & (change > 0.0)).sum())
                break  # one intact test is enough
    return (up, moved) if moved >= _LEAST and up >= _MOST * moved else (0, 0)
