"""How a search went: best objective of each island."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .canvas import COLOURS, DASHES, below, columns, hover, paper

if TYPE_CHECKING:
    from ..updating.results import UpdateResult

__all__ = ["convergence_figure"]

#: Points that a curve is drawn with at most.
MOST_POINTS = 1500


def convergence_figure(result: UpdateResult) -> Any:
    """Best J of each island against the evaluations of all.

    Parameters
    ----------
    result : UpdateResult or DamageResult
        Of a search: one against a baseline has none.

    Returns
    -------
    bokeh.plotting.figure
    """
    history = result.history
    cost, nfev = np.asarray(history.cost), np.asarray(history.nfev, dtype=np.float64)
    kept = np.unique(np.linspace(0, len(nfev) - 1, min(len(nfev), MOST_POINTS)).round().astype(int))
    log = bool(np.isfinite(cost).all() and cost.min() > 0.0 and cost.max() > 3.0 * cost.min())
    fig = paper(
        "Evaluations of all islands (-)", "Best objective J (-)", height=340, y_log=log, name="convergence"
    )
    fig.xaxis.formatter.use_scientific = False
    colours = list(COLOURS.values())
    table = columns(nfev=nfev[kept], **{f"island_{i}": cost[kept, i] for i in range(cost.shape[1])})
    for i in range(cost.shape[1]):
        line = fig.step(
            "nfev",
            f"island_{i}",
            source=table,
            mode="after",
            color=colours[i % len(colours)],
            line_dash=DASHES[i % len(DASHES)],
            line_width=max(3.0 - 0.5 * i, 1.2),
            legend_label=f"island {i}",
        )
        says = {"": f"island {i}", "Evaluations": "@nfev{0,0}", "J": f"@island_{i}{{0.000000e+0}}"}
        hover(fig, [line], says)
    at = nfev[np.minimum(np.asarray(history.migrations, dtype=np.int64), len(nfev) - 1)]
    if at.size:
        table = columns(nfev=at, y=np.full(at.size, cost.min() if log else cost.min()))
        fig.scatter(
            "nfev",
            "y",
            source=table,
            marker="dash",
            angle=np.pi / 2,
            size=10,
            color="black",
            legend_label=f"exchange ({at.size} in all)",
        )
    below(fig)
    return fig
