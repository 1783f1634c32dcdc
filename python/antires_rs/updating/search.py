"""Run the search of an updating problem."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..optimize.arguments import guesses, seed_of, thread_count
from ..optimize.checkpoint import Checkpoint
from ..optimize.island_ga import IslandGA
from ..optimize.outcome import OptimizeResult
from ..support.progress import watched
from ..support.validation import FloatArray, reject
from .fingerprint import fingerprint
from .problem import UpdatingProblem
from .results import UpdateResult

__all__ = ["search", "update"]


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
    ga = IslandGA() if optimizer is None else optimizer
    if not isinstance(ga, IslandGA):
        reject("optimizer", optimizer, "an IslandGA", "Leave it out for IslandGA().")
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


def nominal_first(problem: UpdatingProblem) -> tuple[FloatArray, float] | None:
    """The nominal values and their cost; none where a parameter has no nominal value within its bounds."""
    x, (low, high) = problem.nominal, problem.bounds.T
    if not np.all((low <= x) & (x <= high)):  # NaN is outside
        return None
    return x, problem.cost(x)
