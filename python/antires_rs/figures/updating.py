"""Differences of antiresonances, or of resonances with their MAC, before and after updating."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from .canvas import (
    COLOURS,
    LINES,
    below,
    clip_bars,
    new_axes,
    offer,
    plain_log,
    reach,
    text_width_pt,
    width_pt,
)

if TYPE_CHECKING:
    from ..optimize.island_ga import OptimizeResult
    from ..support.checks import FloatArray
    from ..updating.box_identifiability import BoxIdentifiability
    from ..updating.result import UpdateResult
    from ..updating.tables import FrequencyTable, ModalTable

#: Above this many antiresonances their frequencies no longer fit under the bars.
MOST_LABELS = 64
#: Space between two responses, in widths of an antiresonance.
GAP = 0.8
#: A picture has room for so many at least: a single bar is a bar, not a block.
LEAST_WIDTH = 8.0
#: Vermillion, pale.
PALE = "#F2B48A"
#: What is offered, as far as the table has it.
COLUMNS = (
    "excitation",
    "dof",
    "mode",
    "measured_hz",
    "before_hz",
    "before_percent",
    "before_mac",
    "after_hz",
    "after_percent",
    "after_mac",
)


def plot_differences(
    table: FrequencyTable | ModalTable,
    ax: Any = None,
    names: tuple[str, str] = ("before updating", "after updating"),
) -> Any:
    """Draw the difference of each frequency to the measured one in %, before and after.

    Parameters
    ----------
    table : FrequencyTable or ModalTable
        ``UpdateResult.table``.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.
    names : (str, str), optional
        What the two states of the model are called in the legend.

    Returns
    -------
    matplotlib.axes.Axes
        Bars grouped by response and force, in the order of the table; a cross where the model has no partner.
        Where few values stand apart the axis is made for the others, and theirs are written at its edge.
        Of modes, one group for those measured together, with the MAC before and after above each.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> from antires_rs.figures import plot_differences
    >>> from matplotlib.figure import Figure
    >>> columns = [0, 0], [0, 0], [10.0, 20.0], [10.4, 19.0], [10.01, 20.0]
    >>> table = ar.FrequencyTable(*map(np.array, columns))
    >>> ax = plot_differences(table, ax=Figure().subplots())
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['before updating, largest 5.00 %', 'after updating, largest 0.10 %']
    """
    ax = new_axes(ax, (9.5, 4.6))
    count = table.measured_hz.size
    starts, named, across = (_modes if hasattr(table, "before_mac") else _responses)(table)
    x = np.arange(count) + GAP * (np.cumsum(starts) - 1)
    labelled = count <= MOST_LABELS
    # Before is hatched, or pale where bars are thin, and after is dark: told apart in grey too.
    colour, dark = COLOURS["vermillion"], COLOURS["blue"]
    before = (
        {"facecolor": "white", "hatch": "/////", "edgecolor": colour}
        if labelled
        else {"facecolor": PALE, "edgecolor": PALE}
    )
    leading = (
        _bars(ax, x - 0.2, table.before_percent, names[0], colour, **before),
        _bars(ax, x + 0.2, table.after_percent, names[1], dark, facecolor=dark, edgecolor=dark),
    )
    ax.axhline(0.0, color="black", lw=0.8)
    ax.set_xticks(
        x if labelled else [],
        [f"{f:.1f}" for f in table.measured_hz] if labelled else [],
        rotation=90,
        fontsize="x-small",
    )
    ax.grid(axis="y", alpha=0.25)
    ax.set_axisbelow(True)
    firsts = np.flatnonzero(starts)
    for first in firsts[1:]:
        ax.axvline(x[first] - 0.5 - GAP / 2, color="#BFBFBF", lw=0.7)
    most = max(x[-1] - x[0] + 1.0 + GAP, LEAST_WIDTH) if count else 1.0
    free = -np.inf
    for first, end, name in named:
        # A name that would run into the one before it is left out.
        half = 0.5 * most * (text_width_pt(name) + 2.0) / width_pt(ax)
        if x[first:end].mean() - half < free:
            continue
        free = x[first:end].mean() + half
        ax.annotate(
            name,
            (x[first:end].mean(), 1.0),
            xytext=(0, 4),
            xycoords=ax.get_xaxis_transform(),
            textcoords="offset points",
            ha="center",
            va="bottom",
            fontsize="small",
        )
    if count:
        middle = 0.5 * (x[0] + x[-1])
        ax.set_xlim(middle - most / 2, middle + most / 2)
    ax.set_xlabel(across if labelled else across.replace(" (Hz)", "s, ascending"))
    ax.set_ylabel("Difference to the measurement (%)")
    _limits(ax, x, table)
    below(ax, drop_pt=56.0 if labelled else 32.0, first=leading)
    offer(ax, bars={name: getattr(table, name) for name in COLUMNS if hasattr(table, name)})
    return ax


def _limits(ax: Any, x: FloatArray, table: FrequencyTable | ModalTable) -> None:
    """An axis for the many; bars that go on beyond it have an arrow and their number."""
    both = np.concatenate([table.before_percent, table.after_percent])
    most = reach(both)
    ax.margins(y=0.08)
    if not np.isfinite(most):
        return
    low, high = np.nanmin(both), np.nanmax(both)
    ax.set_ylim(max(1.08 * min(low, 0.0), -most), min(1.08 * max(high, 0.0), most))
    clip_bars(ax, x - 0.2, table.before_percent, most, COLOURS["vermillion"])
    clip_bars(ax, x + 0.2, table.after_percent, most, COLOURS["blue"])


def _responses(table: Any) -> tuple[Any, list[tuple[int, int, str]], str]:
    """Where a group begins, (first, end, name) of each, and the label of the axis."""
    dof, force, names = np.asarray(table.dof), np.asarray(table.excitation), table.dof_names
    several = np.unique(force).size > 1
    starts = np.r_[True, (dof[1:] != dof[:-1]) | (force[1:] != force[:-1])][: dof.size]
    firsts = np.flatnonzero(starts)
    # "mass" or "dof" once: beside it there is no room over a response with a single antiresonance.
    masses = bool(names) and all(str(each).startswith("mass ") for each in names.values())
    title = "mass " if masses else "" if names else "dof "

    def name(which: int) -> str:
        return str(names.get(which, which)).removeprefix("mass ")

    named = [
        (
            first,
            end,
            f"{name(int(dof[first]))}, {name(int(force[first]))}"
            if several
            else f"{title if first == 0 else ''}{name(int(dof[first]))}",
        )
        for first, end in zip(firsts.tolist(), [*firsts[1:].tolist(), dof.size], strict=True)
    ]
    groups = "response and force dof" if several else "response dof"
    return starts, named, f"Measured antiresonance (Hz), by {groups} (above)"


def _modes(table: Any) -> tuple[Any, list[tuple[int, int, str]], str]:
    """The same of modes, whose MAC stands above each."""
    mode = np.asarray(table.mode)
    starts = np.r_[True, mode[1:] <= mode[:-1]][: mode.size]
    if mode.size > MOST_LABELS // 4:
        return starts, [], "Measured resonance (Hz)"
    pairs = zip(table.before_mac, table.after_mac, strict=True)
    named = [(r, r + 1, f"{before:.3f} \u2192\n{after:.3f}") for r, (before, after) in enumerate(pairs)]
    return starts, named, "Measured resonance (Hz); above: MAC before and after"


def _bars(ax: Any, x: FloatArray, percent: FloatArray, name: str, colour: str, **look: Any) -> str:
    """Draw them, and crosses where there is no partner; returns the label of the bars."""
    found = np.isfinite(percent)
    largest = f"largest {np.abs(percent[found]).max():.2f} %" if found.any() else "no partner at all"
    label = f"{name}, {largest}"
    ax.bar(x[found], percent[found], width=0.4, linewidth=0.8, label=label, **look)
    if not found.all():
        lost = int(np.count_nonzero(~found))
        ax.plot(
            x[~found],
            np.zeros(lost),
            ls="",
            marker="x",
            ms=6,
            mew=1.6,
            clip_on=False,
            color=colour,
            label=f"{name}: no partner ({lost})",
            zorder=5,
        )
    return label


# -- How a search went: best cost of each island


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
    >>> from antires_rs.figures import plot_convergence
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


# -- What a test leaves open of each parameter, within its bounds


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
    >>> from antires_rs.figures import plot_identifiability
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
