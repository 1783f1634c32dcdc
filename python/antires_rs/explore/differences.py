"""Measured values beside those of the model: differences of each, before and after."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..plotting.clipping import reach
from .canvas import COLOURS, below, columns, hover, paper

if TYPE_CHECKING:
    from ..support.validation import FloatArray
    from ..updating.tables import FrequencyTable, ModalTable

__all__ = ["differences_figure"]

#: Space between two responses, in widths of a value.
GAP = 0.8


def differences_figure(
    table: FrequencyTable | ModalTable, names: tuple[str, str] = ("before updating", "after updating")
) -> Any:
    """Bars of the difference of each frequency to the measured one in %, before and after.

    Parameters
    ----------
    table : FrequencyTable or ModalTable
        ``UpdateResult.table``.
    names : (str, str), optional
        What the two states of the model are called.

    Returns
    -------
    bokeh.plotting.figure
        The axis is made for the many: a value that stands apart is a triangle at its edge, with its number;
        zooming out shows it. A cross where the model has no partner.
    """
    modal = hasattr(table, "before_mac")
    of, starts = _groups(table, modal)
    x = np.arange(of.size) + GAP * (np.cumsum(starts) - 1)
    both = np.concatenate([table.before_percent, table.after_percent])
    most = reach(both)
    both = both[np.isfinite(both)]
    low, high = (
        float(np.clip(end, -most, most)) for end in (min(both.min(initial=0), 0), max(both.max(initial=0), 0))
    )
    room = 0.12 * max(high - low, 1e-6)
    fig = paper(
        f"{'Resonances' if modal else 'Antiresonances'}, by {'test' if modal else 'response'}, ascending",
        "Difference to the measurement (%)",
        height=360,
        x_range=(float(x[0]) - 0.9, float(x[-1]) + 0.9) if x.size else (0.0, 1.0),
        y_range=(low - (room if low < 0 else 0.02 * room), high + room),
        name="differences",
    )
    says = {"Of": "@of", "Measured": "@measured{0.000} Hz", "Model": "@model{0.000} Hz"}
    says |= {"Difference": "@difference{+0.00} %"} | ({"MAC": "@mac{0.000}"} if modal else {})
    for side, (state, name, colour) in enumerate(
        zip(("before", "after"), names, (COLOURS["vermillion"], COLOURS["blue"]), strict=True)
    ):
        percent = np.asarray(getattr(table, f"{state}_percent"))
        values = {
            "x": x + (-0.2, 0.2)[side],
            "difference": percent,
            "of": of.tolist(),
            "measured": table.measured_hz,
            "model": getattr(table, f"{state}_hz"),
        } | ({"mac": getattr(table, f"{state}_mac")} if modal else {})
        look: dict[str, Any] = {"fill_color": colour if side else "white", "line_color": colour}
        look |= (
            {} if side else {"hatch_pattern": "right_diagonal_line", "hatch_color": colour, "hatch_scale": 6}
        )
        _state(fig, values, percent, name, look, says, (low, high))
    _names_above(fig, x, of, starts, modal)
    fig.xaxis.major_label_text_font_size = "0px"
    fig.xaxis.major_tick_line_color = None
    fig.xgrid.grid_line_color = None
    below(fig, side_by_side=1)  # entries that name the largest are long
    return fig


def _state(
    fig: Any,
    values: dict[str, Any],
    percent: FloatArray,
    name: str,
    look: dict[str, Any],
    says: dict[str, str],
    ends: tuple[float, float],
) -> None:
    """The bars of one state, crosses where there is no partner, triangles for what lies beyond."""
    there = np.isfinite(percent)
    label = f"{name}, largest {np.abs(percent[there]).max():.2f} %" if there.any() else f"{name}, no partner"
    bars = fig.vbar(
        x="x", top="difference", width=0.38, source=_rows(values, there), legend_label=label, **look
    )
    drawn = [bars]
    if not there.all():
        lost = _rows(values | {"zero": np.zeros(percent.size)}, ~there)
        cross = fig.scatter(
            "x", "zero", source=lost, marker="x", size=9, line_width=2, color=look["line_color"],
            legend_label=f"{name}: no partner ({int(np.sum(~there))})",
        )  # fmt: skip
        drawn.append(cross)
    hover(fig, drawn, {"": name} | says)
    for up in (True, False):
        end = ends[1] if up else ends[0]
        beyond = there & ((percent > end) if up else (percent < end))
        if beyond.any():
            marks = _rows(values, beyond)
            marks.data["edge"] = np.full(int(beyond.sum()), end, dtype=np.float32)
            marks.data["label"] = [f"{value:+.0f} %" for value in percent[beyond]]
            fig.scatter(
                "x", "edge", source=marks, size=10, color=look["line_color"], line_color="white",
                marker="triangle" if up else "inverted_triangle", legend_label="beyond the axis",
            )  # fmt: skip
            # Upright, so that neighbours do not run into each other.
            fig.text(
                "x",
                "edge",
                "label",
                source=marks,
                angle=np.pi / 2,
                text_align="right" if up else "left",
                y_offset=9 if up else -9,
                text_baseline="middle",
                text_font_size="11px",
                background_fill_color="white",
            )


def _rows(values: dict[str, Any], which: Any) -> Any:
    picked = {
        name: np.asarray(column, dtype=object if name == "of" else None)[which]
        for name, column in values.items()
    }
    return columns(**(picked | {"of": picked["of"].tolist()}))


def _groups(table: Any, modal: bool) -> tuple[Any, Any]:
    """What each value is of, and where a group begins."""
    if modal:
        mode = np.asarray(table.mode)
        return np.array([f"mode {each}" for each in mode], dtype=object), np.r_[True, mode[1:] <= mode[:-1]][
            : mode.size
        ]
    dof, force = np.asarray(table.dof), np.asarray(table.excitation)

    def called(number: int) -> str:
        return str(table.dof_names.get(number, f"dof {number}"))

    several = np.unique(force).size > 1
    of = [
        called(int(d)) + (f", force at {called(int(k))}" if several else "")
        for d, k in zip(dof, force, strict=True)
    ]
    starts = np.r_[True, (dof[1:] != dof[:-1]) | (force[1:] != force[:-1])][: dof.size]
    return np.array(of, dtype=object), starts


def _names_above(fig: Any, x: FloatArray, of: Any, starts: Any, modal: bool) -> None:
    """Lines between the groups, and the name of each along the lower edge, upright."""
    from bokeh.core.properties import value
    from bokeh.models import LabelSet, Span

    firsts = np.flatnonzero(starts)
    for first in firsts[1:]:
        fig.add_layout(
            Span(location=float(x[first]) - 0.5 - GAP / 2, dimension="height", line_color="#BFBFBF")
        )
    if modal:
        return
    table = columns(x=x[firsts] - 0.45, name=[str(of[first]) for first in firsts])
    fig.add_layout(
        LabelSet(
            x="x",
            y=value(4),
            y_units="screen",
            text="name",
            source=table,
            angle=np.pi / 2,
            text_baseline="top",
            text_font_size=value("10px"),
            text_color="#444444",
        )
    )
