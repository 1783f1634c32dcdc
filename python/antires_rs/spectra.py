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

from dataclasses import dataclass
from typing import Any

import numpy as np

from ._validation import ComplexArray, FloatArray, choice, integer, reject
from .estimators import std_of_rank_one, two_channel
from .rankone import response_vectors
from .signals import FrequencyResponse, Recording

__all__ = ["CrossSpectra", "cross_spectra", "effective_averages", "frf", "transmissibility",
           "transmissibility_sum", "two_channel"]


@dataclass(frozen=True, eq=False)
class CrossSpectra:
    """Averaged spectral matrix of several channels.

    Attributes
    ----------
    freq_hz : (n_freq,)
    matrix : (n_freq, n_channels, n_channels) complex
        ``matrix[:, a, b]`` is the average of conj(A) B: a one-sided density for Welch, energy spectra
        for hits.
    n_averages : int
        Segments or hits averaged.
    noise : (n_channels,) or None
        Noise part of the diagonal, where it was measured (before a hit).
    added_decay_per_s : float
        Decay rate of an exponential window; roots identified from these spectra carry it in their real part.
    n_effective : float
        Independent averages that would scatter as much: fewer than ``n_averages`` where segments overlap.
        0 (default) stands for ``n_averages``.
    segments : (n_channels, n_segments, n_freq) complex or None
        What was averaged: ``matrix`` is the mean over segments of conj(A) B.
    """

    freq_hz: FloatArray
    matrix: ComplexArray
    n_averages: int
    noise: FloatArray | None = None
    added_decay_per_s: float = 0.0
    n_effective: float = 0.0
    segments: ComplexArray | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "n_effective", self.n_effective or float(self.n_averages))


