"""The search on reduced models: a basis where the search stands, a search on it, its answer on the full one.

The first search is the optimizer's own, over the whole box; those after it are descents within a trust
region around where the last one ended, on a basis made there. They end when full and reduced model agree at
the answer. Unless that answer explains everything, others begin elsewhere until two agree.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..optimize.island_ga import IslandGA
from ..optimize.outcome import OptimizeResult
from ..support.one_thread import one_blas_thread
from ..support.validation import FloatArray
from .affine import Affine
from .reduced_basis import basis_at
from .reduced_model import ReducedProblem, largest_difference
from .reduction import Reduction, ReductionReport

if TYPE_CHECKING:
    from .problem import UpdatingProblem

__all__ = ["reduced_search"]

#: Half-widths of the first trust region and the least, as shares of the bounds' distance.
_FIRST_TRUST, _LEAST_TRUST = 0.25, 1e-3
#: Krylov vectors of a sensor in the first basis: each later one has one more.
_DEPTH = 2
#: Modes are taken up to this multiple of the highest measured frequency, as the objective asks for roots.
_BAND = 1.5
#: Most searches from elsewhere, until two end within this part of the box.
_ATTEMPTS, _SAME = 4, 0.02
#: A mean residual of nothing but rounding; else a search looks around its answer within this part of the box,
#: and goes on from a cost lower than this part of what it was.
_EXACT, _AROUND, _BETTER = 1e-6, 0.2, 0.95
#: What ends a search at once.
_STOPPED = ("interrupted", "callback")
_INTERRUPTED = {
    "status": "interrupted",
    "message": "Interrupted by the user; this is the best found until then.",
}
_NO_TIME = {
    "status": "budget",
    "message": "The time limit was reached before searches on reduced models agreed.",
}

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
    ended: dict[str, Any] = {}
    try:
        best = _agreed(search, start)
    except KeyboardInterrupt:
        if search.best is None:
            raise
        best, ended = search.best, _INTERRUPTED
    if search.stopped and not ended:
        last = search.found[-1]
        ended = {"status": last.status, "message": last.message} if last.status in _STOPPED else _NO_TIME
    report = ReductionReport(
        n_dof=problem.model.n_dof,
        size=best.reduced.size,
        rounds=search.bases,
        estimate=best.reduced.estimate(best.x),
        difference=best.difference,
        agreed=best.difference <= reduction.tolerance,
        full_evaluations=2 * search.bases,
    )
    first = search.found[0]
    nfev, njev = (sum(getattr(each, name) or 0 for each in search.found) for name in ("nfev", "njev"))
    if ended:
        ended = {**ended, "success": False}
    return replace(first, x=best.x, fun=best.cost, nfev=nfev, njev=njev, **ended), report


def _agreed(search: _Search, start: FloatArray) -> _Answer:
    """The answer from ``start``; unless it explains everything, the best of it and others until two agree."""
    best = search.run(start)
    low, high = search.problem.bounds.T
    for _ in range(_ATTEMPTS):
        if best.unexplained <= _EXACT or search.stopped:
            break
        other = search.run(search.rng.uniform(low, high))
        agreed = bool(np.all(np.abs(other.x - best.x) <= _SAME * (high - low)))
        if other.cost < best.cost:
            best = other
        if agreed:
            break
    return best


class _Answer:
    """A candidate on the full model."""

    def __init__(self, problem: UpdatingProblem, reduced: ReducedProblem, x: FloatArray) -> None:
        self.x, self.reduced = x, reduced
        self.cost = problem.cost(x)
        pairs = problem._core.pairs(x)[0]
        self.difference = largest_difference(reduced.core.pairs(x)[0], pairs)
        residuals = np.where(np.isnan(pairs), 1.0, (pairs / problem.measured_hz) ** 2 - 1.0)
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

    @property
    def stopped(self) -> bool:
        """Whether somebody stopped the search, or its time is over."""
        return self.found[-1].status in _STOPPED or self._seconds_left() <= 0.0

    def run(self, start: FloatArray) -> _Answer:
        """The answer that a search from ``start`` ends at."""
        low, high = self.problem.bounds.T
        reduced = self._reduced(start, 1.0, _DEPTH)
        near = reduced.approached(start, self.rng)
        best = self._answer(reduced, (low, high), near, self._descent if self.found else None)
        trust, rounds, looked = _FIRST_TRUST, 1, False
        while rounds < self._reduction.rounds and trust >= _LEAST_TRUST and not self.stopped:
            if best.difference <= self._reduction.tolerance:
                if looked or best.unexplained <= _EXACT:
                    break
                # Once: is there a better place around this one?
                there, looked = (
                    self._answer(best.reduced, self._around(best.x, _AROUND), best.x, self._look),
                    True,
                )
                if there.cost < _BETTER * best.cost:
                    best = there
                continue
            reduced = self._reduced(best.x, 2.0 * trust, _DEPTH + rounds)
            there = self._answer(reduced, self._around(best.x, trust), best.x, self._descent)
            rounds += 1
            if there.cost > best.cost and there.difference > self._reduction.tolerance:
                trust *= 0.25
                continue
            # Where the basis does not gain by its new place, its box is too large for it.
            trust *= 1.0 if there.difference < 0.1 * best.difference else 0.5
            best = there
        return best

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
        answer = _Answer(self.problem, reduced, self.found[-1].x)
        if self.best is None or answer.cost < self.best.cost:
            self.best = answer
        return answer

    def _reduced(self, x: FloatArray, share: float, depth: int) -> ReducedProblem:
        """For that share of the parameters' ranges around ``x``."""
        self.bases += 1
        problem, wanted = self.problem, self._reduction
        half_widths = 0.5 * share * (problem.bounds[:, 1] - problem.bounds[:, 0])
        limit_hz = _BAND * float(problem.measured_hz.max())
        largest = wanted.size, wanted.least
        basis = basis_at(self._affine, x, half_widths, limit_hz, depth, largest)
        return ReducedProblem(self._affine, basis)
