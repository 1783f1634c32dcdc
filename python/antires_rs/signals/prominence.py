"""Peaks that stand out of a curve, by their prominence."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray

__all__ = ["prominent_peaks"]


def prominent_peaks(curve: FloatArray, least: float) -> NDArray[np.int64]:
    """Indices of the maxima with a prominence of ``least`` at least, ascending.

    The prominence is the height over the higher of the two lowest points that lie between the peak and the
    next higher point, or the end, on either side. Of a flat top the middle is taken. As
    ``scipy.signal.find_peaks``, whose import takes longer than the identification of a short record.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.signals.prominence import prominent_peaks
    >>> prominent_peaks(np.array([0.0, 3.0, 2.0, 2.5, 2.5, 2.5, 0.0]), 1.0).tolist()
    [1]
    >>> prominent_peaks(np.array([0.0, 3.0, 2.0, 2.5, 2.5, 2.5, 0.0]), 0.5).tolist()
    [1, 4]
    """
    # Stretches of equal values; a peak is one with lower ones on both sides.
    first = np.flatnonzero(np.diff(curve, prepend=np.nan) != 0.0)
    level = curve[first]
    top = 1 + np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:]))
    if not top.size:
        return np.empty(0, dtype=np.int64)
    middle = (first[top] + first[top + 1] - 1) // 2
    # Lowest points before the first peak, between peaks, and after the last.
    low = np.minimum.reduceat(level, np.concatenate([[0], top]))
    height = level[top].tolist()
    left = _lowest(height, low[:-1].tolist())
    right = _lowest(height[::-1], low[:0:-1].tolist())[::-1]
    return np.asarray(middle[np.array(height) - np.maximum(left, right) >= least], dtype=np.int64)


def _lowest(height: list[float], before: list[float]) -> list[float]:
    """Lowest point from every peak back to the next higher one; ``before`` are those between neighbours."""
    higher: list[tuple[float, float]] = []
    found = []
    for own, lowest in zip(height, before, strict=True):
        while higher and higher[-1][0] <= own:
            lowest = min(lowest, higher.pop()[1])
        higher.append((own, lowest))
        found.append(lowest)
    return found
