"""Hypotheses: bars of their probabilities."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..damage.percent import span
from ..support.validation import integer
from .canvas import COLOURS, new_axes, offer

if TYPE_CHECKING:
    from ..damage.hypotheses import Hypotheses, Hypothesis

__all__ = ["plot_hypotheses"]

#: Hypotheses that have a bar in any case, and those above this probability.
_LEAST_ROWS, _WORTH_A_ROW = 3, 0.005


def plot_hypotheses(hypotheses: Hypotheses, ax: Any = None, most: int = 8) -> Any:
    """Draw the probabilities of hypotheses of damage, the most probable on top.

    Parameters
    ----------
    hypotheses : Hypotheses
        ``result.hypotheses`` of :func:`~antires_rs.assess_damage`.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    most : int
        Hypotheses with a bar of their own at most: the first three, and those above 0.005. The others share
        one.

    Returns
    -------
    matplotlib.axes.Axes
        One bar a hypothesis, with its stiffness losses and their 90 % intervals, each in %, under its name.
        Blue bars are damage of candidates, white ones no damage, hatched ones what none of them explains.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.
    InvalidInputError
        ``most`` below 1.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from matplotlib.figure import Figure
    >>> from antires_rs.plotting import plot_hypotheses
    >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 500.0, 500.0])
    >>> damaged = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 300.0, 500.0])
    >>> before, now = (ar.AntiresonanceSet(0, dict(enumerate(m.antiresonances([0, 1, 2, 3], 0))))
    ...                for m in (intact, damaged))
    >>> ax = plot_hypotheses(ar.assess_damage(intact, now, baseline=before).hypotheses, Figure().subplots())
    >>> ax.get_xlabel()
    'Probability'
    """
    integer("most", most, low=1)
    rows = [
        one
        for nth, one in enumerate(hypotheses[:most])
        if nth < _LEAST_ROWS or one.probability >= _WORTH_A_ROW
    ]
    names = [hypotheses.called(one) for one in rows]
    labels = [_label(name, one) for name, one in zip(names, rows, strict=True)]
    probability = [one.probability for one in rows]
    looks = [_look(one) for one in rows]
    others = len(hypotheses) - len(rows)
    if others:
        label = f"{others} other{'s' if others > 1 else ''} together"
        names.append(label)
        labels.append(label)
        probability.append(float(np.sum(hypotheses.probability[len(rows) :])))
        looks.append({"color": "#BFBFBF"})
    ax = new_axes(ax, (8.0, 1.3 + 0.5 * len(names)))
    y = np.arange(len(names))
    for at, p, look in zip(y, probability, looks, strict=True):
        ax.barh(at, p, height=0.62, edgecolor="black", linewidth=0.8, **look)
        ax.annotate(
            _number(p), (p, at), xytext=(5, 0), textcoords="offset points", va="center", fontsize="small"
        )
    ax.set_yticks(y, labels, fontsize="small")
    ax.set_ylim(len(names) - 0.4, -0.6)
    ax.set_xlim(0.0, 1.12)
    ax.set_xticks(np.linspace(0.0, 1.0, 6))
    ax.set_xlabel("Probability")
    ax.grid(axis="x", alpha=0.25)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)
    offer(ax, hypotheses={"name": names, "probability": probability})
    return ax


def _look(one: Hypothesis) -> dict[str, Any]:
    if not one.candidate:
        return {"color": "white", "hatch": "////"}
    return {"color": COLOURS["blue"] if one.elements else "white"}


def _label(name: str, one: Hypothesis) -> str:
    losses = ", ".join(
        f"{100 * s:.1f} % ({span(low, high)})"
        for s, low, high in zip(one.severities, one.low, one.high, strict=True)
    )
    return f"{name}\n{losses}" if losses else name


def _number(p: float) -> str:
    return "< 0.001" if p < 0.0005 else "> 0.999" if p > 0.9995 else f"{p:.3f}"
