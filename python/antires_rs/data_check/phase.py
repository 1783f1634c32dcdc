r"""Are all channels on one clock and of one kind?

A channel that was sampled later turns against the others in proportion to frequency; one of another kind (a
velocity among accelerations) stands at right angles. What it takes to say so is more than a phase that is
off: real structures have channels, near a clamp for instance, whose phase is off at every resonance. A
finding needs a delay, or a right angle, that brings the channel back into the common phase (``agreement``)
about as well as the other channels keep it, at so many modes that random phases would not do so: the bound of
that probability, times the number of channels of this structure that are out of phase without such a reason,
has to be small.

Polarity cannot be seen: a sensor upside down is at half a turn, like a mode shape with a node in between.
"""

from __future__ import annotations

import numpy as np

from .agreement import Agreement, Fit
from .evidence import Evidence
from .findings import Finding, NotTested, Said

TIME_SHIFT, QUADRATURE = "time_shift", "quadrature"
# Phase (degrees) at the band's upper edge from which a delay is named. Damping of 2 % looks like 30 degrees
# on the ends of a chain; identification itself bears any delay that is short beside a segment.
SHIFT_DEG = 60.0
# Limit of the offset that a finding states.
QUADRATURE_DEG = 45.0
# A channel is out of phase below this agreement (33 degrees of scatter), ...
IN_PHASE = 0.7
# ... and a delay or an offset explains it if it mends so much of the agreement, ...
MENDED = 0.3
# ... leaves at most so many times the disagreement of the median channel, ...
AS_THE_OTHERS = 3.0
# ... which is taken to be no less than this (a scatter of 13 degrees in doubled phase), ...
LEAST_SCATTER = 0.05
# ... and is expected so often, at most, of channels whose phase means nothing.
FALSE_ALARMS = 0.1


def in_phase(seen: Evidence) -> Said:
    """Delay and right-angle tests of every channel against the others."""
    if len(seen.dofs) < 2:
        why = "a single channel has nothing to be compared with"
        return [NotTested(TIME_SHIFT, why), NotTested(QUADRATURE, why)]
    left = list(range(len(seen.dofs)))
    found: Said = []
    # The worst channel first, and without it again: a late channel makes the others look early.
    while len(left) > 1:
        fits = _fits(seen, left)
        if not fits and not found:
            why = "at too few lines do the channels rise out of their noise in phase or against phase"
            return [NotTested(TIME_SHIFT, why), NotTested(QUADRATURE, why)]
        off = sorted((p for p, fit in fits.items() if _is_off(seen, fit)), key=lambda p: fits[p].chance)
        worst = next((p for p in off if _proved(fits[p], _without(seen, left, p))), None)
        if worst is None:
            break
        found.append(_finding(seen, tuple(left) if len(left) == 2 else (worst,), fits[worst]))
        if len(left) == 2:
            break
        left.remove(worst)
    return found


def _fits(seen: Evidence, channels: list[int]) -> dict[int, Fit]:
    lines = Agreement(seen, channels)
    fits = {p: lines.fit(i, SHIFT_DEG) for i, p in enumerate(channels)}
    return {p: fit for p, fit in fits.items() if fit is not None}


def _without(seen: Evidence, channels: list[int], p: int) -> dict[int, Fit]:
    """What the others say of each other; of two no one knows which is off."""
    others = [q for q in channels if q != p]
    return _fits(seen, others) if len(others) > 2 else {}


def _is_off(seen: Evidence, fit: Fit) -> bool:
    mended = fit.fits >= IN_PHASE and fit.fits - fit.in_phase >= MENDED and fit.chance < FALSE_ALARMS
    return mended and (fit.quadrature or _shift_deg(seen, fit) >= SHIFT_DEG)


def _proved(fit: Fit, others: dict[int, Fit]) -> bool:
    """Whether the fit is as good as the others' phases, and no chance among so many that are off."""
    kept = [other.in_phase for other in others.values()]
    astray = sum(each < IN_PHASE for each in kept)
    scatter = max(1.0 - float(np.median(kept)), LEAST_SCATTER) if kept else 1.0
    return (astray + 0.5) * fit.chance <= FALSE_ALARMS and 1.0 - fit.fits <= AS_THE_OTHERS * scatter


def _shift_deg(seen: Evidence, fit: Fit) -> float:
    return 360.0 * abs(fit.delay_s) * float(seen.freq_hz[-1])


def _finding(seen: Evidence, where: tuple[int, ...], fit: Fit) -> Finding:
    dofs = tuple(seen.dofs[p] for p in where)
    name = " and ".join(repr(dof) for dof in dofs)
    who = f"Dof {name} is" if len(dofs) == 1 else f"One of dofs {name} is"
    modes = f"{fit.modes} modes" if fit.modes > 1 else "1 mode"
    if fit.quadrature:
        text = (
            f"{who} at right angles to the other channels at {modes}: it looks like another kind of "
            "quantity, a velocity among accelerations."
        )
        return Finding(
            QUADRATURE,
            "warning",
            dofs,
            90.0,
            QUADRATURE_DEG,
            text,
            "Check the sensor and its conditioning; convert all channels to one kind.",
            f"at right angles to the other channels at {modes}",
        )
    samples = "" if seen.fs_hz is None else f", {fit.delay_s * seen.fs_hz:+.2f} samples"
    brief = (
        f"{'late' if fit.delay_s > 0 else 'early'} against the other channels by "
        f"{1e3 * abs(fit.delay_s):.3g} ms{samples}"
    )
    return Finding(
        TIME_SHIFT,
        "warning",
        dofs,
        fit.delay_s,
        SHIFT_DEG / 360.0 / float(seen.freq_hz[-1]),
        f"{who} {brief}: {_shift_deg(seen, fit):.0f} degrees at {seen.freq_hz[-1]:g} Hz.",
        "Check that all channels share one clock and one filter, or shift it back.",
        brief,
    )
