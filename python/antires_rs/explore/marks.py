"""The values of a response as marks in its figures: found, added and dropped."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..order_sweep.table import ResponseTable
from .canvas import COLOURS, FONT, INK, columns, hover

__all__ = ["LOOKS", "Marks", "draw_marks", "mark_columns"]

#: Colour and dash of each kind of value. The table behind a kind's marks has its name: a page writes new ones
#: into it.
LOOKS: dict[str, tuple[str, str | list[int]]] = {
    "accepted": (COLOURS["vermillion"], "dashed"),
    "accepted, not stable": (COLOURS["vermillion"], "dashdot"),
    "added by hand": (COLOURS["black"], "solid"),
    "dropped by hand": (COLOURS["black"], [1, 4]),
}
STABLE, UNSTABLE, ADDED, DROPPED = LOOKS
#: Before the name of a kind: its entry in a legend, which a page shows while there are such values.
ENTRY = "entry of "
#: Labels nearer to each other than this share of the band are left out; hover and table have them.
LABEL_GAP = 0.03
Marks = dict[str, dict[str, list[Any]]]


def mark_columns(zeros: AntiresonanceSet, dof: Any, band_hz: tuple[float, float]) -> Marks:
    """The marks of a response by kind: a row a value, ascending, dropped ones included."""
    now, before = zeros.tables[dof], zeros.original().tables[dof]
    gone = before.take(~np.isin(before.freq_hz, now.freq_hz))
    rows = [*_rows(now), *((freq, DROPPED, std) for freq, _, std in _rows(gone))]
    rows.sort()
    marks: Marks = {kind: {"freq": [], "label": [], "error": []} for kind in LOOKS}
    last = -np.inf
    for freq, kind, std in rows:
        shown = freq - last >= LABEL_GAP * (band_hz[1] - band_hz[0])
        last = freq if shown else last
        label = f"({freq:.2f})" if kind == DROPPED else f"{freq:.2f}"
        marks[kind]["freq"].append(freq)
        marks[kind]["label"].append(label if shown else "")
        marks[kind]["error"].append("not known" if np.isnan(std) else f"{std:.2g} Hz")
    return marks


def _rows(table: ResponseTable) -> list[tuple[float, str, float]]:
    """Frequency, kind and standard deviation."""
    how = table.scores.get("how", np.full(len(table), "chain"))
    unsteady = np.isin(how, ["persistent", "likeliest order"])
    kinds = np.where(table.by_hand, ADDED, np.where(unsteady, UNSTABLE, STABLE))
    return list(zip(table.freq_hz.tolist(), kinds.tolist(), table.std_hz.tolist(), strict=True))


def draw_marks(fig: Any, marks: Marks, *, labels: bool = False, every_kind: bool = False) -> None:
    """Vertical lines over the figure at the values, with their frequencies beside them if asked for.

    With ``every_kind`` those without a value have their place too, for pages in which values change.
    """
    for kind, (colour, dash) in LOOKS.items():
        if not every_kind and not marks[kind]["freq"]:
            continue
        table = columns(**marks[kind])
        table.name = kind
        drawn = fig.vspan(
            x="freq", source=table, line_color=colour, line_dash=dash, line_width=1.6, legend_label=kind
        )
        hover(fig, [drawn], {kind.capitalize(): "@freq{0.000} Hz", "Standard deviation": "@error"})
        entry = fig.legend[0].items[-1]  # that of no value at all would stand there without its line
        entry.name, entry.visible = f"{ENTRY}{kind}", bool(marks[kind]["freq"])
        if labels:
            fig.add_layout(_labels(table))


def _labels(table: Any) -> Any:
    """On the lower edge of the figure, whatever part of it is shown."""
    from bokeh.core.properties import value
    from bokeh.models import LabelSet

    return LabelSet(
        x="freq",
        y=value(5),
        y_units="screen",
        x_offset=-3,
        text="label",
        source=table,
        angle=np.pi / 2,
        text_baseline="bottom",
        text_font=value(FONT),
        text_font_size=value("11px"),
        text_color=INK,
        background_fill_color="white",
        background_fill_alpha=0.8,
    )
