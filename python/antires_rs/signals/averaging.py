"""Averages of a record, made once: the options, and the value that check and fit share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, wraps
from typing import Any, TypeVar
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ..exceptions import UnsuitableDataError, reject
from ..support.checks import ComplexArray, FloatArray, choice
from .hum import Hum, without_hum
from .recording import Recording, parts_of, rows_of, shortest
from .spectra import CrossSpectra, Segments, cross_spectra, lines_in, window_values

# -- Hammer impacts: one transform over the whole event, from before the impact until it has died
#
# Welch's segments would each start in the middle of a decay, with an unknown state. Of a transform from rest
# every response is the FRF times the spectrum of the force, whatever its shape. If the response has not died
# at the end, an exponential window forces it to, and moves every root by its decay rate along the real axis.

# Blocks of the energy profile: coarse ones tell a decay from steady vibration, fine ones find the impact.
COARSE_BLOCKS = 64
FINE_BLOCK_SAMPLES = 8
FINE_BLOCKS = 8192
MEDIAN_SAMPLES = 8192  # samples of which the coarse profile takes the median
# A steady Gaussian record of one narrow mode has an exponentially distributed envelope: over 64 blocks its
# largest energy is some 13 dB above its lower fifth. 20 dB is out of its reach.
DECAY_RATIO = 100.0
LEAST_DECAY = 8.0  # one event that decays may have fallen less where the record ends
HIT_RISE = 30.0  # an impact lifts the energy at least this much over the eight blocks before it ...
LEAST_RISE = 4.0  # where none does, the highest block is the impact if something before it is this much lower
# ... and to this share of the record's peak. A new impact needs the last one dead by this much.
HIT_SHARE = 0.01
DEAD_SHARE = 1e-3
# Amplitude at the end of an event, relative to its start, above which the window must help: -40 dB.
END_AMPLITUDE = 1e-2
WINDOWED_END = 1e-3  # ... and the amplitude to which the exponential window brings it down.
LEAST_REST = 32  # quiet samples before an impact that tell offset and noise
# Drift is slower than the band's low end, at least this share of its high one. It is told from noise by means
# over four periods of that, to leave modes below the band out, whose power is so many times that of noise.
LEAST_LOW, SLOW, DRIFT_RATIO = 0.005, 0.25, 30.0


@dataclass(frozen=True)
class Event:
    """Samples ``start`` to ``stop`` of a record hold one impact at sample ``hit``."""

    start: int
    hit: int
    stop: int


T = TypeVar("T")


def _once(of: Callable[[Recording, float], T]) -> Callable[[Recording, float], T]:
    """The same, computed once for a record, which does not change: the fit, the check and the looks ask."""
    known: WeakKeyDictionary[Recording, dict[float, T]] = WeakKeyDictionary()

    @wraps(of)
    def once(rec: Recording, low_hz: float) -> T:
        own = known.setdefault(rec, {})
        if low_hz not in own:
            own[low_hz] = of(rec, low_hz)
        return own[low_hz]

    return once


def without_drift(x: FloatArray, fs_hz: float, low_hz: float) -> FloatArray:
    """Samples less their median and their running mean over one period of the lowest frequency, (..., n).

    The same filter for all channels leaves ratios of responses as they are. At 0 Hz only the median goes.
    """
    n = x.shape[-1]
    half = min(int(0.5 * fs_hz / low_hz), (n - 1) // 2) if low_hz > 0.0 else 0
    if half == 0:
        return np.asarray(x - np.median(x, axis=-1, keepdims=True))
    x = x - x.mean(axis=-1, keepdims=True)  # a running mean takes the median, which is slower, as well
    sums = np.empty((*x.shape[:-1], n + 2 * half + 1))
    sums[..., : half + 1], sums[..., n + half + 1 :] = x[..., :1], x[..., -1:]
    sums[..., half + 1 : n + half + 1] = x
    np.cumsum(sums, axis=-1, out=sums)
    mean = sums[..., 2 * half + 1 :] - sums[..., :n]
    mean /= 2 * half + 1
    x -= mean
    return np.asarray(x)


def lowest_hz(band_hz: tuple[float, float] | None) -> float:
    """Frequency below which there is drift only: the band's low end, no less than a part of its high one."""
    return 0.0 if band_hz is None else max(band_hz[0], LEAST_LOW * band_hz[1])


