"""Does a response rise out of its noise beside a frequency?

A value in the middle of a valley of noise is believed only if the response is seen on both of its flanks.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..support.validation import FloatArray
from .limits import FLANK

__all__ = ["flanked"]


def flanked(freq_hz: FloatArray, snr: FloatArray, at_hz: FloatArray, least_snr: float) -> Any:
    """Whether half the lines at least of either flank of ``at_hz`` (n,) reach ``least_snr``.

    ``snr`` is the signal-to-noise power of the response at ``freq_hz``. Beyond the edge of the band there is
    no line: where a flank has none it cannot be told, and the answer is no.
    """
    good = np.concatenate([[0], np.cumsum(snr >= least_snr)])

    def half(low: float, high: float) -> Any:
        a, b = np.searchsorted(freq_hz, at_hz * (1.0 + low)), np.searchsorted(freq_hz, at_hz * (1.0 + high))
        return (good[b] - good[a]) / np.maximum(b - a, 1) >= 0.5

    return half(-FLANK[1], -FLANK[0]) & half(*FLANK)
