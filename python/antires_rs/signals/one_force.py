r"""Does one force explain the responses?

Under one force and independent noise the spectral matrix, scaled to equal noise, has one large eigenvalue;
the others are noise and scatter as those of a Wishart matrix. A second, independent force lifts the second
eigenvalue. Two other things do so too and must not be taken for it: the scatter of few averages, whose mean
is known, and leakage. Within the width of the window the response changes its direction, so a segment's line
holds a mixture of neighbouring directions; the first vectors, spread by the window as the window spreads
power, tell how much second eigenvalue that makes. A line counts when its second eigenvalue stands above both,
and above a share of the first below which a second force does not matter.

References: K. Johansson, Commun. Math. Phys. 209 (2000) 437-476, and I. M. Johnstone, Ann. Stat. 29 (2001)
295-327 (largest eigenvalue of noise); C. Y. Shih et al., Mech. Syst. Signal Process. 2 (1988) 367-377
(singular values by line).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..support.checks import ComplexArray, FloatArray
from .findings import Finding, NotTested, Said, Severity, rounded
from .noise import spectrum, typical_noise
from .segments import pieces
from .spectra import CrossSpectra

# -- What the tests look at: spectra in the band, brought to equal noise, and their eigenvalues


# A line's power spreads at least as the Hann window lets it, whatever window is said to be used.
HANN_SPREAD = (1.0, 0.25)
# No channel is taken to be quieter than this part of its own power (-60 dB): exact data have no noise at all,
# and scaling by what rounding and leakage leave would weigh channels at random.
LEAST_NOISE = 1e-6
# Lines to which the window spreads less than this part of a tone's power see nothing of it.
LEAST_SPREAD = 1e-6


@dataclass(frozen=True)
class Evidence:
    """Responses as one vector a line, and, for records, how well one vector describes them.

    Attributes
    ----------
    dofs : tuple
        n channels.
    freq_hz : (n_freq,)
    vectors : (n_freq, n) complex
        Responses by line, each line with a free phase, in units in which all channels have equal noise.
    power : (n_freq,)
        Signal-to-noise power of all channels together.
    matrix : (n_freq, n, n) complex or None
        Covariance A conj(B) of the channels by line, in those units; None without averages.
    eigenvalues : (n_freq, n) or None
        Of that matrix, largest first.
    n_averages : float
        Effective; 1 for measured responses and single impacts.
    signal : (n, n_freq) or None
        Signal-to-noise power of each channel by line.
    coherence : (n, n_freq) or None
        Highest ordinary coherence of each channel with any other.
    explained : (n,) or None
        Share of each channel's power in the band that its best partner explains.
    nperseg : int or None
    fs_hz : float or None
    spread : tuple of float
        Power that the window puts 0, 1, ... lines beside a tone.
    """

    dofs: tuple[Any, ...]
    freq_hz: FloatArray
    vectors: ComplexArray
    power: FloatArray
    matrix: ComplexArray | None = None
    eigenvalues: FloatArray | None = None
    n_averages: float = 1.0
    signal: FloatArray | None = None
    coherence: FloatArray | None = None
    explained: FloatArray | None = None
    nperseg: int | None = None
    fs_hz: float | None = None
    spread: tuple[float, ...] = HANN_SPREAD

    @cached_property
    def leakage(self) -> FloatArray:
        """Second eigenvalue that the window makes out of one force, (n_freq,).

        A line's matrix is then the sum of the neighbours' vectors, spread as the window spreads power; its
        eigenvalues are those of the vectors' inner products, which are a smaller matrix.
        """
        n = self.vectors.shape[0]
        parts = [self.vectors]
        for shift, power in enumerate(self.spread[1:], start=1):
            if power > LEAST_SPREAD:
                for step in (shift, -shift):
                    moved = np.zeros_like(self.vectors)
                    moved[max(step, 0) : n + min(step, 0)] = self.vectors[max(-step, 0) : n - max(step, 0)]
                    parts.append(np.sqrt(power) * moved)
        stack = np.stack(parts, axis=1)
        if stack.shape[1] < 2:
            return np.zeros(n)
        inner = stack.conj() @ stack.transpose(0, 2, 1)
        return np.asarray(np.maximum(np.linalg.eigvalsh(inner)[:, -2], 0.0), dtype=np.float64)


def of_spectra(
    spectra: CrossSpectra,
    dofs: tuple[Any, ...],
    *,
    nperseg: int | None,
    fs_hz: float,
    taper: FloatArray | None,
) -> Evidence:
    """Evidence of a record's spectra on the lines of the band."""
    matrix, freq = spectra.matrix, spectra.freq_hz
    if spectra.n_averages == 1:
        return _of_one_average(spectra, matrix, freq, dofs, fs_hz)
    noise = spectra.noise if spectra.noise is not None else spectra.noise_power
    auto = np.einsum("fii->if", matrix).real
    noise = np.maximum(noise, LEAST_NOISE * auto.mean(axis=1))
    root = np.sqrt(noise)
    # conj(A) B is the transpose of the covariance whose eigenvectors are wanted.
    scaled = (matrix * (1.0 / (root[:, None] * root))).transpose(0, 2, 1)
    values, vectors = spectrum(matrix, noise)
    first = np.maximum(values[:, 0], 0.0)
    coherence, explained = _best_partners(matrix, auto)
    return Evidence(
        dofs,
        freq,
        vectors * np.sqrt(first)[:, None],
        first,
        scaled,
        np.maximum(values, 0.0),
        spectra.n_effective,
        np.maximum(auto / noise[:, None] - 1.0, 0.0),
        coherence,
        explained,
        nperseg,
        fs_hz,
        _spread(taper),
    )


