"""Differences of two sets of antiresonances, with their errors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from ..support.checks import choice
from .canvas import COLOURS, LINES, below, new_axes, offer

if TYPE_CHECKING:
    from ..measured.compare import Comparison
    from ..measured.track import Tracks

#: Above so many pairs their frequencies do not fit under the axis.
MOST_LABELS = 64


def plot_comparison(compared: Comparison, ax: Any = None) -> Any:
    """Draw the differences in % with 90 % intervals, response by response.

    Parameters
    ----------
    compared : Comparison
        Made by :func:`~antires_rs.compare`.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        Filled: changed at the rate of false alarms of the comparison; open: not.

    Raises
    ------
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs.figures import plot_comparison
    >>> from matplotlib.figure import Figure
    >>> a, b = (ar.AntiresonanceSet(0, {0: f}, std_hz={0: [0.01, 0.01]}) for f in ([8.7, 23.9], [8.6, 23.9]))
    >>> ax = plot_comparison(ar.compare(a, b), ax=Figure().subplots())
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['no change seen', 'changed']
    """
    ax = new_axes(ax, (9.5, 4.2))
    dof = [str(each) for each in compared.dof]
    starts = np.array([i > 0 and dof[i] != dof[i - 1] for i in range(len(dof))], dtype=bool)
    x = np.arange(len(dof)) + 0.8 * np.cumsum(starts)
    interval = 1.645 * np.nan_to_num(compared.std_percent)
    kinds = (
        (~compared.changed, "no change seen", COLOURS["blue"], "white", "o"),
        (compared.changed, "changed", COLOURS["vermillion"], COLOURS["vermillion"], "s"),
    )
    for chosen, name, colour, face, mark in kinds:
        if chosen.any():
            ax.errorbar(
                x[chosen],
                compared.difference_percent[chosen],
                yerr=interval[chosen],
                ls="none",
                marker=mark,
                ms=6,
                color=colour,
                mfc=face,
                elinewidth=1.1,
                capsize=2.5,
                label=name,
            )
    ax.axhline(0.0, color="black", lw=0.8)
    for first in np.flatnonzero(starts):
        ax.axvline(x[first] - 0.9, color="#BFBFBF", lw=0.7)
    labelled = len(dof) <= MOST_LABELS
    for first in np.flatnonzero(np.r_[bool(len(dof)), starts[1:]]):
        name = f"dof {dof[first]}" if first == 0 else dof[first]
        ax.annotate(
            name,
            (x[first], 1.0),
            xytext=(0, 4),
            xycoords=ax.get_xaxis_transform(),
            textcoords="offset points",
            ha="center",
            fontsize="small",
        )
    ax.set_xticks(
        x if labelled else [],
        [f"{f:.1f}" for f in compared.a_hz] if labelled else [],
        rotation=90,
        fontsize="x-small",
    )
    ax.set_xlabel("Antiresonance of a (Hz), by response dof (above)")
    ax.set_ylabel("b less a (%), 90 % intervals")
    ax.grid(axis="y", alpha=0.25)
    below(ax, drop_pt=56.0 if labelled else 32.0)
    names = ("dof", "a_hz", "b_hz", "difference_percent", "std_percent", "changed")
    offer(ax, pairs={name: getattr(compared, name) for name in names})
    return ax


# -- Antiresonances over many tests: how far each has moved, and where one comes, goes or merges


KINDS = ("change", "frequency")
MARKS = ("o", "s", "^", "D", "v", "P", "X")
#: Sign of each kind of event, and what the legend calls it.
SIGNS = {
    "new": ("o", "new"),
    "back": ("s", "back"),
    "lost": ("x", "lost"),
    "merged": ("1", "merged with its neighbour"),
}
#: Texts of conditions longer than this, all together, are turned.
ROOM = 60


def plot_tracks(tracks: Tracks, dof: Any = None, *, kind: str = "change", ax: Any = None) -> Any:
    """Draw the antiresonances of one response over the tests.

    Parameters
    ----------
    tracks : Tracks
        Made by :func:`~antires_rs.track`.
    dof : int or str, optional
        The response; by default the first that has any antiresonance.
    kind : {"change", "frequency"}
        Change since the first test of each in %, or the frequencies in Hz.
    ax : matplotlib.axes.Axes, optional
        Drawn into; a new figure by default.

    Returns
    -------
    matplotlib.axes.Axes
        A line a track with its standard deviations, over numbers as conditions to scale, over texts evenly.

    Raises
    ------
    InvalidInputError
        A dof without antiresonances, or an unknown kind.
    MissingDependencyError
        matplotlib is not installed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from antires_rs.figures import plot_tracks
    >>> from matplotlib.figure import Figure
    >>> tests = [ar.AntiresonanceSet(0, {0: values}) for values in ([8.7, 23.9], [8.6, 23.8])]
    >>> ax = plot_tracks(ar.track(tests), ax=Figure().subplots())
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['8.70 Hz', '23.90 Hz']
    """
    choice("kind", kind, KINDS)
    if dof is None and len(tracks):
        dof = tracks.dof[0]
    some = tracks.of(dof)
    if not some.size:
        known = tuple(dict.fromkeys(tracks.dof.tolist()))
        reject("dof", dof, f"one of {known}", "Name a response that has antiresonances.")
    ax = new_axes(ax, (7.5, 4.5))
    numeric = not any(isinstance(condition, str) for condition in tracks.conditions)
    x = np.array(tracks.conditions if numeric else range(len(tracks.conditions)), dtype=np.float64)
    change = tracks.change_percent
    scale = np.where(np.isnan(change), np.nan, 100.0 / (tracks.freq_hz / (1.0 + change / 100.0)))
    y, std = (change, tracks.std_hz * scale) if kind == "change" else (tracks.freq_hz, tracks.std_hz)
    rank = np.argsort(x, kind="stable")
    colours = list(COLOURS.values())
    names = [f"{tracks.freq_hz[~np.isnan(tracks.freq_hz[:, i]), i][0]:.2f} Hz" for i in some]
    for n, i in enumerate(some):
        ax.errorbar(
            x[rank],
            y[rank, i],
            yerr=np.nan_to_num(std[rank, i]),
            color=colours[n % len(colours)],
            ls=LINES[n % len(LINES)],
            marker=MARKS[n % len(MARKS)],
            ms=4.5,
            lw=1.3,
            elinewidth=0.8,
            label=names[n],
        )
    _draw_events(ax, tracks, set(some.tolist()), x, y)
    if not numeric:
        turned = len("".join(tracks.conditions)) > ROOM
        ax.set_xticks(x, tracks.conditions, rotation=45 if turned else 0, ha="right" if turned else "center")
    counted = tracks.conditions == tuple(range(x.size))
    if counted:
        ax.xaxis.get_major_locator().set_params(integer=True)
    ax.set_xlabel("Test" if counted else "Condition")
    ax.set_ylabel("Change since its first test (%)" if kind == "change" else "Antiresonance (Hz)")
    ax.set_title(f"Response at dof {dof}, force at {tracks.excitation}", fontsize="medium")
    ax.grid(alpha=0.25)
    ax.margins(x=0.04, y=0.08)
    below(ax, drop_pt=62.0 if not numeric and turned else 36.0, first=names)
    long = np.repeat(np.arange(x.size), some.size)
    offer(
        ax,
        tracks={
            "test": long,
            "track": np.tile(some, x.size),
            "freq_hz": tracks.freq_hz[:, some].ravel(),
            "std_hz": tracks.std_hz[:, some].ravel(),
            "change_percent": change[:, some].ravel(),
        },
    )
    return ax


def _draw_events(ax: Any, tracks: Tracks, some: set[int], x: Any, y: Any) -> None:
    """A sign at the test where a track begins, or at the first that lacks it, there at its last value."""
    named: set[str] = set()
    for event in tracks.events:
        if event.track not in some:
            continue
        sign, name = SIGNS[event.kind]
        at = event.test
        while np.isnan(y[at, event.track]):
            at -= 1
        level = y[at, event.track]
        # What leads from the last test that had it to the first that lacks it is no measurement.
        ax.plot(x[[at, event.test]], [level, level], ls=":", lw=0.9, color="0.4", zorder=1)
        ax.plot(
            x[event.test],
            level,
            ls="none",
            marker=sign,
            ms=12.0,
            mew=1.4,
            mfc="none",
            color="black",
            zorder=5,
            label=None if name in named else name,
        )
        named.add(name)
