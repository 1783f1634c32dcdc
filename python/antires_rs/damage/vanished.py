"""Roots that the baseline shows and the model loses on the way to a damage: two that met.

Where they meet depends on the model's errors. So a structure may still have them where the model has not, and
a value there is not simply a false one: it may be of such a root, found with the probability of one that only
one state shows, as far from its intact place as a root goes until it meets another.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .model_error import ModelError
from .view import Foreseen

__all__ = ["and_vanished", "vanished"]

#: Standard deviation of ln f of such a root from its intact place.
_MOVED = 0.1

Gone = tuple[NDArray[np.intp], FloatArray]


def vanished(error: ModelError, beside: FloatArray, followed: NDArray[np.intp]) -> Gone:
    """Response and ln f, in the measured structure, of roots that are gone; ``followed`` are those left."""
    left = np.zeros(error.intact.size, dtype=bool)
    left[followed[followed >= 0]] = True
    gone = np.flatnonzero(error.seen & ~left)
    return error.intact.response[gone], error.intact.log_f[gone] + beside[gone]


def and_vanished(roots: Foreseen, gone: Gone) -> Foreseen:
    """The roots together with those that are gone, in ascending order within each response."""
    response, place = gone
    n, m = roots.place.size, response.size
    if not m:
        return roots
    both, places = np.concatenate([roots.response, response]), np.concatenate([roots.place, place])
    order = np.lexsort((places, both))
    spread = np.zeros((n + m, n + m))
    spread[:n, :n] = roots.spread
    spread[np.arange(n, n + m), np.arange(n, n + m)] = _MOVED**2
    none = np.zeros(m)
    return replace(
        roots,
        response=both[order],
        place=places[order],
        beside=np.concatenate([roots.beside, none])[order],
        spread=spread[np.ix_(order, order)],
        change=np.concatenate([roots.change, none])[order],
        slopes=np.vstack([roots.slopes, np.zeros((m, roots.slopes.shape[1]))])[order],
        seen=np.concatenate([roots.seen, np.zeros(m, dtype=bool)])[order],
    )
