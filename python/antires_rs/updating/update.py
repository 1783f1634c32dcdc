"""Run the search of an updating problem."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from ..exceptions import NumericalError, reject
from ..optimize.island_ga import IslandGA, OptimizeResult, guesses, resumed, thread_count
from ..support.checks import FloatArray
from ..support.progress import watched
from .problem import UpdatingProblem, fingerprint
from .reduced_search import Reduction, ReductionReport, reduced_search, wanted_reduction
from .result import UpdateResult


def update(
    problem: UpdatingProblem,
    *,
    optimizer: IslandGA | None = None,
    rng: int | np.random.Generator | None = None,
    workers: int | None = None,
    callback: Callable[[dict[str, Any]], bool | None] | None = None,
    x0: Any = None,
    progress: bool | None = None,
    checkpoint: str | os.PathLike[str] | None = None,
    reduction: Literal["auto"] | bool | Reduction = "auto",
) -> UpdateResult:
    """Find the parameters that bring the model's antiresonances, or modes, to the measured ones.

    Parameters
    ----------
    problem : UpdatingProblem
    optimizer : IslandGA, optional
        Settings of the search.
    rng, callback, x0, progress, checkpoint
        As of :meth:`IslandGA.minimize`.
    workers : int, optional
        Threads; all processors by default. The bits are the same for any number.
    reduction : {'auto', True, False} or Reduction, optional
        Whether to search on a reduced model, which is made anew where the search arrives until it agrees
        there with the full one; all that the result tells is of the full model. 'auto' does so above 2,000
        dofs, where antiresonances were measured, the parameters (60 at most) scale terms, and no checkpoint
        is kept. See :class:`Reduction`, and ``reduction`` of the result.

    Returns
    -------
    UpdateResult
        Also when a budget or Ctrl-C ended the run: the best so far, with a status that says so; never worse
        than the nominal model, where that is within the bounds.

    Raises
    ------
    InvalidInputError
        Something that is not an UpdatingProblem, a guess outside the bounds, a checkpoint of another search.
    UnsuitableDataError
        A damaged checkpoint.
    NumericalError
        A reduction that was asked for cannot be made: measured dofs move as one.

    Examples
    --------
    >>> import antires_rs as ar
    >>> true = ar.MassSpringChain([2.0, 1.0, 1.0], [550.0, 480.0])
    >>> measured = ar.AntiresonanceSet(0, dict(enumerate(true.antiresonances([0, 1, 2], 0))))
    >>> nominal = ar.MassSpringChain([2.0, 1.0, 1.0], [500.0, 500.0])
    >>> problem = ar.UpdatingProblem(nominal, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), measured)
    >>> result = ar.update(problem, rng=0)
    >>> result.x.round(2)
    array([1.1 , 0.96])
    """
    if not isinstance(problem, UpdatingProblem):
        remedy = "Join model, parameters and measurement by UpdatingProblem first."
        reject("problem", problem, "an UpdatingProblem", remedy)
    wanted = wanted_reduction(problem, reduction, checkpoint)
    asked = (optimizer, rng, workers, callback, x0, progress, checkpoint)
    if wanted is not None:
        try:
            return UpdateResult(problem, *search(problem, *asked, wanted))
        except NumericalError:
            if reduction != "auto":
                raise
    return UpdateResult(problem, *search(problem, *asked))


def search(
    problem: UpdatingProblem,
    optimizer: IslandGA | None,
    rng: Any,
    workers: int | None,
    callback: Callable[[dict[str, Any]], bool | None] | None,
    x0: Any,
    progress: bool | None,
    checkpoint: Any,
    reduction: Reduction | None = None,
) -> tuple[OptimizeResult, int, ReductionReport | None]:
    """The core's search as ``update`` and ``assess_damage`` run it, the seed used, how reductions served.

    The nominal model is evaluated first: what comes back is never worse, however short the search was.
    """
    ga = IslandGA() if optimizer is None else optimizer
    if not isinstance(ga, IslandGA):
        reject("optimizer", optimizer, "an IslandGA", "Leave it out for IslandGA().")
    first = guesses(x0, len(problem.parameters))
    kept, seed = resumed(checkpoint, rng, lambda: fingerprint(problem, ga.options, first))
    end = float("inf") if ga.max_seconds is None else time.monotonic() + ga.max_seconds
    x, (low, high) = problem.nominal, problem.bounds.T
    inside = bool(np.all((low <= x) & (x <= high)))  # NaN, no nominal value, is outside
    cost = problem.cost(x) if inside else float("inf")

    def seconds_left() -> float:
        return max(0.0, end - time.monotonic())

    with watched(callback, progress, ga.options["max_evaluations"]) as watcher:

        def minimize(
            core: Any,
            low: FloatArray,
            high: FloatArray,
            at: FloatArray | None,
            options: dict[str, Any] | None,
        ) -> OptimizeResult:
            own = [] if at is None else [at.tolist()]
            raw = core.minimize(
                np.ascontiguousarray(low),
                np.ascontiguousarray(high),
                [*first, *own] if options is None else own,
                ga.options if options is None else options,
                seed,
                thread_count(workers),
                None if ga.max_seconds is None else seconds_left(),
                watcher,
                kept,
                own[0] if own else None,
            )
            return OptimizeResult._of(raw, ga._in_force)

        if reduction is None:
            found, report = minimize(problem._core, low, high, None, None), None
        else:
            start = np.clip(x, low, high)
            found, report = reduced_search(problem, reduction, minimize, start, seed, seconds_left)
    return (replace(found, x=x, fun=cost) if cost < found.fun else found), seed, report
