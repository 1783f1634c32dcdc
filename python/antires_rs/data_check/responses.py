"""The tests that measured frequency responses allow."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..signals.frequency_response import FrequencyResponse
from ..signals.roughness import roughness
from . import channels, force_location, one_force, phase, resolution
from .evidence import Evidence, of_curves
from .findings import Finding, NotTested, Said

# Roughness from line to line over the power of a curve above which it is noise, white noise having one; if
# another curve is smooth: lines too far apart make all of them rough.
ROUGH, SMOOTH = 0.5, 0.1
# Coherence below which a line is more noise than response.
COHERENT = 0.5


def of_response(
    resp: FrequencyResponse, excitation: Any, band: tuple[float, float]
) -> tuple[Said, Evidence | None]:
    """What the tests say, and the evidence of those by line, if there is any."""
    why = "needs time records"
    said: Said = [NotTested(name, why) for name in (channels.CLIPPED, channels.DROPOUTS, channels.SPIKES)]
    inside = (resp.freq_hz >= band[0]) & (resp.freq_hz <= band[1]) & (resp.freq_hz > 0.0)
    by_line = (
        phase.TIME_SHIFT,
        phase.QUADRATURE,
        channels.NOISE,
        resolution.RESOLUTION,
        one_force.NAME,
        force_location.NAME,
    )
    if inside.sum() < resolution.LEAST_LINES:
        said.append(resolution.too_few_lines(int(inside.sum()), band))
        return said + [NotTested(name, "too few lines in the band") for name in by_line], None
    values = resp.values[:, inside]
    rough = np.array([roughness(curve) for curve in values])
    live = []
    for p, dof in enumerate(resp.dofs):
        if not values[p].any():
            said.append(
                Finding(
                    channels.DEAD,
                    "fatal",
                    (dof,),
                    0.0,
                    0.0,
                    f"Dof {dof!r} is zero throughout the band.",
                    channels.DEAD_ADVICE,
                    "zero throughout the band",
                )
            )
        elif rough[p] > ROUGH and rough.min() < SMOOTH:
            text = (
                f"Dof {dof!r} holds only noise in the band: from line to line it changes as much as "
                f"white noise does ({rough[p]:.2f} of its power, limit {ROUGH:g})."
            )
            said.append(
                Finding(
                    channels.DEAD,
                    "fatal",
                    (dof,),
                    float(rough[p]),
                    ROUGH,
                    text,
                    channels.DEAD_ADVICE,
                    f"only noise in the band ({rough[p]:.2f} of its power)",
                )
            )
        else:
            live.append(p)
    if rough.min() >= SMOOTH and np.median(rough) > ROUGH:
        text = (
            f"The curves change from line to line as white noise does ({np.median(rough):.2f} of their "
            f"power, limit {ROUGH:g}): they are noise, or their lines too far apart."
        )
        said.append(
            Finding(
                resolution.RESOLUTION,
                "fatal",
                (),
                float(np.median(rough)),
                ROUGH,
                text,
                "Measure with a finer resolution, or force harder.",
            )
        )
    if not live:
        return said + [NotTested(name, "no channel holds a response") for name in by_line], None
    dofs = tuple(resp.dofs[p] for p in live)
    seen = of_curves(
        resp.freq_hz[inside],
        values[live],
        dofs,
        None if resp.coherence is None else resp.coherence[live][:, inside],
    )
    twice, _ = channels.duplicated(np.hstack([values[live].real, values[live].imag]), dofs)
    said += [*twice, *phase.in_phase(seen), *_incoherent(seen), *one_force.one_force(seen)]
    if resp.kind == "transmissibility":
        why = (
            "peaks of transmissibilities are antiresonances of the reference, as sharp as noise lets them be"
        )
        said.append(NotTested(resolution.RESOLUTION, why))
        said.append(NotTested(force_location.NAME, "transmissibilities do not show the resonances"))
        return said, seen
    spacing = float(np.median(np.diff(seen.freq_hz)))
    power = np.abs(values[live]) ** 2
    lines = resolution.sharpest_lines(
        np.sum(power / power.mean(axis=1, keepdims=True), axis=0), leakage=False
    )
    said += resolution.without_leakage(None if lines is None else lines * spacing, spacing, hit=False)
    said += force_location.force_location(seen, excitation, values[live])
    return said, seen


def _incoherent(seen: Evidence) -> Said:
    if seen.coherence is None:
        return [NotTested(channels.NOISE, "no coherence is given with the responses")]
    share = np.mean(seen.coherence < COHERENT, axis=1)
    return [
        Finding(
            channels.NOISE,
            "note",
            (dof,),
            float(part),
            channels.BURIED,
            f"Dof {dof!r} has a coherence under {COHERENT:g} in {100 * part:.0f} % of the band.",
            channels.BURIED_ADVICE,
            f"coherence under {COHERENT:g} in {100 * part:.0f} % of the band",
        )
        for dof, part in zip(seen.dofs, share, strict=True)
        if part > channels.BURIED
    ]
