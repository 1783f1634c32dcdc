"""Differences of antiresonances, or of resonances with their MAC, before and after updating; its search."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from .canvas import draw, new_axes, plain_log, text_width_pt, width_pt
from .marks import Axis, Bars, Heads, Line, Mark, Panel, Points, Rules, turn

if TYPE_CHECKING:
    from ..optimize.island_ga import OptimizeResult
    from ..support.checks import FloatArray
    from ..updating.identifiability import BoxIdentifiability
    from ..updating.result import UpdateResult
    from ..updating.targets import FrequencyTable, ModalTable

__all__ = ["plot_convergence", "plot_differences", "plot_identifiability"]

MOST_LABELS = 64  # above this many antiresonances their frequencies no longer fit under the bars
GAP = 0.8  # space between two responses, in widths of an antiresonance
LEAST_WIDTH = 8.0  # a picture has room for so many at least: a single bar is a bar, not a block
PALE_VERMILLION = "#F2B48A"  # vermillion, pale


def plot_differences(
    table: FrequencyTable | ModalTable,
    ax: Any = None,
    names: tuple[str, str] = ("before updating", "after updating"),
) -> Any:
    """Draw the difference of each frequency to the measured one in %, before and after.

    Bars grouped by response and force, in the order of the table; a cross where the model has no partner.
    Of modes, one group for those measured together, with the MAC before and after above each. ``names`` are
    those of the two states in the legend.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> columns = [0, 0], [0, 0], [10.0, 20.0], [10.4, 19.0], [10.01, 20.0]
    >>> ar.figures.plot_differences(ar.FrequencyTable(*map(np.array, columns))).get_ylabel()
    'Difference to the measurement (%)'
    """
    ax = new_axes(ax, (9.5, 4.6))
    panel = differences(table, names, width_pt(ax))
    draw(panel, ax, drop_pt=32.0 if panel.x.names is None else 56.0)
    ax.tick_params(axis="x", labelsize="x-small")
    return ax


def differences(table: Any, names: tuple[str, str], wide_pt: float | None = None) -> Panel:
    """Bars before and after, of a picture ``wide_pt`` points wide or of a page, where hovering tells more."""
    modal = hasattr(table, "before_mac")
    count = table.measured_hz.size
    starts, named, of, across = (_modes if modal else _responses)(table)
    x = np.arange(count) + GAP * (np.cumsum(starts) - 1)
    labelled = count <= MOST_LABELS and wide_pt is not None
    most = max(x[-1] - x[0] + 1.0 + GAP, LEAST_WIDTH) if count else 1.0
    if wide_pt is None:
        across = f"{'Resonances, by test' if modal else 'Antiresonances, by response'}, ascending"
    elif not labelled:
        across = across.replace(" (Hz)", "s, ascending")
    both = np.concatenate([table.before_percent, table.after_percent])
    both = both[np.isfinite(both)]
    low, high = float(both.min(initial=0.0)), float(both.max(initial=0.0))
    room = 0.08 * max(high - low, 1e-6)
    limits = (low - room * (low < -0.1 * room), high + room)
    # Before is hatched, or pale where bars are thin, and after is dark: told apart in grey too.
    hatched = {"face": "white", "hatch": "/////", "edge": "vermillion"}
    pale = {"face": PALE_VERMILLION, "edge": PALE_VERMILLION}
    looks = (hatched if count <= MOST_LABELS else pale, {"face": "blue", "edge": "blue"})
    marks: list[Mark] = []
    for state, name, look, off in zip(("before", "after"), names, looks, (-0.2, 0.2), strict=True):
        marks += _bars(table, state, name, look, x + off, of)
    first = [str(mark.label) for mark in marks if isinstance(mark, Bars)]
    firsts = np.flatnonzero(starts)
    marks += [Rules(0.0), Rules(x[firsts[1:]] - 0.5 - GAP / 2, upright=True, colour="pale", width=0.7)]
    if wide_pt is not None:
        free, kept = -np.inf, []  # A name that would run into the one before it is left out.
        for begin, end, text in named:
            centre, half = x[begin:end].mean(), 0.5 * most * (text_width_pt(text) + 2.0) / wide_pt
            if centre - half >= free:
                free = centre + half
                kept.append((centre, text))
        marks.append(Heads([centre for centre, _ in kept], [text for _, text in kept]))
    elif not modal:
        marks.append(Heads(x[firsts] - 0.3, [of[first] for first in firsts]))
    middle = 0.5 * (x[0] + x[-1]) if count else 0.5
    ticks = [f"{f:.1f}" for f in table.measured_hz] if labelled else None
    wide = (middle - most / 2, middle + most / 2)
    x_axis = Axis(across, wide, names=ticks, at=x if labelled else [], upright=labelled)
    y_axis = Axis("Difference to the measurement (%)", limits)
    return Panel("differences", x_axis, y_axis, marks, grid="y", first=first)


def _bars(
    table: Any, state: str, name: str, look: dict[str, Any], x: FloatArray, of: list[str]
) -> list[Mark]:
    """Bars of one state, and crosses where there is no partner."""
    percent = np.asarray(getattr(table, f"{state}_percent"))
    found, colour = np.isfinite(percent), look["edge"] if look["face"] != PALE_VERMILLION else "vermillion"
    says = {"": name, "Of": "@of", "Measured": "@measured{0.000} Hz", "Model": "@model{0.000} Hz"}
    says |= {"Difference": "@difference{+0.00} %"}
    more = {"of": np.array(of, dtype=object), "measured": table.measured_hz, "difference": percent}
    more["model"] = getattr(table, f"{state}_hz")
    if hasattr(table, "before_mac"):
        says |= {"MAC": "@mac{0.000}"}
        more["mac"] = getattr(table, f"{state}_mac")

    def hovered(which: Any) -> dict[str, Any]:
        return {"says": says, "more": {column: np.asarray(values)[which] for column, values in more.items()}}

    largest = f"largest {np.abs(percent[found]).max():.2f} %" if found.any() else "no partner at all"
    label = f"{name}, {largest}"
    marks: list[Mark] = [Bars(x[found], percent[found], 0.4, label=label, **look, **hovered(found))]
    if not found.all():
        zero = np.zeros(int(np.sum(~found)))
        cross: dict[str, Any] = {"label": f"{name}: no partner ({zero.size})", "stroke": 1.6, "spill": True}
        marks.append(Points(x[~found], zero, "x", 6.0, colour, **cross, **hovered(~found)))
    return marks


def _responses(table: Any) -> tuple[Any, list[tuple[int, int, str]], list[str], str]:
    """Where a group begins, (first, end, short name) of each, what each value is of, and the axis' label."""
    dof, force, names = np.asarray(table.dof), np.asarray(table.excitation), table.dof_names
    several = len(set(force.tolist())) > 1
    starts = np.r_[True, (dof[1:] != dof[:-1]) | (force[1:] != force[:-1])][: dof.size]
    # "mass" or "dof" once: beside it there is no room over a response with a single antiresonance.
    masses = bool(names) and all(str(each).startswith("mass ") for each in names.values())
    title = "mass " if masses else "" if names else "dof "
    pairs = list(zip(dof.tolist(), force.tolist(), strict=True))
    ends, named = [*np.flatnonzero(starts).tolist(), dof.size], []
    for first, end in pairwise(ends):
        short = [table.named(which).replace("mass ", "") for which in pairs[first]]
        named.append((first, end, ", ".join(short) if several else f"{title * (first == 0)}{short[0]}"))
    whole = [[table.named(which, "dof {}") for which in pair] for pair in pairs]
    of = [f"{p}, force at {k}" if several else p for p, k in whole]
    groups = "response and force dof" if several else "response dof"
    return starts, named, of, f"Measured antiresonance (Hz), by {groups} (above)"


