"""The search on reduced models: a basis where the search stands, a search on it, its answer on the full one.

The first basis is that of the middle of the box, and the first search the optimizer's own. Those after it are
descents within a trust region around where the last one ended, on a basis made there whose frequencies are
brought to those of the full model at that place (Alexandrov & Lewis, Optim. Eng. 2 (2001) 413-430, correct
so in a first order; here the slopes are the basis' own). They end when full and reduced model agree at the
answer. Unless that answer explains everything, others begin elsewhere until two agree.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import reject
from ..optimize.island_ga import IslandGA, OptimizeResult
from ..support.checks import FloatArray, finite_scalar, integer
from ..support.progress import one_blas_thread
from .reduced_model import Affine, ReducedProblem, basis_at, bent_by, largest_difference
from .targets import AntiresonanceTargets

if TYPE_CHECKING:
    from .problem import UpdatingProblem


#: More dofs than these are reduced unless told otherwise.
_LARGE = 2000
#: More parameters than these are not: their effect takes too many vectors.
_MOST_PARAMETERS = 60


@dataclass(frozen=True)
class Reduction:
    """How a model is reduced while its parameters are sought.

    The model is projected on modes, on the first Krylov vectors of force and sensors, and on what parameters
    make of these to first order. The search goes on with a basis made where it arrived, its frequencies
    corrected by those of the full model there, until both agree.

    Parameters
    ----------
    size : int, default 160
        Most vectors; at least as many as modes (to 1.5 times the highest measured frequency), forces and
        sensors.
    least : float, default 0.05
        A direction that parameters move the basis by less than this, relatively, over half of their ranges,
        is left out. Smaller is larger, slower and better.
    tolerance : float, default 1e-6
        Largest relative difference, at the answer, of a frequency of the reduced model from the full one's.
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
    rounds, full_evaluations : int
        Bases made, and evaluations of the full model.
    estimate, difference : float
        Largest relative error of a frequency of the reduced model at the answer: as expected of the last one,
        uncorrected; and as it was, corrected at the place before.
    agreed : bool
        Whether it is within the tolerance.

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
    if not isinstance(problem._targets, AntiresonanceTargets):
        unfit: str | None = "modes were measured"
    else:
        unfit = bent_by(problem.parameters) if checkpoint is None else "a checkpoint is asked for"
    if isinstance(given, str) and given == "auto":
        large = problem.model.n_dof > _LARGE and len(problem.parameters) <= _MOST_PARAMETERS
        return Reduction() if large and unfit is None else None
    if given is not True and not isinstance(given, Reduction):
        remedy = "Leave it out: large models are reduced where that is sound."
        reject("reduction", given, "'auto', True, False or a Reduction", remedy)
    if unfit is not None:
        reject("reduction", f"a reduced model, but {unfit}", "a problem that can be reduced", "Leave it out.")
    return Reduction() if given is True else given


#: Half-widths of the first trust region and the least, as shares of the bounds' distance.
_FIRST_TRUST, _LEAST_TRUST = 0.25, 1e-3
#: It is halved where the cost falls by less than the first part of what the reduced model promised, doubled
#: from the second on.
_POOR, _GOOD = 0.25, 0.75
#: Krylov vectors of a sensor in the first basis, and in those around a place.
_DEPTH, _DEPTH_THERE = 2, 3
#: The first basis has directions of this part of the least size: it serves the whole box.
_FINER = 0.4
#: Below this difference of full and reduced frequencies the basis stays, and is corrected, again where that
#: has left no more than the second part of it.
_CLOSE, _CORRECTS = 1e-4, 0.1
#: Largest share of the box that a basis around a place serves.
_WIDEST = 0.5
#: Modes are taken up to this multiple of the highest measured frequency, as the objective asks for roots.
_BAND = 1.5
#: Most searches from elsewhere, until two end within this part of the box.
_ATTEMPTS, _SAME = 4, 0.02
#: A mean residual of nothing but rounding; else a search looks around its answer within this part of the box,
#: and goes on from a cost lower than this part of what it was.
_EXACT, _AROUND, _BETTER = 1e-6, 0.2, 0.95
#: A cost above another by less than this factor is as good, where full and reduced model agree.
_EQUAL = 1.001
#: What ends a search at once.
_STOPPED = ("interrupted", "callback")
_INTERRUPTED = ("interrupted", "Interrupted by the user; this is the best found until then.")
_NO_TIME = ("budget", "The time limit was reached before searches on reduced models agreed.")

