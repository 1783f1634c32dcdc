"""Intervals of severities after an assessment against a baseline: quick ones, and sure ones by sampling."""

from __future__ import annotations

from typing import cast

import numpy as np

from ..optimize.arguments import seed_of, thread_count
from ..support.one_thread import one_blas_thread
from ..support.progress import patient
from ..support.validation import FloatArray, choice, finite_scalar, integer
from ..updating.parameter_intervals import Method
from .assessment import Assessment
from .evidence import HIGHEST, Fit, fitted
from .hypotheses import Hypothesis
from .likelihood import Likelihood
from .posterior import LEVEL
from .question import Question
from .sampling import Sampled, linear, sampled
from .severity_intervals import SampledSet, SeverityIntervals

__all__ = ["severity_intervals"]

#: Hypotheses of at least this probability are sampled, so many of them.
_NEAR, _MOST = 0.01, 4
#: Share of the draws that the points of the severities declared should be worth; least number of any set.
_WORTH, _LEAST = 0.15, 30
#: Sets of at least this probability are worth particles, where no Gaussian serves.
_MAIN = 0.2
#: Change of a probability that is worth a word, and share of the wanted draws that are too few.
_CHANGED, _FEW = 0.02, 0.5
#: Newton steps from the severities of a hypothesis, and when they have come to rest, in u.
_STEPS, _RESTS = 4, 1e-4


@patient("intervals")
@one_blas_thread
def severity_intervals(
    question: Question,
    found: Assessment,
    names: list[str],
    *,
    method: Method,
    level: float,
    draws: int,
    rng: int | np.random.Generator | None,
    workers: int | None,
    progress: bool | None = None,
) -> SeverityIntervals:
    """Intervals given the elements declared damaged; see ``DamageResult.intervals``."""
    choice("method", method, ("laplace", "ensemble"))
    finite_scalar("level", level, low=0.5, high=0.999)
    integer("draws", draws, low=50, high=1_000_000)
    seed, sure = seed_of(rng), method == "ensemble"
    prepared = question.prepared(thread_count(workers))
    near = [h for h in found.hypotheses if h.elements and not h.unknown and h.probability >= _NEAR][:_MOST]
    declared = next((h for h in found.hypotheses if found.declared and h.elements == found.declared), None)
    if declared is not None and declared not in near:
        near.append(declared)
    parts: list[tuple[Fit, Sampled]] = []
    notes: list[str] = []
    for nth, one in enumerate(near):
        fit = _settled(prepared.likelihood, one, prepared.numbers)
        own = np.random.default_rng([seed, nth])
        wanted = _WORTH * draws * (1.0 if one is declared else one.probability)
        few = max(int(wanted), _LEAST)
        name, main = found.hypotheses.called(one), one is declared or one.probability >= _MAIN
        part = sampled(prepared.likelihood, fit, few, own, name, main) if sure else linear(fit, draws, own)
        if sure and part.effective < _FEW * few:
            notes.append(f"Draws of {name} are worth {part.effective:.0f} independent ones: take more.")
        parts.append((fit, part))
    confirmed, nothing = _confirmed(found, near, parts)
    sets = tuple(
        SampledSet(h.elements, h.candidate, h.probability, c, part.effective, part.weight.size)
        for h, c, (_, part) in zip(near, confirmed, parts, strict=True)
    )
    column = {e: nth for nth, e in enumerate(question.elements)}
    rng = np.random.default_rng([seed, len(near)])
    shape = (draws, len(column))
    own_draws, low, high = np.zeros(shape), np.zeros(len(column)), np.zeros(len(column))
    words = ["not damaged"] * len(column)
    if declared is not None:
        fit, part = parts[near.index(declared)]
        values = part.resampled(draws, rng)
        for nth, e in enumerate(declared.elements):
            own_draws[:, column[e]] = values[:, nth]
            words[column[e]], shares = _sides(fit, nth, level)
            ends = part.quantiles(nth, shares) if sure else fit.interval(nth, _central(level))
            if not sure and level == LEVEL:  # as the assessment has it, from where its search came to rest
                ends = declared.low[nth], declared.high[nth]
            low[column[e]], high[column[e]] = ends
    if sure:
        notes = [*_verdict(found, near, confirmed), *notes]
    return SeverityIntervals(
        tuple(names),
        method,
        float(level),
        low,
        high,
        np.median(own_draws, axis=0),
        np.std(own_draws, axis=0),
        tuple(words),
        own_draws,
        found.chi_square,
        2.0 * found.root_std,
        tuple(notes),
        question.elements,
        _mixture(near, confirmed, parts, nothing, column, draws, rng),
        sets,
    )


