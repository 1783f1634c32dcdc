"""From evidence to probabilities: of hypotheses, of elements, of groups that the data cannot tell apart."""

from __future__ import annotations

import numpy as np

from ..exceptions import reject
from .hypotheses import UNKNOWN, Hypothesis
from .likelihood import Likelihood
from .question import DamagePrior
from .search import Elements, Search

#: Probability of the intervals, and the shares between which they lie.
LEVEL = 0.9
_SHARES = (0.05, 0.95)
#: A group holds this share of the probability of its kind; and has at most so many hypotheses.
_GROUPED, _MOST_ALTERNATIVES = 0.9, 4
#: Hypotheses below this probability are dropped.
_LEAST = 1e-9


def log_weights(search: Search, likelihood: Likelihood, prior: DamagePrior) -> dict[Elements, float]:
    """Log of prior times evidence by elements, numbered as in the search; ``UNKNOWN`` for something else."""
    n, others = search.n_candidates, likelihood.n - search.n_candidates
    found = {
        elements: fit.log_evidence
        + (prior.log_elsewhere(others) if _outside(elements, n) else prior.log_of(len(elements), n))
        for elements, fit in search.fits.items()
    }
    found[UNKNOWN] = search.something_else + prior.log_unknown(others)
    return found


def posterior(
    search: Search, weights: dict[Elements, float], numbers: list[int], kept: Elements = ()
) -> list[Hypothesis]:
    """Hypotheses with their probabilities, the most probable first; ``numbers`` are the elements' own.
    Those that are all but impossible are dropped, but for ``kept``."""
    from scipy.special import logsumexp

    total = allowed(float(logsumexp(list(weights.values()))))
    rows = []
    for elements, weight in weights.items():
        probability = min(float(np.exp(weight - total)), 1.0)
        if probability < _LEAST and elements and elements != kept:
            continue
        if elements == UNKNOWN:
            rows.append(Hypothesis(UNKNOWN, probability, (), (), (), candidate=False))
            continue
        fit = search.fits[elements]
        limits = [fit.interval(nth, _SHARES) for nth in range(len(elements))]
        rows.append(
            Hypothesis(
                tuple(numbers[e] for e in elements),
                probability,
                tuple(float(b) for b in fit.beta),
                tuple(low for low, _ in limits),
                tuple(high for _, high in limits),
                candidate=not _outside(elements, search.n_candidates),
            )
        )
    return sorted(rows, key=lambda one: (-one.probability, one.elements))


def allowed(total: float) -> float:
    """Log of the sum of prior times evidence, which no prior may make zero."""
    if not np.isfinite(total):
        reject(
            "prior",
            "one that allows none of the hypotheses that were judged",
            "some probability for no damage or one element",
            "Leave the prior out, or give nothing, one and unknown more than 0.",
        )
    return total


def together(hypotheses: list[Hypothesis]) -> list[Hypothesis]:
    """The most probable damage of candidates with its alternatives: those that make up most of it.

    One hypothesis where it is clear; none where more than a few would be needed.
    """
    damage = [one for one in hypotheses if one.candidate and one.elements]
    if not damage:
        return []
    total = sum(one.probability for one in damage)
    group: list[Hypothesis] = []
    for one in damage:
        group.append(one)
        if sum(each.probability for each in group) >= _GROUPED * total:
            return group if len(group) <= _MOST_ALTERNATIVES else []
    return []


def _outside(elements: Elements, n_candidates: int) -> bool:
    return any(e >= n_candidates for e in elements)
