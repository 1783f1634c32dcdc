"""Run the search of an updating problem, or those of many."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import repeat
from typing import Any, Literal

import numpy as np

from ..exceptions import NumericalError, part, reject
from ..optimize.island_ga import IslandGA, OptimizeResult, guesses, resumed, seed_of, thread_count
from ..support.checks import FloatArray, integer
from ..support.progress import waiting, watched
from ..support.workers import Failed, in_order
from .problem import UpdatingProblem, fingerprint
from .reduced_model import Reduction, ReductionReport, reduced_search, wanted_reduction
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
        Whether to search on a reduced model, see :class:`Reduction`; the result is told of the full one.
        'auto': above 600 dofs, with antiresonances, at most 60 parameters that scale terms, no checkpoint.

    Returns
    -------
    UpdateResult
        Also when a budget or Ctrl-C ended the run: the best so far, with a status that says so; never worse
        than the nominal model, where that is within the bounds.

    Raises
    ------
    InvalidInputError, UnsuitableDataError, NumericalError
        A guess outside the bounds, a checkpoint of another search; a damaged checkpoint; a reduction that was
        asked for and cannot be made, since measured dofs move as one.

    Examples
    --------
    >>> import antires_rs as ar
    >>> nominal = ar.MassSpringChain([1.0, 1.0], [500.0], ground_first_n_per_m=500.0)
    >>> measured = ar.AntiresonanceSet(0, {0: [3.4]})  # sqrt(k / m) / 2 pi
    >>> problem = ar.UpdatingProblem(nominal, ar.stiffness_factor([0], bounds=(0.8, 1.2)), measured)
    >>> ar.update(problem, rng=0).x.round(3)
    array([0.913])
    """
    if not isinstance(problem, UpdatingProblem):
        reject("problem", problem, "an UpdatingProblem", "Join model, parameters and measurement by it.")
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
    """The core's search as ``update`` and ``assess_damage`` run it, the seed used, how reductions served."""
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
            core: Any, low: Any, high: Any, at: FloatArray | None, options: dict[str, Any] | None
        ) -> OptimizeResult:
            own = [] if at is None else [at.tolist()]
            box = np.ascontiguousarray(low), np.ascontiguousarray(high)
            how = ([*first, *own], ga.options) if options is None else (own, options)
            seconds = None if ga.max_seconds is None else seconds_left()
            run = seed, thread_count(workers), seconds, watcher, kept, own[0] if own else None
            return OptimizeResult._of(core.minimize(*box, *how, *run), ga._in_force)

        if reduction is None:
            found, report = minimize(problem._core, low, high, None, None), None
        else:
            start = np.clip(x, low, high)
            found, report = reduced_search(problem, reduction, minimize, start, seed, seconds_left)
    return (replace(found, x=x, fun=cost) if cost < found.fun else found), seed, report


# -- Many updating problems: seeds, drawn measurements, scenarios; by threads, processes or a cluster


@dataclass(frozen=True, eq=False, repr=False)
class UpdateEnsemble:
    """Results of many updatings, in the order of their problems. Read-only.

    Attributes
    ----------
    results, failed : tuple of UpdateResult or None, and dict of int to str
        None where an updating failed, and why, by the number of the problem.
    seeds, interrupted : tuple of int and bool
        ``ar.update(problem, rng=seeds[k])`` gives result k again, bit for bit; whether Ctrl-C ended it.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.update_ensemble(ar.cases.chain8().damage_problem(), count=3, rng=0).x[:, 4].round(2).tolist()
    [0.55, 0.55, 0.55]
    """

    results: tuple[UpdateResult | None, ...]
    seeds: tuple[int, ...]
    failed: dict[int, str]
    interrupted: bool = False

    def __len__(self) -> int:
        return len(self.results)

    def __getitem__(self, k: int) -> UpdateResult | None:
        return self.results[k]

    def __iter__(self) -> Iterator[UpdateResult | None]:
        return iter(self.results)

    @property
    def x(self) -> FloatArray:
        """Parameters of every result, (n_problems, n_parameters), of one number; NaN where it failed."""
        sizes = {result.x.size for result in self.results if result is not None}
        if len(sizes) > 1:
            got = f"problems of {', '.join(map(str, sorted(sizes)))} parameters"
            reject("x", got, "problems of one number of parameters", "Take .x of each result.")
        size = sizes.pop() if sizes else 0
        return np.array([np.full(size, np.nan) if r is None else r.x for r in self.results]).reshape(-1, size)

    @property
    def fun(self) -> FloatArray:
        """Objective of every result, (n_problems,); NaN where it failed."""
        return np.array([np.nan if result is None else result.fun for result in self.results])

    def __str__(self) -> str:
        there = [result for result in self.results if result is not None]
        lines = [f"{len(self.results)} updatings, {len(there)} with a result"]
        if len({result.x.size for result in there}) == 1:
            names, columns = there[0].problem.names, np.array([result.x for result in there]).T
            width = max(map(len, names))
            lines.append(f"{'parameter':{width}s}       mean        std     lowest    highest")
            for name, own in zip(names, columns, strict=True):
                numbers = own.mean(), own.std(ddof=1) if own.size > 1 else 0.0, own.min(), own.max()
                lines.append(f"{name:{width}s} " + " ".join(f"{value:10.4g}" for value in numbers))
        lines += [f"updating {k} failed: {why}" for k, why in self.failed.items()]
        if self.interrupted:
            lines.append("interrupted: these are the results that were there")
        return "\n".join(lines)

    __repr__ = __str__


