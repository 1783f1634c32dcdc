"""What a search without a baseline comes to, in words: it compares one state with the model."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from ..updating.model_check import Explained
from .evidence import BLIND, FURTHEST, HIGHEST

if TYPE_CHECKING:
    from ..support.checks import FloatArray
    from .likelihood import Likelihood, Question

#: So large a loss in half of the elements, or in so many, is none: the model is another structure.
_LOST, _MOST_LOST = 0.8, 4

_CAVEAT = (
    "Without a baseline an error of the model comes out as damage, and the values cannot tell which it is: "
    "give the values of the intact structure as baseline=."
)
_NO_BEFORE = (
    "Without a baseline it is not known what was there before, and errors of the model may hide damage."
)


def headline_of_one_state(
    losses: Mapping[int, float],
    label: Callable[[int], str],
    fit: Explained | None = None,
    n_elements: int = 0,
    *,
    finished: bool,
) -> list[str]:
    """The first lines of a report; ``losses`` are the severities found, the worst first.

    ``fit`` is what the model with these explains; None where that is not known.
    """
    found = "; ".join(
        f"{label(e)} has lost {100.0 * beta:.1f} % of its stiffness" for e, beta in losses.items()
    )
    if not finished:
        best = f"the best so far, if the model is exact, is that {found}" if losses else "no damage so far"
        return [f"The search was stopped: {best}.", _CAVEAT if losses else _NO_BEFORE]
    if fit is not None and (not fit.enough or all_lost(losses, n_elements)):
        so = f"the search came to this, which is no finding: {found}" if losses else "no damage is to be seen"
        return [fit.sentence, f"If the model can be trusted at all, {so}."]
    if losses:
        return [f"{found[0].upper()}{found[1:]}, if the model is exact.", _CAVEAT]
    return ["No damage found.", _NO_BEFORE]


def all_lost(losses: Mapping[int, float], n_elements: int) -> bool:
    """Whether so many elements have lost nearly all stiffness that it is no damage but a wrong model."""
    nearly = sum(beta >= _LOST for beta in losses.values())
    return nearly >= min(_MOST_LOST, max(0.5 * n_elements, 2.0))


# -- Without a baseline: is one factor on all stiffnesses more probable than the losses of many elements?
#
# A modulus, a section or a unit that is wrong throughout multiplies every stiffness by the same number. A
# search that knows losses only makes it a loss of nearly every element. Both are judged by the same
# likelihood, with the scatter of stiffnesses and masses that is assumed without a baseline, and by
# Laplace's approximation of the evidence: the one factor with every loss equally probable, as that of one
# element is, on the candidates or on all elements; the set of elements with the prior of their number.


#: Steps to the most probable factor, the largest of them, and when they have come to rest, in u.
_STEPS, _LONGEST, _RESTS = 10, 0.3, 1e-4
#: Sets beyond the three elements of the prior: so many times less probable for each element more.
_RARER = 6.0


def many(n_losses: int, n_elements: int) -> bool:
    """Whether a common factor may have come out as so many losses."""
    return n_losses >= max(2.0, n_elements / 3.0)


def common_loss(question: Question, losses: dict[int, float], threads: int) -> float:
    """The loss of all stiffnesses that is more probable than these losses of single ones and than none; 0 if
    there is no such."""
    prior, numbers = question.prior, question.numbers
    likelihood, k, n = question.prepared(threads).likelihood, len(losses), len(question.elements)
    u = np.zeros(likelihood.n)
    for element, loss in losses.items():
        u[numbers.index(element)] = -np.log1p(-min(loss, HIGHEST))
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
        matrix = by_u @ view.curvature @ by_u.T + BLIND * np.eye(u.size)
        step = np.linalg.solve(matrix, gain)
        volume = 0.5 * (u.size * np.log(2.0 * np.pi) - np.linalg.slogdet(matrix)[1])
        told = view.log_likelihood + 0.5 * float(gain @ step) + float(volume) - u.size * size - u.sum()
        if told > most:
            best, most = u, float(told)
        u = np.clip(u + np.clip(step, -_LONGEST, _LONGEST), 0.0, FURTHEST)
        if np.abs(step).max() < _RESTS:
            break
    return best, most
