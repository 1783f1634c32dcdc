"""Damage as several measurements see it, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.validation import reject
from .canvas import COLOURS, fit_across, new_axes, offer
from .damage import element_axis, element_names, mark_truth, percent_axis

if TYPE_CHECKING:
    from ..damage.result import DamageResult

__all__ = ["plot_damages"]

#: Looks of the bars, told apart in grey too.
LOOKS = (
    {"facecolor": COLOURS["blue"], "edgecolor": "black"},
    {"facecolor": "white", "edgecolor": COLOURS["vermillion"], "hatch": "/////"},
    {"facecolor": "#D9D9D9", "edgecolor": "black", "hatch": "..."},
    {"facecolor": "white", "edgecolor": COLOURS["green"], "hatch": "xxxx"},
)


def plot_damages(
    results: Mapping[str, DamageResult], ax: Any = None, truth: Mapping[int, float] | None = None
) -> Any:
    """Draw the stiffness loss of each candidate element in % as found by several approaches.

    Parameters
    ----------
    results : mapping of str to DamageResult
        By the name of the approach, two to four, all with the same candidate elements.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    truth : mapping of int to float, optional
        True loss by zero-based element, where it is known; drawn as diamonds.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    InvalidInputError
        Fewer than two results or more than four, or different candidate elements.
    MissingDependencyError
        matplotlib is not installed.

    Notes
    -----
    As Fig. 8 of V. Meruane, J. Sound Vib. 332 (2013) 807-820, for antiresonances beside resonances with mode
    shapes.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs.plotting import plot_damages
    >>> from matplotlib.figure import Figure
    >>> case = ar.cases.chain8()
    >>> both = {"antiresonances": case.exact(1), "resonances and shapes": case.exact_modes(1)}
    >>> found = {name: ar.assess_damage(case.model, exact, rng=0) for name, exact in both.items()}
    >>> ax = plot_damages(found, ax=Figure().subplots(), truth={4: 0.55})
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['antiresonances', 'resonances and shapes', 'truth']
    """
    if not 2 <= len(results) <= len(LOOKS):
        reject("results", f"{len(results)} results", f"two to {len(LOOKS)}", "Pass a dict of name to result.")
    first, *others = results.values()
    if any(other.elements != first.elements for other in others):
        reject("results", "different candidate elements", "the same in all", "Pass a dict of name to result.")
    names = element_names(first)
    ax = new_axes(ax, (max(7.0, 0.4 * len(names) + 1.5), 4.4))
    x = np.arange(len(names))
    width = 0.8 / len(results)
    upright = not fit_across(ax, names)
    known = 100.0 * np.array([(truth or {}).get(e, np.nan) for e in first.elements])
    losses = {name: 100.0 * np.asarray(result.x) for name, result in results.items()}
    percent_axis(ax, np.concatenate([known, *losses.values()]), upright)
    # Under bars as narrow as this numbers stand upright.
    narrow = len(names) * len(results) > 24
    for k, (name, percent) in enumerate(losses.items()):
        at = x + (k - 0.5 * (len(results) - 1)) * width
        ax.bar(at, percent, width=0.92 * width, label=name, linewidth=0.8, **LOOKS[k])
        for where, value in zip(at, percent, strict=True):
            if value > 0.0:
                # A number beside its bar's middle: the diamond of the truth stands between the bars.
                ax.annotate(
                    f"{value:.1f}",
                    (where, value),
                    xytext=(0, 4),
                    textcoords="offset points",
                    ha="center",
                    va="bottom",
                    fontsize="x-small",
                    rotation=90 if narrow else 0,
                )
    if truth is not None:
        mark_truth(ax, x, known, 7)
    element_axis(ax, names, upright, first=tuple(results))
    columns = {f"{name}_percent": percent for name, percent in losses.items()}
    shown = {} if truth is None else {"truth_percent": known}
    offer(ax, bars={"element": first.elements, "name": names, **columns, **shown})
    return ax