def effective_averages(taper: FloatArray, step: int, n_segments: int) -> float:
    """Number of independent averages with the variance of ``n_segments`` that overlap.

    Parameters
    ----------
    taper : (nperseg,)
        The window.
    step : int
        Samples from one segment's start to the next.
    n_segments : int

    Returns
    -------
    float
        ``K / (1 + 2 sum_j (1 - j/K) r_j)`` with K segments and
        ``r_j = (sum w[k] w[k + j step])**2 / (sum w**2)**2``.

    Notes
    -----
    P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73: variance of the averaged spectrum of a
    signal that is white over the width of the window.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.spectra import effective_averages
    >>> hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(256) / 256)
    >>> round(effective_averages(hann, 128, 31), 1), round(effective_averages(hann, 256, 16), 1)
    (29.4, 16.0)
    """
    shifts = np.arange(1, min(n_segments, -(-taper.size // step)))
    shared = np.array([(taper[j * step:] @ taper[:taper.size - j * step])**2 for j in shifts])
    return float(n_segments / (1.0 + 2.0 * np.sum((1.0 - shifts / n_segments) * shared) / (taper @ taper)**2))


def averaged_products(spectra: ComplexArray) -> ComplexArray:
    """Mean over segments of conj(A) B; (n_channels, n_segments, n_freq) to (n_freq, n, n)."""
    by_line = np.ascontiguousarray(spectra.transpose(2, 0, 1))
    return np.asarray(by_line.conj() @ by_line.transpose(0, 2, 1) / spectra.shape[1], dtype=np.complex128)


def cross_spectra(rec: Recording, *, nperseg: int, noverlap: int | None = None, window: Any = "hann",
                  include_force: bool = False) -> CrossSpectra:
    """Welch's averaged auto and cross spectral densities of all channels at once.

    Parameters
    ----------
    rec : Recording
    nperseg : int
        Samples per segment.
    noverlap : int, optional
        Samples shared by neighbours; default half a segment.
    window : str, tuple or array_like
        As for ``scipy.signal.get_window``, periodic; or ``nperseg`` values.
    include_force : bool
        Append ``rec.force`` as the last channel.

    Returns
    -------
    CrossSpectra
        Agrees with ``scipy.signal.csd`` (density, constant detrend) to rounding, but each channel and
        segment is transformed once.

    Raises
    ------
    InvalidInputError
        Segments that do not fit the record, an unknown window, or a force that was not recorded.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.signals import Recording
    >>> from antires_rs.spectra import cross_spectra
    >>> rec = Recording(np.random.default_rng(0).standard_normal((2, 4096)), 100.0)
    >>> cross_spectra(rec, nperseg=512).matrix.shape
    (257, 2, 2)
    """
    _recording(rec)
    n_seg = integer("nperseg", nperseg, low=8, high=rec.n_samples)
    overlap = n_seg // 2 if noverlap is None else integer("noverlap", noverlap, low=0, high=n_seg - 1)
    taper = window_values(window, n_seg)
    data = channels_of(rec, include_force)
    segments = np.lib.stride_tricks.sliding_window_view(data, n_seg, axis=1)[:, ::n_seg - overlap]
    spectra = np.fft.rfft((segments - segments.mean(axis=2, keepdims=True)) * taper)
    # One-sided: all lines but zero and Nyquist stand for two.
    density = np.full(spectra.shape[2], 2.0)
    density[[0] if n_seg % 2 else [0, -1]] = 1.0
    spectra *= np.sqrt(density / (rec.fs_hz * (taper @ taper)))
    freq = np.asarray(np.fft.rfftfreq(n_seg, 1.0 / rec.fs_hz), dtype=np.float64)
    return CrossSpectra(freq, averaged_products(spectra), spectra.shape[1],
                        n_effective=effective_averages(taper, n_seg - overlap, spectra.shape[1]),
                        segments=spectra)


def frf(rec: Recording, *, nperseg: int | None = None, noverlap: int | None = None, window: Any = "hann",
        estimator: str = "h1", method: str = "auto") -> FrequencyResponse:
    """Frequency response functions of all channels to the recorded force.

    Parameters
    ----------
    rec : Recording
        With ``force``.
    nperseg, noverlap, window
        As for :func:`~antires_rs.spectra.cross_spectra`; not used for hits.
    estimator : {"h1", "h2", "hv"}
        ``S_fx / S_ff``, ``S_xx / S_xf``, or total least squares with both signals scaled to unit rms, so that
        units do not matter.
    method : {"auto", "welch", "transient"}
        "auto" refuses Welch on a record that decays; "welch" forces it; "transient" transforms whole hits.

    Returns
    -------
    FrequencyResponse
        ``kind="frf"``, with ordinary coherence, the effective number of averages and the standard deviation
        of every value (no coherence and no deviation for a single average, where coherence is one by
        construction).

    Raises
    ------
    InvalidInputError
        No force, bad segments, unknown option.
    UnsuitableDataError
        A decaying record under ``method="auto"``.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.signals import Recording
    >>> from antires_rs.spectra import frf
    >>> force = np.random.default_rng(0).standard_normal(8192)
    >>> h = frf(Recording([2.0 * force, -force], 512.0, force=force), nperseg=1024)
    >>> h.values[:, 100].real.round(9).tolist()
    [2.0, -1.0]
    """
    _recording(rec)
    choice("estimator", estimator, ("h1", "h2", "hv"))
    _force(rec)
    spectra = averaged_spectra(rec, nperseg, noverlap, window, method, include_force=True)
    values, coherence = two_channel(spectra.matrix, spectra.matrix.shape[1] - 1, estimator)
    return FrequencyResponse(spectra.freq_hz, values[:-1], rec.dofs, "frf",
                             coherence=coherence[:-1] if spectra.n_averages > 1 else None,
                             n_averages=spectra.n_effective)


def transmissibility(
    rec: Recording,
    reference: Any,
    *,
    nperseg: int | None = None,
    noverlap: int | None = None,
    window: Any = "hann",
    estimator: str = "h1",
    method: str = "auto",
) -> FrequencyResponse:
    """Transmissibilities ``T_pj = X_p / X_j`` of all channels p to one reference j.

    Parameters
    ----------
    rec : Recording
        Two channels or more; ``force`` is not read.
    reference : int or str
        Label j, one of ``rec.dofs``.
    nperseg, noverlap, window, method
        As for :func:`frf`.
    estimator : {"h1", "h2", "hv", "rank1"}
        ``S_jp / S_jj``, ``S_pp / S_pj``, total least squares on the pair (scaled to unit rms), or the
        dominant eigenvector of the whole matrix scaled to equal noise. "rank1" is best near the
        antiresonances of j.

    Returns
    -------
    FrequencyResponse
        ``kind="transmissibility"``; the row of j is one. ``coherence`` is the ordinary coherence of p and j
        whatever the estimator; ``std`` is that of the estimator, see :mod:`~antires_rs.estimators`.

    Raises
    ------
    InvalidInputError
        A reference that was not recorded, bad segments, unknown option.
    UnsuitableDataError
        A decaying record under ``method="auto"``, or a reference channel that is zero.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.signals import Recording
    >>> from antires_rs.spectra import transmissibility
    >>> x = np.random.default_rng(0).standard_normal(8192)
    >>> t = transmissibility(Recording([x, 3.0 * x], 512.0, dofs=["a", "b"]), "a", nperseg=1024)
    >>> t.values[:, 100].real.round(9).tolist()
    [1.0, 3.0]
    """
    _recording(rec)
    choice("estimator", estimator, ("h1", "h2", "hv", "rank1"))
    if reference not in rec.dofs:
        reject("reference", reference, f"a recorded dof, one of {rec.dofs}")
    j = rec.dofs.index(reference)
    spectra = averaged_spectra(rec, nperseg, noverlap, window, method)
    values, coherence = two_channel(spectra.matrix, j, "h1" if estimator == "rank1" else estimator)
    std = None
    # A single average is of rank one as it stands.
    if estimator == "rank1" and spectra.n_averages > 1:
        vectors, _ = response_vectors(spectra.matrix, spectra.noise)
        values = vectors / vectors[j]
        if rec.n_channels > 1:
            std = std_of_rank_one(spectra.matrix, j, spectra.n_effective)
    values[j] = 1.0
    return FrequencyResponse(spectra.freq_hz, values, rec.dofs, "transmissibility", reference,
                             coherence if spectra.n_averages > 1 else None, spectra.n_effective, std)


def transmissibility_sum(resp: FrequencyResponse) -> ComplexArray:
    """Sum over p of ``abs(Re T_pj) + i abs(Im T_pj)``, the paper's equation 10 as printed, for the eye.

    Parameters
    ----------
    resp : FrequencyResponse
        Of ``kind="transmissibility"``. The reference's own row of ones is left out.

    Returns
    -------
    (n_freq,) complex
        Peaks at the antiresonances of the reference. The absolute values kink at every sign change, so it
        cannot be fitted by a rational function; identification uses the joint fit instead.

    Raises
    ------
    InvalidInputError
        FRFs instead of transmissibilities.

    Notes
    -----
    V. Meruane, J. Sound Vib. 332 (2013) 807-820, Eq. 10.

    Examples
    --------
    >>> from antires_rs.signals import FrequencyResponse
    >>> from antires_rs.spectra import transmissibility_sum
    >>> t = FrequencyResponse([1.0, 2.0], [[1, 1], [-3 + 1j, 2 - 2j]], kind="transmissibility", reference=0)
    >>> transmissibility_sum(t).tolist()
    [(3+1j), (2+2j)]
    """
    if not isinstance(resp, FrequencyResponse) or resp.kind != "transmissibility":
        reject(
            "resp",
            getattr(resp, "kind", type(resp).__name__),
            "a FrequencyResponse of kind 'transmissibility'",
        )
    others = np.delete(resp.values, resp.dofs.index(resp.reference), axis=0)
    return np.asarray(np.abs(others.real).sum(axis=0) + 1j * np.abs(others.imag).sum(axis=0))


def averaged_spectra(rec: Recording, nperseg: int | None, noverlap: int | None, window: Any, method: str, *,
                     include_force: bool = False) -> CrossSpectra:
    """Welch or whole hits, by ``method``."""
    from .transient import require_stationary, transient_spectra  # transient builds on this module
    choice("method", method, ("auto", "welch", "transient"))
    if method == "transient":
        return transient_spectra(rec, include_force=include_force)
    if nperseg is None:
        reject("nperseg", None, "an integer, the samples per segment", "Long enough for several decay times.")
    if method == "auto":
        require_stationary(rec)
    return cross_spectra(rec, nperseg=nperseg, noverlap=noverlap, window=window, include_force=include_force)


def _recording(rec: object) -> None:
    if not isinstance(rec, Recording):
        reject("rec", type(rec).__name__, "a Recording")


def _force(rec: Recording) -> FloatArray:
    if rec.force is None:
        reject("rec", "a Recording without force", "one with the force recorded",
               "Use transmissibilities: they need no force.")
    return rec.force


def channels_of(rec: Recording, include_force: bool) -> FloatArray:
    """The responses, and below them the force where it is wanted."""
    return np.vstack([rec.responses, _force(rec)]) if include_force else rec.responses


def window_values(window: Any, n: int) -> FloatArray:
    """The window as an array, from a name known to scipy or from given values."""
    if isinstance(window, str | tuple):
        from scipy.signal import get_window  # slow to import
        try:
            return np.asarray(get_window(window, n), dtype=np.float64)
        except ValueError as exc:
            reject("window", window, f"a window known to scipy.signal.get_window ({exc})")
    taper = np.asarray(window, dtype=np.float64)
    if taper.shape != (n,) or not np.isfinite(taper).all() or not taper.any():
        reject("window", f"an array of shape {taper.shape}", f"a window name, or {n} finite values")
    return taper
