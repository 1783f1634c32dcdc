"""The result of a damage assessment: severities, hypotheses with probabilities, what they leave open."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from ..optimize.island_ga import thread_count
from ..support.checks import FloatArray
from ..updating.identifiability import smallest_visible
from ..updating.model_check import Explained, explained
from ..updating.result import UpdateResult
from .hypotheses import figure
from .inference import infer
from .one_state import all_lost, common_loss, headline_of_one_state, many
from .options import DamagePrior, SearchOptions
from .question import Question
from .severity_intervals import severity_intervals, severity_profile
from .words import headline, largest_left, note_of_reduction, reservations

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..optimize.island_ga import OptimizeResult
    from ..updating.posterior import Method, ParameterIntervals, ProfileLikelihood
    from ..updating.problem import UpdatingProblem
    from ..updating.reduced_search import ReductionReport
    from .hypotheses import Assessment, Hypotheses

#: Width of the 90 % interval of a Gaussian, in standard deviations.
_WIDTH_90 = 2.0 * 1.6448536269514722
#: Elements that a note calls by name.
_NAMED = 4
#: Relative scatter of stiffnesses and masses that probabilities without a baseline assume.
ASSUMED_MODEL_ERROR = 0.03


class DamageResult(UpdateResult):
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
        rng = np.random.default_rng(self.seed)
        return infer(self._alone, rng=rng, threads=thread_count(None)).assessment

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
    def hypotheses(self) -> Hypotheses:
        """All explanations that were judged, the most probable first; prints as a table."""
        return self.assessment.hypotheses

    @property
    def probability(self) -> dict[int, float]:
        """Probability that each candidate is damaged, summed over all hypotheses."""
        return {e: self.assessment.marginal(e) for e in self.elements}

    @property
    def probability_of_damage(self) -> float:
        """Probability that anything has changed, be it what none of the candidates explains."""
        return 1.0 - self.assessment.probability_of_nothing

    @property
    def probability_elsewhere(self) -> float:
        """Probability that something has changed which none of the candidates explains."""
        return self.assessment.probability_elsewhere

    @property
    def chi_square(self) -> float:
        """Chi-square of the most probable hypothesis, over its degrees of freedom."""
        return self.assessment.chi_square

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
            return headline(self._assessment, label)
        losses = {e: self.severity[e] for e in self.damaged}
        return headline_of_one_state(
            losses, label, self._fit, len(self.elements), finished=self.search.status != "interrupted"
        )

    @cached_property
    def _fit(self) -> Explained | None:
        """What the model with the damage found explains, without a baseline."""
        if self._assessment is not None or self.search.status == "interrupted":
            return None
        losses, n = {e: self.severity[e] for e in self.damaged}, len(self.elements)
        common = common_loss(self._alone, losses, thread_count(None)) if many(len(losses), n) else 0.0
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
        rng : int or numpy.random.Generator, optional
            The same seed gives the same bits for any number of ``workers``.
        workers : int, optional
            Threads; all processors by default.
        progress : bool, optional
            Show progress on standard error; by default on a terminal, after one second.

        Raises
        ------
        InvalidInputError
            A method, level or number out of range; a result of an older file, which lacks the values of the
            baseline.

        Examples
        --------
        >>> import antires_rs as ar
        >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [510.0, 495.0, 500.0])
        >>> damaged = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [510.0, 297.0, 500.0])
        >>> before, now = (ar.AntiresonanceSet(0, dict(enumerate(m.antiresonances([0, 1, 2, 3], 0))))
        ...                for m in (intact, damaged))
        >>> model = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 500.0, 500.0])
        >>> sure = ar.assess_damage(model, now, baseline=before).intervals("ensemble", draws=200)
        >>> low, high = sure[1]
        >>> bool(low < 0.4 < high), bool(sure.sets[0].confirmed > 0.99), sure.draws.shape
        (True, True, (200, 3))
        """
        if self._assessment is None:
            return super().intervals(
                method, level=level, draws=draws, rng=rng, workers=workers, progress=progress
            )
        return severity_intervals(
            self._asked(),
            self._assessment,
            self.problem.names,
            method=method,
            level=level,
            draws=draws,
            rng=rng,
            workers=workers,
            progress=progress,
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
        return severity_profile(
            self._asked(),
            self._assessment,
            self.problem.names,
            name,
            level=level,
            points=points,
            progress=progress,
        )

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

    @cached_property
    def _detectable(self) -> tuple[float, ...]:
        if self._assessment is not None:
            return self._assessment.detectable
        return tuple(smallest_visible(self.problem))

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
    def damaged(self) -> list[int]:
        """Elements with damage, the worst first."""
        return sorted((e for e, beta in self.severity.items() if beta > 0), key=lambda e: -self.severity[e])

    @property
    def notes(self) -> list[str]:
        """What a reader should know before trusting the numbers."""
        label = self.problem.model.element_label
        if self._assessment is None:
            notes = [*super().notes, *self._of_the_penalties()]
        else:
            notes = [] if self.success else [f"The search did not finish: {self.message}"]
            notes += reservations(self._assessment, label)
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
