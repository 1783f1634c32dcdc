"""Damage assessment: which elements have lost stiffness, how much, and how sure that is."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core import __version__
from ..exceptions import part, reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..optimize.island_ga import History, IslandGA, OptimizeResult, seed_of, thread_count
from ..support.checks import FloatArray, integer, shape_of
from ..support.options import gathered
from ..support.progress import waiting
from ..updating.identifiability import smallest_visible
from ..updating.model_check import Explained, explained
from ..updating.problem import DamagePenalty, Measured, UpdatingProblem
from ..updating.reduced_search import ReductionReport
from ..updating.result import UpdateResult
from ..updating.update import search as find
from .hypotheses import Answered, Assessment, figure
from .inference import common_loss, infer
from .likelihood import Prepared, Question
from .options import ONE_STATE, TWO_STATES, DamagePrior, SearchOptions, checked_prior
from .severity_intervals import severity_intervals, severity_profile
from .words import all_lost, headline, headline_of_one_state, largest_left, note_of_reduction, reservations

if TYPE_CHECKING:
    from ..updating.posterior import Method, ParameterIntervals, ProfileLikelihood

# -- The model, the elements and the sets that a question about damage names


def checked_model(model: Any) -> StructuralModel:
    """A model of ours."""
    if not isinstance(model, StructuralModel):
        wanted = "a MassSpringChain, FrameModel or MatrixModel"
        reject("model", model, wanted, "Build the model as one of these first.")
    return model


def checked_search(search: Any) -> SearchOptions:
    """Options of a search."""
    if search is not None and not isinstance(search, SearchOptions):
        reject("search", search, "a SearchOptions", "As in search=SearchOptions(std_common=0.001).")
    return search or SearchOptions()


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
    return [integer(part("elements", i), e, low=0, high=terms - 1) for i, e in enumerate(chosen)]


def sets_of(name: str, given: Any, *, modes: bool = True) -> tuple[Any, ...]:
    """One or several measured sets of one kind."""
    kinds = (AntiresonanceSet, ModalSet) if modes else (AntiresonanceSet,)
    sets = (given,) if isinstance(given, kinds) else given
    own = {type(each) for each in sets} if isinstance(sets, Sequence) else set()
    if own not in [{kind} for kind in kinds]:
        if modes:
            wanted, remedy = (
                "an AntiresonanceSet or a ModalSet, or several of one kind",
                "both states in the same way.",
            )
        else:
            given, wanted = type(given).__name__, "an AntiresonanceSet, or several"
            remedy = "the antiresonances first: ar.identify_antiresonances(record, ...)."
        reject(name, given, wanted, f"Identify {remedy}")
    return tuple(sets)


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
    reduced = options.reduces(model.n_dof, modes)
    return Question(model, before, now, tuple(elements), believed, options, reduced=reduced)


# -- The result

#: Width of the 90 % interval of a Gaussian, in standard deviations.
_WIDTH_90 = 2.0 * 1.6448536269514722
#: Elements that a note calls by name.
_NAMED = 4
#: Relative scatter of stiffnesses and masses that probabilities without a baseline assume.
ASSUMED_MODEL_ERROR = 0.03


class DamageResult(Answered, UpdateResult):
    """Damage found: an :class:`UpdateResult` whose ``x`` holds the severities beta.

    Examples
    --------
    >>> import antires_rs as ar
    >>> damaged = ar.MassSpringChain([2.0, 1.0, 1.0], [500.0, 300.0])
    >>> measured = ar.AntiresonanceSet(0, dict(enumerate(damaged.antiresonances([0, 1, 2], 0))))
    >>> result = ar.assess_damage(ar.MassSpringChain([2.0, 1.0, 1.0], [500.0, 500.0]), measured, rng=0)
    >>> result.damaged, round(result.severity[1], 3), round(result.detectable[1], 2)
    ([1], 0.4, 0.01)
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

        With a baseline: that of a Gaussian with the 90 % interval, errors of the model considered. Without
        one: of the values' errors alone, to first order.
        """
        if self._assessment is None:
            return super().std
        width = np.array([high - low for low, high in self.interval.values()])
        return np.where(width > 0.0, width / _WIDTH_90, np.nan)

    @property
    def probability(self) -> dict[int, float]:
        """Probability that each candidate is damaged, summed over all hypotheses."""
        return {e: self.assessment.marginal(e) for e in self.elements}

    @property
    def headline(self) -> str:
        """Is there damage, where, how sure, how much: in a sentence or two.

        Without a baseline that of the search, as :attr:`severity`, and what it rests on; :attr:`hypotheses`
        allow for errors of the model and may come to another answer.
        """
        return " ".join(self._headline())

    def _headline(self) -> list[str]:
        label = self.problem.model.element_label
        if self._assessment is not None:
            return headline(self._assessment)
        finished, count = self.search.status != "interrupted", len(self.elements)
        return headline_of_one_state(self._losses, label, self._fit, count, finished=finished)

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
        return replace(found, common_loss=common)

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

        With a baseline: what nine of ten such tests would show, with the errors of the values and those that
        the baseline leaves to the model. Without one: below it the penalties cost more than the damage
        explains, on exact data, so that an undamaged structure is the better answer to the objective.
        """
        return dict(zip(self.elements, self._detectable, strict=True))

    @cached_property
    def _detectable(self) -> tuple[float, ...]:
        return self._assessment.detectable if self._assessment else tuple(smallest_visible(self.problem))

    @property
    def interval(self) -> dict[int, tuple[float, float]]:
        """90 % interval of each severity, given the elements declared damaged; (0, 0) of the others."""
        limits = self.assessment.intervals
        return {e: limits.get(e, (0.0, 0.0)) for e in self.elements}

    def intervals(
        self,
        method: Method = "laplace",
        *,
        level: float = 0.9,
        draws: int = 1000,
        rng: int | np.random.Generator | None = 0,
        workers: int | None = None,
        progress: bool | None = None,
    ) -> ParameterIntervals:
        """Intervals of the severities, given the elements declared damaged, with draws of their posterior.

        With a baseline a :class:`SeverityIntervals`, errors of the model considered. Without one as
        :meth:`UpdateResult.intervals`, from the errors of the values and what the residuals tell.

        Parameters
        ----------
        method : {'laplace', 'ensemble'}
            Quick, with ln f linear in ln(1 - severity) around the most probable severities, as
            :attr:`interval`; or sure, with the model's antiresonances at every draw, values and
            antiresonances associated anew there. The sure one estimates also how probable the hypotheses are,
            without these approximations: some hundred evaluations of the model for the likeliest.
        level : float
            Probability of each interval, within [0.5, 0.999].
        draws : int
            At least 50.
        rng, workers, progress
            As in :func:`assess_damage`; the same seed gives the same bits for any number of ``workers``.

        Raises
        ------
        InvalidInputError
            A method, level or number out of range; a result of an older file, which lacks the values of the
            baseline.

        Examples
        --------
        >>> import antires_rs as ar
        >>> case = ar.cases.chain8()
        >>> result = ar.assess_damage(case.model, case.exact(level=1), baseline=case.exact(level=0))
        >>> sure = result.intervals("ensemble", draws=200)
        >>> low, high = sure[4]
        >>> bool(low < 0.55 < high), bool(sure.sets[0].confirmed > 0.99), sure.draws.shape
        (True, True, (200, 7))
        """
        if self._assessment is None:
            return super().intervals(
                method, level=level, draws=draws, rng=rng, workers=workers, progress=progress
            )
        asked = self._asked(), self._assessment, self.problem.names
        return severity_intervals(
            *asked, method=method, level=level, draws=draws, rng=rng, workers=workers, progress=progress
        )

    def profile(
        self, name: str, *, level: float = 0.9, points: int = 21, progress: bool | None = None
    ) -> ProfileLikelihood:
        """Profile likelihood of one severity, the others of the set declared damaged fitted at every value.

        With a baseline the likelihood is that of the assessment, errors of the model in it. A name that is
        unknown, or of an element that is not declared damaged, is an ``InvalidInputError``.
        """
        if self._assessment is None:
            return super().profile(name, level=level, points=points, progress=progress)
        asked = self._asked(), self._assessment, self.problem.names
        return severity_profile(*asked, name, level=level, points=points, progress=progress)

    def _asked(self) -> Question:
        """Both states, as they were assessed."""
        if self._question is None:
            reject(
                "result",
                "one without the values of the baseline, of an older file",
                "one that assess_damage has made, or a file of one",
                "Assess the damage again; .interval has its 90 % intervals.",
            )
        return self._question

    def _values(self) -> list[str]:
        """The damaged elements, the worst first; the others are exactly 0 and take one line."""
        names = dict(zip(self.elements, self.problem.names, strict=True))
        width = max(len(name) for name in names.values())
        std = dict(zip(self.elements, 100 * self.std, strict=True))
        lines = [
            f"{names[e]:<{width}}  {100 * self.severity[e]:6.2f} % \u00b1 {std[e]:.2g} %"
            for e in self.damaged
        ]
        others = len(names) - len(lines)
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
                notes.append(note_of_reduction(self.reduction))
            notes += self._of_the_values()
            if self._visible():
                notes.append(f"Smallest damage that nine of ten such tests would show: {self._visible()}.")
        others = [label(e) for e in self.problem.model._springs if e not in self.severity]
        if others:
            named = ", ".join(others[:_NAMED])
            named += f" and {len(others) - _NAMED} more" if len(others) > _NAMED else ""
            blamed = "would be blamed on others" if self._assessment is None else "counts as elsewhere"
            notes.append(f"No candidates: {named}. Damage there {blamed}.")
        hidden = [label(e) for e, b in self.detectable.items() if not np.isfinite(b)]
        if hidden:
            notes.append(f"No damage of {', '.join(hidden)} can be seen from these {self.problem.noun}s.")
        return notes

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
            "intact structure as baseline=, or see .probability."
        ]
        if self._visible():
            notes.append(
                f"Smallest damage that would be seen: {self._visible()}. An element with less than its own "
                "limit counts as undamaged"
                + (f": {penalty.text} outweigh what its damage explains." if penalty else ".")
            )
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