def update_ensemble(
    problems: UpdatingProblem | Iterable[UpdatingProblem],
    *,
    count: int | None = None,
    optimizer: IslandGA | None = None,
    rng: int | np.random.Generator | None = None,
    workers: Any = None,
    progress: bool | None = None,
) -> UpdateEnsemble:
    """Update many problems: one from several seeds, drawn measurements, scenarios of what is unknown.

    Parameters
    ----------
    problems : UpdatingProblem, or an iterable of them
        A generator is read a few ahead only. One problem alone is updated ``count`` times, with other seeds.
    count : int, optional
        How many seeds one problem gets; None for several problems.
    optimizer, progress
        As of :func:`update`.
    rng : int or numpy.random.Generator, optional
        Seed of all: search k has the seed ``SeedSequence(seed, spawn_key=(k,))``.
    workers : int, str or executor, optional
        Who searches, as of :meth:`IslandGA.minimize`; None is one search after another, each by all
        processors. The bits are the same. A problem alone goes to each worker once.

    Returns
    -------
    UpdateEnsemble
        Also after Ctrl-C: what was there.

    Examples
    --------
    >>> import antires_rs as ar
    >>> problems = (ar.cases.chain8(perturbation=0.05, rng=seed).updating_problem() for seed in range(2))
    >>> ar.update_ensemble(problems, rng=0).x.shape
    (2, 15)
    """
    alone = isinstance(problems, UpdatingProblem)
    if alone == (count is None):
        got = "none beside one problem" if alone else f"{count} beside several problems"
        remedy = "Pass count=20." if alone else "Leave it out."
        reject("count", got, "how many seeds one problem gets; nothing beside several", remedy)
    if alone:
        given: Iterable[Any] = repeat(None, integer("count", count, low=1))
    elif isinstance(problems, Iterable):
        given = problems
    else:
        reject("problems", problems, "an UpdatingProblem, or an iterable of them", "Make them first.")
    seed = seed_of(rng)
    kept: list[UpdatingProblem] = []
    seeds: list[int] = []

    def tasks() -> Iterator[tuple[UpdatingProblem | None, int]]:
        for k, problem in enumerate(given):
            if not (alone or isinstance(problem, UpdatingProblem)):
                reject(part("problems", k), problem, "an UpdatingProblem", "Make one of it first.")
            kept.append(problems if problem is None else problem)  # type: ignore[arg-type]
            own = np.random.SeedSequence(seed, spawn_key=(k,))
            seeds.append(int(own.generate_state(1, np.uint64)[0]) >> 1)
            yield problem, seeds[-1]

    results: list[UpdateResult | None] = []
    failed: dict[int, str] = {}
    interrupted = False
    shared = (problems if alone else None, optimizer, None if workers is None else 1)
    with waiting("updating", progress):
        answers = in_order(_updated, tasks(), workers, shared=shared, errors="return", what="problem")
        try:
            for k, answer in enumerate(answers):
                if not isinstance(answer, Failed):
                    results.append(UpdateResult(kept[k], *answer))
                    if interrupted := answer[0].status == "interrupted":
                        break
                    continue
                if isinstance(answer.error, KeyboardInterrupt):
                    raise answer.error
                failed[k] = f"{type(answer.error).__name__}: {answer.error}"
                results.append(None)
        except KeyboardInterrupt:
            if not results:
                raise
            interrupted = True
        finally:
            answers.close()  # type: ignore[attr-defined]
    return UpdateEnsemble(tuple(results), tuple(seeds[: len(results)]), failed, interrupted)


def _updated(shared: tuple[Any, ...], task: tuple[UpdatingProblem | None, int]) -> tuple[Any, ...]:
    """What makes a result of a problem: its search, seed and reduction. The problem itself stays at home."""
    alone, optimizer, threads = shared
    problem, seed = task
    options: dict[str, Any] = {"optimizer": optimizer, "rng": seed, "workers": threads, "progress": False}
    found = update(alone if problem is None else problem, **options)
    return found.search, found.seed, found.reduction
