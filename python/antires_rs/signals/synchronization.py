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

from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..support.checks import ComplexArray, FloatArray
from .findings import Finding, NotTested, Said
from .one_force import Evidence

# -- How well a channel keeps the common phase, and how sure that is
#
# Where the modes are real all responses at one line are in phase or against phase. That holds at the
# resonances of any lightly damped structure; between them, near clamps and at nodes, what is left may be
# noise, cross-talk or the imaginary part of the modes, and its phase means nothing. So a line speaks about
# channel p only where
#
# - the *others* are in phase or against phase among themselves, in power, each at its typical share of the
#   line (the shares are those of the direction of the vector of responses, which FRFs and transmissibilities
#   have in common);
# - p itself takes part: it has at least half of its typical share of the line. A channel that follows no
#   resonance falls below it exactly there.
#
# Twice the phase, which does not know the sign, is compared: z_p = exp(2i (phase of p - phase of the
# others)). Neighbouring lines of one direction are one mode, and one piece of evidence, however many they
# are. For a delay t and an offset c the agreement is
#
#     R(t, c) = mean over modes of the mean over their lines of Re(z_p exp(2i (2 pi f t - c)))
#
# and, by Chernoff's bound, n modes of random phase reach R with a probability of at most exp(-n I(R)), times
# the number of independent delays up to t that were tried.
#
# Reference: K. V. Mardia and P. E. Jupp, Directional Statistics, 2000, ch. 4 (sums of random phases).


# Signal-to-noise power of an averaged line from which its phase counts: an error of 13 degrees.
LEAST_SNR = 10.0
# The others agree on a line if doubled phases leave this part of their power: a scatter of 13 degrees.
COMMON = 0.9
# Where there are several others, no line is judged by one of them alone.
LEAST_OTHERS = 1.5
# Least share of a line, of the typical one, with which a channel takes part; largest that counts, so that
# none speaks for all.
LEAST_SHARE, LARGEST_SHARE = 0.5, 2.0
# Cosine between the directions of two lines below which they are two modes (60 degrees).
SAME_MODE = 0.5
# Lines that make a mode, and in all.
LINES_OF_MODE, LEAST_LINES = 3, 8
# Delays are at most this part of the time that the spacing of the lines resolves.
SPAN = 0.25
# Zero padding of the transform that scans the delays.
PADDING = 4


class Fit(NamedTuple):
    """What the lines say of one channel.

    Attributes
    ----------
    in_phase : float
        R without delay and offset: 1 for a channel that keeps the common phase.
    fits : float
        R with the delay and the offset found.
    delay_s : float
    quadrature : bool
        Whether the offset is a right angle.
    chance : float
        Bound of the probability that random phases fit as well.
    modes : int
    """

    in_phase: float
    fits: float
    delay_s: float
    quadrature: bool
    chance: float
    modes: int