#: Of (objective, lower and upper bounds, where a polish begins, options; None for the optimizer's own).
Minimize = Callable[[Any, FloatArray, FloatArray, FloatArray, dict[str, Any] | None], OptimizeResult]


@one_blas_thread
def reduced_search(
    problem: UpdatingProblem,
    reduction: Reduction,
    minimize: Minimize,
    start: FloatArray,
    seed: int,
    seconds_left: Callable[[], float],
) -> tuple[OptimizeResult, ReductionReport]:
    """What the search found, its cost that of the full model, and how the reduced ones served.

    ``seconds_left`` ends it at zero, after the first answer. Ctrl-C hands back the best answer, once there is
    one.
    """
    search = _Search(problem, reduction, minimize, np.random.default_rng(seed), seconds_left)
    ended = None
    try:
        best = _agreed(search, start)
    except KeyboardInterrupt:
        if search.best is None:
            raise
        best, ended = search.best, _INTERRUPTED
    last = search.found[-1]
    if search.stopped and ended is None:
        ended = (last.status, last.message) if last.status in _STOPPED else _NO_TIME
    report = ReductionReport(
        n_dof=problem.model.n_dof,
        size=best.reduced.size,
        rounds=search.bases,
        estimate=best.reduced.estimate(best.x),
        difference=best.difference,
        agreed=best.difference <= reduction.tolerance,
        full_evaluations=len(search.found),
    )
    nfev, njev = (sum(getattr(each, name) or 0 for each in search.found) for name in ("nfev", "njev"))
    found = replace(search.found[0], x=best.x, fun=best.cost, nfev=nfev, njev=njev)
    if ended is not None:
        found = replace(found, status=ended[0], message=ended[1], success=False)
    return found, report


def _agreed(search: _Search, start: FloatArray) -> _Answer:
    """The answer from ``start``; unless it explains everything, the best of it and others until two agree."""
    best = search.run(start)
    low, high = search.problem.bounds.T
    for _ in range(_ATTEMPTS):
        if best.unexplained <= _EXACT or search.stopped:
            return best
        other = search.run(search.rng.uniform(low, high))
        agreed = bool(np.all(np.abs(other.x - best.x) <= _SAME * (high - low)))
        if other.cost < best.cost:
            best = other
        if agreed:
            break
    return best if best.unexplained <= _EXACT or search.stopped else search.look_around(best)


class _Answer:
    """A candidate on the full model, and the reduced one's cost there."""

    def __init__(
        self, problem: UpdatingProblem, reduced: ReducedProblem, x: FloatArray, promised: float
    ) -> None:
        self.x, self.reduced, self.promised = x, reduced, promised
        self.cost, self.full_hz = problem._core.cost_and_pairs(x)
        self.difference = largest_difference(reduced.paired_hz(x), self.full_hz)
        residuals = np.where(np.isnan(self.full_hz), 1.0, (self.full_hz / problem.measured_hz) ** 2 - 1.0)
        self.unexplained = float(np.abs(residuals).mean())