def drifts(rec: Recording, band_hz: tuple[float, float]) -> bool:
    """Whether the last quarter of a record is slower than its noise can be, in most channels.

    Means of white noise over w samples have the w-th part of its power.
    """
    slow_hz = SLOW * lowest_hz(band_hz)
    for part in parts_of(rec):
        tail = part.responses[:, -max(part.n_samples // 4, 1) :]
        width = min(rec.fs_hz / slow_hz, float(tail.shape[1]))
        fast = without_drift(tail, rec.fs_hz, slow_hz)
        slow = tail - fast
        if np.median(slow.var(axis=1) * width / np.maximum(fast.var(axis=1), 1e-300)) > DRIFT_RATIO:
            return True
    return False


def _energy(rec: Recording, block: int, low_hz: float = 0.0, every: int = 1) -> FloatArray:
    """Mean energy of each block, channels at equal weight, without what is slower than ``low_hz``; else about
    a median of every so-many-th sample."""
    n = rec.n_samples // block
    energy = np.zeros(n)
    for row in rec.responses:
        x = without_drift(row, rec.fs_hz, low_hz) if low_hz > 0.0 else row - np.median(row[::every])
        power = max(float(x @ x) / x.size - float(x.mean()) ** 2, 0.0) or 1.0
        x = x[: n * block].reshape(n, block)
        energy += np.einsum("ij,ij->i", x, x) / (power * block * rec.n_channels)
    return energy


def is_transient(rec: Recording, low_hz: float = 0.0) -> bool:
    """True if the energy profile, without drift, is that of decaying events, False if it is steady."""
    decaying = []
    for part in parts_of(rec):
        n = part.n_samples
        if n < 2 * COARSE_BLOCKS:
            decaying.append(False)
            continue
        # A hundredfold rise is told from any few thousand samples' median.
        energy = _energy(part, n // COARSE_BLOCKS, low_hz, max(1, n // MEDIAN_SAMPLES))
        rest, low = (energy.max() / max(np.quantile(energy, share), 1e-300) for share in (0.05, 0.2))
        ringing = (low > LEAST_DECAY or rest > DECAY_RATIO) and _decays(part, low_hz)
        decaying.append(bool(low > DECAY_RATIO or ringing))
    if any(decaying) and not all(decaying):
        steady, first = decaying.count(False), decaying.index(False)
        got = f"'auto' for records of which {sum(decaying)} decay after an impact and {steady} do not (the "
        got += f"first of these is record {first}, counted from 0)"
        remedy = "Leave out what does not belong, or say method='transient' or method='welch'."
        raise UnsuitableDataError("method", got, "records of one kind of test", remedy)
    return all(decaying)


# Of a weak hit most of a record is level noise: its median is less than this above its lower fifth. Steady
# vibration swells and fades.
LEVEL = 1.2


def is_level_but_for_a_rise(rec: Recording, low_hz: float) -> bool:
    """Whether a record that is not transient may still hold a weak hit."""
    energy = _energy(rec, max(1, rec.n_samples // COARSE_BLOCKS), low_hz)
    fifth, median = np.quantile(energy, (0.2, 0.5))
    return bool(median < LEVEL * fifth and energy.max() > LEAST_RISE * median)


@_once
def find_events(rec: Recording, low_hz: float) -> tuple[Event, ...]:
    """Find the impacts of a record, without what is slower than ``low_hz``."""
    block = max(FINE_BLOCK_SAMPLES, rec.n_samples // FINE_BLOCKS)
    energy = _energy(rec, block, low_hz)
    peak = energy.max()
    hits: list[int] = []
    for b in range(1, energy.size):
        before = energy[max(0, b - 8) : b]
        if energy[b] <= HIT_SHARE * peak or energy[b] <= HIT_RISE * np.median(before):
            continue
        if hits and before.max() > DEAD_SHARE * energy[hits[-1] : b].max():
            continue  # the same event: still ringing, or a rebound of the hammer
        hits.append(b)
    if not hits and energy.argmax() > 0 and energy[: energy.argmax()].min() < peak / LEAST_RISE:
        # In noise, or so slowly sampled that the response builds up over several blocks.
        hits.append(int(energy.argmax()))
    if not hits:
        got = "a record without an impact: the energy never rises from rest, as in a free decay"
        remedy = "Record again with a pre-trigger: what was missed at the start cannot be recovered."
        raise UnsuitableDataError("responses", got, "a record that starts before the hit", remedy)
    events = []
    for i, b in enumerate(hits):
        stop = hits[i + 1] * block if i + 1 < len(hits) else rec.n_samples
        # Anti-alias filters ring before the impact: start a little earlier, but not inside the last event's
        # tail.
        start = max(0, b * block - max(4 * block, (stop - b * block) // 50))
        events.append((start, b * block, stop))
    stops = [start for start, _, _ in events[1:]] + [rec.n_samples]
    return tuple(Event(start, hit, stop) for (start, hit, _), stop in zip(events, stops, strict=True))


@_once
def tail_noise(rec: Recording, low_hz: float) -> tuple[FloatArray, FloatArray]:
    """Noise of every channel behind the last impact: power, (n,), and by frequency to half the rate, (n, m).

    From the last quarter; medians over frequency, for what rings there still is sharp.
    """
    from scipy.ndimage import median_filter  # slow to import

    x = without_drift(rec.responses[:, find_events(rec, low_hz)[-1].hit :], rec.fs_hz, low_hz)
    count = x.shape[1]
    tail = x[:, -max(count // 4, min(count, 512)) :]
    tail = tail - tail.mean(axis=1, keepdims=True)
    taper = np.hanning(tail.shape[1])
    power = np.abs(np.fft.rfft(tail * taper)) ** 2 / np.sum(taper**2)
    smooth = median_filter(power, (1, max(9, power.shape[1] // 20)), mode="nearest") / np.log(2.0)
    smooth = np.maximum(smooth, 1e-12 * np.maximum(power.max(axis=1, keepdims=True), 1e-300))
    return np.median(smooth, axis=1), smooth


def until_noise(x: FloatArray, event: Event, level: FloatArray, fs_hz: float) -> int:
    """Sample at which the energy of half seconds has fallen to ``CUT_AT`` times the noise."""
    energy = np.mean(x[:, event.hit : event.stop] ** 2 / level[:, None], axis=0)
    block = max(8, min(int(0.5 * fs_hz), energy.size // 16))
    low = np.flatnonzero(energy[: energy.size // block * block].reshape(-1, block).mean(axis=1) < CUT_AT)
    return min(event.stop, event.hit + (int(low[0]) + 1) * block) if low.size else event.stop


# Blocks of an event in which its energy is followed. Of a decay the logarithm falls (rank correlation with
# time), does not lie above its chord by more than a share of what it falls, and is within an eighth of its
# highest no longer than an exponential times a factor; less energy comes afterwards.
DECAY_BLOCKS, DECAY_RANK, ABOVE_CHORD, LOUD, AFTERWARDS = 32, -0.85, 0.12, 1.4, 1.0
# An impact has a quarter of its highest energy within so many fine blocks, or seconds.
SHARP_BLOCKS, SHARP_S = 3, 0.1
# Share of the highest energy that is left in the last eighth of what still rings; the first has most.
STILL_RINGS = 0.01
CUT_AT = 10.0  # a decay ends where its energy has fallen to so many times the noise


@_once
def _decays(rec: Recording, low_hz: float) -> bool | None:
    """Whether the one event is a decay; sines that stop rise from rest, too. None without an impact."""
    try:
        events = find_events(rec, low_hz)
    except UnsuitableDataError:
        return None
    if len(events) > 1:
        return True
    (event,) = events
    x = without_drift(rec.responses, rec.fs_hz, low_hz)
    first, last = event.hit // FINE_BLOCK_SAMPLES, event.stop // FINE_BLOCK_SAMPLES
    fine = _energy(rec, FINE_BLOCK_SAMPLES, low_hz)[first:last]
    sharp = max(SHARP_BLOCKS, int(SHARP_S * rec.fs_hz / FINE_BLOCK_SAMPLES))
    eighths = [part.mean() for part in np.array_split(fine, 8) if part.size]
    rings = bool(eighths) and eighths[-1] > STILL_RINGS * fine.max() and int(np.argmax(eighths)) == 0
    if rings and np.argmax(fine >= 0.25 * fine.max()) < sharp:
        # What is damped little has not decayed where the record ends; a sine that stops is above its chord.
        falls = np.log(np.maximum(eighths, np.finfo(float).tiny))
        above = np.mean(falls - np.linspace(falls[0], falls[-1], falls.size))
        if above <= ABOVE_CHORD * (falls[0] - falls[-1]):
            return True
    level = tail_noise(rec, low_hz)[0]
    energy = np.mean(x[:, event.hit : event.stop] ** 2 / level[:, None], axis=0)
    end = until_noise(x, event, level, rec.fs_hz) - event.hit
    if np.sum(energy[end:] - 1.0) > AFTERWARDS * np.sum(energy[:end]):
        return False
    blocks = np.log([max(one.mean(), 1e-300) for one in np.array_split(energy[:end], min(DECAY_BLOCKS, end))])
    time = np.linspace(0.0, 1.0, blocks.size)
    rank = np.argsort(np.argsort(blocks, kind="stable"), kind="stable")
    fall = max(float(blocks[0] - blocks[-1]), 1e-9)
    return bool(
        np.corrcoef(rank, time)[0, 1] <= DECAY_RANK
        and np.mean(blocks - (blocks[0] - fall * time)) <= ABOVE_CHORD * fall
        and np.mean(blocks >= blocks.max() - np.log(8.0)) <= LOUD * np.log(8.0) / fall
    )


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
    low_hz = lowest_hz(band_hz)
    found = [find_events(part, low_hz) for part in parts]
    # One length for all, so that their lines agree; a shorter event is padded with zeros, being dead by then.
    length = max(event.stop - event.start for events in found for event in events)
    each_event = ((part, event) for part, events in zip(parts, found, strict=True) for event in events)
    decay = max(_window_decay(part, event, window) for part, event in each_event)
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
    impacts: dict[str, Any] = {"n_effective": float(len(each)), "draws": np.arange(len(each))}
    impacts["records"] = np.repeat(np.arange(len(parts)), [len(events) for events in found])
    return CrossSpectra(freq, segments.matrix, len(each), noise, decay, segments=segments, **impacts)


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


# -- How wide the sharp resonances of a record are, and the power spectrum that tells it
#
# Averaged over all places of a segment, Welch's auto spectrum is the transform of the autocorrelation of the
# record times that of the taper: one transform of the whole record gives the spectrum at the resolution of
# any segment length (R. B. Blackman and J. W. Tukey, The Measurement of Power Spectra, 1959).

SEGMENTS = 10.0  # segments are not longer than this share of the record, so that their scatter can be told
PEAK_RATIO = 10.0  # peaks lower than this over the band's median are not taken for resonances
NARROWEST = 0.25  # the narrow bandwidth is this quantile of those of all peaks


@dataclass(frozen=True, eq=False)
class Autocorrelation:
    """Autocorrelation of a record's responses, each of unit power, summed."""

    rec: Recording

    @cached_property
    def longest(self) -> int:
        """Samples of the longest segments that leave enough averages and fit every part of the record."""
        n = power_of_two(self.rec.n_samples / SEGMENTS)
        while n > shortest(self.rec):
            n //= 2
        return n

    @cached_property
    def _lags(self) -> FloatArray:
        # With NumPy: SciPy's transforms are faster, but their import takes longer than all of this.
        lags = np.zeros(self.longest)
        for part in parts_of(self.rec):
            n = fast_length(part.n_samples + self.longest)
            total = np.zeros(n, dtype=np.float32)
            # The power of z = x + i y, taken at f and at -f together, is that of x and y.
            for first in range(0, part.n_channels, 2):
                z: NDArray[Any] = np.zeros(n, dtype=np.complex64)
                for row, x in zip(part.responses[first : first + 2], (z.real, z.imag), strict=False):
                    # Of unit power in seven digits, as only widths of peaks are looked for.
                    x = x[: row.size]
                    np.subtract(row, row.mean(), out=x, casting="same_kind")
                    # Of what stays constant nothing is left but rounding.
                    size = float(np.linalg.norm(x)) if row.max() > row.min() else 0.0
                    x *= np.float32(1.0 / size if size > 0.0 else 0.0)
                z = np.fft.fft(z)
                total += z.real**2
                total += z.imag**2
            half = total[: n // 2 + 1] + np.roll(total[::-1], 1)[: n // 2 + 1]
            lags += 0.5 * np.fft.irfft(half, n)[: self.longest]
        return lags

    def power(self, n: int, band_hz: tuple[float, float]) -> FloatArray:
        """Power of all channels at equal weight in the band, as Hann segments of ``n`` samples resolve it."""
        lags = self._lags[:n] * hann_autocorrelation(n)[: self._lags.size]
        folded = np.zeros(n)  # Negative lags, folded onto the length of a segment.
        folded[: lags.size] = lags
        folded[n - lags.size + 1 :] += lags[:0:-1]
        freq = np.fft.rfftfreq(n, 1.0 / self.rec.fs_hz)
        inside = (freq >= band_hz[0]) & (freq <= band_hz[1])
        return np.asarray(np.fft.rfft(folded).real[inside], dtype=np.float64)


def fast_length(least: int) -> int:
    """The smallest product of powers of 2, 3 and 5 that is not less."""
    best = 1 << max(least - 1, 1).bit_length()
    fives = 1
    while fives < best:
        odd = fives
        while odd < best:
            best = min(best, odd << max(-(-least // odd) - 1, 0).bit_length())
            odd *= 3
        fives *= 5
    return best


def hann_autocorrelation(n: int) -> FloatArray:
    """Of the periodic Hann window of ``n`` samples, one at lag zero."""
    taper = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n)
    r = np.fft.irfft(np.abs(np.fft.rfft(taper, 2 * n)) ** 2)[:n]
    return np.asarray(r / r[0], dtype=np.float64)


def power_of_two(n: float) -> int:
    """The nearest, by ratio."""
    return int(2 ** max(0, round(np.log2(max(n, 1.0)))))


def narrow_width(power: FloatArray) -> float | None:
    """Half-power bandwidth, in lines, of the sharp ones among the peaks that stand out; None without any."""
    # The area over the height is steadier than the two half-power points of a ragged spectrum;
    # pi/2 half-power widths make the area of a resonance.
    widths = [power[lo : hi + 1].sum() / power[peak] for lo, peak, hi in owned_by_peaks(power)]
    return float(np.quantile(widths, NARROWEST)) * 2 / np.pi if widths else None


def owned_by_peaks(power: FloatArray) -> list[tuple[int, int, int]]:
    """First line, highest line and last line of each peak, which owns all down to a tenth of its height."""
    left = power.copy()
    least = PEAK_RATIO * np.median(power)
    owned = []
    while left.max() > least:
        peak = int(np.argmax(left))
        lo = hi = peak
        while lo > 0 and power[lo - 1] > 0.1 * power[peak]:
            lo -= 1
        while hi < power.size - 1 and power[hi + 1] > 0.1 * power[peak]:
            hi += 1
        if lo > 0 and hi < power.size - 1 and left[lo : hi + 1].min() > 0:
            owned.append((lo, peak, hi))
        left[lo : hi + 1] = 0.0
    return owned


# -- How long the segments of Welch's method should be when the user does not say
#
# For the 8-mass chain with 1 % damping at 512 Hz: 32 s of a record of 600 s, 16 s of 200 s, 8 s of 60 s.

# Segments of this many half-power bandwidths' reciprocals. On a chain with 1 % damping (narrowest resonance
# 0.46 Hz wide) 32 s have a third of the leakage error of 16 s, and no more scatter: a joint fit over all
# lines does not mind whether it sees many averages or many lines.
BANDWIDTHS = 16.0
LEAST_SAMPLES = 256
FEWEST_SAMPLES = 64  # shorter ones are taken of records that have no more, down to these
MOST_LINES = 5000  # bands with more lines are fitted in windows, which costs more than the resolution gains
LEAST_LINES = 8  # lines below which no bandwidth is measured


def longest_segments(rec: Recording, band_hz: tuple[float, float]) -> int:
    """Samples of the longest segments that leave enough averages, and not too many lines in the band."""
    n_long = Autocorrelation(rec).longest
    while n_long * (band_hz[1] - band_hz[0]) / rec.fs_hz > MOST_LINES:
        n_long //= 2
    return n_long


def choose_nperseg(
    rec: Recording, band_hz: tuple[float, float], correlation: Autocorrelation | None = None
) -> int:
    """Samples per segment from the record's length and the sharpness of its resonances."""
    n_long = longest_segments(rec, band_hz)
    if n_long < FEWEST_SAMPLES:
        wanted = f"at least {FEWEST_SAMPLES * SEGMENTS / rec.fs_hz:.3g} s"
        got = f"a record that lasts {rec.n_samples / rec.fs_hz:.3g} s"
        reject("source", got, wanted, "Record for longer, or give nperseg=.")
    power = (correlation or Autocorrelation(rec)).power(n_long, band_hz)
    width = narrow_width(power) if power.size >= LEAST_LINES else None
    if width is None:
        return n_long
    bandwidth = width * rec.fs_hz / n_long
    return min(n_long, max(LEAST_SAMPLES, power_of_two(BANDWIDTHS / bandwidth * rec.fs_hz)))


def beside(spectra: CrossSpectra, hum: Hum | None) -> CrossSpectra:
    """The lines that no hum reaches."""
    if hum is None:
        return spectra
    return spectra.part(hum.outside(spectra.freq_hz, 1.0 / float(np.median(np.diff(spectra.freq_hz)))))


METHODS = ("auto", "welch", "transient")


@dataclass(frozen=True)
class Averaging:
    """How a record is averaged, see :class:`~antires_rs.FitOptions`; defaults of every call that averages."""

    nperseg: int | None = None
    noverlap: int | None = None
    window: Any = "hann"
    method: str = "auto"

    def checked(self) -> Averaging:
        """The same options, or an error that names the bad one; segments are checked with the record."""
        choice("method", self.method, METHODS)
        return self


@dataclass(frozen=True, eq=False)
class Averages:
    """Averaged spectra of a record on the lines of a band, and how they were made; without mains hum."""

    options: Averaging
    spectra: CrossSpectra  # with the segments; the force, if it is there, is the last channel
    nperseg: int | None  # samples per segment; None for impacts
    taper: FloatArray | None
    has_force: bool
    correlation: Autocorrelation  # of the whole record, for what needs the longest segments
    hum: Hum | None  # what was taken out

    @property
    def rec(self) -> Recording:
        """The record that was averaged, less the hum."""
        return self.correlation.rec

    @property
    def scatter(self) -> tuple[float, float, NDArray[np.int64] | None]:
        """Independent lines over all, segments over independent averages, and the draw of each segment."""
        n = self.spectra.n_effective
        lines = 1.0 if self.nperseg is None else min(1.0, self.rec.n_samples / self.nperseg / n)
        return lines, self.spectra.n_averages / n, self.spectra.draws


def holds_hits(rec: Recording, options: Averaging, band_hz: tuple[float, float] | None = None) -> bool:
    """Whether a record is to be transformed impact by impact."""
    if options.method == "auto":
        low_hz = lowest_hz(band_hz)
        return is_transient(rec, low_hz) and all(_decays(part, low_hz) is not False for part in parts_of(rec))
    return options.method == "transient"


def average(
    rec: Recording,
    band_hz: tuple[float, float],
    options: Averaging,
    *,
    include_force: bool = False,
    lines_hz: tuple[float, float] | None = None,
    longer: int = 1,
    hits: bool | None = None,
) -> Averages:
    """The averages of a record: one transform of its segments, or of its impacts.

    ``band_hz`` decides on the length of the segments where that is left open, made ``longer`` by a factor;
    ``lines_hz`` are the lines kept, by default those of the band. ``hits`` where that is known already.
    """
    lines = band_hz if lines_hz is None else lines_hz
    rec, hum = without_hum(rec, band_hz)
    correlation = Autocorrelation(rec)
    if holds_hits(rec, options, band_hz) if hits is None else hits:
        name = options.window
        window = name if isinstance(name, str) and name in ("rectangular", "exponential") else "auto"
        spectra = transient_spectra(rec, window=window, include_force=include_force, band_hz=lines)
        return Averages(options, beside(spectra, hum), None, None, include_force, correlation, hum)
    nperseg = options.nperseg
    if nperseg is None:
        nperseg = min(longer * choose_nperseg(rec, band_hz, correlation), shortest(rec))
    how: dict[str, Any] = {"nperseg": nperseg, "noverlap": options.noverlap, "window": options.window}
    spectra = cross_spectra(rec, include_force=include_force, band_hz=lines, **how)
    taper = window_values(options.window, nperseg)
    return Averages(options, beside(spectra, hum), nperseg, taper, include_force, correlation, hum)