def of_curves(
    freq_hz: FloatArray, values: ComplexArray, dofs: tuple[Any, ...], coherence: FloatArray | None = None
) -> Evidence:
    """Evidence of measured frequency responses, (n, n_freq): no averages, noise from roughness."""
    noise = typical_noise(values)
    noise[noise <= 0.0] = 1.0
    scaled = values / np.sqrt(noise)[:, None]
    size = np.abs(scaled) ** 2
    return Evidence(
        dofs, freq_hz, np.ascontiguousarray(scaled.T), size.sum(axis=0), signal=size, coherence=coherence
    )


def _of_one_average(
    spectra: CrossSpectra, matrix: ComplexArray, freq: FloatArray, dofs: tuple[Any, ...], fs_hz: float
) -> Evidence:
    """A single impact: the matrix is exactly of rank one, and nothing else can be read from it."""
    auto = np.einsum("fii->if", matrix).real
    noise = spectra.noise if spectra.noise is not None else 1e-6 * auto.mean(axis=1)
    noise = np.where(noise > 0.0, noise, 1.0)
    row = int(np.argmax((auto / noise[:, None]).mean(axis=1)))
    # Column of the strongest channel over its root: the spectra themselves, up to a phase a line.
    size = np.sqrt(np.maximum(auto[row], 1e-300))
    vectors = (matrix[:, row, :] / size[:, None]) / np.sqrt(noise)
    power = np.sum(np.abs(vectors) ** 2, axis=1)
    return Evidence(dofs, freq, vectors, power, signal=np.abs(vectors.T) ** 2, fs_hz=fs_hz)


