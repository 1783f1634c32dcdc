r"""Welch spectra, frequency responses and transmissibilities from records.

Conventions: S_ab is what ``scipy.signal.csd(a, b)`` computes, the average of conj(A) B. So
X_p = T_pj X_j gives

    H1:  T = S_jp / S_jj      H2:  T = S_pp / S_pj      Hv:  total least squares on (x_j, x_p)

and the same with the force for x_j in an FRF. H1 is biased low by noise on the input, H2 biased high by
noise on the output. For a transmissibility H1 is at its worst exactly where it matters: at an antiresonance
of j the channel x_j is mostly noise, the estimate is the true T divided by 1 + noise / signal of x_j at that
line, and the peak of T_pj is flattened. No averaging helps: a bias, unlike scatter, stays. Nor does the
coherence-based standard deviation show it. H2 has that bias at the antiresonances of p instead, Hv lies
between. "rank1" uses that one force acts: the matrix of all spectra has rank one but for noise, and its
dominant eigenvector, with the channels scaled to equal noise, holds the responses up to a common factor,
without bias to first order.

References: P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73; J. S. Bendat and A. G. Piersol,
Random Data, 4th ed., 2010; G. T. Rocklin, J. Crowley, H. Vold, Proc. IMAC 3 (1985) 272-278 (Hv).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..support.checks import ComplexArray, FloatArray, integer, real_array
from .noise import noise_power
from .recording import Recording
from .segments import Segments, add_products, parts_of, pieces, shortest

#: Numbers of the spectra that are multiplied together: 4 MB.
TOGETHER = 1 << 18


@dataclass(frozen=True, eq=False)
class CrossSpectra:
    """Averaged spectral matrix of several channels.

    Attributes
    ----------
    freq_hz : (n_freq,)
    matrix : (n_freq, n_channels, n_channels) complex
        ``matrix[:, a, b]`` is the average of conj(A) B: a one-sided density for Welch, energy spectra
        for impacts.
    n_averages : int
        Segments or impacts averaged.
    noise : (n_channels,) or None
        Noise part of the diagonal, where it was measured (before an impact).
    added_decay_per_s : float
        Decay rate of an exponential window; roots identified from these spectra carry it in their real part.
    n_effective : float
        Independent averages that would scatter as much: fewer than ``n_averages`` where segments overlap.
        0 (default) stands for ``n_averages``.
    segments : Segments or None
        What was averaged: ``matrix`` is the mean over segments of conj(A) B.
    draws : (n_segments,) int or None
        To which of several independent draws, records or impacts, each segment belongs; None for one record.
    """

    freq_hz: FloatArray
    matrix: ComplexArray
    n_averages: int
    noise: FloatArray | None = None
    added_decay_per_s: float = 0.0
    n_effective: float = 0.0
    segments: Segments | None = None
    draws: NDArray[np.int64] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "n_effective", self.n_effective or float(self.n_averages))

    @cached_property
    def noise_power(self) -> FloatArray:
        """Noise power of each channel at the median line, see :mod:`~antires_rs.signals.noise`."""
        return noise_power(self.matrix, self.n_effective)

    def rows(self, rows: list[int]) -> CrossSpectra:
        """Spectra of some of the channels, without the segments; these spectra if it is all of them."""
        if rows == list(range(self.matrix.shape[1])):
            return self
        return replace(
            self,
            matrix=self.matrix[:, rows][:, :, rows],
            segments=None,
            noise=None if self.noise is None else self.noise[rows],
        )


def effective_averages(taper: FloatArray, step: int, n_segments: int) -> float:
    """Number of independent averages with the variance of ``n_segments`` that overlap.

    Notes
    -----
    P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73: variance of the averaged spectrum of a
    signal that is white over the width of the window.
    """
    shifts = np.arange(1, min(n_segments, -(-taper.size // step)))
    shared = np.array([(taper[j * step :] @ taper[: taper.size - j * step]) ** 2 for j in shifts])
    return float(
        n_segments / (1.0 + 2.0 * np.sum((1.0 - shifts / n_segments) * shared) / (taper @ taper) ** 2)
    )


def cross_spectra(
    rec: Recording,
    *,
    nperseg: int,
    noverlap: int | None = None,
    window: Any = "hann",
    include_force: bool = False,
    band_hz: tuple[float, float] | None = None,
) -> CrossSpectra:
    """Welch's averaged auto and cross spectral densities of all channels at once."""
    check_recording(rec)
    n_seg = integer("nperseg", nperseg, low=8, high=shortest(rec))
    overlap = n_seg // 2 if noverlap is None else integer("noverlap", noverlap, low=0, high=n_seg - 1)
    taper = window_values(window, n_seg)
    freq = np.asarray(np.fft.rfftfreq(n_seg, 1.0 / rec.fs_hz), dtype=np.float64)
    # One-sided: all lines but zero and Nyquist stand for two.
    density = np.full(freq.size, 2.0)
    density[[0] if n_seg % 2 else [0, -1]] = 1.0
    lines = slice(0, freq.size) if band_hz is None else lines_in(freq, band_hz)
    freq = freq[lines]
    step = n_seg - overlap
    parts = parts_of(rec)
    counts = [1 + (part.n_samples - n_seg) // step for part in parts]
    factor = np.sqrt(density[lines] / (rec.fs_hz * (taper @ taper)))
    rows = [rows_of(part, include_force) for part in parts]
    # Of one size in all channels, so that single precision holds them in any unit.
    unit = np.array([max(float(np.abs(row).max()) for row in own) or 1.0 for own in zip(*rows, strict=True)])
    products = np.zeros((freq.size, unit.size, unit.size), dtype=np.complex128)
    segments = np.empty((freq.size, unit.size, sum(counts)), dtype=np.complex64)
    done = 0
    for own in rows:
        for some in _transforms(own, unit, taper, step, lines):
            add_products(products, some)
            segments[:, :, done : done + some.shape[2]] = some
            done += some.shape[2]
    scale = factor[:, None] * unit
    products *= scale[:, :, None]
    products *= scale[:, None, :] / done
    return CrossSpectra(
        freq,
        products,
        done,
        n_effective=sum(effective_averages(taper, step, count) for count in counts),
        segments=Segments(segments, products, scale, np.ones(scale.shape)),
        draws=np.repeat(np.arange(len(parts)), counts) if len(parts) > 1 else None,
    )


def _transforms(
    rows: list[FloatArray], unit: FloatArray, taper: FloatArray, step: int, lines: slice
) -> Iterator[ComplexArray]:
    """Spectra of all segments, (n_lines, n_channels, n_more) at a time; nothing else transforms segments."""
    n, count = taper.size, 1 + (rows[0].size - taper.size) // step
    tapers = (taper / unit[:, None])[:, None, :]
    views = [np.lib.stride_tricks.sliding_window_view(row, n)[::step] for row in rows]
    # Products of many segments cost little more than those of few.
    for group in pieces(count, len(rows) * (lines.stop - lines.start), at_a_time=TOGETHER):
        spectra = np.empty(
            (lines.stop - lines.start, len(rows), group.stop - group.start), dtype=np.complex128
        )
        for some in pieces(group.stop - group.start, len(rows) * n):
            at = slice(group.start + some.start, group.start + some.stop)
            samples = np.stack([view[at] for view in views])
            samples -= samples.mean(axis=2, keepdims=True)
            samples *= tapers
            spectra[:, :, some] = np.fft.rfft(samples)[:, :, lines].transpose(2, 0, 1)
        yield spectra


def lines_in(freq_hz: FloatArray, band_hz: tuple[float, float]) -> slice:
    """The lines in a band; zero frequency is none of them: means are removed, accelerations vanish."""
    first = int(np.searchsorted(freq_hz, max(band_hz[0], np.nextafter(0.0, 1.0)), side="left"))
    return slice(first, max(first, int(np.searchsorted(freq_hz, band_hz[1], side="right"))))


def check_recording(rec: object) -> None:
    """Refuse what is not a Recording."""
    if not isinstance(rec, Recording):
        reject(
            "rec",
            type(rec).__name__,
            "a Recording",
            "Make one of the arrays first: Recording(responses, fs_hz).",
        )


def force_of(rec: Recording) -> FloatArray:
    """The measured force, which this estimate needs."""
    if rec.force is None:
        reject(
            "rec",
            "a Recording without force",
            "one with the force recorded",
            "Use transmissibilities: they need no force.",
        )
    return rec.force


def rows_of(rec: Recording, include_force: bool) -> list[FloatArray]:
    """The responses, and after them the force where it is wanted."""
    return [*rec.responses, force_of(rec)] if include_force else [*rec.responses]


def window_values(window: Any, n: int) -> FloatArray:
    """The window as an array, from a name known to scipy or from given values."""
    if isinstance(window, str) and window == "hann":
        return np.asarray(0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n))
    if isinstance(window, str | tuple):
        from scipy.signal import get_window  # slow to import

        try:
            return np.asarray(get_window(window, n), dtype=np.float64)
        except ValueError as exc:
            reject(
                "window",
                window,
                f"a window known to scipy.signal.get_window ({exc})",
                "Leave it out for 'hann'.",
            )
    taper = real_array("window", window, ndim=1, wanted=f"a window name, or {n} finite values")
    if taper.shape != (n,) or not taper.any():
        reject(
            "window",
            f"an array of shape {taper.shape}",
            f"a window name, or {n} finite values",
            "Give a value for each sample of a segment.",
        )
    return taper
