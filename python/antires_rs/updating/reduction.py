"""Whether and how an updating searches on a reduced model, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..support.validation import finite_scalar, integer, reject
from .affine import bent_by
from .antiresonance_targets import AntiresonanceTargets

if TYPE_CHECKING:
    from .problem import UpdatingProblem

__all__ = ["Reduction", "ReductionReport", "wanted_reduction"]

#: More dofs than these are reduced unless told otherwise.
_LARGE = 2000
#: More parameters than these are not: their effect takes too many vectors.
_MOST_PARAMETERS = 60


@dataclass(frozen=True)
class Reduction:
    """How a model is reduced while its parameters are sought.

    The model is projected on modes, on the first Krylov vectors of force and sensors, and on what parameters
    make of these to first order. The reduced model has the same parameters and stands for the full one near
    a point; the search goes on with a basis made where it arrived, its frequencies corrected by those of the
    full model there, until both agree.

    Parameters
    ----------
    size : int, default 160
        Most vectors; at least as many as modes (to 1.5 times the highest measured frequency), forces and
        sensors.
    least : float, default 0.05
        A direction that parameters move the basis by less than this, relatively, over half of their ranges,
        is left out. Smaller is larger, slower and better.
    tolerance : float, default 1e-6
        Largest relative difference, at the answer, of a frequency of the reduced model from that of the full
        one.
    rounds : int, default 8
        Most bases.

    Raises
    ------
    InvalidInputError
        A value out of range.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.Reduction(size=100).tolerance
    1e-06
    """

    size: int = 160
    least: float = 0.05
    tolerance: float = 1e-6
    rounds: int = 8

    def __post_init__(self) -> None:
        integer("size", self.size, low=1)
        integer("rounds", self.rounds, low=1)
        finite_scalar("least", self.least, low=0.0)
        finite_scalar("tolerance", self.tolerance, low=0.0, low_open=True)


@dataclass(frozen=True)
class ReductionReport:
    """What a search on reduced models came to.

    Attributes
    ----------
    n_dof, size : int
        Dofs of the full model, and of the last reduced one.
    rounds : int
        Bases made.
    estimate : float
        Error that was to be expected of the last reduced model's frequencies at the answer, uncorrected,
        relative.
    difference : float
        The largest relative difference, at the answer, of a frequency of the reduced model, corrected at the
        place before, from that of the full model.
    agreed : bool
        Whether it is within the tolerance.
    full_evaluations : int
        Evaluations of the full model.

    Examples
    --------
    >>> import antires_rs as ar
    >>> chain = ar.MassSpringChain([1.0] * 60, [1e5] * 59, ground_first_n_per_m=1e5)
    >>> springs = ar.stiffness_factor(range(30), bounds=(0.8, 1.2), together=True)
    >>> tested = chain.with_parameters(springs, 1.1)
    >>> zeros = ar.AntiresonanceSet(59, {30: tested.antiresonances(30, 59, f_max_hz=10.0)})
    >>> found = ar.update(ar.UpdatingProblem(chain, springs, zeros), rng=0, reduction=True)
    >>> found.x.round(4), found.reduction.agreed, found.reduction.size < 30
    (array([1.1]), True, True)
    """

    n_dof: int
    size: int
    rounds: int
    estimate: float
    difference: float
    agreed: bool
    full_evaluations: int

    @property
    def note(self) -> str:
        """A sentence for the reader."""
        bases = "a basis" if self.rounds == 1 else f"{self.rounds} bases"
        head = f"Sought on a reduced model, {self.size} dofs for {self.n_dof}, by {bases}: at the answer "
        if self.agreed:
            return f"{head}its antiresonances are those of the full model to {self.difference:.0e}."
        return (
            f"{head}they still differ from the full model's by {self.difference:.0e}. The basis "
            "is too small; give reduction=Reduction(size=...) more vectors, or reduction=False."
        )


def wanted_reduction(problem: UpdatingProblem, given: Any, checkpoint: Any) -> Reduction | None:
    """The reduction to use; None for the full model."""
    if given is False or given is None:
        return None
    unfit = _unfit(problem, checkpoint)
    if isinstance(given, str) and given == "auto":
        large = problem.model.n_dof > _LARGE and len(problem.parameters) <= _MOST_PARAMETERS
        return Reduction() if large and unfit is None else None
    if given is not True and not isinstance(given, Reduction):
        reject(
            "reduction",
            given,
            "'auto', True, False or a Reduction",
            "Leave it out: large models are reduced where that is sound.",
        )
    if unfit is not None:
        reject("reduction", f"a reduced model, but {unfit}", "a problem that can be reduced", "Leave it out.")
    return Reduction() if given is True else given


def _unfit(problem: UpdatingProblem, checkpoint: Any) -> str | None:
    """Why the problem cannot be reduced."""
    if not isinstance(problem._targets, AntiresonanceTargets):
        return "modes were measured"
    if checkpoint is not None:
        return "a checkpoint is asked for"
    return bent_by(problem.parameters)
