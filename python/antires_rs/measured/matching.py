r"""Which antiresonance of one set is which of another: the assignment of least cost over a response.

A pair at distance d costs (d / t)^2 and a value without partner 1/2, so that two values are paired if that
explains them better than that one vanished and another appeared; t, the largest distance, is

    t^2 = (max_shift f)^2 + (3 std)^2,      std that of the difference.

All pairs of a response are found at once, no value twice; the cost is convex, so that pairs do not cross.

Reference: D. F. Crouse, IEEE Trans. Aerosp. Electron. Syst. 52 (2016) 1679-1696 (the algorithm in SciPy).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..exceptions import Argument
from ..order_sweep.table import ResponseTable
from ..support.validation import FloatArray, finite_scalar, reject
from .antiresonance_set import AntiresonanceSet

__all__ = ["MAX_SHIFT", "check_set", "check_sets", "check_shift", "paired", "variance_hz"]

#: Largest relative distance of two values that are one, by default.
MAX_SHIFT = 0.05
# A difference may exceed that by so many standard deviations.
STDS = 3.0
# Cost of what may not be paired: more than leaving both alone.
FORBIDDEN = 1e3


def paired(
    a_hz: FloatArray, b_hz: FloatArray, max_shift: float, variance: FloatArray | None = None
) -> list[tuple[int, int]]:
    """Indices of the values that are one, by ascending frequency.

    Parameters
    ----------
    a_hz : (n,)
    b_hz : (m,)
    max_shift : float
        Relative.
    variance : (n, m), optional
        Of the differences in Hz^2; NaN where not known.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.measured.matching import paired
    >>> paired(np.array([10.0, 10.4, 30.0]), np.array([10.3, 29.0, 45.0]), 0.05)
    [(1, 0), (2, 1)]
    """
    from scipy.optimize import linear_sum_assignment  # slow to import

    if not a_hz.size or not b_hz.size:
        return []
    middle = 0.5 * (a_hz[:, None] + b_hz)
    reach = (max_shift * middle) ** 2
    if variance is not None:
        reach = reach + STDS**2 * np.nan_to_num(variance)
    cost = (b_hz - a_hz[:, None]) ** 2 / reach
    # Of many tracks few are near what a test has; the others stay alone in any case.
    near_a, near_b = (np.flatnonzero((cost < 1.0).any(axis=axis)) for axis in (1, 0))
    cost, n, m = cost[np.ix_(near_a, near_b)], near_a.size, near_b.size
    # Beside it a partner of nobody for each, so that the least total may leave any value alone.
    square = np.full((n + m, n + m), FORBIDDEN)
    square[:n, :m] = np.where(cost < 1.0, cost, FORBIDDEN)
    square[np.arange(n), m + np.arange(n)] = 0.5
    square[n + np.arange(m), np.arange(m)] = 0.5
    square[n:, m:] = 0.0
    rows, columns = linear_sum_assignment(square)
    pairs = zip(rows.tolist(), columns.tolist(), strict=True)
    return [(int(near_a[i]), int(near_b[k])) for i, k in pairs if i < n and k < m]


def variance_hz(table: ResponseTable, std_between: float) -> FloatArray:
    """Variance of every value in Hz^2, with the scatter between tests; NaN where neither is known."""
    own = table.std_hz**2
    between = (std_between * table.freq_hz) ** 2
    return np.where(np.isnan(own), between if std_between > 0.0 else np.nan, own + between)


def check_shift(max_shift: Any) -> float:
    """A relative distance."""
    return finite_scalar("max_shift", max_shift, low=0.0, high=0.5, low_open=True)


def check_sets(name: str, sets: Any, least: int) -> list[AntiresonanceSet]:
    """A list of sets, at least so many."""
    wanted = f"a list of {least} sets or more"
    if not isinstance(sets, list | tuple):
        reject(name, type(sets).__name__, wanted, "Put the sets in a list.")
    if len(sets) < least:
        reject(name, f"{len(sets)} of them", wanted, "Give the others too.")
    return [check_set(Argument(name).item(i), one) for i, one in enumerate(sets)]


def check_set(name: str, one: Any) -> AntiresonanceSet:
    """A set of antiresonances."""
    if not isinstance(one, AntiresonanceSet):
        reject(
            name,
            type(one).__name__,
            "an AntiresonanceSet",
            "Identify the record first: identify_antiresonances(record, ...).",
        )
    return one