class _Search:
    """Searches from one point after the other."""

    def __init__(
        self,
        problem: UpdatingProblem,
        reduction: Reduction,
        minimize: Minimize,
        rng: np.random.Generator,
        seconds_left: Callable[[], float],
    ) -> None:
        self.problem, self.rng = problem, rng
        self.found: list[OptimizeResult] = []
        self.best: _Answer | None = None
        self.bases = 0
        self._reduction, self._minimize, self._seconds_left = reduction, minimize, seconds_left
        # The smallest search there is around a polish, and one that polishes a few points.
        self._descent = IslandGA(islands=1, population=4, max_generations=1).options
        self._look = IslandGA(islands=3, population=6, max_generations=8, polish_interval=3).options
        self._affine = Affine(problem)
        self._whole: ReducedProblem | None = None

    @property
    def stopped(self) -> bool:
        """Whether somebody stopped the search, or its time is over."""
        return self.found[-1].status in _STOPPED or self._seconds_left() <= 0.0

    def run(self, start: FloatArray) -> _Answer:
        """The answer that a search from ``start`` ends at."""
        if self._whole is None:  # for the whole box, around its middle, reductions at their nominal values
            problem, (low, high) = self.problem, self.problem.bounds.T
            reductions = np.array([p.quantity == "stiffness_reduction" for p in problem.parameters])
            middle = np.where(reductions, np.clip(problem.nominal, low, high), 0.5 * (low + high))
            self._whole = self._reduced(middle, 1.0, _DEPTH, _FINER)
        reduced = self._whole
        near = reduced.approached(start, self.rng)
        options = self._descent if self.found else None
        best = self._answer(reduced, self._around(near, 1.0), near, options)
        return self._settled(best)

    def look_around(self, best: _Answer) -> _Answer:
        """The better one where there is one near ``best``."""
        there = self._answer(best.reduced, self._around(best.x, _AROUND), best.x, self._look)
        return self._settled(there) if there.cost < _BETTER * best.cost else best

    def _settled(self, best: _Answer) -> _Answer:
        """Where descents from ``best`` end, full and reduced model in agreement."""
        trust, rounds, reduced, close = _FIRST_TRUST, 1, best.reduced, _CLOSE
        while trust >= _LEAST_TRUST and not self._agrees(best) and not self.stopped:
            if best.reduced is reduced:  # it has moved since the last basis or correction
                fresh = best.difference > close
                if fresh and rounds == self._reduction.rounds:
                    break
                reduced = self._reduced(best.x, min(_WIDEST, 2.0 * trust)) if fresh else reduced
                reduced = reduced.corrected(best.x, best.full_hz)
                rounds += fresh
                close = _CLOSE if fresh else _CORRECTS * best.difference
            there = self._answer(reduced, self._around(best.x, trust), best.x, self._descent)
            if there.cost > (_EQUAL if self._agrees(there) else 1.0) * best.cost:
                trust *= _POOR
                continue
            gain = (best.cost - there.cost) / max(best.cost - there.promised, np.finfo(float).tiny)
            trust *= 2.0 if gain > _GOOD else 0.5 if gain < _POOR else 1.0
            best = there
        return best

    def _agrees(self, found: _Answer) -> bool:
        """Whether a model corrected near it is the full one there."""
        return found.reduced.is_corrected and found.difference <= self._reduction.tolerance

    def _around(self, x: FloatArray, share: float) -> tuple[FloatArray, FloatArray]:
        """A part of the box."""
        low, high = self.problem.bounds.T
        reach = share * (high - low)
        return np.maximum(low, x - reach), np.minimum(high, x + reach)

    def _answer(
        self,
        reduced: ReducedProblem,
        box: tuple[FloatArray, FloatArray],
        near: FloatArray,
        options: dict[str, Any] | None,
    ) -> _Answer:
        self.found.append(self._minimize(reduced.core, *box, near, options))
        answer = _Answer(self.problem, reduced, self.found[-1].x, self.found[-1].fun)
        if self.best is None or answer.cost < self.best.cost:
            self.best = answer
        return answer

    def _reduced(
        self, x: FloatArray, share: float, depth: int = _DEPTH_THERE, finer: float = 1.0
    ) -> ReducedProblem:
        """For that share of the parameters' ranges around ``x``."""
        self.bases += 1
        problem, wanted = self.problem, self._reduction
        half_widths = 0.5 * share * (problem.bounds[:, 1] - problem.bounds[:, 0])
        limit_hz = _BAND * float(problem.measured_hz.max())
        largest = wanted.size, finer * wanted.least
        return ReducedProblem(self._affine, basis_at(self._affine, x, half_widths, limit_hz, depth, largest))
