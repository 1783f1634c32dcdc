"""Faults of single channels: dead, clipped, duplicated, interrupted, spiked, buried in noise."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..support.checks import ComplexArray, FloatArray, IntArray
from .averaging import (
    BANDWIDTHS,
    NARROWEST,
    SEGMENTS,
    fast_length,
    find_events,
    lowest_hz,
    narrow_width,
    owned_by_peaks,
    tail_noise,
    until_noise,
    without_drift,
)
from .findings import CheckResults, Finding, NotTested, Severity, rounded
from .hum import Hum
from .one_force import NOISE, Evidence
from .recording import Recording
from .spectra import CrossSpectra, pieces

DEAD, CLIPPED, DUPLICATED = "dead_channel", "clipped_channel", "duplicated_channels"
QUANTIZED = "quantized_channel"
DROPOUTS, SPIKES, HUM = "dropouts", "spikes", "mains_hum"
FORCE = "force"

# Part of a channel's range that counts as one level, and how many levels below the extreme are compared with
# it.
LEVEL = 1e-3
LEVELS_BELOW = 3
# A pile of so many samples at an extreme, this many times what the levels below hold, is a clipped one. A
# slow sine piles up by 3.
PILE, PILE_RATIO = 8, 5.0
MOSTLY_CLIPPED = 0.05  # share of clipped samples from which a channel tells nothing of the structure
# Steps of a converter between a channel's extremes below which it is told, and below which it says nothing.
FEW_STEPS, NO_STEPS = 24, 4
HIGH = 0.25  # extremes are looked for in this part of a channel's range
SAME = 1.0 - 1e-9  # correlation of two channels above which they are one signal
# Equal samples in a row that make a dropout, unless the digits are so coarse that this share repeat anyway.
RUN, REPEATED = 20, 0.01
# Second differences this far out, in robust standard deviations, are spikes: Gaussian ones never reach 8.
SPIKE_SIGMAS = 15.0
# ... of the record, and of so many samples on either side; so many are looked at.
BESIDE_SPIKE, MOST_SPIKES = 40, 1000
MEDIAN_SAMPLES = 16384  # so many second differences tell their standard deviation within a per cent
EXPLAINED = 0.25  # a channel of which others explain less of its power in the band carries no response
LEAST_AVERAGES = 4.0
DEAD_ADVICE = "Check sensor, cable and gain; leave the channel out."
# Share of the band that a channel may spend under its noise without a note, and the coherence below which a
# line is more noise than response.
BURIED, COHERENT = 0.25, 0.5


def in_time(rec: Recording, hits: bool) -> tuple[CheckResults, Recording | None]:
    """All tests of the samples; and the record without channels that are still or twice there."""
    data, labels = rec.responses, rec.dofs
    found, still = constant(data, labels)
    rows = [p for p in range(rec.n_channels) if p not in still]
    said: CheckResults = list(found)
    force = rec.force
    if force is not None and force.max() == force.min():
        text = "The force is recorded as a constant."
        advice = "Check its cable; antiresonances do not need it."
        said.append(Finding(DEAD, "warning", (FORCE,), 0.0, 0.0, text, advice))
        force = None
    if not rows:
        return said, None
    moving = data if not still else data[rows]
    names = tuple(labels[p] for p in rows)
    coarse = quantized(moving, names)
    few = {dof for one in coarse for dof in one.where}
    fine = {dof: x for dof, x in zip(names, moving, strict=True) if dof not in few}
    said += [*coarse, *clipped(fine.values(), tuple(fine))]
    if force is not None:
        said += clipped([force], (FORCE,))
    if hits:
        why = "in a record of impacts, rest and blows look like dropouts and spikes"
        said += [NotTested(DROPOUTS, why), NotTested(SPIKES, why)]
    else:
        said += interrupted(moving, names, rec.fs_hz)
    twice, extra = duplicated(moving, names)
    said += twice
    keep = [p for p in range(len(rows)) if p not in extra]
    if len(keep) == rec.n_channels and force is rec.force:
        return said, rec
    return said, Recording(moving[keep], rec.fs_hz, [names[p] for p in keep], force)


def constant(data: FloatArray, labels: tuple[Any, ...]) -> tuple[list[Finding], list[int]]:
    """Channels that never move; also their rows."""
    still = [p for p, x in enumerate(data) if x.max() == x.min()]
    found = []
    for p in still:
        brief = f"the constant {data[p, 0]:.3g}"
        text = f"Dof {labels[p]!r} gives {brief}: no signal at all."
        found.append(Finding(DEAD, "fatal", (labels[p],), 0.0, 0.0, text, DEAD_ADVICE, brief))
    return found, still


def clipped(data: Iterable[FloatArray], labels: tuple[Any, ...]) -> CheckResults:
    """Channels whose samples pile up at their largest or smallest value."""
    found: CheckResults = []
    for label, x in zip(labels, data, strict=True):
        low, high = float(x.min()), float(x.max())
        above, below = x[x >= high - HIGH * (high - low)], x[x <= low + HIGH * (high - low)]
        piles = {high: _pile(np.sort(above), high - low, x), low: _pile(np.sort(-below), high - low, x, -1.0)}
        count = sum(piles.values())
        if count == 0:
            continue
        share = count / x.size
        where = " and ".join(f"{value:.4g}" for value, pile in piles.items() if pile)
        text = f"Channel {label!r} is clipped at {where}: {count} samples, {100 * share:.2g} % of the record."
        advice = (
            "Lower the gain or the force and record again; clipping adds harmonics that look like "
            "noise of the channel."
        )
        brief = f"clipped at {where}, {100 * share:.2g} % of the record"
        severity: Severity = "fatal" if share > MOSTLY_CLIPPED else "warning"
        found.append(Finding(CLIPPED, severity, (label,), share, PILE / x.size, text, advice, brief))
    return found


def quantized(data: FloatArray, labels: tuple[Any, ...]) -> list[Finding]:
    """Channels that move over a few steps of their converter."""
    found = []
    for label, x in zip(labels, data, strict=True):
        if np.unique(x[: 8 * FEW_STEPS]).size > FEW_STEPS:
            continue
        levels = np.unique(x)
        steps = round((levels[-1] - levels[0]) / np.diff(levels).min(initial=np.inf))
        if steps < FEW_STEPS:
            brief = f"moves over {steps} steps of its converter"
            severity: Severity = "fatal" if steps < NO_STEPS else "warning"
            text = f"Channel {label!r} {brief}: what it measures less strongly is lost in rounding."
            advice = "Raise the gain or lower the range; weigh what this channel shows with care."
            found.append(Finding(QUANTIZED, severity, (label,), float(steps), FEW_STEPS, text, advice, brief))
    return found


def _pile(high: FloatArray, spread: float, x: FloatArray, sign: float = 1.0) -> int:
    """Samples at the largest of ``sign * x`` if they are a pile, else 0; ``high`` are its high ones."""
    largest = float(high[-1])
    steps = np.diff(high)
    steps = steps[steps > 1e-9 * spread]
    # Levels as wide as the digits of the converter, where these are coarse.
    level = max(LEVEL * spread, 1.5 * float(steps.min()) if steps.size else 0.0)
    count = int(np.count_nonzero(high >= largest - level))
    more = int(np.count_nonzero(high >= largest - (1 + LEVELS_BELOW) * level))
    if count < PILE or count <= PILE_RATIO * (more - count) / LEVELS_BELOW:
        return 0
    # Rest is no pile: the force between two impacts.
    return count if largest - sign * np.median(x) > level else 0


def duplicated(data: FloatArray, labels: tuple[Any, ...]) -> tuple[list[Finding], list[int]]:
    """Pairs of channels that are one signal up to a factor; also the rows to leave out."""
    mean = data.mean(axis=1, keepdims=True)
    products = np.zeros((len(data), len(data)))
    for some in pieces(data.shape[1], len(data)):
        moved = data[:, some] - mean
        products += moved @ moved.T
    norm = np.sqrt(np.diag(products))
    same = np.abs(products) / np.maximum(norm[:, None] * norm, 1e-300)
    found, extra = [], []
    for p, q in zip(*np.nonzero(np.triu(same > SAME, 1)), strict=True):
        if q in extra:
            continue
        extra.append(int(q))
        factor = float(products[p, q]) / float(norm[p]) ** 2
        brief = f"one signal, up to a factor of {factor:.4g}"
        text = f"Channels {labels[p]!r} and {labels[q]!r} hold {brief}."
        advice = "Check the wiring and the channel list; leave one of them out."
        where = (labels[p], labels[q])
        found.append(Finding(DUPLICATED, "warning", where, float(same[p, q]), SAME, text, advice, brief))
    return found, extra


def interrupted(data: FloatArray, labels: tuple[Any, ...], fs_hz: float) -> CheckResults:
    """Channels that stand still for a while within a steady record, or jump."""
    found: CheckResults = []
    for label, x in zip(labels, data, strict=True):
        step = np.diff(x)
        still = step == 0.0
        start, run = _longest_run(still)
        usual = still.mean() >= max(REPEATED, 2.0 * run / x.size)
        if run >= RUN and not usual and x.min() < x[start] < x.max():
            brief = f"still for {run} samples at {start / fs_hz:.3g} s"
            text = f"Channel {label!r} stands {brief}."
            advice = "Look for a loose contact or lost data; use the part of the record without it."
            found.append(Finding(DROPOUTS, "warning", (label,), float(run), RUN, text, advice, brief))
        second = np.diff(step)
        scale = float(np.median(np.abs(second[:: max(1, second.size // MEDIAN_SAMPLES)]))) / 0.6745
        largest = max(float(second.max()), -float(second.min()))
        if scale > 0.0 and largest > SPIKE_SIGMAS * scale:
            second = np.abs(second)
            at = np.argsort(-second)[: min(MOST_SPIKES, int(np.count_nonzero(second > SPIKE_SIGMAS * scale)))]
            # a record that grows, as in an earthquake, is all of a size with what is beside it.
            beside = np.clip(at[:, None] + np.arange(-BESIDE_SPIKE, BESIDE_SPIKE + 1), 0, second.size - 1)
            ratio = second[at] / np.maximum(scale, np.median(second[beside], axis=1) / 0.6745)
            off, count = float(ratio.max()), int(np.count_nonzero(ratio > SPIKE_SIGMAS))
            if not count:
                continue
            text = (
                f"Channel {label!r} jumps: {count} second differences lie beyond {SPIKE_SIGMAS:g} standard "
            )
            text += (
                f"deviations, the largest at {off:.0f}, {at[np.argmax(ratio)] / fs_hz:.3g} s into the record."
            )
            advice = "Look for loose contacts, electric switching or blows; use the part of the record "
            advice += "without them."
            brief = f"{count} jumps, the largest at {off:.0f} standard deviations"
            found.append(Finding(SPIKES, "warning", (label,), off, SPIKE_SIGMAS, text, advice, brief))
    return found


def _longest_run(still: Any) -> tuple[int, int]:
    """Start of the longest run of equal samples, and its length in samples."""
    if not still.any():
        return 0, 1
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    starts, lengths = edges[::2], edges[1::2] - edges[::2]
    best = int(np.argmax(lengths))
    return int(starts[best]), int(lengths[best]) + 1


def hum(found: Hum | None) -> CheckResults:
    """What was taken out of the record."""
    if found is None:
        return []
    where = " and ".join(f"{freq:g}" for freq in found.freq_hz)
    text = (
        f"Mains hum at {where} Hz, up to {100 * found.share:.2g} % of the rms of a channel "
        f"(dof {found.dof!r}). It was taken out, with the lines beside it."
    )
    advice = (
        "Look for ground loops, unshielded cables and lamps; an antiresonance at these lines is not seen."
    )
    return [Finding(HUM, "warning", (), found.share, 0.0, text, advice)]


#: Share of the power of all channels, each at its own mean, that is left beside one common motion.
ALIKE = 1e-3


def alike(seen: Evidence) -> CheckResults:
    """Channels that all do the same in the whole band."""
    unit = seen.vectors / np.maximum(np.sqrt(np.mean(np.abs(seen.vectors) ** 2, axis=0)), 1e-300)
    unit = unit / np.maximum(np.linalg.norm(unit, axis=1, keepdims=True), 1e-300)
    left = 1.0 - float(np.linalg.eigvalsh(unit.T @ unit.conj() / len(unit))[-1])
    if len(seen.dofs) < 2 or left > ALIKE:
        return []
    text = (
        f"All channels hold one signal, up to factors: over the whole band {100 * left:.2g} % of their power "
        "is anything else."
    )
    advice = "Check the wiring; what moves as one has no antiresonance: widen the band, or move the sensors."
    return [Finding(DUPLICATED, "fatal", (), left, ALIKE, text, advice)]


def unrelated(seen: Evidence) -> CheckResults:
    """Channels that share nothing with any other in the band: only noise."""
    if seen.explained is None:
        why = "one average does not tell a response from noise; constant channels are found"
        return [NotTested(DEAD, why)]
    if len(seen.dofs) < 2:
        return [NotTested(DEAD, "a single channel has nothing to be compared with; a constant one is found")]
    if seen.n_averages < LEAST_AVERAGES:
        count = f"{seen.n_averages:.1f} independent averages"
        return [NotTested(DEAD, f"{count} explain noise by noise; constant channels are found")]
    limit = max(EXPLAINED, 2.0 / seen.n_averages)  # Noise explains 1/n of noise.
    lost = [p for p, share in enumerate(seen.explained) if share < limit]
    if len(lost) == 2 and len(seen.dofs) == 2:
        text = (
            f"Dofs {seen.dofs[0]!r} and {seen.dofs[1]!r} have nothing in common in the band: either "
            f"explains {100 * seen.explained.max():.0f} % of the other's power. One of them, or both, "
            "hold only noise."
        )
        advice, most = "Check cables, sensors and the band.", float(seen.explained.max())
        return [Finding(DEAD, "fatal", seen.dofs, most, limit, text, advice)]
    found: CheckResults = []
    for p in lost:
        share = float(seen.explained[p])
        text = (
            f"Dof {seen.dofs[p]!r} holds only noise in the band: no other channel explains more than "
            f"{100 * share:.0f} % of its power (limit {100 * limit:.0f} %)."
        )
        brief = f"only noise in the band, of which no other explains more than {100 * share:.0f} %"
        found.append(Finding(DEAD, "fatal", (seen.dofs[p],), share, limit, text, DEAD_ADVICE, brief))
    return found


#: Power of the loudest line of a hit over noise, over the logarithm of the number of lines, of noise alone.
LOUDEST = 3.0


def silent(rec: Recording, band_hz: tuple[float, float]) -> list[Finding]:
    """Channels that a hit does not move from the band on; none where a record ends in ringing."""
    low_hz = lowest_hz(band_hz)
    event = find_events(rec, low_hz)[-1]
    x = without_drift(rec.responses, rec.fs_hz, low_hz)
    level, noise = tail_noise(rec, low_hz)
    stop = until_noise(x, event, level, rec.fs_hz)
    if stop >= event.stop:
        return []  # what follows is no noise
    cut = x[:, event.hit : max(stop, event.hit + 4 * LINES_OF_BAND)]
    taper = np.hanning(cut.shape[1])
    freq = np.fft.rfftfreq(cut.shape[1], 1.0 / rec.fs_hz)
    inside = freq >= low_hz  # between resonances a band may be as low as the noise
    power = np.abs(np.fft.rfft(cut * taper)[:, inside]) ** 2 / np.sum(taper**2)
    known = np.linspace(0.0, 0.5 * rec.fs_hz, noise.shape[1])
    limit = LOUDEST * np.log(max(int(inside.sum()), 3))
    found = []
    for dof, own, own_noise in zip(rec.dofs, power, noise, strict=True):
        most = float(np.max(own / np.interp(freq[inside], known, own_noise), initial=0.0))
        if most < limit:
            brief = "only noise in the band: the hit lifts no line of it over what follows"
            text = f"Dof {dof!r} holds {brief}."
            found.append(Finding(DEAD, "fatal", (dof,), most, limit, text, DEAD_ADVICE, brief))
    return found


DRIFTING = "drift"
DRIFT_GROUPS, PEAK_LINES = 8, 5  # groups of segments whose peaks are followed, and lines that a peak must own
#: Standard deviations of the mean change of all, and its size, as a share of the frequency, that are told.
DRIFT_SIGMAS, LEAST_DRIFT = 6.0, 2e-3


def drift(spectra: CrossSpectra) -> list[Finding]:
    """Whether resonances move from the first segments to the last: the mean frequency under each peak."""
    segments = spectra.segments
    if segments is None or spectra.draws is not None or segments.count < DRIFT_GROUPS:
        return []
    unit = (segments.unit * segments.scale) ** 2 / np.maximum(
        np.einsum("fii->i", spectra.matrix).real, 1e-300
    )
    values = np.ascontiguousarray(segments.values)
    parts = values.view(values.real.dtype).reshape(*values.shape, 2)  # real and imaginary
    groups = np.array_split(parts, DRIFT_GROUPS, axis=2)
    power = np.array([np.sum(np.einsum("fisc,fisc->fi", x, x) / x.shape[2] * unit, axis=1) for x in groups])
    at = np.linspace(-0.5, 0.5, DRIFT_GROUPS)
    changes, errors = [], []
    for low, peak, high in owned_by_peaks(power.mean(axis=0)):
        if high - low + 1 >= PEAK_LINES:
            own = power[:, low : high + 1]
            middle = own @ spectra.freq_hz[low : high + 1] / own.sum(axis=1) / spectra.freq_hz[peak]
            changes.append(at @ middle / (at @ at))
            rest = middle - middle.mean() - changes[-1] * at
            errors.append(np.sqrt(rest @ rest / (DRIFT_GROUPS - 2) / (at @ at)))
    if not changes:
        return []
    weights = 1.0 / np.maximum(errors, 1e-12) ** 2
    change = float(np.average(changes, weights=weights))
    if abs(change) * np.sqrt(weights.sum()) < DRIFT_SIGMAS or abs(change) < LEAST_DRIFT:
        return []
    text = (
        f"The resonances move by at least {100 * change:+.2g} % from the beginning of the record to its end."
    )
    advice = "Standard deviations hold it; identify parts of the record by themselves, or wait for rest."
    return [Finding(DRIFTING, "warning", (), abs(change), LEAST_DRIFT, text, advice)]


DOUBLE = "double_hit"
#: Blocks of samples in which second differences, where blows stand out of what rings, are followed; how many
#: times the highest of some blocks before, and which share of the first blow, another one has; until when.
BLOW_BLOCK, BLOCKS_BEFORE, BLOW_RISE, BLOW_SHARE, BLOWS_S = 4, 6, 3.0, 0.02, 1.5


def double_hits(rec: Recording, band_hz: tuple[float, float]) -> list[Finding]:
    """Impacts after which the hammer came back."""
    found = []
    for event in find_events(rec, lowest_hz(band_hz)):
        second = np.diff(rec.responses[:, max(event.hit - 4 * BLOW_BLOCK, 0) : event.stop], n=2, axis=1)
        energy = np.mean(second**2 / np.maximum(np.mean(second**2, axis=1, keepdims=True), 1e-300), axis=0)
        blocks = energy[: energy.size // BLOW_BLOCK * BLOW_BLOCK].reshape(-1, BLOW_BLOCK).mean(axis=1)
        first = int(np.argmax(blocks))
        last = min(blocks.size - 1, first + int(BLOWS_S * rec.fs_hz / BLOW_BLOCK))
        for b in range(first + 3, last):
            before = float(blocks[max(first + 1, b - BLOCKS_BEFORE) : b - 1].max())
            if blocks[b] > max(BLOW_RISE * before, BLOW_SHARE * blocks[first]):
                ms = 1e3 * (b - first) * BLOW_BLOCK / rec.fs_hz
                text = (
                    f"The hammer hit twice, {ms:.0f} ms apart, at {event.hit / rec.fs_hz:.3g} s: its force "
                    f"has dips every {1e3 / ms:.3g} Hz, at which all responses are small."
                )
                advice = "Hit again if values near these dips matter; the others are right."
                found.append(Finding(DOUBLE, "note", (), ms, 0.0, text, advice))
                break
    return found


BURIED_ADVICE = (
    "Antiresonances there come from the other channels or not at all; force harder or average longer."
)


def buried(seen: Evidence, skip: Container[Any] = (), *, by_coherence: bool = False) -> CheckResults:
    """Channels that spend much of the band under their noise; of measured responses by their coherence."""
    signal, least = (seen.coherence, COHERENT) if by_coherence else (seen.signal, 1.0)
    if signal is None:
        noise = "the noise of a single average is not known"
        why = "no coherence is given with the responses" if by_coherence else noise
        return [NotTested(NOISE, why)]
    brief = f"coherence under {COHERENT:g}" if by_coherence else "under its noise"
    text = f"has a {brief}" if by_coherence else "lies under its own noise"
    found: CheckResults = []
    for dof, share in zip(seen.dofs, np.mean(signal < least, axis=1).tolist(), strict=True):
        if share > BURIED and dof not in skip:
            where = f"in {100 * share:.0f} % of the band"
            parts = (f"Dof {dof!r} {text} {where}.", BURIED_ADVICE, f"{brief} {where}")
            found.append(Finding(NOISE, "note", (dof,), share, BURIED, *parts))
    return found


# -- Are all channels on one clock and of one kind?
#
# A channel that was sampled later turns against the others in proportion to frequency; one of another kind
# (a velocity among accelerations) stands at right angles. Real structures have channels whose phase is off at
# every resonance, so a finding needs a delay, or a right angle, that brings the channel back into the common
# phase about as well as the other channels keep it, at so many modes that random phases would not do so.
#
# A line speaks about channel p only where the *others* are in phase or against phase among themselves, in
# power, each at its typical share of the line, and where p has at least half of its typical share. Twice the
# phase, which does not know the sign, is compared: z_p = exp(2i (phase of p - phase of the others)).
# Neighbouring lines of one direction are one mode, and one piece of evidence. For a delay t and an offset c
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
LEAST_OTHERS = 1.5  # where there are several others, no line is judged by one of them alone
# Least share of a line, of the typical one, with which a channel takes part; largest that counts, so that
# none speaks for all.
LEAST_SHARE, LARGEST_SHARE = 0.5, 2.0
SAME_MODE = 0.5  # cosine between the directions of two lines below which they are two modes (60 degrees)
LINES_OF_MODE, LEAST_LINES = 3, 8  # lines that make a mode, and in all
SPAN = 0.25  # delays are at most this part of the time that the spacing of the lines resolves
PADDING = 4  # zero padding of the transform that scans the delays
MENDED = 0.3  # what a delay or an offset must add to the agreement of a channel with the others to explain it


class Fit(NamedTuple):
    """What the lines say of one channel."""

    in_phase: float  # R without delay and offset: 1 for a channel that keeps the common phase
    fits: float  # R with the delay and the offset found
    delay_s: float
    quadrature: bool  # whether the offset is a right angle
    chance: float  # bound of the probability that random phases fit as well
    modes: int


def _fits(seen: Evidence, channels: list[int]) -> dict[int, Fit]:
    """What the lines that speak about some channels, n of them, say of each; none where too few do."""
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
    heard = agreed & (share >= LEAST_SHARE)  # lines that speak about each channel, (n_freq, n)
    votes = doubled * np.conj(common / np.maximum(np.abs(common), 1e-300))  # what they say
    direction = np.sqrt(power) * unit
    direction /= np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-300)
    mode = _modes(direction, heard.any(axis=1))
    fits = {}
    for p, own, vote in zip(channels, heard.T, votes.T, strict=True):
        lines = np.flatnonzero(own)
        lines = lines[np.bincount(mode[lines], minlength=1)[mode[lines]] >= LINES_OF_MODE]
        if lines.size >= LEAST_LINES:
            fits[p] = _fit(seen.freq_hz, lines, mode[lines], vote[lines])
    return fits


def _fit(freq_hz: FloatArray, lines: IntArray, modes: IntArray, votes: ComplexArray) -> Fit:
    """The likeliest delay and offset of a channel; ``modes`` and ``votes`` of the lines that speak.

    An offset of a right angle, another kind of quantity, has no delay that turns the highest line by more
    than ``SHIFT_DEG``.
    """
    _, mode, counts = np.unique(modes, return_inverse=True, return_counts=True)
    weighted = votes / (counts.size * counts[mode])
    in_phase = float(weighted.real.sum())
    if in_phase > 1.0 - MENDED:  # no delay could mend so much
        return Fit(in_phase, in_phase, 0.0, False, 1.0, int(counts.size))
    freq = freq_hz[lines]
    delays, sums = _scanned(freq, weighted, float(np.diff(freq_hz).min()))
    tried = np.log1p(4.0 * np.abs(delays) * float(freq[-1] - freq[0]))
    late = _log_chance(sums.real, counts.size) + tried
    short = 360.0 * np.abs(delays) * float(freq_hz[-1]) <= SHIFT_DEG
    turned = np.where(short, _log_chance(-sums.real, counts.size), 0.0)
    quadrature = bool(turned.min() < late.min())
    best = int(np.argmin(turned if quadrature else late))
    sign = -1.0 if quadrature else 1.0
    return Fit(
        in_phase,
        float(sign * sums.real[best]),
        _refined(freq, sign * weighted, float(delays[best]), float(delays[1] - delays[0])),
        quadrature,
        float(np.exp(turned[best] if quadrature else late[best])),
        int(counts.size),
    )


def _modes(direction: ComplexArray, used: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Number of the mode that each used line belongs to, -1 for the others."""
    mode = np.full(used.size, -1)
    lines = np.flatnonzero(used)
    first, number = 0, 0
    while first < lines.size:
        end, some = first + 1, 16  # looked at some lines at a time, ever more
        while end < lines.size:
            others = np.abs(direction[lines[end : end + some]] @ direction[lines[first]].conj()) < SAME_MODE
            if others.any():
                end += int(np.argmax(others))
                break
            end, some = end + some, 2 * some
        mode[lines[first:end]] = number
        first, number = end, number + 1
    return mode


