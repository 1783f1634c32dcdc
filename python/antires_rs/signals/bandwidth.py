r"""How wide the sharp resonances of a record are, and the power spectrum that tells it.

Averaged over all places that a segment can have, Welch's auto spectrum with the taper w is the transform of
the autocorrelation R of the record times that of the taper,

    S(f) = sum over lags of  R(lag) r_w(lag) exp(-2 pi i f lag),

so one transform of the whole record gives the spectrum at the resolution of any segment length, and no
segment is transformed to choose one (R. B. Blackman and J. W. Tukey, The Measurement of Power Spectra, 1959;
P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .pooled import parts_of, shortest
from .recording import Recording

__all__ = [
    "Autocorrelation",
    "fast_length",
    "half_power_widths",
    "hann_autocorrelation",
    "longest_power",
    "narrow_width",
    "power_of_two",
    "standing_peaks",
]

# Segments are not longer than this share of the record, so that their scatter can be told.
SEGMENTS = 10.0
# Peaks lower than this over the band's median are not taken for resonances.
PEAK_RATIO = 10.0
# The narrow bandwidth is this quantile of those of all peaks.
NARROWEST = 0.25


@dataclass(frozen=True, eq=False)
class Autocorrelation:
    """Autocorrelation of a record's responses, each of unit power, summed."""

    rec: Recording

    @property
    def longest(self) -> int:
        """Samples of the longest segments that leave enough averages."""
        return longest_power(self.rec)

    @cached_property
    def _lags(self) -> FloatArray:
        # With NumPy: SciPy's transforms are faster, but their import takes longer than all of this.
        lags = np.zeros(self.longest)
        for part in parts_of(self.rec):
            n = fast_length(part.n_samples + self.longest)
            total = np.zeros(n, dtype=np.float32)
            # The power of z = x + i y, taken at f and at -f together, is that of x and y.
            for first in range(0, part.n_channels, 2):
                z: NDArray[Any] = np.zeros(n, dtype=np.complex64)
                for row, x in zip(part.responses[first : first + 2], (z.real, z.imag), strict=False):
                    _unit_power(row, x[: row.size])
                z = np.fft.fft(z)
                total += z.real**2
                total += z.imag**2
            half = total[: n // 2 + 1] + np.roll(total[::-1], 1)[: n // 2 + 1]
            lags += 0.5 * np.fft.irfft(half, n)[: self.longest]
        return lags

    def power(self, n: int, band_hz: tuple[float, float]) -> FloatArray:
        """Power of all channels at equal weight in the band, as Hann segments of ``n`` samples resolve it."""
        lags = self._lags[:n] * hann_autocorrelation(n)[: self._lags.size]
        # Negative lags, folded onto the length of a segment.
        folded = np.zeros(n)
        folded[: lags.size] = lags
        folded[n - lags.size + 1 :] += lags[:0:-1]
        freq = np.fft.rfftfreq(n, 1.0 / self.rec.fs_hz)
        inside = (freq >= band_hz[0]) & (freq <= band_hz[1])
        return np.asarray(np.fft.rfft(folded).real[inside], dtype=np.float64)


def fast_length(least: int) -> int:
    """The smallest product of powers of 2, 3 and 5 that is not less.

    Examples
    --------
    >>> from antires_rs.signals.bandwidth import fast_length
    >>> fast_length(1025), fast_length(121)
    (1080, 125)
    """
    best = 1 << max(least - 1, 1).bit_length()
    fives = 1
    while fives < best:
        odd = fives
        while odd < best:
            twos = max(-(-least // odd) - 1, 0).bit_length()
            best = min(best, odd << twos)
            odd *= 3
        fives *= 5
    return best


def _unit_power(row: FloatArray, out: FloatArray) -> None:
    """Write a row less its mean, of unit power: in seven digits, as only widths of peaks are looked for."""
    np.subtract(row, row.mean(), out=out, casting="same_kind")
    # Of what stays constant nothing is left but rounding.
    size = float(np.linalg.norm(out)) if row.max() > row.min() else 0.0
    out *= np.float32(1.0 / size if size > 0.0 else 0.0)


def hann_autocorrelation(n: int) -> FloatArray:
    """Of the periodic Hann window of ``n`` samples, one at lag zero."""
    taper = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n)
    r = np.fft.irfft(np.abs(np.fft.rfft(taper, 2 * n)) ** 2)[:n]
    return np.asarray(r / r[0], dtype=np.float64)


def longest_power(rec: Recording) -> int:
    """Samples of the longest segments that leave enough averages and fit every part of the record."""
    n = power_of_two(rec.n_samples / SEGMENTS)
    while n > shortest(rec):
        n //= 2
    return n


def power_of_two(n: float) -> int:
    """The nearest, by ratio."""
    return int(2 ** max(0, round(np.log2(max(n, 1.0)))))


def narrow_width(power: FloatArray) -> float | None:
    """Half-power bandwidth, in lines, of the sharp ones among the peaks that stand out; None without any."""
    widths = half_power_widths(power)
    return float(np.quantile(widths, NARROWEST)) if widths else None


def half_power_widths(power: FloatArray) -> list[float]:
    """Widths, in lines, of the peaks that stand out."""
    # The area over the height is steadier than the two half-power points of a ragged spectrum;
    # pi/2 half-power widths make the area of a resonance.
    return [
        float(power[lo : hi + 1].sum() / power[peak]) * 2 / np.pi for lo, peak, hi in _owned_by_peaks(power)
    ]


def standing_peaks(power: FloatArray) -> list[int]:
    """Lines of the peaks that stand out."""
    return [peak for _, peak, _ in _owned_by_peaks(power)]


def _owned_by_peaks(power: FloatArray) -> list[tuple[int, int, int]]:
    """First line, highest line and last line of each peak, which owns all down to a tenth of its height."""
    left = power.copy()
    least = PEAK_RATIO * np.median(power)
    owned = []
    while left.max() > least:
        peak = int(np.argmax(left))
        lo = hi = peak
        while lo > 0 and power[lo - 1] > 0.1 * power[peak]:
            lo -= 1
        while hi < power.size - 1 and power[hi + 1] > 0.1 * power[peak]:
            hi += 1
        if lo > 0 and hi < power.size - 1 and left[lo : hi + 1].min() > 0:
            owned.append((lo, peak, hi))
        left[lo : hi + 1] = 0.0
    return owned
