r"""Are all channels on one clock and of one kind?

On a lightly damped structure all responses at one line are in phase or against phase, whatever the force;
only within the width of its own antiresonance does a channel turn from one to the other. A channel that was
sampled later turns against the others in proportion to frequency; one of another kind (a velocity among
accelerations) stands at right angles. Twice the phase does not know the sign, so a channel p is compared with
the others by

    z_p(f) = sum_q u_pq^2,   u_pq the phase factor of the cross spectrum of p and q,

over all other q that are coherent with p at that line, one vote each; the delay t and offset c are those that
maximise abs(sum_f z_p exp(2i (2 pi f t - c))). Polarity cannot be seen: a sensor upside down is at half a
turn, like a mode shape with a node in between.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..support.validation import ComplexArray, FloatArray
from .evidence import Evidence
from .findings import Finding, NotTested, Said

TIME_SHIFT, QUADRATURE = "time_shift", "quadrature"
# Coherence of two channels from which their phase counts: noise alone reaches it once in 1,000 lines at ten
# averages.
LEAST_COHERENCE = 0.5
LEAST_LINES = 32
# Signal-to-noise power for the same where there is nothing to average.
SINGLE_SNR = 10.0
# Share of the votes, and of the lines, that must agree on a delay and an offset for either to mean something.
AGREEMENT = 0.7
# Phase (degrees) at the band's upper edge from which a delay is named. Damping of 2 % looks like 30 degrees
# on the ends of a chain; identification itself bears any delay that is short beside a segment.
SHIFT_DEG = 60.0
QUADRATURE_DEG = 40.0
# Phase (degrees) from one end of the lines to the other below which no delay is fitted. In a narrow band an
# antiresonance turns the phase as far, and the line through it would be extended from there down to 0 Hz.
TURN_DEG = 60.0
# Candidate delays are at most this part of the time that the spacing of the lines resolves.
SPAN = 0.25
# Zero padding of the transform that scans the delays.
PADDING = 8


class _Fit(NamedTuple):
    """Delay in s, offset in degrees (-90 to 90), and the number of lines that tell."""

    delay: float
    offset: float
    lines: int


def in_phase(seen: Evidence) -> Said:
    """Delay and right-angle tests of every channel against the others."""
    if len(seen.dofs) < 2:
        why = "a single channel has nothing to be compared with"
        return [NotTested(TIME_SHIFT, why), NotTested(QUADRATURE, why)]
    left = list(range(len(seen.dofs)))
    votes = _votes(seen)
    found: Said = []
    # The worst channel first, and without it again: a late channel makes the others look early.
    while len(left) > 1:
        fits = {p: _fit(seen, votes, p, [q for q in left if q != p]) for p in left}
        known = {p: fit for p, fit in fits.items() if fit is not None}
        if not known and not found:
            why = "too few lines at which the channels rise out of their noise in phase or against phase"
            return [NotTested(TIME_SHIFT, why), NotTested(QUADRATURE, why)]
        off = {p: fit for p, fit in known.items() if _badness(fit, seen) >= 1.0}
        if not off:
            break
        worst = max(off, key=lambda p: off[p].lines * min(_badness(off[p], seen), 2.0))
        if len(left) == 2:
            found.append(_finding(seen, tuple(left), off[worst]))
            break
        found.append(_finding(seen, (worst,), off[worst]))
        left.remove(worst)
    return found


def _votes(seen: Evidence) -> ComplexArray:
    """Squared phase factors of all pairs, (n_freq, n, n), zero where two channels are not coherent."""
    if seen.matrix is None:
        noisy = np.abs(seen.vectors) ** 2 < SINGLE_SNR
        cross = seen.vectors[:, :, None] * seen.vectors[:, None, :].conj()
        deaf = noisy[:, :, None] | noisy[:, None, :]
    else:
        cross = seen.matrix
        auto = np.einsum("fii->fi", cross).real
        deaf = np.abs(cross) ** 2 < LEAST_COHERENCE * auto[:, :, None] * auto[:, None, :]
    size = np.maximum(np.abs(cross), 1e-300)
    return np.asarray(np.where(deaf, 0.0, (cross / size) ** 2), dtype=np.complex128)


def _fit(seen: Evidence, votes: ComplexArray, p: int, others: list[int]) -> _Fit | None:
    """Channel p against others, or None where the lines do not agree."""
    cast = votes[:, p, others]
    total, count = cast.sum(axis=1), np.count_nonzero(cast, axis=1)
    # Two votes at least, where there can be two: one other channel may itself be the one that is off.
    heard = (count >= min(2, len(others))) & (np.abs(total) > AGREEMENT * count)
    if heard.sum() < LEAST_LINES:
        return None
    freq = seen.freq_hz[heard]
    z = total[heard] / np.abs(total[heard])
    delay = _delay(freq, z)
    if 360.0 * abs(delay) * float(freq[-1] - freq[0]) < TURN_DEG:
        delay = 0.0
    mean = np.mean(z * np.exp(4j * np.pi * freq * delay))
    if np.abs(mean) < AGREEMENT:
        return None
    return _Fit(delay, float(np.degrees(0.5 * np.angle(mean))), freq.size)


def _delay(freq: FloatArray, z: ComplexArray) -> float:
    """Delay (s) that brings the doubled phases together: one transform, then parabolas."""
    spacing = float(np.diff(freq).min())
    index = np.rint((freq - freq[0]) / spacing).astype(int)
    n = PADDING * int(2 ** np.ceil(np.log2(index[-1] + 1)))
    grid = np.zeros(n, dtype=np.complex128)
    np.add.at(grid, index, z)
    size = np.abs(np.fft.ifft(grid))
    size[int(SPAN * n) : n - int(SPAN * n)] = 0.0
    best = int(np.argmax(size))
    step = 1.0 / (2.0 * spacing * n)
    delay = step * (best - n if best > n // 2 else best)
    for width in (step, step / 4, step / 16):
        three = [abs(np.exp(4j * np.pi * t * freq) @ z) for t in (delay - width, delay, delay + width)]
        bend = three[0] - 2.0 * three[1] + three[2]
        if bend < 0.0:
            delay += width * float(np.clip(0.5 * (three[0] - three[2]) / bend, -1.0, 1.0))
    return delay


def _shift_deg(fit: _Fit, seen: Evidence) -> float:
    return 360.0 * abs(fit.delay) * float(seen.freq_hz[-1])


def _badness(fit: _Fit, seen: Evidence) -> float:
    return max(_shift_deg(fit, seen) / SHIFT_DEG, abs(fit.offset) / QUADRATURE_DEG)


def _finding(seen: Evidence, where: tuple[int, ...], fit: _Fit) -> Finding:
    dofs = tuple(seen.dofs[p] for p in where)
    name = " and ".join(repr(dof) for dof in dofs)
    who = f"Dof {name} is" if len(dofs) == 1 else f"One of dofs {name} is"
    delay, offset = fit.delay, fit.offset
    if abs(offset) > QUADRATURE_DEG:
        text = (
            f"{who} at right angles to the other channels (phase {offset:+.0f} degrees, delay "
            f"{1e3 * delay:+.3g} ms): it looks like another kind of quantity, a velocity among "
            "accelerations."
        )
        return Finding(
            QUADRATURE,
            "warning",
            dofs,
            abs(offset),
            QUADRATURE_DEG,
            text,
            "Check the sensor and its conditioning; convert all channels to one kind.",
        )
    samples = "" if seen.fs_hz is None else f", {delay * seen.fs_hz:+.2f} samples"
    sense = "late" if delay > 0 else "early"
    text = (
        f"{who} {sense} against the other channels by {1e3 * abs(delay):.3g} ms{samples}: "
        f"{_shift_deg(fit, seen):.0f} degrees at {seen.freq_hz[-1]:g} Hz."
    )
    return Finding(
        TIME_SHIFT,
        "warning",
        dofs,
        delay,
        SHIFT_DEG / 360.0 / float(seen.freq_hz[-1]),
        text,
        "Check that all channels share one clock and one filter, or shift it back.",
    )
