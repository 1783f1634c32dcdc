r"""How far an identified value may be off: standard deviations from the scatter of the segments.

The coefficients c solve (A - mu I) c = 0, so a change dA moves them by

    dc = -(A - mu I)^+ dA c,      dA c = -sum_f g_f Re phi' (dC_f N - (N' dC_f N / N'N) N)

and a zero s of N_j by its slope ds/dc. Each Welch segment is one independent draw of all C_f at once;
what its own x x' would move the zero by is its influence, and the variance of the mean of K influences is
the variance of the zero (the infinitesimal jackknife). Nothing is assumed of the noise: coloured noise,
leakage, and what the segments share between neighbouring lines are in the scatter. Where there are no
segments, blocks of neighbouring lines take their place. The scatter between several records of a test, or
several impacts, is added as module :mod:`~antires_rs.identification.repeat_scatter` says.

References: B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM 1982, ch. 6; H. White,
Econometrica 50 (1982) 1-25.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..order_sweep.limits import WIDEST
from ..signals.segments import pieces
from ..support.validation import ComplexArray, FloatArray
from .lines import Lines
from .numerators import NumeratorFit
from .repeat_scatter import combined, excess, sums_by_draw

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
        self._values = fit.values(c)
        self._draw_count = 1 if lines.segments is None else lines.segments.count
        self._sums: FloatArray | None = None
        self._excess = 1.0
        values, self._vectors = np.linalg.eigh(fit.form[: c.size, : c.size])
        gap = values - misfit
        # The solution itself, the smallest, is a matter of scale.
        keep = gap > max(UNDETERMINED * values[-1], 1e-300)
        keep[0] = False
        self._inverse = np.where(keep, 1.0 / np.where(keep, gap, 1.0), 0.0)
        if lines.segments is not None:
            draws, count = lines.segments.at, lines.segments.count
            whole = slice(0, lines.freq_hz.size)
            self._push = self._pushed(draws, whole)
            scale = lines.averages_ratio / count**2
            if lines.draws is not None:
                self._sums = sums_by_draw(self._push, lines.draws) / count
                if self._sums.shape[1] == count:  # of one impact each: inside it, blocks of lines
                    each = [self._pushed(draws, block) for block in _blocks(whole.stop)]
                    self._push = np.concatenate(
                        [one - one.mean(axis=1, keepdims=True) for one in each], axis=1
                    )
                    self._scale = 1.0 / (count * (count - 1.0))
                    return
        else:
            single = (np.sqrt(lines.snr) * lines.vectors).T[:, :, None]
            blocks = _blocks(len(single))
            count, scale = len(blocks), 1.0
            self._push = np.concatenate([self._pushed(single.__getitem__, block) for block in blocks], axis=1)
        self._push -= self._push.mean(axis=1, keepdims=True)
        self._scale = scale * count / (count - 1)

    def _pushed(self, draws: Callable[[slice], ComplexArray], lines: slice) -> FloatArray:
        """Products of the polynomials with x x' N less its part along N, (n_coefficients, n_draws).

        Summed over some lines; the draws x at lines are (n_lines, n, n_draws).
        """
        total: FloatArray | None = None
        for some in pieces(lines.stop - lines.start, self._values.shape[1] * self._draw_count):
            at = slice(lines.start + some.start, lines.start + some.stop)
            n, x = self._values[at], draws(at)
            along = n.conj()[:, None, :] @ x
            length = np.sum(np.abs(n) ** 2, axis=1)[:, None, None]
            part = x * along.conj()
            part -= n[:, :, None] * (np.abs(along) ** 2 / length)
            flat = self.fit.projected(part.reshape(len(part), -1), self.c.shape[0] - 1, at)
            total = flat if total is None else total + flat
        assert total is not None
        return total.reshape(self.c.size, -1)

    def pool(self, roots: Sequence[ComplexArray]) -> None:
        """Let the zeros of all rows tell how much repeats of the test scatter beyond what is inside each."""
        if self._sums is None:
            return
        light = [s[(s.imag > 0.0) & (np.abs(s.real) <= WIDEST * np.abs(s))] for s in roots]
        both = [self.variances(row, s) for row, s in enumerate(light) if s.size]
        within, between = np.concatenate([np.empty((2, 0)), *map(np.stack, both)], axis=1)
        self._excess = excess(between, within, self._sums.shape[1])

    def standard_deviations(self, row: int | FloatArray, s: ComplexArray) -> FloatArray:
        """Standard deviation in Hz of zeros ``s`` (rad/s) of one row, or of a weighted sum of all rows."""
        within, between = self.variances(row, s)
        if self._sums is not None:
            within = combined(between, within, self._sums.shape[1], self._excess)
        return np.asarray(np.sqrt(within))

    def variances(self, row: int | FloatArray, s: ComplexArray) -> tuple[FloatArray, FloatArray]:
        """Variances in Hz^2 from the scatter inside the draws, and from that between them (0 for one)."""
        weights = np.eye(self.c.shape[1])[row] if isinstance(row, int) else row
        slope = self.fit.slopes(self.c @ weights, s)
        by_size = (slope * s.conj()[:, None]).real / np.abs(s)[:, None]
        gradient = by_size[:, :, None] * weights
        flat = gradient.reshape(s.size, self.c.size) @ self._vectors
        moves = (flat * self._inverse) @ self._vectors.T / (2 * np.pi)
        within = self._scale * np.sum((moves @ self._push) ** 2, axis=1)
        if self._sums is None:
            return within, np.zeros(s.size)
        n = self._sums.shape[1]
        return within, n / (n - 1.0) * np.sum((moves @ self._sums) ** 2, axis=1)


def _blocks(n_lines: int) -> list[slice]:
    """Neighbouring lines that stand for independent draws."""
    ends = np.linspace(0, n_lines, min(BLOCKS, n_lines) + 1).round().astype(int)
    return [slice(a, b) for a, b in zip(ends[:-1], ends[1:], strict=True)]
