"""From lines to stabilization diagrams, window by window, by either formulation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from ..support.checks import FloatArray
from ..support.messages import warn
from ..support.progress import step
from ..support.values import frozen
from .dips import unexplained, without_common
from .lines import FORCE, Lines
from .options import IdentificationOptions
from .paper import sweep_of
from .scores import scored
from .selection import select
from .stabilization import PoleSweep, StabilizationDiagram, ZeroSweep, add_persistent, diagram, join, windows
from .windows import HIGHEST_ORDER, LINES_PER_ORDER, SCALES, local_diagrams


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


# -- Which fit suits the lines, and which options count for it
#
# Curves and records may be identified by one call with the same options, and by one job: what has no effect
# is said, not refused.


#: Options of the sweep over orders alone, and of the fits over windows alone.
OF_SWEEP = ("damping_tol", "min_rows", "min_dominance", "persistent")
OF_WINDOWS = ("min_share", "min_depth_db")
#: What either listens to.
OF_BOTH = ("freq_tol", "max_damping")
#: With fewer lines there is no window of the narrow scale, and no fit that others could confirm.
FEW_LINES = SCALES[-1][1]


def settled(options: IdentificationOptions, lines: Lines) -> IdentificationOptions:
    """The options with the formulation that "auto" means for these lines."""
    formulation = options.formulation
    if formulation == "auto":
        averaged = lines.segments is not None
        formulation = "windows" if not averaged else "numerators" if options.estimator == "rank1" else "joint"
    if formulation == "windows":
        idle = [name for name in OF_SWEEP if name in options.given]
        if "max_order" in options.given and options.max_order > HIGHEST_ORDER:
            idle.append(f"max_order above {HIGHEST_ORDER}")
        if options.min_order > HIGHEST_ORDER:
            idle.append(f"min_order above {HIGHEST_ORDER}")
        fit = "fits over windows (formulation 'windows': given curves and single impacts)"
        counts = [*OF_BOTH, *OF_WINDOWS, f"orders up to {HIGHEST_ORDER}"]
    else:
        options.rule.check_span(*options.orders)
        idle = [name for name in OF_WINDOWS if name in options.given]
        fit = f"the sweep over orders (formulation {formulation!r})"
        counts = [*OF_BOTH, *OF_SWEEP, "min_order", "max_order"]
    if idle:
        verb = "has" if len(idle) == 1 else "have"
        warn(
            "no_effect",
            f"identify_antiresonances: {' and '.join(idle)} {verb} no effect on {fit}; what counts there is "
            f"{', '.join(counts)}.",
        )
    if formulation == "windows" and lines.freq_hz.size < FEW_LINES:
        warn("few_lines", f"identify_antiresonances: {_of_few_lines(lines)}")
    return replace(options, formulation=formulation)


def _of_few_lines(lines: Lines) -> str:
    count, width = lines.freq_hz.size, float(lines.freq_hz[-1] - lines.freq_hz[0])
    return (
        f"the band holds {count} lines, which carry {count // LINES_PER_ORDER} orders; fits over windows "
        f"want {FEW_LINES} lines or more, else antiresonances are missed or misplaced. Measure with lines "
        f"{width / FEW_LINES:.2g} Hz apart or finer; if the band holds one mode alone, widen it."
    )
