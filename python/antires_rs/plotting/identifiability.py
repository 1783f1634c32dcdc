"""What a test leaves open of each parameter, within its bounds."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import COLOURS, below, new_axes, offer

if TYPE_CHECKING:
    from ..updating.box_identifiability import BoxIdentifiability

__all__ = ["plot_identifiability"]

#: Names longer than this are cut: the whole ones are among the numbers.
_LONGEST = 48


def plot_identifiability(found: BoxIdentifiability, ax: Any = None) -> Any:
    """Draw what is left of each parameter's standard deviation after a test, a bar each.

    Parameters
    ----------
    found : BoxIdentifiability
        Of :func:`antires_rs.identifiability`.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        Bars in %, the first parameter on top: 100 is a test that tells nothing. Beyond the line a
        parameter counts as not told.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs.plotting import plot_identifiability
    >>> from matplotlib.figure import Figure
    >>> problem = ar.cases.chain8().updating_problem()
    >>> found = ar.identifiability(problem, points=4, forces=[], sensors=[])
    >>> ax = plot_identifiability(found, ax=Figure().subplots())
    >>> round(max(bar.get_width() for bar in ax.patches))
    100
    """
    ax = new_axes(ax, (8.0, max(2.5, 0.9 + 0.24 * len(found.names))))
    left = 100.0 * found.left
    told = found.left < found.TOLD
    y = np.arange(left.size)
    for these, colour, hatch, label in (
        (told, COLOURS["blue"], "", "told"),
        (~told, COLOURS["vermillion"], "////", "not told"),
    ):
        if these.any():
            ax.barh(
                y[these],
                left[these],
                height=0.7,
                facecolor=colour if not hatch else "white",
                edgecolor=colour,
                hatch=hatch,
                label=label,
            )
    ax.axvline(100.0 * found.TOLD, color="black", lw=0.8, ls="--")
    cut = [name if len(name) <= _LONGEST else f"{name[: _LONGEST - 1]}\u2026" for name in found.names]
    ax.set_yticks(y, cut, fontsize="small")
    ax.set_ylim(left.size - 0.4, -0.6)
    ax.set_xlim(0.0, 105.0)
    ax.set_xlabel("standard deviation left after the test, % of that within the bounds")
    ax.grid(axis="x", alpha=0.25)
    ax.set_axisbelow(True)
    below(ax)
    offer(ax, parameters={"name": np.array(found.names), "left_percent": left})
    return ax
