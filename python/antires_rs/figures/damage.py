"""Damage: stiffness loss by element."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..damage.hypotheses import span
from ..exceptions import reject
from ..support.checks import FloatArray, integer
from .canvas import COLOURS, below, fit_across, new_axes, offer, text_width_pt

if TYPE_CHECKING:
    from ..damage.assess import DamageResult
    from ..damage.hypotheses import Assessment, Hypotheses, Hypothesis


# -- What a bar chart of losses shows where hypotheses were judged: intervals, probabilities, alternatives


#: From this probability on an element that was not declared has a bar of its own.
_WORTH_A_BAR = 0.02


def alternatives(found: Assessment, elements: list[int]) -> FloatArray:
    """Losses in % of elements that may be the damaged ones instead, NaN elsewhere."""
    losses = np.full(len(elements), np.nan)
    for one in found.hypotheses:
        if not one.candidate or one.probability < _WORTH_A_BAR:
            continue
        for element, severity in zip(one.elements, one.severities, strict=True):
            at = elements.index(element)
            if element not in found.declared and np.isnan(losses[at]):
                losses[at] = 100.0 * severity
    return losses


def draw_alternatives(ax: Any, x: FloatArray, losses: FloatArray) -> None:
    """Empty bars behind the others."""
    some = np.isfinite(losses)
    if some.any():
        ax.bar(
            x[some],
            losses[some],
            width=0.62,
            facecolor="none",
            edgecolor="black",
            linewidth=0.9,
            linestyle="--",
            label="what else it may be",
        )


def draw_intervals(ax: Any, x: FloatArray, loss: FloatArray, low: FloatArray, high: FloatArray) -> None:
    """90 % intervals of the bars."""
    some = high > 0.0
    if some.any():
        reach = np.maximum([loss[some] - low[some], high[some] - loss[some]], 0.0)
        ax.errorbar(
            x[some],
            loss[some],
            reach,
            fmt="none",
            ecolor="black",
            elinewidth=1.4,
            capsize=5,
            capthick=1.4,
            zorder=4,
            label="90 % interval",
        )


def draw_probabilities(ax: Any, x: FloatArray, probability: FloatArray, upright: bool) -> None:
    """A row of numbers over the axes, from the probable down to what is left out as below 0.5 %."""
    for at, p in zip(x, probability, strict=True):
        shown = _percent(p)
        ax.annotate(
            shown,
            (at, 1.0),
            xycoords=ax.get_xaxis_transform(),
            xytext=(0, 4),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize="x-small" if upright else "small",
            fontweight="bold" if p >= 0.5 else "normal",
            color="black" if p >= 0.005 else "#6E6E6E",
        )
    ax.set_title("Probability that it is damaged (%)", fontsize="small", loc="left", pad=18)


def verdict(result: DamageResult) -> str:
    """Why there is no bar."""
    elsewhere = result.probability_elsewhere
    if not result.assessment.best.candidate:
        return f"something has changed that no candidate explains\n(probability {_percent(elsewhere)} %)"
    changed = _percent(result.probability_of_damage)
    return f"no damage declared\n(probability that anything has changed: {changed} %)"


def _percent(p: float) -> str:
    """In whole percent; what is nearly 0 or 1 is not rounded to it."""
    return "<1" if p < 0.005 else ">99" if p > 0.995 else f"{100 * p:.0f}"


#: The axis shows at least this much: on a finer scale nothing would look like something.
LEAST_PERCENT = 10.0
#: Smallest visible losses above this do not lengthen the axis, or small bars would vanish.
MOST_VISIBLE = 25.0


def plot_damage(result: DamageResult, ax: Any = None, truth: Mapping[int, float] | None = None) -> Any:
    """Draw the stiffness loss of each candidate element in %, with what could have been seen.

    Parameters
    ----------
    result : DamageResult
        From :func:`~antires_rs.assess_damage`.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    truth : mapping of int to float, optional
        True loss by zero-based element, where it is known; drawn as diamonds.

    Returns
    -------
    matplotlib.axes.Axes
        One bar an element. The ticks across are ``result.detectable``: damage below would come out as none; a
        triangle at the upper edge gives those that lie above the axis. A hatched background marks elements
        whose damage no value could show. Against a baseline bars have their 90 % intervals, the row above
        them is the probability of each element, and empty bars are losses of elements that may be the damaged
        ones instead.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.
    InvalidInputError
        A truth that is no mapping.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from matplotlib.figure import Figure
    >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 500.0])
    >>> measured = ar.AntiresonanceSet(0, {0: [1.9, 5.2], 1: [3.1]})
    >>> ax = ar.assess_damage(intact, measured, rng=0).plot(ax=Figure().subplots())
    >>> ax.get_ylabel()
    'Stiffness loss (%)'
    """
    if truth is not None and not isinstance(truth, Mapping):
        reject("truth", truth, "a mapping of zero-based element to loss, such as {4: 0.55}", "Pass a dict.")
    severity = 100.0 * np.asarray(result.x)
    names = element_names(result)
    ax = new_axes(ax, (max(6.0, 0.32 * len(names) + 1.5), 4.4))
    upright = not fit_across(ax, names)
    x = np.arange(len(names), dtype=np.float64)
    more = _judged(result) if result.has_baseline else {}
    nowhere = np.full(len(names), np.nan)
    high, instead = more.get("high_percent", nowhere), more.get("instead_percent", nowhere)
    draw_alternatives(ax, x, instead)
    ax.bar(x, severity, width=0.62, color=COLOURS["blue"], edgecolor="black", linewidth=0.6, label="found")
    visible = 100.0 * np.array([result.detectable[e] for e in result.elements])
    known = 100.0 * np.array([(truth or {}).get(e, np.nan) for e in result.elements])
    shown = (severity, known, high, instead, np.minimum(visible, MOST_VISIBLE))
    percent_axis(ax, np.concatenate(shown), upright)
    _smallest_seen(ax, x, visible)
    if truth is not None:
        mark_truth(ax, x, known, 8)
    if more:
        draw_intervals(ax, x, severity, more["low_percent"], high)
        draw_probabilities(ax, x, more["probability"], upright)
    _numbers(ax, severity, (severity, known, visible, high), known, upright)
    if not severity.any():
        if more:
            ax.text(0.5, 0.6, verdict(result), transform=ax.transAxes, ha="center", fontsize="medium")
        else:
            ax.set_title("no damage found", fontsize="medium")
    element_axis(ax, names, upright, first=("found", "90 % interval", "truth"))
    offer(
        ax,
        bars={
            "element": result.elements,
            "name": names,
            "loss_percent": severity,
            **({} if truth is None else {"truth_percent": known}),
            **more,
            "smallest_seen_percent": visible,
        },
    )
    return ax


def _judged(result: DamageResult) -> dict[str, FloatArray]:
    """Columns beside the losses: 90 % intervals, probabilities, losses of what may be damaged instead."""
    low, high = 100.0 * np.array(list(result.interval.values())).T
    return {
        "low_percent": low,
        "high_percent": high,
        "probability": np.array(list(result.probability.values())),
        "instead_percent": alternatives(result.assessment, result.elements),
    }


def _numbers(
    ax: Any, severity: FloatArray, marks: tuple[FloatArray, ...], known: FloatArray, upright: bool
) -> None:
    """Losses over their bars, and over marks close above, which would strike them out."""
    for i, value in enumerate(severity):
        if value > 0.0:
            reach = value + 0.12 * ax.get_ylim()[1]
            over = max(mark[i] for mark in marks if value <= mark[i] <= reach)
            diamond = abs(over - known[i]) < 0.05 * ax.get_ylim()[1]
            ax.annotate(
                f"{value:.1f} %",
                (i, over),
                xytext=(0, 8 if diamond else 3),
                ha="center",
                va="bottom",
                textcoords="offset points",
                fontsize="small",
                rotation=90 if upright else 0,
            )


def _smallest_seen(ax: Any, x: FloatArray, visible: FloatArray) -> None:
    """Ticks across at the smallest losses seen; what lies above the axis, or nowhere, is said so."""
    top = ax.get_ylim()[1]
    look = {"color": COLOURS["vermillion"], "zorder": 3}
    on = visible <= 0.98 * top
    above = np.isfinite(visible) & ~on
    # The white edge keeps a tick apart from the bar behind it, in grey as well.
    ax.hlines(visible[on], x[on] - 0.42, x[on] + 0.42, color="white", lw=3.0, zorder=2.9)
    ax.hlines(
        visible[on],
        x[on] - 0.42,
        x[on] + 0.42,
        lw=1.5,
        ls=(0, (3, 1)),
        clip_on=False,
        label="smallest damage that would be seen",
        **look,
    )
    if above.any():
        ax.plot(
            x[above],
            np.full(int(above.sum()), 0.975),
            ls="",
            marker="^",
            ms=5.5,
            mew=0.0,
            transform=ax.get_xaxis_transform(),
            label="seen only from this loss on, in %",
            **look,
        )
        for at, value in zip(x[above], visible[above], strict=True):
            ax.annotate(
                f"{value:.0f}",
                (at, 0.975),
                xycoords=ax.get_xaxis_transform(),
                xytext=(0, -5),
                textcoords="offset points",
                ha="center",
                va="top",
                fontsize="x-small",
            )
    for number, i in enumerate(x[~np.isfinite(visible)]):
        ax.axvspan(
            i - 0.5,
            i + 0.5,
            facecolor="none",
            edgecolor="#BFBFBF",
            hatch="...",
            lw=0.0,
            zorder=0,
            label="no damage could be seen" if number == 0 else None,
        )


def element_names(result: DamageResult) -> list[str]:
    """What the candidate elements are called."""
    label = result.problem.model.element_label
    return [", ".join(label(term) for term in p.terms) for p in result.problem.parameters]


def percent_axis(ax: Any, shown: FloatArray, upright: bool) -> None:
    """Scale of the losses, with room for the numbers over the bars; there is none above 100 %."""
    room = 1.36 if upright else 1.16
    top = max(LEAST_PERCENT, room * np.nanmax(shown[np.isfinite(shown)], initial=0.0))
    ax.set_ylim(0.0, top)
    if top > 100.0:
        ax.set_yticks(range(0, 101, 20))
    ax.set_ylabel("Stiffness loss (%)")
    ax.grid(axis="y", alpha=0.25)
    ax.set_axisbelow(True)


def mark_truth(ax: Any, x: Any, known: FloatArray, size: float) -> None:
    """Known losses as diamonds that leave the bars visible."""
    look = {"marker": "D", "mfc": "none", "mec": "black", "mew": 1.3, "clip_on": False}
    ax.plot(x, known, ls="", ms=size, label="truth", zorder=4, **look)


def element_axis(ax: Any, names: list[str], upright: bool, first: tuple[str, ...]) -> None:
    """Names of the elements across, and the legend below them."""
    ax.set_xticks(range(len(names)), names, rotation=90 if upright else 0)
    ax.tick_params(axis="x", pad=7)  # clear of diamonds at 0
    spare = max(0.6, 0.5 * (4 - len(names)))  # one or two bars are bars, not blocks
    ax.set_xlim(-spare, len(names) - 1 + spare)
    ax.set_xlabel("Candidate element (no bar: exactly 0)")
    length = text_width_pt(max(names, key=len), 10.0)
    below(ax, drop_pt=34.0 + length if upright else 44.0, first=first)


# -- Damage as several measurements see it, side by side


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
    >>> from antires_rs.figures import plot_damages
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


# -- Hypotheses: bars of their probabilities


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
    >>> from antires_rs.figures import plot_hypotheses
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
