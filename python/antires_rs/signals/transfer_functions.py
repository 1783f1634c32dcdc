"""Frequency response functions and transmissibilities from records."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..exceptions import UnsuitableDataError, reject
from ..support.checks import ComplexArray, choice
from .averaging import METHODS, Averaging, holds_hits, transient_spectra
from .frequency_response import FrequencyResponse
from .recording import Recording, check_recording, force_of
from .spectra import CrossSpectra, cross_spectra, response_vectors, std_of_rank_one, two_channel


def frf(
    rec: Recording,
    *,
    nperseg: int | None = None,
    noverlap: int | None = None,
    window: Any = "hann",
    estimator: str = "h1",
    method: str = "auto",
) -> FrequencyResponse:
    """Frequency response functions of all channels to the recorded force.

    Parameters
    ----------
    rec : Recording
        With ``force``.
    nperseg, noverlap, window
        Samples of a Welch segment and of their overlap (default half), window as for
        ``scipy.signal.get_window``; not used for impacts.
    estimator : {"h1", "h2", "hv"}
        ``S_fx / S_ff``, ``S_xx / S_xf``, or total least squares with both signals scaled to unit rms.
    method : {"auto", "welch", "transient"}
        "auto" refuses Welch on a record that decays; "welch" forces it; "transient" transforms whole impacts.

    Returns
    -------
    FrequencyResponse
        ``kind="frf"``, with ordinary coherence, the effective number of averages and the standard deviation
        of every value (neither coherence nor deviation for a single average).

    Raises
    ------
    InvalidInputError
        No force, bad segments, unknown option.
    UnsuitableDataError
        A decaying record under ``method="auto"``.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> force = np.random.default_rng(0).standard_normal(8192)
    >>> h = ar.frf(ar.Recording([2.0 * force, -force], 512.0, force=force), nperseg=1024)
    >>> h.values[:, 100].real.round(9).tolist()
    [2.0, -1.0]
    """
    check_recording(rec)
    choice("estimator", estimator, ("h1", "h2", "hv"))
    force_of(rec)
    spectra = averaged_spectra(rec, nperseg, noverlap, window, method, include_force=True)
    values, coherence = two_channel(spectra.matrix, spectra.matrix.shape[1] - 1, estimator)
    known = None if spectra.n_averages == 1 else coherence[:-1], spectra.n_effective
    return FrequencyResponse(spectra.freq_hz, values[:-1], rec.dofs, "frf", None, *known)


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
        whatever the estimator; ``std`` is that of the estimator, see :mod:`~antires_rs.signals.spectra`.

    Raises
    ------
    InvalidInputError
        A reference that was not recorded, bad segments, unknown option.
    UnsuitableDataError
        A decaying record under ``method="auto"``, or a reference channel that is zero.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> x = np.random.default_rng(0).standard_normal(8192)
    >>> t = ar.transmissibility(ar.Recording([x, 3.0 * x], 512.0, dofs=["a", "b"]), "a", nperseg=1024)
    >>> t.values[:, 100].real.round(9).tolist()
    [1.0, 3.0]
    """
    check_recording(rec)
    choice("estimator", estimator, ("h1", "h2", "hv", "rank1"))
    if reference not in rec.dofs:
        reject("reference", reference, f"a recorded dof, one of {rec.dofs}", "Name a dof of the recording.")
    j = rec.dofs.index(reference)
    spectra = averaged_spectra(rec, nperseg, noverlap, window, method)
    values, coherence = two_channel(spectra.matrix, j, "h1" if estimator == "rank1" else estimator)
    std = None
    # a single average is of rank one as it stands.
    if estimator == "rank1" and spectra.n_averages > 1:
        vectors, _ = response_vectors(spectra.matrix, spectra.noise)
        values = vectors / vectors[j]
        if rec.n_channels > 1:
            std = std_of_rank_one(spectra, j)
    values[j] = 1.0
    known = None if spectra.n_averages == 1 else coherence, spectra.n_effective, std
    return FrequencyResponse(spectra.freq_hz, values, rec.dofs, "transmissibility", reference, *known)


def transmissibility_sum(resp: FrequencyResponse) -> ComplexArray:
    """Sum over p of ``abs(Re T_pj) + i abs(Im T_pj)``: V. Meruane, J. Sound Vib. 332 (2013) 807-820, Eq. 10.

    Parameters
    ----------
    resp : FrequencyResponse
        Of ``kind="transmissibility"``. The reference's own row of ones is left out.

    Returns
    -------
    (n_freq,) complex
        Its absolute value, which the paper fits (its square: ``preset="paper"``), has its peaks at the
        antiresonances of the reference.

    Raises
    ------
    InvalidInputError
        FRFs instead of transmissibilities.

    Examples
    --------
    >>> import antires_rs as ar
    >>> rows = [[1, 1], [-3 + 1j, 2 - 2j]]
    >>> t = ar.FrequencyResponse([1.0, 2.0], rows, kind="transmissibility", reference=0)
    >>> ar.transmissibility_sum(t).tolist()
    [(3+1j), (2+2j)]
    """
    if not isinstance(resp, FrequencyResponse) or resp.kind != "transmissibility":
        got = getattr(resp, "kind", type(resp).__name__)
        wanted = "a FrequencyResponse of kind 'transmissibility'"
        reject("resp", got, wanted, "Estimate it by antires_rs.transmissibility.")
    others = np.delete(resp.values, resp.dofs.index(resp.reference), axis=0)
    return np.asarray(np.abs(others.real).sum(axis=0) + 1j * np.abs(others.imag).sum(axis=0))


def averaged_spectra(
    rec: Recording,
    nperseg: int | None,
    noverlap: int | None,
    window: Any,
    method: str,
    *,
    include_force: bool = False,
) -> CrossSpectra:
    """Welch or whole impacts, by ``method``."""
    choice("method", method, METHODS)
    if method == "transient":
        return transient_spectra(rec, include_force=include_force)
    if nperseg is None:
        reject("nperseg", None, "an integer, the samples per segment", "Long enough for several decay times.")
    if holds_hits(rec, Averaging(method=method)):
        raise UnsuitableDataError(
            "method",
            "'auto' for a record whose energy decays by more than 20 dB",
            "steady vibration for Welch's averages, because a segment that starts within a decay does not "
            "hold its own excitation",
            "Use method='transient' (one transform over each whole impact), or force it with method='welch'.",
        )
    return cross_spectra(rec, nperseg=nperseg, noverlap=noverlap, window=window, include_force=include_force)
