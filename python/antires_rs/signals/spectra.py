r"""Welch spectra of records, the noise that they tell, and what one force or two channels make of them.

S_ab is what ``scipy.signal.csd(a, b)`` computes, the average of conj(A) B. H1 is biased low by noise on the
input, H2 biased high by noise on the output. At an antiresonance of j the channel x_j is mostly noise: H1
divides T_pj by 1 + noise / signal of x_j at that line, and flattens its peak, which no averaging helps and
the coherence-based standard deviation does not show. "rank1" uses that one force acts: the dominant
eigenvector of the matrix of all spectra, with the channels scaled to equal noise, holds the responses up to a
common factor, without bias to first order.

References: P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73; J. S. Bendat and A. G. Piersol,
Random Data, 4th ed., 2010; G. T. Rocklin, J. Crowley, H. Vold, Proc. IMAC 3 (1985) 272-278 (Hv).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..exceptions import UnsuitableDataError, reject
from ..support.checks import ComplexArray, FloatArray, integer, real_array
from .recording import Recording, check_recording, parts_of, rows_of, shortest

# -- Spectra of many segments, kept in half the digits beside their exact average
#
# What is kept of each segment is asked for standard deviations only, so seven digits do: of a record whose
# band reaches up to the Nyquist frequency, segments that overlap by half take as much memory as the record.

#: Numbers that are worked on at a time: a few times this is what a step needs beside its input.
AT_A_TIME = 1 << 17


def pieces(count: int, size: int, at_a_time: int = AT_A_TIME) -> Iterator[slice]:
    """Slices of ``count`` things of ``size`` numbers each, at least one thing in each slice."""
    step = max(1, at_a_time // max(1, size))
    for start in range(0, count, step):
        yield slice(start, min(start + step, count))


@dataclass(frozen=True, eq=False)
class Segments:
    """Scaled spectra of what was averaged."""

    values: NDArray[np.complexfloating[Any, Any]]  # (n_freq, n_rows, n_segments), single of long records
    matrix: ComplexArray  # mean over the segments of conj(A) B in double precision, (n_freq, n_rows, n_rows)
    unit: FloatArray  # what values are to be multiplied by for that mean, (n_freq, n_rows)
    scale: FloatArray  # what both are to be multiplied by, the matrix in rows and in columns

    @classmethod
    def of(cls, values: ComplexArray) -> Self:
        """Of spectra as they are."""
        matrix = values.conj() @ values.transpose(0, 2, 1) / values.shape[2]
        return cls(values, matrix, np.ones(values.shape[:2]), np.ones(values.shape[:2]))

    @property
    def count(self) -> int:
        """Number of segments."""
        return int(self.values.shape[2])

    def covariance(self, lines: slice = slice(None)) -> ComplexArray:
        """Mean over the segments of A conj(B) at some lines, scaled, (n_lines, n_rows, n_rows)."""
        scaled, scale = self.matrix[lines].conj(), self.scale[lines]
        scaled *= scale[:, :, None]
        scaled *= scale[:, None, :]
        return scaled

    def at(self, lines: slice) -> ComplexArray:
        """Those of some lines, scaled, in double precision."""
        factor = self.unit[lines] * self.scale[lines]
        return np.asarray(self.values[lines] * factor[:, :, None], dtype=np.complex128)

    def times(self, scale: FloatArray) -> Self:
        """Scaled once more, by rows (n_rows,) or by lines and rows, (n_freq, n_rows) or (n_freq, 1)."""
        return replace(self, scale=self.scale * scale)

    def part(self, lines: slice | NDArray[np.bool_]) -> Self:
        """The same for some of the lines."""
        values, matrix, unit, scale = self.values, self.matrix, self.unit, self.scale
        return replace(self, values=values[lines], matrix=matrix[lines], unit=unit[lines], scale=scale[lines])

    def projected(self, directions: FloatArray) -> Segments:
        """The same in the basis ``directions``, (n_rows, n_directions)."""
        return Segments.of(np.asarray(directions.T @ self.at(slice(None))))


# -- The noise of channels and of lines, as averaged spectra tell it


def spectrum(matrix: ComplexArray, scale: FloatArray) -> tuple[FloatArray, ComplexArray]:
    """All eigenvalues, largest first, (n_freq, n), and the vectors of the largest, (n_freq, n)."""
    values = _core.hermitian_values(matrix, scale)[:, ::-1]
    return np.ascontiguousarray(values), dominant(matrix, scale)[2]


def dominant(matrix: ComplexArray, scale: FloatArray) -> tuple[FloatArray, FloatArray, ComplexArray]:
    """The largest eigenvalue, the mean of the others, (n_freq,) each, and its vectors, (n_freq, n)."""
    return _core.dominant_pairs(matrix, scale)


RIDGE = 1e-13  # keeps the inverse of exact data, whose matrices are of rank one, within rounding
# Independent averages needed per channel before the inverse of an averaged matrix means something.
AVERAGES_PER_CHANNEL = 1.5
PASSES = 4  # passes of "eigenvector, residual noise of each channel, scale"
LINES = 500  # the scales are medians over lines: so many lines tell them
# No channel is taken to have less than this share of the noise that the passes start from: with next to no
# noise they would end by calling a single channel perfect.
LEAST_NOISE = 0.1
# Mean of the other eigenvalues over the first of a matrix that holds nothing but rounding beside its vector.
EXACT = 1e-13
ROUNDING = 1e-15  # share of the largest eigenvalue below which a floor is rounding
FLOOR_LINES = 101  # lines over which the noise of averaged spectra is taken to be constant


def channel_noise(matrix: ComplexArray, start: FloatArray | None = None) -> FloatArray:
    """Relative noise power of every channel: what the dominant vector leaves of the diagonal, (n_channels,).

    ``matrix`` holds averages of conj(A) B, (n_freq, n, n).
    """
    some = matrix[:: max(1, matrix.shape[0] // LINES)]
    auto = np.einsum("fii->fi", some).real
    first = auto.mean(axis=0) if start is None else start
    first = np.where(first > 0.0, first, 1.0)
    scale = first
    for _ in range(PASSES):
        largest, rest, vectors = dominant(some, scale)
        if scale.size > 1 and np.median(rest / np.maximum(largest, 1e-300)) < EXACT:
            break  # of rank one but for rounding: there is no noise to tell
        # The noise is in the largest eigenvalue as well.
        left = auto / scale - (largest - rest)[:, None] * np.abs(vectors) ** 2
        # By line, since otherwise coloured noise would let the quiet lines decide, where leakage counts.
        share = np.median(left / np.maximum(np.abs(left).mean(axis=1, keepdims=True), 1e-300), axis=0)
        scale = scale * share / max(float(share.mean()), 1e-300)
        scale = np.maximum(scale, LEAST_NOISE * first * float(np.median(scale / first)))
    return np.asarray(scale)


def floors(largest: FloatArray, rest: FloatArray) -> FloatArray:
    """Noise level of every line: running median of the mean of all eigenvalues but the largest.

    Noise that is not white would otherwise bias the eigenvector of smallest misfit, which takes it for even.
    """
    from scipy.ndimage import median_filter  # slow to import

    return np.asarray(np.maximum(median_filter(rest, size=FLOOR_LINES, mode="nearest"), _rounding(largest)))


def _rounding(largest: FloatArray) -> float:
    """Exact rank one leaves rounding only."""
    return max(ROUNDING * float(largest.max()), 1e-300)


# -- What is rough from line to line is noise: second differences of curves that are smooth without it

NOISE_LINES = 31  # lines over which the noise of measured curves is taken to be constant
LEAST_LINES = 12  # with fewer lines nothing tells noise from curve
LEAST_NOISE_ROUGHNESS = 1e-12  # no curve is taken to have less noise than this share of its power
GAIN = 6.0  # second differences of white noise over the noise itself, in power
MEDIAN = np.log(2.0)  # the median of abs()**2 of complex Gaussian noise over its mean


def second_differences(values: ComplexArray) -> FloatArray:
    """Squared second differences along the last axis: ``GAIN`` times the power of white noise."""
    return np.abs(values[..., 2:] - 2.0 * values[..., 1:-1] + values[..., :-2]) ** 2


def typical_noise(values: ComplexArray) -> FloatArray:
    """Noise power of every curve (n_outputs, n_freq) at its median line, (n_outputs,)."""
    noise = np.median(second_differences(values), axis=1) / (GAIN * MEDIAN)
    return np.asarray(np.maximum(noise, LEAST_NOISE_ROUGHNESS * np.mean(np.abs(values) ** 2, axis=1)))


def local_noise(values: ComplexArray) -> FloatArray:
    """Noise power of every curve around every line, (n_outputs, n_freq); too high at sharp resonances."""
    from scipy.ndimage import median_filter  # slow to import

    power = np.mean(np.abs(values) ** 2, axis=1)[:, None]
    if values.shape[1] < LEAST_LINES:
        return np.repeat(power, values.shape[1], axis=1)
    second = second_differences(values)
    second = np.concatenate([second[:, :1], second, second[:, -1:]], axis=1)
    noise = median_filter(second, size=(1, NOISE_LINES), mode="nearest") / (GAIN * MEDIAN)
    return np.asarray(np.maximum(noise, LEAST_NOISE_ROUGHNESS * power))


def roughness(curve: ComplexArray) -> float:
    """Noise over power of one curve, by medians: the few lines of a sharp resonance are rough too."""
    power = float(np.median(np.abs(curve) ** 2))
    return float(np.median(second_differences(curve))) / GAIN / power if power > 0.0 else 0.0


# -- Running means, and peaks that stand out of a curve, by their prominence


def running_mean(values: FloatArray, width: int) -> FloatArray:
    """Mean over so many neighbours, fewer at the ends."""
    kernel = np.ones(min(width, values.size))
    return np.asarray(np.convolve(values, kernel, "same") / np.convolve(np.ones(values.size), kernel, "same"))


def prominent_peaks(curve: FloatArray, least: float) -> NDArray[np.int64]:
    """Indices of the maxima with a prominence of ``least`` at least, ascending; of a flat top the middle.

    As ``scipy.signal.find_peaks``, whose import takes longer than the identification of a short record.
    """
    # Stretches of equal values; a peak is one with lower ones on both sides.
    first = np.flatnonzero(np.diff(curve, prepend=np.nan) != 0.0)
    level = curve[first]
    top = 1 + np.flatnonzero((level[1:-1] > level[:-2]) & (level[1:-1] > level[2:]))
    if not top.size:
        return np.empty(0, dtype=np.int64)
    middle = (first[top] + first[top + 1] - 1) // 2
    # Lowest points before the first peak, between peaks, and after the last.
    low = np.minimum.reduceat(level, np.concatenate([[0], top]))
    height = level[top].tolist()
    left = _lowest(height, low[:-1].tolist())
    right = _lowest(height[::-1], low[:0:-1].tolist())[::-1]
    return np.asarray(middle[np.array(height) - np.maximum(left, right) >= least], dtype=np.int64)


def _lowest(height: list[float], before: list[float]) -> list[float]:
    """Lowest point from every peak back to the next higher one; ``before`` are those between neighbours."""
    higher: list[tuple[float, float]] = []
    found = []
    for own, lowest in zip(height, before, strict=True):
        while higher and higher[-1][0] <= own:
            lowest = min(lowest, higher.pop()[1])
        higher.append((own, lowest))
        found.append(lowest)
    return found


TOGETHER = 1 << 18  # numbers of the spectra that are multiplied together: 4 MB


@dataclass(frozen=True, eq=False)
class CrossSpectra:
    """Averaged spectral matrix of several channels."""

    freq_hz: FloatArray
    matrix: ComplexArray
    """(n_freq, n, n): the average of conj(A) B, a one-sided density for Welch, energy spectra for impacts."""
    n_averages: int
    noise: FloatArray | None = None
    """Noise part of the diagonal, (n,), where it was measured: before an impact."""
    added_decay_per_s: float = 0.0
    """Of an exponential window; roots identified from these spectra carry it in their real part."""
    n_effective: float = field(kw_only=True)
    """Independent averages that would scatter as much, fewer where segments overlap."""
    segments: Segments | None = None
    draws: NDArray[np.int64] | None = None
    """To which of several draws, records or impacts, each segment belongs; None for one record."""
    records: NDArray[np.int64] | None = None
    """To which record each segment belongs."""

    @cached_property
    def noise_power(self) -> FloatArray:
        """Noise power of each channel at the median line, (n_channels,), units of the diagonal.

        What the other channels together do not tell of a channel is its noise: ``1 / inv(S)_pp``, corrected
        for the averages that the regression uses up, for any number of forces below that of channels. With
        too few averages for an inverse, what the dominant eigenvector leaves of the diagonal is taken.
        """
        matrix, n, n_averages = self.matrix, self.matrix.shape[1], self.n_effective
        mean = np.einsum("fii->fi", matrix).real.mean(axis=0)
        root = np.sqrt(np.where(mean > 0.0, mean, 1.0))
        auto = np.einsum("fii->fi", matrix).real / root**2
        left = np.empty(auto.shape)
        if n_averages >= AVERAGES_PER_CHANNEL * n:
            for some in pieces(len(matrix), n * n):
                part = matrix[some] * (1.0 / (root[:, None] * root))
                part[:, np.arange(n), np.arange(n)] += (
                    RIDGE * np.maximum(auto[some].mean(axis=1), 1e-300)[:, None]
                )
                left[some] = 1.0 / np.einsum("fii->fi", np.linalg.inv(part)).real
            left *= n_averages / (n_averages - n + 1.0)
        else:
            scaled = matrix * (1.0 / (root[:, None] * root))
            scale = channel_noise(scaled)
            unit = dominant(scaled, scale)[2] * np.sqrt(scale)
            unit = unit / np.linalg.norm(unit, axis=1, keepdims=True)
            along = np.einsum("fi,fji,fj->f", unit, scaled, unit.conj(), optimize=True).real
            left = auto - along[:, None] * np.abs(unit) ** 2
        level = np.median(left, axis=0)  # The median, because near a resonance leakage looks like noise.
        return np.asarray(np.maximum(level, RIDGE * np.maximum(auto.mean(axis=0), 1e-300)) * root**2)

    def part(self, kept: NDArray[np.bool_]) -> CrossSpectra:
        """Spectra at some of the lines."""
        segments = None if self.segments is None else self.segments.part(kept)
        return replace(self, freq_hz=self.freq_hz[kept], matrix=self.matrix[kept], segments=segments)

    def rows(self, rows: list[int]) -> CrossSpectra:
        """Spectra of some of the channels, without the segments; these spectra if it is all of them."""
        if rows == list(range(self.matrix.shape[1])):
            return self
        noise = None if self.noise is None else self.noise[rows]
        return replace(self, matrix=self.matrix[:, rows][:, :, rows], segments=None, noise=noise)


def effective_averages(taper: FloatArray, step: int, n_segments: int) -> float:
    """Number of independent averages with the variance of ``n_segments`` that overlap.

    P. D. Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70-73, for a signal that is white over the window.
    """
    shifts = np.arange(1, min(n_segments, -(-taper.size // step)))
    shared = np.array([(taper[j * step :] @ taper[: taper.size - j * step]) ** 2 for j in shifts])
    return float(
        n_segments / (1.0 + 2.0 * np.sum((1.0 - shifts / n_segments) * shared) / (taper @ taper) ** 2)
    )


def cross_spectra(
    rec: Recording,
    *,
    nperseg: int,
    noverlap: int | None = None,
    window: Any = "hann",
    include_force: bool = False,
    band_hz: tuple[float, float] | None = None,
) -> CrossSpectra:
    """Welch's averaged auto and cross spectral densities of all channels at once."""
    check_recording(rec)
    n_seg = integer("nperseg", nperseg, low=8, high=shortest(rec))
    overlap = n_seg // 2 if noverlap is None else integer("noverlap", noverlap, low=0, high=n_seg - 1)
    taper = window_values(window, n_seg)
    freq = np.asarray(np.fft.rfftfreq(n_seg, 1.0 / rec.fs_hz), dtype=np.float64)
    density = np.full(freq.size, 2.0)  # One-sided: all lines but zero and Nyquist stand for two.
    density[[0] if n_seg % 2 else [0, -1]] = 1.0
    lines = slice(0, freq.size) if band_hz is None else lines_in(freq, band_hz)
    freq = freq[lines]
    step = n_seg - overlap
    parts = parts_of(rec)
    counts = [1 + (part.n_samples - n_seg) // step for part in parts]
    factor = np.sqrt(density[lines] / (rec.fs_hz * (taper @ taper)))
    rows = [rows_of(part, include_force) for part in parts]
    # Of one size in all channels, so that single precision holds them in any unit.
    unit = np.array([max(float(np.abs(row).max()) for row in own) or 1.0 for own in zip(*rows, strict=True)])
    products = np.zeros((freq.size, unit.size, unit.size), dtype=np.complex128)
    segments = np.empty((freq.size, unit.size, sum(counts)), dtype=np.complex64)
    done = 0
    for own in rows:
        for some in _transforms(own, unit, taper, step, lines):
            for lines_at in pieces(len(some), unit.size * (unit.size + some.shape[2])):
                part = some[lines_at]
                products[lines_at] += part.conj() @ part.transpose(0, 2, 1)
            segments[:, :, done : done + some.shape[2]] = some
            done += some.shape[2]
    scale = factor[:, None] * unit
    products *= scale[:, :, None]
    products *= scale[:, None, :] / done
    effective = sum(effective_averages(taper, step, count) for count in counts)
    records = np.repeat(np.arange(len(parts)), counts)
    each = Segments(segments, products, scale, np.ones(scale.shape))
    of: dict[str, Any] = {"draws": records if len(parts) > 1 else None, "records": records}
    return CrossSpectra(freq, products, done, n_effective=effective, segments=each, **of)


def _transforms(
    rows: list[FloatArray], unit: FloatArray, taper: FloatArray, step: int, lines: slice
) -> Iterator[ComplexArray]:
    """Spectra of all segments, (n_lines, n_channels, n_more) at a time; nothing else transforms segments."""
    n, count = taper.size, 1 + (rows[0].size - taper.size) // step
    tapers = (taper / unit[:, None])[:, None, :]
    views = [np.lib.stride_tricks.sliding_window_view(row, n)[::step] for row in rows]
    # Products of many segments cost little more than those of few.
    for group in pieces(count, len(rows) * (lines.stop - lines.start), at_a_time=TOGETHER):
        spectra = np.empty(
            (lines.stop - lines.start, len(rows), group.stop - group.start), dtype=np.complex128
        )
        for some in pieces(group.stop - group.start, len(rows) * n):
            at = slice(group.start + some.start, group.start + some.stop)
            samples = np.stack([view[at] for view in views])
            samples -= samples.mean(axis=2, keepdims=True)
            samples *= tapers
            spectra[:, :, some] = np.fft.rfft(samples)[:, :, lines].transpose(2, 0, 1)
        yield spectra


def lines_in(freq_hz: FloatArray, band_hz: tuple[float, float]) -> slice:
    """The lines in a band; zero frequency is none of them: means are removed, accelerations vanish."""
    first = int(np.searchsorted(freq_hz, max(band_hz[0], np.nextafter(0.0, 1.0)), side="left"))
    return slice(first, max(first, int(np.searchsorted(freq_hz, band_hz[1], side="right"))))


def window_values(window: Any, n: int) -> FloatArray:
    """The window as an array, from a name known to scipy or from given values."""
    if isinstance(window, str) and window == "hann":
        return np.asarray(0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n))
    if isinstance(window, str | tuple):
        from scipy.signal import get_window  # slow to import

        try:
            return np.asarray(get_window(window, n), dtype=np.float64)
        except ValueError as exc:
            wanted = f"a window known to scipy.signal.get_window ({exc})"
            reject("window", window, wanted, "Leave it out for 'hann'.")
    taper = real_array("window", window, ndim=1, wanted=f"a window name, or {n} finite values")
    if taper.shape != (n,) or not taper.any():
        remedy = "Give a value for each sample of a segment."
        reject("window", f"an array of shape {taper.shape}", f"a window name, or {n} finite values", remedy)
    return taper


