"""Measured FRFs and transmissibilities, with those of the model before and after."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.transfer_functions import transmissibility_sum
from ..support.checks import FloatArray, label_text
from .canvas import band_shown, draw, new_axes
from .marks import Axis, Line, Mark, Panel, Rules

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["plot_responses"]

MOST_RESPONSES = 6  # responses that a picture has room for
_INTEGRATED = range(3)  # times that accelerance, mobility and receptance were integrated
#: Of the measured curve, and of the model before and after.
LOOKS: tuple[dict[str, Any], ...] = ({"colour": "#BDBDBD", "width": 3.2},)
LOOKS += ({"colour": "vermillion", "dash": "--"}, {"colour": "blue"})


def plot_responses(
    measured: FrequencyResponse,
    before: StructuralModel,
    after: StructuralModel | None = None,
    *,
    excitation: int,
    dofs: Sequence[int] | None = None,
    damping_ratio: Any = 0.01,
    band_hz: Sequence[float] | None = None,
    ax: Any = None,
    names: tuple[str, str] = ("before updating", "after updating"),
) -> Any:
    """Draw FRFs or transmissibilities in dB, as measured and as the models have them.

    Responses one above the other, the first on top, shifted so that they do not overlap; lines across are
    20 dB apart. Antiresonances are the dips of FRFs, and the peaks of transmissibilities are those of their
    reference. Whether acceleration, velocity or displacement was measured, and in which unit, is taken from
    what fits the models' FRFs best.

    Parameters
    ----------
    measured : FrequencyResponse
        Its dofs being dofs of the models.
    before, after : StructuralModel
        The nominal and the updated model; ``after`` may be None.
    excitation : int
    dofs : sequence of int, optional
        Responses drawn; by default the first six FRFs, or :func:`~antires_rs.transmissibility_sum`.
    damping_ratio : float or array_like, (n_modes,)
        Modal damping of the models, which sets the depth of dips and the height of peaks, not their place.
    band_hz : (low, high), optional
        Lines drawn; all of the data by default.
    names : (str, str)
        What the two models are called.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> t = ar.transmissibility(case.experiment(duration_s=60.0, rng=0), 0, nperseg=4096)
    >>> ar.figures.plot_responses(t, case.model, dofs=[2], excitation=0).get_ylabel()
    'dof 2 over dof 0 (dB)'
    """
    models = [before] if after is None else [before, after]
    panel = responses(measured, models, excitation, dofs, names, damping_ratio=damping_ratio, band_hz=band_hz)
    return draw(panel, new_axes(ax, (9.0, 2.0 + 1.2 * max(len(panel.y.names or ()), 2))))


def responses(
    measured: FrequencyResponse,
    models: Sequence[StructuralModel],
    excitation: int,
    dofs: Sequence[int] | None = None,
    names: tuple[str, str] = ("before updating", "after updating"),
    *,
    damping_ratio: Any = 0.01,
    band_hz: Sequence[float] | None = None,
) -> Panel:
    """The measured curves one above the other, with those of each model."""
    freq, labels, levels = _curves(measured, models, excitation, dofs, damping_ratio, band_hz)
    called = ["measured", *(f"model {name}" for name in names)] if len(models) > 1 else ["measured", "model"]
    alone = len(labels) == 1
    says = {"Frequency": "@x{0.000} Hz"} | {name: f"@level_{i}{{0.0}} dB" for i, name in enumerate(called)}
    marks: list[Mark] = []
    places, top = [], 0.0
    for nth, own in enumerate(zip(*levels, strict=True)):
        low, high = float(np.min(own[0])), float(np.max(own[0]))
        shift = 0.0 if alone else top - high
        places.append(0.5 * (low + high) + shift)
        told = {f"level_{i}": level for i, level in enumerate(own)}
        for level, name, look in zip(own, called, LOOKS, strict=False):
            # What goes far below the measured curve would run through the response underneath.
            shown = np.where((level < low - 15.0) & (not alone), np.nan, level) + shift
            more: dict[str, Any] = {"says": says, "more": told} if name == "measured" else {}
            marks.append(Line(freq, shown, label=name if nth == 0 else None, **look, **more))
        top = low + shift - 12.0
    y = Axis(f"{labels[0]} (dB)")
    if not alone:
        highest = max(float(np.nanmax(mark.y)) for mark in marks if isinstance(mark, Line))
        y = Axis("FRFs, each shifted (dB)", (top - 4.0, highest + 4.0), names=labels, at=places)
        marks.insert(0, Rules(np.arange(0.0, top, -20.0), colour="#EBEBEB", width=0.6))
    x, grid = Axis("Frequency (Hz)", (freq[0], freq[-1])), "both" if alone else "x"
    return Panel("response", x, y, marks, grid=grid)


def _curves(
    measured: FrequencyResponse,
    models: Sequence[StructuralModel],
    excitation: int,
    dofs: Sequence[int] | None,
    damping_ratio: Any,
    band_hz: Sequence[float] | None,
) -> tuple[FloatArray, list[str], list[FloatArray]]:
    """Lines, names of the responses, and levels in dB (n_dofs, n_freq): the measured ones, of each model."""
    if not isinstance(measured, FrequencyResponse):
        reject("measured", measured, "a FrequencyResponse", "Estimate it by antires_rs.frf.")
    every, reference = list(measured.dofs), measured.reference
    over = measured.kind == "transmissibility"
    shown = list(dofs) if dofs is not None else [] if over else every[:MOST_RESPONSES]
    others = [dof for dof in every if dof != reference]
    if unknown := [dof for dof in shown if dof not in others]:
        reject("dofs", unknown, f"some of {others}", "The reference over itself is one everywhere.")
    low, high = band_shown(measured.freq_hz, band_hz)
    # A free structure moves without bound at 0 Hz.
    keep = (measured.freq_hz >= low) & (measured.freq_hz <= high) & (measured.freq_hz > 0.0)
    freq = measured.freq_hz[keep]
    curves = [np.atleast_2d(one.frf(every, excitation, freq, damping_ratio=damping_ratio)) for one in models]
    if over:
        curves = [one / one[every.index(reference)] for one in curves]
    curves.insert(0, measured.values[:, keep])
    name = dof_name(models[0], reference) if over else ""
    if not shown:
        ratios = (FrequencyResponse(freq, one, every, "transmissibility", reference) for one in curves)
        sums = [_level(transmissibility_sum(one)[None]) for one in ratios]
        return freq, [f"Sum of transmissibilities over {name}"], sums
    levels = [_level(one) for one in curves]
    levels = levels if over else _as_measured(freq, levels)
    rows, label = [every.index(dof) for dof in shown], models[0].dof_label
    labels = [f"{dof_name(models[0], dof)} over {name}" if over else label(dof) for dof in shown]
    return freq, labels, [level[rows] for level in levels]


def _as_measured(freq: FloatArray, levels: list[FloatArray]) -> list[FloatArray]:
    """Accelerances of models as mobility or receptance, and in the unit, of the measured FRFs."""
    own, *shapes = levels
    fall = 20.0 * np.log10(2.0 * np.pi * freq)
    options = [own - (shapes[-1] - times * fall) for times in _INTEGRATED]
    best = int(np.argmin([float(np.std(gap)) for gap in options]))
    gap = float(np.median(options[best]))
    return [own, *(shape - best * fall + (gap if abs(gap) > 6.0 else 0.0) for shape in shapes)]


def _level(values: Any) -> FloatArray:
    return np.asarray(20.0 * np.log10(np.maximum(np.abs(values), 1e-15)))


def dof_name(model: StructuralModel, dof: Any) -> str:
    """A dof as the tables name it, or several of them."""
    name = model.dof_label if hasattr(model, "dof") else "dof {}".format
    return label_text(dof, lambda one: one if isinstance(one, str) else name(one))
