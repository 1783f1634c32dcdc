"""Mains hum: lines at multiples of 50 or 60 Hz that no mode makes, found, and taken out of all channels.

A line of the mains keeps its amplitude and its frequency, however finely it is looked at; the response of a
mode scatters about its frequency, or decays. Every multiple is brought to zero frequency and thinned out; in
pieces of the record K sine tapers give K amplitudes Y_k, which for a line are proportional to the sums U_k of
the tapers, and the share of their power that fits is a ratio of variances F (for noise, and for modes wider
than a piece resolves, of Fisher's distribution with 2 and 2 K - 2 degrees of freedom):

    mu = sum_k U_k Y_k / sum_k U_k^2,    F = (K - 1) abs(mu)^2 sum_k U_k^2 / sum_k abs(Y_k - mu U_k)^2

Taken out is the sinusoid that fits where the structure is quiet, at one frequency of the mains for all
multiples, and the lines of the spectra beside each, where what it leaves, as its frequency wanders, is more
than the response.

References: D. J. Thomson, Proc. IEEE 70 (1982) 1055-1096 (harmonic F test); K. S. Riedel and A. Sidorenko,
IEEE Trans. Signal Process. 43 (1995) 188-195 (sine tapers).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.checks import ComplexArray, FloatArray
from .recording import PooledRecording, Recording, parts_of
from .spectra import pieces

BASES_HZ = (50.0, 60.0)
#: Part of a frequency by which the mains may be off, and that its line may wander within a record.
OFF, WANDER = 2e-3, 1e-3
#: Rate to which a multiple is thinned out, longest pieces in s, and how many: the record holds six at least.
RATE_HZ, PIECE_S, LEAST_PIECES, PIECES = 20.0, 20.0, 6, 12
LEAST_SAMPLES, TAPERS = 16, 5  # samples of a thinned-out piece without which nothing is told, and tapers
#: F of a line, and of one beside another multiple that is one. Noise has the first by chance in one of 200
#: pieces, at any of the frequencies that are tried.
LINE_F, ANOTHER_F = 25.0, 8.0
#: Share of the pieces in which a channel must have the line, less a first third in which a hit may hide it;
#: and largest ratio of its power over these pieces (upper over lower tenth): of a mode it is 22.
PIECES_WITH, HIDDEN, STEADY = 0.7, 3, 2.5
BEYOND = 1.2  # how far beyond the band multiples are looked for, whose leakage reaches into it
SLOW = 2  # degree of the polynomials in time by which amplitude and phase may change over a record
QUIET_S = 0.25  # blocks in s whose energy tells where the structure is quiet
LINES = 2.5  # half the width, in lines, that is left out of spectra beside each multiple


@dataclass(frozen=True)
class Hum:
    """Multiples of the mains in a record; ``share`` is the largest of a channel's rms that they are."""

    base_hz: float
    freq_hz: tuple[float, ...]
    share: float
    dof: Any

    def outside(self, freq_hz: FloatArray, length_s: float) -> NDArray[np.bool_]:
        """Lines of spectra over ``length_s`` that none of it reaches."""
        half = np.maximum(LINES / length_s, WANDER * np.array(self.freq_hz))
        return np.asarray(np.all(np.abs(freq_hz[:, None] - self.freq_hz) > half, axis=1))


