"""Every kind of source brought to one form: a complex vector of responses a line.

The vector is known up to a factor a line, which cancels in every quotient. On the FRF route the force is one
more
row, so that FRFs are transmissibilities to the force. Channels are scaled to equal noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..exceptions import UnsuitableDataError
from ..signals.estimators import two_channel
from ..signals.frequency_response import FrequencyResponse
from ..signals.noise import noise_power
from ..signals.rankone import channel_noise, response_vectors
from ..signals.recording import Recording
from ..signals.segment_length import choose_nperseg
from ..signals.spectra import CrossSpectra, cross_spectra
from ..signals.transient import is_transient, require_stationary, transient_spectra
from ..support.validation import ComplexArray, FloatArray, reject

# Row index of the force in ``Lines.vectors``: the last.
FORCE = -1
# Signal-to-noise power beyond which a line gains no more weight: what is left there is leakage.
SNR_CAP = 1e4
# The SNR given to lines of data whose noise cannot be known; above the cap of the weights.
UNKNOWN_SNR = 1e12
# Lines over which the noise of measured curves is taken to be constant.
NOISE_LINES = 31
# Lines over which the noise of averaged spectra is taken to be constant.
FLOOR_LINES = 101


@dataclass(frozen=True)
class Lines:
    """Response vectors ``(n_rows, n_freq)``, of unit norm at every line, and their ``snr``, (n_freq,).

    ``segments`` are the scaled spectra that were averaged, (n_freq, n_rows, n_segments), with unit noise in
    every row; None where there are fewer than two. ``independent`` is the number of independent lines over
    the number of lines: the spectra of tapered, overlapping segments are correlated from line to line.
    ``averages_ratio`` is the number of segments over that of independent averages.
    """

    freq_hz: FloatArray
    vectors: ComplexArray
    snr: FloatArray
    added_decay_per_s: float = 0.0
    segments: ComplexArray | None = None
    independent: float = 1.0
    averages_ratio: float = 1.0

    def part(self, first: int, last: int) -> Lines:
        """Some of the lines."""
        some = None if self.segments is None else self.segments[first:last]
        return replace(
            self,
            freq_hz=self.freq_hz[first:last],
            vectors=self.vectors[:, first:last],
            snr=self.snr[first:last],
            segments=some,
        )

    def covariance(self) -> ComplexArray:
        """Covariance of the rows at every line, (n_freq, n_rows, n_rows), in units of the noise."""
        if self.segments is not None:
            return np.asarray(
                self.segments @ self.segments.conj().transpose(0, 2, 1) / self.segments.shape[2],
                dtype=np.complex128,
            )
        v = self.vectors.T
        return np.asarray(self.snr[:, None, None] * v[:, :, None] * v[:, None, :].conj())

    @property
    def capped_snr(self) -> FloatArray:
        """What the lines are worth as weights: never so much that leakage rules."""
        return np.asarray(self.snr / (1.0 + self.snr / SNR_CAP))

    @property
    def snr_known(self) -> bool:
        """False for transmissibilities, whose magnitude says nothing about noise."""
        return bool(self.snr[0] < UNKNOWN_SNR)

    def channel_snr(self, row: int) -> FloatArray:
        """Signal-to-noise power of one row."""
        return np.asarray(self.snr * np.abs(self.vectors[row]) ** 2, dtype=np.float64)

    def quotients(self, row: int) -> tuple[ComplexArray, FloatArray]:
        """All other rows over one row, and the sum of their squared magnitudes."""
        own = self.vectors[row]
        # A line at which the row vanishes would divide by zero; its weight will be nil.
        own = np.where(np.abs(own) < 1e-12, 1e-12, own)
        others = np.delete(self.vectors, row, axis=0) / own
        return others, np.sum(np.abs(others) ** 2, axis=0)


def lines_of(
    source: Recording | FrequencyResponse,
    band_hz: tuple[float, float],
    *,
    use_force: bool,
    nperseg: int | None,
    noverlap: int | None,
    window: Any,
    method: str,
    estimator: str,
) -> Callable[[int], Lines]:
    """Response vectors of either source; the argument is the row that will be divided by.

    The options of averaging are a record's.
    """
    if isinstance(source, Recording):
        return lines_of_recording(
            source,
            band_hz,
            use_force=use_force,
            nperseg=nperseg,
            noverlap=noverlap,
            window=window,
            method=method,
            estimator=estimator,
        )
    same = lines_of_response(source, band_hz, use_force=use_force)
    return lambda row: same


def lines_of_recording(
    rec: Recording,
    band_hz: tuple[float, float],
    *,
    use_force: bool,
    nperseg: int | None,
    noverlap: int | None,
    window: Any,
    method: str,
    estimator: str,
) -> Callable[[int], Lines]:
    """Response vectors of a record; the argument is the row that will be divided by."""
    transient = method == "transient" or (method == "auto" and is_transient(rec))
    if transient:
        kind = window if isinstance(window, str) and window in ("rectangular", "exponential") else "auto"
        spectra = transient_spectra(rec, window=kind, include_force=use_force)
    else:
        if method == "auto":
            require_stationary(rec)
        length = choose_nperseg(rec, band_hz) if nperseg is None else nperseg
        spectra = cross_spectra(
            rec, nperseg=length, noverlap=noverlap, window=window, include_force=use_force
        )
    spectra = _cut(spectra, band_hz)
    auto = np.einsum("fii->i", spectra.matrix).real
    if not auto.all():
        dead = int(np.flatnonzero(auto == 0.0)[0])
        name = f"dof {rec.dofs[dead]!r}" if dead < rec.n_channels else "the force"
        raise UnsuitableDataError(
            "source",
            f"no signal at all from {name} in the band",
            "a live channel",
            "Leave the dead channel out of the Recording.",
        )
    vectors, snr = response_vectors(spectra.matrix, spectra.noise)
    if transient:
        noise, snr = _noise_of_curves(_joined(vectors, auto_by_line=np.einsum("fii->f", spectra.matrix).real))
    else:
        noise = channel_noise(spectra.matrix, noise_power(spectra.matrix, spectra.n_effective))
        if use_force:
            # A force cell is far quieter than the responses: what a line is worth, the responses tell.
            snr = response_vectors(spectra.matrix[:, :FORCE, :FORCE])[1]
    white = vectors / np.sqrt(noise)[:, None]
    unit = 1.0 / np.sqrt(noise)
    if use_force:
        unit[FORCE] *= _middling(white[:FORCE] / white[FORCE])
    segments = None if transient else _segments(spectra, unit, use_force)
    independent = 1.0 if transient else min(1.0, rec.n_samples / length / spectra.n_effective)

    def lines(row: int) -> Lines:
        own = (
            vectors
            if estimator == "rank1"
            else two_channel(spectra.matrix, row % vectors.shape[0], estimator)[0]
        )
        return Lines(
            spectra.freq_hz,
            _unit(own * unit[:, None]),
            snr,
            spectra.added_decay_per_s,
            segments,
            independent,
            spectra.n_averages / spectra.n_effective,
        )

    return lines


def _segments(spectra: CrossSpectra, unit: FloatArray, use_force: bool) -> ComplexArray | None:
    """Spectra of the segments scaled to unit noise in every row, lines first."""
    if spectra.segments is None or spectra.n_averages < 2:
        return None
    scaled = np.ascontiguousarray((spectra.segments * unit[:, None, None]).transpose(2, 0, 1))
    some = scaled[:, : FORCE if use_force else None]
    values = np.linalg.eigvalsh(some @ some.conj().transpose(0, 2, 1) / scaled.shape[2])
    return np.asarray(scaled / np.sqrt(_floors(values))[:, None, None])


def _floors(values: FloatArray) -> FloatArray:
    """Noise power of every line: running median of the mean of all eigenvalues but the largest.

    Noise that is not white would otherwise bias the eigenvector of smallest misfit, which takes it for even.
    """
    from scipy.ndimage import median_filter  # slow to import

    if values.shape[1] < 2:
        return np.ones(values.shape[0])
    left = median_filter(values[:, :-1].mean(axis=1), size=FLOOR_LINES, mode="nearest")
    return np.asarray(np.maximum(left, max(1e-15 * float(values[:, -1].max()), 1e-300)))


def lines_of_response(resp: FrequencyResponse, band_hz: tuple[float, float], *, use_force: bool) -> Lines:
    """Response vectors of measured FRFs or transmissibilities."""
    inside = _inside(resp.freq_hz, band_hz)
    freq, values = resp.freq_hz[inside], resp.values[:, inside]
    power = np.mean(np.abs(values) ** 2, axis=1)
    if not power.all():
        dead = resp.dofs[int(np.flatnonzero(power == 0.0)[0])]
        raise UnsuitableDataError(
            "source",
            f"zeros only for dof {dead!r} in the band",
            "a live channel",
            "Leave the dead channel out of the FrequencyResponse.",
        )
    if resp.kind == "transmissibility":
        if use_force:
            reject(
                "route",
                "'frf' with a source of transmissibilities",
                "'transmissibility'",
                "Transmissibilities do not hold the FRFs.",
            )
        # A transmissibility's own magnitude says nothing about its signal-to-noise ratio.
        return Lines(freq, _unit(values), np.full(freq.size, UNKNOWN_SNR))
    noise, snr = _noise_of_curves(values)
    scaled = values / np.sqrt(noise)[:, None]
    if use_force:
        scaled = np.vstack([scaled, np.full((1, freq.size), _middling(scaled))])
    return Lines(freq, _unit(scaled), snr)


def _middling(frfs: ComplexArray) -> float:
    """A force of this size weighs as much as all responses together at the median line."""
    return float(np.median(np.linalg.norm(frfs, axis=0)))


def _joined(vectors: ComplexArray, auto_by_line: FloatArray) -> ComplexArray:
    """Vectors with their magnitude restored, each line's free phase turned to its neighbour's."""
    unit = _unit(vectors)
    step = np.angle(np.sum(unit[:, :-1].conj() * unit[:, 1:], axis=0))
    turn = np.concatenate([[0.0], np.cumsum(step)])
    return np.asarray(unit * np.sqrt(auto_by_line) * np.exp(-1j * turn))


def _noise_of_curves(values: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Typical noise power of every curve, and the signal-to-noise power of every line, from roughness alone.

    A single hit, or a given FRF, has no averages to tell its noise. What is rough from line to line is noise,
    or an error of another kind that the fit should not follow either (a joint that slips, a drifting mode).
    """
    local = _roughness(values, np.mean(np.abs(values) ** 2, axis=1))
    noise = np.median(local, axis=1)
    snr = np.sum(np.abs(values) ** 2 / noise[:, None], axis=0) / np.sum(local / noise[:, None], axis=0)
    return noise, snr


