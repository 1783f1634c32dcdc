"""Time records as somebody measures them, with what is wrong with them, each thing switchable.

A record comes from :mod:`reference.modal_structures` in the frequency domain, under one hammer hit, several
(a list) or the noise of one shaker, and then passes through :class:`Imperfections`. Every imperfection draws
from a stream of its own: one that is switched off changes nothing of the others. What belongs to the
structure and its cables (steps of a channel, sideways modes, hum) is the same in all records of it.

Beside each record stands its truth: the zeros of all channels for the force as it acted, shifted as
frequencies were, and two standard deviations: ``bound_hz`` is the Cramer-Rao bound for the noise and the
steps as simulated, ``std_hz`` adds what moves within the record and, of several hits, what differs between
them.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.fft import next_fast_len
from scipy.interpolate import CubicSpline

from reference.modal_structures import ModalStructure, cramer_rao

#: Zeros with more damping are not asked for.
SHARP = 0.04
#: Analog noise of a channel in steps, beside the rounding itself; steps to either side of zero of 12 bits.
ROUGH_STEPS, FULL_SCALE = 0.3, 2048
#: Samples between two of the record's, from which moving frequencies are interpolated.
FINER = 4
#: Zeros of two hits this close are one.
SAME_ZERO = 0.1


@dataclass(frozen=True)
class Imperfections:
    """What is wrong with a record; at zero (or None, False) it is not there."""

    #: Noise of every channel as a share of its peak.
    noise: float = 1e-3
    #: Force on dofs and in directions beside the stated one, as a share of it (rms), anew in every hit.
    misplaced: float = 0.0
    #: Probability of a second blow, 15 to 60 ms after the first, misplaced on its own.
    double: float = 0.0
    #: Constant of every channel, and its slow wandering, as shares of its peak (rms).
    offset: float = 0.0
    drift: float = 0.0
    #: Steps of the converter up to the peak of a channel: spread over this range, or None for fine ones.
    steps: tuple[float, float] | None = None
    #: Twice the frequency of the strongest mode in all channels, as a share of their peaks.
    harmonic: float = 0.0
    #: Number of modes that a model lacks, and their size beside those that it has.
    sideways: int = 0
    sideways_size: float = 0.3
    #: By how much frequencies are lower at the largest amplitude, and their standard deviation by record.
    softening: float = 0.0
    between: float = 0.0
    #: Seconds of rest before a hit (half to once that), and of noise after it has died.
    rest_s: float = 0.05
    after_s: float = 0.0
    #: Whether the last channel has noise only.
    dead: bool = False
    #: Samples by which the clocks of channels differ (standard deviation).
    clocks: float = 0.0
    #: Whether the rate is told with six digits, of a clock that is off by some millionths.
    rounded_rate: bool = False
    #: Mains at 50 Hz and multiples as a share of the median peak.
    hum: float = 0.0
    #: Another force beside the shaker, as a share of it.
    second_force: float = 0.0


#: Nothing but a little noise.
CLEAN = Imperfections()
#: Levels at which records are like measured ones, see benchmarks/simulated_reality.py.
MEASURED = Imperfections(
    misplaced=0.04,
    double=0.15,
    offset=0.05,
    drift=0.02,
    steps=(20.0, 200.0),
    harmonic=0.02,
    sideways=2,
    softening=0.01,
    between=0.001,
    rest_s=2.0,
    after_s=30.0,
    clocks=0.3,
    rounded_rate=True,
    hum=0.005,
    second_force=0.03,
)
#: Names of the switches, in the order of the table.
SWITCHES = tuple(f.name for f in fields(Imperfections) if f.name not in ("noise", "sideways_size"))


def only(name, level=MEASURED):
    """Clean but for one imperfection."""
    return replace(CLEAN, **{name: getattr(level, name) if name != "dead" else True})


def without(name, level=MEASURED):
    """All but one."""
    return replace(level, **{name: getattr(CLEAN, name)})


@dataclass(frozen=True)
class Truth:
    """Zeros of every channel, one array each: frequency, damping ratio, and the two standard deviations."""

    zeros_hz: tuple[np.ndarray, ...]
    damping: tuple[np.ndarray, ...]
    bound_hz: tuple[np.ndarray, ...]
    std_hz: tuple[np.ndarray, ...]

    def wanted(self, within=0.01):
        """Zeros that a record can tell: sharp ones whose deviations are below this share, by channel."""
        return [
            f[(np.abs(d) <= SHARP) & (s < within * f)]
            for f, d, s in zip(self.zeros_hz, self.damping, self.std_hz, strict=True)
        ]


@dataclass(frozen=True)
class SimulatedRecord:
    """Samples (n, n_samples), the rate as told, and what is true."""

    samples: np.ndarray
    fs_hz: float
    truth: Truth


def _rng(seed, what):
    return np.random.default_rng([seed, zlib.crc32(what.encode())])


def as_measured(structure: ModalStructure, level: Imperfections) -> ModalStructure:
    """The structure with its sideways modes."""
    if not level.sideways:
        return structure
    rng = _rng(zlib.crc32(structure.name.encode()), "sideways")
    count, (low, high) = level.sideways, structure.band_hz
    freq = np.exp(rng.uniform(np.log(1.5 * low), np.log(0.9 * high), count))
    size = level.sideways_size * np.sqrt(np.mean(structure.sensors**2))
    n, beside = len(structure.sensors), len(structure.beside)
    return structure.with_modes(
        freq,
        rng.uniform(0.005, 0.015, count),
        size * rng.standard_normal((n, count)),
        size * rng.standard_normal(count),
        size / level.sideways_size * rng.standard_normal((beside, count)),
    )


def hit(structure: ModalStructure, level: Imperfections = MEASURED, seed: int = 0) -> SimulatedRecord:
    """One hammer hit."""
    whole = as_measured(structure, level)
    fs = structure.fs_hz
    rest = level.rest_s * _rng(seed, "rest").uniform(0.5, 1.0)
    ring = _ring_s(structure)
    duration = rest + ring + level.after_s
    finer = next_fast_len(int((duration + 2 * ring) * fs), real=True)
    freq = np.fft.rfftfreq(finer, 1 / fs)
    # A half sine whose spectrum reaches beyond the band; its exact place is between two samples.
    pulse = 0.7 / structure.band_hz[1]
    at = rest + _rng(seed, "rest").uniform(0, 1 / fs)
    blows = [(at, 1.0, _displaced(whole, level, _rng(seed, "misplaced")))]
    rng = _rng(seed, "double")
    if rng.random() < level.double:
        late, size = rng.uniform(0.015, 0.06), rng.uniform(0.2, 0.7)
        blows.append((at + late, size, _displaced(whole, level, rng)))
    force = np.zeros((whole.freq_hz.size, freq.size), complex)
    for when, size, shape in blows:
        own = size * np.exp(-2j * np.pi * freq * when) * half_sine(freq, pulse)
        force += shape[:, None] * own
    # Of two blows in two places the zeros are those of the stronger, about which the other moves them.
    power = np.abs(half_sine(freq, pulse)) ** 2
    return _measured(whole, level, seed, force, power, blows[0][2], int(duration * fs), finer, at)


def hits(structure: ModalStructure, level: Imperfections = MEASURED, seed: int = 0, count: int = 10):
    """(records, truth) of several hits of one state: the zeros for the force in its place."""
    records = [hit(structure, level, count * seed + i) for i in range(count)]
    return records, pooled_truth(as_measured(structure, level), records)


def ambient(
    structure: ModalStructure, level: Imperfections = MEASURED, seed: int = 0, seconds: float | None = None
) -> SimulatedRecord:
    """White noise of one shaker, for two hundred periods of the lowest mode unless told otherwise."""
    whole = as_measured(structure, level)
    fs = structure.fs_hz
    duration = 4.0 * 40.0 * _ring_s(structure) / 8.0 if seconds is None else seconds
    n = int(duration * fs)
    finer = next_fast_len(2 * n, real=True)
    freq = np.fft.rfftfreq(finer, 1 / fs)

    def white(what):
        rng = _rng(seed, what)
        return (rng.standard_normal(freq.size) + 1j * rng.standard_normal(freq.size)) * (freq > 0)

    force = whole.force[:, None] * white("force")
    if level.second_force:
        size = np.sqrt(np.mean(whole.force**2) / np.mean(whole.beside**2))
        other = size * whole.beside[-1] * level.second_force
        force = force + other[:, None] * white("second force")
    return _measured(whole, level, seed, force, np.full(freq.size, 2.0), whole.force, n, finer, None)


def half_sine(freq_hz, width_s):
    """Spectrum of a half sine of unit area about its middle."""
    x = np.asarray(freq_hz) * width_s
    near = np.abs(4 * x**2 - 1) < 1e-6
    return np.where(near, np.pi / 4, np.cos(np.pi * x) / np.where(near, 1.0, 1 - 4 * x**2))


def _ring_s(structure):
    """Seconds that are recorded of a hit: 8 of a structure of 5 Hz and more."""
    return 8.0 * max(1.0, 5.0 / structure.band_hz[0]) if structure.band_hz[0] < 2.0 else 8.0


def _displaced(structure, level, rng):
    """Modal participations of a force that is a little beside its place and direction."""
    draws = rng.standard_normal(len(structure.beside))
    size = np.sqrt(np.mean(structure.force**2) / np.mean(structure.beside**2, axis=1))
    return structure.force + level.misplaced / np.sqrt(draws.size) * (draws * size) @ structure.beside


def _measured(structure, level, seed, force, power, acted, n, n_long, hit_s):
    """The record of these modal forces, through everything that is wrong with it."""
    fs, count = structure.fs_hz, len(structure.sensors)
    freq = np.fft.rfftfreq(n_long, 1 / fs)
    # The filter before the converter, the same in all channels.
    through = 1.0 / np.sqrt(1.0 + (freq / (0.42 * fs)) ** 24)
    modal = structure.oscillators(freq) * force * through
    modal[:, 0] = 0.0
    spectra = structure.sensors @ modal
    if level.clocks:
        late = level.clocks * _rng(seed, "clocks").standard_normal(count) / fs
        spectra = spectra * np.exp(-2j * np.pi * freq * late[:, None])
    start = 0 if hit_s is not None else n_long // 4
    fine = np.fft.irfft(spectra, FINER * n_long)[:, FINER * start : FINER * (start + n + 8)] * FINER
    clean = fine[:, : FINER * n : FINER]
    peak = np.abs(clean).max(axis=1)
    factor = 1.0 + level.between * float(_rng(seed, "between").standard_normal())
    moved = np.full(n, factor)
    if level.softening:
        moved = factor * (1.0 - level.softening * _envelope(clean / peak[:, None], fs))
    begin = 0 if hit_s is None else int(hit_s * fs)
    at = np.arange(n, dtype=float)
    at[begin:] = begin + np.concatenate([[0.0], np.cumsum(moved[begin:-1])])
    if level.softening or level.between:
        place = np.clip(at, 0, fine.shape[1] / FINER - 1)
        clean = CubicSpline(np.arange(fine.shape[1]) / FINER, fine, axis=1)(place)
    x = clean + _harmonic(structure, level, modal, peak, start, n, n_long)
    noise = _dirty(x, level, structure, seed, peak, power_of=fs)
    energy = np.sum((clean / np.sqrt(noise)[:, None]) ** 2, axis=0)
    mean = float(np.sum(energy * moved) / energy.sum())
    swing = float(np.sqrt(np.sum(energy * (moved - mean) ** 2) / energy.sum()))
    live = np.arange(count) < (count - 1 if level.dead else count)
    zeros = [structure.zeros(row, acted) if live[row] else (np.zeros(0),) * 2 for row in range(count)]
    # Lines of the record's own length: a hit has its energy in each, noise that of all samples.
    lines = np.fft.rfftfreq(n, 1 / fs)
    inside = (lines >= structure.band_hz[0]) & (lines <= structure.band_hz[1])
    step = max(1, int(inside.sum() / MOST_LINES))
    some = np.flatnonzero(inside)[::step]
    energy_of_line = np.interp(lines[some], freq, power * through**2)
    if hit_s is None:
        energy_of_line = energy_of_line * n / n_long
    bound = cramer_rao(structure, zeros, energy_of_line * step, noise * n, lines[some], acted, live)
    truth = Truth(
        tuple(f * mean for f, _ in zeros),
        tuple(d for _, d in zeros),
        tuple(b * mean for b in bound),
        tuple(np.hypot(b * mean, f * swing) for b, (f, _) in zip(bound, zeros, strict=True)),
    )
    told = float(f"{fs * (1 + 3.7e-6):.6g}") if level.rounded_rate else fs
    return SimulatedRecord(x, told, truth)


#: Lines that the bound is formed of.
MOST_LINES = 1000


def _envelope(x, fs_hz):
    """Amplitude over time, at most one: a tenth of a second is looked at together."""
    width = max(3, int(0.1 * fs_hz))
    power = np.convolve(np.mean(x**2, axis=0), np.ones(width) / width, "same")
    return np.sqrt(power / power.max())


def _harmonic(structure, level, modal, peak, start, n, n_long):
    """Of the strongest mode, squared: twice its frequency, in a shape of its own."""
    if not level.harmonic:
        return 0.0
    size = np.sum(np.abs(structure.sensors), axis=0) * np.sqrt(np.sum(np.abs(modal) ** 2, axis=1))
    size[(structure.freq_hz < structure.band_hz[0]) | (structure.freq_hz > 0.45 * structure.band_hz[1])] = 0.0
    q = np.fft.irfft(modal[int(np.argmax(size))], n_long)[start : start + n]
    shape = _rng(zlib.crc32(structure.name.encode()), "harmonic").standard_normal(len(peak))
    square = q**2 - np.mean(q**2)
    return level.harmonic * (peak * shape)[:, None] * square / max(np.abs(square).max(), 1e-300)


def _dirty(x, level, structure, seed, peak, power_of):
    """What sensors, cables and converters add to ``x``, in place; returns the power of white noise."""
    count, n = x.shape
    own = zlib.crc32(structure.name.encode())
    t = np.arange(n) / structure.fs_hz
    if level.dead:
        x[-1] = 0.0
    if level.hum:
        rng = _rng(own, "hum")
        phase = _rng(seed, "hum").uniform(0, 2 * np.pi)
        gain = level.hum * np.median(peak) * rng.lognormal(0.0, 0.5, count)
        for k, part in ((1, 1.0), (2, 0.2), (3, 0.4)):
            if 50.0 * k < 0.45 * structure.fs_hz:
                x += part * gain[:, None] * np.sin(2 * np.pi * 50.0 * k * t + k * phase)
    if level.offset:
        x += (level.offset * peak * _rng(seed, "offset").standard_normal(count))[:, None]
    if level.drift:
        rng = _rng(seed, "drift")
        knots = max(4, int(t[-1] / 4.0))
        slow = CubicSpline(np.linspace(0, t[-1], knots), rng.standard_normal((count, knots)), axis=1)(t)
        x += (level.drift * peak)[:, None] * slow
    noise = (level.noise * peak) ** 2
    step = np.zeros(count)
    if level.steps is not None:
        steps = np.geomspace(*level.steps, count)
        step = peak / _rng(own, "steps").permutation(steps)
        noise = noise + (ROUGH_STEPS * step) ** 2
    x += np.sqrt(noise)[:, None] * _rng(seed, "noise").standard_normal((count, n))
    if level.steps is not None:
        x[:] = np.clip(np.round(x / step[:, None]), -FULL_SCALE, FULL_SCALE - 1) * step[:, None]
        noise = noise + step**2 / 12
    return noise


def pooled_truth(structure: ModalStructure, records) -> Truth:
    """Of several hits: zeros for the force in its place, with what differs between the hits."""
    parts = ([], [], [], [])
    scale = len(records)
    for row in range(len(structure.sensors)):
        freq, damping = structure.zeros(row)
        if not any(r.truth.zeros_hz[row].size for r in records):
            freq = damping = np.zeros(0)
        off, bounds = np.full((scale, freq.size), np.inf), np.full((scale, freq.size), np.inf)
        within = np.zeros((scale, freq.size))
        for k, record in enumerate(records):
            own = record.truth.zeros_hz[row]
            for i, value in enumerate(freq):
                if own.size and np.abs(own / value - 1).min() < SAME_ZERO:
                    nearest = int(np.argmin(np.abs(own - value)))
                    off[k, i] = own[nearest] - value
                    bounds[k, i] = record.truth.bound_hz[row][nearest]
                    within[k, i] = record.truth.std_hz[row][nearest]
        bound = 1.0 / np.sqrt(np.maximum(np.sum(bounds**-2.0, axis=0), 1e-300))
        middle = np.where(np.isfinite(off).all(axis=0), np.median(off, axis=0), 0.0)
        scatter = np.sqrt(np.mean(np.where(np.isfinite(off), off - middle, np.inf) ** 2, axis=0) / scale)
        drift = np.sqrt(np.maximum(np.mean(within**2 - np.where(np.isfinite(bounds), bounds, 0) ** 2, 0), 0))
        parts[0].append(freq + middle)
        parts[1].append(damping)
        parts[2].append(bound)
        parts[3].append(np.sqrt(bound**2 + scatter**2 + drift**2))
    return Truth(*(tuple(part) for part in parts))
