"""Damage of one test in a fraction of a second: a plan made once, asked for every test."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..measured.antiresonance_set import AntiresonanceSet
from ..models.structural_model import StructuralModel
from ..optimize.island_ga import seed_of, thread_count
from ..support.options import gathered
from ..support.progress import patient
from ..support.values import FrozenDict, ReadOnly
from ..views import Viewed
from .assess import checked_model, checked_search, elements_of, question_of, sets_of
from .assessor_plan import Plan, QuickSearch, TabulatedLikelihood, plan_of, read
from .hypotheses import Answered, Assessment
from .inference import concluded
from .options import TWO_STATES, DamagePrior, SearchOptions
from .words import headline, reservations


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
    severity, interval, probability : dict of int to float, to (low, high), to float
        Stiffness loss of each candidate with its 90 % interval, 0 and (0, 0) where there is no damage; and
        the probability that it is damaged.
    assessment : Assessment
        Hypotheses, chi-square and what they rest on.
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
    interval: Mapping[int, tuple[float, float]]
    probability: Mapping[int, float]
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

#: Two hypotheses within this (log probability) may change places in a full run.
_CLOSE = 0.1
#: Probability of something else from which on the full run is to look for it.
_UNKNOWN = 0.1
#: Share of values without a root that is too much, and how many are usual.
_LOST, _USUALLY_LOST = 0.1, 2
#: Severity beyond which the slopes say little.
_LARGE = 0.97
#: Values so far outside of the baseline's band (ln f) are not looked at.
_OUTSIDE = 0.3
#: Hypotheses of less than this probability are not listed.
_LISTED = 1e-3


def doubts(search: QuickSearch, found: Assessment) -> list[str]:
    """Why a full run is wanted."""
    now, band, best = search.likelihood.now, search.likelihood.band, found.best
    likeliest = [one.probability for one in found.hypotheses if not one.unknown]
    close = len(likeliest) > 1 and likeliest[1] > likeliest[0] * np.exp(-_CLOSE)
    unknown = sum(one.probability for one in found.hypotheses if one.unknown)
    lost = found.n_values - found.n_matched
    outside = (now.log_f < band.low - _OUTSIDE) | (now.log_f > band.high + _OUTSIDE)
    reasons = {
        "more hypotheses are likely than were judged": search.cut,
        "two hypotheses are about equally probable": close and not search.cut,
        "something else than damage of the elements may have changed": unknown > _UNKNOWN,
        "what was found does not explain all values": not search.finished,
        f"{lost} of {now.size} values have no antiresonance of the model": (
            lost > max(_USUALLY_LOST, _LOST * now.size)
        ),
        f"a loss above {100 * _LARGE:.0f} %": max(best.severities, default=0.0) > _LARGE,
        "more than two damaged elements, of which a full run judges more sets": len(best.elements) > 2,
        "values are far outside of the band of the baseline": outside.any(),
    }
    return [reason for reason, holds in reasons.items() if holds]


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
    elements, prior, search
        As for :func:`assess_damage` with a baseline; a rate of false alarms is that of tests as exact as the
        baseline.
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
        options = gathered("Assessor", "search", checked_search(search), older).of(TWO_STATES)
        # In place of a test of now: the first set of each force.
        first = {each.excitation: each for each in reversed(before)}
        question = question_of(model, before, tuple(reversed(first.values())), chosen, prior, options)
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
        sets = sets_of("zeros", zeros, modes=False)
        plan, question, learned = self._plan, self._plan.question, self._plan.learned
        test = read(sets, plan.expected, learned.scatter)
        search = QuickSearch(TabulatedLikelihood(plan, test.values), len(question.elements), question.prior)
        search.run()
        learned = replace(learned, assumed_std=learned.assumed_std or test.assumed)
        found = concluded(
            search, question, learned, plan.states[1], measured=sets, notes=test.notes, least=_LISTED
        )
        reasons = tuple(dict.fromkeys([*test.strange, *doubts(search, found)]))
        elements = question.elements
        return AssessedTest(
            bool(reasons),
            reasons,
            FrozenDict({e: found.severities.get(e, 0.0) for e in elements}),
            FrozenDict({e: found.intervals.get(e, (0.0, 0.0)) for e in elements}),
            FrozenDict({e: min(found.marginal(e), 1.0) for e in elements}),
            found,
            FrozenDict(plan.names),
        )

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
