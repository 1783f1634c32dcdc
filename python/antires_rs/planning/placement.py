"""The best sets of sensors: greedy forwards and backwards, then exchange of one for another; or all sets.

Forwards, the sensor that adds most joins; backwards, from all candidates, the one that is missed least goes.
From both ends sensors are exchanged, one by one or two by two, for candidates left out, the best exchange
first, until none improves. The better end wins.

References: V. V. Fedorov, Theory of Optimal Experiments, 1972 (exchange); D. C. Kammer, Sensor placement for
on-orbit modal identification, J. Guidance 14 (1991) 251-259 (backwards).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations, islice
from math import comb

import numpy as np

from .information import Information

__all__ = ["Placed", "Round", "exhaustive", "greedy"]

#: An exchange must add at least this share.
_LEAST = 1e-10
#: So many exchanges or sets are tried at once.
_MOST_EXCHANGES = 20_000
#: Above so many candidates the search goes forwards only.
_MOST_BACKWARDS = 150


@dataclass(frozen=True)
class Round:
    """One step of the search.

    Attributes
    ----------
    added, removed : int or None
        Dof of the sensor that joined, and of the one that went.
    worth : float
        Of the set after it.

    Examples
    --------
    >>> import antires_rs as ar
    >>> plan = ar.plan_test(ar.cases.chain8().model, n_sensors=2, excitations=0)
    >>> [(one.added, one.removed) for one in plan.rounds]
    [(0, None), (2, None)]
    """

    added: int | None
    removed: int | None
    worth: float


@dataclass(frozen=True)
class Placed:
    """The best set found for one force: numbers of the candidates, its worth, how it was found."""

    chosen: tuple[int, ...]
    worth: float
    rounds: tuple[Round, ...]


def greedy(information: Information, n: int, criterion: str) -> Placed:
    """Greedy with exchange."""
    count = information.own.shape[0]
    ends = [_forwards(information, n, criterion)]
    if count <= _MOST_BACKWARDS:
        ends.append(_backwards(information, n, criterion))
    placed = [_exchanged(information, criterion, end) for end in ends]
    return max(placed, key=lambda one: one.worth)


def exhaustive(information: Information, n: int, criterion: str) -> Placed:
    """Of all sets of n candidates the best."""
    every = combinations(range(information.own.shape[0]), n)
    worth, chosen = -np.inf, tuple(range(n))
    while some := list(islice(every, _MOST_EXCHANGES)):
        worths = information.worths(np.array(some), criterion)
        best = int(np.argmax(worths))
        if worths[best] > worth:
            worth, chosen = float(worths[best]), some[best]
    return Placed(chosen, worth, ())


def _forwards(information: Information, n: int, criterion: str) -> Placed:
    chosen: list[int] = []
    rounds = []
    for _ in range(n):
        further = [c for c in range(information.own.shape[0]) if c not in chosen]
        worths = information.worths(np.array([[*chosen, c] for c in further]), criterion)
        best = int(np.argmax(worths))
        chosen.append(further[best])
        rounds.append(Round(further[best], None, float(worths[best])))
    return Placed(tuple(chosen), rounds[-1].worth, tuple(rounds))


def _backwards(information: Information, n: int, criterion: str) -> Placed:
    chosen = list(range(information.own.shape[0]))
    rounds = []
    worth = information.worth(chosen, criterion)
    while len(chosen) > n:
        sets = np.array([[other for other in chosen if other != c] for c in chosen])
        worths = information.worths(sets, criterion)
        best = int(np.argmax(worths))
        worth = float(worths[best])
        rounds.append(Round(None, chosen.pop(best), worth))
    return Placed(tuple(chosen), worth, tuple(rounds))


def _exchanged(information: Information, criterion: str, start: Placed) -> Placed:
    chosen, worth, rounds = list(start.chosen), start.worth, list(start.rounds)
    while True:
        better = _better(information, criterion, chosen, worth)
        if better is None:
            return Placed(tuple(chosen), worth, tuple(rounds))
        worth, joins, goes = better
        for new, old in zip(joins, goes, strict=True):
            chosen[chosen.index(old)] = new
            rounds.append(Round(new, old, worth))


def _better(
    information: Information, criterion: str, chosen: list[int], worth: float
) -> tuple[float, tuple[int, ...], tuple[int, ...]] | None:
    """The best exchange of one sensor or, if none helps and there are not too many, of two."""
    outside = [c for c in range(information.own.shape[0]) if c not in chosen]
    for size in (1, 2):
        if comb(len(chosen), size) * comb(len(outside), size) > _MOST_EXCHANGES:
            return None
        least = worth + _LEAST * abs(worth)
        tried = [
            (goes, joins)
            for goes in combinations(chosen, size)
            for joins in _promising(
                information, criterion, [c for c in chosen if c not in goes], outside, size, least
            )
        ]
        if not tried:
            continue
        sets = np.array([[c for c in chosen if c not in goes] + list(joins) for goes, joins in tried])
        worths = information.worths(sets, criterion)
        best = int(np.argmax(worths))
        if worths[best] > least:
            goes, joins = tried[best]
            return float(worths[best]), joins, goes
    return None


def _promising(
    information: Information, criterion: str, kept: list[int], outside: list[int], size: int, least: float
) -> list[tuple[int, ...]]:
    """What may join the kept ones and be worth more than ``least``: one or two, these by what each adds."""
    if size == 1 or criterion != "determinant" or not kept:
        return list(combinations(outside, size))
    alone = information.worths(np.array([kept]), criterion, all_shown=True)[0]
    sets = np.array([[*kept, c] for c in outside])
    gain = information.worths(sets, criterion, all_shown=True) - alone
    a, b = np.triu_indices(len(outside), 1)
    enough = alone + gain[a] + gain[b] > least
    return [(outside[i], outside[j]) for i, j in zip(a[enough].tolist(), b[enough].tolist(), strict=True)]
