"""Stabilization diagram: model order against frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import COLOURS, GREY, below, new_axes, spread

if TYPE_CHECKING:
    from ..stabilization import StabilizationDiagram

__all__ = ["plot_stabilization"]


def plot_stabilization(diagram: StabilizationDiagram, ax: Any = None) -> Any:
    """Draw poles of every order, the stable ones, and the values accepted.

    Parameters
    ----------
    diagram : StabilizationDiagram
        From :func:`~antires_rs.stabilization`, or ``AntiresonanceSet.diagrams[dof]``.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default. It gets a twin axis for the response behind the poles.

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
    counts = [len(f) for f in diagram.freq_hz]
    order = np.repeat(np.asarray(diagram.orders), counts)
    freq = np.concatenate([np.empty(0), *diagram.freq_hz])
    stable = np.concatenate([np.empty(0, dtype=bool), *diagram.stable])

    behind = ax.twinx()
    size = np.where(np.asarray(diagram.background) > 0.0, diagram.background, np.nan)
    behind.plot(diagram.background_freq_hz, size, color=GREY, lw=1.0, alpha=0.8)
    if np.isfinite(size).any():
        behind.set_yscale("log")
    behind.set_ylabel("Magnitude of the summed responses (unit of the data)", color="#595959")
    # The poles belong in front of the curve, though its axis was made later.
    ax.set_zorder(behind.get_zorder() + 1)
    ax.patch.set_visible(False)

    ax.plot(freq[~stable], order[~stable], ls="", marker="x", ms=3.5, mew=0.7, color=COLOURS["orange"],
            label="pole, not stable")
    ax.plot(freq[stable], order[stable], ls="", marker="o", ms=3.0, mew=0.0, color=COLOURS["blue"],
            label="stable pole")
    low, high = diagram.band_hz
    ax.set_xlim(low, high)
    _mark_accepted(ax, np.asarray(diagram.identified), low, high)
    # In the legend of the front axis, though drawn on the other.
    ax.plot([], [], color=GREY, lw=1.0, label="response (right axis)")
    ax.set_ylim(int(diagram.orders[0]) - 1, int(diagram.orders[-1]) + 1)
    ax.set_xlabel("Frequency (Hz)")
    ax.set_ylabel("Model order (-)")
    below(ax, 4, markerscale=1.6)
    return ax


def _mark_accepted(ax: Any, found: Any, low: float, high: float) -> None:
    """Vertical lines with their frequencies above the axes, pushed apart where they would overlap."""
    transform = ax.get_xaxis_transform()
    labels_at = spread(found, (high - low) / 50.0, low, high)
    for i, (freq, label_at) in enumerate(zip(found, labels_at, strict=True)):
        ax.axvline(freq, color=COLOURS["vermillion"], lw=1.0, ls="--", zorder=1.5,
                   label="accepted" if i == 0 else None)
        ax.annotate(f"{freq:.2f} Hz", (freq, 1.0), xytext=(label_at, 1.03), xycoords=transform,
                    textcoords=transform, rotation=90, ha="center", va="bottom", fontsize="x-small",
                    arrowprops={"arrowstyle": "-", "lw": 0.6, "color": COLOURS["vermillion"],
                                "shrinkA": 0.0, "shrinkB": 0.0}, annotation_clip=False)
    if not len(found):
        ax.set_title("no value accepted in this band", fontsize="medium")
