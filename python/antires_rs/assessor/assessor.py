"""Damage of one test in a fraction of a second: a plan made once, asked for every test."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..damage.candidates import checked_model, checked_prior, elements_of
from ..damage.inference import STD_COMMON
from ..damage.prior import DamagePrior
from ..damage.question import Question
from ..damage.reduced_roots import wanted_reduced
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..optimize.arguments import seed_of, thread_count
from ..support.pickling import ReadOnly
from ..support.progress import patient
from ..support.validation import finite_scalar, reject
from ..updating.problem import UpdatingProblem
from .answer import AssessedTest
from .at_once import assess_at_once
from .plan import Plan, plan_of

__all__ = ["Assessor"]


class Assessor(ReadOnly):
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
    false_alarm_rate : float, optional
        Share of intact tests in which damage may be declared, in (0, 0.5], of tests as exact as the baseline.
    std_common : float, optional
        Standard deviation of what moves all values alike between two tests, relative, within [0, 0.1].
        Default 0.0005.
    rng : int or numpy.random.Generator, optional
        For ``false_alarm_rate``.
    workers : int, optional
        Threads that compute the tables; all processors by default. No bit depends on it.
    progress : bool, optional
        Show a line of progress; by default on a terminal.

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
        false_alarm_rate: float | None = None,
        std_common: float | None = None,
        rng: int | np.random.Generator | None = None,
        workers: int | None = None,
        progress: bool | None = None,
    ) -> None:
        checked_model(model)
        before = _sets("baseline", baseline)
        if not any(any(map(len, each.values())) for each in before):
            reject(
                "baseline", "no antiresonance", "those of the intact structure", "Identify in a wider band."
            )
        chosen = elements_of(model, elements)
        UpdatingProblem(model, stiffness_reduction(chosen), before)  # speaks up where they do not fit
        believed = checked_prior(prior, false_alarm_rate)
        common = (
            STD_COMMON if std_common is None else finite_scalar("std_common", std_common, low=0.0, high=0.1)
        )
        first = {each.excitation: each for each in reversed(before)}
        question = Question(
            model,
            before,
            tuple(reversed(first.values())),
            tuple(chosen),
            believed,
            common,
            reduced=wanted_reduced(model, before[0], "auto"),
        )
        generator = np.random.default_rng(seed_of(rng))
        self._fill(_plan=plan_of(question, false_alarm_rate, generator, thread_count(workers)))

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
        from ..io.assessors import save_assessor

        return save_assessor(self, path)

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
        from ..io.assessors import load_assessor

        return load_assessor(path)

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
