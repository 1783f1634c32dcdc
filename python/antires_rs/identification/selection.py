"""Which zeros of the fitted numerators are antiresonances.

Two solutions see the same data. The likeliest numerators, at the one order that the data support, have the
least scatter, no bias, and tell the standard deviation of every zero: their zeros are the candidates and
give the values. The sweep over orders, whose values are biased near the noise, shows what stays. A
candidate is

- in the band and lightly damped, and known to half the frequency tolerance (one standard deviation),
- not a factor that all numerators share, and not half of a pair of one modulus and two dampings, which is one
  zero that is complex even without damping.

It is accepted at once, unless there is a doubt: if it is hardly damped or right of the axis it must own its
curve and be far from every root that all rows share; if it is near such a root, or owns less than half of its
curve, most higher orders must have it too. Without a chain in the diagram it is marked
"persistent" if most higher orders have it, else "likeliest order": what speaks for it is that fit alone.

The limits, with their reasons, are in :mod:`~antires_rs.identification.limits`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..measured.response_table import ResponseTable
from ..signals.spectra import CrossSpectra, pieces
from ..support.checks import ComplexArray, FloatArray
from ..support.messages import warn
from ..support.progress import step
from .limits import (
    KNOWN,
    LEAST_DAMPING,
    MOST_NEGATIVE,
    NEARLY_SHARED,
    OTHER_HALF,
    PAIR,
    PAIR_DAMPING,
    PRESENCE,
    RIGHT_DOMINANCE,
    SAME,
    SAME_DAMPING,
    WEAK,
    WIDEST,
)
from .lines import SNR_CAP, Lines
from .numerators import Likeliest, NumeratorFit, NumeratorSweep, likeliest
from .options import FitOptions, IdentificationOptions
from .scores import scored, shared
from .stabilization import StabilizationDiagram, Window, diagram

# -- How far an identified value may be off: standard deviations from the scatter of the segments
#
# The coefficients c solve (A - mu I) c = 0, so a change dA moves them by
#
#     dc = -(A - mu I)^+ dA c,      dA c = -sum_f g_f Re phi' (dC_f N - (N' dC_f N / N'N) N)
#
# and a zero s of N_j by its slope ds/dc. Each Welch segment is one independent draw of all C_f at once;
# what its own x x' would move the zero by is its influence, and the variance of the mean of K influences is
# the variance of the zero (the infinitesimal jackknife). Nothing is assumed of the noise: coloured noise,
# leakage, and what the segments share between neighbouring lines are in the scatter. Where there are no
# segments, blocks of neighbouring lines take their place. The scatter between several records of a test, or
# several impacts, is added as module :mod:`~antires_rs.identification.selection` says.
#
# References: B. Efron, The Jackknife, the Bootstrap and Other Resampling Plans, SIAM 1982, ch. 6; H. White,
# Econometrica 50 (1982) 1-25.


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
    shifts = np.tile(most, (len(roots), 1))
    for row, every in zip(shifts, roots, strict=True):
        if every.size:
            nearest = every[np.argmin(np.abs(every - s[:, None]), axis=1)]
            near = np.abs(nearest - s) <= most
            row[near] = np.abs(np.abs(nearest) - np.abs(s))[near]
    shifts.sort(axis=0)
    shifts[-1] = np.minimum(shifts[-1], LARGEST * shifts[-2])
    return np.asarray(np.sqrt(np.mean(shifts**2, axis=0)) / (2 * np.pi))


def select(
    lines: Lines, n_responses: int, window: Window, options: IdentificationOptions
) -> list[StabilizationDiagram]:
    """One diagram for each of the first ``n_responses`` rows of ``lines``."""
    rule, keep_common = replace(options.rule, both_sides=True), options.rule.keep_common
    orders = rule.orders((options.rule.min_order, options.most), lines.freq_hz.size)
    best = likeliest(lines.freq_hz, lines.covariance, SNR_CAP, lines.independent, orders[-1])
    if len(next_orders(best)) < len(ABOVE):
        _warn_highest(best, window.report_hz, named=best.fit.max_order == options.max_order)
    orders = range(orders[0], best.fit.max_order + 1)
    influence = Influence(best.fit, best.coefficients, best.misfit, lines.by_test())
    # The force, if it is there, has the poles for zeros: only where there is no second response may it say
    # what a zero owns, since a zero beside a resonance owns little of the quotient with the force.
    rows = range(n_responses if n_responses > 1 else lines.vectors.shape[0])
    roots = [best.fit.zeros(best.coefficients[:, row]) for row in rows]
    influence.pool(roots)
    other_orders = [
        [best.fit.zeros(c[:, row]) for row in rows] for c in best.fit.likeliest(*next_orders(best))
    ]
    solutions: dict[int, FloatArray] = {}
    sweeps = [NumeratorSweep(best.fit, row, [k for k in rows if k != row], solutions) for row in rows]
    for sweep in sweeps:
        # Ascending, so that the roots of each order start from those of the one before.
        for order in orders:
            sweep.roots(order)
    numerators = best.fit.values(best.coefficients).T
    higher = [order for order in orders if order > best.order]
    diagrams = []
    for row in range(n_responses):
        step(f"response {row + 1} of {n_responses}")
        sweep = sweeps[row]
        others = [] if keep_common else [roots[k] for k in sweep.others]
        sweep.companions = [] if keep_common else [sweeps[k] for k in sweep.others]
        quotients = lines.quotients(row)[0]
        background = np.abs(quotients.sum(axis=0))
        one = diagram(
            sweep, orders, window.report_hz, rule, lines.freq_hz, background, lines.added_decay_per_s
        )
        own = roots[row][~shared(roots[row], others)]
        s, share, std = _candidates(best, influence, sweep, own, lines, window.report_hz, rule)
        std = np.hypot(std, order_scatter(s, [every[row] for every in other_orders]))
        seen = _seen(s, sweep, higher, rule)
        counts = np.array([len(own) for own in seen], dtype=int)
        stays = (counts > rule.min_rows) & (counts >= PRESENCE * len(higher))
        zeros = _table(s, share, std, seen, stays, one.accepted, lines.added_decay_per_s)
        keep = _credible(s, zeros, stays, others)
        if not rule.persistent:
            keep &= zeros.how == "chain"
        fitted = np.delete(numerators, row, axis=0) * (1.0 / numerators[row])
        accepted = scored(zeros.take(keep), lines.freq_hz, background, quotients, fitted)
        diagrams.append(replace(one, accepted=accepted))
    return diagrams


def _warn_highest(best: Likeliest, band_hz: tuple[float, float], *, named: bool) -> None:
    """There are hardly any orders above the likeliest, which may be beyond them."""
    remedy = "Leave max_order out, or raise it" if named else "Narrow the band, or record longer"
    warn(
        "highest_order",
        f"identify_antiresonances: from {band_hz[0]:.4g} to {band_hz[1]:.4g} Hz the likeliest order, "
        f"{best.order}, is hardly below the highest that is fitted, {best.fit.max_order}; antiresonances may "
        f"be missing or wrong. {remedy}.",
    )


def _candidates(
    best: Likeliest,
    influence: Influence,
    sweep: NumeratorSweep,
    s: ComplexArray,
    lines: Lines,
    report_hz: tuple[float, float],
    rule: FitOptions,
) -> tuple[ComplexArray, FloatArray, FloatArray]:
    """Zeros in the band, lightly damped, well known, not half of a complex pair; dominance, std in Hz."""
    size = np.abs(s)
    damping = -(s.real + lines.added_decay_per_s) / size
    s = s[
        (s.imag > 0)
        & (size >= 2 * np.pi * 0.98 * report_hz[0])
        & (size <= 2 * np.pi * 1.02 * report_hz[1])
        & (np.abs(damping) <= WIDEST)
    ]
    if not s.size:
        return s, np.empty(0), np.empty(0)
    share = best.fit.dominances(best.coefficients, sweep.row, s, sweep.others)
    least = min(OTHER_HALF, rule.min_dominance)
    s, share = s[share >= least], share[share >= least]
    std = influence.standard_deviations(sweep.row, s)
    known = std <= KNOWN * rule.freq_tol * np.abs(s) / (2 * np.pi)
    s, share, std = s[known], share[known], std[known]
    size = np.abs(s)
    freq, damping = size / (2 * np.pi), -(s.real + lines.added_decay_per_s) / size
    keep = (
        (freq >= report_hz[0])
        & (freq <= report_hz[1])
        & (damping >= -MOST_NEGATIVE)
        & (damping <= rule.max_damping)
        & (share >= rule.min_dominance)
        & ~_paired(freq, damping, std / freq)
    )
    # In the order of the table that is made of them.
    rank = sorted(np.flatnonzero(keep), key=lambda i: abs(complex(s[i]) + lines.added_decay_per_s))
    return s[rank], share[rank], std[rank]


def _paired(freq: FloatArray, damping: FloatArray, std: FloatArray) -> Any:
    """Which zeros have another of the same modulus and clearly another damping."""
    apart = np.abs(damping[:, None] - damping)
    least = PAIR_DAMPING + 3.0 * (std[:, None] + std)
    return ((apart > least) & (np.abs(freq[:, None] / freq - 1.0) <= PAIR * apart)).any(axis=1)


def _credible(s: ComplexArray, zeros: ResponseTable, stays: Any, others: list[ComplexArray]) -> Any:
    """Which zeros may be accepted: at once, or because they stay, most higher orders having them too."""
    # With fewer than two others nothing can be told of what all rows share: the higher orders decide.
    unknown = len(others) < 2
    near = np.zeros(s.size, dtype=bool) if unknown else shared(s, others, NEARLY_SHARED)
    hardly_damped = ~near & (zeros.dominance >= RIGHT_DOMINANCE) & (stays | (not unknown))
    damped = stays | ~(near | unknown | (zeros.dominance < WEAK))
    return np.where(zeros.damping_ratio < LEAST_DAMPING, hardly_damped, damped)


def _seen(
    zeros: ComplexArray, sweep: NumeratorSweep, higher: list[int], rule: FitOptions
) -> list[list[float]]:
    """For every zero: moduli of the roots of higher orders that agree with it in frequency and damping."""
    every = [sweep.roots(order) for order in higher]
    every = [s[s.imag > 0] for s in every]
    order = np.repeat(np.arange(len(every)), [s.size for s in every])
    roots = np.concatenate([np.empty(0, dtype=np.complex128), *every])
    size, damping = np.abs(roots), -roots.real / np.abs(roots)
    seen = []
    for zero in zeros.tolist():
        own_size, own_damping = abs(zero), -zero.real / abs(zero)
        near = np.flatnonzero(
            (np.abs(size / own_size - 1.0) <= rule.freq_tol)
            & rule.of_one_damping(damping, own_damping, SAME_DAMPING)
        )
        # Of each order the nearest.
        near = near[np.argsort(np.abs(roots[near] - zero), kind="stable")]
        nearest = near[np.unique(order[near], return_index=True)[1]]
        seen.append(size[nearest].tolist())
    return seen


def _chains_of(freq_hz: FloatArray, chains: ResponseTable) -> Any:
    """The chain nearest to each zero; -1 if there is none, or if another zero is nearer to it."""
    if not len(chains):
        return np.full(freq_hz.size, -1)
    distance = np.abs(chains.freq_hz[:, None] / freq_hz - 1.0)
    row, zero = np.argmin(distance, axis=0), np.arange(freq_hz.size)
    near = distance[row, zero] <= np.minimum(SAME, distance.min(axis=1, initial=np.inf)[row])
    return np.where(near, row, -1)


def _table(
    s: ComplexArray,
    dominance: FloatArray,
    std_hz: FloatArray,
    seen: list[list[float]],
    stays: Any,
    chains: ResponseTable,
    added_decay_per_s: float,
) -> ResponseTable:
    """The zeros less the decay of an exponential window, with the scores of a chain where they have one."""
    size = [abs(zero) for zero in s.tolist()]
    moved = (s + added_decay_per_s).tolist()
    chain = _chains_of(np.array(size) / (2 * np.pi), chains)
    rows, spread = [], []
    for own_size, own, row in zip(size, seen, chain, strict=True):
        rows.append(chains.rows[row] if row >= 0 else len(own))
        spread.append(chains.spread[row] if row >= 0 else np.std(own) / own_size if own else np.nan)
    return ResponseTable.of_sweep(
        [abs(zero) / (2 * np.pi) for zero in moved],
        [-zero.real / abs(zero) for zero in moved],
        std_hz,
        rows=rows,
        spread=spread,
        dominance=dominance,
        how=np.where(chain >= 0, "chain", np.where(stays, "persistent", "likeliest order")),
    )
