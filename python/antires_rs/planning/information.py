r"""The Fisher information of a set of sensors, and what it is worth.

Parameters are taken in units of their spread before the test (uniform within their bounds), so that the worth
of a set that leaves some of them open is finite:

.. math:: \tfrac{1}{2} \ln \det (1 + I(S)) \quad\text{("determinant")}, \qquad
          \min_e \tfrac{1}{2} \ln (1 + I_{ee}(S)) \quad\text{("worst")}.

The first is what the test is expected to tell, in nats; to the second a hundredth of the mean over e is
added, which decides between sets that leave the worst element equally badly seen.

Reference: K. Chaloner and I. Verdinelli, Bayesian experimental design, Statistical Science 10 (1995) 273-304.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .virtual_roots import VirtualRoots

__all__ = ["CRITERIA", "Information", "information"]

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
        diagonal = _summed(self._diagonal, sets)
        diagonal[some] -= hidden[some] @ self.rows**2
        each = 0.5 * np.log1p(np.maximum(diagonal, 0.0))
        return np.asarray(each.min(axis=1) + _MEAN * each.mean(axis=1))

    @cached_property
    def _diagonal(self) -> FloatArray:
        return np.ascontiguousarray(np.diagonal(self._full, axis1=1, axis2=2))


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
