"""All that speaks for the antiresonances of a response, to be explored and clicked on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..signals.averaging import Averages
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..signals.spectra import two_channel
from ..support.checks import FloatArray
from .identification import ADDED, DROPPED, LOOKS, STABLE, UNSTABLE, singular_values, stabilization
from .live_canvas import INK, below, columns, dash_of, edge_labels, explored, hover, require_bokeh, stacked
from .marks import Axis, Line, Panel

# -- The values of a response as marks in its figures: found, added and dropped


#: Before the name of a kind: its entry in a legend, which a page shows while there are such values.
ENTRY = "entry of "
#: Labels nearer to each other than this share of the band are left out; hover and table have them.
LABEL_GAP = 0.03
Marks = dict[str, dict[str, list[Any]]]


def mark_columns(zeros: AntiresonanceSet, dof: Any, band_hz: tuple[float, float]) -> Marks:
    """The marks of a response by kind: a row a value, ascending, dropped ones included."""
    now, before = zeros.tables[dof], zeros.original().tables[dof]
    gone = before.take(~np.isin(before.freq_hz, now.freq_hz))
    how = now.scores.get("how", np.full(len(now), "chain"))
    unsteady = np.isin(how, ["persistent", "likeliest order"])
    kinds = np.where(now.by_hand, ADDED, np.where(unsteady, UNSTABLE, STABLE))
    rows = list(zip(now.freq_hz.tolist(), kinds.tolist(), now.std_hz.tolist(), strict=True))
    rows += [
        (freq, DROPPED, std) for freq, std in zip(gone.freq_hz.tolist(), gone.std_hz.tolist(), strict=True)
    ]
    marks: Marks = {kind: {"x": [], "label": [], "error": []} for kind in LOOKS}
    last = -np.inf
    for freq, kind, std in sorted(rows):
        shown = freq - last >= LABEL_GAP * (band_hz[1] - band_hz[0])
        last = freq if shown else last
        label = f"({freq:.2f})" if kind == DROPPED else f"{freq:.2f}"
        marks[kind]["x"].append(freq)
        marks[kind]["label"].append(label if shown else "")
        marks[kind]["error"].append("not known" if np.isnan(std) else f"{std:.2g} Hz")
    return marks


def draw_marks(fig: Any, marks: Marks, *, labels: bool = False, every_kind: bool = False) -> None:
    """Lines at the values, in tables that a page may rewrite, for which ``every_kind`` has its place."""
    for kind, (colour, dash) in LOOKS.items():
        if not every_kind and not marks[kind]["x"]:
            continue
        table = columns(**marks[kind])
        table.name = kind
        look = {"line_color": colour, "line_dash": dash_of(dash), "line_width": 1.6}
        drawn = fig.vspan(x="x", source=table, legend_label=kind, **look)
        hover(fig, [drawn], {kind.capitalize(): "@x{0.000} Hz", "Standard deviation": "@error"})
        entry = fig.legend[0].items[-1]  # that of no value at all would stand there without its line
        entry.name, entry.visible = f"{ENTRY}{kind}", bool(marks[kind]["x"])
        if labels:
            look = {"background_fill_color": "white", "background_fill_alpha": 0.8}
            edge_labels(fig, table, text_font_size="11px", text_color=INK, **look)


def stabilization_figure(
    diagram: Any,
    zeros: AntiresonanceSet | None = None,
    dof: Any = 0,
    *,
    x_range: Any = None,
    every_kind: bool = False,
) -> Any:
    """Poles of every order, the values, and the summed curve behind them."""
    if zeros is None:
        zeros = AntiresonanceSet.from_tables(dof, {dof: diagram.accepted})
    fig = explored(stabilization(diagram), height=400, x_range=x_range)
    draw_marks(fig, mark_columns(zeros, dof, diagram.band_hz), labels=True, every_kind=every_kind)
    return fig


# -- A measured curve, on its dips, with its coherence below it


@dataclass(frozen=True)
class Curve:
    """What was measured at one response: its size, ``what`` that is with its unit, and its coherence."""

    freq_hz: FloatArray
    size: FloatArray
    what: str
    coherence: FloatArray | None = None
    coherence_with: str = ""


def curve_of(source: Recording | FrequencyResponse, averages: Averages | None, dof: Any) -> Curve | None:
    """The curve of a response, on which its antiresonances are dips; None for a dof that was not measured."""
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


#: Singular values up to so many are drawn; further ones lie in the noise with them.
MOST_VALUES = 6


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

    diagram, check = zeros.diagrams.get(dof), zeros.data_check
    band = band_hz or (diagram.band_hz if diagram is not None else _around(zeros, dof))
    x = Range1d(*band, bounds=None)
    marks = mark_columns(zeros, dof, band)
    figures = []
    if diagram is not None:
        figures.append(stabilization_figure(diagram, zeros, dof, x_range=x, every_kind=every_kind))
    if curve is not None:
        size = np.where(curve.size > 0.0, curve.size, np.nan)
        y, look = Axis(curve.what, log=True), {"colour": "blue", "label": "measured"}
        panel = _one_line("curve", curve.freq_hz, size, band, y, {"Size": "@y{0.000e+0}"}, **look)
        figures.append(explored(panel, height=300, x_range=x))
        draw_marks(figures[-1], marks, every_kind=every_kind)
        figures[-1].legend.visible = diagram is None
        if curve.coherence is not None:
            y, says = (
                Axis(f"Coherence with {curve.coherence_with} (-)", (0.0, 1.04)),
                {"Coherence": "@y{0.000}"},
            )
            panel = _one_line("coherence", curve.freq_hz, curve.coherence, band, y, says, width=0.9)
            figures.append(explored(panel, height=180, x_range=x))
    if diagram is None and curve is None:  # the set was made by hand or loaded
        alone = Panel("values_alone", Axis("Frequency (Hz)"), Axis("", (0.0, 1.0), at=[]), [])
        figures.append(explored(alone, height=240, x_range=x))
        draw_marks(figures[0], marks, labels=True, every_kind=every_kind)
        below(figures[0])
    elif check is not None and check.eigenvalues is not None:
        figures.append(explored(singular_values(check, MOST_VALUES), height=270, x_range=x))
    elif response is not None:  # of responses to one force there is no other value
        level = 20.0 * np.log10(np.maximum(np.linalg.norm(response.values, axis=0), 1e-150))
        y, says = Axis("Singular value (dB re 1)"), {"Level": "@y{0.0} dB"}
        look = {"colour": "blue", "label": "first, the only one for one force"}
        panel = _one_line("singular_values", response.freq_hz, level, band, y, says, **look)
        figures.append(explored(panel, height=270, x_range=x))
    return stacked(figures)


def _one_line(
    name: str,
    freq_hz: FloatArray,
    y: FloatArray,
    band_hz: tuple[float, float],
    axis: Axis,
    says: dict[str, str],
    **look: Any,
) -> Panel:
    """A curve in the band."""
    shown = (freq_hz >= band_hz[0]) & (freq_hz <= band_hz[1])
    line = Line(freq_hz[shown], y[shown], says={"Frequency": "@x{0.000} Hz"} | says, **look)
    return Panel(name, Axis("Frequency (Hz)"), axis, [line])


def _around(zeros: AntiresonanceSet, dof: Any) -> tuple[float, float]:
    """A band that shows all values of the set, so that it is the same for every response."""
    values = [freq for one in (zeros, zeros.original()) for each in one.values() for freq in each]
    if not values:
        return 0.0, 100.0
    low, high = min(values), max(values)
    return max(0.0, low - 0.1 * (high - low + low)), high + 0.1 * (high - low + low)