def _best_partners(matrix: ComplexArray, auto: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Highest coherence with another channel by line; best partner's share of the power in the band."""
    n = auto.shape[0]
    if n == 1:
        return np.zeros_like(auto), np.ones(1)
    coherence = np.empty((n, n, len(matrix)))
    for some in pieces(len(matrix), n * n):
        part = matrix[some].transpose(1, 2, 0)
        power = np.maximum(auto[:, None, some] * auto[None, :, some], 1e-300)
        coherence[:, :, some] = np.minimum((part.real**2 + part.imag**2) / power, 1.0)
    coherence[np.arange(n), np.arange(n)] = 0.0
    explained = np.einsum("pqf,pf->pq", coherence, auto) / np.maximum(auto.sum(axis=1), 1e-300)[:, None]
    return coherence.max(axis=1), np.asarray(explained.max(axis=1), dtype=np.float64)


def _spread(taper: FloatArray | None) -> tuple[float, ...]:
    """Power of the window's transform at 0, 1, ... 3 lines, over that at zero."""
    if taper is None:
        return HANN_SPREAD
    power = np.abs(np.fft.rfft(taper)[:4]) ** 2
    power = power / power[0]
    power[:2] = np.maximum(power[:2], HANN_SPREAD)
    return tuple(float(p) for p in power)


NAME = "one_force"
# Fewer independent averages than this leave no scatter to compare with.
LEAST_AVERAGES = 4.0
# A line counts if the second eigenvalue is twice what noise makes it on average ...
OVER_NOISE = 2.0
# ... three times what leakage makes it (measured: 0.5 to 1.0 times the prediction) ...
OVER_LEAKAGE = 3.0
# ... and this part of the first; a second force of 0.1 of the first makes 4e-3 at the median line, and
# one of 0.03 is the least that harmed an identification.
LEAST_SHARE = 1e-3
# Share of the lines that must count. Of one force 2 % at most did in 240 records with up to 10 % of noise; of
# a second force of 0.1 of the first 20 to 90 % did.
LINES = 0.10
# Share of the lines, and second over first eigenvalue at their median, above which identified values are
# nonsense: a second force of 0.3 of the first.
FATAL_LINES, FATAL = 0.4, 0.025
# Noise level of a line is averaged over so many lines.
SMOOTHING = 15
# Second over first eigenvalue at the median line above which one force does not explain the responses at all.
UNEXPLAINED = 0.2


def one_force(seen: Evidence) -> Said:
    """Second eigenvalue against the first, the noise and the leakage."""
    n = len(seen.dofs)
    if seen.eigenvalues is None:
        return [
            NotTested(
                NAME,
                "measured responses and single impacts hold one vector a line, which one force "
                "always explains; a record with several averages is needed",
            )
        ]
    if seen.n_averages < LEAST_AVERAGES:
        return [
            NotTested(
                NAME,
                f"{seen.n_averages:.1f} independent averages; {LEAST_AVERAGES:g} are needed "
                "to tell a second force from noise",
            )
        ]
    if n == 1:
        return [NotTested(NAME, "a single channel has one eigenvalue")]
    if n == 2:
        return [_two_channels(seen)]
    first, second = seen.eigenvalues[:, 0], seen.eigenvalues[:, 1]
    share = second / np.maximum(first, 1e-300)
    limit = OVER_NOISE * noise_level(seen)
    counts = (second > limit) & (second > OVER_LEAKAGE * seen.leakage) & (share > LEAST_SHARE)
    lines = float(counts.mean())
    if lines > LINES:
        middle = float(np.median((second - 0.5 * limit)[counts] / first[counts]))
        text = (
            f"The responses need more than one force: at {100 * lines:.0f} % of the lines the second "
            "eigenvalue of the spectral matrix stands clear of noise and leakage, at "
            f"{rounded(100 * middle)} % of the first (median of these lines)."
        )
        advice = (
            "Stop the other source (a second shaker, machines, wind, people), or record while only the "
            "known force acts."
        )
        severity: Severity = "fatal" if lines > FATAL_LINES and middle > FATAL else "warning"
        return [Finding(NAME, severity, (), lines, LINES, text, advice)]
    middle = float(np.median(share))
    if middle > UNEXPLAINED:
        text = (
            f"One force does not explain the responses: at the median line the second eigenvalue of the "
            f"spectral matrix is {100 * middle:.0f} % of the first, {100 * UNEXPLAINED:.0f} % being the "
            "limit. Noise and many forces at once look alike here."
        )
        advice = "Force harder, use quieter sensors, narrow the band, or stop other sources."
        return [Finding(NAME, "warning", (), middle, UNEXPLAINED, text, advice)]
    return []


def expected(seen: Evidence) -> FloatArray:
    """Second eigenvalue that one force gives with noise and leakage, (n_freq,)."""
    return np.asarray(np.maximum(noise_level(seen), seen.leakage), dtype=np.float64)


def noise_level(seen: Evidence) -> FloatArray:
    """Mean second eigenvalue under one force and noise, by line, from the lower ones; (n_freq,)."""
    assert seen.eigenvalues is not None
    rest = _smoothed(seen.eigenvalues[:, 2:].mean(axis=1))
    return noise_ratio(len(seen.dofs), seen.n_averages) * rest


def noise_ratio(n: int, n_averages: float) -> float:
    """Mean second eigenvalue over the mean of the lower ones, under one force and white noise.

    The n - 1 noise eigenvalues are those of a complex Wishart matrix; its largest one by Johnstone's limit
    (mean of the Tracy-Widom law -1.7711), the others by the trace.
    """
    p, m = n - 1.0, max(n_averages - 1.0, 1.0)
    a, b = np.sqrt(m), np.sqrt(p)
    largest = ((a + b) ** 2 - 1.7711 * (a + b) * (1.0 / a + 1.0 / b) ** (1.0 / 3.0)) / m
    largest = min(max(largest, 1.0), 0.95 * p)
    return float(largest * (p - 1.0) / (p - largest))


def _two_channels(seen: Evidence) -> NotTested:
    assert seen.coherence is not None
    level = float(np.median(seen.coherence))
    return NotTested(
        NAME,
        "two channels cannot tell a second force from noise; their coherence is "
        f"{level:.3g} at the median line, and what lacks to one is either",
    )


def _smoothed(values: FloatArray) -> FloatArray:
    """Running mean, so that the noise of a few channels has enough samples."""
    width = min(SMOOTHING, values.size)
    kernel = np.ones(width)
    return np.asarray(np.convolve(values, kernel, "same") / np.convolve(np.ones(values.size), kernel, "same"))
