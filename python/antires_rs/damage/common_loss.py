r"""Without a baseline: is one factor on all stiffnesses more probable than the losses of many elements?

A modulus, a section or a unit that is wrong throughout multiplies every stiffness by the same number. A
search that knows losses only makes it a loss of nearly every element. Both are judged by the same likelihood,
with the scatter of stiffnesses and masses that is assumed without a baseline, and by Laplace's approximation
of the evidence: the one factor with every loss equally probable, as that of one element is, on the candidates
or on all elements; the set of elements with the prior of their number.
"""

from __future__ import annotations

from math import comb
from typing import TYPE_CHECKING

import numpy as np

from .evidence import FURTHEST, HIGHEST

if TYPE_CHECKING:
    from ..support.validation import FloatArray
    from .likelihood import Likelihood
    from .question import Question

__all__ = ["common_loss", "many"]

#: Steps to the most probable factor, the largest of them, and when they have come to rest, in u.
_STEPS, _LONGEST, _RESTS = 10, 0.3, 1e-4
#: Sets beyond the three elements of the prior: so many times less probable for each element more.
_RARER = 6.0
#: As in the evidence: precision of u where nothing sees it.
_BLIND = 1e-2


def many(n_losses: int, n_elements: int) -> bool:
    """Whether a common factor may have come out as so many losses."""
    return n_losses >= max(2.0, n_elements / 3.0)


def common_loss(question: Question, losses: dict[int, float], threads: int) -> float:
    """The loss of all stiffnesses that is more probable than these losses of single ones and than none; 0 if
    there is no such."""
    prepared, prior = question.prepared(threads), question.prior
    likelihood, k, n = prepared.likelihood, len(losses), len(question.elements)
    u = np.zeros(likelihood.n)
    for element, loss in losses.items():
        u[prepared.numbers.index(element)] = -np.log1p(-min(loss, HIGHEST))
    each = np.eye(likelihood.n)[u > 0.0]
    share = (prior.nothing, prior.one, prior.two, prior.three)[min(k, 3)]
    of_set = np.log(share) - max(k - 3, 0) * np.log(_RARER) - np.log(comb(n, k))
    of_losses = _settled(likelihood, each, u[u > 0.0])[1] + of_set
    start = np.array([np.median(u[u > 0.0])])
    families = [np.arange(likelihood.n) < n, np.ones(likelihood.n, dtype=bool)]
    found = [_settled(likelihood, family[None].astype(np.float64), start) for family in families]
    at, of_factor = max(found, key=lambda one: one[1])
    of_nothing = likelihood.start.log_likelihood + np.log(prior.nothing)
    if of_factor + np.log(prior.unknown) <= max(of_losses, of_nothing):
        return 0.0
    return -float(np.expm1(-at[0]))


def _settled(likelihood: Likelihood, ways: FloatArray, start: FloatArray) -> tuple[FloatArray, float]:
    """Most probable severities (u) along some ways (k, n) through those of all elements, and the log
    evidence; bounds are not considered, so that it is at least so much."""
    u, size = start, float(np.log(HIGHEST))
    best, most = start, -np.inf
    for _ in range(_STEPS):
        beta = -np.expm1(-u @ ways)
        view = likelihood.views(beta[None])[0]
        by_u = ways * (1.0 - beta)
        gain = by_u @ view.gain - 1.0
        matrix = by_u @ view.curvature @ by_u.T + _BLIND * np.eye(u.size)
        step = np.linalg.solve(matrix, gain)
        volume = 0.5 * (u.size * np.log(2.0 * np.pi) - np.linalg.slogdet(matrix)[1])
        told = view.log_likelihood + 0.5 * float(gain @ step) + float(volume) - u.size * size - u.sum()
        if told > most:
            best, most = u, float(told)
        u = np.clip(u + np.clip(step, -_LONGEST, _LONGEST), 0.0, FURTHEST)
        if np.abs(step).max() < _RESTS:
            break
    return best, most