def _scanned(
    freq_hz: FloatArray, weighted: ComplexArray, spacing_hz: float
) -> tuple[FloatArray, ComplexArray]:
    """Delays in s, and the sum of the votes brought together by each: one transform."""
    index = np.rint((freq_hz - freq_hz[0]) / spacing_hz).astype(int)
    n = PADDING * int(2 ** np.ceil(np.log2(index[-1] + 2)))
    grid = np.zeros(n, dtype=np.complex128)
    np.add.at(grid, index, weighted)
    sums = np.fft.fftshift(np.fft.ifft(grid) * n)
    steps = np.arange(n) - n // 2
    allowed = np.abs(steps) <= SPAN * n
    delays = steps[allowed] / (2.0 * spacing_hz * n)
    return delays, sums[allowed] * np.exp(4j * np.pi * delays * freq_hz[0])


def _refined(freq_hz: FloatArray, weighted: ComplexArray, delay: float, step: float) -> float:
    """The delay between those of the scan, by parabolas."""
    for width in (step, step / 4.0, step / 16.0):
        near = np.array([delay - width, delay, delay + width])
        left, middle, right = (np.exp(4j * np.pi * near[:, None] * freq_hz) @ weighted).real.tolist()
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
QUADRATURE_DEG = 45.0  # limit of the offset that a finding states
IN_PHASE = 0.7  # a channel is out of phase below this agreement (33 degrees of scatter), ...
# ... and a delay or an offset explains it if it mends so much of the agreement (MENDED), ...
# ... leaves at most so many times the disagreement of the median channel, ...
AS_THE_OTHERS = 3.0
# ... which is taken to be no less than this (a scatter of 13 degrees in doubled phase), ...
LEAST_SCATTER = 0.05
FALSE_ALARMS = 0.1  # ... and is expected so often, at most, of channels whose phase means nothing.


