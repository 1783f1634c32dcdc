"""What the choice of the model order, and leakage with it, adds to the error of a zero.

The scatter of the segments tells the noise. That a curve of finite resolution is not a rational function of
the chosen order does not scatter: it shows in how far a zero moves when the order is raised by one to four.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..support.validation import ComplexArray, FloatArray
from .likelihood import Likeliest

__all__ = ["ABOVE", "next_orders", "order_scatter"]

#: Orders above the likeliest that are compared with it.
ABOVE = (1, 2, 3, 4)
#: The largest shift over the next, at most.
LARGEST = 3.0
#: A root further off than this share of the frequency is another one.
SAME_ROOT = 0.01


def next_orders(best: Likeliest) -> list[int]:
    """The orders compared, those that the fit has."""
    return [best.order + k for k in ABOVE if best.order + k <= best.fit.max_order]


def order_scatter(s: ComplexArray, roots: Sequence[ComplexArray]) -> FloatArray:
    """Root mean square in Hz of the shifts of zeros ``s`` (rad/s) to the nearest of other orders, (n,).

    The largest shift counts with at most three times the next: at one order a spurious root may come between.
    What an order does not have counts with the distance up to which it was looked for.
    """
    if len(roots) < 2 or not s.size:
        return np.zeros(s.size)
    most = SAME_ROOT * np.abs(s)
    shifts = np.array([_shifts(s, every, most) for every in roots])
    shifts.sort(axis=0)
    shifts[-1] = np.minimum(shifts[-1], LARGEST * shifts[-2])
    return np.asarray(np.sqrt(np.mean(shifts**2, axis=0)) / (2 * np.pi))


def _shifts(s: ComplexArray, every: ComplexArray, most: FloatArray) -> FloatArray:
    """Change of the modulus to the nearest root, ``most`` where there is none so near."""
    if not every.size:
        return most
    nearest = every[np.argmin(np.abs(every - s[:, None]), axis=1)]
    return np.where(np.abs(nearest - s) <= most, np.abs(np.abs(nearest) - np.abs(s)), most)