class Agreement:
    """Which lines speak about which of some channels, and what they say.

    Parameters
    ----------
    seen : Evidence
    channels : list of int
        Those that are compared, n of them.
    """

    def __init__(self, seen: Evidence, channels: list[int]) -> None:
        self.freq_hz = seen.freq_hz
        vectors = seen.vectors[:, channels]
        size = np.abs(vectors)
        unit = vectors / np.maximum(size, 1e-300)
        level = np.log(np.maximum(size, 1e-300))
        level -= np.median(level, axis=1, keepdims=True)
        level -= np.median(level, axis=0)
        loud = size**2 * seen.n_averages >= LEAST_SNR
        share = np.where(loud, np.exp(np.minimum(level, 10.0)), 0.0)
        power = np.minimum(share, LARGEST_SHARE) ** 2
        doubled = unit**2
        common, total, squares = (
            part.sum(axis=1, keepdims=True) - part for part in (power * doubled, power, power**2)
        )
        agreed = (np.abs(common) >= COMMON * total) & (total > 0.0)
        if len(channels) > 2:
            agreed &= total**2 >= LEAST_OTHERS * squares
        #: Lines that speak about each channel, (n_freq, n), and what they say.
        self.heard = agreed & (share >= LEAST_SHARE)
        self.votes: ComplexArray = doubled * np.conj(common / np.maximum(np.abs(common), 1e-300))
        direction = np.sqrt(power) * unit
        direction /= np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-300)
        self._mode = _modes(direction, self.heard.any(axis=1))

    def fit(self, p: int, largest_turn_deg: float) -> Fit | None:
        """The likeliest delay and offset of channel ``p``; None where too few lines speak.

        An offset of a right angle is another kind of quantity, which has no delay beyond ``largest_turn_deg``
        at the highest line.
        """
        lines = np.flatnonzero(self.heard[:, p])
        if lines.size:
            counts = np.bincount(self._mode[lines])
            lines = lines[counts[self._mode[lines]] >= LINES_OF_MODE]
        if lines.size < LEAST_LINES:
            return None
        _, mode, counts = np.unique(self._mode[lines], return_inverse=True, return_counts=True)
        weighted = self.votes[lines, p] / (counts.size * counts[mode])
        freq = self.freq_hz[lines]
        delays, sums = _scanned(freq, weighted, float(np.diff(self.freq_hz).min()))
        tried = np.log1p(4.0 * np.abs(delays) * float(freq[-1] - freq[0]))
        late = _log_chance(sums.real, counts.size) + tried
        short = 360.0 * np.abs(delays) * float(self.freq_hz[-1]) <= largest_turn_deg
        turned = np.where(short, _log_chance(-sums.real, counts.size), 0.0)
        quadrature = bool(turned.min() < late.min())
        best = int(np.argmin(turned if quadrature else late))
        sign = -1.0 if quadrature else 1.0
        return Fit(
            float(weighted.real.sum()),
            float(sign * sums.real[best]),
            _refined(freq, sign * weighted, float(delays[best]), float(delays[1] - delays[0])),
            quadrature,
            float(np.exp(turned[best] if quadrature else late[best])),
            int(counts.size),
        )


def _modes(direction: ComplexArray, used: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Number of the mode that each used line belongs to, -1 for the others."""
    mode = np.full(used.size, -1)
    first, number = None, -1
    for i in np.flatnonzero(used):
        if first is None or abs(np.vdot(first, direction[i])) < SAME_MODE:
            first, number = direction[i], number + 1
        mode[i] = number
    return mode


def _scanned(
    freq_hz: FloatArray, weighted: ComplexArray, spacing_hz: float
) -> tuple[FloatArray, ComplexArray]:
    """Delays in s, and the sum of the votes brought together by each: one transform."""
    index = np.rint((freq_hz - freq_hz[0]) / spacing_hz).astype(int)
    n = PADDING * int(2 ** np.ceil(np.log2(index[-1] + 2)))
    grid = np.zeros(n, dtype=np.complex128)
    np.add.at(grid, index, weighted)
    sums = np.fft.ifft(grid) * n
    sums = np.fft.fftshift(sums)
    steps = np.arange(n) - n // 2
    allowed = np.abs(steps) <= SPAN * n
    delays = steps[allowed] / (2.0 * spacing_hz * n)
    return delays, sums[allowed] * np.exp(4j * np.pi * delays * freq_hz[0])


def _refined(freq_hz: FloatArray, weighted: ComplexArray, delay: float, step: float) -> float:
    """The delay between those of the scan, by parabolas."""
    for width in (step, step / 4.0, step / 16.0):
        left, middle, right = (
            float((np.exp(4j * np.pi * t * freq_hz) @ weighted).real)
            for t in (delay - width, delay, delay + width)
        )
        bend = left - 2.0 * middle + right
        if bend < 0.0:
            delay += width * float(np.clip(0.5 * (left - right) / bend, -1.0, 1.0))
    return delay


@cache
def _rates() -> tuple[FloatArray, FloatArray]:
    """R and its rate I(R) = sup (s R - ln I0(s)), by their common parameter s."""
    from scipy.special import i0e, i1e  # slow to import

    s = np.geomspace(1e-3, 1e4, 400)
    r = i1e(s) / i0e(s)
    return r, s * r - (np.log(i0e(s)) + s)


def _log_chance(r: FloatArray, modes: int) -> FloatArray:
    """Bound of the logarithm of the probability that the mean of so many random cosines reaches r."""
    return np.asarray(-modes * np.interp(r, *_rates()), dtype=np.float64)


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
