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
    """Derivatives of zeros by the covariances, for one solution ``c`` of a fit.

    What a draw x x' would move the coefficients' right-hand side by is summed over its lines once for all
    zeros, ``(n_coefficients, n_draws)``; a zero's influences are one product with it.
    """

    def __init__(self, fit: NumeratorFit, c: FloatArray, misfit: float, lines: Lines) -> None:
        self.fit, self.c = fit, c
        values, self._vectors = np.linalg.eigh(fit.form[: c.size, : c.size])
        gap = values - misfit
        # The solution itself, the smallest, is a matter of scale.
        keep = gap > max(UNDETERMINED * values[-1], 1e-300)
        keep[0] = False
        self._inverse = np.where(keep, 1.0 / np.where(keep, gap, 1.0), 0.0)
        if lines.segments is not None:
            pushed = self._pushed(lines.segments)
            count = lines.segments.shape[2]
            self._push = self._projected(pushed)
            scale = lines.averages_ratio / count**2
        else:
            single = (np.sqrt(lines.snr) * lines.vectors).T[:, :, None]
            pushed = self._pushed(single)
            count, scale = min(BLOCKS, len(pushed)), 1.0
            ends = np.linspace(0, len(pushed), count + 1).round().astype(int)
            blocks = [slice(a, b) for a, b in zip(ends[:-1], ends[1:], strict=True)]
            self._push = np.concatenate([self._projected(pushed, block) for block in blocks], axis=1)
        self._push -= self._push.mean(axis=1, keepdims=True)
        self._scale = scale * count / (count - 1)

    def _pushed(self, draws: ComplexArray) -> ComplexArray:
        """x x' N less its part along N, (n_freq, n, n_draws); ``draws`` x are (n_freq, n, n_draws)."""
        n = self.fit.values(self.c)
        along = n.conj()[:, None, :] @ draws
        length = np.sum(np.abs(n) ** 2, axis=1)[:, None, None]
        return np.asarray(draws * along.conj() - n[:, :, None] * (np.abs(along) ** 2 / length))

    def _projected(self, pushed: ComplexArray, lines: slice = slice(None)) -> FloatArray:
        """Its product with the polynomials over some lines, (n_coefficients, n_draws)."""
        some = pushed[lines]
        flat = self.fit.projected(some.reshape(len(some), -1), self.c.shape[0] - 1, lines)
        return flat.reshape(self.c.size, pushed.shape[2])

    def standard_deviations(self, row: int, s: ComplexArray) -> FloatArray:
        """Standard deviation in Hz of zeros ``s`` (rad/s) of one row."""
        slope = self.fit.slopes(self.c, row, s)
        by_size = (slope * s.conj()[:, None]).real / np.abs(s)[:, None]
        gradient = np.zeros((s.size, *self.c.shape))
        gradient[:, :, row] = by_size
        flat = gradient.reshape(s.size, self.c.size) @ self._vectors
        moved = ((flat * self._inverse) @ self._vectors.T) @ self._push
        return np.asarray(np.sqrt(self._scale * np.sum(moved**2, axis=1)) / (2 * np.pi))
