"""Stabilization diagram to be zoomed into and clicked on: model order against frequency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.response_table import ResponseTable
from ..signals.averaging import Averages
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..signals.spectra import two_channel
from ..support.checks import FloatArray
from .canvas import COLOURS
from .identification import CURVE, pole_table
from .live_canvas import FONT, INK, below, columns, hover, paper, require_bokeh, stacked

if TYPE_CHECKING:
    from ..identification.stabilization import StabilizationDiagram


# -- The values of a response as marks in its figures: found, added and dropped


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


def stabilization_figure(
    diagram: StabilizationDiagram,
    zeros: AntiresonanceSet | None = None,
    dof: Any = 0,
    *,
    height: int = 400,
    x_range: Any = None,
    every_kind: bool = False,
) -> Any:
    """Poles of every order, the stable ones, the values, and the summed curve behind them."""
    order, freq, damping, stable = pole_table(diagram)
    first, last = float(diagram.orders[0]), float(diagram.orders[-1])
    fig = paper(
        "Frequency (Hz)",
        "Model order (-)",
        height=height,
        x_range=diagram.band_hz if x_range is None else x_range,
        y_range=(first - 1.5, last + 1.0),
        name="stabilization",
    )
    _curve_behind(fig, diagram)
    if zeros is None:
        zeros = AntiresonanceSet.from_tables(dof, {dof: diagram.accepted})
    draw_marks(fig, mark_columns(zeros, dof, diagram.band_hz), labels=True, every_kind=every_kind)
    drawn = [
        fig.scatter(
            "freq",
            "order",
            source=_poles(order, freq, damping, ~stable),
            marker="x",
            size=5,
            color=COLOURS["orange"],
            legend_label="pole, not stable",
        ),
        fig.scatter(
            "freq",
            "order",
            source=_poles(order, freq, damping, stable),
            marker="circle",
            size=5,
            color=COLOURS["blue"],
            legend_label="stable pole",
        ),
    ]
    hover(
        fig, drawn, {"Frequency": "@freq{0.000} Hz", "Model order": "@order", "Damping": "@damping{0.00} %"}
    )
    left = diagram.left_out
    if len(left):
        why = left.scores.get("why", np.full(len(left), ""))
        table = columns(freq=left.freq_hz, order=np.full(len(left), last + 0.2), why=why.tolist())
        seen = fig.scatter(
            "freq",
            "order",
            source=table,
            marker="inverted_triangle",
            size=9,
            fill_color="white",
            line_color=COLOURS["black"],
            legend_label="seen, not accepted",
        )
        hover(fig, [seen], {"Seen, not accepted": "@freq{0.000} Hz", "Why": "@why"})
    below(fig)
    return fig


def _poles(order: Any, freq: Any, damping: Any, which: Any) -> Any:
    return columns(freq=freq[which], order=order[which].astype(np.float32), damping=100.0 * damping[which])


def _curve_behind(fig: Any, diagram: StabilizationDiagram) -> None:
    """The summed curves, pale, on a logarithmic axis of their own at the right."""
    from bokeh.models import LinearAxis, LogAxis, LogScale, Range1d

    size = np.asarray(diagram.background, dtype=np.float64)
    there = np.isfinite(size) & (size > 0.0)
    if not there.any():
        return
    low, high = float(size[there].min()), float(size[there].max())
    fig.extra_y_ranges = {"curve": Range1d(0.7 * low, 1.4 * high)}
    fig.extra_y_scales = {"curve": LogScale()}
    axis: LinearAxis = LogAxis(
        y_range_name="curve",
        axis_label="Summed curves (unit of the data)",
        axis_label_text_font_style="normal",
        axis_label_text_color="#595959",
        major_label_text_color="#595959",
        axis_label_text_font_size="12px",
    )
    fig.add_layout(axis, "right")
    fig.line(
        "freq",
        "size",
        source=columns(freq=diagram.background_freq_hz, size=np.where(there, size, np.nan)),
        y_range_name="curve",
        color=CURVE,
        line_width=1.2,
        legend_label="summed curves, peaks at poles",
    )


# -- A measured curve, on its dips, with its coherence below it


@dataclass(frozen=True)
class Curve:
    """What was measured at one response.

    Attributes
    ----------
    freq_hz, size : (n_freq,)
    what : str
        What ``size`` is, with its unit in parentheses.
    coherence : (n_freq,) or None
        None where it is not known.
    coherence_with : str
        With what.
    """

    freq_hz: FloatArray
    size: FloatArray
    what: str
    coherence: FloatArray | None = None
    coherence_with: str = ""


def curve_of(source: Recording | FrequencyResponse, averages: Averages | None, dof: Any) -> Curve | None:
    """The curve of a response on which its antiresonances are dips; None for a dof that was not measured.

    ``averages`` are those of a record. Its coherence is that with the force where that was recorded, else
    with the channel with which it is highest.
    """
    if dof not in source.dofs:
        return None
    row = source.dofs.index(dof)
    if isinstance(source, FrequencyResponse):
        over = "the force" if source.reference is None else f"dof {source.reference}"
        return Curve(
            source.freq_hz,
            np.abs(source.values[row]),
            f"Dof {dof} over {over} (unit of the data)",
            None if source.coherence is None else source.coherence[row],
            over,
        )
    assert averages is not None
    spectra = averages.spectra
    auto = np.sqrt(spectra.matrix[:, row, row].real)
    unit = "unit of the data x s" if averages.nperseg is None else "unit of the data/√Hz"
    coherence, name = None, ""
    if spectra.n_averages > 1:
        _, all_of_them = two_channel(spectra.matrix, row, "h1")
        others = [p for p in range(all_of_them.shape[0]) if p != row]
        if averages.has_force:
            best, name = len(all_of_them) - 1, "the force"
        elif others:
            best = max(others, key=lambda p: float(np.median(all_of_them[p])))
            name = f"dof {source.dofs[best]}"
        coherence = all_of_them[best] if name else None
    return Curve(spectra.freq_hz, auto, f"Spectrum of dof {dof} ({unit})", coherence, name)


def curve_figure(
    curve: Curve,
    zeros: AntiresonanceSet,
    dof: Any,
    band_hz: tuple[float, float],
    *,
    x_range: Any = None,
    legend: bool = True,
    every_kind: bool = False,
) -> Any:
    """The curve of a response with its values marked: antiresonances stand at its dips."""
    shown = (curve.freq_hz >= band_hz[0]) & (curve.freq_hz <= band_hz[1])
    fig = paper(
        "Frequency (Hz)",
        curve.what,
        height=300,
        x_range=band_hz if x_range is None else x_range,
        y_log=True,
        name="curve",
    )
    fig.yaxis.axis_label_text_font_size = "11px"
    draw_marks(fig, mark_columns(zeros, dof, band_hz), every_kind=every_kind)
    size = np.where(curve.size > 0.0, curve.size, np.nan)
    line = fig.line(
        "freq",
        "size",
        source=columns(freq=curve.freq_hz[shown], size=size[shown]),
        color=COLOURS["blue"],
        line_width=1.4,
        legend_label="measured",
    )
    hover(fig, [line], {"Frequency": "@freq{0.000} Hz", "Size": "@size{0.000e+0}"}, mode="vline")
    if legend:
        below(fig)
    else:
        fig.legend.visible = False
    return fig


def coherence_figure(curve: Curve, band_hz: tuple[float, float], *, x_range: Any = None) -> Any:
    """The coherence of a response; None in the curve is not drawn, ask before."""
    shown = (curve.freq_hz >= band_hz[0]) & (curve.freq_hz <= band_hz[1])
    fig = paper(
        "Frequency (Hz)",
        f"Coherence with {curve.coherence_with} (-)",
        height=180,
        x_range=band_hz if x_range is None else x_range,
        y_range=(0.0, 1.04),
        name="coherence",
    )
    fig.yaxis.axis_label_text_font_size = "11px"
    line = fig.line(
        "freq",
        "coherence",
        source=columns(freq=curve.freq_hz[shown], coherence=np.asarray(curve.coherence)[shown]),
        color=COLOURS["black"],
        line_width=1.1,
    )
    hover(fig, [line], {"Frequency": "@freq{0.000} Hz", "Coherence": "@coherence{0.000}"}, mode="vline")
    return fig


# -- Singular values of the responses by frequency: is it one force, and where do the modes lie


#: The others are drawn up to this many; further ones lie in the noise with them.
OTHERS = 6


def singular_values_figure(
    check: Any, response: FrequencyResponse | None, band_hz: tuple[float, float], *, x_range: Any = None
) -> Any | None:
    """Singular values of the spectral matrix of a record; of responses to one force, the only one."""
    values = getattr(check, "eigenvalues", None)
    if values is None and response is None:
        return None
    what = "Singular value (dB re noise)" if values is not None else "Singular value (dB re 1)"
    fig = paper(
        "Frequency (Hz)",
        what,
        height=270,
        x_range=band_hz if x_range is None else x_range,
        name="singular_values",
    )
    fig.yaxis.axis_label_text_font_size = "11px"
    if values is None:
        assert response is not None
        shown = (response.freq_hz >= band_hz[0]) & (response.freq_hz <= band_hz[1])
        norm = np.linalg.norm(response.values[:, shown], axis=0)[:, None] ** 2
        drawn = [
            _line(fig, response.freq_hz[shown], norm, 0, "first, the only one for one force", "blue", "solid")
        ]
    else:
        freq = check.freq_hz
        for i in range(min(values.shape[1], OTHERS) - 1, 1, -1):
            _line(fig, freq, values, i, "the others", None, "solid")
        if check.second_expected is not None:
            expected = np.asarray(check.second_expected)[:, None]
            _line(fig, freq, expected, 0, "second expected under one force", "black", "dotted")
        drawn = [_line(fig, freq, values, 0, "first", "blue", "solid")]
        if values.shape[1] > 1:
            drawn.append(_line(fig, freq, values, 1, "second", "vermillion", "dashed"))
    hover(fig, drawn, {"Frequency": "@freq{0.000} Hz", "Level": "@level{0.0} dB"})
    below(fig)
    return fig


def _line(
    fig: Any, freq_hz: FloatArray, values: FloatArray, i: int, label: str, colour: str | None, dash: str
) -> Any:
    """One of them in dB; what is nothing but rounding is left out."""
    size = np.maximum(values[:, i], 1e-300)
    level = np.where(size > 1e-12 * values.max(), 10.0 * np.log10(size), np.nan)
    return fig.line(
        "freq",
        "level",
        source=columns(freq=freq_hz, level=level),
        color="#B8B8B8" if colour is None else COLOURS[colour],
        line_dash=dash,
        line_width=0.8 if colour is None else 1.4,
        legend_label=label,
    )


# -- All figures that speak for the antiresonances of one response, on one frequency axis


def evidence_figure(
    zeros: AntiresonanceSet,
    dof: Any,
    curve: Curve | None = None,
    response: FrequencyResponse | None = None,
    band_hz: tuple[float, float] | None = None,
    *,
    every_kind: bool = False,
) -> Any:
    """Diagram, curve, coherence and singular values of a response, as far as they are there."""
    require_bokeh()
    from bokeh.models import Range1d

    diagram = zeros.diagrams.get(dof)
    band = band_hz or (diagram.band_hz if diagram is not None else _around(zeros, dof))
    axis = Range1d(*band, bounds=None)
    figures = []
    if diagram is not None:
        figures.append(stabilization_figure(diagram, zeros, dof, x_range=axis, every_kind=every_kind))
    if curve is not None:
        figures.append(
            curve_figure(curve, zeros, dof, band, x_range=axis, legend=diagram is None, every_kind=every_kind)
        )
        if curve.coherence is not None:
            figures.append(coherence_figure(curve, band, x_range=axis))
    if diagram is not None or curve is not None:
        singular = singular_values_figure(zeros.data_check, response, band, x_range=axis)
        figures += [] if singular is None else [singular]
    else:
        figures.append(_values_alone(zeros, dof, band, axis, every_kind))
    return stacked(figures)


def _values_alone(
    zeros: AntiresonanceSet, dof: Any, band: tuple[float, float], axis: Any, every_kind: bool
) -> Any:
    """The values of a set of which nothing else is there: it was made by hand or loaded."""
    fig = paper("Frequency (Hz)", "", height=240, x_range=axis, y_range=(0.0, 1.0), name="values_alone")
    fig.yaxis.visible = False
    draw_marks(fig, mark_columns(zeros, dof, band), labels=True, every_kind=every_kind)
    below(fig)
    return fig


def _around(zeros: AntiresonanceSet, dof: Any) -> tuple[float, float]:
    """A band that shows all values of the set, so that it is the same for every response."""
    values = [freq for one in (zeros, zeros.original()) for each in one.values() for freq in each]
    if not values:
        return 0.0, 100.0
    low, high = min(values), max(values)
    return max(0.0, low - 0.1 * (high - low + low)), high + 0.1 * (high - low + low)
