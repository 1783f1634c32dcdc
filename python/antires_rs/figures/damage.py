"""Damage: stiffness loss by element, and the probabilities of what may explain a measurement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from ..damage.hypotheses import loss, percent, span
from ..exceptions import reject
from ..support.checks import FloatArray, integer
from .canvas import draw, fit_across, new_axes
from .marks import Axis, Bands, Bars, Heads, Mark, Panel, Paths, Points, Words

if TYPE_CHECKING:
    from ..damage.assess import DamageResult
    from ..damage.hypotheses import Assessment, Hypotheses, Hypothesis

__all__ = ["plot_damage", "plot_hypotheses"]

_WORTH_A_BAR = 0.02  # from this probability on an element that was not declared has a bar of its own
LEAST_PERCENT = 10.0  # the axis shows at least this much: on a finer scale nothing would look like something
MOST_VISIBLE = 25.0  # smallest visible losses above this do not lengthen the axis, or small bars would vanish


def plot_damage(result: DamageResult, ax: Any = None, truth: Mapping[int, float] | None = None) -> Any:
    """Draw the stiffness loss of each candidate element in %, with what could have been seen.

    The ticks across are ``result.detectable``; a triangle at the upper edge gives those above the axis, and a
    hatched background marks elements whose damage no value could show. Against a baseline bars have their
    90 % intervals, probabilities stand above, and empty bars are elements that may be damaged instead.

    Parameters
    ----------
    truth : mapping of int to float, optional
        True loss by zero-based element, where it is known; drawn as diamonds.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> ar.assess_damage(case.model, case.exact(1), rng=0).plot(truth={4: 0.55}).get_ylabel()
    'Stiffness loss (%)'
    """
    if truth is not None and not isinstance(truth, Mapping):
        reject("truth", truth, "a mapping of zero-based element to loss, such as {4: 0.55}", "Pass a dict.")
    names = element_names(result)
    ax = new_axes(ax, (max(6.0, 0.32 * len(names) + 1.5), 4.4))
    draw(losses(result, truth, not fit_across(ax, names)), ax)
    if result.has_baseline:
        ax.set_title("Probability that it is damaged (%)", fontsize="small", loc="left", pad=18)
        if not result.damaged:  # why there is no bar
            elsewhere = _percent(result.probability_elsewhere)
            why = f"something has changed that no candidate explains\n(probability {elsewhere} %)"
            if result.assessment.best.candidate:
                changed = _percent(result.probability_of_damage)
                why = f"no damage declared\n(probability that anything has changed: {changed} %)"
            ax.text(0.5, 0.6, why, transform=ax.transAxes, ha="center", fontsize="medium")
    return ax


def losses(result: DamageResult, truth: Mapping[int, float] | None, upright: bool) -> Panel:
    """Bars of the losses found, with all that is known of each element; names ``upright`` where many."""
    names, x = element_names(result), np.arange(len(result.x), dtype=np.float64)
    found, visible = 100.0 * np.asarray(result.x), 100.0 * np.array(list(result.detectable.values()))
    truths = 100.0 * np.array([(truth or {}).get(e, np.nan) for e in result.elements])
    low = high = instead = np.full(x.size, np.nan)
    judged = result.has_baseline
    if judged:
        low, high = 100.0 * np.array(list(result.interval.values())).T
        instead = _alternatives(result.assessment, result.elements)
    axis = _percent_axis([found, truths, high, instead, np.minimum(visible, MOST_VISIBLE)], upright)
    top = axis.limits[1] if axis.limits else 100.0
    says = {"Element": "@name", "Stiffness loss": "@loss{0.0} %"}
    more = {"name": names, "loss": found, "truth": truths}
    more["seen"] = [f"{value:.1f} %" if np.isfinite(value) else "none would be seen" for value in visible]
    if judged:
        says |= {"90 % interval": "@interval", "Probability": "@probability"}
        more["interval"] = [f"{span(a, b)} %" if b > 0.0 else "-" for a, b in result.interval.values()]
        more["probability"] = [percent(p) for p in result.probability.values()]
    says |= {"Smallest that would be seen": "@seen"} | ({"Truth": "@truth{0.0} %"} if truth else {})
    whole = np.full(x.size, top)  # what a page hovers over
    marks: list[Mark] = [Bars(x, whole, 1.0, "none", None, only="page", says=says, more=more)]
    if (some := np.isfinite(instead)).any():
        marks.append(Bars(x[some], instead[some], face="none", dash="--", label="what else it may be"))
    marks += [Bars(x, found, label="found"), *_smallest_seen(x, visible, top)]
    if (some := high > 0.0).any():
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        marks.append(Points(x[some], middle[some], "", error=half[some], label="90 % interval"))
    if truth is not None:
        look: dict[str, Any] = {"face": "none", "stroke": 1.3, "spill": True}  # bars stay visible
        marks.append(Points(x, truths, "D", 8.0, label="truth", **look))
    if judged:
        chance = list(result.probability.values())
        marks.append(Heads(x, list(map(_percent, chance)), [p >= 0.5 for p in chance], only="picture"))
    for i in np.flatnonzero(found > 0.0):
        # Over the bar, and over marks close above, which would strike the number out.
        close = (found[i], truths[i], visible[i], high[i])
        over = max(level for level in close if found[i] <= level <= found[i] + 0.12 * top)
        away = 8.0 if abs(over - truths[i]) < 0.05 * top else 3.0  # over a diamond
        marks.append(Words([i], [over], [f"{found[i]:.1f} %"], away=away, turned=upright, only="picture"))
    title = "" if found.any() or judged else "no loss found"
    first = ("found", "90 % interval", "truth")
    return Panel("damage", _element_axis(names, upright), axis, marks, title=title, grid="y", first=first)


def _alternatives(found: Assessment, elements: list[int]) -> FloatArray:
    """Losses in % of elements that may be the damaged ones instead, NaN elsewhere."""
    losses = np.full(len(elements), np.nan)
    likely = [one for one in found.hypotheses if one.candidate and one.probability >= _WORTH_A_BAR]
    for one in reversed(likely):  # the likeliest last, which counts
        for element, severity in zip(one.elements, one.severities, strict=True):
            if element not in found.declared:
                losses[elements.index(element)] = 100.0 * severity
    return losses


def _percent(p: float) -> str:
    """In whole percent; what is nearly 0 or 1 is not rounded to it."""
    return "<1" if p < 0.005 else ">99" if p > 0.995 else f"{100 * p:.0f}"


def _smallest_seen(x: FloatArray, visible: FloatArray, top: float) -> list[Mark]:
    """Ticks across at the smallest losses seen; what lies above the axis, or nowhere, is said so."""
    on = visible <= 0.98 * top
    above, nowhere = np.isfinite(visible) & ~on, x[~np.isfinite(visible)]
    marks: list[Mark] = []
    if nowhere.size:
        marks.append(Bands(nowhere - 0.5, nowhere + 0.5, hatch="...", label="no damage could be seen"))
    if on.any():
        ticks = [np.array([(at - 0.42, y), (at + 0.42, y)]) for at, y in zip(x[on], visible[on], strict=True)]
        label = "smallest damage that would be seen"
        marks.append(Paths(ticks, "vermillion", dash=(3, 1), width=1.5, label=label))
    if above.any():
        edge = np.full(int(above.sum()), 0.975 * top)
        label = "seen only from this loss on, in %"
        marks.append(Points(x[above], edge, "^", 5.5, "vermillion", stroke=0.0, label=label))
        marks.append(Words(x[above], edge, [f"{value:.0f}" for value in visible[above]], "below", 5.0, 6.94))
    return marks


def element_names(result: DamageResult) -> list[str]:
    """What the candidate elements are called."""
    label = result.problem.model.element_label
    return [", ".join(label(term) for term in p.terms) for p in result.problem.parameters]


def _percent_axis(shown: Sequence[FloatArray], upright: bool) -> Axis:
    """Scale of the losses, with room for the numbers over the bars; there is none above 100 %."""
    losses = np.concatenate(shown)
    highest = float(np.max(losses[np.isfinite(losses)], initial=0.0))
    top = max(LEAST_PERCENT, (1.36 if upright else 1.16) * highest)
    return Axis("Stiffness loss (%)", (0.0, top), at=range(0, 101, 20) if top > 100.0 else None)


def _element_axis(names: list[str], upright: bool) -> Axis:
    spare = max(0.6, 0.5 * (4 - len(names)))  # one or two bars are bars, not blocks
    label = "Candidate element (no bar: exactly 0)"
    return Axis(label, (-spare, len(names) - 1 + spare), names=names, upright=upright)


# -- Hypotheses: bars of their probabilities

_LEAST_ROWS, WORTH_A_ROW, MOST_ROWS = 3, 0.005, 12  # bars in any case, those above this probability, most


def worth_a_row(hypotheses: Hypotheses, most: int = MOST_ROWS) -> list[Hypothesis]:
    """Those that have a bar, or a row of a table, of their own."""
    few, rest = hypotheses[: min(most, _LEAST_ROWS)], hypotheses[_LEAST_ROWS:most]
    return [*few, *(one for one in rest if one.probability >= WORTH_A_ROW)]


def plot_hypotheses(hypotheses: Hypotheses, ax: Any = None, most: int = 8) -> Any:
    """Draw the probabilities of hypotheses of damage, the most probable on top.

    Each with its stiffness losses and their 90 % intervals, in %, under its name. Blue bars are damage of
    candidates, white ones no damage, hatched ones what none of them explains.

    Parameters
    ----------
    most : int
        Bars at most, from 1 on: the first three hypotheses, and those above 0.005. The others share one.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> ar.assess_damage(case.model, case.exact(1), baseline=case.exact(0)).hypotheses.plot().get_xlabel()
    'Probability'
    """
    integer("most", most, low=1)
    panel = probabilities(hypotheses, most)
    ax = draw(panel, new_axes(ax, (8.0, 1.3 + 0.5 * len(panel.y.names or ()))))
    ax.tick_params(axis="y", labelsize="small")
    ax.spines[["top", "right"]].set_visible(False)
    return ax


def probabilities(hypotheses: Hypotheses, most: int = MOST_ROWS) -> Panel:
    """One bar a hypothesis, the most probable on top, and one for the others."""
    rows = worth_a_row(hypotheses, most)
    names, values = [hypotheses.called(one) for one in rows], [one.probability for one in rows]
    losses = [[*zip(one.severities, one.low, one.high, strict=True)] for one in rows]
    said = [", ".join(loss(*each, " %") for each in of) or "-" for of in losses]
    under = [", ".join(f"{100 * s:.1f} % ({span(low, high)})" for s, low, high in of) for of in losses]
    # Names of cracks with their places would leave no room for the bars.
    labels = ["\n".join(wrap(name, 48) + wrap(text, 48)) for name, text in zip(names, under, strict=True)]
    looks: list[dict[str, Any]] = [  # Damage of candidates, no damage, what none of them explains.
        {"face": "blue" if one.elements else "white"} if one.candidate else {"face": "white", "hatch": "////"}
        for one in rows
    ]
    others = len(hypotheses) - len(rows)
    if others:
        names.append(f"{others} other{'s' if others > 1 else ''} together")
        labels.append(names[-1])
        values.append(float(np.sum(hypotheses.probability[len(rows) :])))
        looks.append({"face": "pale"})
        said.append("-")
    says = {"Explanation": "@name", "Probability": "@percent", "Stiffness loss (90 %)": "@losses"}
    marks: list[Mark] = []
    for i, (p, look, name, text) in enumerate(zip(values, looks, names, said, strict=True)):
        more = {"name": [name], "percent": [percent(p)], "losses": [text]}
        marks.append(Bars([i], [p], sideways=True, says=says, more=more, **look))
    shown = ["< 0.001" if p < 0.0005 else "> 0.999" if p > 0.9995 else f"{p:.3f}" for p in values]
    marks.append(Words(values, range(len(values)), shown, "right", 5.0))
    x = Axis("Probability", (0.0, 1.12), at=np.linspace(0.0, 1.0, 6))
    return Panel("hypotheses", x, Axis("", (len(names) - 0.4, -0.6), names=labels), marks, grid="x")
