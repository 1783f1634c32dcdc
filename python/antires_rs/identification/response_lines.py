"""Every kind of source brought to the common form, a complex vector of responses a line."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..exceptions import UnsuitableDataError
from ..signals.averaging import Averages
from ..signals.eigen import dominant
from ..signals.estimators import two_channel
from ..signals.frequency_response import FrequencyResponse
from ..signals.noise import channel_noise, floors
from ..signals.rankone import response_vectors
from ..signals.recording import Recording
from ..signals.repeats import AveragedResponse
from ..signals.segment_length import LEAST_LINES
from ..signals.segments import Segments
from ..signals.spectra import CrossSpectra, lines_in
from ..support.validation import ComplexArray, FloatArray, reject
from .curve_lines import curve_lines
from .lines import FORCE, Lines, unit

# From so many impacts on, their scatter tells the noise; of a single one the roughness of its curves does.
LEAST_IMPACTS = 2


def lines_of(
    source: Recording | FrequencyResponse,
    averages: Averages | None,
    band_hz: tuple[float, float],
    *,
    use_force: bool,
    estimator: str,
) -> Callable[[int], Lines]:
    """Response vectors of either source; the argument is the row that will be divided by.

    ``averages`` are those of a record, with the force where it is used; None for measured curves.
    """
    if isinstance(source, Recording):
        assert averages is not None
        return lines_of_recording(source, averages, band_hz, use_force=use_force, estimator=estimator)
    same = lines_of_response(source, band_hz, use_force=use_force)
    return lambda row: same


def lines_of_recording(
    rec: Recording, averages: Averages, band_hz: tuple[float, float], *, use_force: bool, estimator: str
) -> Callable[[int], Lines]:
    """Response vectors of a record; the argument is the row that will be divided by."""
    spectra = averages.spectra
    _require_lines(spectra.freq_hz.size, band_hz, 0.5 * rec.fs_hz)
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
    if averages.nperseg is None and spectra.n_averages < LEAST_IMPACTS:
        size = np.sqrt(np.einsum("fii->f", spectra.matrix).real)
        values = unit(vectors) * size
        force = values[FORCE] if use_force else None
        one = curve_lines(
            spectra.freq_hz,
            values[:FORCE] if use_force else values,
            force,
            size_known=not use_force,
            added_decay_per_s=spectra.added_decay_per_s,
        )
        return lambda row: one
    noise = channel_noise(spectra.matrix, spectra.noise_power)
    if use_force:
        # A force cell is far quieter than the responses: what a line is worth, the responses tell.
        snr = response_vectors(spectra.matrix[:, :FORCE, :FORCE])[1]
    length = averages.nperseg
    independent = 1.0 if length is None else min(1.0, rec.n_samples / length / spectra.n_effective)
    white = vectors / np.sqrt(noise)[:, None]
    scale = 1.0 / np.sqrt(noise)
    if use_force:
        scale[FORCE] *= _middling(white[:FORCE] / white[FORCE])
    segments = _segments(spectra, scale, use_force)

    def lines(row: int) -> Lines:
        own = (
            vectors
            if estimator == "rank1"
            else two_channel(spectra.matrix, row % vectors.shape[0], estimator)[0]
        )
        return Lines(
            spectra.freq_hz,
            unit(own * scale[:, None]),
            snr,
            spectra.added_decay_per_s,
            segments,
            independent,
            spectra.n_averages / spectra.n_effective,
            spectra.draws,
        )

    return lines


def _segments(spectra: CrossSpectra, scale: FloatArray, use_force: bool) -> Segments | None:
    """Spectra of the segments scaled to unit noise in every row."""
    if spectra.segments is None or spectra.n_averages < 2:
        return None
    scaled = spectra.segments.times(scale)
    some = slice(FORCE if use_force else None)
    if scale[some].size < 2:
        return scaled
    largest, rest, _ = dominant(scaled.covariance()[:, some, some], np.ones(scale[some].size))
    return scaled.times(1.0 / np.sqrt(floors(largest, rest))[:, None])


def lines_of_response(resp: FrequencyResponse, band_hz: tuple[float, float], *, use_force: bool) -> Lines:
    """Response vectors of measured FRFs or transmissibilities."""
    inside = lines_in(resp.freq_hz, band_hz)
    _require_lines(inside.stop - inside.start, band_hz, float(resp.freq_hz[-1]))
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
    if resp.kind == "transmissibility" and use_force:
        reject(
            "route",
            "'frf' with a source of transmissibilities",
            "'transmissibility'",
            "Transmissibilities do not hold the FRFs.",
        )
    return curve_lines(
        freq,
        values,
        np.ones(freq.size, dtype=np.complex128) if use_force else None,
        std=None if resp.std is None else resp.std[:, inside],
        runs=resp.runs[:, :, inside] if isinstance(resp, AveragedResponse) else None,
        size_known=resp.kind == "frf",
    )


def _middling(frfs: ComplexArray) -> float:
    """A force of this size weighs as much as all responses together at the median line."""
    return float(np.median(np.linalg.norm(frfs, axis=0)))


def _require_lines(count: int, band_hz: tuple[float, float], highest_hz: float) -> None:
    if count < LEAST_LINES:
        reject(
            "band_hz",
            f"({band_hz[0]:g}, {band_hz[1]:g}) Hz with {count} lines in it",
            f"a band with at least {LEAST_LINES} frequency lines",
            f"Widen the band, in Hz: the data reach to {highest_hz:g} Hz. Or use longer segments.",
        )
