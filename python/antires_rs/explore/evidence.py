"""All figures that speak for the antiresonances of one response, on one frequency axis."""

from __future__ import annotations

from typing import Any

from ..measured.antiresonance_set import AntiresonanceSet
from ..signals.frequency_response import FrequencyResponse
from .canvas import below, paper, require_bokeh, stacked
from .curve import Curve, coherence_figure, curve_figure
from .marks import draw_marks, mark_columns
from .singular import singular_values_figure
from .stabilization import stabilization_figure

__all__ = ["evidence_figure"]


def evidence_figure(
    zeros: AntiresonanceSet,
    dof: Any,
    curve: Curve | None = None,
    response: FrequencyResponse | None = None,
    band_hz: tuple[float, float] | None = None,
    *,
    every_kind: bool = False,
) -> Any:
    """Diagram, curve, coherence and singular values of a response, as far as they are there.

    Parameters
    ----------
    zeros : AntiresonanceSet
    dof : int or str
        One of the set's.
    curve : Curve, optional
        What was measured there.
    response : FrequencyResponse, optional
        What the set was identified from, where it was no record.
    band_hz : (low, high), optional
        Shown at first; by default the band of the diagram, else around the values.
    every_kind : bool
        Have a place for values of every kind, for pages in which they change.

    Returns
    -------
    bokeh.models.Column
        Tied together: zooming one zooms all.
    """
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