def without_hum(rec: Recording, band_hz: tuple[float, float]) -> tuple[Recording, Hum | None]:
    """The record less the hum in the band, and what was found; the record itself where there is none."""
    parts = parts_of(rec)
    found: dict[float, list[int]] = {}
    highest = min(BEYOND * band_hz[1], 0.45 * rec.fs_hz)
    for base in BASES_HZ:
        found[base] = list(range(max(1, int(np.ceil(band_hz[0] / BEYOND / base))), int(highest / base) + 1))
        multiples = found[base]
        for least in (LINE_F, ANOTHER_F):
            # One line is enough for the second, lower bar for all of them.
            if found[base]:
                found[base] = [k for k in multiples if _f_of_line(parts, k * base, least) >= least]
    base = max(BASES_HZ, key=lambda each: len(found[each]))
    if not found[base]:
        return rec, None
    cleaned = [_without(part, base, found[base]) for part in parts]
    share = np.zeros(rec.n_channels)
    for before, after in zip(parts, cleaned, strict=True):
        own = np.std(before.responses - after.responses, axis=1)
        share = np.maximum(share, own / np.maximum(before.responses.std(axis=1), 1e-300))
    worst = int(np.argmax(share))
    hum = Hum(base, tuple(k * base for k in found[base]), float(share[worst]), rec.dofs[worst])
    return (PooledRecording(cleaned) if len(cleaned) > 1 else cleaned[0]), hum


def _thinned(rec: Recording, freq_hz: float, start: int, count: int) -> ComplexArray:
    """Amplitude of a frequency in some of the blocks of a record, (n_channels, count)."""
    block = _block(rec)
    # Means over a block of means over a block, that is by a triangle, so that what stands near a multiple of
    # the rate does not fold into a line: its rising half over one block, its falling half over the next.
    at = np.arange(block)
    turn = np.exp(-2j * np.pi * freq_hz / rec.fs_hz * np.arange(2 * block)) / block**2
    halves = turn[:block] * at, turn[block:] * (block - at)
    columns = np.array([part for half in halves for part in (half.real, half.imag)]).T
    x = rec.responses[:, start * block : (start + count + 1) * block]
    sums = x.reshape(rec.n_channels, count + 1, block) @ columns
    thinned = sums[:, :-1, 0] + sums[:, 1:, 2] + 1j * (sums[:, :-1, 1] + sums[:, 1:, 3])
    return np.asarray(
        thinned * np.exp(-2j * np.pi * freq_hz / rec.fs_hz * block * np.arange(start, start + count))
    )


def _block(rec: Recording) -> int:
    """Samples of a block of a record that is thinned out."""
    return max(1, round(rec.fs_hz / RATE_HZ))


