"""Is the resolution enough for the damping, and the record long enough for the resolution?"""

from __future__ import annotations

import numpy as np

from ..support.checks import FloatArray
from .averaging import BANDWIDTHS, NARROWEST, SEGMENTS, narrow_width, standing_peaks
from .findings import Finding, NotTested, Said, Severity, rounded

RESOLUTION, LENGTH, AVERAGES = "resolution", "record_length", "averages"
# Lines per half-power bandwidth of the sharp resonances, for averaged segments, whose leakage fills what is
# narrower than a line. On the 8-mass chain two were enough for all 28 values to 1e-3; one gave false ones now
# and then, half a line gave several in every run.
ENOUGH, TOO_FEW = 2.0, 1.0
# Whole impacts and measured responses have no leakage; what is narrower than two lines is poorly sampled.
ENOUGH_WITHOUT_LEAKAGE = 0.5
# Width that a pure tone has through a Hann window.
TONE = 0.95
# Bandwidth over what the top of a resonance, cut off at a tenth of its height, measures.
TOP = 1.6
# Widths are trusted from so many lines on.
TRUSTED = 4.0
# Independent averages below which noise and coherence are guesses.
LEAST_AVERAGES = 6.0
# Lines in the band below which nothing can be said by line.
LEAST_LINES = 8


def sharpest_lines(power: FloatArray, leakage: bool = True) -> float | None:
    """Half-power bandwidth of the sharp resonances in lines, or None if nothing stands out."""
    if power.size < LEAST_LINES:
        return None
    if not leakage:
        widths = [_width_at(power, peak) for peak in standing_peaks(power)]
        return float(np.quantile(widths, NARROWEST)) if widths else None
    width = narrow_width(power)
    return None if width is None else max(TOP * (width - TONE), 0.0)


def _width_at(power: FloatArray, peak: int) -> float:
    """Half-power bandwidth in lines from three lines of a resonance, however coarse they are.

    The inverse of the power of one mode is a parabola, a ((f - f0)^2 + (B / 2)^2).
    """
    left, middle, right = 1.0 / np.maximum(power[peak - 1 : peak + 2], 1e-300)
    bend = 0.5 * (left + right) - middle
    least = middle - (right - left) ** 2 / (16.0 * bend)
    return float(2.0 * np.sqrt(max(least, 0.0) / bend))


def of_segments(
    bandwidth_hz: float | None,
    spacing_hz: float,
    duration_s: float,
    *,
    longer: bool,
    chosen: bool,
    known: bool,
) -> Said:
    """Lines per bandwidth of averaged segments, and what would mend it.

    ``longer``: the record allows longer segments. ``chosen``: these were not the user's, so that leaving the
    choice is no advice. ``known``: the bandwidth was resolved; otherwise it is an upper limit.
    """
    if bandwidth_hz is None:
        return [_nothing_sharp()]
    lines = bandwidth_hz / spacing_hz
    if lines >= ENOUGH:
        return []
    severity: Severity = "fatal" if lines < TOO_FEW else "warning"
    width = (
        f"{rounded(bandwidth_hz)} Hz wide at half power"
        if known
        else f"not resolved (narrower than about {rounded(max(bandwidth_hz, spacing_hz))} Hz at half power)"
    )
    seen = (
        f"the sharp resonances are {width}, the lines {spacing_hz:.3g} Hz apart. That is "
        f"{'' if known else 'at most '}{lines:.1f} lines per bandwidth; {ENOUGH:g} are needed, "
        f"{BANDWIDTHS:g} are good."
    )
    wanted_s = BANDWIDTHS / max(bandwidth_hz, 0.5 * spacing_hz)
    if longer:
        leave_it = "" if chosen else ", or let nperseg=None choose"
        return [
            Finding(
                RESOLUTION,
                severity,
                (),
                lines,
                ENOUGH,
                "The resolution is too coarse: " + seen,
                f"Use longer segments, of {rounded(wanted_s)} s{leave_it}.",
            )
        ]
    constants = np.pi * bandwidth_hz * duration_s
    # With as few lines as are needed; more are better. Segments are powers of two, which may fall short of a
    # record that is long enough by this count.
    least_s = SEGMENTS * wanted_s * ENOUGH / BANDWIDTHS
    return [
        Finding(
            LENGTH,
            severity,
            (),
            lines,
            ENOUGH,
            f"The record of {duration_s:.3g} s is too short: {seen} It holds {constants:.0f} time "
            "constants of these resonances.",
            (
                f"Record {'' if known else 'at least '}{rounded(least_s)} s, better "
                if least_s > duration_s
                else "Record for longer, at best "
            )
            + f"{rounded(SEGMENTS * wanted_s)} s.",
        )
    ]


def without_leakage(bandwidth_hz: float | None, spacing_hz: float, *, hit: bool) -> Said:
    """The same for whole impacts and for measured responses."""
    if bandwidth_hz is None:
        return [_nothing_sharp()]
    lines = bandwidth_hz / spacing_hz
    if lines >= ENOUGH_WITHOUT_LEAKAGE:
        return []
    limit = ENOUGH_WITHOUT_LEAKAGE
    wanted_hz = max(bandwidth_hz, 0.25 * spacing_hz) / ENOUGH
    seen = (
        f"the sharp resonances are about {rounded(bandwidth_hz)} Hz wide at half power, the lines "
        f"{spacing_hz:.3g} Hz apart; {limit:g} lines per bandwidth is the least."
    )
    if hit:
        return [
            Finding(
                LENGTH,
                "warning",
                (),
                lines,
                limit,
                f"The record after the impact ({1.0 / spacing_hz:.3g} s) is too short: {seen}",
                f"Record until the response has died, for some {rounded(1.0 / wanted_hz)} s.",
            )
        ]
    return [
        Finding(
            RESOLUTION,
            "warning",
            (),
            lines,
            limit,
            f"The resolution is too coarse: {seen}",
            f"Measure with lines {rounded(wanted_hz)} Hz apart.",
        )
    ]


def averages(n_averages: float, duration_s: float, nperseg: int) -> Said:
    """Enough averages to tell noise from signal?"""
    if n_averages >= LEAST_AVERAGES:
        return []
    return [
        Finding(
            AVERAGES,
            "warning",
            (),
            n_averages,
            LEAST_AVERAGES,
            f"Segments of {nperseg} samples leave {n_averages:.1f} independent averages in "
            f"{duration_s:.3g} s; {LEAST_AVERAGES:g} are needed for noise and coherence to mean "
            "something.",
            "Use shorter segments, or record for longer.",
        )
    ]


def too_few_lines(n_lines: int, band: tuple[float, float]) -> Finding:
    """A band with hardly a line in it."""
    return Finding(
        RESOLUTION,
        "fatal",
        (),
        float(n_lines),
        LEAST_LINES,
        f"Only {n_lines} lines lie in {band[0]:g}-{band[1]:g} Hz, {LEAST_LINES} being the least.",
        "Widen the band, or use longer segments.",
    )


def _nothing_sharp() -> NotTested:
    return NotTested(RESOLUTION, "no resonance stands out of the band by 10 dB")
