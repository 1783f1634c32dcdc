"""The island genetic algorithm: several populations search on their own and exchange their best."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from typing import Any, Self, cast

import numpy as np

from .. import _core
from ..exceptions import ObjectiveError, reject
from ..support.checks import FloatArray, finite_scalar, integer, real_array
from ..support.progress import watched
from ..support.values import FrozenDict, Value
from ..support.workers import MOST_WORKERS, Failed, Workers, processors
from .checkpoint import Checkpoint, digest_of


@dataclass(frozen=True, eq=False)
class History(Value):
    """How a search went, one row a generation, the initial populations first.

    Examples
    --------
    >>> import antires_rs as ar
    >>> found = ar.IslandGA(max_evaluations=5000).minimize(lambda x: (x[0] - 0.3) ** 2, [(-1, 1)], rng=0)
    >>> found.history.cost.shape[1]
    4
    """

    nfev: FloatArray  # evaluations so far, (n_generations,)
    cost: FloatArray  # the best of each island, (n_generations, n_islands)
    migrations: FloatArray  # generations after which the islands exchanged their best


@dataclass(frozen=True, eq=False)
class OptimizeResult(Value):
    """Outcome of a search.

    Attributes
    ----------
    x, fun : ndarray, (n,), and float
        Best point found, and its cost.
    success : bool
        Whether the search ended by its own stop rule, not by a budget or an interruption.
    status, message : str
        ``'agreed'`` (the islands' bests are the same point), ``'cost agreed'`` (they have the same cost, at
        different points: a flat valley), ``'stagnated'`` (a single island), ``'budget'``, ``'interrupted'``,
        ``'callback'``, ``'collapsed'``, or in the ``result`` of an exception ``'objective error'``; and the
        same in a sentence.
    nfev, nit : int
        Evaluations, as the budget counts them (costs and linearizations, one each), and generations.
    njev : int or None
        Linearizations among them: cost, residuals and all their slopes at one point, of which a Python
        function has none. None in the file of an older version.
    history : History
    populations, population_costs : ndarray, (n_islands, population, n) and (n_islands, population)
        Final individuals and their costs.
    options : dict
        Options of the optimizer in force.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.IslandGA(max_evaluations=5000).minimize(lambda x: (x[0] - 0.3) ** 2, [(-1, 1)], rng=0).x.round(2)
    array([0.3])
    """

    x: FloatArray
    fun: float
    success: bool
    status: str
    message: str
    nfev: int
    njev: int | None
    nit: int
    history: History = field(repr=False)
    populations: FloatArray = field(repr=False)
    population_costs: FloatArray = field(repr=False)
    options: dict[str, Any] = field(default_factory=dict, repr=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._fill(options=FrozenDict(self.options))

    @property
    def migrations(self) -> int:
        """Exchanges between the islands. Bests that agree after none were found by each island alone."""
        return len(self.history.migrations)

    @property
    def effort(self) -> str:
        """What the search took, in words."""
        slopes = f" ({self.njev:,} of them linearizations)" if self.njev else ""
        return f"{self.nfev:,} evaluations{slopes}, {self.nit} generations, {self.migrations} exchanges"

    @classmethod
    def _of(cls, raw: dict[str, Any], options: dict[str, Any]) -> Self:
        history = History(raw["history_nfev"], raw["history_cost"], raw["history_migrations"])
        held = {each.name: raw[each.name] for each in fields(cls) if each.name in raw}
        return cls(history=history, options=options, **held)


# -- Arguments of a search, checked: seed, threads, bounds, guesses and the types of options

_MOST = 2**63 - 1  # largest count that the core can hold


def seed_of(rng: int | np.random.Generator | None) -> int:
    """Master seed of a run, which repeats it: an int, or one drawn from a Generator or the system."""
    if rng is not None and not isinstance(rng, np.random.Generator):
        return integer("rng", rng, low=0, high=_MOST)
    return int(np.random.default_rng(rng).integers(0, 2**63, dtype=np.int64))


def resumed(checkpoint: Any, rng: Any, fingerprint: Callable[[], bytes]) -> tuple[Checkpoint | None, int]:
    """Where a search is kept, if it is, and its seed: that of the file where none is given."""
    kept = None if checkpoint is None else Checkpoint(checkpoint)
    seed = kept.seed if kept and rng is None and kept.seed is not None else seed_of(rng)
    if kept:
        kept.begin(fingerprint(), seed)
    return kept, seed


def thread_count(workers: int | None) -> int:
    """Threads to use: the given number, or the processors this process may run on."""
    return processors() if workers is None else integer("workers", workers, low=1, high=MOST_WORKERS)


def check_bounds(bounds: Any) -> FloatArray:
    """Bounds as an (n, 2) array; order and finiteness are checked in the core, by gene."""
    wanted, remedy = "an array (n, 2) of lower and upper bounds", "Write them as in [(0.0, 1.0), (0.9, 1.1)]."
    try:
        box = np.asarray(bounds, dtype=np.float64)
    except (TypeError, ValueError) as exc:
        reject("bounds", f"{type(bounds).__name__} that does not convert ({exc})", wanted, remedy)
    if box.ndim != 2 or box.shape[1] != 2 or box.size == 0:
        reject("bounds", f"shape {box.shape}", wanted, remedy)
    return box


def guesses(x0: Any, n: int) -> list[list[float]]:
    """Initial guesses as rows."""
    if x0 is None:
        return []
    wanted = f"an array ({n},) or (m, {n})"
    rows = np.atleast_2d(real_array("x0", x0, ndim=None, wanted=wanted))
    if rows.ndim != 2 or rows.shape[1] != n:
        reject("x0", f"shape {np.shape(x0)}", wanted, "Give a value for each parameter, in their order.")
    return cast("list[list[float]]", rows.tolist())


def _check_type(name: str, value: Any) -> Any:
    """An option of the right type; its range is the core's to judge, and so is an unknown name."""
    default = _core.island_options({}).get(name)
    if name in ("crossovers", "agreement"):
        several = name == "crossovers" and isinstance(value, Iterable) and not isinstance(value, str)
        texts = list(value) if several else [value]
        if not all(isinstance(each, str) for each in texts):
            remedy = "Put it in quotes; see the docstring for the names."
            reject(name, value, "text, or a list of texts", remedy)
        return texts if name == "crossovers" else value
    if name == "polish":
        if value is not None and not isinstance(value, bool):
            reject(name, value, "True, False or None", "None lets the optimizer choose.")
    elif isinstance(default, int) or (name == "max_generations" and value is not None):
        integer(name, value, low=0, high=_MOST)
    elif isinstance(default, float):
        finite_scalar(name, value)
    return value


