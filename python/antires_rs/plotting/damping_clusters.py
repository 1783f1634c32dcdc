"""Damping against frequency: the poles of all orders, clustered where something physical is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.validation import FloatArray
from .canvas import COLOURS, below, new_axes, offer, plain_log
from .stabilization import diagram_tables, mark_values, pole_table

if TYPE_CHECKING:
    from ..order_sweep.diagram import StabilizationDiagram

__all__ = ["plot_damping_clusters"]

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
    >>> from antires_rs.plotting.damping_clusters import plot_damping_clusters
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
