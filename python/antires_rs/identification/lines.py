"""The common form of all sources: a complex vector of responses a line, and what it is worth.

The vector is known up to a factor a line, which cancels in every quotient. On the FRF route the force is one
more row, so that FRFs are transmissibilities to the force. Channels are scaled to equal noise.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..exceptions import UnsuitableDataError, reject
from ..signals.averaging import LEAST_LINES, Averages
from ..signals.frequency_response import FrequencyResponse
from ..signals.recording import Recording
from ..signals.repeats import AveragedResponse
from ..signals.spectra import (
    LEAST_DIRECTION_NOISE as ROUNDING,
    Segments,
    aligned,
    channel_noise,
    direction_noise,
    dominant,
    floors,
    lines_in,
    local_noise,
    noise_shares,
    response_vectors,
    two_channel,
)
from ..support.checks import ComplexArray, FloatArray
from .options import IdentificationOptions

FORCE = -1  # row index of the force in ``Lines.vectors``: the last
SNR_CAP = 1e4  # signal-to-noise power beyond which a line gains no more weight: what is left there is leakage


@dataclass(frozen=True)
class Lines:
    """Response vectors ``(n_rows, n_freq)``, of unit norm at every line, and their ``snr``, (n_freq,).

    ``segments`` are the spectra that were averaged, scaled to unit noise in every row; None where there are
    fewer than two. ``independent`` is the number of independent lines over all: spectra of tapered,
    overlapping segments are correlated. ``averages_ratio`` is the number of segments over that of independent
    averages. ``draws`` are the independent draws (impacts, or records of one test) to which the segments
    belong; None for one record. ``size`` is what the vectors were divided by, where that is a property of the
    structure: the norm of measured FRFs or of the responses to one impact. ``noise_given``: the
    signal-to-noise ratio came with the curves. ``runs`` are the unit vectors of each of several tests whose
    average the vectors are, scaled alike, (n_freq, n_rows, n_tests). Lines below ``least_snr`` hold no
    direction by which a fit may be judged. ``order`` is the number of forces.
    """

    freq_hz: FloatArray
    vectors: ComplexArray
    snr: FloatArray
    added_decay_per_s: float = 0.0
    segments: Segments | None = None
    independent: float = 1.0
    averages_ratio: float = 1.0
    draws: NDArray[np.int64] | None = None
    size: FloatArray | None = None
    noise_given: bool = False
    runs: ComplexArray | None = None
    least_snr: float = 0.0
    order: int = 1

    def part(self, first: int, last: int) -> Self:
        """Some of the lines."""
        inside = slice(first, last)
        return replace(
            self,
            freq_hz=self.freq_hz[inside],
            vectors=self.vectors[:, inside],
            snr=self.snr[inside],
            segments=None if self.segments is None else self.segments.part(inside),
            size=None if self.size is None else self.size[inside],
            runs=None if self.runs is None else self.runs[inside],
        )

    def projected(self, directions: FloatArray) -> Lines:
        """The same lines in an orthonormal basis, (n_rows, n_directions), that holds their signal."""
        inside = directions.T @ self.vectors
        share = np.sum(np.abs(inside) ** 2, axis=0)
        segments = None if self.segments is None else self.segments.projected(directions)
        runs = None
        if self.runs is not None:
            runs = (directions.T @ self.runs) / np.sqrt(np.maximum(share, 1e-300))[:, None, None]
        return replace(
            self, vectors=unit(inside), snr=self.snr * share, segments=segments, size=None, runs=runs
        )

    def by_test(self) -> Lines:
        """The same lines with what each test gave as one segment."""
        if self.runs is None:
            return self
        draws = np.arange(self.runs.shape[2])
        return replace(self, segments=Segments.of(np.sqrt(self.snr)[:, None, None] * self.runs), draws=draws)

    @property
    def n_tests(self) -> int:
        """Independent draws that tell the scatter between tests; 1 if nothing does."""
        if self.runs is not None:
            return int(self.runs.shape[2])
        return 1 if self.draws is None or self.segments is None else int(np.unique(self.draws).size)

    def covariance(self, lines: slice = slice(None)) -> ComplexArray:
        """Covariance of the rows at some lines, (n_lines, n_rows, n_rows), in units of the noise."""
        if self.segments is not None:
            return self.segments.covariance(lines)
        v = self.vectors.T[lines]
        return np.asarray(self.snr[lines, None, None] * v[:, :, None] * v[:, None, :].conj())

    @property
    def capped_snr(self) -> FloatArray:
        """What the lines are worth as weights: never so much that leakage rules."""
        return np.asarray(self.snr / (1.0 + self.snr / SNR_CAP))

    def channel_snr(self, row: int) -> FloatArray:
        """Signal-to-noise power of one row."""
        return np.asarray(self.snr * np.abs(self.vectors[row]) ** 2, dtype=np.float64)

    def quotients(self, row: int) -> tuple[ComplexArray, FloatArray]:
        """All other rows over one row, and the sum of their squared magnitudes."""
        own = self.vectors[row]
        # A line at which the row vanishes would divide by zero; its weight will be nil.
        own = np.where(np.abs(own) < 1e-12, 1e-12, own)
        others = np.delete(self.vectors, row, axis=0) * (1.0 / own)
        return others, np.sum(others.real**2 + others.imag**2, axis=0)


def unit(vectors: ComplexArray, axis: int = 0) -> ComplexArray:
    """Vectors (n_rows, n_freq) scaled to unit norm at every line; ``axis`` is that of the rows."""
    norm = np.linalg.norm(vectors, axis=axis, keepdims=True)
    return np.asarray(vectors / np.where(norm > 0.0, norm, 1.0))


# -- Lines of single curves: measured FRFs and transmissibilities, and the responses to one impact
#
# Nothing was averaged, so the noise comes with the curves (``std``, or coherence and averages) or is taken
# from them: what is rough from line to line is noise, or an error of another kind that the fit should not
# follow either (a joint that slips, a mode that drifts).


def curve_lines(
    freq_hz: FloatArray,
    values: ComplexArray,
    force: ComplexArray | None = None,
    *,
    std: FloatArray | None = None,
    runs: ComplexArray | None = None,
    size_known: bool = False,
    added_decay_per_s: float = 0.0,
) -> Lines:
    """Vectors of equal noise, and what each line is worth."""
    rows = values if force is None else np.vstack([values, _weighty(force, values)])
    power = np.sum(np.abs(rows) ** 2, axis=0)
    directions = aligned(rows)
    if std is not None:
        row, line = noise_shares(np.maximum(2.0 * std**2 / np.where(power > 0.0, power, 1.0), ROUNDING))
    elif force is None:
        row, line = noise_shares(direction_noise(directions))
    else:
        # Of FRFs the noise is nearly the same at all lines, that of their directions is not.
        row, line = noise_shares(local_noise(values))
        line = np.maximum(line / np.where(power > 0.0, power, 1.0), 1e-300)
    scaled = values / np.sqrt(row)[:, None]
    size = np.linalg.norm(scaled, axis=0)
    # Of all rows but the force, whose noise is not that of a response.
    snr = np.sum(np.abs(directions[: len(values)]) ** 2 / row[:, None], axis=0) / line
    if force is not None:
        scaled = np.vstack([scaled, _weighty(force, scaled)])
        responses, size = size, np.linalg.norm(scaled, axis=0)
        if std is None:
            # What roughness tells is a start, careful by the number of responses; residuals replace it.
            snr = snr / len(values)
        else:
            # Noise that is known counts as it is, over a vector that the force, without noise, makes longer.
            snr = snr * (size / np.where(responses > 0.0, responses, 1.0)) ** 2
    if runs is not None:  # the force, no row or one, is the same in all
        forces = np.broadcast_to(scaled[len(values) :], (len(runs), len(scaled) - len(values), freq_hz.size))
        vectors = unit(np.concatenate([runs / np.sqrt(row)[:, None], forces], axis=1), axis=1)
        runs = np.ascontiguousarray(vectors.transpose(2, 1, 0))
    return Lines(
        freq_hz,
        unit(scaled),
        snr,
        added_decay_per_s=added_decay_per_s,
        size=size if size_known else None,
        noise_given=std is not None,
        runs=runs,
    )


def _weighty(force: ComplexArray, responses: ComplexArray) -> ComplexArray:
    """The force as a row that weighs as much as all responses together at the median line."""
    ratio = np.linalg.norm(responses, axis=0) / np.maximum(np.abs(force), 1e-300)
    return np.asarray(float(np.median(ratio)) * force[None, :])


# -- Every kind of source brought to the common form, a complex vector of responses a line

# From so many impacts on, their scatter tells the noise; of a single one the roughness of its curves does.
LEAST_IMPACTS = 2


def lines_of(
    source: Recording | FrequencyResponse,
    averages: Averages | None,
    band_hz: tuple[float, float],
    options: IdentificationOptions,
) -> Callable[[int], Lines]:
    """Response vectors by the row that will be divided by; ``averages`` of a record, None for curves."""
    use_force, estimator = options.use_force, options.call.estimator
    if isinstance(source, FrequencyResponse):
        same = lines_of_response(source, band_hz, use_force=use_force)
        return lambda row: same
    assert averages is not None
    spectra = averages.spectra
    _require_lines(spectra.freq_hz.size, band_hz, 0.5 * source.fs_hz)
    auto = np.einsum("fii->i", spectra.matrix).real
    require_live(auto, source.dofs, "no signal at all from {} in the band", "Recording")
    vectors, snr = response_vectors(spectra.matrix, spectra.noise)
    if averages.nperseg is None and spectra.n_averages < LEAST_IMPACTS:
        size = np.sqrt(np.einsum("fii->f", spectra.matrix).real)
        values = unit(vectors) * size
        force = values[FORCE] if use_force else None
        one = curve_lines(
            spectra.freq_hz,
            values[:FORCE] if use_force else values,
            force,
            added_decay_per_s=spectra.added_decay_per_s,
        )
        return lambda row: one
    noise = channel_noise(spectra.matrix, spectra.noise_power)
    if use_force:
        # A force cell is far quieter than the responses: what a line is worth, the responses tell.
        snr = response_vectors(spectra.matrix[:, :FORCE, :FORCE])[1]
    white = vectors / np.sqrt(noise)[:, None]
    scale = 1.0 / np.sqrt(noise)
    if use_force:
        # The force weighs as much as all responses together at the median line.
        scale[FORCE] *= float(np.median(np.linalg.norm(white[:FORCE] / white[FORCE], axis=0)))
    segments = None
    if spectra.segments is not None and spectra.n_averages >= 2:
        # Of unit noise in every row; of two rows or more the others tell how much there is at each line.
        segments = spectra.segments.times(scale)
        some = slice(FORCE if use_force else None)
        if scale[some].size >= 2:
            ones = np.ones(scale[some].size)
            largest, rest, _ = dominant(segments.covariance()[:, some, some], ones)
            segments = segments.times(1.0 / np.sqrt(floors(largest, rest))[:, None])

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
            *averages.scatter,
        )

    return lines


def lines_of_response(resp: FrequencyResponse, band_hz: tuple[float, float], *, use_force: bool) -> Lines:
    """Response vectors of measured FRFs or transmissibilities."""
    inside = lines_in(resp.freq_hz, band_hz)
    _require_lines(inside.stop - inside.start, band_hz, float(resp.freq_hz[-1]))
    freq, values = resp.freq_hz[inside], resp.values[:, inside]
    power = np.mean(np.abs(values) ** 2, axis=1)
    require_live(power, resp.dofs, "zeros only for {} in the band", "FrequencyResponse")
    if resp.kind == "transmissibility" and use_force:
        got = "'frf' with a source of transmissibilities"
        reject("route", got, "'transmissibility'", "Transmissibilities do not hold the FRFs.")
    return curve_lines(
        freq,
        values,
        np.ones(freq.size, dtype=np.complex128) if use_force else None,
        std=None if resp.std is None else resp.std[:, inside],
        runs=resp.runs[:, :, inside] if isinstance(resp, AveragedResponse) else None,
        size_known=resp.kind == "frf",
    )


def require_live(power: FloatArray, dofs: tuple[Any, ...], got: str, kind: str) -> None:
    """Refuse channels without any power; the one after the dofs is the force."""
    for dead in np.flatnonzero(power == 0.0):
        name = f"dof {dofs[dead]!r}" if dead < len(dofs) else "the force"
        remedy = f"Leave the dead channel out of the {kind}."
        raise UnsuitableDataError("source", got.format(name), "a live channel", remedy)


def _require_lines(count: int, band_hz: tuple[float, float], highest_hz: float) -> None:
    if count < LEAST_LINES:
        got = f"({band_hz[0]:g}, {band_hz[1]:g}) Hz with {count} lines in it"
        remedy = f"Widen the band, in Hz: the data reach to {highest_hz:g} Hz. Or use longer segments."
        reject("band_hz", got, f"a band with at least {LEAST_LINES} frequency lines", remedy)
