"""How long the segments of Welch's method should be when the user does not say."""

from __future__ import annotations

import numpy as np

from ..support.validation import reject
from .recording import Recording
from .spectra import cross_spectra

# Segments of this many half-power bandwidths' reciprocals. On a chain with 1 % damping (narrowest resonance
# 0.46 Hz wide) 32 s have a third of the leakage error of 16 s, and no more scatter: a joint fit over all
# lines does not mind whether it sees many averages or many lines.
BANDWIDTHS = 16.0
# ... but not longer than this share of the record, so that the scatter of the segments can be told.
SEGMENTS = 10.0
LEAST_SAMPLES = 256
# Peaks lower than this over the band's median are not taken for resonances.
PEAK_RATIO = 10.0
NARROWEST = 0.25
# Bands with more lines are fitted in windows, which costs more than the resolution gains.
MOST_LINES = 5000


def choose_nperseg(rec: Recording, band_hz: tuple[float, float]) -> int:
    """Samples per segment from the record's length and the sharpness of its resonances.

    The rule: 16 / (narrow half-power bandwidth), at most a tenth of the record; rounded to the nearest power
    of two; with no more than 5,000 lines in the band. The bandwidth is the lower quartile of those of the
    peaks that stand 10 dB over the median of the summed, channel-normalised power spectrum in the band,
    measured with the longest segments allowed. For the 8-mass chain with 1 % damping at 512 Hz: 32 s of a
    record of 600 s, 16 s of one of 200 s, 8 s of one of 60 s.
    """
    n_long = _power_of_two(rec.n_samples / SEGMENTS)
    while n_long * (band_hz[1] - band_hz[0]) / rec.fs_hz > MOST_LINES:
        n_long //= 2
    if n_long < LEAST_SAMPLES:
        reject(
            "nperseg",
            f"None for a record of {rec.n_samples} samples",
            f"a record of at least {int(LEAST_SAMPLES * SEGMENTS)} samples",
            "Give nperseg, or record for longer.",
        )
    spectra = cross_spectra(rec, nperseg=n_long)
    auto = np.einsum("fii->if", spectra.matrix).real
    mean = auto.mean(axis=1, keepdims=True)
    power = (auto[mean[:, 0] > 0] / mean[mean[:, 0] > 0]).sum(axis=0)
    inside = (spectra.freq_hz >= band_hz[0]) & (spectra.freq_hz <= band_hz[1])
    power = power[inside]
    if power.size < 8:
        return n_long
    widths = _half_power_widths(power)
    if not widths:
        return n_long
    bandwidth = float(np.quantile(widths, NARROWEST)) * rec.fs_hz / n_long
    return max(LEAST_SAMPLES, min(n_long, _power_of_two(BANDWIDTHS / bandwidth * rec.fs_hz)))


def _power_of_two(n: float) -> int:
    return int(2 ** max(0, round(np.log2(max(n, 1.0)))))


def _half_power_widths(power: np.ndarray) -> list[float]:
    """Widths, in lines, of the peaks that stand out; a peak owns all down to a tenth of its height."""
    left = power.copy()
    widths = []
    while left.max() > PEAK_RATIO * np.median(power):
        peak = int(np.argmax(left))
        lo = hi = peak
        while lo > 0 and power[lo - 1] > 0.1 * power[peak]:
            lo -= 1
        while hi < power.size - 1 and power[hi + 1] > 0.1 * power[peak]:
            hi += 1
        # The area over the height is steadier than the two half-power points of a ragged spectrum;
        # pi/2 half-power widths make the area of a resonance.
        if lo > 0 and hi < power.size - 1 and left[lo : hi + 1].min() > 0:
            widths.append(float(power[lo : hi + 1].sum() / power[peak]) * 2 / np.pi)
        left[lo : hi + 1] = 0.0
    return widths
