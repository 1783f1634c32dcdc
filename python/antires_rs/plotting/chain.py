"""Chains of masses and springs, coloured by any value."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.validation import FloatArray
from .canvas import COLOURS, below, fit_across, new_axes, offer, width_pt
from .values import coloured, value_by_element

if TYPE_CHECKING:
    from ..models.chain import MassSpringChain

__all__ = ["coil", "plot_chain", "spring_paths"]

#: Share of a free end's stiffness that rounding may leave.
ROUNDING = 1e-9
#: Up to this many masses the springs are drawn as coils, so high.
MOST_COILS, HEIGHT = 20, 0.16


def plot_chain(
    model: MassSpringChain,
    values: Any = None,
    ax: Any = None,
    *,
    sensors: Sequence[int] = (),
    excitation: int | None = None,
    label: str = "Value by spring",
) -> Any:
    """Draw a chain with its springs numbered and coloured by a value of each.

    Parameters
    ----------
    model : MassSpringChain
    values : array_like, (n_masses - 1,), or mapping of int to float, optional
        Value of each spring between masses, for example ``DamageResult.severity``: light grey at 0, dark blue
        at the largest; springs without one are thin. Those to ground have theirs in a mapping.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    sensors : sequence of int, optional
        Dofs of the accelerometers; arrows above their masses.
    excitation : int, optional
        Dof of the force; a heavier arrow below its mass.
    label : str
        Name of the values, with their unit.

    Returns
    -------
    matplotlib.axes.Axes
        Masses and springs with their numbers from 0, as tables have them.

    Raises
    ------
    InvalidInputError
        Values that do not fit the springs, dofs outside the model.
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs.plotting import plot_chain
    >>> from matplotlib.figure import Figure
    >>> ax = plot_chain(ar.cases.chain8().model, {4: 55.0}, ax=Figure().subplots(), excitation=0)
    >>> ax.get_xlabel()
    'Mass (number of each spring above it)'
    """
    n = model.n_dof
    force = [] if excitation is None else [model._dof("excitation", excitation)]
    measured = [model._dof("sensors", dof) for dof in sensors]
    given = value_by_element(values, n + 1 if values is None or isinstance(values, Mapping) else n - 1)
    ax = new_axes(ax, (max(6.0, 0.5 * n + 1.5), 2.8))
    springs = spring_paths(model)
    paths = list(springs.values())
    by_spring = np.full(n + 1, np.nan)
    if given is None:
        for path in paths:
            ax.plot(*path.T, color=COLOURS["blue"], lw=1.6, zorder=2)
    else:
        by_spring[: given.size] = given
        coloured(ax, paths, by_spring[list(springs)], label, width=2.6 if n <= MOST_COILS else 5.0)
    size = float(np.clip(0.4 * width_pt(ax) / (n + 1), 4.0, 22.0))
    ax.plot(range(n), np.zeros(n), ls="", marker="s", ms=size, mfc="white", mec="black", mew=1.2, zorder=3)
    for element in springs.keys() & {n - 1, n}:
        wall = springs[element][-1, 0]
        ax.plot([wall, wall], [-0.4, 0.4], color="black", lw=2.5, zorder=3)
    _arrows(ax, measured, 0.5 * size + 8.0, COLOURS["vermillion"], 11.0, "accelerometer")
    _arrows(ax, force, -0.5 * size - 9.0, COLOURS["black"], 15.0, "force")
    every = next(step for step in (1, 2, 5, 10, n) if fit_across(ax, [str(n)] * (n // step), 8.0))
    for element in list(springs)[::every]:
        name = str(element) if element < n - 1 else "ground"
        ax.annotate(
            name,
            (springs[element][:, 0].mean(), HEIGHT),
            xytext=(0, 4),
            ha="center",
            va="bottom",
            textcoords="offset points",
            fontsize="small",
        )
    ax.set_xticks(range(0, n, every), [str(i) for i in range(0, n, every)])
    reach = np.array([[0.0, n - 1.0], *([path[:, 0].min(), path[:, 0].max()] for path in paths)])
    ax.set_xlim(reach.min() - 0.6, reach.max() + 0.6)
    ax.set_ylim(-0.8, 0.8)
    ax.set_yticks([])
    ax.set_xlabel("Mass (number of each spring above it)")
    if ax.get_legend_handles_labels()[1]:
        below(ax)
    offer(
        ax,
        springs={
            "element": list(springs),
            "name": [model.element_label(e) for e in springs],
            **({} if given is None else {"value": by_spring[list(springs)]}),
        },
    )
    return ax


def coil(a: FloatArray, b: FloatArray, amplitude: float) -> FloatArray:
    """A spring as it is drawn from a to b, (n, 2): straight ends and a zigzag."""
    share = np.array([0.0, 0.25, *np.linspace(0.29, 0.71, 8), 0.75, 1.0])
    off = amplitude * np.array([0.0, 0.0, *np.tile([1.0, -1.0], 4), 0.0, 0.0])
    across = np.array([a[1] - b[1], b[0] - a[0]])
    return np.asarray(a + share[:, None] * (b - a) + off[:, None] * across)


def spring_paths(model: MassSpringChain) -> dict[int, FloatArray]:
    """The springs that there are, by element: those between masses, then those to ground."""
    n, stiffness = model.n_dof, model.stiffness()
    ends = {i: (i, i + 1) for i in range(n - 1)}
    for element, mass, wall in ((n - 1, 0, -1), (n, n - 1, n)):
        if stiffness[mass].sum() > ROUNDING * stiffness[mass, mass]:
            ends[element] = (mass, wall)
    high = HEIGHT if n <= MOST_COILS else 0.0
    return {element: coil(np.array([a, 0.0]), np.array([b, 0.0]), high) for element, (a, b) in ends.items()}


def _arrows(ax: Any, dofs: list[int], offset_pt: float, colour: str, size: float, name: str) -> None:
    """Arrows to the right, the positive direction, so many points above their masses."""
    from matplotlib.transforms import ScaledTranslation

    if dofs:
        lifted = ax.transData + ScaledTranslation(0.0, offset_pt / 72.0, ax.figure.dpi_scale_trans)
        ax.plot(
            dofs,
            np.zeros(len(dofs)),
            ls="",
            marker=r"$\rightarrow$",
            ms=size,
            color=colour,
            zorder=4,
            transform=lifted,
            label=name,
        )
