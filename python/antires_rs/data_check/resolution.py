"""Is the resolution enough for the damping, and the record long enough for the resolution?"""

from __future__ import annotations

import numpy as np

from .._validation import FloatArray
from ..segment_length import BANDWIDTHS, NARROWEST, SEGMENTS, _half_power_widths
from .findings import Finding, NotTested, Said, Severity

RESOLUTION, LENGTH, AVERAGES = "resolution", "record_length", "averages"
# Lines per half-power bandwidth of the sharp resonances. On the 8-mass chain two were enough for all 28 values
# to 1e-3; one gave false ones now and then, half a line gave several in every run.
ENOUGH, TOO_FEW = 2.0, 1.0
# What a pure tone through a Hann window measures, and what a resonance measures short of its bandwidth because
# only its top counts.
TONE_LINES, TOP = 0.95, 1.6
# Widths are trusted from so many lines on.
TRUSTED = 4.0
# Independent averages below which noise and coherence are guesses.
LEAST_AVERAGES = 6.0
# Lines in the band below which nothing can be said by line.
LEAST_LINES = 8


def sharpest_lines(power: FloatArray) -> float | None:
    """Half-power bandwidth of the sharp resonances in lines, or None if nothing stands out."""
    if power.size < 8:
        return None
    widths = _half_power_widths(power)
    if not widths:
        return None
    return float(max(TOP * (np.quantile(widths, NARROWEST) - TONE_LINES), 0.0))


def resolution(bandwidth_hz: float | None, spacing_hz: float, duration_s: float | None, *,
               adjustable: bool, known: bool = True) -> Said:
    """Lines per bandwidth, and what would mend it.

    ``adjustable``: the record allows longer segments. ``known``: the bandwidth was resolved; otherwise it is an
    upper limit.
    """
    if bandwidth_hz is None:
        return [NotTested(RESOLUTION, "no resonance stands out of the band by 10 dB")]
    lines = bandwidth_hz / spacing_hz
    if lines >= ENOUGH:
        return []
    severity: Severity = "fatal" if lines < TOO_FEW else "warning"
    width = f"{bandwidth_hz:.2g} Hz wide at half power" if known else (
        f"not resolved (below {max(bandwidth_hz, spacing_hz):.2g} Hz at half power)")
    seen = (f"the sharp resonances are {width}, lines {spacing_hz:.3g} Hz apart: {lines:.1f} lines per bandwidth, "
            f"{ENOUGH:g} being needed.")
    wanted_s = BANDWIDTHS / max(bandwidth_hz, 0.5 * spacing_hz)
    if duration_s is None:
        return [Finding(RESOLUTION, severity, (), lines, ENOUGH, "The resolution is too coarse: " + seen,
                        f"Measure with lines {1.0 / wanted_s:.2g} Hz apart or closer.")]
    constants = np.pi * bandwidth_hz * duration_s
    if adjustable:
        return [Finding(RESOLUTION, severity, (), lines, ENOUGH, "The resolution is too coarse: " + seen,
                        f"Use longer segments, of {wanted_s:.2g} s, or let nperseg=None choose.")]
    at_least = "" if known else "at least "
    return [Finding(LENGTH, severity, (), lines, ENOUGH,
                    f"The record of {duration_s:.3g} s is too short: " + seen[0].upper() + seen[1:] +
                    f" It holds {constants:.0f} time constants of these resonances.",
                    f"Record {at_least}{SEGMENTS * wanted_s:.2g} s.")]


def averages(n_averages: float, duration_s: float, nperseg: int) -> Said:
    """Enough averages to tell noise from signal?"""
    if n_averages >= LEAST_AVERAGES:
        return []
    return [Finding(AVERAGES, "warning", (), n_averages, LEAST_AVERAGES,
                    f"Segments of {nperseg} samples leave {n_averages:.1f} independent averages in "
                    f"{duration_s:.3g} s; {LEAST_AVERAGES:g} are needed for noise and coherence to mean "
                    "something.", "Use shorter segments, or record for longer.")]


def too_few_lines(n_lines: int, band: tuple[float, float]) -> Finding:
    """A band with hardly a line in it."""
    return Finding(RESOLUTION, "fatal", (), float(n_lines), LEAST_LINES,
                   f"Only {n_lines} lines lie in {band[0]:g}-{band[1]:g} Hz, {LEAST_LINES} being the least.",
                   "Widen the band, or use longer segments.")
