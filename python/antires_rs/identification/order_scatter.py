"""What the choice of the model order, and leakage with it, adds to the error of a zero.

The scatter of the segments tells the noise. That a curve of finite resolution is not a rational function of
the chosen order does not scatter: it shows in how far a zero moves when the order is raised by one to four.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..support.validation import ComplexArray, FloatArray
from .likelihood import Likeliest

__all__ = ["next_orders", "order_scatter"]

#: Orders above the likeliest that are compared with it.
ABOVE = (1, 2, 3, 4)
#: A root further off than this share of the frequency is another one.
SAME_ROOT = 0.01


def next_orders(best: Likeliest) -> list[int]:
    """The orders compared, those that the fit has."""
    return [best.order + k for k in ABOVE if best.order + k <= best.fit.max_order]


def order_scatter(s: ComplexArray, roots: Sequence[ComplexArray]) -> FloatArray:
    """Root mean square in Hz of the shifts of zeros ``s`` (rad/s) to the nearest of other orders, (n,).

    What no other order has counts with the distance up to which it was looked for.
    """
    squares, counts = np.zeros(s.size), np.zeros(s.size)
    for every in roots:
        if not every.size or not s.size:
            continue
        nearest = every[np.argmin(np.abs(every - s[:, None]), axis=1)]
        shift = (np.abs(nearest) - np.abs(s)) / (2 * np.pi)
        same = np.abs(nearest - s) <= SAME_ROOT * np.abs(s)
        squares += np.where(same, shift**2, 0.0)
        counts += same
    nowhere = SAME_ROOT * np.abs(s) / (2 * np.pi) if roots else np.zeros(s.size)
    return np.asarray(np.where(counts > 0, np.sqrt(squares / np.maximum(counts, 1.0)), nowhere))
