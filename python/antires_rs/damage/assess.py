"""Damage assessment: the call and its result, and the assessor that is prepared for many tests."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import comb
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core import __version__
from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel, checked_model
from ..optimize.island_ga import History, IslandGA, OptimizeResult, seed_of, thread_count
from ..support.checks import FloatArray, integer, shape_of
from ..support.messages import some, warn
from ..support.options import gathered
from ..support.progress import one_blas_thread, patient, waiting
from ..support.values import FrozenDict, ReadOnly
from ..updating.identifiability import smallest_visible
from ..updating.problem import (
    DamagePenalty,
    Explained,
    Measured,
    UpdatingProblem,
    explained,
    refuse_other_units,
)
from ..updating.reduced_model import LARGE, ReductionReport
from ..updating.result import UpdateResult
from ..updating.targets import FrequencyTable, ModalTable, sets_of
from ..updating.update import search as find
from ..views import Viewed
from .assessor_plan import Plan, QuickSearch, TabulatedLikelihood, plan_of, read
from .hypotheses import Answered, Assessment, figure
from .inference import BLIND, FURTHEST, HIGHEST, Search, concluded, confirmed, learned_from
from .likelihood import Likelihood, Prepared, Question
from .measured_states import ASSUMED_STD, PAIRED_STATES, Responses, repeated, unfit, warn_of_channels
from .options import ONE_STATE, TWO_STATES, DamagePrior, SearchOptions, checked_prior
from .reduced_roots import ReducedRoots
from .severity_intervals import severity_intervals, severity_profile
from .shape_search import find_shapes
from .words import (
    UNREDUCED,
    UNSEEN_OF_ONE,
    all_lost,
    headline,
    headline_of_one_state,
    largest_left,
    reservations,
)

if TYPE_CHECKING:
    from ..updating.posterior import ParameterIntervals, ProfileLikelihood


# -- The model, the elements and the sets that a question about damage names


def elements_of(model: StructuralModel, elements: Any) -> list[int]:
    """Candidate elements by number: all springs between masses, all beams or all terms by default."""
    terms = model._core.n_stiffness_terms
    if elements is None:
        chosen = list(model.default_elements)
    elif isinstance(elements, str) or (shape_of(elements) == () and not np.isscalar(elements)):
        reject("elements", elements, "numbers of elements", "As in elements=[3, 4].")
    else:
        chosen = [elements] if shape_of(elements) == () else list(elements)
    if not chosen:
        remedy = f"Name some of 0 to {terms - 1}." if terms else "Give the MatrixModel its stiffness_terms."
        reject("elements", "no candidate", "at least one stiffness term", remedy)
    chosen = [model.element(e) if isinstance(e, str) else e for e in chosen]
    numbers = [integer(("elements", i), e, low=0, high=terms - 1) for i, e in enumerate(chosen)]
    if len({*numbers}) < len(numbers):
        reject("elements", f"{numbers}, one of them twice", "each element once", "Drop the second one.")
    return numbers


def question_of(
    model: StructuralModel,
    before: tuple[Any, ...],
    now: tuple[Any, ...],
    elements: list[int],
    prior: DamagePrior | None,
    options: SearchOptions,
) -> Question:
    """Two states that can be compared."""
    believed, modes = checked_prior(prior, options), isinstance(now[0], ModalSet)
    if type(before[0]) is not type(now[0]):
        kinds = ("an AntiresonanceSet", "a ModalSet") if modes else ("a ModalSet", "an AntiresonanceSet")
        reject("baseline", kinds[0], f"{kinds[1]}, as measured", "Compare what is of one kind.")
    if not any(any(each.freq_hz) if modes else any(map(len, each.values())) for each in before):
        got = "no mode" if modes else "no antiresonance"
        reject("baseline", got, "those of the intact structure", "Identify in a wider band.")
    UpdatingProblem(model, stiffness_reduction(elements), now)  # speaks up where they do not fit
    most = max(before, key=lambda each: each.freq_hz.size if modes else sum(map(len, each.values())))
    refuse_other_units(UpdatingProblem(model, stiffness_reduction(elements), most))
    reduced = bool(options.reduction)
    if options.reduction == "auto":
        reduced = model.n_dof > LARGE and not modes
    elif reduced and modes:
        reject("reduction", "a reduced model, but modes were measured", "antiresonances", "Leave it out.")
    return Question(model, before, now, tuple(elements), believed, options, reduced=reduced)


# -- The result

_WIDTH_90 = 2.0 * 1.6448536269514722  # width of the 90 % interval of a Gaussian, in standard deviations
#: Without a baseline: differences so many times the errors of the values are the model's, and damage that
#: leaves more than this share of them may be made of them.
_BEYOND, _MOST = 3.0, 0.5
#: Relative scatter of stiffnesses and masses that probabilities without a baseline assume.
ASSUMED_MODEL_ERROR = 0.03


class DamageResult(Answered, UpdateResult):
    """Damage found: an :class:`UpdateResult` whose ``x`` holds the severities beta.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> result = ar.assess_damage(case.model, case.exact(level=1), rng=0)
    >>> result.damaged, round(result.severity[4], 2)
    ([4], 0.55)
    """

    _assessment: Assessment | None
    _question: Question | None

    def __init__(
        self,
        problem: UpdatingProblem,
        search: OptimizeResult,
        seed: int,
        assessment: Assessment | None = None,
        question: Question | None = None,
        reduction: ReductionReport | None = None,
        *,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__(problem, search, seed, reduction, options=options)
        self._fill(_assessment=assessment, _question=question)

    @cached_property
    def assessment(self) -> Assessment:
        """Hypotheses and what they rest on; without a baseline with an assumed error of the model."""
        if self._assessment is not None:
            return self._assessment
        return infer(self._alone, np.random.default_rng(self.seed), thread_count(None))[0]

    @cached_property
    def table(self) -> FrequencyTable | ModalTable:
        """Measured values, with a baseline corrected by it, beside the model without and with the damage
        found, NaN where that has nothing near.
        """
        table = super().table
        if self._assessment is None:
            return table
        columns: dict[str, Any] = {}
        for state, hz in (("before", table.before_hz), ("after", table.after_hz)):
            near = np.abs(np.log(hz / table.measured_hz)) <= PAIRED_STATES
            for name in (f"{state}_hz", f"{state}_mac", f"{state}_mode"):  # modes have all three
                if (column := getattr(table, name, None)) is not None:
                    columns[name] = np.where(near, column, np.nan)
        return replace(table, corrected=True, **columns)

    @cached_property
    def _alone(self) -> Question:
        """What is asked of one state."""
        model, measured, elements = self.problem.model, tuple(self.problem.measured), tuple(self.elements)
        options = SearchOptions(std_common=0.0)
        return Question(model, (), measured, elements, DamagePrior(), options, ASSUMED_MODEL_ERROR)

    @property
    def has_baseline(self) -> bool:
        """Whether changes were compared with changes, or one state with the model."""
        return self._assessment is not None

    @property
    def std(self) -> FloatArray:
        """Standard deviation of each severity, (n,); NaN where it is 0.

        With a baseline that of a Gaussian with the 90 % interval, without one of the values' errors alone.
        """
        if self._assessment is None:
            return super().std
        width = np.array([high - low for low, high in self.interval.values()])
        return np.where(width > 0.0, width / _WIDTH_90, np.nan)

    @property
    def headline(self) -> str:
        """Is there damage, where, how sure, how much: in a sentence or two.

        Without a baseline that of the search, as :attr:`severity`, and what it rests on; :attr:`hypotheses`
        allow for errors of the model and may come to another answer.
        """
        return " ".join(self._headline())

    def _headline(self) -> list[str]:
        if self._assessment is not None:
            return headline(self._assessment)
        found = self._losses, self.problem.model.element_label, self._fit, len(self.elements)
        doubt = unfit((), self.problem.measured)
        return headline_of_one_state(*found, doubt, finished=self.search.status != "interrupted")

    @property
    def _losses(self) -> dict[int, float]:
        """Of the damaged elements, the worst first."""
        return {e: self.severity[e] for e in self.damaged}

    @cached_property
    def _fit(self) -> Explained | None:
        """What the model with the damage found explains, without a baseline."""
        if self._assessment is not None or self.search.status == "interrupted":
            return None
        losses, n = self._losses, len(self.elements)
        common = common_loss(self._alone, losses, thread_count(None))
        found = explained(self.problem, self.x, doubted=bool(common) or all_lost(losses, n))
        return replace(found, common_loss=common, left=self._left())

    def _left(self) -> float:
        """The largest difference of a frequency with the damage found, relative; 0 where these differences
        are as the errors of the values are, or the damage explains most of them."""
        value, kind, std = self.problem._targets.error_rows()
        of_hz = np.full(self.table.measured_hz.size, ASSUMED_STD)
        of_hz[value[kind == 0]] = 0.5 * std[kind == 0]  # these are of squares
        both = self.table.before_percent, self.table.after_percent
        before, after = (np.nan_to_num(np.abs(each)) / 100.0 for each in both)
        beyond = after / np.where(np.isfinite(of_hz), of_hz, ASSUMED_STD)
        usual = not after.size or np.sqrt(np.mean(beyond**2)) < _BEYOND
        return 0.0 if usual or after.sum() < _MOST * before.sum() else float(after.max())

    @property
    def elements(self) -> list[int]:
        """Candidate elements, zero-based, in the order of ``x``."""
        return [p.terms[0] for p in self.problem.parameters]

    @property
    def severity(self) -> dict[int, float]:
        """Stiffness loss beta of each element; exactly 0 where there is no damage."""
        return {element: float(beta) for element, beta in zip(self.elements, self.x, strict=True)}

    @property
    def detectable(self) -> dict[int, float]:
        """Smallest beta of each element that would be seen; infinity where none would.

        With a baseline: at which nine of ten such tests would declare the element, and no other that moves
        the values alike, with the errors of the values and those that the baseline leaves to the model.
        Without one: below it the penalties cost more than the damage explains, on exact data.
        """
        return dict(zip(self.elements, self._detectable, strict=True))

    @cached_property
    def _detectable(self) -> tuple[float, ...]:
        return self._assessment.detectable if self._assessment else tuple(smallest_visible(self.problem))

    def _intervals(self, *asked: Any) -> ParameterIntervals:
        if self._assessment is None:
            return super()._intervals(*asked)
        return severity_intervals(self._asked(), self._assessment, self.problem.names, *asked)

    def _profile(self, *asked: Any) -> ProfileLikelihood:
        if self._assessment is None:
            return super()._profile(*asked)
        return severity_profile(self._asked(), self._assessment, self.problem.names, *asked)

    def _asked(self) -> Question:
        """Both states, as they were assessed."""
        if self._question is None:
            got = "one without the values of the baseline, of an older file"
            remedy = "Assess the damage again; .interval has its 90 % intervals."
            reject("result", got, "one that assess_damage has made, or a file of one", remedy)
        return self._question

    def _values(self) -> list[str]:
        """The damaged elements, the worst first; the others are exactly 0 and take one line."""
        width, at = max(map(len, self.problem.names)), list(map(self.elements.index, self.damaged))
        rows = [(self.problem.names[i], 100 * self.x[i], 100 * self.std[i]) for i in at]
        lines = [f"{name:<{width}}  {loss:6.2f} % \u00b1 {std:.2g} %" for name, loss, std in rows]
        others = len(self.elements) - len(lines)
        rest = "all others" if lines else "all of them"
        return [*lines, *([f"{rest} ({others}): exactly 0"] if others else [])]

    @property
    def notes(self) -> list[str]:
        """What a reader should know before trusting the numbers."""
        label = self.problem.model.element_label
        if self._assessment is None:
            notes = [*super().notes, *self._of_the_penalties()]
        else:
            notes = [] if self.success else [f"The search did not finish: {self.message}"]
            notes += reservations(self._assessment)
            if self.reduction is not None:
                notes.append(self.reduction.note_with(UNREDUCED))
            notes += [*self._of_the_values(), *([self.separating_test] if self.separating_test else [])]
            if self._assessment.n_baselines == 1:
                notes.append(UNSEEN_OF_ONE)
            elif seen := self._visible():
                notes.append(f"Smallest damage that nine of ten such tests would show: {seen}.")
        others = [label(e) for e in self.problem.model._springs if e not in self.severity]
        if others:
            blamed = "would be blamed on others" if self._assessment is None else "counts as elsewhere"
            notes.append(f"No candidates: {some(others)}. Damage there {blamed}.")
        hidden = [label(e) for e, b in self.detectable.items() if not np.isfinite(b)]
        if hidden:
            names, noun = ", ".join(hidden), f"{self.problem.noun}s"
            notes.append(f"No damage of {names} can be seen, or told from that of others, by these {noun}.")
        return notes

    @cached_property
    def separating_test(self) -> str:
        """Which further sensor, or place of the force, would tell apart the damages that a test against a
        baseline leaves, as :func:`plan_test` would; '' where one is left."""
        if self._assessment is None or self._question is None or self._assessment.interrupted:
            return ""
        said: str = self._view("separating_test")(self)
        return said

    def _of_the_values(self) -> list[str]:
        """The largest changes, where no candidate explains them; else what the damage found leaves."""
        found = self.assessment
        largest = largest_left(self.table)
        if not largest or (found.explained and found.best.candidate):
            return []
        if found.best.candidate:
            return [f"Left unexplained, in the values corrected by the baseline: {largest}."]
        by = "no element" if found.best.unknown else "no candidate"
        return [f"Largest changes against the intact structure, which {by} explains: {largest}."]

    def _of_the_penalties(self) -> list[str]:
        penalty = self.problem.penalty
        notes = [
            "Without a baseline every error of the model may come out as damage: give the values of the "
            "intact structure as a baseline."
        ]
        if seen := self._visible():
            why = f": the damage penalty ({penalty.text}) hides damage this small." if penalty else "."
            less = f"An element with less than its own limit counts as undamaged{why}"
            notes.append(f"Smallest damage that would be seen: {seen}. {less}")
        if penalty is not None and penalty.snap > 0:
            notes.append(f"Severities below {penalty.snap:g} were set to exactly 0.")
        return notes

    def _visible(self) -> str:
        """Where least and most damage is needed to be seen."""
        visible = sorted((b, e) for e, b in self.detectable.items() if np.isfinite(b))
        label = self.problem.model.element_label
        spans = [f"{figure(beta)} ({label(e)})" for beta, e in visible]
        return " to ".join(dict.fromkeys([spans[0], spans[-1]])) if spans else ""

    def summary(self) -> str:
        """What was found, frequencies and notes as text."""
        if self._assessment is None:
            return "\n".join([self.headline, "", super().summary()])
        head = [self.headline, "", str(self.hypotheses), "", str(self.table), ""]
        return "\n".join([*head, *(f"note: {note}" for note in self.notes)])

    def __repr__(self) -> str:
        if self._assessment is None:
            return super().__repr__()
        best = self.hypotheses[0]
        return f"{type(self).__name__}({self.hypotheses.called(best)}, probability {best.probability:.3f})"

    def plot(self, ax: Any = None, truth: Mapping[int, float] | None = None) -> Any:
        """Damage bar chart; see :func:`antires_rs.figures.plot_damage`."""
        return self._view("plot")(self, ax=ax, truth=truth)


# -- Without a baseline: is one factor on all stiffnesses more probable than the losses of many elements?
#
# A modulus or a unit that is wrong throughout comes out as a loss of nearly every element. Both are judged by
# the same likelihood and Laplace's approximation: the one factor with every loss equally probable, on the
# candidates or on all elements; the set of elements with the prior of their number.

#: Steps to the most probable factor, the largest of them, and one that ends them, in u.
_MOST_STEPS, _LONGEST_STEP, _RESTS = 10, 0.3, 1e-4
_RARER = 6.0  # sets beyond the three elements of the prior: so many times less probable for each element more


def common_loss(question: Question, losses: dict[int, float], threads: int) -> float:
    """The loss of all stiffnesses that is more probable than these of single ones and than none, else 0."""
    prior, numbers, k, n = question.prior, question.numbers, len(losses), len(question.elements)
    if k < max(2.0, n / 3.0):
        return 0.0
    likelihood = question.prepared(threads).likelihood
    u = np.zeros(likelihood.n)
    for element, loss in losses.items():
        u[numbers.index(element)] = -np.log1p(-min(loss, HIGHEST))
    each = np.eye(likelihood.n)[u > 0.0]
    share = (prior.nothing, prior.one, prior.two, prior.three)[min(k, 3)]
    of_set = np.log(share) - max(k - 3, 0) * np.log(_RARER) - np.log(comb(n, k))
    of_losses = _along(likelihood, each, u[u > 0.0])[1] + of_set
    start = np.array([np.median(u[u > 0.0])])
    families = [np.arange(likelihood.n) < n, np.ones(likelihood.n, dtype=bool)]
    found = [_along(likelihood, family[None].astype(np.float64), start) for family in families]
    at, of_factor = max(found, key=lambda one: one[1])
    of_nothing = likelihood.start.log_likelihood + np.log(prior.nothing)
    if of_factor + np.log(prior.unknown) <= max(of_losses, of_nothing):
        return 0.0
    return -float(np.expm1(-at[0]))


def _along(likelihood: Likelihood, ways: FloatArray, start: FloatArray) -> tuple[FloatArray, float]:
    """Most probable severities (u) along some ways (k, n), and the log evidence, at least, without bounds."""
    u, size = start, float(np.log(HIGHEST))
    best, most = start, -np.inf
    for _ in range(_MOST_STEPS):
        beta = -np.expm1(-u @ ways)
        view = likelihood.views(beta[None])[0]
        by_u = ways * (1.0 - beta)
        gain = by_u @ view.gain - 1.0
        matrix = by_u @ view.curvature @ by_u.T + BLIND * np.eye(u.size)
        step_by = np.linalg.solve(matrix, gain)
        volume = 0.5 * (u.size * np.log(2.0 * np.pi) - np.linalg.slogdet(matrix)[1])
        log_evidence = (
            view.log_likelihood + 0.5 * float(gain @ step_by) + float(volume) - u.size * size - u.sum()
        )
        if log_evidence > most:
            best, most = u, float(log_evidence)
        u = np.clip(u + np.clip(step_by, -_LONGEST_STEP, _LONGEST_STEP), 0.0, FURTHEST)
        if np.abs(step_by).max() < _RESTS:
            break
    return best, most


# -- The call


@one_blas_thread
def infer(
    question: Question, rng: np.random.Generator, threads: int
) -> tuple[Assessment, Prepared, ReductionReport | None]:
    """Judge all hypotheses; what was made on the way, and how reduced models served."""
    prepared = question.prepared(threads)
    search = Search(prepared.likelihood, len(question.elements), question.prior)
    search.run()
    source = prepared.likelihood.core
    reduction = confirmed(search, prepared.likelihood, source) if isinstance(source, ReducedRoots) else None
    identified = isinstance(prepared.responses, Responses)  # modes have no shapes beside elements
    if question.baseline and identified and not question.reduced and not search.interrupted:
        try:
            find_shapes(search, prepared, question)
        except KeyboardInterrupt:
            search.interrupted = True
    learned = learned_from(prepared, question, rng)
    found = concluded(search, question, learned, prepared.intact)
    return replace(found, unfit=unfit(question.baseline, question.measured)), prepared, reduction


def assess_damage(
    model: StructuralModel,
    measured: Measured,
    *,
    baseline: Measured | None = None,
    elements: Any = None,
    prior: DamagePrior | None = None,
    search: SearchOptions | None = None,
    environment: Sequence[str] | None = None,
    optimizer: IslandGA | None = None,
    rng: int | np.random.Generator | None = None,
    workers: int | None = None,
    callback: Callable[[dict[str, Any]], bool | None] | None = None,
    progress: bool | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    **older: Any,
) -> DamageResult:
    """Locate and size damage: the stiffness loss of each element that explains the measurement.

    With a baseline, the way to go, changes of the measured values are set against changes of the model, whose
    own errors are learned from the baseline. Without one, the paper's search, in which every error of the
    model may come out as damage.

    Parameters
    ----------
    model : MassSpringChain, FrameModel or MatrixModel
        The undamaged structure. With a baseline it need not be updated; without, it must be.
    measured : AntiresonanceSet, ModalSet, or several of one kind
        The structure as it is now: antiresonances, one set for each position of the force (or several, from
        repeated tests); or resonances with their shapes, one set for each setup of sensors.
        See :class:`UpdatingProblem`.
    baseline : AntiresonanceSet, ModalSet, or several of one kind, optional
        The intact structure, identified with the same sensors and forces. Standard deviations of both count.
    elements : sequence of int or str, optional
        Candidate elements, zero-based, or names of terms. Default: all springs between masses, all beams, all
        stiffness terms.
    prior : DamagePrior, optional
        What is believed before the test; with a baseline.
    search : SearchOptions, optional
        What few calls change.
    environment : sequence of {'temperature', 'supports', 'mass'}, optional
        What else may differ between the two tests, as :class:`SearchOptions` has it; with a baseline.
    optimizer, callback, checkpoint, rng, workers, progress
        As in :func:`update`; the first three without a baseline only. With one ``rng`` serves a rate of false
        alarms.
    **older
        Options of ``search`` by name, as until 0.1; with a warning.

    Returns
    -------
    DamageResult

    Raises
    ------
    InvalidInputError
        An element outside the model or listed twice, measured dofs outside the model, a baseline without the
        forces of ``measured``, options that have no effect with a baseline, or without one.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8(perturbation=0.05, rng=3)
    >>> result = ar.assess_damage(case.model, case.exact(level=1), baseline=case.exact(level=0))
    >>> result.damaged, round(result.severity[4], 2), result.probability[4] > 0.99
    ([4], 0.55, True)
    """
    checked_model(model)
    chosen = elements_of(model, elements)
    options = gathered("assess_damage", "search", SearchOptions, search, older)
    options = options.joined({"environment": environment})
    if baseline is None:
        options = options.of(ONE_STATE, prior=prior)
        how: Any = {"penalty": options.prices, "weights": options.weights}
        problem = UpdatingProblem(model, stiffness_reduction(chosen), measured, **how)
        found, seed, _ = find(problem, optimizer, rng, workers, callback, options.x0, progress, checkpoint)
        held = {"antires_rs": __version__, **options.held(ONE_STATE), **found.options}
        return DamageResult(problem, found, seed, options=held)
    options = options.of(TWO_STATES, optimizer=optimizer, callback=callback, checkpoint=checkpoint)
    before, now = sets_of("baseline", baseline), sets_of("measured", measured)
    if repeated(before, now):
        said = "baseline: has the values of measured, number for number, as no second test gives them. "
        warn("copied_setups", said + "Was one file given twice?")
    question = question_of(model, before, now, chosen, prior, options)
    if isinstance(now[0], AntiresonanceSet):
        warn_of_channels(model, before, now)
    seed = seed_of(rng)
    with waiting("assessing damage", progress):
        inferred = infer(question, np.random.default_rng(seed), thread_count(workers))
    return _result(question, *inferred, seed)


def _result(
    question: Question, found: Assessment, prepared: Prepared, reduction: ReductionReport | None, seed: int
) -> DamageResult:
    """The answer as a result: the model after the baseline, and the values as it would have them."""
    nfev, given = prepared.likelihood.nfev, prepared.n_given
    problem = UpdatingProblem(
        question.model.with_parameters(prepared.factors[:given], prepared.likelihood.factors[:given]),
        stiffness_reduction(question.elements),
        prepared.corrected(found.severities),
        penalty=DamagePenalty(0.0, 0.0, 0.0),
    )
    x = np.array([found.severities.get(e, 0.0) for e in question.elements])
    none, when = np.empty(0), " before Ctrl-C" if found.interrupted else ""
    search_result = OptimizeResult(
        x=x,
        fun=problem.cost(x),
        success=not found.interrupted,
        status="interrupted" if found.interrupted else "judged",
        message=f"{len(found.hypotheses)} hypotheses were judged{when}",
        nfev=nfev,
        njev=None,
        nit=0,
        history=History(none, np.empty((0, 1)), none),
        populations=np.empty((0, 0, x.size)),
        population_costs=np.empty((0, 0)),
    )
    held = {"antires_rs": __version__, "prior": vars(question.prior), **question.options.held(TWO_STATES)}
    return DamageResult(problem, search_result, seed, found, question, reduction, options=held)


# -- The damage of single tests in a fraction of a second: a plan made once, asked for every test


@dataclass(frozen=True, eq=False, repr=False)
class AssessedTest(Answered, ReadOnly):
    """Damage of one test, as an :class:`~antires_rs.Assessor` has it.

    Fields that a :class:`~antires_rs.DamageResult` has too mean the same.

    Attributes
    ----------
    full_run_wanted : bool
        Whether the answer may not hold, and :func:`~antires_rs.assess_damage` should be asked.
    reasons : tuple of str
        Why; empty where it holds.
    severity : dict of int to float
    assessment : Assessment
    labels : dict of int to str
        What the elements are called.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> before = case.exact(level=0)
    >>> ar.Assessor(case.model, baseline=before).assess(before).damaged
    []
    """

    full_run_wanted: bool
    reasons: tuple[str, ...]
    severity: Mapping[int, float]
    assessment: Assessment
    labels: Mapping[int, str]

    @property
    def detectable(self) -> dict[int, float]:
        """Severity of each candidate that nine of ten tests would show which are as exact as the baseline."""
        return dict(zip(self.severity, self.assessment.detectable, strict=True))

    @property
    def headline(self) -> str:
        """Is there damage, where, how sure, how much: in a sentence or two."""
        lines = headline(self.assessment)
        if self.full_run_wanted:
            lines.append(f"A full run is wanted: {'; '.join(self.reasons)}.")
        return " ".join(lines)

    @property
    def notes(self) -> list[str]:
        """What a reader should know before trusting the numbers."""
        return reservations(self.assessment)

    def __repr__(self) -> str:
        best = self.hypotheses[0]
        wanted = ", full run wanted" if self.full_run_wanted else ""
        return f"AssessedTest({self.hypotheses.called(best)}, probability {best.probability:.3f}{wanted})"

    def __str__(self) -> str:
        return "\n".join([self.headline, "", str(self.hypotheses), *(f"note: {note}" for note in self.notes)])


# -- Whether the answer of the tables holds

#: Two hypotheses within this (log probability) may change places in a full run, which is also to look for
#: something else from this probability on.
_CLOSE, _UNKNOWN = 0.1, 0.1
_LOST, _USUALLY_LOST = 0.1, 2  # share of values without a root that is too much, and how many are usual
#: Severity beyond which the slopes say little; values so far outside of the baseline's band (ln f) are not
#: looked at; hypotheses of less than this probability are not listed.
_LARGE, _OUTSIDE, _LISTED = 0.97, 0.3, 1e-3


def doubts(search: QuickSearch, found: Assessment) -> list[str]:
    """Why a full run is wanted."""
    now, band, best = search.likelihood.now, search.likelihood.band, found.best
    likeliest = [one.probability for one in found.hypotheses if not one.unknown]
    close = len(likeliest) > 1 and likeliest[1] > likeliest[0] * np.exp(-_CLOSE)
    unknown = sum(one.probability for one in found.hypotheses if one.unknown)
    lost = found.n_values - found.n_matched
    outside = (now.log_f < band.low - _OUTSIDE) | (now.log_f > band.high + _OUTSIDE)
    many = lost > max(_USUALLY_LOST, _LOST * now.size)
    reasons = {
        "more hypotheses are likely than were judged": search.cut,
        "two hypotheses are about equally probable": close and not search.cut,
        "something else than damage of the elements may have changed": unknown > _UNKNOWN,
        "what was found does not explain all values": not search.finished,
        f"{lost} of {now.size} values have no antiresonance of the model": many,
        f"a loss above {100 * _LARGE:.0f} %": max(best.severities, default=0.0) > _LARGE,
        "more than two damaged elements, of which a full run judges more sets": len(best.elements) > 2,
        "values are far outside of the band of the baseline": outside.any(),
    }
    return [reason for reason, holds in reasons.items() if holds]


class Assessor(ReadOnly, Viewed):
    """Assess the damage of single tests against a baseline, each in some tens of milliseconds.

    What does not depend on the test is done once: the model's errors are learned from the baseline, its
    antiresonances and their sensitivities computed over the severity of each element. A test is then searched
    in these tables, and what may be the answer is judged by the likelihood of :func:`assess_damage`, its
    antiresonances computed; :class:`AssessedTest` says where that may not be enough.

    Parameters
    ----------
    baseline : AntiresonanceSet, or several
        The intact structure, with the sensors and forces of the tests to come.
    model, elements, prior, search, rng, workers, progress, **older
        As for :func:`assess_damage` with a baseline; a rate of false alarms is that of tests as exact as the
        baseline.

    Raises
    ------
    InvalidInputError
        An element outside the model, a baseline without antiresonances near the model's, tables of more than
        2 GB, or a malformed argument.

    Notes
    -----
    The tables take 8 bytes times levels (15), elements squared, and antiresonances: seconds and tens of MB
    for 50 elements, and five times that with the cracks of a frame. :meth:`assess` is safe in several threads
    and processes; BLAS should have one thread (``OPENBLAS_NUM_THREADS=1``), since more of them make small
    matrices slower.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8()
    >>> assessor = ar.Assessor(case.model, baseline=case.exact(level=0))
    >>> found = assessor.assess(case.exact(level=1))
    >>> found.damaged, round(found.severity[4], 2)
    ([4], 0.55)
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
        before = sets_of("baseline", baseline, modes=False)
        chosen = elements_of(model, elements)
        options = gathered("Assessor", "search", SearchOptions, search, older).of(TWO_STATES)
        # In place of a test of now: the first set of each force.
        first = {each.excitation: each for each in reversed(before)}
        question = question_of(model, before, tuple(reversed(first.values())), chosen, prior, options)
        self._fill(_plan=plan_of(question, np.random.default_rng(seed_of(rng)), thread_count(workers)))

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

    @patient("assessing a test")
    def assess(self, zeros: AntiresonanceSet | Sequence[AntiresonanceSet]) -> AssessedTest:
        """The damage of one test.

        Parameters
        ----------
        zeros : AntiresonanceSet, or one for each position of the force
            Identified as the baseline was. Responses that the baseline does not have are left out.

        Raises
        ------
        InvalidInputError
            No antiresonance, or a force that the baseline does not have.
        """
        sets = sets_of("zeros", zeros, modes=False)
        plan, question, learned = self._plan, self._plan.question, self._plan.learned
        values, notes, strange, assumed = read(sets, plan.expected, learned.scatter)
        search = QuickSearch(TabulatedLikelihood(plan, values), len(question.elements), question.prior)
        search.run()
        learned = replace(learned, assumed_std=learned.assumed_std or assumed)
        found = concluded(search, question, learned, plan.prepared.intact, notes=notes, least=_LISTED)
        found = replace(found, unfit=unfit(question.baseline, sets))
        reasons = tuple(dict.fromkeys([*strange, *doubts(search, found)]))
        severity = FrozenDict({e: found.severities.get(e, 0.0) for e in question.elements})
        return AssessedTest(bool(reasons), reasons, severity, found, FrozenDict(plan.names))

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write model, baseline and tables to an .npz file, whole or not at all; no pickle is in it."""
        saved: Path = self._view("save")(self, path)
        return saved

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
        made: Assessor = cls._view("load")(path)
        return made

    def __repr__(self) -> str:
        values = self._plan.learned.n_intact
        return f"Assessor({len(self.elements)} candidates, {values} antiresonances in the baseline)"
