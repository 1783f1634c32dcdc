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

from ..support.validation import FloatArray

__all__ = ["ALONE", "FALSE", "FOUND", "FOUND_ONCE", "align", "associate"]

#: Index of what has no partner.
ALONE = -1
FOUND, FOUND_ONCE, FALSE = 0.97, 0.5, 0.01

_HALF_LOG_TAU = 0.5 * float(np.log(2.0 * np.pi))


def align(cost: FloatArray, alone_row: FloatArray, alone_column: FloatArray) -> NDArray[np.intp]:
    """Column of each row, ``ALONE`` without one: the order-preserving assignment of least cost.

    ``cost`` is (rows, columns); ``alone_row`` and ``alone_column`` are the prices of staying without partner.
    """
    n_rows, n_columns = cost.shape
    total = np.zeros((n_rows + 1, n_columns + 1))
    total[1:, 0] = np.cumsum(alone_row)
    total[0, 1:] = np.cumsum(alone_column)
    pairs, rows, columns = cost.tolist(), alone_row.tolist(), alone_column.tolist()
    table: list[list[float]] = total.tolist()
    for i in range(n_rows):
        above, here, price, row = table[i], table[i + 1], pairs[i], rows[i]
        for j in range(n_columns):
            here[j + 1] = min(above[j] + price[j], above[j + 1] + row, here[j] + columns[j])
    found = np.full(n_rows, ALONE)
    i, j = n_rows, n_columns
    while i and j:
        if table[i][j] == table[i - 1][j - 1] + pairs[i - 1][j - 1]:
            i, j = i - 1, j - 1
            found[i] = j
        elif table[i][j] == table[i - 1][j] + rows[i - 1]:
            i -= 1
        else:
            j -= 1
    return found


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
    (group, place, spread), (root_group, root_place, root_spread) = value, root
    found = np.full(place.size, ALONE)
    starts = np.searchsorted(root_group, np.arange(group.max(initial=-1) + 2))
    firsts = np.searchsorted(group, np.arange(group.max(initial=-1) + 2))
    for number in range(firsts.size - 1):
        own, roots = slice(*firsts[number : number + 2]), slice(*starts[number : number + 2])
        if own.start == own.stop or roots.start == roots.stop:
            continue
        sigma = np.hypot(spread[own][:, None], root_spread[roots])
        apart = (place[own][:, None] - root_place[roots]) / sigma
        cost = 0.5 * apart**2 + np.log(sigma) + _HALF_LOG_TAU
        columns = align(cost, np.full(cost.shape[0], alone), alone_root[roots])
        found[own] = np.where(columns >= 0, columns + roots.start, ALONE)
    return found
