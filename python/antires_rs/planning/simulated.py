"""Probability of detection by whole assessments: structures drawn, values drawn, ``assess_damage`` asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..damage.assess import assess_damage
from ..damage.prior import DamagePrior
from ..support.workers.door import in_order
from .virtual_test import VirtualTest

__all__ = ["Task", "simulated"]


@dataclass(frozen=True)
class Task:
    """One virtual test: place of the damaged element among the candidates (None: intact), its severity."""

    place: int | None
    severity: float
    prior: DamagePrior
    false_alarm_rate: float | None
    seed: np.random.SeedSequence
    threads: int


def judged(test: VirtualTest, task: Task) -> tuple[int, ...]:
    """Elements that ``assess_damage`` declares damaged."""
    rng = np.random.default_rng(task.seed)
    factors = test.truth(rng)
    damage = (0, 0.0) if task.place is None else (task.place, task.severity)
    intact, now = test.roots(factors, [(0, 0.0), damage], task.threads)
    result = assess_damage(
        test.model,
        test.measured(now, rng),
        baseline=test.measured(intact, rng),
        elements=list(test.elements),
        prior=task.prior,
        false_alarm_rate=task.false_alarm_rate,
        rng=int(rng.integers(2**32)),
        workers=task.threads,
        progress=False,
    )
    return result.assessment.declared


def simulated(test: VirtualTest, tasks: Sequence[Task], workers: Any) -> list[tuple[int, ...]]:
    """What each test declares, in order; after Ctrl-C those that are there."""
    found: list[tuple[int, ...]] = []
    try:
        for one in in_order(judged, tasks, workers, shared=test, what="test"):
            found.append(one)
    except KeyboardInterrupt:
        if not found:
            raise
    return found