def _modes(table: Any) -> tuple[Any, list[tuple[int, int, str]], list[str], str]:
    """The same of modes, whose MAC stands above each."""
    mode = np.asarray(table.mode)
    starts, of = np.r_[True, mode[1:] <= mode[:-1]][: mode.size], [f"mode {each}" for each in mode]
    if mode.size > MOST_LABELS // 4:
        return starts, [], of, "Measured resonance (Hz)"
    pairs = zip(table.before_mac, table.after_mac, strict=True)
    named = [(r, r + 1, f"{before:.3f} \u2192\n{after:.3f}") for r, (before, after) in enumerate(pairs)]
    return starts, named, of, "Measured resonance (Hz); above: MAC before and after"


# -- How a search went: best cost of each island

MOST_POINTS = 1500  # points that a curve is drawn with at most


def plot_convergence(result: UpdateResult | OptimizeResult, ax: Any = None) -> Any:
    """Draw the best J of each island against the evaluations of all, with the migrations.

    A result against a baseline, which has no search, is refused.

    Examples
    --------
    >>> import antires_rs as ar
    >>> found = ar.IslandGA(max_evaluations=2000).minimize(lambda x: x @ x + 1.0, [(-1, 1)] * 2, rng=0)
    >>> ar.figures.plot_convergence(found).get_xlabel()
    'Evaluations of all islands (-)'
    """
    if not np.size(result.history.cost):
        got = "one that was judged against a baseline, without a search"
        reject("result", got, "the result of a search", "See result.hypotheses.plot() instead.")
    panel = convergence(result)
    ax = draw(panel, new_axes(ax, (9.0, 4.4)))
    if panel.y.log and np.min(result.history.cost) > 1e-4:
        plain_log(ax.yaxis)
    ax.xaxis.set_major_formatter("{x:,.0f}")
    ax.set_title(f"{result.status}: {result.message}", fontsize="small")
    return ax


