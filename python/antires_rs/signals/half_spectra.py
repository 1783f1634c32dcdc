r"""Positive half spectra: what responses alone tell about resonances.

Under a broadband force the correlation of channels a and b decays like the structure rings,

    R_ab(tau) = E[x_a(t) x_b(t + tau)] = sum_r g_ra phi_rb exp(s_r tau) + its conjugate,      tau > 0

so that its transform over positive lags is a rational function with the poles s_r and the shapes phi_r, as an
FRF is. (The full auto spectrum has each pole twice, and no phase.) The transform back from Welch's spectra
gives R times the autocorrelation of the taper, which is known and divided out: leakage, which widens every
peak of a Welch spectrum, is gone. An exponential over the lags keeps the tail, where only scatter is left,
from counting; its decay is taken off the poles exactly. White noise of a sensor lives at lag zero and adds a
constant.

What remains is scatter: the force is known only on average. For well separated modes no method can do
better than a relative standard deviation of 1 / sqrt(2 pi zeta N) in damping and sqrt(zeta / (4 pi N)) in
frequency, N the cycles of the mode in the record: 6 % and 0.04 % for 22 Hz with 1 % damping in 200 s.

References: J. S. Bendat and A. G. Piersol, Random Data, 4th ed., 2010 (correlation from spectra); B.
Cauberghe, Ph.D. thesis, Vrije Universiteit Brussel, 2004 (positive half spectra); S.-K. Au, Mech. Syst.
Signal Process. 48 (2014) 15-33 (limits).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..support.checks import ComplexArray, FloatArray
from .averaging import hann_autocorrelation, transient_spectra
from .recording import Recording
from .spectra import CrossSpectra, cross_spectra

# Amplitude of the exponential at the last lag.
END_AMPLITUDE = 1e-3
# Every channel is an output to some channels taken as references; more curves than this add no knowledge.
MOST_CURVES = 64


@dataclass(frozen=True)
class HalfSpectra:
    """``values`` are (n_references, n_channels, n_freq) in the channels' own units."""

    freq_hz: FloatArray
    values: ComplexArray
    references: tuple[int, ...]
    added_decay_per_s: float


def half_spectra(rec: Recording, *, nperseg: int | None) -> HalfSpectra:
    """Half spectra of all channels to a few references."""
    if nperseg is None:
        spectra = transient_spectra(rec)
        n = round(rec.fs_hz / spectra.freq_hz[1])
        references = _references(spectra)
        two_sided = spectra.matrix[:, references]
        taper_share = np.ones(n)
    else:
        n = nperseg - nperseg % 2
        spectra = cross_spectra(rec, nperseg=n)
        references = _references(spectra)
        two_sided = spectra.matrix[:, references] * (0.5 * rec.fs_hz)
        two_sided[[0, -1]] *= 2.0
        taper_share = hann_autocorrelation(n)
    n_lags = n // 2
    correlation = np.fft.irfft(two_sided, n, axis=0)[:n_lags]
    lag_s = np.arange(n_lags) / rec.fs_hz
    decay = -np.log(END_AMPLITUDE) / (n_lags / rec.fs_hz)
    correlation *= (np.exp(-decay * lag_s) / taper_share[:n_lags])[:, None, None]
    values = np.fft.rfft(correlation, axis=0).transpose(1, 2, 0)
    freq = np.asarray(np.fft.rfftfreq(n_lags, 1.0 / rec.fs_hz), dtype=np.float64)
    # Correlations of windowed impacts decay by the window's own rate in the lag.
    return HalfSpectra(
        freq, np.ascontiguousarray(values), tuple(references), float(decay) + spectra.added_decay_per_s
    )


def _references(spectra: CrossSpectra) -> list[int]:
    """All channels if they are few; else those whose amplitude spectra differ most (pivoted QR)."""
    n = spectra.matrix.shape[1]
    count = max(1, MOST_CURVES // n)
    if n <= count:
        return list(range(n))
    from scipy.linalg import qr  # slow to import

    amplitude = np.sqrt(np.einsum("fii->fi", spectra.matrix).real)
    pivots = qr(amplitude / np.linalg.norm(amplitude, axis=0), mode="r", pivoting=True)[1]
    return sorted(int(i) for i in pivots[:count])


# -- Peaks that stand out of a curve, by their prominence


def prominent_peaks(curve: FloatArray, least: float) -> NDArray[np.int64]:
    """Indices of the maxima with a prominence of ``least`` at least, ascending.

    The prominence is the height over the higher of the two lowest points that lie between the peak and the
    next higher point, or the end, on either side. Of a flat top the middle is taken. As
    ``scipy.signal.find_peaks``, whose import takes longer than the identification of a short record.
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
