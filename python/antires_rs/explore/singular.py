"""Singular values of the responses by frequency: is it one force, and where do the modes lie."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..signals.frequency_response import FrequencyResponse
from ..support.validation import FloatArray
from .canvas import COLOURS, below, columns, hover, paper

__all__ = ["singular_values_figure"]

#: The others are drawn up to this many; further ones lie in the noise with them.
OTHERS = 6


def singular_values_figure(
    check: Any, response: FrequencyResponse | None, band_hz: tuple[float, float], *, x_range: Any = None
) -> Any | None:
    """Singular values of the spectral matrix of a record; of responses to one force, the only one.

    Parameters
    ----------
    check : DataCheck or None
        Of a record with several averages it has the spectral matrix.
    response : FrequencyResponse or None
        Used where there is no spectral matrix: its column of responses has one singular value, its norm.
    band_hz : (low, high)
    x_range : range of another figure, optional
        To tie the two together.

    Returns
    -------
    bokeh.plotting.figure or None
        None where neither is there.
    """
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