def convergence(result: UpdateResult | OptimizeResult) -> Panel:
    """Best J of each island, and where they exchanged their best."""
    history = result.history
    cost, nfev = np.asarray(history.cost), np.asarray(history.nfev)
    kept = np.unique(np.linspace(0, len(nfev) - 1, min(len(nfev), MOST_POINTS)).round().astype(int))
    log = bool(np.isfinite(cost).all() and cost.min() > 0.0 and cost.max() > 3.0 * cost.min())
    says = {"Evaluations": "@x{0,0}", "J": "@y{0.000000e+0}"}
    marks: list[Mark] = []  # Different widths keep islands apart that run on top of each other.
    for i, column in enumerate(cost.T):
        look = turn(i) | {"width": max(2.6 - 0.5 * i, 1.0), "steps": True, "label": f"island {i}"}
        marks.append(Line(nfev[kept], column[kept], says={"": f"island {i}"} | says, **look))
    at = nfev[np.minimum(np.asarray(history.migrations, dtype=np.int64), len(nfev) - 1)]
    if at.size:
        foot, label = np.full(at.size, cost[np.isfinite(cost)].min()), f"migration ({at.size} in all)"
        marks.append(Points(at, foot, "|", 9.0, stroke=0.8, label=label))
    ends = np.repeat(nfev[-1:], cost.shape[1])  # The last step has no width: a dot says where it ends.
    marks.append(Points(ends, cost[-1], size=5.0, face="white", spill=True, label="end"))
    x = Axis("Evaluations of all islands (-)", (0.0, 1.03 * max(float(nfev[-1]), 1.0)))
    return Panel("convergence", x, Axis("Best objective J (-)", log=log), marks, grid="both")


# -- What a test leaves open of each parameter, within its bounds

_LONGEST = 48  # names longer than this are cut


def plot_identifiability(found: BoxIdentifiability, ax: Any = None) -> Any:
    """Draw what is left of each parameter's standard deviation after a test, a bar each.

    Bars in %, the first parameter on top: 100 is a test that tells nothing. Beyond the line a
    parameter counts as not told.

    Examples
    --------
    >>> import antires_rs as ar
    >>> found = ar.identifiability(ar.cases.chain8().updating_problem(), points=4, forces=[], sensors=[])
    >>> round(max(bar.get_width() for bar in found.plot().patches))
    100
    """
    left, told = 100.0 * found.left, found.left < found.TOLD
    y = np.arange(left.size)
    marks: list[Mark] = []
    hatched: dict[str, Any] = {"face": "white", "edge": "vermillion", "hatch": "////"}
    for these, label, look in ((told, "told", {"edge": "blue"}), (~told, "not told", hatched)):
        if these.any():
            marks.append(Bars(y[these], left[these], 0.7, sideways=True, label=label, **look))
    cut = [name if len(name) <= _LONGEST else f"{name[: _LONGEST - 1]}\u2026" for name in found.names]
    label = "standard deviation left after the test, % of that within the bounds"
    marks.append(Rules(100.0 * found.TOLD, upright=True, dash="--"))
    x_axis, y_axis = Axis(label, (0.0, 105.0)), Axis("", (left.size - 0.4, -0.6), names=cut)
    panel = Panel("identifiability", x_axis, y_axis, marks, grid="x")
    ax = draw(panel, new_axes(ax, (8.0, max(2.5, 0.9 + 0.24 * left.size))))
    ax.tick_params(axis="y", labelsize="small")
    return ax
