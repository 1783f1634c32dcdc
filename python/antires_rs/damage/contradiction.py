"""Tests of the intact structure that contradict each other: which one, and by how much.

Values of two tests of the same response are paired in their order; how far two tests are apart is the upper
quartile of the differences of ln f, so that a few false values count for nothing. Ordinary scatter from test
to test is no contradiction: one test must differ from all others by several times what these differ among
themselves. Of two tests that are far apart none can be named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..support.validation import FloatArray
from .association import align
from .measured_states import Values

__all__ = ["Contradiction", "contradiction"]

#: Difference of ln f up to which values are paired; what both tests have alone counts as so far apart.
_PAIRED = 0.1
#: An odd test differs by so many times what the others differ, and at least by this share and so many
#: standard deviations.
_TIMES, _ODD, _DEVIATIONS = 3.0, 0.002, 5.0
#: Without a third test, or if no single one is odd, so much is more than tests scatter.
_APART = 0.01
_UPPER = 75.0


@dataclass(frozen=True)
class Contradiction:
    """Positions of the tests among all baseline sets, the odd one alone where it is known.

    ``apart`` is their relative difference, ``usual`` that of the others (0 where there are none).
    """

    tests: tuple[int, ...]
    apart: float
    usual: float


def contradiction(values: Values, forces: Sequence[int]) -> Contradiction | None:
    """The worst contradiction between tests with the same force; ``forces`` are those of the tests."""
    found = []
    for force in sorted(set(forces)):
        tests = [nth for nth, each in enumerate(forces) if each == force]
        apart = {pair: _apart(values, *pair) for pair in combinations(tests, 2)}
        known = {pair: one for pair, one in apart.items() if one is not None}
        one = _worst(tests, known)
        if one is not None:
            found.append(one)
    return max(found, key=lambda one: one.apart, default=None)


def _worst(tests: list[int], known: dict[tuple[int, int], tuple[float, float]]) -> Contradiction | None:
    for odd in tests:
        own = [known[pair] for pair in known if odd in pair]
        others = [known[pair][0] for pair in known if odd not in pair]
        if not own or not others:
            continue
        least, usual = min(apart for apart, _ in own), max(others)
        if least > max(_TIMES * usual, _ODD, _DEVIATIONS * max(std for _, std in own)):
            return Contradiction((odd,), float(np.median([apart for apart, _ in own])), usual)
    far = {pair: apart for pair, (apart, std) in known.items() if apart > max(_APART, _DEVIATIONS * std)}
    if not far:
        return None
    return Contradiction(tuple(sorted({nth for pair in far for nth in pair})), max(far.values()), 0.0)


def _apart(values: Values, one: int, other: int) -> tuple[float, float] | None:
    """Upper quartile of the differences between two tests, and their usual error; None with nothing in
    common."""
    differences: list[FloatArray] = []
    errors: list[FloatArray] = []
    for number in np.unique(values.response[values.test == one]):
        a = np.flatnonzero((values.test == one) & (values.response == number))
        b = np.flatnonzero((values.test == other) & (values.response == number))
        if not b.size:
            continue
        cost = np.abs(values.log_f[a][:, None] - values.log_f[b])
        partner = align(cost, np.full(a.size, 0.5 * _PAIRED), np.full(b.size, 0.5 * _PAIRED))
        has = np.flatnonzero(partner >= 0)
        moved = min(a.size, b.size) - has.size
        differences += [cost[has, partner[has]], np.full(moved, _PAIRED)]
        errors.append(np.hypot(values.std[a[has]], values.std[b[partner[has]]]))
    apart, std = (np.concatenate([np.empty(0), *parts]) for parts in (differences, errors))
    if not apart.size:
        return None
    return float(np.percentile(apart, _UPPER)), float(np.median(std)) if std.size else 0.0
