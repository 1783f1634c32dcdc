"""Stabilization diagram: model order against frequency."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from ..signals.frequency_response import FrequencyResponse
from ..support.checks import FloatArray
from .canvas import COLOURS, GREY, LINES, band_shown, below, new_axes, offer, plain_log, spread

if TYPE_CHECKING:
    from ..identification.stabilization import StabilizationDiagram
    from ..signals.one_force import DataCheck

#: Lighter than every mark, also where colours are lost.
CURVE = "#B8B8B8"
#: Look of the antiresonances: accepted as stable, accepted without it, and added by hand.
LOOKS: dict[str, dict[str, Any]] = {
    "accepted": {"color": COLOURS["vermillion"], "ls": "--", "lw": 1.1},
    "accepted: not stable over the orders": {"color": COLOURS["vermillion"], "ls": "-.", "lw": 1.1},
    "added by hand": {"color": COLOURS["black"], "ls": (0, (8, 3)), "lw": 1.1},
    "dropped by hand": {"color": COLOURS["black"], "ls": ":", "lw": 1.1},
}


def plot_stabilization(
    diagram: StabilizationDiagram,
    ax: Any = None,
    *,
    dropped: Sequence[float] | FloatArray = (),
    added: Sequence[float] | FloatArray = (),
) -> Any:
    """Draw the poles of every order, the stable ones, and the accepted antiresonances.

    Parameters
    ----------
    diagram : StabilizationDiagram
        From :func:`~antires_rs.stabilization`, or ``AntiresonanceSet.diagrams[dof]``.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default. It gets a twin axis for the curve behind the poles.
    dropped, added : sequence of float, optional
        Values in Hz that were taken out or put in by hand; :meth:`~antires_rs.AntiresonanceSet.plot` knows
        them.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> from matplotlib.figure import Figure
    >>> f = np.linspace(1.0, 20.0, 200)
    >>> noise = 1e-3 * np.random.default_rng(0).standard_normal(200)
    >>> diagram = ar.stabilization(f, 25 / (5**2 - f**2 + 0.1j * f) + noise, max_order=20)
    >>> diagram.plot(ax=Figure().subplots()).get_xlabel()
    'Frequency (Hz)'
    """
    ax = new_axes(ax, (9.0, 5.2))
    order, freq, _, stable = pole_table(diagram)

    behind = ax.twinx()
    size = np.where(np.asarray(diagram.background) > 0.0, diagram.background, np.nan)
    behind.plot(diagram.background_freq_hz, size, color=CURVE, lw=1.0)
    if np.isfinite(size).any():
        behind.set_yscale("log")
    behind.set_ylabel("Magnitude of the summed curves (unit of the data)", color="#595959")
    # The poles belong in front of the curve, though its axis was made later.
    ax.set_zorder(behind.get_zorder() + 1)
    ax.patch.set_visible(False)

    ax.plot(
        freq[~stable],
        order[~stable],
        ls="",
        marker="x",
        ms=3.5,
        mew=0.7,
        color=COLOURS["orange"],
        label="pole, not stable",
    )
    ax.plot(
        freq[stable],
        order[stable],
        ls="",
        marker="o",
        ms=3.0,
        mew=0.0,
        color=COLOURS["blue"],
        label="stable pole",
    )
    ax.set_xlim(*diagram.band_hz)
    mark_values(ax, diagram, dropped, added)
    # In the legend of the front axis, though drawn on the other.
    ax.plot([], [], color=CURVE, lw=1.0, label="summed curves, which peak at the poles (right axis)")
    ax.set_ylim(int(diagram.orders[0]) - 1, int(diagram.orders[-1]) + 1)
    ax.set_xlabel("Frequency (Hz)")
    ax.set_ylabel("Model order (-)")
    ax.yaxis.get_major_locator().set_params(integer=True)
    below(ax, markerscale=1.6)
    offer(
        ax,
        **diagram_tables(diagram, dropped, added),
        curve={"freq_hz": diagram.background_freq_hz, "magnitude": diagram.background},
    )
    return ax


def diagram_tables(
    diagram: StabilizationDiagram, dropped: Sequence[float] | FloatArray, added: Sequence[float] | FloatArray
) -> dict[str, dict[str, Any]]:
    """The poles and the values of a diagram, as pictures of it offer them."""
    order, freq, damping, stable = pole_table(diagram)
    found, by_hand = diagram.accepted, np.asarray(added, dtype=np.float64)
    unknown = np.full(by_hand.size, np.nan)
    gone = np.isin(found.freq_hz, np.asarray(dropped, dtype=np.float64))
    return {
        "poles": {"order": order, "freq_hz": freq, "damping_ratio": damping, "stable": stable},
        "values": {
            "freq_hz": np.r_[found.freq_hz, by_hand],
            "damping_ratio": np.r_[found.damping_ratio, unknown],
            "std_hz": np.r_[found.std_hz, unknown],
            "how": [*np.where(gone, "dropped", found.how), *["added"] * by_hand.size],
        },
    }


def pole_table(diagram: StabilizationDiagram) -> tuple[FloatArray, FloatArray, FloatArray, Any]:
    """Order, frequency in Hz, damping ratio and stability of all poles, (n_poles,) each."""
    order = np.repeat(np.asarray(diagram.orders), [len(f) for f in diagram.freq_hz])
    freq = np.concatenate([np.empty(0), *diagram.freq_hz])
    damping = np.concatenate([np.empty(0), *diagram.damping_ratio])
    return order, freq, damping, np.concatenate([np.empty(0, dtype=bool), *diagram.stable])


def mark_values(
    ax: Any,
    diagram: StabilizationDiagram,
    dropped: Sequence[float] | FloatArray,
    added: Sequence[float] | FloatArray,
) -> None:
    """Vertical lines with their frequencies above the axes, pushed apart where they would overlap.

    A dropped antiresonance has its frequency in parentheses.
    """
    low, high = diagram.band_hz
    stable, unsteady, by_hand, out = LOOKS
    gone = np.asarray(dropped, dtype=np.float64)
    marks = [
        (float(f), out if f in gone else stable if how in ("chain", "windows") else unsteady)
        for f, how in zip(diagram.identified, diagram.accepted.how, strict=True)
    ]
    marks = sorted(marks + [(float(f), by_hand) for f in added])
    transform = ax.get_xaxis_transform()
    labels_at = spread([f for f, _ in marks], (high - low) / 50.0, low, high)
    named: set[str] = set()
    for (freq, kind), label_at in zip(marks, labels_at, strict=True):
        ax.axvline(freq, zorder=1.5, label=None if kind in named else kind, **LOOKS[kind])
        named.add(kind)
        ax.annotate(
            f"({freq:.2f} Hz)" if kind == out else f"{freq:.2f} Hz",
            (freq, 1.0),
            xytext=(label_at, 1.03),
            xycoords=transform,
            textcoords=transform,
            rotation=90,
            ha="center",
            va="bottom",
            fontsize="x-small",
            annotation_clip=False,
            arrowprops={
                "arrowstyle": "-",
                "lw": 0.6,
                "color": LOOKS[kind]["color"],
                "shrinkA": 0.0,
                "shrinkB": 0.0,
            },
        )
    if not marks:
        ax.set_title("no antiresonance accepted in this band", fontsize="medium")


# -- Damping against frequency: the poles of all orders, clustered where something physical is


#: Foot of the logarithmic axis, percent; what lies below, or has none, stands on it.
LEAST_PERCENT = 0.01
#: Room above the highest pole.
HEADROOM = 1.3


def plot_damping_clusters(
    diagram: StabilizationDiagram,
    ax: Any = None,
    *,
    dropped: Sequence[float] | FloatArray = (),
    added: Sequence[float] | FloatArray = (),
) -> Any:
    """Draw the damping ratio of all poles of all orders against their frequency.

    The poles of an antiresonance gather in one spot over many orders; spurious poles scatter everywhere.
    A cluster elongated upwards has an uncertain damping; one elongated sideways, an uncertain frequency.
    Squares are the accepted antiresonances. They may lie beside their cluster: near the noise the poles of
    the sweep are biased, while the antiresonances are taken from the likeliest fit.

    Parameters
    ----------
    diagram : StabilizationDiagram
        From :func:`~antires_rs.stabilization`, or ``AntiresonanceSet.diagrams[dof]``.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    dropped, added : sequence of float, optional
        Values in Hz that were taken out or put in by hand; :meth:`~antires_rs.AntiresonanceSet.plot` knows
        them.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.

    Notes
    -----
    The damping axis is logarithmic. Poles with less than 0.01 %, or right of the imaginary axis, stand as
    triangles on its foot.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> from antires_rs.figures.identification import plot_damping_clusters
    >>> from matplotlib.figure import Figure
    >>> f = np.linspace(1.0, 20.0, 200)
    >>> noise = 1e-3 * np.random.default_rng(0).standard_normal(200)
    >>> diagram = ar.stabilization(f, 25 / (5**2 - f**2 + 0.1j * f) + noise, max_order=20)
    >>> plot_damping_clusters(diagram, ax=Figure().subplots()).get_ylabel()
    'Damping ratio (%)'
    """
    ax = new_axes(ax, (9.0, 5.2))
    _, freq, damping, stable = pole_table(diagram)
    percent = 100.0 * damping
    low = percent < LEAST_PERCENT
    ax.plot(
        freq[~stable & ~low],
        percent[~stable & ~low],
        ls="",
        marker="x",
        ms=4.0,
        mew=0.8,
        color=COLOURS["orange"],
        label="pole, not stable",
    )
    ax.plot(
        freq[stable & ~low],
        percent[stable & ~low],
        ls="",
        marker="o",
        ms=4.0,
        mew=0.0,
        alpha=0.6,
        color=COLOURS["blue"],
        label="stable pole",
    )
    if low.any():
        ax.plot(
            freq[low],
            np.full(int(low.sum()), LEAST_PERCENT),
            ls="",
            marker="v",
            ms=4.0,
            mew=0.0,
            color="#595959",
            clip_on=False,
            label=f"pole with less than {LEAST_PERCENT:g} %, or none",
        )
    mark_values(ax, diagram, dropped, added)
    if diagram.identified.size:
        found = np.maximum(100.0 * diagram.identified_damping, LEAST_PERCENT)
        ax.plot(
            diagram.identified,
            found,
            ls="",
            marker="s",
            ms=9.0,
            mew=1.4,
            mfc="none",
            mec=COLOURS["black"],
            clip_on=False,
            zorder=4,
            label="damping of the value",
        )
    ax.set_yscale("log")
    top = max(float(percent.max(initial=0.0)), 1.0)
    ax.set_ylim(LEAST_PERCENT, HEADROOM * top)
    plain_log(ax.yaxis, narrow=False)
    ax.set_xlim(*diagram.band_hz)
    ax.set_xlabel("Frequency (Hz)")
    ax.set_ylabel("Damping ratio (%)")
    ax.grid(axis="y", alpha=0.25)
    below(ax)
    offer(ax, **diagram_tables(diagram, dropped, added))
    return ax


# -- What stands behind an identification: coherence, and whether one force is enough


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
    >>> from antires_rs.figures.identification import plot_coherence
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
    >>> from antires_rs.signals import check_data
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
