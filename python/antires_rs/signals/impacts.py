"""Hammer impacts: one transform over the whole event, from before the impact until it has died.

Welch's segments would each start in the middle of a decay, with an unknown state; the quotient of two such
spectra is not a transmissibility. A transform over the whole event, from rest, is exact: every response is
then the FRF times the spectrum of the force, whatever its shape (double impacts too). If the response has
not died at the end, an exponential window forces it to. That window moves every root of every quotient by its
decay rate along the real axis, so its damping can be taken off again exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..exceptions import UnsuitableDataError
from ..support.checks import ComplexArray, FloatArray, choice
from .recording import Recording
from .segments import Segments, parts_of
from .spectra import CrossSpectra, lines_in, rows_of

# Blocks of the energy profile: coarse ones tell a decay from steady vibration, fine ones find the impact.
COARSE_BLOCKS = 64
FINE_BLOCK_SAMPLES = 8
FINE_BLOCKS = 8192
# Samples of which the coarse profile takes the median.
MEDIAN_SAMPLES = 8192
# A steady Gaussian record of one narrow mode has an exponentially distributed envelope: over 64 blocks its
# largest energy is some 13 dB above its lower fifth. 20 dB is out of its reach.
DECAY_RATIO = 100.0
# An impact lifts the energy at least this much over the eight blocks before it ...
HIT_RISE = 30.0
# ... and to this share of the record's peak. A new impact needs the last one dead by this much.
HIT_SHARE = 0.01
DEAD_SHARE = 1e-3
# Amplitude at the end of an event, relative to its start, above which the window must help: -40 dB.
END_AMPLITUDE = 1e-2
# ... and the amplitude to which the exponential window brings it down.
WINDOWED_END = 1e-3
# Quiet samples before an impact that tell offset and noise.
LEAST_REST = 32


@dataclass(frozen=True)
class Event:
    """Samples ``start`` to ``stop`` of a record hold one impact at sample ``hit``."""

    start: int
    hit: int
    stop: int


def _energy(rec: Recording, block: int, every: int = 1) -> FloatArray:
    """Mean energy of each block, channels at equal weight, about a median of every so-many-th sample."""
    n = rec.n_samples // block
    energy = np.zeros(n)
    for row in rec.responses:
        x = row - np.median(row[::every])
        power = max(float(x @ x) / x.size - float(x.mean()) ** 2, 0.0) or 1.0
        x = x[: n * block].reshape(n, block)
        energy += np.einsum("ij,ij->i", x, x) / (power * block * rec.n_channels)
    return energy


def is_transient(rec: Recording) -> bool:
    """True if the energy profile is that of decaying events, False if it is steady."""
    decaying = [_decays(part) for part in parts_of(rec)]
    if any(decaying) and not all(decaying):
        raise UnsuitableDataError(
            "method",
            f"'auto' for records of which {sum(decaying)} decay after an impact and "
            f"{len(decaying) - sum(decaying)} do not (the first of these is record "
            f"{decaying.index(False) + 1})",
            "records of one kind of test",
            "Leave out what does not belong, or say method='transient' or method='welch'.",
        )
    return all(decaying)


def _decays(rec: Recording) -> bool:
    if rec.n_samples < 2 * COARSE_BLOCKS:
        return False
    # A hundredfold rise is told from any few thousand samples' median.
    energy = _energy(rec, rec.n_samples // COARSE_BLOCKS, max(1, rec.n_samples // MEDIAN_SAMPLES))
    return bool(energy.max() > DECAY_RATIO * np.quantile(energy, 0.2))


def require_stationary(rec: Recording) -> None:
    """Raise UnsuitableDataError if Welch's method does not fit the record."""
    if is_transient(rec):
        raise UnsuitableDataError(
            "method",
            "'auto' for a record whose energy decays by more than 20 dB",
            "steady vibration for Welch's averages, because a segment that starts within a decay does not "
            "hold its own excitation",
            "Use method='transient' (one transform over each whole impact), or force it with method='welch'.",
        )