# -- The direction of the responses at each line, and its noise: what is rough from line to line in curves
# that turn smoothly. Of FRFs and of the transmissibilities made of them it is the same.

LEAST_SHARE = 1e-2  # no channel is taken to have less noise than this share of the typical one
LEAST_DIRECTION_NOISE = 1e-12  # no direction is taken to have less noise power than this


def aligned(vectors: ComplexArray) -> ComplexArray:
    """Vectors (n_rows, n_freq) of unit norm, each line's free phase turned to that of its neighbour."""
    norm = np.linalg.norm(vectors, axis=0)
    unit = vectors / np.where(norm > 0.0, norm, 1.0)
    step = np.angle(np.sum(unit[:, :-1].conj() * unit[:, 1:], axis=0))
    return np.asarray(unit * np.exp(-1j * np.concatenate([[0.0], np.cumsum(step)])))


def direction_noise(directions: ComplexArray) -> FloatArray:
    """Noise power of :func:`aligned` directions around every line, (n_rows, n_freq), from roughness."""
    return np.maximum(local_noise(directions), LEAST_DIRECTION_NOISE)


def noise_shares(noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A noise power (n_rows, n_freq) as row times line: medians, for sharp peaks look noisy in all; means."""
    row = np.median(noise, axis=1)
    row = np.maximum(row, LEAST_SHARE * float(np.median(row)))
    return row, np.mean(noise / row[:, None], axis=0)


# -- One force acts: S = s s^H + diag(noise), s proportional to the FRFs H_pk. With channels of equal noise
# its dominant eigenvector is the maximum-likelihood estimate of s up to a complex factor, which cancels.


def response_vectors(
    matrix: ComplexArray, noise: FloatArray | None = None
) -> tuple[ComplexArray, FloatArray]:
    """Dominant vectors, (n_channels, n_freq) in the channels' units, and signal-to-noise power, (n_freq,).

    ``noise`` is each channel's noise power in the same units; where it is not known it is estimated.
    """
    known = noise is not None and noise.min() > 0.0
    scale = noise if noise is not None and known else channel_noise(matrix)
    largest, rest, vectors = dominant(matrix, scale)
    floor = 1.0 if known else max(float(np.median(rest)), _rounding(largest))
    return np.ascontiguousarray((vectors * np.sqrt(scale)).T), largest / floor


# -- Two-channel estimators, and how far each estimate scatters
#
# With n_d independent averages an H1 or H2 scatters, in its real and its imaginary part alike, by
#
#     std^2 = abs(H)^2 (1 - g2) / (2 g2 (n_d - 1)),    g2 the ordinary coherence,
#
# the textbook's expression (there with n_d: the coherence itself comes out too high by one part in n_d), and
# an upper limit for Hv. For the rank-one estimate T = v_p / v_j first-order perturbation moves v along every
# other eigenvector e_k by a random amount of variance l_1 l_k / (n_d (l_1 - l_k)^2), hence
#
#     std^2 = sum_k abs(e_kp - T e_kj)^2 / abs(v_j)^2  l_1 l_k / (2 (n_d - 1) (l_1 - l_k)^2).
#
# So the eigenvector gains over H1 where both channels are weak; with two channels both are the same.
#
# References: J. S. Bendat and A. G. Piersol, Random Data, 4th ed., 2010, ch. 9 (random errors of H1 and H2);
# T. W. Anderson, Ann. Math. Stat. 34 (1963) 122-148 (scatter of eigenvectors).

LEAST_COHERENCE = 1e-12  # below this a coherence is that of a line without energy
LEAST_GAP = 1e-3  # two largest eigenvalues closer than this leave the eigenvector undetermined


def two_channel(matrix: ComplexArray, j: int, estimator: str) -> tuple[ComplexArray, FloatArray]:
    """Every channel over channel j by H1, H2 or Hv, and ordinary coherence; both (n_channels, n_freq)."""
    auto = np.einsum("fii->if", matrix).real
    s_jp, s_jj = matrix[:, j, :].T, auto[j]
    if not s_jj[1:].all() or not auto.any(axis=1).all():
        silent = ~auto.any(axis=1)
        dead = int(np.flatnonzero(silent)[0]) if silent.any() else j
        got = f"channel {dead} without energy at some frequencies"
        wanted = "signals that are not zero"
        raise UnsuitableDataError("responses", got, wanted, "Leave the dead channel out.")
    with np.errstate(divide="ignore", invalid="ignore"):
        coherence = np.clip(np.abs(s_jp) ** 2 / (s_jj * auto), 0.0, 1.0)
        if estimator == "h1":
            values = s_jp / s_jj
        elif estimator == "h2":
            values = auto / s_jp.conj()
        else:
            scale = np.sqrt(auto.mean(axis=1) / s_jj.mean())[:, None]
            a, b, c = s_jj, auto / scale**2, s_jp / scale
            # Dominant eigenvector of [[a, conj c], [c, b]], from the row that does not cancel.
            largest = 0.5 * (a + b + np.hypot(a - b, 2.0 * np.abs(c)))
            values = np.where(a >= b, c / (largest - b), (largest - a) / c.conj()) * scale
    # Lines without energy (often zero frequency, after the mean was removed) carry no information.
    return np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0), np.nan_to_num(coherence)


def std_of_coherence(values: ComplexArray, coherence: FloatArray, n_averages: float) -> FloatArray:
    """Standard deviation of real and imaginary part, (n_channels, n_freq); finite without coherence."""
    known = np.maximum(coherence, LEAST_COHERENCE)
    # H1 is zero where coherence is: the scatter there must not be.
    size = np.maximum(np.abs(values), LEAST_COHERENCE * np.abs(values).max(axis=1, keepdims=True))
    return np.asarray(size * np.sqrt((1.0 - known) / (2.0 * known * (n_averages - 1.0))), dtype=np.float64)


def std_of_rank_one(spectra: CrossSpectra, j: int) -> FloatArray:
    """Standard deviation of real and imaginary part of the rank-one T_pj, (n_channels, n_freq)."""
    root, n_averages = np.sqrt(spectra.noise_power), spectra.n_effective
    # conj(A) B is the transpose of the covariance whose eigenvectors are wanted; eigenvalues ascend.
    values, vectors = np.linalg.eigh((spectra.matrix / (root[:, None] * root)).transpose(0, 2, 1))
    first = np.maximum(values[:, -1:], 1e-300)
    values = np.clip(values[:, :-1], 0.0, (1.0 - LEAST_GAP) * first)
    own, others = vectors[:, :, -1], vectors[:, :, :-1]
    # The eigenvector errs along every other one; the ratio to component j takes the projections.
    share = first * values / (first - values) ** 2
    v_j = np.where(own[:, j] == 0.0, 1e-300, own[:, j])[:, None]
    t = own / v_j
    error = (
        np.abs((others - t[:, :, None] * others[:, j : j + 1, :]) / v_j[:, :, None]) ** 2 @ share[:, :, None]
    )
    std = (np.sqrt(error[:, :, 0] / (2.0 * (n_averages - 1.0))) * root / root[j]).T
    std[j] = 0.0
    return np.asarray(std, dtype=np.float64)