def in_phase(seen: Evidence) -> CheckResults:
    """Delay and right-angle tests of every channel against the others."""
    if len(seen.dofs) < 2:
        why = "a single channel has nothing to be compared with"
        return [NotTested(TIME_SHIFT, why), NotTested(QUADRATURE, why)]
    left = list(range(len(seen.dofs)))
    found: CheckResults = []
    # The worst channel first, and without it again: a late channel makes the others look early.
    while len(left) > 1:
        fits = _fits(seen, left)
        if not fits and not found:
            why = "at too few lines do the channels rise out of their noise in phase or against phase"
            return [NotTested(TIME_SHIFT, why), NotTested(QUADRATURE, why)]
        # Channels whose phase a delay that matters, or a right angle, explains.
        mended = {p: fit for p, fit in fits.items() if fit.fits >= max(IN_PHASE, fit.in_phase + MENDED)}
        off = [p for p, fit in mended.items() if fit.quadrature or _shift_deg(seen, fit) >= SHIFT_DEG]
        off = sorted((p for p in off if fits[p].chance < FALSE_ALARMS), key=lambda p: fits[p].chance)
        # What the others say of each other; of two no one knows which is off.
        others = (_fits(seen, [q for q in left if q != p]) if len(left) > 3 else {} for p in off)
        worst = next((p for p, rest in zip(off, others, strict=True) if _proved(fits[p], rest)), None)
        if worst is None:
            break
        found.append(_finding(seen, tuple(left) if len(left) == 2 else (worst,), fits[worst]))
        if len(left) == 2:
            break
        left.remove(worst)
    return found


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
        advice = "Check the sensor and its conditioning; convert all channels to one kind."
        brief = f"at right angles to the other channels at {modes}"
        return Finding(QUADRATURE, "warning", dofs, 90.0, QUADRATURE_DEG, text, advice, brief)
    samples = "" if seen.fs_hz is None else f", {abs(fit.delay_s) * seen.fs_hz:.2f} samples"
    brief = (
        f"{'late' if fit.delay_s > 0 else 'early'} against the other channels by "
        f"{1e3 * abs(fit.delay_s):.3g} ms{samples}"
    )
    limit = SHIFT_DEG / 360.0 / float(seen.freq_hz[-1])
    text = f"{who} {brief}: {_shift_deg(seen, fit):.0f} degrees at {seen.freq_hz[-1]:g} Hz."
    advice = "Check that all channels share one clock and one filter, or shift it back."
    return Finding(TIME_SHIFT, "warning", dofs, fit.delay_s, limit, text, advice, brief)


