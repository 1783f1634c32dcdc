"""Probability of detection by linear algebra: some structures with their baselines, many tests of each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..damage.prior import DamagePrior
from ..support.progress import step
from ..support.validation import FloatArray
from .judge import GRID, Judge
from .pod import rising
from .virtual_test import VirtualTest, along

__all__ = ["predicted"]

#: Tests of each structure and damage.
_DRAWS = 64


def predicted(
    test: VirtualTest,
    severities: Sequence[FloatArray],
    prior: DamagePrior,
    false_alarm_rate: float | None,
    seeds: Sequence[np.random.SeedSequence],
    threads: int,
) -> tuple[list[FloatArray], float, int]:
    """Share of tests that find each severity of each candidate, rate of false calls, structures judged.

    Shares are made to rise with the severity.

    After Ctrl-C those judged so far count.
    """
    shares, calls = [], []
    try:
        for nth, seed in enumerate(seeds):
            step(f"structure {nth + 1} of {len(seeds)}")
            share, call = _one(test, severities, prior, false_alarm_rate, seed, threads)
            shares.append(share)
            calls.append(call)
    except KeyboardInterrupt:
        if not shares:
            raise
    mean = [rising(np.mean([share[e] for share in shares], axis=0)) for e in range(len(severities))]
    return mean, float(np.mean(calls)), len(shares)


def _one(
    test: VirtualTest,
    severities: Sequence[FloatArray],
    prior: DamagePrior,
    false_alarm_rate: float | None,
    seed: np.random.SeedSequence,
    threads: int,
) -> tuple[list[FloatArray], float]:
    rng = np.random.default_rng(seed)
    factors = test.truth(rng)
    # Between the severities asked for there are others, so that no root goes far in one step.
    steps = [np.unique(np.concatenate([betas, GRID[betas[-1] > GRID]])) for betas in severities]
    damage = [(place, float(beta)) for place, betas in enumerate(steps) for beta in betas]
    intact, *damaged = test.roots(factors, [(0, 0.0), *damage], threads)
    judge = Judge(test, prior, test.values(intact, rng), threads, false_alarm_rate, rng)
    kept = np.flatnonzero(test.inside(intact))
    found, start = [], 0
    for place, (betas, asked) in enumerate(zip(steps, severities, strict=True)):
        states = damaged[start : start + betas.size]
        start += betas.size
        identities = along(intact, states)
        shares = []
        for nth in np.searchsorted(betas, asked):
            log_f = np.full(intact.size, np.nan)
            seen = (identities[nth] >= 0) & test.inside(states[nth])
            log_f[identities[nth][seen]] = states[nth].log_f[seen]
            there = np.isfinite(log_f[kept])
            share, _ = judge.found(np.where(there, log_f[kept], 0.0), there, _DRAWS)
            shares.append(share[place])
        found.append(np.array(shares))
    everything = np.ones(kept.size, dtype=bool)
    _, call = judge.found(intact.log_f[kept], everything, 4 * _DRAWS)
    return found, call
