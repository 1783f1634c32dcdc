"""Damage of one test in a fraction of a second: a plan made once, asked for every test."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..optimize.island_ga import seed_of, thread_count
from ..support.options import gathered
from ..support.progress import patient
from ..support.values import FrozenDict, ReadOnly
from ..updating.problem import UpdatingProblem
from ..views import Viewed
from .assess import checked_model, checked_search, elements_of
from .assessor_plan import Plan, plan_of, values_of
from .assessor_search import QuickSearch
from .evidence import HIGHEST, fitted
from .hypotheses import UNKNOWN, Assessment, Hypotheses, Hypothesis
from .inference import Elements, allowed, note_of_shift, together
from .likelihood import Band
from .options import TWO_STATES, DamagePrior, SearchOptions, checked_prior
from .question import Question
from .reduced_roots import wanted_reduced
from .words import headline, reservations

# -- What an :class:`Assessor` says of one test


@dataclass(frozen=True, eq=False, repr=False)
class AssessedTest(ReadOnly):
    """Damage of one test, as an :class:`~antires_rs.Assessor` has it.

    Fields that a :class:`~antires_rs.DamageResult` has too mean the same.

    Attributes
    ----------
    full_run_wanted : bool
        Whether the answer may not hold, and :func:`~antires_rs.assess_damage` should be asked.
    reasons : tuple of str
        Why; empty where it holds.
    severity : dict of int to float
        Stiffness loss of each candidate; 0 where there is no damage.
    interval : dict of int to (low, high)
        90 % interval of each severity, given the elements declared damaged; (0, 0) of the others.
    probability : dict of int to float
        Probability that each candidate is damaged, over all hypotheses that were judged.
    assessment : Assessment
        Hypotheses, chi-square and what they rest on.
    labels : dict of int to str
        What the elements are called.

    Examples
    --------
    >>> import antires_rs as ar
    >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [510.0, 495.0, 500.0])
    >>> before = ar.AntiresonanceSet(0, dict(enumerate(intact.antiresonances([0, 1, 2, 3], 0))))
    >>> model = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 500.0, 500.0])
    >>> ar.Assessor(model, baseline=before).assess(before).damaged
    []
    """

    full_run_wanted: bool
    reasons: tuple[str, ...]
    severity: Mapping[int, float]
    interval: Mapping[int, tuple[float, float]]
    probability: Mapping[int, float]
    assessment: Assessment
    labels: Mapping[int, str]

    @property
    def damaged(self) -> list[int]:
        """Elements with damage, the worst first."""
        return sorted((e for e, beta in self.severity.items() if beta > 0), key=lambda e: -self.severity[e])

    @property
    def hypotheses(self) -> Hypotheses:
        """The explanations of at least 1 % probability, the most probable first; prints as a table."""
        return self.assessment.hypotheses

    @property
    def probability_of_damage(self) -> float:
        """Probability that anything has changed."""
        return 1.0 - self.assessment.probability_of_nothing

    @property
    def probability_elsewhere(self) -> float:
        """Probability that something has changed which none of the candidates explains."""
        return self.assessment.probability_elsewhere

    @property
    def detectable(self) -> dict[int, float]:
        """Severity of each candidate that nine of ten tests would show which are as exact as the baseline."""
        return dict(zip(self.severity, self.assessment.detectable, strict=True))

    @property
    def chi_square(self) -> float:
        """Chi-square of the most probable hypothesis, over its degrees of freedom."""
        return self.assessment.chi_square

    @property
    def headline(self) -> str:
        """Is there damage, where, how sure, how much: in a sentence or two."""
        said = headline(self.assessment, self.labels.__getitem__)
        if self.full_run_wanted:
            said.append(f"A full run is wanted: {'; '.join(self.reasons)}.")
        return " ".join(said)

    @property
    def notes(self) -> list[str]:
        """What a reader should know before trusting the numbers."""
        return reservations(self.assessment, self.labels.__getitem__)

    def __repr__(self) -> str:
        best = self.hypotheses[0]
        wanted = ", full run wanted" if self.full_run_wanted else ""
        return f"AssessedTest({self.hypotheses.called(best)}, probability {best.probability:.3f}{wanted})"

    def __str__(self) -> str:
        return "\n".join([self.headline, "", str(self.hypotheses), *(f"note: {note}" for note in self.notes)])


# -- Does the prepared answer hold: the antiresonances of the answer, computed, against those of the tables


#: Sets so near to the likeliest (log probability) are checked like it.
CLOSE = 0.7
#: Errors of the interpolation that are corrected, and those that are too large (standard deviations of the
#: values).
_CORRECTED, _TOO_LARGE = 0.05, 0.5
#: Change of u, from where the answer was judged, after which it is judged again.
_MOVED = 2e-3
#: How often the answer is judged at most.
_ROUNDS = 4
#: What is so much likelier than all others (log probability) is the answer even with such errors.
_SURE = 2.0
#: Two hypotheses within this (log probability) may change places in a full run, by the number of elements.
_CLOSE = (0.1, 0.2, 0.5)
#: The same of damage of several elements, where one is the answer.
_SEVERAL = 0.05
#: Probability of something else from which on the full run is to look for it.
_UNKNOWN = 0.1
#: Share of values without a root that is too much, and how many are usual.
_LOST, _USUALLY_LOST = 0.1, 2
#: Severity beyond which the slopes say little.
_LARGE = 0.97
#: Values so far outside of the baseline's band (ln f) are not looked at.
_OUTSIDE = 0.3


def checked(search: QuickSearch, plan: Plan, best: Elements) -> list[str]:
    """Judge the answer with its exact antiresonances; what is wrong with the tables there."""
    if not best:
        return []
    t, usual = plan.tables, float(np.median(search.now.std))
    inside = (t.all_log_f[t.identity] > search.band.low) & (t.all_log_f[t.identity] < search.band.high)
    counted = t.seen & inside & (search.now.times_measured(t.response) > 0.0)
    other, worst, slopes = False, 0.0, False
    for _ in range(_ROUNDS):
        before = search.u[best]
        u = -np.log1p(-np.minimum(search.fits[best].beta, HIGHEST))
        placed, beside, known = search.test.places(list(best), u.tolist())
        exact, by = plan.exact(search.beta(best, u), search.band, slopes=slopes)
        there = np.isfinite(exact)
        other |= bool(np.any((there != known) & counted))
        off = np.where(there & known & t.old, exact - (placed - beside), 0.0)
        worst = max(worst, float(np.abs(off[counted]).max(initial=0.0)) / usual)
        moved = float(np.abs(u - before).max())
        if worst <= _CORRECTED and moved <= _MOVED and not other:
            return []
        there = np.where(t.old, there, known)
        place = np.where(there & ~known, exact + t.beside[0, 0], placed + off)
        search.keep(best, u, search.view(best, u, place.tolist(), there.tolist(), by))
        ahead = -np.log1p(-np.minimum(search.fits[best].beta, HIGHEST)) - u
        if np.abs(ahead).max() <= _MOVED:
            break
        slopes = True  # those of the tables do not lead there
    others = max(w for s, w in search.weights.items() if s != best)
    if search.weights[best] - others > _SURE:
        return []
    reasons = ["antiresonances meet or part near the severities found"] if other else []
    if worst > _TOO_LARGE:
        reasons.append(
            f"antiresonances differ from the prepared ones by up to {worst:.1f} standard deviations"
        )
    return reasons


def doubts(search: QuickSearch, best: Elements, weights: dict[Elements, float], unknown: float) -> list[str]:
    """Why a full run is wanted; ``unknown`` is the probability of something else."""
    reasons = []
    fit, now = search.fit(best), search.now
    others = [w for s, w in weights.items() if s not in (best, UNKNOWN)]
    if search.cut:
        reasons.append("more hypotheses are likely than were judged")
    elif others and weights[best] - max(others) < _CLOSE[min(len(best), 2)]:
        reasons.append("two hypotheses are about equally probable")
    if unknown > _UNKNOWN:
        reasons.append("something else than damage of the elements may have changed")
    if not search.explained(best):
        reasons.append("what was found does not explain all values")
    lost = now.size - int(fit.view.matched.sum())
    if lost > max(_USUALLY_LOST, _LOST * now.size):
        reasons.append(f"{lost} of {now.size} values have no antiresonance of the model")
    if fit.beta.max(initial=0.0) > _LARGE:
        reasons.append(f"a loss above {100 * _LARGE:.0f} %")
    if len(best) > 2:
        reasons.append("more than two damaged elements, of which a full run judges more sets")
    elif len(best) < 2 and (search.pair_hint > weights[best] or _of_several(search, weights) > _SEVERAL):
        reasons.append("two damaged elements may explain the values better")
    low, high = search.band.low, search.band.high
    if np.any((now.log_f < low - _OUTSIDE) | (now.log_f > high + _OUTSIDE)):
        reasons.append("values are far outside of the band of the baseline")
    return reasons


def _of_several(search: QuickSearch, weights: dict[Elements, float]) -> float:
    """Probability of sets of several elements that all have a loss."""
    own = [w for s, w in weights.items() if len(s) > 1 and np.all(search.u[s] > 0.0)]
    total = np.logaddexp.reduce(list(weights.values()))
    return float(np.exp(np.logaddexp.reduce([-np.inf, *own]) - total))


# -- From a search to an :class:`~antires_rs.damage.assessment.Assessment`


#: Shares between which intervals lie; hypotheses of less than this probability are not listed.
_SHARES = (0.05, 0.95)
_LISTED, _MOST = 0.01, 6
#: The same for sets of several elements that were not judged from their own severities.
_CLEAR = 0.05


def weighed(search: QuickSearch) -> tuple[dict[Elements, float], float]:
    """Log of prior times evidence of all sets and of something else, and of their sum."""
    others = search.n - search.n_candidates
    weights = {**search.weights, UNKNOWN: search.something_else + search.prior.log_unknown(others)}
    return weights, allowed(float(np.logaddexp.reduce(list(weights.values()))))


def declared_by(search: QuickSearch, plan: Plan, weights: dict[Elements, float]) -> Elements:
    """The set that is declared damaged, numbered as in the search."""
    candidates = len(plan.question.elements)
    best = max(weights, key=lambda s: weights[s])
    if best == UNKNOWN or any(e >= candidates for e in best):
        return ()
    if plan.learned.threshold is None:
        return best
    damage = {s: w for s, w in weights.items() if s and s != UNKNOWN and max(s) < candidates}
    if not damage:
        return ()
    odds = float(np.logaddexp.reduce(list(damage.values()))) - weights[()]
    return max(damage, key=lambda s: damage[s]) if odds > plan.learned.threshold else ()


def assessment_of(
    search: QuickSearch,
    plan: Plan,
    weights: dict[Elements, float],
    total: float,
    declared: Elements,
    notes: list[str],
    assumed: bool,
    sets: tuple[AntiresonanceSet, ...],
) -> Assessment:
    """Hypotheses with their probabilities, and how well the best explains the values."""
    rows = _rows(search, plan, weights, total, declared)
    numbers, learned = plan.numbers, plan.learned
    own = tuple(numbers.index(e) for e in rows[0].elements) if not rows[0].unknown else ()
    fit = search.fit(own if own in search.fits else ())
    matched = int(fit.view.matched.sum())
    shift = search.moved_alike if rows[0].unknown else 0.0
    found = Assessment(
        hypotheses=Hypotheses(rows, plan.names),
        group=tuple(together(rows)),
        declared=tuple(numbers[e] for e in declared),
        chi_square=fit.view.chi_square / max(matched - len(own), 1) if matched else np.nan,
        n_values=search.now.size,
        n_matched=matched,
        kappa=fit.view.kappa,
        factor_std=learned.s,
        root_std=learned.tau,
        threshold=learned.threshold,
        detectable=learned.detectable,
        baseline=True,
        assumed_std=learned.assumed_std or assumed,
        n_intact=learned.n_intact,
        n_intact_matched=learned.n_intact_matched,
        n_intact_roots=learned.n_intact_roots,
        n_baselines=learned.n_baselines,
        scatter=learned.scatter,
        notes=(*learned.notes, *notes, *note_of_shift(shift)),
        odd_baselines=learned.odd_baselines,
        baseline_gap=learned.baseline_gap,
        usual_gap=learned.usual_gap,
        moved_alike=shift,
    )
    if not found.model_fits:
        return replace(found, hint=learned.hint)
    return replace(found, hint=plan.question.hint_between(sets)) if 2 * matched < found.n_values else found


def _rows(
    search: QuickSearch, plan: Plan, weights: dict[Elements, float], total: float, declared: Elements
) -> list[Hypothesis]:
    """The hypotheses that are listed, the most probable first."""
    least = total + np.log(_LISTED)
    clear = total + np.log(_CLEAR)
    listed = [
        s
        for s, w in weights.items()
        if w > (least if s in search.fits or len(s) == 1 else clear) and s not in search.rough
    ]
    listed = sorted(listed, key=lambda s: -weights[s])[:_MOST]
    listed = list(dict.fromkeys([*listed, (), declared]))
    rows = []
    for elements in listed:
        probability = min(float(np.exp(weights[elements] - total)), 1.0)
        if elements == UNKNOWN:
            rows.append(Hypothesis(UNKNOWN, probability, (), (), (), candidate=False))
            continue
        fit = search.fits.get(elements) or fitted(search.seen_from[elements], elements, reach=np.inf)
        assert fit is not None
        limits = [fit.interval(nth, _SHARES) for nth in range(len(elements))]
        rows.append(
            Hypothesis(
                tuple(plan.numbers[e] for e in elements),
                probability,
                tuple(float(b) for b in fit.beta),
                tuple(low for low, _ in limits),
                tuple(high for _, high in limits),
                candidate=not any(e >= search.n_candidates for e in elements),
            )
        )
    return sorted(rows, key=lambda one: (-one.probability, one.elements))


# -- One test against a plan


def assess_at_once(plan: Plan, sets: tuple[AntiresonanceSet, ...]) -> AssessedTest:
    """Judge a test by what was prepared."""
    learned, question = plan.learned, plan.question
    now, notes, strange, assumed = values_of(sets, plan.expected, learned.scatter)
    band = Band(min(learned.low, float(now.log_f.min())), max(learned.high, float(now.log_f.max())))
    search = QuickSearch(
        plan.interpolated,
        now,
        band,
        question.options.std_common,
        plan.errors,
        learned.outside,
        len(plan.numbers),
        len(question.elements),
        question.prior,
        plan.pairs,
    )
    search.run()
    strange_of = {}
    while True:
        known = max(search.fits, key=lambda s: search.weights[s])
        near = [s for s in search.fits if search.weights[s] >= search.weights[known] - CLOSE]
        unknown = [s for s in sorted(near, key=lambda s: -search.weights[s])[:2] if s not in strange_of]
        if not unknown:
            break
        for each in unknown:
            strange_of[each] = checked(search, plan, each)
    strange += strange_of[known]
    weights, total = weighed(search)
    declared = declared_by(search, plan, weights)
    if declared not in search.fits:
        search.judge([declared])
        weights, total = weighed(search)
    strange += doubts(search, known, weights, float(np.exp(weights[UNKNOWN] - total)))
    assessment = assessment_of(search, plan, weights, total, declared, notes, assumed, sets)
    elements = question.elements
    of = {each.elements: each for each in assessment.hypotheses}.get(assessment.declared)
    severity = dict.fromkeys(elements, 0.0)
    interval = dict.fromkeys(elements, (0.0, 0.0))
    if of is not None:
        severity |= dict(zip(of.elements, of.severities, strict=True))
        interval |= dict(zip(of.elements, zip(of.low, of.high, strict=True), strict=True))
    share = np.zeros(search.n)
    for each, weight in weights.items():
        if each and each != UNKNOWN:
            share[list(each)] += np.exp(weight - total)
    return AssessedTest(
        bool(strange),
        tuple(dict.fromkeys(strange)),
        FrozenDict(severity),
        FrozenDict(interval),
        FrozenDict(zip(elements, np.minimum(share, 1.0).tolist(), strict=False)),
        assessment,
        FrozenDict(plan.names),
    )


class Assessor(ReadOnly, Viewed):
    """Assess the damage of single tests against a baseline, each in some tens of milliseconds.

    What does not depend on the test is done once: the model's errors are learned from the baseline, its
    antiresonances and their sensitivities computed over the severity of each element. A test is then judged
    by the likelihood of :func:`assess_damage`, and the antiresonances of the answer are computed and
    compared. Where the answer may not be that of a full run it says so, see
    :class:`AssessedTest`.

    Parameters
    ----------
    model : MassSpringChain, FrameModel or MatrixModel
        The undamaged structure; it need not be updated.
    baseline : AntiresonanceSet, or several
        The intact structure, with the sensors and forces of the tests to come.
    elements : sequence of int, optional
        Candidate elements, zero-based. Default as for :func:`assess_damage`.
    prior : DamagePrior, optional
        What is believed before the test.
    search : SearchOptions, optional
        Those with a baseline; a rate of false alarms is that of tests as exact as the baseline.
    rng : int or numpy.random.Generator, optional
        For a rate of false alarms.
    workers : int, optional
        Threads that compute the tables; all processors by default. No bit depends on it.
    progress : bool, optional
        Show a line of progress; by default on a terminal.
    **older
        Options of ``search`` by name, as until 0.1; with a warning.

    Raises
    ------
    InvalidInputError
        An element outside the model, a baseline without antiresonances near the model's, tables of more than
        2 GB, or a malformed argument.

    Notes
    -----
    The tables take 8 bytes times levels (15), elements squared, and antiresonances: seconds and tens of MB
    for 50 elements. :meth:`assess` is safe in several threads and processes; BLAS should have one thread
    (``OPENBLAS_NUM_THREADS=1``), since more of them make small matrices slower.

    Examples
    --------
    >>> import antires_rs as ar
    >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [510.0, 495.0, 500.0])
    >>> damaged = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [510.0, 297.0, 500.0])
    >>> before, now = (ar.AntiresonanceSet(0, dict(enumerate(m.antiresonances([0, 1, 2, 3], 0))))
    ...                for m in (intact, damaged))
    >>> assessor = ar.Assessor(ar.MassSpringChain([1.0] * 4, [500.0] * 3), baseline=before)
    >>> found = assessor.assess(now)
    >>> found.damaged, round(found.severity[1], 2)
    ([1], 0.4)
    """

    _plan: Plan

    @patient("preparing the assessor")
    def __init__(
        self,
        model: StructuralModel,
        *,
        baseline: AntiresonanceSet | Sequence[AntiresonanceSet],
        elements: Any = None,
        prior: DamagePrior | None = None,
        search: SearchOptions | None = None,
        rng: int | np.random.Generator | None = None,
        workers: int | None = None,
        progress: bool | None = None,
        **older: Any,
    ) -> None:
        checked_model(model)
        before = _sets("baseline", baseline)
        if not any(any(map(len, each.values())) for each in before):
            reject(
                "baseline", "no antiresonance", "those of the intact structure", "Identify in a wider band."
            )
        chosen = elements_of(model, elements)
        UpdatingProblem(model, stiffness_reduction(chosen), before)  # speaks up where they do not fit
        options = gathered("Assessor", "search", checked_search(search), older, stacklevel=4).of(TWO_STATES)
        believed = checked_prior(prior, options)
        first = {each.excitation: each for each in reversed(before)}
        question = Question(
            model,
            before,
            tuple(reversed(first.values())),
            tuple(chosen),
            believed,
            options,
            reduced=wanted_reduced(model, before[0], options.reduction),
        )
        generator = np.random.default_rng(seed_of(rng))
        self._fill(_plan=plan_of(question, generator, thread_count(workers)))

    @classmethod
    def _of(cls, plan: Plan) -> Assessor:
        made = cls.__new__(cls)
        made._fill(_plan=plan)
        return made

    @property
    def elements(self) -> list[int]:
        """Candidate elements, zero-based."""
        return list(self._plan.question.elements)

    @property
    def model(self) -> StructuralModel:
        """The undamaged structure."""
        return self._plan.question.model

    @property
    def baseline(self) -> tuple[AntiresonanceSet, ...]:
        """The intact structure as it was measured."""
        return self._plan.question.baseline  # type: ignore[return-value]

    @property
    def detectable(self) -> dict[int, float]:
        """Severity of each candidate that nine of ten tests as exact as the baseline would show."""
        return dict(zip(self.elements, self._plan.learned.detectable, strict=True))

    def assess(self, zeros: AntiresonanceSet | Sequence[AntiresonanceSet]) -> AssessedTest:
        """The damage of one test.

        Parameters
        ----------
        zeros : AntiresonanceSet, or one for each position of the force
            Identified as the baseline was. Responses that the baseline does not have are left out, which is
            among the reasons for a full run.

        Raises
        ------
        InvalidInputError
            No antiresonance, or a force that the baseline does not have.
        """
        return assess_at_once(self._plan, _sets("zeros", zeros))

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write model, baseline and tables to an .npz file, whole or not at all; no pickle is in it."""
        return self._view("save")(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Assessor:
        """Read what :meth:`save` wrote; its answers are bit-identical.

        Raises
        ------
        InvalidInputError
            Another file, a damaged one, or one of a later version.
        FileNotFoundError
            No such file.
        """
        return cls._view("load")(path)

    def __repr__(self) -> str:
        values = self._plan.learned.n_intact
        return f"Assessor({len(self.elements)} candidates, {values} antiresonances in the baseline)"


def _sets(name: str, given: Any) -> tuple[AntiresonanceSet, ...]:
    sets = (given,) if isinstance(given, AntiresonanceSet) else given
    wrong = not isinstance(sets, Sequence) or isinstance(sets, str)
    if wrong or not sets or not all(isinstance(each, AntiresonanceSet) for each in sets):
        reject(
            name,
            type(given).__name__,
            "an AntiresonanceSet, or several",
            "Identify the antiresonances first: ar.identify_antiresonances(record, ...).",
        )
    return tuple(sets)
