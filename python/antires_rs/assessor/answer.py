"""What an :class:`Assessor` says of one test."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..damage.assessment import Assessment
from ..damage.hypotheses import Hypotheses
from ..damage.reservations import reservations
from ..damage.words import headline
from ..support.pickling import ReadOnly

__all__ = ["AssessedTest"]


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