# -- The user's function as the core calls it: all candidates of a generation, or as many as time allows

_RETURN = "Return a float for each candidate: an array (m,) of them with vectorized=True."
_CHUNK_S = 0.25  # candidates go to workers in chunks of about so long: an interrupted chunk is lost


class _Late(Exception):
    """The time is over."""


class Batch:
    """Costs of (m, n) candidates by the user's function, NaN where it was not asked; and why, as a text."""

    def __init__(self, fun: Any, vectorized: bool, workers: Any, max_seconds: float | None) -> None:
        if not callable(fun):
            reject("fun", fun, "a callable", "Pass the function itself, without calling it.")
        self._fun, self._vectorized = fun, vectorized
        self._end = np.inf if max_seconds is None else time.monotonic() + max_seconds
        self._workers = None if workers is None else Workers(fun, workers, seconds_a_chunk=_CHUNK_S)
        self._seen_finite = False
        self.error: BaseException | None = None  # what the function raised, or what is wrong with its answer

    def __enter__(self) -> Batch:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._workers is not None:
            self._workers.close(at_once=kind is not None)

    def __call__(self, candidates: FloatArray) -> tuple[FloatArray, str | None]:
        """Costs of a generation."""
        costs = np.full(len(candidates), np.nan)
        found: dict[int, Any] = {}
        try:
            if self._vectorized:
                return self._numbers(self._fun(candidates), len(candidates), whole=True), None
            why = self._evaluate(candidates, found)
            done = sorted(found)
            costs[done] = self._numbers([found[nth] for nth in done], len(done), whole=why is None)
        except Exception as error:
            self.error, why = error, "error"
        return costs, why

    def _evaluate(self, candidates: FloatArray, found: dict[int, Any]) -> str | None:
        """Fill ``found`` by number of the candidate; returns why it is not full."""
        try:
            if self._workers is None:
                for nth, x in enumerate(candidates):
                    try:
                        found[nth] = self._fun(x)
                    except Exception as error:
                        return self._failed(error, x)
                    self._in_time()
            else:
                for nth, value in self._workers.as_done(candidates, poll=self._in_time):
                    if isinstance(value, Failed):
                        return self._failed(value.error, candidates[nth])
                    found[nth] = value
        except KeyboardInterrupt:
            return "interrupted"
        except _Late:
            return "time"
        except Exception as error:  # of the workers
            self.error = error
            return "error"
        return None

    def _failed(self, error: BaseException, x: FloatArray) -> str:
        error.add_note(f"fun was at x = {np.array2string(x, precision=6, threshold=20)}")
        self.error = error
        return "error"

    def _in_time(self) -> None:
        if time.monotonic() > self._end:
            raise _Late

    def _numbers(self, answer: Any, count: int, whole: bool) -> FloatArray:
        """The answer as costs; one that is not finite is the worst there is."""
        wanted = f"{count} real costs, one for each candidate"
        try:
            costs = np.asarray(answer)
            if np.iscomplexobj(costs):
                raise TypeError("complex costs")
            costs = costs.astype(np.float64)
        except (TypeError, ValueError) as exc:
            got = f"{type(answer).__name__} that is not numeric ({exc})"
            raise ObjectiveError("fun", got, wanted, _RETURN) from exc
        if costs.shape != (count,):
            raise ObjectiveError("fun", f"an array of shape {costs.shape}", wanted, _RETURN)
        # A whole first generation that is not finite is a mistake.
        self._seen_finite = self._seen_finite or bool(np.isfinite(costs).any())
        if whole and not self._seen_finite:
            got = f"no finite cost for any of {count} candidates"
            raise ObjectiveError("fun", got, wanted, "Call it at a point within the bounds to see why.")
        return np.where(np.isfinite(costs), costs, np.inf)