def _pieces(rec: Recording) -> list[tuple[int, int]]:
    """First block and number of blocks of each piece, less those in which a hit may hide a line."""
    count = rec.n_samples // _block(rec) - 1
    n = min(round(PIECE_S * rec.fs_hz / _block(rec)), count // LEAST_PIECES)
    if n < LEAST_SAMPLES:
        return []
    starts = np.linspace(0, count - n, min(count // n, PIECES)).astype(int)
    return [(int(start), n) for start in starts[starts.size // HIDDEN :]]


@lru_cache(maxsize=8)
def _tapers(n: int, rate_hz: float, reach_hz: float) -> tuple[FloatArray, ComplexArray]:
    """Tapers of a piece, (n_tapers, n), and turns by all frequencies within reach, (n, n_off)."""
    at = np.arange(1, n + 1) / (n + 1.0)
    tapers = np.sqrt(2.0 / (n + 1.0)) * np.sin(np.pi * np.arange(1, TAPERS + 1)[:, None] * at)
    off = np.linspace(-reach_hz, reach_hz, 2 * int(np.ceil(4 * reach_hz * n / rate_hz)) + 1)
    return tapers, np.exp(-2j * np.pi * np.arange(n)[:, None] / rate_hz * off)


def _f_of_line(parts: tuple[Recording, ...], freq_hz: float, least: float) -> float:
    """F that most of the pieces reach in a channel in which the line is steady, the largest of all channels.

    0 as soon as it cannot be ``least``. At what frequency, within what the mains may be off, all channels of
    a piece say together.
    """
    cut = [(part, *piece) for part in parts for piece in _pieces(part)]
    fits, powers = [], []
    # Once so many pieces of every channel are without it the others cannot make it a line.
    enough = int((1.0 - PIECES_WITH) * (len(cut) - 1)) + 2
    without = np.zeros(parts[0].n_channels, dtype=int)
    for part, start, n in cut:
        tapers, turns = _tapers(n, part.fs_hz / _block(part), OFF * freq_hz)
        sums = tapers.sum(axis=1)
        tapered = tapers * _thinned(part, freq_hz, start, n)[:, None]
        y = (tapered.reshape(-1, n) @ turns).reshape(*tapered.shape[:2], -1)
        mu = sums @ y / (sums @ sums)
        rest = np.sum(np.abs(y - mu[:, None] * sums[:, None]) ** 2, axis=1)
        f = (TAPERS - 1) * np.abs(mu) ** 2 * (sums @ sums) / np.maximum(rest, 1e-300)
        best = int(np.argmax(np.minimum(f, LINE_F).sum(axis=0)))
        fits.append(f[:, best])
        powers.append(np.abs(mu[:, best]) ** 2)
        without += fits[-1] < least
        if without.min() >= enough:
            return 0.0
    if not fits:
        return 0.0
    reached = np.quantile(fits, 1.0 - PIECES_WITH, axis=0)
    high, low = np.nanquantile(np.where(fits >= reached, powers, np.nan), (0.9, 0.1), axis=0)
    return float(np.max(reached, where=high <= STEADY * low, initial=0.0))


def _without(rec: Recording, base_hz: float, multiples: list[int]) -> Recording:
    """The record less the sinusoids that fit its quiet parts."""
    block = _block(rec)
    rate, count = rec.fs_hz / block, rec.n_samples // block - 1
    thinned = [_thinned(rec, k * base_hz, 0, count) for k in multiples]
    energy = np.array(
        [np.square(x[: count * block] - x.mean()).reshape(count, block).mean(axis=1) for x in rec.responses]
    )
    energy = np.mean(energy / np.maximum(energy.mean(axis=1, keepdims=True), 1e-300), axis=0)
    width = max(1, round(QUIET_S * rate))
    energy = np.convolve(np.pad(energy, width, "edge"), np.ones(width) / width, "same")[width:-width]
    weights = 1.0 / np.maximum(energy, 1e-300)
    weights /= weights.sum()
    middle = (np.arange(count) + 1.0) / rate
    off = np.linspace(-OFF, OFF, 2 * int(np.ceil(8 * OFF * multiples[-1] * base_hz * count / rate)) + 1)
    fits = np.zeros(off.size)
    for k, z in zip(multiples, thinned, strict=True):
        scale = np.mean(np.abs(z) ** 2, axis=1, keepdims=True)
        turn = np.exp(-2j * np.pi * k * base_hz * off[:, None] * middle) * weights
        fits += np.sum(np.abs(z @ turn.T) ** 2 / np.maximum(scale, 1e-300), axis=0)
    base_hz *= 1.0 + float(off[np.argmax(fits)])
    w = np.sqrt(np.repeat(weights, block))
    w = np.pad(w, (0, rec.n_samples - w.size), "edge")

    def basis(some: slice) -> FloatArray:
        at = np.arange(some.start, some.stop)
        angle = 2.0 * np.pi * base_hz / rec.fs_hz * at[:, None] * np.array(multiples)
        wave = np.concatenate([np.cos(angle), np.sin(angle)], axis=1)
        slow = (2.0 * at / rec.n_samples - 1.0)[:, None]
        return np.concatenate([*(slow**p * wave for p in range(SLOW + 1)), np.ones((at.size, 1))], axis=1)

    size = 2 * len(multiples) * (SLOW + 1) + 1
    form, right = np.zeros((size, size)), np.zeros((size, rec.n_channels))
    for some in pieces(rec.n_samples, size):
        weighted = basis(some) * w[some, None]
        form += weighted.T @ weighted
        right += weighted.T @ (w[some] * rec.responses[:, some]).T
    fitted = np.linalg.solve(form, right)[:-1]
    left = np.array(rec.responses)
    for some in pieces(rec.n_samples, size):
        left[:, some] -= (basis(some)[:, :-1] @ fitted).T
    return Recording(left, rec.fs_hz, rec.dofs, rec.force)
