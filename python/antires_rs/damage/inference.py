"""From two measured states to an :class:`Assessment`: learn the model's errors, search, weigh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..models.parameter import Parameter
from ..support.checks import FloatArray
from ..support.progress import step
from ..support.threads import one_blas_thread
from ..updating.model_check import roots_between
from ..updating.reduced_search import ReductionReport
from .assessment import Assessment
from .evidence import HIGHEST, fitted
from .hypotheses import UNKNOWN, Hypotheses, figure
from .likelihood import Likelihood
from .measured_modes import ModeResponses
from .measured_states import Responses, Values
from .one_state import mostly_risen
from .posterior import log_weights, posterior, together
from .question import Question
from .reduced_roots import TOLERANCE, ReducedRoots
from .roots import Roots
from .search import Search
from .thresholds import intact_slopes, log_odds_threshold, smallest_found

if TYPE_CHECKING:
    from .likelihood import Likelihood
    from .question import DamagePrior
    from .search import Elements, Search


# -- The answers of a search on reduced models, judged anew where full and reduced model agree
#
# Each hypothesis that has a share in the answer gets a basis at its own severities, whose roots are
# compared with those of the full model there, and is judged from it; so is no damage. All others stay as
# the search has them.


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


#: Largest number of damaged elements in one hypothesis.
MOST = 3
#: Relative standard deviation of what moves all values alike between two tests.
STD_COMMON = 5e-4


@dataclass(frozen=True)
class Inferred:
    """An assessment, the model after the baseline, and the values of now as that model would have them."""

    assessment: Assessment
    factors: tuple[Parameter, ...]
    values: FloatArray
    severities: dict[int, float]
    nfev: int
    interrupted: bool
    #: The values of now as the model after the baseline would have them: what is wrong in both states taken
    #: out.
    corrected: list[Any]
    #: How reduced models served; None where there were none.
    reduction: ReductionReport | None


@one_blas_thread
def infer(
    question: Question, *, false_alarm_rate: float | None, rng: np.random.Generator, threads: int
) -> Inferred:
    """Judge all hypotheses."""
    elements, prior, baseline = question.elements, question.prior, question.baseline
    prepared = question.prepared(threads)
    likelihood, error, numbers = prepared.likelihood, prepared.error, list(prepared.numbers)
    intact, now, responses, odd = prepared.intact, prepared.now, prepared.responses, prepared.odd
    search = Search(likelihood, len(elements), MOST)
    search.run()
    reduction = confirmed(search, likelihood, prior)
    weights = log_weights(search, likelihood, prior)
    damage = {s: w for s, w in weights.items() if s and s != UNKNOWN and max(s) < len(elements)}
    likeliest = max(damage, key=lambda s: damage[s], default=())
    rows = posterior(search, weights, numbers, likeliest)
    names = {e: question.model.element_label(e) for e in numbers}
    threshold, slopes = None, intact_slopes(likelihood, len(elements))
    declared = rows[0].elements if rows[0].candidate else ()
    if false_alarm_rate is not None:
        threshold = log_odds_threshold(slopes, prior, false_alarm_rate, rng)
        odds = float(np.logaddexp.reduce([-np.inf, *damage.values()])) - weights[()]
        declared = tuple(numbers[e] for e in likeliest) if odds > threshold else ()
        if not rows[0].candidate:
            declared = ()
    key = tuple(numbers.index(e) for e in rows[0].elements) if rows[0].elements != UNKNOWN else ()
    fit = search.fits[key]
    matched = int(fit.view.matched.sum())
    shift = (likelihood.moved_alike() if rows[0].unknown else None) or 0.0
    assessment = Assessment(
        hypotheses=Hypotheses(rows, names),
        group=tuple(together(rows)),
        declared=declared,
        chi_square=fit.view.chi_square / max(matched - len(key), 1) if matched else np.nan,
        n_values=now.size,
        n_matched=matched,
        kappa=fit.view.kappa,
        factor_std=error.s,
        root_std=error.tau,
        threshold=threshold,
        detectable=tuple(smallest_found(slopes, prior).tolist()),
        baseline=bool(baseline),
        assumed_std=responses.assumed,
        n_intact=intact.size,
        n_intact_matched=int((error.partner >= 0).sum()),
        n_baselines=prepared.n_baselines,
        scatter=prepared.scatter,
        notes=(*responses.left_out, *note_of_shift(shift), *_of_screening(search)),
        odd_baselines=odd.tests if odd else (),
        baseline_gap=odd.apart if odd else 0.0,
        usual_gap=odd.usual if odd else 0.0,
        interrupted=search.interrupted,
        moved_alike=shift,
        n_intact_roots=roots_beside(intact, error.intact),
    )
    if not assessment.model_fits:
        assessment = replace(assessment, hint=question.hint())
    elif baseline and 2 * matched < now.size:
        assessment = replace(assessment, hint=question.hint_between(question.measured))
    if baseline and not shift and not assessment.explained:  # a change of unknown kind explains nothing
        up, moved = mostly_risen(intact.plain, now.plain)
        assessment = replace(assessment, n_risen=up, n_moved=moved)
    found = next((one for one in rows if one.elements == declared), None)
    severities = dict(zip(declared, found.severities, strict=True)) if found else {}
    betas = np.zeros((1, len(numbers)))
    for e, beta in severities.items():
        betas[0, numbers.index(e)] = beta
    return Inferred(
        assessment,
        prepared.factors,
        np.exp(error.theta),
        severities,
        likelihood.nfev,
        search.interrupted,
        _corrected(likelihood, betas, responses),
        reduction,
    )


def roots_beside(intact: Any, roots: Roots) -> int:
    """Roots between the values of each response, test by test; 0 for modes, which have shapes."""
    if not isinstance(intact, Values):
        return 0
    return sum(
        roots_between(intact.response[own], intact.log_f[own], roots.response, roots.log_f)
        for own in (intact.test == test for test in np.unique(intact.test))
    )


def note_of_shift(moved: float) -> list[str]:
    """A note where all values have moved alike, which is no damage."""
    if not moved:
        return []
    way = "higher" if moved > 0.0 else "lower"
    return [
        f"All values are {figure(abs(moved))} {way} than in the intact state, as at another temperature or "
        "by another sampling clock: correct them for it, or raise std_common."
    ]


def _of_screening(search: Search) -> list[str]:
    """A note on what was looked at less closely, where there are many elements."""
    if search.screened is None:
        return []
    closely, count = search.screened
    return [
        f"Of {count} elements the {closely} that would explain most to first order were scanned from 2 to "
        "97 % loss; the others were judged from the slopes of the undamaged model."
    ]


def _corrected(likelihood: Likelihood, betas: FloatArray, responses: Responses | ModeResponses) -> list[Any]:
    view, roots = likelihood.views(betas)[0], likelihood.near(likelihood.roots(betas, slopes=False)[0])[0]
    now: Any = likelihood.now
    return list(responses.corrected(now, roots, view.partner, view.beside))
