"""The values of a response as marks in its figures: found, added and dropped."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..order_sweep.table import ResponseTable
from .canvas import COLOURS, FONT, INK, columns

__all__ = ["VALUES", "draw_marks", "mark_columns"]

#: Name of the table of marks in every figure that has them: a page writes new ones into it.
VALUES = "values"
#: Colour and dash of each kind of value.
LOOKS: dict[str, tuple[str, list[int]]] = {
    "accepted": (COLOURS["vermillion"], [7, 3]),
    "accepted, not stable over the orders": (COLOURS["vermillion"], [7, 3, 2, 3]),
    "added by hand": (COLOURS["black"], []),
    "dropped by hand": (COLOURS["black"], [1, 4]),
}
#: Labels nearer to each other than this share of the band are left out; hover and table have them.
LABEL_GAP = 0.03


def mark_columns(zeros: AntiresonanceSet, dof: Any, band_hz: tuple[float, float]) -> dict[str, list[Any]]:
    """The marks of a response: one row a value, dropped ones included, ascending."""
    now, before = zeros.tables[dof], zeros.original().tables[dof]
    gone = before.take(~np.isin(before.freq_hz, now.freq_hz))
    rows = [*_rows(now), *((freq, "dropped by hand", std) for freq, _, std in _rows(gone))]
    rows.sort()
    labels, last = [], -np.inf
    for freq, kind, _ in rows:
        shown = freq - last >= LABEL_GAP * (band_hz[1] - band_hz[0])
        labels.append((f"({freq:.2f})" if kind == "dropped by hand" else f"{freq:.2f}") if shown else "")
        last = freq if shown else last
    return {
        "freq": [freq for freq, _, _ in rows],
        "kind": [kind for _, kind, _ in rows],
        "colour": [LOOKS[kind][0] for _, kind, _ in rows],
        "dash": [LOOKS[kind][1] for _, kind, _ in rows],
        "label": labels,
        "error": ["not known" if np.isnan(std) else f"{std:.2g} Hz" for _, _, std in rows],
    }


def _rows(table: ResponseTable) -> list[tuple[float, str, float]]:
    """Frequency, kind and standard deviation."""
    how = table.scores.get("how", np.full(len(table), "chain"))
    kinds = np.where(
        table.by_hand,
        "added by hand",
        np.where(np.isin(how, ["persistent", "likeliest order"]), *list(LOOKS)[1::-1]),
    )
    return list(zip(table.freq_hz.tolist(), kinds.tolist(), table.std_hz.tolist(), strict=True))


def draw_marks(fig: Any, marks: dict[str, list[Any]], *, labels: bool = False) -> Any:
    """Vertical lines over the figure at the values, with their frequencies beside them if asked for."""
    table = columns(**{name: marks[name] for name in marks if name != "dash"})
    table.data["dash"] = marks["dash"]
    table.name = VALUES
    drawn = fig.vspan(
        x="freq", source=table, line_color="colour", line_dash="dash", line_width=1.6, legend_field="kind"
    )
    if labels:
        from bokeh.core.properties import value
        from bokeh.models import LabelSet

        # On the lower edge of the figure, whatever part of it is shown.
        fig.add_layout(
            LabelSet(
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
        )
    return drawn
