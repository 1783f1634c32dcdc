"""Antiresonances of all responses from one fit: what two solutions of the same data agree on.

The sweep over orders shows which zeros stand still; near the noise its values are biased, since it
takes the data for exact. The likeliest numerators, at the one order that the data support, have the least
scatter and no such bias, but a fit of one order cannot tell a zero from an artefact. So the chains say what
is there, the likeliest fit says where, and both must have it. It must also be known to half the frequency
tolerance (one standard deviation) and own its curve.

A zero of the likeliest fit that heads no chain is accepted as "persistent", if besides

- it is lightly damped, left of the axis,
- it is no neighbour of a root that all responses share, and
- three quarters of the higher orders have a root near it.

On the eight-mass chain, 0 to 10 % noise, true values owned at least 0.94 of their curve; superfluous ones that
had a chain lay at the edge of the band, where there is only noise, and were missing from the likeliest fit
or owned at most 0.64, or had standard deviations of 0.8 % and more.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ._validation import ComplexArray, FloatArray
from .accepted import Accepted, Value
from .bands import Window
from .likelihood import Likeliest, likeliest
from .numerators import NumeratorSweep, shared
from .response_lines import Lines
from .stabilization import Rule, StabilizationDiagram, diagram
from .uncertainty import Influence, standard_deviations

# Line weights grow with the signal-to-noise power up to here: beyond, leakage would rule.
SNR_CAP = 1e4
# A chain and a zero of the likeliest fit this close belong together: the chain may be biased by so much.
SAME = 0.05
# Least share of the curve, and largest standard deviation in frequency tolerances: left of the axis, and
# right of it, where zeros are rare.
DOMINANCE, KNOWN = 0.8, 0.5
RIGHT_DOMINANCE, RIGHT_KNOWN = 0.9, 0.1
# Zeros without a chain: most damping, distance from roots that all share, share of the orders.
MAX_DAMPING = 0.05
NEARLY_SHARED = 0.05
PRESENCE = 0.75


class Zero(NamedTuple):
    """A zero of the likeliest fit that may be physical."""

    s: complex
    dominance: float
    std_hz: float

    @property
    def freq_hz(self) -> float:
        """abs(s) / 2 pi."""
        return float(abs(self.s) / (2 * np.pi))


def select(lines: Lines, n_responses: int, window: Window, orders: range, rule: Rule,
           keep_common: bool) -> list[StabilizationDiagram]:
    """One diagram for each of the first ``n_responses`` rows of ``lines``."""
    rule = replace(rule, both_sides=True)
    best = likeliest(lines.freq_hz, lines.covariance(), SNR_CAP, lines.independent, orders[-1])
    influence = Influence(best.fit, best.coefficients, best.misfit)
    # The force, if it is there, has the poles for zeros: only where there is no second response may it say
    # what a zero owns, since a zero beside a resonance owns little of the quotient with the force.
    rows = range(n_responses if n_responses > 1 else lines.vectors.shape[0])
    roots = [best.fit.zeros(best.coefficients, row) for row in rows]
    solutions: dict[int, FloatArray] = {}
    sweeps = [NumeratorSweep(best.fit, row, [k for k in rows if k != row], solutions) for row in rows]
    numerators = best.fit.values(best.coefficients).T
    diagrams = []
    for row in range(n_responses):
        sweep = sweeps[row]
        others = [] if keep_common else [roots[k] for k in sweep.others]
        sweep.companions = [] if keep_common else [sweeps[k] for k in sweep.others]
        quotients = lines.quotients(row)[0]
        background = np.abs(quotients.sum(axis=0))
        one = diagram(sweep, orders, window.report_hz, rule, lines.freq_hz, background,
                      lines.added_decay_per_s)
        own = roots[row][~shared(roots[row], others)]
        zeros = _candidates(best, influence, sweep, own, lines, window.report_hz, rule)
        values, alone = _joined(one.accepted.values(), zeros, rule, lines.added_decay_per_s)
        for zero in alone if rule.persistent else ():
            value = _persistent(zero, sweep, best.order, orders, others, rule, lines.added_decay_per_s)
            if value is not None:
                values.append(value)
        fitted = np.delete(numerators, row, axis=0) / numerators[row]
        accepted = Accepted.of(values).scored(lines.freq_hz, background, quotients, fitted)
        diagrams.append(replace(one, accepted=accepted))
    return diagrams


def _candidates(best: Likeliest, influence: Influence, sweep: NumeratorSweep, s: ComplexArray,
                lines: Lines, report_hz: tuple[float, float], rule: Rule) -> list[Zero]:
    """Zeros in the band, lightly damped, and not cancelled in every transmissibility."""
    size = np.abs(s)
    freq = size / (2 * np.pi)
    damping = -(s.real + lines.added_decay_per_s) / size
    s = s[(s.imag > 0) & (freq >= report_hz[0]) & (freq <= report_hz[1])
          & (np.abs(damping) <= rule.max_damping)]
    if not s.size:
        return []
    share = best.fit.dominances(best.coefficients, sweep.row, s, sweep.others)
    s, share = s[share >= rule.min_dominance], share[share >= rule.min_dominance]
    std = standard_deviations(influence, sweep.row, s, lines)
    return [Zero(complex(z), float(d), float(e)) for z, d, e in zip(s, share, std, strict=True)]


def _joined(chains: list[Value], zeros: list[Zero], rule: Rule, added: float,
            ) -> tuple[list[Value], list[Zero]]:
    """Chains with the values of the zeros nearest to them, nearest pairs first, and the zeros left over."""
    pairs = sorted((abs(zero.freq_hz / chain.freq_hz - 1.0), i, k)
                   for i, chain in enumerate(chains) for k, zero in enumerate(zeros))
    partner: dict[int, int] = {}
    for distance, i, k in pairs:
        if distance <= SAME and i not in partner and k not in partner.values():
            partner[i] = k
    values = []
    for i, chain in enumerate(chains):
        if i not in partner:
            continue
        zero = zeros[partner[i]]
        freq, damping = _of(zero.s, added)
        needed, known = (DOMINANCE, KNOWN) if damping > 0.0 else (RIGHT_DOMINANCE, RIGHT_KNOWN)
        if zero.dominance >= needed and zero.std_hz <= known * rule.freq_tol * freq:
            values.append(chain._replace(freq_hz=freq, damping_ratio=damping, dominance=zero.dominance,
                                         std_hz=zero.std_hz))
    return values, [zero for k, zero in enumerate(zeros) if k not in partner.values()]


def _of(s: complex, added: float) -> tuple[float, float]:
    """Frequency and damping ratio without the decay of an exponential window."""
    moved = s + added
    return float(abs(moved) / (2 * np.pi)), float(-moved.real / abs(moved))


def _persistent(zero: Zero, sweep: NumeratorSweep, order: int, orders: range, others: list[ComplexArray],
                rule: Rule, added: float) -> Value | None:
    """The value of a zero without a chain, if it passes every test."""
    freq, damping = _of(zero.s, added)
    if not (zero.std_hz <= KNOWN * rule.freq_tol * freq and 0.0 < damping <= MAX_DAMPING
            and zero.dominance >= DOMINANCE):
        return None
    if shared(np.array([zero.s]), others, NEARLY_SHARED)[0]:
        return None
    seen = []
    higher = [m for m in orders if m > order]
    for m in higher:
        s = sweep.roots(m)
        s = s[(s.imag > 0) & (np.abs(np.abs(s) / abs(zero.s) - 1.0) <= SAME)
              & (np.abs(s.real) <= rule.max_damping * np.abs(s))]
        if s.size and sweep.dominances(m, s).max() >= DOMINANCE:
            seen.append(float(np.abs(s[np.argmin(np.abs(s - zero.s))])))
    if len(seen) <= rule.min_rows or len(seen) < PRESENCE * len(higher):
        return None
    return Value(freq, damping, len(seen), float(np.std(seen) / abs(zero.s)), zero.dominance, "persistent",
                 zero.std_hz)
