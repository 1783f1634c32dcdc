"""Which value belongs to which root: one to one within a response, in ascending order, with gaps.

Along a change of the model the roots of one response keep their order, but for pairs that merge, vanish or
appear; and so do the values that were measured of them. So the assignment that explains a whole response
best is an alignment of two ascending lists: a pair costs its distance, what stays alone costs a price.

The prices are those of the likelihood: a root in the band is found with the probability ``FOUND`` (if the
other state showed it; else with ``FOUND_ONCE``), and a value is a false one with ``FALSE``, anywhere in the
band.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support.validation import FloatArray

__all__ = ["ALONE", "FALSE", "FOUND", "FOUND_ONCE", "align", "associate"]

#: Index of what has no partner.
ALONE = -1
FOUND, FOUND_ONCE, FALSE = 0.97, 0.5, 0.01


def align(cost: FloatArray, alone_row: FloatArray, alone_column: FloatArray) -> NDArray[np.intp]:
    """Column of each row, ``ALONE`` without one: the order-preserving assignment of least cost.

    ``cost`` is (rows, columns); ``alone_row`` and ``alone_column`` are the prices of staying without partner.
    """
    return _core.align(cost, alone_row, alone_column)


def associate(
    value: tuple[NDArray[np.intp], FloatArray, FloatArray],
    root: tuple[NDArray[np.intp], FloatArray, FloatArray],
    alone: float,
    alone_root: FloatArray,
) -> NDArray[np.intp]:
    """Root of each value, ``ALONE`` without one: that of the greatest likelihood.

    ``value`` and ``root`` are group, place and standard deviation of each; both ascend within a group.
    ``alone`` is the price of a value, ``alone_root`` that of each root.
    """
    return _core.associate(*value, *root, alone, alone_root)
