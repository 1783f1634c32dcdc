"""From lines to stabilization diagrams, window by window, by either formulation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from ..order_sweep.diagram import PoleSweep, StabilizationDiagram, ZeroSweep, diagram
from ..order_sweep.peaks import unexplained
from ..order_sweep.persistence import add_persistent
from ..order_sweep.scores import scored
from ..order_sweep.shared import without_common
from ..order_sweep.windows import join, windows
from ..support.pickling import frozen
from ..support.progress import step
from ..support.validation import FloatArray
from .formulations import sweep_of
from .lines import FORCE, Lines
from .local.sweep import local_diagrams
from .options import IdentificationOptions
from .selection import select

__all__ = ["Fitted", "diagrams_of"]


@dataclass(frozen=True)
class Fitted:
    """Diagrams by dof; whether a fit of all numerators made them, and what kind of curve they speak of."""

    diagrams: dict[Any, StabilizationDiagram]
    of_numerators: bool
    sees: Literal["frf", "transmissibility"]


def diagrams_of(
    dofs: tuple[Any, ...],
    lines_for: Callable[[int], Lines],
    band: tuple[float, float],
    options: IdentificationOptions,
) -> Fitted:
    """One diagram for each of ``dofs``, by the formulation of the options, which is no longer "auto"."""
    first = lines_for(FORCE if options.use_force else 0)
    formulation = options.formulation
    if formulation == "windows":
        found = dict(zip(dofs, local_diagrams(first, len(dofs), band, options), strict=True))
    elif formulation == "numerators":
        found = _from_numerators(dofs, first, band, options)
    else:
        found = _one_by_one(dofs, lines_for, band, options, formulation)
    if not options.keep_common:
        found = without_common(found)
    for row, (dof, one) in enumerate(found.items()):
        peaks = unexplained(
            one.background_freq_hz,
            one.background,
            np.concatenate([one.identified, one.left_out.freq_hz]),
            first.channel_snr(row),
        )
        found[dof] = replace(one, unexplained_hz=frozen(peaks))
    of_responses = options.use_force or (formulation == "windows" and first.size is not None)
    return Fitted(found, formulation == "numerators", "frf" if of_responses else "transmissibility")


def _from_numerators(
    dofs: tuple[Any, ...], lines: Lines, band: tuple[float, float], options: IdentificationOptions
) -> dict[Any, StabilizationDiagram]:
    """All dofs from one fit a window."""
    cut = windows(lines.freq_hz, band)
    parts = [lines.part(w.first, w.last) for w in cut]
    found = [select(part, len(dofs), w, options) for part, w in zip(parts, cut, strict=True)]
    return {
        dof: join([d[row] for d in found], cut, band, options.rule.freq_tol) for row, dof in enumerate(dofs)
    }


def _one_by_one(
    dofs: tuple[Any, ...],
    lines_for: Callable[[int], Lines],
    band: tuple[float, float],
    options: IdentificationOptions,
    formulation: str,
) -> dict[Any, StabilizationDiagram]:
    """Every dof from its own joint fit of all T_pj; with a force, from one joint fit of all H_jk."""
    rule, use_force = options.rule, options.use_force
    found: dict[Any, StabilizationDiagram] = {}
    shared: dict[int, tuple[PoleSweep, range, FloatArray]] = {}
    # Dofs not asked for are looked at too: what all channels share is told only from all.
    for row, dof in enumerate(dofs):
        step(f"response {row + 1} of {len(dofs)}")
        below = FORCE if use_force else row
        lines = lines_for(below)
        cut = windows(lines.freq_hz, band)
        parts = []
        for window in cut:
            part = lines.part(window.first, window.last)
            if not use_force or window.first not in shared:
                shared[window.first] = sweep_of(part, below, *options.orders, rule, formulation)
            parent, swept, background = shared[window.first]
            sweep: PoleSweep = parent
            if use_force:
                background = 1.0 / np.maximum(np.abs(parent.nested.values[row]), 1e-300)
                sweep = ZeroSweep(parent, row)
            one = diagram(
                sweep, swept, window.report_hz, rule, part.freq_hz, background, part.added_decay_per_s
            )
            if rule.persistent:
                one = add_persistent(one, sweep, rule, part.channel_snr(row), part.added_decay_per_s)
            curves = sweep.curves(swept[len(swept) // 2])
            parts.append(replace(one, accepted=scored(one.accepted, part.freq_hz, background, *curves)))
        found[dof] = join(parts, cut, band, rule.freq_tol)
    return found
