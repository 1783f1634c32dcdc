r"""Welch spectra, frequency responses and transmissibilities from records.

Conventions: S_ab is what ``scipy.signal.csd(a, b)`` computes, the average of conj(A) B. So
X_p = T_pj X_j gives

    H1:  T = S_jp / S_jj      H2:  T = S_pp / S_pj      Hv:  total least squares on (x_j, x_p)

and the same with the force for x_j in an FRF. H1 is biased low by noise on the input, H2 biased high by
noise on the output. For a transmissibility H1 is at its worst exactly where it matters: at an
antiresonance of j the channel x_j is all noise, and the peak of T_pj is flattened. "rank1" uses that one
force acts: the matrix of all spectra has rank one but for noise, and its dominant eigenvector, with the
channels scaled to equal noise, holds the responses up to a common factor.

References: P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73; J. S. Bendat and A. G. Piersol,
Random Data, 4th ed., 2010; G. T. Rocklin, J. Crowley, H. Vold, Proc. IMAC 3 (1985) 272-278 (Hv).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ._validation import ComplexArray, FloatArray, choice, integer, reject
from .exceptions import UnsuitableDataError
from .rankone import response_vectors
from .signals import FrequencyResponse, Recording

__all__ = ["CrossSpectra", "cross_spectra", "frf", "transmissibility", "transmissibility_sum"]


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
    """

    freq_hz: FloatArray
    matrix: ComplexArray
    n_averages: int
    noise: FloatArray | None = None
    added_decay_per_s: float = 0.0


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
    taper = _window(window, n_seg)
    data = rec.responses
    if include_force:
        data = np.vstack([data, _force(rec)])
    segments = np.lib.stride_tricks.sliding_window_view(data, n_seg, axis=1)[:, ::n_seg - overlap]
    spectra = np.fft.rfft((segments - segments.mean(axis=2, keepdims=True)) * taper)
    matrix = averaged_products(spectra) / (rec.fs_hz * (taper @ taper))
    # One-sided: all lines but zero and Nyquist stand for two.
    matrix[1:None if n_seg % 2 else -1] *= 2.0
    freq = np.asarray(np.fft.rfftfreq(n_seg, 1.0 / rec.fs_hz), dtype=np.float64)
    return CrossSpectra(freq, matrix, spectra.shape[1])


def frf(rec: Recording, *, nperseg: int | None = None, noverlap: int | None = None, window: Any = "hann",
        estimator: str = "h1", method: str = "auto") -> FrequencyResponse:
    """Frequency response functions of all channels to the recorded force.

    Parameters
    ----------
    rec : Recording
        With ``force``.
    nperseg, noverlap, window
        As for :func:`cross_spectra`; not used for hits.
    estimator : {"h1", "h2", "hv"}
        ``S_fx / S_ff``, ``S_xx / S_xf``, or total least squares with both signals scaled to unit rms, so that
        units do not matter.
    method : {"auto", "welch", "transient"}
        "auto" refuses Welch on a record that decays; "welch" forces it; "transient" transforms whole hits.

    Returns
    -------
    FrequencyResponse
        ``kind="frf"``, with ordinary coherence (none for a single average, where it is one by construction).

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
                             coherence=coherence[:-1] if spectra.n_averages > 1 else None)


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
        ``kind="transmissibility"``; the row of j is one.

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
    if estimator == "rank1":
        vectors, _ = response_vectors(spectra.matrix, spectra.noise)
        values = vectors / vectors[j]
    values[j] = 1.0
    return FrequencyResponse(spectra.freq_hz, values, rec.dofs, "transmissibility", reference,
                             coherence if spectra.n_averages > 1 else None)


def transmissibility_sum(resp: FrequencyResponse) -> ComplexArray:
    """Sum over p of ``abs(Re T_pj) + i abs(Im T_pj)``: Eq. 10 of the paper as printed, for the eye.

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


def two_channel(matrix: ComplexArray, j: int, estimator: str) -> tuple[ComplexArray, FloatArray]:
    """Every channel over channel j by H1, H2 or Hv, and ordinary coherence; both (n_channels, n_freq)."""
    auto = np.einsum("fii->if", matrix).real
    s_jp, s_jj = matrix[:, j, :].T, auto[j]
    if not s_jj[1:].all() or not auto.any(axis=1).all():
        dead = int(np.flatnonzero(~auto[:, 1:].all(axis=1))[0])
        raise UnsuitableDataError(f"responses: channel {dead} has no energy at some frequencies; wanted "
                                  "signals that are not zero. Leave the dead channel out.")
    with np.errstate(divide="ignore", invalid="ignore"):
        coherence = np.clip(np.abs(s_jp)**2 / (s_jj * auto), 0.0, 1.0)
        if estimator == "h1":
            values = s_jp / s_jj
        elif estimator == "h2":
            values = auto / s_jp.conj()
        else:
            scale = np.sqrt(auto.mean(axis=1) / s_jj.mean())[:, None]
            a, b, c = s_jj, auto / scale**2, s_jp / scale
            # Dominant eigenvector of [[a, conj c], [c, b]], from the row that does not cancel.
            largest = 0.5 * (a + b + np.hypot(a - b, 2.0 * np.abs(c)))
            values = np.where(a >= b, c / (largest - b), (largest - a) / c.conj()) * scale
    # Lines without energy (often zero frequency, after the mean was removed) carry no information.
    return np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0), np.nan_to_num(coherence)


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


def _window(window: Any, n: int) -> FloatArray:
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
