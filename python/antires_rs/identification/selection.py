"""Which zeros of the fitted numerators are antiresonances.

The likeliest numerators, at the one order that the data support, have the least scatter, no bias, and tell
the standard deviation of every zero: their zeros are the candidates and give the values. The sweep over
orders, whose values are biased near the noise, shows what stays. A candidate is lightly damped, known to half
the frequency tolerance, no factor that all numerators share, and not half of a pair of one modulus and two
dampings, which is one zero that is complex even without damping. It is accepted at once unless there is a
doubt (``_credible``); without a chain in the diagram it is marked "persistent" if most higher orders have
it, else "likeliest order".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..exceptions import NumericalError
from ..measured.response_table import ResponseTable
from ..support.checks import ComplexArray, FloatArray
from ..support.messages import warn
from ..support.progress import step
from .column_fit import likeliest_columns
from .lines import SNR_CAP, Lines
from .minors import MinorLines
from .numerators import UNDEFINED, WIDEST, Influence, Likeliest, NumeratorSweep, likeliest
from .options import FitOptions, IdentificationOptions
from .scores import scored, shared
from .stabilization import PRESENCE, StabilizationDiagram, Window, diagram

# -- What the choice of the model order, and leakage with it, adds to the error of a zero
#
# That a curve of finite resolution is not a rational function of the chosen order does not scatter from
# segment to segment: it shows in how far a zero moves when the order is raised by one to four.

ABOVE = 4  # orders above the likeliest that are compared with it
LARGEST = 3.0  # the largest shift over the next, at most
SAME_ROOT = 0.01  # a root further off than this share of the frequency is another one


def order_scatter(s: ComplexArray, roots: Sequence[ComplexArray], count: Any = 1) -> FloatArray:
    """Root mean square in Hz of the shifts of zeros ``s`` (rad/s) to the nearest of other orders, (n,).

    The largest shift counts with at most three times the next: at one order a spurious root may come between.
    What an order does not have counts with the distance up to which it was looked for. Zeros that are the
    mean of a ``count`` of roots go with the mean of as many.
    """
    if len(roots) < 2 or not s.size:
        return np.zeros(s.size)
    most = SAME_ROOT * np.abs(s)
    shifts = np.tile(most, (len(roots), 1))
    several = np.flatnonzero(np.broadcast_to(count, s.shape) > 1)
    for row, every in zip(shifts, roots, strict=True):
        if every.size:
            nearest = every[np.argmin(np.abs(every - s[:, None]), axis=1)]
            near = np.abs(nearest - s) <= most
            row[near] = np.abs(np.abs(nearest) - np.abs(s))[near]
            for i in several.tolist():
                about = every[np.argsort(np.abs(every - s[i]))[: count[i]]]
                row[i] = min(most[i], abs(abs(complex(about.mean())) - abs(complex(s[i]))))
    shifts.sort(axis=0)
    shifts[-1] = np.minimum(shifts[-1], LARGEST * shifts[-2])
    return np.asarray(np.sqrt(np.mean(shifts**2, axis=0)) / (2 * np.pi))


# -- Zeros of the likeliest numerators: which are candidates, and which of these are accepted

# A chain and a zero of the likeliest fit this close belong together: the chain may be biased by so much.
SAME = 0.05
KNOWN = 0.5  # largest standard deviation in frequency tolerances
# Damped less than this, or right of the axis, are few physical zeros (two that nearly coincide part so), and
# many roots glued to the noise of single lines: such a zero must own this much of its curve.
LEAST_DAMPING, MOST_NEGATIVE, RIGHT_DOMINANCE = 5e-4, 0.01, 0.9
# Two zeros of one modulus, whose frequencies differ by less than this share of the difference of their
# damping ratios, are the halves of one that is complex without damping; at least so far apart in damping.
PAIR, PAIR_DAMPING = 0.5, 0.004
# Minors of many modes have roots of any damping: halves lie evenly about the damping of a structure, at most
# so large or this share of their distance.
PAIR_MIDDLE, PAIR_OFF, MOST_NEGATIVE_MINORS = 0.02, 0.25, 0.03
# Roots with this share of the curve, and up to WIDEST of damping, may be the other half of such a pair.
OTHER_HALF = 0.02
# A zero that owns less than this share of its curve, or is this near to a root that all responses share, is
# doubtful: it needs a root of the same frequency and damping in PRESENCE of the higher orders.
WEAK, NEARLY_SHARED, SAME_DAMPING = 0.5, 0.05, 0.002
NEARLY_SHARED_MINORS = 0.01  # of many sets of responses most have roots that others have, too


def likeliest_of(lines: Lines, options: IdentificationOptions) -> Likeliest:
    """The likeliest numerators of all rows; the lines of one window."""
    orders = options.rule.orders((options.rule.min_order, options.most), lines.freq_hz.size)
    if isinstance(lines, MinorLines):
        try:
            return likeliest_columns(lines, orders[-1])
        except np.linalg.LinAlgError:
            raise NumericalError("the columns of several forces", UNDEFINED) from None
    return likeliest(lines.freq_hz, lines.covariance, SNR_CAP, lines.independent, orders[-1])


def select(
    lines: Lines, best: Likeliest, n_responses: int, window: Window, options: IdentificationOptions
) -> list[StabilizationDiagram]:
    """One diagram for each of the first ``n_responses`` rows of ``lines``, of which ``best`` is the fit."""
    rule, keep_common = replace(options.rule, both_sides=True), options.rule.keep_common
    unit = best.fit.step
    above = range(best.order + unit, best.order + max(ABOVE, 2 * unit) + 1, unit)
    if above[-1] > best.fit.max_order:
        above = range(above.start, best.fit.max_order + 1, unit)
        # There are hardly any orders above the likeliest, which may be beyond them.
        named = best.fit.max_order == options.max_order
        remedy = "Leave max_order out, or raise it" if named else "Narrow the band, or record longer"
        low, high = window.report_hz
        warn(
            "highest_order",
            f"identify_antiresonances: from {low:.4g} to {high:.4g} Hz the likeliest order, {best.order}, is "
            f"hardly below the highest that is fitted, {best.fit.max_order}; antiresonances may be missing "
            f"or wrong. {remedy}.",
        )
    orders = range(-(-rule.min_order // unit) * unit, best.fit.max_order + 1, unit)
    influence = best.influence(lines.by_test())
    # The force, if it is there, has the poles for zeros: only where there is no second response may it say
    # what a zero owns, since a zero beside a resonance owns little of the quotient with the force.
    rows = range(n_responses if n_responses > 1 else lines.vectors.shape[0])
    roots = [best.fit.zeros(best.coefficients[:, row]) for row in rows]
    influence.pool(roots)
    other_orders = [[best.fit.zeros(c[:, row]) for row in rows] for c in best.fit.likeliest(*above)]
    solutions: dict[int, FloatArray] = {}
    sweeps = [NumeratorSweep(best.fit, row, [k for k in rows if k != row], solutions) for row in rows]
    for sweep in sweeps:
        for order in orders:  # Ascending, so that the roots of each order start from those of the one before.
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
        s, share, std, count = _candidates(best, influence, sweep, own, lines, window.report_hz, rule)
        scatter = order_scatter(s, [every[row] for every in other_orders], count)
        std = np.hypot(std, scatter)
        seen = _seen(s, sweep, higher, rule)
        counts = np.array([len(own) for own in seen], dtype=int)
        stays = (counts > rule.min_rows) & (counts >= PRESENCE * len(higher))
        zeros = _table(s, share, std, count, seen, stays, one.accepted, lines.added_decay_per_s)
        if lines.order > 1:  # The orders above are fits as good as the likeliest, those of the sweep are not.
            spread = scatter / zeros.freq_hz
            zeros = zeros.with_scores(spread=spread, rows=unit * zeros.rows)
        keep = _credible(s, zeros, stays, others, NEARLY_SHARED if lines.order == 1 else NEARLY_SHARED_MINORS)
        if not rule.persistent:
            keep &= zeros.how == "chain"
        fitted = np.delete(numerators, row, axis=0) * (1.0 / numerators[row])
        accepted = scored(zeros.take(keep), lines.freq_hz, background, quotients, fitted)
        diagrams.append(replace(one, accepted=accepted))
    return diagrams


def _candidates(
    best: Likeliest,
    influence: Influence,
    sweep: NumeratorSweep,
    s: ComplexArray,
    lines: Lines,
    report_hz: tuple[float, float],
    rule: FitOptions,
) -> tuple[ComplexArray, FloatArray, FloatArray, NDArray[np.int64]]:
    """Zeros in the band, lightly damped, well known, not half of a complex pair.

    With their dominance, standard deviation in Hz, and of how many roots each is the mean.
    """
    size = np.abs(s)
    damping = -(s.real + lines.added_decay_per_s) / size
    s = s[
        (s.imag > 0)
        & (size >= 2 * np.pi * 0.98 * report_hz[0])
        & (size <= 2 * np.pi * 1.02 * report_hz[1])
        & (np.abs(damping) <= WIDEST)
    ]
    if not s.size:
        return s, np.empty(0), np.empty(0), np.empty(0, dtype=np.int64)
    share = best.fit.dominances(best.coefficients, sweep.row, s, sweep.others)
    least = min(OTHER_HALF, rule.min_dominance)
    s, share = s[share >= least], share[share >= least]
    std = influence.standard_deviations(sweep.row, s)
    split, count = np.zeros(s.size), np.ones(s.size, dtype=np.int64)
    if lines.order > 1:
        added = lines.added_decay_per_s
        s, share, std, split, count = _joined(influence, sweep.row, s, share, std, added)
    known = std <= KNOWN * rule.freq_tol * np.abs(s) / (2 * np.pi)
    s, share, std, count = s[known], share[known], np.hypot(std, split)[known], count[known]
    size = np.abs(s)
    freq, damping = size / (2 * np.pi), -(s.real + lines.added_decay_per_s) / size
    apart, error = np.abs(damping[:, None] - damping), std / freq
    paired = (apart > PAIR_DAMPING + 3.0 * (error[:, None] + error)) & (
        np.abs(freq[:, None] / freq - 1.0) <= PAIR * apart
    )
    most_negative = MOST_NEGATIVE
    if lines.order > 1:
        middle = np.abs(damping[:, None] + damping) / 2.0
        paired &= middle <= np.maximum(PAIR_MIDDLE, PAIR_OFF * apart)
        most_negative = MOST_NEGATIVE_MINORS
    keep = (
        (freq >= report_hz[0])
        & (freq <= report_hz[1])
        & (damping >= -most_negative)
        & (damping <= rule.max_damping)
        & (share >= rule.min_dominance)
        & ~paired.any(axis=1)
    )
    # In the order of the table that is made of them.
    rank = sorted(np.flatnonzero(keep), key=lambda i: abs(complex(s[i]) + lines.added_decay_per_s))
    return s[rank], share[rank], std[rank], count[rank]


# -- Double roots
#
# Near a root of two or more at one place a small change e of the numerator, by noise or by damping that is
# not proportional, parts them by the root of e, one per cent of damping by some per cent, while their mean
# moves by e. Let two roots be s = c +- d. Damping makes d^2 imaginary to first order: what is left of two
# roots without damping is the real part of -d^2, a square of half their distance, negative of complex ones.
# Roots of which it is not told from zero are one value, their mean.

APART = 3.0  # standard deviations of the squared half distance that tell two roots apart
SECOND = 0.3  # of the second order in damping a half distance may be this share of the decay
WIDEST_SPLIT = 0.06  # roots further apart, as a share of the frequency, are no halves
BETTER_KNOWN = 0.25  # the mean's standard deviation over that of each root, at most: errors are opposite


def _joined(
    influence: Influence,
    row: int,
    s: ComplexArray,
    share: FloatArray,
    std: FloatArray,
    added_decay_per_s: float,
) -> tuple[ComplexArray, FloatArray, FloatArray, FloatArray, NDArray[np.int64]]:
    """Zeros with those that are not told apart as one: dominance, std and split in Hz, number of roots."""
    from scipy.sparse.csgraph import connected_components  # slow to import

    half = (s[:, None] - s) / 2.0
    left = -(half**2).real
    of_left = 2.0 * np.abs(half) * np.sqrt((std[:, None] ** 2 + std**2) / 2.0) * (2 * np.pi)
    near = 2.0 * np.abs(half) <= WIDEST_SPLIT * np.abs(s)
    damped = (SECOND * ((s[:, None] + s).real / 2.0 + added_decay_per_s)) ** 2  # a window parts nothing
    one = near & near.T & (np.abs(left) <= np.maximum(APART * of_left, damped))
    clusters, label = connected_components(one, directed=False)
    member = label == np.arange(clusters)[:, None]
    member = member[member.sum(axis=1) > 1]
    means = member / member.sum(axis=1, keepdims=True)
    known = influence.standard_deviations(row, s, means) if len(member) else np.empty(0)
    double = known <= BETTER_KNOWN * np.where(member, std, np.inf).min(axis=1, initial=np.inf)
    member, means, known = member[double], means[double], known[double]
    largest = np.where(member, share, 0.0).max(axis=1, initial=0.0)
    both = member[:, :, None] & member[:, None, :]
    split = np.sqrt(np.where(both, left, 0.0).max(axis=(1, 2), initial=0.0)) / (2 * np.pi)
    alone = ~member.any(axis=0)
    return (
        np.concatenate([s[alone], means @ s]),
        np.concatenate([share[alone], largest]),
        np.concatenate([std[alone], known]),
        np.concatenate([np.zeros(alone.sum()), split]),
        np.concatenate([np.ones(alone.sum(), dtype=np.int64), member.sum(axis=1)]),
    )


def _credible(
    s: ComplexArray, zeros: ResponseTable, stays: Any, others: list[ComplexArray], nearly: float
) -> Any:
    """Which zeros may be accepted: at once, or because they stay, most higher orders having them too."""
    # With fewer than two others nothing can be told of what all rows share: the higher orders decide.
    unknown = len(others) < 2
    near = np.zeros(s.size, dtype=bool) if unknown else shared(s, others, nearly)
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
        near = np.flatnonzero(rule.agree(size / own_size, damping, own_damping, SAME_DAMPING))
        # Of each order the nearest, which is written last.
        near = near[np.argsort(-np.abs(roots[near] - zero), kind="stable")]
        nearest = dict(zip(order[near].tolist(), size[near].tolist(), strict=True))
        seen.append([nearest[one] for one in sorted(nearest)])
    return seen


def _table(
    s: ComplexArray,
    dominance: FloatArray,
    std_hz: FloatArray,
    count: NDArray[np.int64],
    seen: list[list[float]],
    stays: Any,
    chains: ResponseTable,
    added_decay_per_s: float,
) -> ResponseTable:
    """The zeros less the decay of an exponential window, with the scores of a chain where they have one."""
    size = [abs(zero) for zero in s.tolist()]
    moved = (s + added_decay_per_s).tolist()
    # The chain nearest to each zero; -1 if there is none, or if another zero is nearer to it.
    chain = np.full(s.size, -1)
    if len(chains):
        distance = np.abs(chains.freq_hz[:, None] / (np.array(size) / (2 * np.pi)) - 1.0)
        nearest, own_distance = np.argmin(distance, axis=0), distance.min(axis=0)
        first = distance.min(axis=1, initial=np.inf)[nearest]
        chain = np.where(own_distance <= np.minimum(SAME, first), nearest, -1)
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
        how=np.where(
            count > 1,
            "double root",
            np.where(chain >= 0, "chain", np.where(stays, "persistent", "likeliest order")),
        ),
    )
