"""Stabilization diagram: model order against frequency."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.validation import FloatArray
from .canvas import COLOURS, below, new_axes, offer, spread

if TYPE_CHECKING:
    from ..order_sweep.diagram import StabilizationDiagram

__all__ = ["mark_values", "plot_stabilization", "pole_table"]

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