# -- Did all channels start together, and stay together?
#
# Shifts of seconds, and clocks that drift, leave no phase in averaged spectra. Of two channels of one force
# the phase at a line of one long transform is 0 or a half turn, but for damping, and the turn of the shift;
# twice that phase, brought back to time, has one peak at twice the shift. Of n lines of noise no lag has more
# than some sqrt(ln n / n).

#: How many times what noise has at most the peak is, the parts of a record whose shifts differ where a clock
#: drifts, and the least such difference over the period of the band's upper edge.
PEAK_OVER_NOISE, CLOCK_PARTS, DRIFT = 3.0, 4, 0.25


def clocks(rec: Recording, band_hz: tuple[float, float]) -> CheckResults:
    """Channels that are seconds apart from the others, or whose shift changes within the record."""
    n, dofs = rec.n_samples // CLOCK_PARTS, rec.dofs
    ends = (slice(0, n), slice(rec.n_samples - n, rec.n_samples))
    whole, *parts = (_shifts_s(rec, some, band_hz) for some in (slice(None), *ends))
    found: CheckResults = []
    usual = np.nanmedian(whole) if np.isfinite(whole).sum() > 1 else np.nan
    limit = SHIFT_DEG / 360.0 / band_hz[1]
    for p, (at, early, late) in enumerate(zip(whole, *parts, strict=True)):
        if abs(late - early) > DRIFT / band_hz[1]:
            off = late - early
            brief = (
                f"on a clock of its own, {1e3 * early:.3g} ms off at first and {1e3 * late:.3g} ms at last"
            )
        elif abs(at - usual) > limit:
            off = at - usual
            brief = f"{'late' if off > 0 else 'early'} against the other channels by {abs(off):.3g} s"
        else:
            continue
        text = f"Dof {dofs[p]!r} is {brief}."
        found.append(Finding(TIME_SHIFT, "fatal", (dofs[p],), off, limit, text, CLOCK_ADVICE, brief))
    return found


