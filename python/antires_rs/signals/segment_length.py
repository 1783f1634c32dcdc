"""How long the segments of Welch's method should be when the user does not say."""

from __future__ import annotations

from ..support.validation import reject
from .bandwidth import SEGMENTS, Autocorrelation, longest_power, narrow_width, power_of_two
from .recording import Recording

__all__ = ["choose_nperseg", "longest_segments"]

# Segments of this many half-power bandwidths' reciprocals. On a chain with 1 % damping (narrowest resonance
# 0.46 Hz wide) 32 s have a third of the leakage error of 16 s, and no more scatter: a joint fit over all
# lines does not mind whether it sees many averages or many lines.
BANDWIDTHS = 16.0
LEAST_SAMPLES = 256
# Bands with more lines are fitted in windows, which costs more than the resolution gains.
MOST_LINES = 5000
# Lines below which no bandwidth is measured.
LEAST_LINES = 8


def choose_nperseg(
    rec: Recording, band_hz: tuple[float, float], correlation: Autocorrelation | None = None
) -> int:
    """Samples per segment from the record's length and the sharpness of its resonances.

    The rule: 16 / (narrow half-power bandwidth), at most a tenth of the record; rounded to the nearest power
    of two; with no more than 5,000 lines in the band. The bandwidth is the lower quartile of those of the
    peaks that stand 10 dB over the median of the summed, channel-normalised power spectrum in the band, at
    the resolution of the longest segments allowed. That spectrum comes from the autocorrelation of the whole
    record (see :mod:`~antires_rs.signals.bandwidth`; pass it where it is there already), not from segments.
    For the 8-mass chain with 1 % damping at 512 Hz: 32 s of a record of 600 s, 16 s of one of 200 s, 8 s of
    one of 60 s.
    """
    n_long = longest_segments(rec, band_hz)
    if n_long < LEAST_SAMPLES:
        reject(
            "nperseg",
            f"None for a record of {rec.n_samples} samples",
            f"a record of at least {int(LEAST_SAMPLES * SEGMENTS)} samples",
            "Give nperseg, or record for longer.",
        )
    power = (correlation or Autocorrelation(rec)).power(n_long, band_hz)
    width = narrow_width(power) if power.size >= LEAST_LINES else None
    if width is None:
        return n_long
    bandwidth = width * rec.fs_hz / n_long
    return max(LEAST_SAMPLES, min(n_long, power_of_two(BANDWIDTHS / bandwidth * rec.fs_hz)))


def longest_segments(rec: Recording, band_hz: tuple[float, float]) -> int:
    """Samples of the longest segments that leave enough averages, and not too many lines in the band."""
    n_long = longest_power(rec)
    while n_long * (band_hz[1] - band_hz[0]) / rec.fs_hz > MOST_LINES:
        n_long //= 2
    return n_long