def _settled(likelihood: Likelihood, one: Hypothesis, numbers: tuple[int, ...]) -> Fit:
    """The Gaussian of a hypothesis, as seen from its own severities."""
    elements, beta = tuple(numbers.index(e) for e in one.elements), np.array(one.severities)
    for _ in range(_STEPS):
        betas = np.zeros((1, likelihood.n))
        betas[0, list(elements)] = np.minimum(beta, HIGHEST)
        fit = cast("Fit", fitted(likelihood.views(betas)[0], elements, reach=np.inf))
        apart = np.abs(np.log1p(-np.minimum(fit.beta, HIGHEST)) - np.log1p(-betas[0, list(elements)]))
        beta = fit.beta
        if apart.max() < _RESTS:
            break
    return fit


def _central(level: float) -> tuple[float, float]:
    return 0.5 - 0.5 * level, 0.5 + 0.5 * level


def _sides(fit: Fit, nth: int, level: float) -> tuple[str, tuple[float, float]]:
    """A word on the interval, and the shares between which it lies."""
    shares = fit.sides(nth, _central(level))
    word = "from 0 on" if shares[0] == 0.0 else f"up to {HIGHEST:g}" if shares[1] == 1.0 else "two-sided"
    return word, shares


def _confirmed(
    found: Assessment, near: list[Hypothesis], parts: list[tuple[Fit, Sampled]]
) -> tuple[list[float], float]:
    """Probabilities of the near hypotheses and of no damage, with the evidence of the draws; the weights of
    the others as they were."""
    weight = [
        one.probability * float(np.exp(part.log_evidence - fit.log_evidence))
        for one, (fit, part) in zip(near, parts, strict=True)
    ]
    others = sum(one.probability for one in found.hypotheses) - sum(one.probability for one in near)
    total = sum(weight) + max(others, 0.0)
    return [each / total for each in weight], found.probability_of_nothing / total


def _verdict(found: Assessment, near: list[Hypothesis], confirmed: list[float]) -> list[str]:
    """What sampling says of the probabilities."""
    if not near:
        return []
    changed = [
        f"{found.hypotheses.called(one)} {each:.2f} instead of {one.probability:.2f}"
        for one, each in zip(near, confirmed, strict=True)
        if abs(each - one.probability) >= _CHANGED
    ]
    if changed:
        return [f"Sampling changes probabilities: {'; '.join(changed)}."]
    most = max(abs(each - one.probability) for one, each in zip(near, confirmed, strict=True))
    return [f"Sampling confirms the probabilities to within {max(most, 0.001):.3f}."]


def _mixture(
    near: list[Hypothesis],
    confirmed: list[float],
    parts: list[tuple[Fit, Sampled]],
    nothing: float,
    column: dict[int, int],
    draws: int,
    rng: np.random.Generator,
) -> FloatArray:
    """Draws of no damage and of the near sets of candidates, by their probabilities."""
    mine = [nth for nth, one in enumerate(near) if one.candidate]
    shares = np.array([nothing, *(confirmed[nth] for nth in mine)])
    drawn = np.zeros((draws, len(column)))
    if not shares.sum():
        return drawn
    which = rng.choice(shares.size, size=draws, p=shares / shares.sum())
    for k, nth in enumerate(mine, start=1):
        rows = np.flatnonzero(which == k)
        at = [column[e] for e in near[nth].elements]
        if rows.size:
            drawn[rows[:, None], at] = parts[nth][1].resampled(rows.size, rng)
    return drawn