# -- The call


def assess_damage(
    model: StructuralModel,
    measured: Measured,
    *,
    baseline: Measured | None = None,
    elements: Any = None,
    prior: DamagePrior | None = None,
    search: SearchOptions | None = None,
    optimizer: IslandGA | None = None,
    rng: int | np.random.Generator | None = None,
    workers: int | None = None,
    callback: Callable[[dict[str, Any]], bool | None] | None = None,
    progress: bool | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    **older: Any,
) -> DamageResult:
    """Locate and size damage: the stiffness loss of each element that explains the measurement.

    With a baseline, the way to go, changes of the measured values are set against changes of the model,
    whose own errors are learned from the baseline; the answer is the most probable set of damaged elements,
    with its probability. Without one, the paper's search, in which every error of the model may come out as
    damage.

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
    elements : sequence of int, optional
        Candidate elements, zero-based. Default: all springs between masses, all beams,
        all stiffness terms.
    prior : DamagePrior, optional
        What is believed before the test; with a baseline.
    search : SearchOptions, optional
        What few calls change: the rate of false alarms and reduced models with a baseline, the penalties
        without one.
    optimizer, callback, checkpoint
        Of the search without a baseline, as in :func:`update`.
    rng, workers, progress
        As in :func:`update`. With a baseline ``rng`` serves a rate of false alarms only.
    **older
        Options of ``search`` by name, as until 0.1; with a warning.

    Returns
    -------
    DamageResult
        ``.headline``, ``.hypotheses``, ``.probability`` {element: p}, ``.severity`` {element: beta},
        ``.interval``, ``.detectable`` {element: smallest visible beta}.

    Raises
    ------
    InvalidInputError
        An element outside the model or listed twice, measured dofs outside the model, a baseline without the
        forces of ``measured``, options of the search together with a baseline or those of a baseline without
        one.

    Examples
    --------
    >>> import antires_rs as ar
    >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [510.0, 495.0, 500.0])
    >>> damaged = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [510.0, 297.0, 500.0])
    >>> before, now = (ar.AntiresonanceSet(0, dict(enumerate(m.antiresonances([0, 1, 2, 3], 0))))
    ...                for m in (intact, damaged))
    >>> model = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 500.0, 500.0])
    >>> result = ar.assess_damage(model, now, baseline=before)
    >>> {element: round(beta, 2) for element, beta in result.severity.items()}, result.probability[1] > 0.99
    ({0: 0.0, 1: 0.4, 2: 0.0}, True)

    The paper's way:

    >>> result = ar.assess_damage(intact, now, rng=0)
    >>> {element: round(beta, 2) for element, beta in result.severity.items()}
    {0: 0.0, 1: 0.4, 2: 0.0}
    """
    checked_model(model)
    chosen = elements_of(model, elements)
    options = gathered("assess_damage", "search", checked_search(search), older)
    if baseline is None:
        _without({"prior": prior}, "together with a baseline")
        options = options.of(ONE_STATE)
        problem = UpdatingProblem(
            model, stiffness_reduction(chosen), measured, penalty=options.prices, weights=options.weights
        )
        found, seed, _ = find(problem, optimizer, rng, workers, callback, options.x0, progress, checkpoint)
        held = {"antires_rs": __version__, **options.held(ONE_STATE), **found.options}
        return DamageResult(problem, found, seed, options=held)
    options = options.of(TWO_STATES)
    _without({"optimizer": optimizer, "callback": callback, "checkpoint": checkpoint}, ONE_STATE)
    before, now = sets_of("baseline", baseline), sets_of("measured", measured)
    question = question_of(model, before, now, chosen, prior, options)
    seed = seed_of(rng)
    with waiting("assessing damage", progress):
        inferred = infer(question, np.random.default_rng(seed), thread_count(workers))
    return _result(question, *inferred, seed)


