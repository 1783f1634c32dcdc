"""Peaks of the curve behind a diagram that no accepted antiresonance explains."""

from __future__ import annotations

import numpy as np

from ..support.validation import FloatArray
from .dips import dips
from .flanks import flanked
from .limits import EXPLAINED_WITHIN, PEAK_DB, PEAK_LINES, PERSISTENT_SNR

__all__ = ["unexplained"]


def unexplained(
    freq_hz: FloatArray, background: FloatArray, known_hz: FloatArray, snr: FloatArray
) -> FloatArray:
    """Frequencies in Hz of high peaks of a curve beside which no antiresonance was seen.

    A response must rise out of its noise on both flanks of a peak.

    Parameters
    ----------
    freq_hz, background : (n_freq,)
        The magnitude that a diagram shows behind its poles.
    known_hz : (n,)
    snr : (n_freq,)
        Signal-to-noise power of the response itself.
    """
    if freq_hz.size < 2 * PEAK_LINES:
        return np.empty(0)
    power = np.convolve(np.abs(background) ** 2, np.full(PEAK_LINES, 1.0 / PEAK_LINES), mode="same")
    at, _ = dips(freq_hz, -10.0 * np.log10(np.maximum(power, 1e-300)), PEAK_DB)
    peaks = freq_hz[at]
    peaks = peaks[flanked(freq_hz, snr, peaks, PERSISTENT_SNR)]
    if not known_hz.size:
        return np.asarray(peaks)
    off = np.abs(peaks[:, None] / known_hz - 1.0).min(axis=1, initial=np.inf)
    return np.asarray(peaks[off > EXPLAINED_WITHIN])