def find_events(rec: Recording) -> tuple[Event, ...]:
    """Find the impacts of a record."""
    block = max(FINE_BLOCK_SAMPLES, rec.n_samples // FINE_BLOCKS)
    energy = _energy(rec, block)
    peak = energy.max()
    hits: list[int] = []
    for b in range(1, energy.size):
        before = energy[max(0, b - 8) : b]
        if energy[b] <= HIT_SHARE * peak or energy[b] <= HIT_RISE * np.median(before):
            continue
        if hits and before.max() > DEAD_SHARE * energy[hits[-1] : b].max():
            continue  # the same event: still ringing, or a rebound of the hammer
        hits.append(b)
    if not hits:
        raise UnsuitableDataError(
            "responses",
            "a record without an impact: the energy never rises from rest",
            "a record that starts before the hit",
            "Record again with a pre-trigger: what was missed at the start cannot be recovered.",
        )
    events = []
    for i, b in enumerate(hits):
        stop = hits[i + 1] * block if i + 1 < len(hits) else rec.n_samples
        # Anti-alias filters ring before the impact: start a little earlier, but not inside the last event's
        # tail.
        early = max(4 * block, (stop - b * block) // 50)
        start = max(0, b * block - early)
        events.append((start, b * block, stop))
    stops = [start for start, _, _ in events[1:]] + [rec.n_samples]
    return tuple(Event(start, hit, stop) for (start, hit, _), stop in zip(events, stops, strict=True))


def transient_spectra(
    rec: Recording,
    *,
    window: str = "auto",
    include_force: bool = False,
    band_hz: tuple[float, float] | None = None,
) -> CrossSpectra:
    """Energy spectra of whole impacts, averaged over the impacts."""
    choice("window", window, ("auto", "rectangular", "exponential"))
    parts = parts_of(rec)
    found = [find_events(part) for part in parts]
    # One length for all, so that their lines agree; a shorter event is padded with zeros, being dead by then.
    length = max(event.stop - event.start for events in found for event in events)
    decay = max(
        _window_decay(part, event, window)
        for part, events in zip(parts, found, strict=True)
        for event in events
    )
    freq = np.asarray(np.fft.rfftfreq(length, 1.0 / rec.fs_hz), dtype=np.float64)
    lines = slice(0, freq.size) if band_hz is None else lines_in(freq, band_hz)
    freq = freq[lines]
    each: list[ComplexArray] = []
    quiet_power: list[FloatArray] = []
    energy = 0.0
    for part, events in zip(parts, found, strict=True):
        rows = rows_of(part, include_force)
        before = slice(0, max(events[0].hit - 4 * FINE_BLOCK_SAMPLES, 0))
        rest = before.stop >= LEAST_REST
        offset = [row[before].mean() if rest else 0.0 for row in rows]
        if rest:
            quiet_power.append(np.array([row[before].var() for row in rows]))
        for event in events:
            t = (np.arange(event.stop - event.start) - (event.hit - event.start)) / rec.fs_hz
            # The same exponential before the impact too: the window must be one exponential for its shift
            # to be exact.
            taper = np.exp(-decay * t)
            energy += float(taper @ taper)
            inside = slice(event.start, event.stop)
            moved = ((row[inside] - level) * taper for row, level in zip(rows, offset, strict=True))
            each.append(np.stack([np.fft.rfft(one, length)[lines] for one in moved], axis=1))
    segments = Segments.of(np.stack(each, axis=2))
    noise = np.mean(quiet_power, axis=0) * energy / len(each) if quiet_power else None
    if noise is not None and noise.min() <= 0.0:
        noise = None
    return CrossSpectra(
        freq, segments.matrix, len(each), noise, decay, segments=segments, draws=np.arange(len(each))
    )


def _window_decay(rec: Recording, event: Event, window: str) -> float:
    """Decay rate (1/s) of the exponential window that an event needs; zero for the rectangular one."""
    if window == "rectangular":
        return 0.0
    x = rec.responses[:, event.hit : event.stop]
    n = x.shape[1]
    tail = max(n // 20, 1)
    # Worst channel; median-free, because a decay has no mean.
    end = float(np.max(x[:, -tail:].std(axis=1) / np.maximum(x[:, :tail].std(axis=1), 1e-300)))
    if window == "auto" and end <= END_AMPLITUDE:
        return 0.0
    return float(max(0.0, np.log(max(end / WINDOWED_END, 2.0)) / (n / rec.fs_hz)))