def _result(
    question: Question, found: Assessment, prepared: Prepared, reduction: ReductionReport | None, seed: int
) -> DamageResult:
    """The answer as a result: the model after the baseline, and the values as it would have them."""
    nfev = prepared.likelihood.nfev
    problem = UpdatingProblem(
        question.model.with_parameters(prepared.factors, prepared.likelihood.factors),
        stiffness_reduction(question.elements),
        prepared.corrected(found.severities),
        penalty=DamagePenalty(0.0, 0.0, 0.0),
    )
    x = np.array([found.severities.get(e, 0.0) for e in question.elements])
    none = np.empty(0)
    search_result = OptimizeResult(
        x=x,
        fun=problem.cost(x),
        success=not found.interrupted,
        status="interrupted" if found.interrupted else "judged",
        message=f"{len(found.hypotheses)} hypotheses were judged"
        + (" before Ctrl-C" if found.interrupted else ""),
        nfev=nfev,
        njev=None,
        nit=0,
        history=History(none, np.empty((0, 1)), none),
        populations=np.empty((0, 0, x.size)),
        population_costs=np.empty((0, 0)),
    )
    held = {"antires_rs": __version__, "prior": vars(question.prior), **question.options.held(TWO_STATES)}
    return DamageResult(problem, search_result, seed, found, question, reduction, options=held)


def _without(options: dict[str, Any], when: str) -> None:
    """Options that have no effect are refused, not ignored."""
    for name, value in options.items():
        if value is not None:
            reject(name, value, f"None: it counts only {when}", f"Leave {name} out.")
