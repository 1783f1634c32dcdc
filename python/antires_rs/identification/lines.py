"""The common form of all sources: a complex vector of responses a line, and what it is worth.

The vector is known up to a factor a line, which cancels in every quotient. On the FRF route the force is one
more row, so that FRFs are transmissibilities to the force. Channels are scaled to equal noise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..signals.segments import Segments
from ..support.validation import ComplexArray, FloatArray

__all__ = ["FORCE", "SNR_CAP", "Lines", "unit"]

# Row index of the force in ``Lines.vectors``: the last.
FORCE = -1
# Signal-to-noise power beyond which a line gains no more weight: what is left there is leakage.
SNR_CAP = 1e4


@dataclass(frozen=True)
class Lines:
    """Response vectors ``(n_rows, n_freq)``, of unit norm at every line, and their ``snr``, (n_freq,).

    ``segments`` are the spectra that were averaged, (n_freq, n_rows, n_segments), scaled to unit noise in
    every row; None where there are fewer than two. ``independent`` is the number of independent lines over
    the number of lines: the spectra of tapered, overlapping segments are correlated from line to line.
    ``averages_ratio`` is the number of segments over that of independent averages. ``draws`` are the
    independent draws (impacts, or records of one test) to which the segments belong, (n_segments,); None for
    one record. ``size`` is what the vectors were divided by, where that is a property of the structure: the
    norm of measured FRFs or of the responses to one impact, (n_freq,); None for transmissibilities and for
    responses to a force of unknown spectrum. ``noise_given`` says that the signal-to-noise ratio came with
    the curves. ``runs`` are the unit vectors of each of several tests whose average the vectors are, scaled
    alike, (n_freq, n_rows, n_tests).
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

    def part(self, first: int, last: int) -> Lines:
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
        each = Segments.of(np.sqrt(self.snr)[:, None, None] * self.runs)
        return replace(self, segments=each, draws=draws)

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


def unit(vectors: ComplexArray) -> ComplexArray:
    """Vectors (n_rows, n_freq) scaled to unit norm at every line."""
    norm = np.linalg.norm(vectors, axis=0)
    return np.asarray(vectors / np.where(norm > 0.0, norm, 1.0))
