"""Where a curve has a dip, and how deep it is.

The depth of a local minimum is what an eye would say: how far the curve climbs on both sides, within a reach
or until it falls below the minimum, the lower of the two (the prominence of the minimum).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..signals.prominence import prominent_peaks
from ..support.validation import FloatArray
from .limits import DIP_LINES, DIP_REACH

__all__ = ["dips"]


def dips(
    freq_hz: FloatArray, level_db: FloatArray, least_db: float, around_hz: tuple[float, float] | None = None
) -> tuple[NDArray[np.intp], FloatArray]:
    """Lines at which a curve has a dip, and the depths in dB.

    Parameters
    ----------
    freq_hz, level_db : (n_freq,)
        A curve in dB. Peaks are the dips of the negative curve.
    least_db : float
        Shallower dips are left out.
    around_hz : (low, high), optional
        Only dips between these; the curve beyond still tells how deep they are.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.order_sweep.dips import dips
    >>> f = np.linspace(5.0, 15.0, 401)
    >>> at, depth = dips(f, 10 * np.log10((f / 10 - 1) ** 2 + 0.01**2), 3.0)
    >>> f[at].tolist(), depth.round(1).tolist()
    ([10.0], [11.8])
    """

    # No dip is deeper within its reach than without bounds.
    lines = prominent_peaks(-level_db, least_db)
    if around_hz is not None:
        lines = lines[(freq_hz[lines] >= around_hz[0]) & (freq_hz[lines] <= around_hz[1])]
    step = float(np.median(np.diff(freq_hz)))
    at, depths = [], []
    for line in lines.tolist():
        reach = max(DIP_LINES, int(DIP_REACH * freq_hz[line] / step))
        left = level_db[max(line - reach, 0) : line][::-1]
        depth = min(
            _climb(left, level_db[line]), _climb(level_db[line + 1 : line + 1 + reach], level_db[line])
        )
        if depth >= least_db:
            at.append(line)
            depths.append(depth)
    return np.array(at, dtype=np.intp), np.array(depths)


def _climb(side: FloatArray, floor: float) -> float:
    """How far a side rises over the minimum before it falls below it."""
    below = np.flatnonzero(side < floor)
    some = side[: below[0]] if below.size else side
    return float(some.max(initial=floor) - floor)