CLOCK_ADVICE = "Record all channels on one clock, or bring them back to one before reading."


def _shifts_s(rec: Recording, some: slice, band_hz: tuple[float, float]) -> list[float]:
    """Shift of every channel against the strongest in a part of the record; NaN where none stands out."""
    x = rec.responses[:, some]
    n = x.shape[1]
    freq = np.fft.rfftfreq(n, 1.0 / rec.fs_hz)
    inside = np.flatnonzero((freq >= band_hz[0]) & (freq <= band_hz[1]))
    if inside.size < LINES_OF_BAND:
        return [np.nan] * rec.n_channels
    each = np.fft.rfft((x - x.mean(axis=1, keepdims=True)) * np.hanning(n))[:, inside]
    first = int(np.argmax(rec.responses.std(axis=1)))
    size = fast_length(4 * freq.size)
    shifts = []
    for own in each:
        doubled = np.zeros(size, dtype=np.complex128)
        doubled[inside] = np.exp(2j * np.angle(own * each[first].conj()))
        peak = np.abs(np.fft.ifft(doubled)) * size
        best = int(np.argmax(peak))
        turns = best - size * (best > size // 2)
        stands = peak[best] >= PEAK_OVER_NOISE * np.sqrt(inside.size * np.log(inside.size))
        shifts.append(0.5 * turns / size / float(freq[1]) if stands else np.nan)
    return shifts


# -- Is the resolution enough for the damping, and the record long enough for the resolution?

RESOLUTION, LENGTH, AVERAGES = "resolution", "record_length", "averages"
COARSE = "The resolution is too coarse: "
NOTHING_SHARP = NotTested(RESOLUTION, "no resonance stands out of the band by 10 dB")
# Lines per half-power bandwidth of the sharp resonances, for averaged segments, whose leakage fills what is
# narrower than a line. On the 8-mass chain two were enough for all 28 values to 1e-3; one gave false ones now
# and then, half a line gave several in every run.
ENOUGH, TOO_FEW = 2.0, 1.0
# Whole impacts and measured responses have no leakage; what is narrower than two lines is poorly sampled.
ENOUGH_WITHOUT_LEAKAGE = 0.5
TONE = 0.95  # width that a pure tone has through a Hann window
TOP = 1.6  # bandwidth over what the top of a resonance, cut off at a tenth of its height, measures
TRUSTED = 4.0  # widths are trusted from so many lines on
STEADY_AVERAGES = 6.0  # independent averages below which noise and coherence are guesses
LINES_OF_BAND = 8  # lines in the band below which nothing can be said by line


def sharpest_lines(power: FloatArray, leakage: bool = True) -> float | None:
    """Half-power bandwidth of the sharp resonances in lines, or None if nothing stands out."""
    if power.size < LINES_OF_BAND:
        return None
    if not leakage:
        widths = []
        for _, peak, _ in owned_by_peaks(power):
            # However coarse the lines are: the inverse of the power of one mode is a parabola,
            # a ((f - f0)^2 + (B / 2)^2).
            left, middle, right = 1.0 / np.maximum(power[peak - 1 : peak + 2], 1e-300)
            bend = 0.5 * (left + right) - middle
            least = middle - (right - left) ** 2 / (16.0 * bend)
            widths.append(float(2.0 * np.sqrt(max(least, 0.0) / bend)))
        return float(np.quantile(widths, NARROWEST)) if widths else None
    width = narrow_width(power)
    return None if width is None else max(TOP * (width - TONE), 0.0)


def of_segments(
    bandwidth_hz: float | None,
    spacing_hz: float,
    duration_s: float,
    *,
    longer: bool,
    chosen: bool,
    known: bool,
    weak_hit: Callable[[], bool],
) -> CheckResults:
    """Lines per bandwidth of averaged segments, and what would mend it."""
    # longer: the record allows longer segments. chosen: these were not the user's, so that leaving the choice
    # is no advice. known: the bandwidth was resolved; otherwise it is an upper limit. weak_hit: minutes more
    # of noise after a hit that was taken for steady vibration mend nothing.
    if bandwidth_hz is None:
        return [NOTHING_SHARP]
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
        advice = f"Use longer segments, of {rounded(wanted_s)} s{leave_it}."
        return [Finding(RESOLUTION, severity, (), lines, ENOUGH, COARSE + seen, advice)]
    constants = np.pi * bandwidth_hz * duration_s
    # With as few lines as are needed; more are better. Segments are powers of two, which may fall short of a
    # record that is long enough by this count.
    least_s = SEGMENTS * wanted_s * ENOUGH / BANDWIDTHS
    text = (
        f"The record of {duration_s:.3g} s is too short: {seen} It holds {constants:.0f} time constants of "
    )
    advice = "Record for longer, at best "
    if least_s > duration_s:
        advice = f"Record {rounded(least_s)} s, better "
    advice += f"{rounded(SEGMENTS * wanted_s)} s."
    if not known:  # what would be wanted grows with the record
        advice = (
            "Record for longer; if it holds a hit, hit harder or use a quieter sensor first: the peaks may "
        )
        advice += "be noise."
    if weak_hit():
        advice = "If its one rise is a hit, that is too weak for the noise: hit harder, several times."
    return [Finding(LENGTH, severity, (), lines, ENOUGH, text + "these resonances.", advice)]


def without_leakage(bandwidth_hz: float | None, spacing_hz: float, *, hit: bool) -> CheckResults:
    """The same for whole impacts and for measured responses."""
    if bandwidth_hz is None:
        return [NOTHING_SHARP]
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
        text = f"The record after the impact ({1.0 / spacing_hz:.3g} s) is too short: {seen}"
        advice = f"Record until the response has died, for some {rounded(1.0 / wanted_hz)} s."
        return [Finding(LENGTH, "warning", (), lines, limit, text, advice)]
    advice = f"Measure with lines {rounded(wanted_hz)} Hz apart."
    return [Finding(RESOLUTION, "warning", (), lines, limit, COARSE + seen, advice)]


def averages(n_averages: float, duration_s: float, nperseg: int) -> CheckResults:
    """Enough averages to tell noise from signal?"""
    if n_averages >= STEADY_AVERAGES:
        return []
    text = (
        f"Segments of {nperseg} samples leave {n_averages:.1f} independent averages in {duration_s:.3g} s; "
        f"{STEADY_AVERAGES:g} are needed for noise and coherence to mean something."
    )
    advice = "Use shorter segments, or record for longer."
    return [Finding(AVERAGES, "warning", (), n_averages, STEADY_AVERAGES, text, advice)]


def too_few_lines(n_lines: int, band: tuple[float, float]) -> Finding:
    """A band with hardly a line in it."""
    text = f"Only {n_lines} lines lie in {band[0]:g}-{band[1]:g} Hz, {LINES_OF_BAND} being the least."
    advice = "Widen the band, or use longer segments."
    return Finding(RESOLUTION, "fatal", (), float(n_lines), LINES_OF_BAND, text, advice)
