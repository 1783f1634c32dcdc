"""Where the windows lie: on a grid that depends on the spacing of the lines, never on the band.

Of each scale the edges ascend by a fourth of a window, so that every frequency lies well inside three. A
window is as wide as a given ratio of frequencies or, at low frequency, as a given number of lines.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...support.validation import FloatArray

#: (highest over lowest frequency, least number of lines) of the windows of each scale: the wide ones hold
#: several modes and know the trend between them, the narrow ones suffer less from what is not rational.
SCALES = ((1.5, 96), (1.25, 48))
#: Windows of one scale that cover a frequency.
OVERLAP = 4
#: A window that the band cuts must keep this share of its width, and so many lines.
LEAST_SHARE, LEAST_LINES = 0.6, 24
#: This share of a window at either end is its margin: what lies there others see better.
MARGIN = 0.08


@dataclass(frozen=True)
class LocalWindow:
    """Lines ``first`` to ``last`` (exclusive)."""

    first: int
    last: int

    def inside(self, freq_hz: FloatArray, at_hz: FloatArray) -> NDArray[np.bool_]:
        """Which frequencies lie in the window but not in its margins."""
        low, high = freq_hz[self.first], freq_hz[self.last - 1]
        margin = MARGIN * (high - low)
        return np.asarray((at_hz > low + margin) & (at_hz < high - margin))

    def covers(self, freq_hz: FloatArray, at_hz: FloatArray) -> NDArray[np.bool_]:
        """Which frequencies lie in the window."""
        return np.asarray((at_hz >= freq_hz[self.first]) & (at_hz <= freq_hz[self.last - 1]))


def local_windows(freq_hz: FloatArray) -> list[LocalWindow]:
    """All windows that the lines fill well enough; the whole if there is none.

    Parameters
    ----------
    freq_hz : (n_freq,)
        Lines of the band, ascending.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.identification.local.grid import local_windows
    >>> one, other = np.arange(100.0, 300.0, 0.5), np.arange(110.0, 300.0, 0.5)
    >>> edges = [{(f[w.first], f[w.last - 1]) for w in local_windows(f)} for f in (one, other)]
    >>> len(edges[0] & edges[1]) > 10  # but for the first and last ones they are the same windows
    True
    """
    step = float(np.median(np.diff(freq_hz)))
    found = []
    for ratio, lines in SCALES:
        edges = _edges(step, float(freq_hz[-1]), ratio, lines)
        for low, high in zip(edges[:-OVERLAP], edges[OVERLAP:], strict=True):
            kept = min(high, freq_hz[-1]) - max(low, freq_hz[0])
            first, last = np.searchsorted(freq_hz, low), np.searchsorted(freq_hz, high)
            if kept >= LEAST_SHARE * (high - low) and last - first >= max(LEAST_LINES, lines // 2):
                found.append(LocalWindow(int(first), int(last)))
    return found or [LocalWindow(0, freq_hz.size)]


def _edges(step_hz: float, highest_hz: float, ratio: float, lines: int) -> list[float]:
    """From zero up, each a fourth of a window above the one before."""
    edges = [0.0]
    while edges[-1] < highest_hz * ratio:
        edges.append(max(edges[-1] * ratio ** (1.0 / OVERLAP), edges[-1] + lines * step_hz / OVERLAP))
    return edges
