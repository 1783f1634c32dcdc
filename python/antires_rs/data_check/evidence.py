"""What the tests look at: spectra in the band, brought to equal noise, and their eigenvalues."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..signals.eigen import spectrum
from ..signals.roughness import typical_noise
from ..signals.segments import pieces
from ..signals.spectra import CrossSpectra
from ..support.validation import ComplexArray, FloatArray

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
