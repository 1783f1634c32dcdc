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

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .virtual_roots import VirtualRoots

__all__ = ["CRITERIA", "Information", "information"]

CRITERIA = ("determinant", "worst")
#: Share of the mean in the criterion of the worst.
_MEAN = 0.01


@dataclass(frozen=True)
class Information:
    """Information of every candidate, (c, p, p), and of roots that some of them share.

    ``owner`` (s,) is the candidate of such a root, ``rows`` (s, p) its slopes over its error, ``share``
    (s, c) whether each other candidate shows it.
    """

    own: FloatArray
    owner: NDArray[np.intp]
    rows: FloatArray
    share: FloatArray

    def of(self, chosen: Sequence[int]) -> FloatArray:
        """Information of a set of candidates, (p, p)."""
        at = np.array(chosen, dtype=np.intp)
        found: FloatArray = self.own[at].sum(axis=0)
        if self.owner.size:
            mine = np.flatnonzero(np.isin(self.owner, at))
            # Alone, there is nothing to share with.
            weight = self.share[np.ix_(mine, at)].max(axis=1) if at.size > 1 else np.ones(mine.size)
            rows = self.rows[mine]
            found = found + (rows.T * weight) @ rows
        return found

    def worth(self, chosen: Sequence[int], criterion: str) -> float:
        """Worth of a set of candidates; the larger the better."""
        found = self.of(chosen)
        if criterion == "determinant":
            return 0.5 * float(np.linalg.slogdet(np.eye(found.shape[0]) + found)[1])
        each = 0.5 * np.log1p(np.diag(found))
        return float(each.min() + _MEAN * each.mean())


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
