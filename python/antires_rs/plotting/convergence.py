"""How a search went: best cost of each island."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.validation import reject
from .canvas import COLOURS, LINES, below, new_axes, offer, plain_log

if TYPE_CHECKING:
    from ..optimize.outcome import OptimizeResult
    from ..updating.results import UpdateResult

__all__ = ["plot_convergence"]


def plot_convergence(result: UpdateResult | OptimizeResult, ax: Any = None) -> Any:
    """Draw the best J of each island against the evaluations of all, with the migrations.

    Parameters
    ----------
    result : UpdateResult, DamageResult or OptimizeResult
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.
    InvalidInputError
        A result without a search: one against a baseline.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs.plotting import plot_convergence
    >>> from matplotlib.figure import Figure
    >>> found = ar.IslandGA(max_evaluations=2000).minimize(lambda x: x @ x + 1.0, [(-1, 1)] * 2, rng=0)
    >>> plot_convergence(found, ax=Figure().subplots()).get_xlabel()
    'Evaluations of all islands (-)'
    """
    history = result.history
    cost = np.asarray(history.cost)
    if not cost.size:
        reject(
            "result",
            "one that was judged against a baseline, without a search",
            "the result of a search",
            "See result.hypotheses.plot() instead.",
        )
    ax = new_axes(ax, (9.0, 4.4))
    colours = list(COLOURS.values())
    for island in range(cost.shape[1]):
        # Different widths keep islands apart that run on top of each other.
        ax.step(
            history.nfev,
            cost[:, island],
            where="post",
            color=colours[island % len(colours)],
            ls=LINES[island % len(LINES)],
            lw=max(2.6 - 0.5 * island, 1.0),
            label=f"island {island}",
        )
    migrations = np.asarray(history.migrations, dtype=np.int64)
    at = np.asarray(history.nfev)[np.minimum(migrations, len(history.nfev) - 1)]
    if migrations.size:
        ax.plot(
            at,
            np.full(at.size, 0.02),
            ls="",
            marker="|",
            ms=9,
            mew=0.8,
            color="black",
            transform=ax.get_xaxis_transform(),
            label=f"migration ({at.size} in all)",
            zorder=1,
        )
    # The last step has no width: a dot says where it ends.
    last = np.asarray(history.nfev, dtype=np.float64)[-1:]
    ax.plot(
        np.repeat(last, cost.shape[1]),
        cost[-1],
        ls="",
        marker="o",
        ms=5.0,
        mfc="white",
        mec="black",
        clip_on=False,
        zorder=4,
        label="end",
    )
    if np.isfinite(cost).all() and cost.min() > 0.0 and cost.max() > 3.0 * cost.min():
        ax.set_yscale("log")
        if cost.min() > 1e-4:
            plain_log(ax.yaxis, narrow=cost.max() < 30.0 * cost.min())
    ax.xaxis.set_major_formatter("{x:,.0f}")
    ax.set_xlim(0, 1.03 * max(float(last[0]), 1.0))
    ax.set_title(f"{result.status}: {result.message}", fontsize="small")
    ax.set_xlabel("Evaluations of all islands (-)")
    ax.set_ylabel("Best objective J (-)")
    ax.grid(alpha=0.25)
    below(ax)
    offer(
        ax,
        islands={"evaluations": history.nfev, **{f"island_{i}": column for i, column in enumerate(cost.T)}},
        migrations={"evaluations": at},
    )
    return ax
