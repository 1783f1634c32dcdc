"""Poles and values of an identification, what stands behind them, and all that speaks for a response."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..signals.averaging import Averages
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..signals.spectra import two_channel
from ..support.checks import FloatArray
from ..support.messages import keywords_left
from . import live_canvas as live
from .canvas import below, draw, draw_marks, new_axes
from .marks import COLOURS, Axis, Line, Mark, Panel, Points, Rules

if TYPE_CHECKING:
    from ..identification.stabilization import StabilizationDiagram
    from ..signals.findings import DataCheck

__all__ = ["plot_singular_values", "plot_stabilization"]

CURVE = "#B8B8B8"  # lighter than every mark, also where colours are lost
LOOKS: dict[str, tuple[str, Any]] = {  #: Colour and dash of each kind of value.
    "accepted": (COLOURS["vermillion"], "--"),
    "accepted, not stable": (COLOURS["vermillion"], "-."),
    "added by hand": (COLOURS["black"], (8, 3)),
    "dropped by hand": (COLOURS["black"], ":"),
}
STABLE, UNSTABLE, ADDED, DROPPED = LOOKS


@keywords_left(dropped="give zeros= and dof=", added="give zeros= and dof=")
def plot_stabilization(
    diagram: StabilizationDiagram, ax: Any = None, *, zeros: AntiresonanceSet | None = None, dof: Any = 0
) -> Any:
    """Draw the poles of every order, the stable ones, and the accepted antiresonances.

    With the set ``zeros`` the values are those of its response ``dof``, with what was dropped and added by
    hand.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> f = np.linspace(1.0, 20.0, 200)
    >>> ar.stabilization(f, 25 / (5**2 - f**2 + 0.1j * f), max_order=20).plot().get_xlabel()
    'Frequency (Hz)'
    """
    ax = draw(stabilization(diagram), new_axes(ax, (9.0, 5.2)), legend=False)
    look = {"rotation": 90, "ha": "center", "va": "bottom", "fontsize": "x-small"}
    look |= {"xycoords": ax.get_xaxis_transform(), "annotation_clip": False}
    marks = _marks_on(diagram, zeros, dof)
    draw_marks(ax, [Rules(marks[kind]["x"], True, *LOOKS[kind], 1.1, label=kind) for kind in LOOKS], 1.5)
    for rows in marks.values():
        for freq, label in zip(rows["x"], rows["label"], strict=True):
            if label:
                ax.annotate(label, (freq, 1.015), **look)
    if not any(rows["x"] for rows in marks.values()):
        ax.set_title("no antiresonance accepted in this band", fontsize="medium")
    ax.yaxis.get_major_locator().set_params(integer=True)
    below(ax)
    return ax


#: Looks of poles.
_POLE: dict[str, Any] = {"marker": "x", "stroke": 0.7, "colour": "orange", "label": "pole, not stable"}
_STABLE_POLE: dict[str, Any] = {"stroke": 0.0, "colour": "blue", "label": "stable pole"}
SEEN_ABOVE = 0.2  # orders above the highest at which what was seen and not accepted stands


def stabilization(diagram: StabilizationDiagram) -> Panel:
    """Poles of every order, the stable ones, and the summed curve behind them."""
    order, freq, damping, stable = pole_table(diagram)
    first, last = float(diagram.orders[0]), float(diagram.orders[-1])
    says = {"Frequency": "@x{0.000} Hz", "Model order": "@y", "Damping": "@damping{0.00} %"}
    marks: list[Mark] = []
    for which, look in ((~stable, _POLE), (stable, _STABLE_POLE)):
        more = {"damping": 100.0 * damping[which]}
        marks.append(Points(freq[which], order[which], size=3.3, says=says, more=more, **look))
    left = diagram.left_out
    if len(left):
        more = {"why": left.scores.get("why", np.full(len(left), "")).tolist()}
        says = {"Seen, not accepted": "@x{0.000} Hz", "Why": "@why"}
        look = {"face": "white", "only": "page", "label": "seen, not accepted", "says": says, "more": more}
        marks.append(Points(left.freq_hz, np.full(len(left), last + SEEN_ABOVE), "v", **look))
    size = np.asarray(diagram.background, dtype=np.float64)
    label = "summed curves, peaks at poles (right axis)"
    shown = np.where(size > 0.0, size, np.nan)
    curve = Line(diagram.background_freq_hz, shown, CURVE, width=1.0, label=label)
    x, y = Axis("Frequency (Hz)", diagram.band_hz), Axis("Model order (-)", (first - 1.5, last + 1.0))
    behind = (Axis("Summed curves (unit of what is fitted)"), curve)
    return Panel("stabilization", x, y, marks, behind=behind)


def pole_table(diagram: StabilizationDiagram) -> tuple[FloatArray, FloatArray, FloatArray, Any]:
    """Order, frequency in Hz, damping ratio and stability of all poles, (n_poles,) each."""
    order = np.repeat(np.asarray(diagram.orders), [len(f) for f in diagram.freq_hz])
    freq, damping = (np.concatenate([[], *rows]) for rows in (diagram.freq_hz, diagram.damping_ratio))
    return order, freq, damping, np.concatenate([np.empty(0, dtype=bool), *diagram.stable])


# -- Whether one force is enough


def plot_singular_values(check: DataCheck, ax: Any = None) -> Any:
    """Draw the singular values of the responses' spectral matrix, and what one force would make the second.

    Under one force the first stands out, and the second lies where noise and leakage put it; a second force
    lifts it everywhere but at the resonances. Channels are scaled to equal noise, so 0 dB is the noise (on
    exact data: 60 dB below the mean power). A check of data without averages, which has no spectral matrix,
    is refused.

    Examples
    --------
    >>> import antires_rs as ar
    >>> rec = ar.cases.chain8().experiment(noise=0.02, duration_s=60.0, rng=0)
    >>> ar.check_data(rec, band_hz=(3, 130)).plot().get_ylabel()
    'Singular value (dB re noise power)'
    """
    if getattr(check, "eigenvalues", None) is None:
        got = "a check without eigenvalues" if hasattr(check, "findings") else type(check).__name__
        remedy = "Single impacts and measured responses have no spectral matrix."
        reject("check", got, "the DataCheck of a Recording with several averages", remedy)
    return draw(singular_values(check), new_axes(ax, (9.0, 4.5)))


def singular_values(check: DataCheck, most: int | None = None) -> Panel:
    """Singular values in dB: of ``most`` at most beside the first and the second."""
    values = np.asarray(check.eigenvalues)
    least = 1e-14 * values.max()
    level = 10.0 * np.log10(np.maximum(values, least))
    says = {"Frequency": "@x{0.000} Hz", "Level": "@y{0.0} dB"}
    marks: list[Mark] = []
    for i in range(min(values.shape[1], most or values.shape[1]) - 1, 1, -1):
        # Rank deficient by construction: rounding, which would only stretch the axis.
        seen = np.where(values[:, i] > 1e-12 * values.max(), level[:, i], np.nan)
        marks.append(Line(check.freq_hz, seen, "#C4C4C4", width=0.5, label="the others" if i == 2 else None))
    if check.second_expected is not None:
        expected = 10.0 * np.log10(np.maximum(check.second_expected, least))
        label = "second expected under one force"
        marks.append(Line(check.freq_hz, expected, "black", ":", 1.1, label=label))
    if values.shape[1] > 1:
        marks.append(Line(check.freq_hz, level[:, 1], "vermillion", "--", 1.1, label="second", says=says))
    marks.append(Line(check.freq_hz, level[:, 0], "blue", width=1.5, label="first", says=says))
    found = check.named("one_force")
    x, y = Axis("Frequency (Hz)", check.band_hz), Axis("Singular value (dB re noise power)")
    title = f"more than one force ({found[0].severity})" if found else ""
    first = ("first", "second", "second expected under one force", "the others")
    return Panel("singular_values", x, y, marks, grid="both", title=title, first=first)


# -- The values of a response as marks in its figures: found, added and dropped

ENTRY = "entry of "  # before the name of a kind: its entry in a legend, shown while there are any
Marks = dict[str, dict[str, list[Any]]]


LABEL_GAP = 0.03  # labels nearer than this share of the band are left out; the hover has them


def mark_columns(zeros: AntiresonanceSet, dof: Any, band_hz: tuple[float, float]) -> Marks:
    """The marks of a response by kind: a row a value, ascending, dropped ones included."""
    now, before = zeros.tables[dof], zeros.original().tables[dof]
    gone = before.take(~np.isin(before.freq_hz, now.freq_hz))
    unsteady = np.isin(now.scores.get("how", np.full(len(now), "chain")), ["persistent", "likeliest order"])
    kinds = np.where(now.by_hand, ADDED, np.where(unsteady, UNSTABLE, STABLE)).tolist()
    rows = [
        *zip(now.freq_hz.tolist(), kinds, now.std_hz.tolist(), strict=True),
        *zip(gone.freq_hz.tolist(), [DROPPED] * len(gone), gone.std_hz.tolist(), strict=True),
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


def _marks_on(diagram: StabilizationDiagram, zeros: AntiresonanceSet | None, dof: Any) -> Marks:
    """The marks on a diagram: those of the set, or what the diagram itself has accepted."""
    if zeros is None:
        zeros = AntiresonanceSet.from_tables(dof, {dof: diagram.accepted})
    return mark_columns(zeros, zeros._dof(dof), diagram.band_hz)


def _mark_lines(fig: Any, marks: Marks, *, labels: bool = False, every_kind: bool = False) -> None:
    """Lines at the values, in tables that a page may rewrite, for which ``every_kind`` has its place."""
    for kind, (colour, dash) in LOOKS.items():
        if not every_kind and not marks[kind]["x"]:
            continue
        table = live.columns(**marks[kind])
        table.name = kind
        look = {"line_color": colour, "line_dash": live.dash_of(dash), "line_width": 1.6}
        drawn = fig.vspan(x="x", source=table, legend_label=kind, **look)
        live.hover(fig, [drawn], {kind.capitalize(): "@x{0.000} Hz", "Standard deviation": "@error"})
        entry = fig.legend[0].items[-1]  # that of no value at all would stand there without its line
        entry.name, entry.visible = f"{ENTRY}{kind}", bool(marks[kind]["x"])
        if labels:
            look = {"background_fill_color": "white", "background_fill_alpha": 0.8}
            live.edge_labels(fig, table, text_font_size="11px", text_color=live.INK, **look)


def stabilization_figure(
    diagram: Any, zeros: AntiresonanceSet | None = None, dof: Any = 0, *, x_range: Any = None, **options: Any
) -> Any:
    """Poles of every order, the values, and the summed curve behind them."""
    fig = live.explored(stabilization(diagram), height=400, x_range=x_range)
    _mark_lines(fig, _marks_on(diagram, zeros, dof), labels=True, **options)
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
        size, what = np.abs(source.values[row]), f"Dof {dof} over {over} (unit of the data)"
        coherence = None if source.coherence is None else source.coherence[row]
        return Curve(source.freq_hz, size, what, coherence, over)
    assert averages is not None
    spectra = averages.spectra
    unit = "unit of the data x s" if averages.nperseg is None else "unit of the data/√Hz"
    auto, what = np.sqrt(spectra.matrix[:, row, row].real), f"Spectrum of dof {dof} ({unit})"
    if spectra.n_averages > 1:
        _, all_of_them = two_channel(spectra.matrix, row, "h1")
        others = [p for p in range(all_of_them.shape[0]) if p != row]
        if averages.has_force:
            return Curve(spectra.freq_hz, auto, what, all_of_them[-1], "the force")
        if others:
            best = max(others, key=lambda p: float(np.median(all_of_them[p])))
            return Curve(spectra.freq_hz, auto, what, all_of_them[best], f"dof {source.dofs[best]}")
    return Curve(spectra.freq_hz, auto, what)


MOST_VALUES = 6  # singular values that are drawn at most; further ones lie in the noise with them


def evidence_figure(
    zeros: AntiresonanceSet,
    dof: Any,
    curve: Curve | None = None,
    band_hz: tuple[float, float] | None = None,
    *,
    every_kind: bool = False,
) -> Any:
    """Diagram, curve, coherence and singular values of a response, as far as they are there."""
    live.require_bokeh()
    from bokeh.models import Range1d

    diagram, check = zeros.diagrams.get(dof), zeros.data_check
    band = band_hz or (diagram.band_hz if diagram is not None else _around(zeros))
    x = Range1d(*band, bounds=None)
    marks = mark_columns(zeros, dof, band)
    figures: list[Any] = []

    def curve_figure(
        name: str, freq_hz: FloatArray, y: FloatArray, axis: Axis, says: Any, height: int, **look: Any
    ) -> None:
        shown = (freq_hz >= band[0]) & (freq_hz <= band[1])
        line = Line(freq_hz[shown], y[shown], says={"Frequency": "@x{0.000} Hz"} | says, **look)
        panel = Panel(name, Axis("Frequency (Hz)"), axis, [line])
        figures.append(live.explored(panel, height=height, x_range=x))

    if diagram is not None:
        figures.append(stabilization_figure(diagram, zeros, dof, x_range=x, every_kind=every_kind))
    if curve is not None:
        size, says = np.where(curve.size > 0.0, curve.size, np.nan), {"Size": "@y{0.000e+0}"}
        look = {"colour": "blue", "label": "measured"}
        curve_figure("curve", curve.freq_hz, size, Axis(curve.what, log=True), says, 300, **look)
        _mark_lines(figures[-1], marks, every_kind=every_kind)
        figures[-1].legend.visible = diagram is None
        if curve.coherence is not None:
            axis = Axis(f"Coherence with {curve.coherence_with} (-)", (0.0, 1.04))
            says = {"Coherence": "@y{0.000}"}
            curve_figure("coherence", curve.freq_hz, curve.coherence, axis, says, 180, width=0.9)
    if not figures:  # the set was made by hand or loaded
        alone = Panel("values_alone", Axis("Frequency (Hz)"), Axis("", (0.0, 1.0), at=[]), [])
        figures.append(live.explored(alone, height=240, x_range=x))
        _mark_lines(figures[0], marks, labels=True, every_kind=every_kind)
        live.below(figures[0])
    elif check is not None and check.eigenvalues is not None:
        figures.append(live.explored(singular_values(check, MOST_VALUES), height=270, x_range=x))
    return live.stacked(figures)


def _around(zeros: AntiresonanceSet) -> tuple[float, float]:
    """A band that shows all values of the set, so that it is the same for every response."""
    values = [freq for one in (zeros, zeros.original()) for each in one.values() for freq in each]
    if not values:
        return 0.0, 100.0
    low, high = min(values), max(values)
    return max(0.0, low - 0.1 * (high - low + low)), high + 0.1 * (high - low + low)
