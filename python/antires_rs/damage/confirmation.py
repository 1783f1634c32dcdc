"""The answers of a search on reduced models, judged anew where full and reduced model agree.

Each hypothesis that has a share in the answer gets a basis at its own severities, whose roots are compared
with those of the full model there, and is judged from it; so is no damage. All others stay as the search has
them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..support.progress import step
from ..updating.reduction import ReductionReport
from .evidence import HIGHEST, fitted
from .hypotheses import UNKNOWN
from .posterior import log_weights
from .reduced_roots import TOLERANCE, ReducedRoots

if TYPE_CHECKING:
    from .likelihood import Likelihood
    from .prior import DamagePrior
    from .search import Elements, Search

__all__ = ["confirmed"]

#: Hypotheses of at least this probability are confirmed, so many of them.
_SHARE, _MOST = 0.01, 6
#: Newton steps of each, and when it has come to rest, in u.
_STEPS, _RESTS = 4, 1e-4


def confirmed(search: Search, likelihood: Likelihood, prior: DamagePrior) -> ReductionReport | None:
    """Judge what matters of a search anew, and tell how full and reduced model agree; None without one."""
    source = likelihood.core
    if not isinstance(source, ReducedRoots):
        return None
    apart: dict[Elements, float] = {}
    try:
        while True:
            new = [elements for elements in _near(search, likelihood, prior) if elements not in apart]
            if not new or len(apart) >= _MOST:
                break
            apart[new[0]] = _settled(search, likelihood, source, new[0])
    except KeyboardInterrupt:
        search.interrupted = True
    worst = max(apart.values(), default=float("inf"))
    return ReductionReport(
        n_dof=source.terms.n_dof,
        size=source.largest,
        rounds=source.bases,
        estimate=source.expected,
        difference=worst,
        agreed=worst <= TOLERANCE,
        full_evaluations=source.full_evaluations,
    )


def _near(search: Search, likelihood: Likelihood, prior: DamagePrior) -> list[Elements]:
    """No damage, and the likeliest hypotheses, first the likeliest."""
    weights = log_weights(search, likelihood, prior)
    total = float(np.logaddexp.reduce(list(weights.values())))
    known = [s for s, weight in weights.items() if s != UNKNOWN and weight > total + np.log(_SHARE)]
    return [(), *sorted((s for s in known if s), key=lambda s: -weights[s])]


def _settled(search: Search, likelihood: Likelihood, source: ReducedRoots, elements: Elements) -> float:
    """Judge one hypothesis from its own severities on a basis made there; what full and reduced differ by."""
    at = list(elements)
    apart = 0.0
    for _ in range(_STEPS):
        step("the answers on the full model")
        betas = np.zeros((1, likelihood.n))
        betas[0, at] = np.minimum(search.fits[elements].beta, HIGHEST)
        apart = likelihood.settle(betas[0])
        fit = fitted(likelihood.views(betas)[0], elements, reach=np.inf)
        assert fit is not None  # none is too far away
        search.fits[elements] = fit
        beyond = np.log1p(-np.minimum(fit.beta, HIGHEST)) - np.log1p(-betas[0, at])
        if np.abs(beyond).max(initial=0.0) < _RESTS:
            break
    return apart
