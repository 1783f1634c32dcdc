"""A measured curve, on its dips, with its coherence below it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..signals.averaging import Averages
from ..signals.estimators import two_channel
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..support.validation import FloatArray
from .canvas import COLOURS, below, columns, hover, paper
from .marks import draw_marks, mark_columns

__all__ = ["Curve", "coherence_figure", "curve_figure", "curve_of"]


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
    unit = "unit of the data x s" if averages.of_hits else "unit of the data/√Hz"
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
    """The curve of a response with its values marked: antiresonances stand at its dips.

    Parameters
    ----------
    curve : Curve
    zeros, dof : AntiresonanceSet, int or str
    band_hz : (low, high)
    x_range : range of another figure, optional
        To tie the two together.
    legend : bool
        Not needed under a diagram that has it.
    every_kind : bool
        Have a place for values of every kind, for pages in which they change.
    """
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
