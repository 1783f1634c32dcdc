r"""How far an identified value may be off: standard deviations from the scatter of the segments.

The coefficients c solve (A - mu I) c = 0, so a change dA moves them by

    dc = -(A - mu I)^+ dA c,      dA c = -sum_f g_f Re phi' (dC_f N - (N' dC_f N / N'N) N)

and a zero s of N_j by its slope ds/dc. Each Welch segment is one independent draw of all C_f at once;
what its own x x' would move the zero by is its influence, and the variance of the mean of K influences is
the variance of the zero (the infinitesimal jackknife). Nothing is assumed of the noise: coloured noise,
leakage, and what the segments share between neighbouring lines are in the scatter. Where there are no
segments, blocks of neighbouring lines take their place. The scatter between several records of a test, or
several impacts, is added as module :mod:`~antires_rs.identification.uncertainty` says.

References: B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM 1982, ch. 6; H. White,
Econometrica 50 (1982) 1-25.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..signals.segments import pieces
from ..signals.spectra import CrossSpectra
from ..support.checks import ComplexArray, FloatArray
from .lines import Lines
from .numerators import Likeliest, NumeratorFit
from .rule import WIDEST

# -- The scatter between repeats of a test, in the variance of an identified value
#
# R records of one test, R impacts, or the curves of R tests are R independent draws. What each would move a
# zero by, summed over the record, gives
#
#     b^2 = R / (R - 1) sum_r (u_r - mean u)^2
#
# which holds whatever differs from record to record: noise, the strength of the force, temperature,
# mounting. But it has R - 1 degrees of freedom only. The scatter inside the records (of their segments; of
# an impact or a curve, in blocks of neighbouring lines) has many, and knows noise and leakage alone: w^2.
# Their ratio is much the same for all zeros of a test, so that all tell of it together:
#
#     q = max(1, median of b^2 / w^2 over all zeros / median of chi^2_{R-1} / (R - 1)),
#
# and the variance of one zero is the average of what it says itself and what the test says, by their
# degrees of freedom,
#
#     ((R - 1) b^2 + n_0 q w^2) / (R - 1 + n_0),      n_0 = 8.
#
# Reference: G. K. Smyth, Stat. Appl. Genet. Mol. Biol. 3 (2004) article 3 (moderated variances).


# Degrees of freedom with which the whole test speaks on the variance of one zero.
PRIOR = 8.0


def sums_by_draw(push: FloatArray, draws: NDArray[np.int64]) -> FloatArray:
    """Columns of ``push`` (n_coefficients, n_segments), less their mean, summed by draw: R columns."""
    centred = push - push.mean(axis=1, keepdims=True)
    return np.stack([centred[:, draws == draw].sum(axis=1) for draw in np.unique(draws)], axis=1)


def excess(between: FloatArray, within: FloatArray, n_draws: int) -> float:
    """q of the module, from the variances of many zeros, (n,) each."""
    from scipy.stats import chi2  # slow to import

    if not between.size:
        return 1.0
    middle = float(chi2.ppf(0.5, n_draws - 1)) / (n_draws - 1)
    return max(1.0, float(np.median(between / np.maximum(within, 1e-300))) / middle)


def independent_averages(spectra: CrossSpectra) -> float:
    """How many independent averages stand behind the standard deviations that these spectra give."""
    if spectra.draws is None:
        return spectra.n_effective
    return min(freedom(np.unique(spectra.draws).size), max(spectra.n_effective, PRIOR))


def freedom(n_draws: int) -> float:
    """Degrees of freedom of a variance that :func:`combined` gives."""
    return n_draws - 1.0 + PRIOR


def combined(between: FloatArray, within: FloatArray, n_draws: int, q: float) -> FloatArray:
    """Variance of each zero."""
    return np.asarray(((n_draws - 1.0) * between + PRIOR * q * within) / freedom(n_draws))


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


# -- What the choice of the model order, and leakage with it, adds to the error of a zero
#
# The scatter of the segments tells the noise. That a curve of finite resolution is not a rational function of
# the chosen order does not scatter: it shows in how far a zero moves when the order is raised by one to four.


#: Orders above the likeliest that are compared with it.
ABOVE = (1, 2, 3, 4)
#: The largest shift over the next, at most.
LARGEST = 3.0
#: A root further off than this share of the frequency is another one.
SAME_ROOT = 0.01


def next_orders(best: Likeliest) -> list[int]:
    """The orders compared, those that the fit has."""
    return [best.order + k for k in ABOVE if best.order + k <= best.fit.max_order]


def order_scatter(s: ComplexArray, roots: Sequence[ComplexArray]) -> FloatArray:
    """Root mean square in Hz of the shifts of zeros ``s`` (rad/s) to the nearest of other orders, (n,).

    The largest shift counts with at most three times the next: at one order a spurious root may come between.
    What an order does not have counts with the distance up to which it was looked for.
    """
    if len(roots) < 2 or not s.size:
        return np.zeros(s.size)
    most = SAME_ROOT * np.abs(s)
    shifts = np.array([_shifts(s, every, most) for every in roots])
    shifts.sort(axis=0)
    shifts[-1] = np.minimum(shifts[-1], LARGEST * shifts[-2])
    return np.asarray(np.sqrt(np.mean(shifts**2, axis=0)) / (2 * np.pi))


def _shifts(s: ComplexArray, every: ComplexArray, most: FloatArray) -> FloatArray:
    """Change of the modulus to the nearest root, ``most`` where there is none so near."""
    if not every.size:
        return most
    nearest = every[np.argmin(np.abs(every - s[:, None]), axis=1)]
    return np.where(np.abs(nearest - s) <= most, np.abs(np.abs(nearest) - np.abs(s)), most)
