r"""How far an identified value may be off: standard deviations from the scatter of the segments.

The coefficients c solve (A - mu I) c = 0, so a change dA moves them by

    dc = -(A - mu I)^+ dA c,      dA c = -sum_f g_f Re phi' (dC_f N - (N' dC_f N / N'N) N)

and a zero s of N_j by its slope ds/dc. Each Welch segment is one independent draw of all C_f at once;
what its own x x' would move the zero by is its influence, and the variance of the mean of K influences is
the variance of the zero (the infinitesimal jackknife). Nothing is assumed of the noise: coloured noise,
leakage, and what the segments share between neighbouring lines are in the scatter. Where there are no
segments, blocks of neighbouring lines take their place.

References: B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM 1982, ch. 6; H. White,
Econometrica 50 (1982) 1-25.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray
from .lines import Lines
from .numerators import NumeratorFit

# Without segments: so many blocks of neighbouring lines stand for independent draws.
BLOCKS = 64
# Directions of the coefficients that the data do not determine (a common factor) move no zero of one
# numerator; below this share of the largest eigenvalue they are left out.
UNDETERMINED = 1e-12


class Influence:
    """Derivatives of zeros by the covariances, for one solution ``c`` of a fit."""

    def __init__(self, fit: NumeratorFit, c: FloatArray, misfit: float) -> None:
        self.fit, self.c = fit, c
        size = c.size
        values, self._vectors = np.linalg.eigh(fit.form[:size, :size])
        gap = values - misfit
        # The solution itself, the smallest, is a matter of scale.
        keep = gap > max(UNDETERMINED * values[-1], 1e-300)
        keep[0] = False
        self._inverse = np.where(keep, 1.0 / np.where(keep, gap, 1.0), 0.0)
        self.directions = fit.values(c)

    def fields(self, row: int, s: ComplexArray) -> ComplexArray:
        """What a change of C_f moves abs(s) of each zero by: (n_zeros, n_freq, n), see ``of_segments``."""
        slope = self.fit.slopes(self.c, row, s)
        by_size = (slope * s.conj()[:, None]).real / np.abs(s)[:, None]
        gradient = np.zeros((s.size, *self.c.shape))
        gradient[:, :, row] = by_size
        flat = gradient.reshape(s.size, self.c.size) @ self._vectors
        u = ((flat * self._inverse) @ self._vectors.T).reshape(gradient.shape)
        stacked = self.fit.values(u.transpose(1, 2, 0).reshape(self.c.shape[0], self.c.shape[1] * s.size))
        out = stacked.reshape(self.directions.shape[0], self.c.shape[1], s.size).transpose(2, 0, 1)
        return np.asarray(out * self.fit.weights[:, None])

    def by_line(self, fields: ComplexArray, segments: ComplexArray) -> FloatArray:
        """Influence of each line of each segment, summed over the segments, (n_zeros, n_freq), rad/s."""
        return np.asarray(self._moves(fields, segments).sum(axis=2))

    def of_segments(self, fields: ComplexArray, segments: ComplexArray) -> FloatArray:
        """Influence of each segment on each zero, (n_zeros, n_segments), rad/s.

        ``segments`` are the scaled spectra x, (n_freq, n, n_segments), whose mean of x x' is C.
        """
        return np.asarray(self._moves(fields, segments).sum(axis=1))

    def _moves(self, fields: ComplexArray, segments: ComplexArray) -> FloatArray:
        """What every line of every segment adds, (n_zeros, n_freq, n_segments)."""
        n = self.directions
        along = n.conj()[:, None, :] @ segments
        length = np.sum(np.abs(n) ** 2, axis=1)
        across = fields.conj().transpose(1, 0, 2) @ segments
        slip = np.einsum("zfa,fa->fz", fields.conj(), n).real / length[:, None]
        moves = (across * along.conj()).real - slip[:, :, None] * np.abs(along) ** 2
        return np.asarray(moves.transpose(1, 0, 2))


def standard_deviations(influence: Influence, row: int, s: ComplexArray, lines: Lines) -> FloatArray:
    """Standard deviation in Hz of zeros ``s`` of one row."""
    fields = influence.fields(row, s)
    if lines.segments is not None:
        moved = influence.of_segments(fields, lines.segments)
        scale = lines.averages_ratio / moved.shape[1] ** 2
    else:
        single = (np.sqrt(lines.snr) * lines.vectors).T[:, :, None]
        by_line = influence.by_line(fields, single)
        blocks = np.array_split(by_line, min(BLOCKS, by_line.shape[1]), axis=1)
        moved = np.stack([block.sum(axis=1) for block in blocks], axis=1)
        scale = 1.0
    count = moved.shape[1]
    spread = moved - moved.mean(axis=1, keepdims=True)
    variance = scale * count / (count - 1) * np.sum(spread**2, axis=1)
    return np.asarray(np.sqrt(variance) / (2 * np.pi))
