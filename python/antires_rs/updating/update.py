"""Run the search of an updating problem."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Literal

import numpy as np

from ..exceptions import NumericalError, reject
from ..optimize.checkpoint import Checkpoint
from ..optimize.island_ga import IslandGA, OptimizeResult, guesses, seed_of, thread_count
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
    rng : int or numpy.random.Generator, optional
        The same seed gives bit-identical results for any number of threads.
    workers : int, optional
        Threads; all processors by default.
    callback : callable, optional
        Called after each generation with a dict (``nit, nfev, fun, x, islands, migrations``); return True
        to stop.
    x0 : array_like, (n,) or (m, n), optional
        Guesses that join the initial populations.
    progress : bool, optional
        Show progress on standard error; by default on a terminal, after one second.
    checkpoint : path-like, optional
        File in which the search is kept, written every two seconds and at the end. If it is there, the search
        goes on from it, bit-identical to one that never stopped; see
        :mod:`antires_rs.optimize.checkpoint`.
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
        reject(
            "problem",
            problem,
            "an UpdatingProblem",
            "Join model, parameters and measurement by UpdatingProblem first.",
        )
    wanted = wanted_reduction(problem, reduction, checkpoint)
    if wanted is not None:
        asked = (wanted, optimizer, rng, workers, callback, x0, progress)
        try:
            return UpdateResult(problem, *_search_reduced(problem, *asked))
        except NumericalError:
            if reduction != "auto":
                raise
    found, seed = search(problem, optimizer, rng, workers, callback, x0, progress, checkpoint)
    return UpdateResult(problem, found, seed)


def search(
    problem: UpdatingProblem,
    optimizer: IslandGA | None,
    rng: Any,
    workers: int | None,
    callback: Callable[[dict[str, Any]], bool | None] | None,
    x0: Any,
    progress: bool | None,
    checkpoint: Any,
) -> tuple[OptimizeResult, int]:
    """The core's search as ``update`` and ``assess_damage`` run it, and the seed that was used.

    The nominal model is evaluated first: what comes back is never worse, however short the search was.
    """
    ga = _optimizer(optimizer)
    first = guesses(x0, len(problem.parameters))
    kept = None if checkpoint is None else Checkpoint(checkpoint)
    seed = kept.seed if kept and rng is None and kept.seed is not None else seed_of(rng)
    if kept:
        kept.begin(fingerprint(problem, ga.options, first), seed)
    nominal = nominal_first(problem)
    with watched(callback, progress, ga.options["max_evaluations"]) as watcher:
        raw = problem._core.minimize(
            problem.bounds[:, 0].copy(),
            problem.bounds[:, 1].copy(),
            first,
            ga.options,
            seed,
            thread_count(workers),
            ga.max_seconds,
            watcher,
            kept,
        )
    found = OptimizeResult._of(raw, ga._in_force)
    if nominal is not None and nominal[1] < found.fun:
        found = replace(found, x=nominal[0], fun=nominal[1])
    return found, seed


def _search_reduced(
    problem: UpdatingProblem,
    reduction: Reduction,
    optimizer: IslandGA | None,
    rng: Any,
    workers: int | None,
    callback: Callable[[dict[str, Any]], bool | None] | None,
    x0: Any,
    progress: bool | None,
) -> tuple[OptimizeResult, int, ReductionReport]:
    """The same on reduced models, and how they served."""
    ga, seed = _optimizer(optimizer), seed_of(rng)
    end = float("inf") if ga.max_seconds is None else time.monotonic() + ga.max_seconds

    def seconds_left() -> float:
        return max(0.0, end - time.monotonic())

    first = guesses(x0, len(problem.parameters))
    nominal = nominal_first(problem)
    low, high = problem.bounds.T
    start = np.clip(problem.nominal, low, high)
    with watched(callback, progress, ga.options["max_evaluations"]) as watcher:

        def minimize(
            core: Any, lower: FloatArray, upper: FloatArray, at: FloatArray, options: dict[str, Any] | None
        ) -> OptimizeResult:
            begin = at.tolist()
            raw = core.minimize(
                np.ascontiguousarray(lower),
                np.ascontiguousarray(upper),
                [*first, begin] if options is None else [begin],
                ga.options if options is None else options,
                seed,
                thread_count(workers),
                None if ga.max_seconds is None else seconds_left(),
                watcher,
                None,
                begin,
            )
            return OptimizeResult._of(raw, ga._in_force)

        found, report = reduced_search(problem, reduction, minimize, start, seed, seconds_left)
    if nominal is not None and nominal[1] < found.fun:
        found = replace(found, x=nominal[0], fun=nominal[1])
    return found, seed, report


def _optimizer(given: IslandGA | None) -> IslandGA:
    ga = IslandGA() if given is None else given
    if not isinstance(ga, IslandGA):
        reject("optimizer", given, "an IslandGA", "Leave it out for IslandGA().")
    return ga


def nominal_first(problem: UpdatingProblem) -> tuple[FloatArray, float] | None:
    """The nominal values and their cost; none where a parameter has no nominal value within its bounds."""
    x, (low, high) = problem.nominal, problem.bounds.T
    if not np.all((low <= x) & (x <= high)):  # NaN is outside
        return None
    return x, problem.cost(x)