def _roughness(values: ComplexArray, power: FloatArray) -> FloatArray:
    """Local noise power of every curve, (n_outputs, n_freq): second differences, 6 times that of white noise.

    At a sharp resonance the curve itself bends within a line; there the noise comes out too high, which only
    keeps the few lines of the peak from ruling the fit.
    """
    from scipy.ndimage import median_filter  # slow to import

    if values.shape[1] < NOISE_LINES:
        return np.repeat(power[:, None], values.shape[1], axis=1)
    second = np.abs(values[:, 2:] - 2.0 * values[:, 1:-1] + values[:, :-2]) ** 2
    second = np.concatenate([second[:, :1], second, second[:, -1:]], axis=1)
    # The median of abs()**2 of complex Gaussian noise is ln 2 of its mean.
    noise = median_filter(second, size=(1, NOISE_LINES), mode="nearest") / (6.0 * np.log(2.0))
    return np.asarray(np.maximum(noise, 1e-12 * power[:, None]))


def _unit(vectors: ComplexArray) -> ComplexArray:
    norm = np.linalg.norm(vectors, axis=0)
    return np.asarray(vectors / np.where(norm > 0.0, norm, 1.0))


def _inside(freq_hz: FloatArray, band_hz: tuple[float, float]) -> Any:
    # Zero frequency is no line of a vibration test: means are removed, accelerations vanish.
    inside = (freq_hz >= band_hz[0]) & (freq_hz <= band_hz[1]) & (freq_hz > 0.0)
    if inside.sum() < 8:
        reject(
            "band_hz",
            f"({band_hz[0]:g}, {band_hz[1]:g}) Hz with {int(inside.sum())} lines in it",
            "a band with at least 8 frequency lines",
            "Widen the band, or use longer segments.",
        )
    return inside


def _cut(spectra: CrossSpectra, band_hz: tuple[float, float]) -> CrossSpectra:
    inside = _inside(spectra.freq_hz, band_hz)
    segments = None if spectra.segments is None else spectra.segments[:, :, inside]
    return replace(spectra, freq_hz=spectra.freq_hz[inside], matrix=spectra.matrix[inside], segments=segments)
