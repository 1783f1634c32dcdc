r"""Positive half spectra: what responses alone tell about resonances.

Under a broadband force the correlation of channels a and b decays like the structure rings,

    R_ab(tau) = E[x_a(t) x_b(t + tau)] = sum_r g_ra phi_rb exp(s_r tau) + its conjugate,      tau > 0

so that its transform over positive lags is a rational function with the poles s_r and the shapes phi_r, as an
FRF is. The transform back from Welch's spectra gives R times the autocorrelation of the taper, which is
divided out: leakage is gone. An exponential over the lags keeps the tail, where only scatter is left, from
counting; its decay is taken off the poles exactly. No method can do better than a relative standard deviation
of 1 / sqrt(2 pi zeta N) in damping and sqrt(zeta / (4 pi N)) in frequency, N the cycles of the mode.

References: J. S. Bendat and A. G. Piersol, Random Data, 4th ed., 2010; B. Cauberghe, Ph.D. thesis, Vrije
Universiteit Brussel, 2004; S.-K. Au, Mech. Syst. Signal Process. 48 (2014) 15-33 (limits).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..support.checks import ComplexArray, FloatArray
from .averaging import hann_autocorrelation, transient_spectra
from .recording import Recording
from .spectra import CrossSpectra, cross_spectra

END_AMPLITUDE = 1e-3  # amplitude of the exponential at the last lag
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
    return HalfSpectra(  # Correlations of windowed impacts decay by the window's own rate in the lag.
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