class IslandGA:
    """Island genetic algorithm of Meruane, J. Sound Vib. 332 (2013) 807-820.

    Each island selects by normalized geometric ranking, crosses by an operator of its own (arithmetic,
    heuristic, BLX-0.5, uniform, in turn), mutates genes to a bound or anywhere, and never loses its best. An
    island that finds nothing better for ``patience`` generations waits; when all wait they compare their
    bests, and stop or exchange them with their ring neighbours (best out, worst replaced). The algorithm as
    printed is :meth:`IslandGA.paper`.

    Parameters
    ----------
    islands, population : int, default 4 and 40
        Number of populations, at least 1, and of individuals of each.
    crossovers : sequence of str, default ('arithmetic', 'heuristic', 'blend', 'uniform')
        Operators dealt out to the islands in turn.
    crossover_probability, mutation_probability : float, default 0.8 and 0.02
        p_c of a pair, p_m of a gene; boundary and uniform mutation are equally likely.
    selection_pressure : float, default 0.08
        Probability q of selecting the best individual (Joines & Houck 1994).
    patience : int, default 40
        Generations without improvement before an island waits.
    improvement_tolerance : float, default 1e-4
        Relative gain that counts as improvement; 0 counts any gain, as the algorithm is printed.
    agreement : {'genes-or-cost', 'genes'}
        What the islands' bests must agree in to end the search; ``'genes'`` alone is the paper's.
    gene_tolerance : float, default 1e-6
        Spread of the bests that counts as agreement, relative to the bounds.
    cost_tolerance, cost_floor, cost_migrations : float, float, int
        Bests agree in cost within ``cost_tolerance`` (1e-6, relative) plus ``cost_floor`` at
        ``cost_migrations`` (3) migrations in a row.
    polish : bool, optional
        Local search from the nominal model and from the islands' bests. By default for an
        :class:`UpdatingProblem`: sequential linear programming with analytic sensitivities, and moves that
        drop, add or exchange single damages. ``True`` polishes plain functions too, without derivatives.
    polish_interval : int, default 10
        Generations after which the bests are polished, even if not all islands wait.
    polish_evaluations : int, default 1000
        Evaluations after which the polish of one point begins no new move; all count in ``nfev``.
    max_evaluations : int, default 200000
        Budget of evaluations, never exceeded; a linearization, one eigenproblem like a cost, counts as one.
    max_generations, max_seconds : int and float, optional
        Budgets of generations and of time. A run that time ends is not reproducible.

    References
    ----------
    Joines & Houck, Proc. IEEE ICEC (1994); Michalewicz, Genetic Algorithms + Data Structures =
    Evolution Programs, 3rd ed. (1996); Eshelman & Schaffer, FOGA 2 (1993) 187-202.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.IslandGA(islands=2, population=20).minimize(lambda x: x @ x, [(-1, 1)] * 2, rng=0).fun < 1e-3
    True
    """

    def __init__(self, *, max_seconds: float | None = None, **options: Any) -> None:
        if max_seconds is not None:
            max_seconds = finite_scalar("max_seconds", max_seconds, low=0.0, unit="s")
        self.max_seconds = max_seconds
        #: Every option with its value in force.
        self.options = _core.island_options({name: _check_type(name, each) for name, each in options.items()})

    @classmethod
    def paper(cls, **options: Any) -> Self:
        """The algorithm as the paper prints it, as a whole.

        ``polish=False, improvement_tolerance=0, agreement='genes', gene_tolerance=0``. For damage give the
        problem ``snap=0`` as well, by ``DamagePenalty(snap=0)`` or ``SearchOptions(snap=0)``: the paper
        rounds no severity to zero.

        Further ``options``, as of :class:`IslandGA`, win over these four. Still ours, as the paper does not
        say it: the selection pressure, which mutation a gene gets (either, equally likely), three tries of
        the heuristic crossover before the parents are copied, the neighbours of a ring, and the budget
        ``max_evaluations``. Where the paper contradicts itself we have four populations, not five.

        Examples
        --------
        >>> import antires_rs as ar
        >>> ar.IslandGA.paper(max_evaluations=4000).options["agreement"]
        'genes'
        """
        printed = {"polish": False, "improvement_tolerance": 0.0, "agreement": "genes", "gene_tolerance": 0.0}
        return cls(**{**printed, **options})

    @property
    def _in_force(self) -> dict[str, Any]:
        """All options, the time limit included, as a result keeps them."""
        return {**self.options, "max_seconds": self.max_seconds}

    def __repr__(self) -> str:
        return f"IslandGA(islands={self.options['islands']}, population={self.options['population']})"

    def minimize(
        self,
        fun: Callable[..., Any],
        bounds: Any,
        *,
        rng: int | np.random.Generator | None = None,
        workers: Any = None,
        vectorized: bool = False,
        callback: Callable[[dict[str, Any]], bool | None] | None = None,
        x0: Any = None,
        progress: bool | None = None,
        checkpoint: str | os.PathLike[str] | None = None,
    ) -> OptimizeResult:
        """Minimize any Python function inside a box.

        Parameters
        ----------
        fun : callable
            ``fun(x) -> float`` for x (n,); with ``vectorized=True`` ``fun(X) -> (m,)`` for X (m, n).
        bounds : array_like, (n, 2)
        rng : int or numpy.random.Generator, optional
            Same seed, same result.
        workers : int, str or executor, optional
            Who evaluates ``fun``: from 2 on that many processes (``fun`` is then to be at the top of a
            module), ``"processes"`` for one a processor, ``"threads"``, or anything with ``submit``: an
            executor of ``concurrent.futures`` or ``mpi4py.futures``, a Dask ``Client``. The bits are the same
            for any workers, each with one BLAS thread; one that is lost is replaced. Not with ``vectorized``.
        vectorized : bool
            Whether ``fun`` takes all candidates at once.
        callback : callable, optional
            Called after each generation with a dict (``nit, nfev, fun, x, islands, migrations``); return
            True to stop.
        x0 : array_like, (n,) or (m, n), optional
            Guesses that join the initial populations.
        progress : bool, optional
            Show progress on standard error; by default on a terminal, after one second.
        checkpoint : path-like, optional
            File in which the search is kept, written every two seconds and at the end. If it is there, the
            search goes on from it, bit-identical to one that never stopped, if ``fun`` is the same.

        Returns
        -------
        OptimizeResult
            After Ctrl-C or ``max_seconds`` the best so far, also in the first generation.

        Raises
        ------
        ObjectiveError
            ``fun`` returned something other than one number for each candidate.
        LostWorkerError
            One candidate took more than ten workers along.

        Notes
        -----
        An exception of ``fun`` ends the search and comes out as it is. Its attribute ``result``, and that of
        the errors above, is the :class:`OptimizeResult` until then; a checkpoint goes on from the generation
        before.

        Examples
        --------
        >>> import numpy as np, antires_rs as ar
        >>> ar.IslandGA().minimize(lambda X: np.abs(X).sum(axis=1), [(0, 1)] * 3, rng=1, vectorized=True).x
        array([0., 0., 0.])
        """
        box = check_bounds(bounds)
        if vectorized and workers is not None:
            reject("workers", workers, "None with vectorized=True", "The function takes all candidates.")
        first = guesses(x0, len(box))
        of = (b"minimize", box.tobytes(), sorted(self.options.items()), first)
        kept, seed = resumed(checkpoint, rng, lambda: digest_of(*of))
        with (
            Batch(fun, vectorized, workers, self.max_seconds) as batch,
            watched(callback, progress, self.options["max_evaluations"]) as watcher,
        ):
            ends = (box[:, 0].copy(), box[:, 1].copy())
            raw = _core.minimize(batch, *ends, first, self.options, seed, self.max_seconds, watcher, kept)
        result = OptimizeResult._of(raw, self._in_force)
        if batch.error is not None:
            raise _with_result(batch.error, result)
        return result


def _with_result(error: BaseException, result: OptimizeResult) -> BaseException:
    """An exception of the objective, with the best found before it as ``error.result``."""
    so_far = "this is the best found until then" if result.nfev else "nothing had been evaluated"
    text = f"The objective failed ({type(error).__name__}); {so_far}."
    with suppress(AttributeError):  # a class of exceptions with slots takes nothing
        error.result = replace(result, status="objective error", message=text)  # type: ignore[attr-defined]
    if result.nfev:
        error.add_note(f"The best of {result.nfev:,} evaluations, {result.fun:.6g}, is kept: error.result")
    return error
