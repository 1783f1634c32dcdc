"""Measured FRFs and transmissibilities, with those of the model before and after."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from ..signals.frequency_response import FrequencyResponse
from ..signals.transfer_functions import transmissibility_sum
from ..support.checks import FloatArray
from .canvas import band_shown, draw, new_axes
from .marks import Axis, Line, Mark, Panel, Rules

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

MOST_RESPONSES = 6  # responses that a picture has room for
KINDS = ("accelerance", "mobility", "receptance")
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
    """Draw ``abs(H_ik)`` in dB, as measured and as the models have it; antiresonances are the dips.

    Responses one above the other, the first on top, shifted so that they do not overlap; lines across
    are 20 dB apart. Whether acceleration, velocity or displacement was measured, and in which unit, is
    taken from what fits the model's curves best.

    Parameters
    ----------
    measured : FrequencyResponse
        Of ``kind="frf"``, its dofs being dofs of the models.
    before, after : StructuralModel
        The nominal and the updated model; ``after`` may be None.
    excitation : int
        Dof of the force.
    dofs : sequence of int, optional
        Responses drawn, each with a level of its own; by default the first six.
    damping_ratio : float or array_like, (n_modes,)
        Modal damping of the models, which an updating does not find. It sets the depth of dips and the height
        of peaks, not their place.
    band_hz : (low, high), optional
        Lines drawn; all of the data by default.
    names : (str, str)
        What the two models are called.

    Raises
    ------
    InvalidInputError
        Transmissibilities instead of FRFs, a dof that was not measured.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from matplotlib.figure import Figure
    >>> chain = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 500.0])
    >>> rec = chain.simulate(excitation=0, fs_hz=20.0, duration_s=60.0, damping_ratio=0.01, rng=0)
    >>> h = ar.frf(rec, nperseg=256)
    >>> ar.figures.plot_responses(h, chain, excitation=0, ax=Figure().subplots()).get_xlabel()
    'Frequency (Hz)'
    """
    chosen = list(measured.dofs)[:MOST_RESPONSES] if dofs is None else list(dofs)
    unknown = [dof for dof in chosen if dof not in measured.dofs]
    if unknown:
        reject("dofs", unknown, f"some of {list(measured.dofs)}", "Name dofs that were measured.")
    models = [before] + ([] if after is None else [after])
    freq, levels = curves_db(measured, models, excitation, damping_ratio=damping_ratio, band_hz=band_hz)
    called = curve_names(names, after is not None)
    table: dict[str, Any] = {"freq_hz": freq}
    marks: list[Mark] = []
    places, top = [], 0.0
    for nth, dof in enumerate(chosen):
        own = [level[list(measured.dofs).index(dof)] for level in levels]
        low, high = float(np.min(own[0])), float(np.max(own[0]))
        shift = -high if nth == 0 else top - high
        places.append(0.5 * (low + high) + shift)
        for level, name, look in zip(own, called, LOOKS, strict=False):
            # What goes far below the measured curve would run through the response underneath.
            shown = np.where(level < low - 15.0, np.nan, level) + shift
            marks.append(Line(freq, shown, label=name if nth == 0 else None, **look))
            table[f"{name.replace(' ', '_')}_{dof}_db"] = level
        top = low + shift - 12.0
    rules = Rules(np.arange(0.0, top, -20.0), colour="#EBEBEB", width=0.6)
    x, y = (
        Axis("Frequency (Hz)", (freq[0], freq[-1])),
        Axis("FRF, each shifted (dB)", names=[before.dof_label(dof) for dof in chosen], at=places),
    )
    panel = Panel("response", x, y, [rules, *marks], grid="x", tables={"responses": table})
    ax = draw(panel, new_axes(ax, (9.0, 2.0 + 1.2 * len(chosen))))
    ax.set_ylim(top - 4.0, None)
    return ax


def curve_names(names: tuple[str, str], both: bool) -> list[str]:
    """What the curves are called, of ``both`` models or one."""
    return ["measured", *(f"model {name}" for name in names)] if both else ["measured", "model"]


def curves_db(
    measured: FrequencyResponse,
    models: Sequence[StructuralModel],
    excitation: int,
    *,
    damping_ratio: Any = 0.01,
    band_hz: Sequence[float] | None = None,
) -> tuple[FloatArray, list[FloatArray]]:
    """Lines in Hz, and levels in dB of the measured FRFs and of each model, (n_dofs, n_freq)."""
    _of_kind(measured, "frf")
    low, high = band_shown(measured.freq_hz, band_hz)
    keep = (measured.freq_hz >= low) & (measured.freq_hz <= high) & (measured.freq_hz > 0.0)
    freq, own = measured.freq_hz[keep], _level(measured.values[:, keep])
    dofs, damping = list(measured.dofs), {"damping_ratio": damping_ratio}
    shapes = [_level(np.atleast_2d(one.frf(dofs, excitation, freq, **damping))) for one in models]
    # Receptance and mobility from accelerance, in dB: by 1 / w once or twice.
    fall = 20.0 * np.log10(2.0 * np.pi * freq)
    options = [own - (shapes[-1] - times * fall) for times in range(len(KINDS))]
    best = int(np.argmin([float(np.std(gap)) for gap in options]))
    gap = float(np.median(options[best]))
    level = gap if abs(gap) > 6.0 else 0.0
    return freq, [own, *(shape - best * fall + level for shape in shapes)]


def _of_kind(measured: Any, kind: str) -> None:
    """Refuse anything but responses of a kind."""
    if not isinstance(measured, FrequencyResponse) or measured.kind != kind:
        got = getattr(measured, "kind", type(measured).__name__)
        reject("measured", got, f"a FrequencyResponse of kind {kind!r}", f"Estimate it by antires_rs.{kind}.")


def _level(values: Any) -> FloatArray:
    return np.asarray(20.0 * np.log10(np.maximum(np.abs(values), 1e-15)))


# -- Transmissibility: measured, and of the model before and after updating


def plot_transmissibility(
    measured: FrequencyResponse,
    before: StructuralModel,
    after: StructuralModel | None = None,
    *,
    dof: int | None,
    excitation: int,
    damping_ratio: Any = 0.01,
    band_hz: Sequence[float] | None = None,
    ax: Any = None,
    names: tuple[str, str] = ("before updating", "after updating"),
) -> Any:
    """Draw ``abs(T_pj)`` in dB, as measured and as the models have it.

    Its peaks are the antiresonances of the reference j, whatever p.

    Parameters
    ----------
    measured : FrequencyResponse
        Of ``kind="transmissibility"``, its dofs being dofs of the models.
    dof : int or None
        Response p; None draws the sum over all of them (:func:`~antires_rs.transmissibility_sum`).
    before, after, excitation, damping_ratio, band_hz, names
        As in :func:`plot_responses`.

    Raises
    ------
    InvalidInputError
        FRFs instead of transmissibilities, a dof that was not measured or is the reference itself.

    Examples
    --------
    >>> import antires_rs as ar
    >>> from matplotlib.figure import Figure
    >>> chain = ar.MassSpringChain([1.0, 1.0, 1.0], [500.0, 500.0])
    >>> rec = chain.simulate(excitation=0, fs_hz=20.0, duration_s=60.0, damping_ratio=0.01, rng=0)
    >>> t = ar.transmissibility(rec, 0, nperseg=256)
    >>> ar.figures.plot_transmissibility(t, chain, dof=2, excitation=0, ax=Figure().subplots()).get_ylabel()
    '|T| of dof 2 over dof 0 (dB re 1)'
    """
    panel = transmissibilities(measured, before, after, dof, excitation, damping_ratio, band_hz, names)
    return draw(panel, new_axes(ax, (9.0, 4.5)))


def transmissibilities(
    measured: FrequencyResponse,
    before: StructuralModel,
    after: StructuralModel | None,
    dof: int | None,
    excitation: int,
    damping_ratio: Any = 0.01,
    band_hz: Sequence[float] | None = None,
    names: tuple[str, str] = ("before updating", "after updating"),
) -> Panel:
    """One of them, or the sum over all dofs."""
    _of_kind(measured, "transmissibility")
    others = [d for d in measured.dofs if d != measured.reference]
    if dof is not None and dof not in others:
        wanted = f"one of {others}, or None for their sum"
        reject("dof", dof, wanted, "The reference over itself is one everywhere.")
    freq = measured.freq_hz
    low, high = band_shown(freq, band_hz)
    # A free structure moves without bound at 0 Hz.
    keep = (freq >= low) & (freq <= high) & (freq > 0.0)
    freq, dofs, reference = freq[keep], measured.dofs, measured.reference
    curves = [measured.values[:, keep]]
    for model in (before, after):
        if model is not None:
            h = model.frf(list(dofs), excitation, freq, damping_ratio=damping_ratio)
            curves.append(h / h[dofs.index(reference)])
    levels = []
    for one in curves:
        ratios = FrequencyResponse(freq, one, dofs, "transmissibility", reference)
        levels.append(_level(transmissibility_sum(ratios) if dof is None else one[dofs.index(dof)]))
    called = curve_names(names, after is not None)
    columns = {f"level_{i}": level for i, level in enumerate(levels)}
    says = {"Frequency": "@x{0.000} Hz"} | {name: f"@level_{i}{{0.0}} dB" for i, name in enumerate(called)}
    rows = zip(levels, called, LOOKS, strict=False)
    marks = [Line(freq, level, label=name, **look) for level, name, look in rows]
    marks[0] = replace(marks[0], says=says, more=columns)
    what = "Sum of T" if dof is None else f"|T| of {dof_name(before, dof)}"
    table = {"freq_hz": freq} | dict(zip(("measured_db", "before_db", "after_db"), levels, strict=False))
    x, y = Axis("Frequency (Hz)", (low, high)), Axis(f"{what} over {dof_name(before, reference)} (dB re 1)")
    return Panel("response", x, y, marks, grid="both", tables={"transmissibility": table})


def dof_name(model: StructuralModel, dof: Any) -> str:
    """A dof as the tables name it."""
    return str(model.dof_name(dof)) if hasattr(model, "dof_name") else f"dof {dof}"
