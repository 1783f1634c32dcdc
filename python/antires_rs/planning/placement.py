"""The best sets of sensors: greedy forwards and backwards, then exchange of one for another; or all sets.

From both ends sensors are exchanged, one by one or two by two, for candidates left out, the best exchange
first, until none improves. The better end wins.

References: V. V. Fedorov, Theory of Optimal Experiments, 1972 (exchange); D. C. Kammer, Sensor placement for
on-orbit modal identification, J. Guidance 14 (1991) 251-259 (backwards).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, islice
from math import comb

import numpy as np
from numpy.typing import NDArray

from ..support.checks import FloatArray
from .virtual_roots import VirtualRoots

# -- The Fisher information of a set of sensors, and what it is worth
#
# Parameters are taken in units of their spread before the test (uniform within their bounds), so that the
# worth of a set that leaves some of them open is finite:
#
# .. math:: \tfrac{1}{2} \ln \det (1 + I(S)) \quad\text{("determinant")}, \qquad
#           \min_e \tfrac{1}{2} \ln (1 + I_{ee}(S)) \quad\text{("worst")}.
#
# The first is what the test is expected to tell, in nats; to the second a hundredth of the mean over e is
# added, which decides between sets that leave the worst element equally badly seen.
#
# Reference: K. Chaloner and I. Verdinelli, Bayesian experimental design, Statistical Science 10 (1995)
# 273-304.

CRITERIA = ("determinant", "worst")
#: Share of the mean in the criterion of the worst.
_MEAN = 0.01
#: Numbers of the sets that are judged together.
_AT_ONCE = 2_000_000


@dataclass(frozen=True)
class Information:
    """Information of every candidate, (c, p, p), and of roots that some of them share.

    ``owner`` (s,) is the candidate of such a root, ``rows`` (s, p) its slopes over its error, ``share``
    (s, c) whether each other candidate shows it: 0 or 1.
    """

    own: FloatArray
    owner: NDArray[np.intp]
    rows: FloatArray
    share: FloatArray

    @cached_property
    def _full(self) -> FloatArray:
        """Information of every candidate, all of its roots seen, (c, p, p)."""
        full = self.own.copy()
        for nth in np.unique(self.owner):
            rows = self.rows[self.owner == nth]
            full[nth] += rows.T @ rows
        return full

    def of(self, chosen: Sequence[int]) -> FloatArray:
        """Information of a set of candidates, (p, p)."""
        at = np.array(chosen, dtype=np.intp)
        rows = self.rows[np.isin(self.owner, at) & ~self._hidden(at[None])[0]]
        return np.asarray(self.own[at].sum(axis=0) + rows.T @ rows)

    def _hidden(self, sets: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Roots of members that all other members share, (sets, s): these do not show them."""
        if not self.owner.size or sets.shape[1] < 2:  # alone, there is nothing to share with
            return np.zeros((len(sets), self.owner.size), dtype=bool)
        member = np.zeros((len(sets), self.own.shape[0]))
        np.put_along_axis(member, sets, 1.0, axis=1)
        shown = member @ (self.share > 0.0).T.astype(np.float64) > 0.0
        return np.asarray((member[:, self.owner] > 0.0) & ~shown)

    def worth(self, chosen: Sequence[int], criterion: str) -> float:
        """Worth of a set of candidates; the larger the better."""
        return float(self.worths(np.array([chosen], dtype=np.intp), criterion)[0])

    def worths(self, sets: NDArray[np.intp], criterion: str, *, all_shown: bool = False) -> FloatArray:
        """Worth of each of several sets, (sets, n) numbers of candidates.

        With ``all_shown`` no root is hidden: never less, and by the determinant two further sensors then add
        no more together than each alone.
        """
        size = self.own.shape[1]
        each = size**2 if criterion == "determinant" else size
        step = max(_AT_ONCE // max(each, self.owner.size, self.own.shape[0], 1), 1)
        parts = [self._worths(sets[at : at + step], criterion, all_shown) for at in range(0, len(sets), step)]
        return np.concatenate([np.empty(0), *parts])

    def _worths(self, sets: NDArray[np.intp], criterion: str, all_shown: bool) -> FloatArray:
        hidden = self._hidden(sets) & (not all_shown)
        some = np.flatnonzero(hidden.any(axis=1))
        if criterion == "determinant":
            found = _summed(self._full, sets)
            for nth in some.tolist():
                rows = self.rows[hidden[nth]]
                found[nth] -= rows.T @ rows
            found += np.eye(self.own.shape[1])
            return np.asarray(0.5 * np.linalg.slogdet(found)[1])
        diagonal = _summed(np.ascontiguousarray(np.diagonal(self._full, axis1=1, axis2=2)), sets)
        diagonal[some] -= hidden[some] @ self.rows**2
        each = 0.5 * np.log1p(np.maximum(diagonal, 0.0))
        return np.asarray(each.min(axis=1) + _MEAN * each.mean(axis=1))


def _summed(parts: FloatArray, sets: NDArray[np.intp]) -> FloatArray:
    """Sum of the parts of each set; of large sets by what they lack."""
    count, n = parts.shape[0], sets.shape[1]
    if 2 * n <= count:
        return np.asarray(sum(parts[column] for column in sets.T))
    lacks = np.ones((len(sets), count), dtype=bool)
    np.put_along_axis(lacks, sets, False, axis=1)
    found = np.repeat(parts.sum(axis=0)[None], len(sets), axis=0)
    for column in np.nonzero(lacks)[1].reshape(len(sets), count - n).T:
        found -= parts[column]
    return found


def information(roots: VirtualRoots, n_candidates: int, spread: FloatArray, tests: int) -> Information:
    """Of one force; ``spread`` (p,) are the units, ``tests`` the number of values in each difference."""
    rows = roots.slopes * spread / (np.sqrt(tests) * roots.std[:, None])
    common = np.array(sorted(roots.common), dtype=np.intp)
    alone = np.setdiff1d(np.arange(rows.shape[0]), common)
    own = np.zeros((n_candidates, rows.shape[1], rows.shape[1]))
    for nth in range(n_candidates):
        mine = rows[alone[roots.sensor[alone] == nth]]
        own[nth] = mine.T @ mine
    share = np.array([roots.common[root] for root in common.tolist()]).reshape(common.size, n_candidates)
    # A root's own response shows nothing beyond itself.
    share[np.arange(common.size), roots.sensor[common]] = 0.0
    return Information(own, roots.sensor[common], rows[common], share)


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
    directions = (False, True) if count <= _MOST_BACKWARDS else (False,)
    ends = [_one_by_one(information, n, criterion, backwards) for backwards in directions]
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


def _one_by_one(information: Information, n: int, criterion: str, backwards: bool) -> Placed:
    """The sensor that adds most joins; or, backwards, from all candidates, the one missed least goes."""
    every = list(range(information.own.shape[0]))
    chosen = every if backwards else []
    worth = information.worth(chosen, criterion) if backwards else -np.inf
    rounds = []
    while len(chosen) != n:
        moves = chosen if backwards else [c for c in every if c not in chosen]
        sets = [[o for o in chosen if o != c] if backwards else [*chosen, c] for c in moves]
        worths = information.worths(np.array(sets), criterion)
        best = int(np.argmax(worths))
        chosen, worth = sets[best], float(worths[best])
        added, removed = (None, moves[best]) if backwards else (moves[best], None)
        rounds.append(Round(added, removed, worth))
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
        tried, sets = [], []
        for goes in combinations(chosen, size):
            kept = [c for c in chosen if c not in goes]
            joining = _promising(information, criterion, kept, outside, size, least)
            tried += [(goes, joins) for joins in joining]
            sets += [[*kept, *joins] for joins in joining]
        if not tried:
            continue
        worths = information.worths(np.array(sets), criterion)
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
