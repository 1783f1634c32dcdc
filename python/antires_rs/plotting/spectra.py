"""What stands behind an identification: coherence, and whether one force is enough."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..signals.frequency_response import FrequencyResponse
from ..support.validation import reject
from .canvas import COLOURS, GREY, LINES, band_shown, below, new_axes, offer

if TYPE_CHECKING:
    from ..data_check import DataCheck

__all__ = ["plot_coherence", "plot_singular_values"]

#: With more curves than this each one is drawn thin and pale, and their median on top.
FEW = 5


def plot_coherence(resp: FrequencyResponse, ax: Any = None, *, band_hz: Sequence[float] | None = None) -> Any:
    """Draw the ordinary coherence of every output by frequency.

    Parameters
    ----------
    resp : FrequencyResponse
        With ``coherence``, e.g. from :func:`~antires_rs.frf` or :func:`~antires_rs.transmissibility`.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    band_hz : (low, high), optional
        Lines drawn; all of the data by default.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InvalidInputError
        Responses without coherence, or a band outside the data.
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs.plotting.spectra import plot_coherence
    >>> from matplotlib.figure import Figure
    >>> rec = ar.cases.chain8().experiment(noise=0.02, duration_s=60.0, rng=0)
    >>> plot_coherence(ar.frf(rec, nperseg=4096), ax=Figure().subplots()).get_ylabel()
    'Coherence with the force (-)'
    """
    if not isinstance(resp, FrequencyResponse) or resp.coherence is None:
        reject(
            "resp",
            "responses without coherence" if isinstance(resp, FrequencyResponse) else type(resp).__name__,
            "a FrequencyResponse with coherence",
            "Estimate it from a record with several averages.",
        )
    ax = new_axes(ax, (9.0, 4.0))
    low, high = band_shown(resp.freq_hz, band_hz)
    rows = [p for p, dof in enumerate(resp.dofs) if dof != resp.reference]
    curves = resp.coherence[rows]
    if len(rows) <= FEW:
        for i, (row, curve) in enumerate(zip(rows, curves, strict=True)):
            ax.plot(
                resp.freq_hz,
                curve,
                lw=1.2,
                ls=LINES[i % len(LINES)],
                color=list(COLOURS.values())[i % len(COLOURS)],
                label=f"dof {resp.dofs[row]}",
            )
    else:
        for i, curve in enumerate(curves):
            ax.plot(resp.freq_hz, curve, lw=0.7, color="#B8B8B8", label="each dof" if i == 0 else None)
        ax.plot(
            resp.freq_hz, curves.min(axis=0), lw=1.0, ls="--", color=COLOURS["vermillion"], label="lowest"
        )
        ax.plot(resp.freq_hz, np.median(curves, axis=0), lw=1.6, color=COLOURS["blue"], label="median")
    if resp.n_averages is not None and resp.n_averages > 1.0:
        ax.axhline(
            1.0 / resp.n_averages,
            color=COLOURS["black"],
            lw=0.9,
            ls=":",
            label=f"noise alone, {resp.n_averages:.0f} averages",
        )
    ax.set_xlim(low, high)
    ax.set_ylim(0.0, 1.04)
    ax.set_xlabel("Frequency (Hz)")
    to = "the force" if resp.reference is None else f"dof {resp.reference}"
    ax.set_ylabel(f"Coherence with {to} (-)")
    ax.grid(alpha=0.25)
    below(ax)
    shown = (resp.freq_hz >= low) & (resp.freq_hz <= high)
    offer(
        ax,
        coherence={
            "freq_hz": resp.freq_hz[shown],
            **{str(resp.dofs[row]): curve[shown] for row, curve in zip(rows, curves, strict=True)},
        },
    )
    return ax


def plot_singular_values(check: DataCheck, ax: Any = None) -> Any:
    """Draw the singular values of the responses' spectral matrix, and what one force would make the second.

    Under one force the first stands out, and the second lies where noise and leakage put it. A second force
    lifts the second everywhere but at the resonances. Channels are scaled to equal noise, so 0 dB is the
    noise (on exact data: 60 dB below the mean power).

    Parameters
    ----------
    check : DataCheck
        Of a Recording, from :func:`~antires_rs.check_data`.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InvalidInputError
        A check of data without averages, which has no spectral matrix.
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs.data_check import check_data
    >>> from matplotlib.figure import Figure
    >>> rec = ar.cases.chain8().experiment(noise=0.02, duration_s=60.0, rng=0)
    >>> check_data(rec, band_hz=(3, 130)).plot(ax=Figure().subplots()).get_ylabel()
    'Singular value (dB re noise power)'
    """
    values = getattr(check, "eigenvalues", None)
    if values is None:
        reject(
            "check",
            "a check without eigenvalues" if hasattr(check, "findings") else type(check).__name__,
            "the DataCheck of a Recording with several averages",
            "Single impacts and measured responses have no spectral matrix.",
        )
    ax = new_axes(ax, (9.0, 4.5))
    level = 10.0 * np.log10(np.maximum(values, 1e-14 * values.max()))
    for i in range(values.shape[1] - 1, 1, -1):
        # Rank deficient by construction: rounding, which would only stretch the axis.
        seen = np.where(values[:, i] > 1e-12 * values.max(), level[:, i], np.nan)
        ax.plot(check.freq_hz, seen, lw=0.5, color="#C4C4C4", label="the others" if i == 2 else None)
    table = {"freq_hz": check.freq_hz, **{f"level_{i}_db": level[:, i] for i in range(level.shape[1])}}
    if check.second_expected is not None:
        expected = 10.0 * np.log10(np.maximum(check.second_expected, 1e-14 * values.max()))
        table["expected_2_db"] = expected
        ax.plot(
            check.freq_hz,
            expected,
            lw=1.1,
            ls=":",
            color=COLOURS["black"],
            zorder=3.0,
            label="second expected under one force",
        )
    if values.shape[1] > 1:
        ax.plot(check.freq_hz, level[:, 1], lw=1.1, ls="--", color=COLOURS["vermillion"], label="second")
    ax.plot(check.freq_hz, level[:, 0], lw=1.5, color=COLOURS["blue"], label="first")
    ax.set_xlim(*check.band_hz)
    ax.set_xlabel("Frequency (Hz)")
    ax.set_ylabel("Singular value (dB re noise power)")
    ax.grid(alpha=0.25, color=GREY)
    found = check.named("one_force")
    ax.set_title(f"more than one force ({found[0].severity})" if found else "", fontsize="medium")
    below(ax, first=("first", "second", "second expected under one force", "the others"))
    offer(ax, singular_values=table)
    return ax
