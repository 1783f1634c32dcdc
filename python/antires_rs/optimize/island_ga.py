"""The island genetic algorithm: several populations search on their own and exchange their best.

The search itself runs in the Rust core, in parallel, with one random stream for each island, so that
the same seed gives the same bits for any number of threads.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .. import _core
from ..exceptions import ObjectiveError
from ..support.progress import watched
from ..support.validation import FloatArray, finite_scalar, integer, real_array, reject

__all__ = ["History", "IslandGA", "OptimizeResult"]


@dataclass(frozen=True)
class History:
    """How a search went, one row a generation, the initial populations first.

    Attributes
    ----------
    nfev : ndarray, (n_generations,)
        Evaluations so far.
    cost : ndarray, (n_generations, n_islands)
        Best cost of each island.
    migrations : ndarray
        Generations after which the islands exchanged their best.

    Examples
    --------
    >>> import antires_rs as ar
    >>> found = ar.IslandGA(max_evaluations=5000).minimize(lambda x: (x[0] - 0.3) ** 2, [(-1, 1)], rng=0)
    >>> bool(found.history.nfev[-1] == found.nfev), found.history.cost.shape[1]
    (True, 4)
    """

    nfev: FloatArray
    cost: FloatArray
    migrations: FloatArray


@dataclass(frozen=True)
class OptimizeResult:
    """Outcome of a search.

    Attributes
    ----------
    x : ndarray, (n,)
        Best point found.
    fun : float
        Its cost.
    success : bool
        Whether the search ended by its own stop rule, not by a budget or an interruption.
    status : str
        ``'agreed'`` (the islands' bests are the same point), ``'cost agreed'`` (they have the same cost,
        at different points: a flat valley), ``'stagnated'`` (a single island), ``'budget'``,
        ``'interrupted'``, ``'callback'`` or ``'collapsed'``.
    message : str
        The status in a sentence.
    nfev, nit : int
        Evaluations and generations.
    history : History
        Best costs by generation and island.
    populations : ndarray, (n_islands, population, n)
        Final individuals.
    population_costs : ndarray, (n_islands, population)
        Their costs.
    options : dict
        Options of the optimizer in force.

    Examples
    --------
    >>> import antires_rs as ar
    >>> found = ar.IslandGA(max_evaluations=5000).minimize(lambda x: (x[0] - 0.3) ** 2, [(-1, 1)], rng=0)
    >>> found.x.round(2), found.nfev <= 5000, found.populations.shape
    (array([0.3]), True, (4, 40, 1))
    """

    x: FloatArray
    fun: float
    success: bool
    status: str
    message: str
    nfev: int
    nit: int
    history: History = field(repr=False)
    populations: FloatArray = field(repr=False)
    population_costs: FloatArray = field(repr=False)
    options: dict[str, Any] = field(default_factory=dict, repr=False)

    @classmethod
    def _of(cls, raw: dict[str, Any], optimizer: IslandGA) -> OptimizeResult:
        history = History(raw["history_nfev"], raw["history_cost"], raw["history_migrations"])
        names = ("x", "fun", "success", "status", "message", "nfev", "nit", "populations", "population_costs")
        return cls(
            history=history,
            options={**optimizer.options, "max_seconds": optimizer.max_seconds},
            **{name: raw[name] for name in names},
        )


class IslandGA:
    """Island genetic algorithm of Meruane, J. Sound Vib. 332 (2013) 807-820.

    Each island selects by normalized geometric ranking, crosses by an operator of its own (arithmetic,
    heuristic, BLX-0.5, uniform, in turn), mutates genes to a bound or anywhere, and never loses its
    best. An island that finds nothing better for ``patience`` generations waits; when all wait they
    compare their bests, and stop or exchange them with their ring neighbours (best out, worst
    replaced). Where the objective allows, a local search polishes the bests before they are compared;
    ``IslandGA(polish=False)`` leaves it out. Parameters not given take the defaults of the Rust core, shown
    by ``.options``.

    Parameters
    ----------
    islands : int, default 4
        Number of populations, at least 1. Crossovers repeat in turn.
    population : int, default 40
        Individuals of each island.
    crossovers : sequence of str, default ('arithmetic', 'heuristic', 'blend', 'uniform')
        Operators dealt out to the islands.
    crossover_probability : float, default 0.8
        Of a pair, p_c.
    mutation_probability : float, default 0.02
        Of a gene, p_m; boundary and uniform mutation are equally likely.
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
        Local search from the nominal model and from the islands' bests. By default where the objective
        tells how it is composed, as an :class:`UpdatingProblem` does and a plain function does not:
        sequential linear programming with analytic sensitivities on the parameters, and moves that drop,
        add or exchange single damages, which a count of damages needs. ``True`` polishes plain functions
        too, without derivatives; variables with lower bound 0 may then be dropped and exchanged.
        ``False`` is the paper's algorithm.
    polish_interval : int, default 10
        Generations after which the bests are polished, even if not all islands wait.
    polish_evaluations : int, default 1000
        Evaluations after which the polish of one point begins no new move; all count in ``nfev``.
    max_evaluations : int, default 200000
        Budget of evaluations, never exceeded.
    max_generations : int, optional
        Budget of generations.
    max_seconds : float, optional
        Budget of time. A run that it ends is not reproducible.

    Raises
    ------
    InvalidInputError
        An unknown option or a value out of range.

    References
    ----------
    Joines & Houck, Proc. IEEE ICEC (1994); Michalewicz, Genetic Algorithms + Data Structures =
    Evolution Programs, 3rd ed. (1996); Eshelman & Schaffer, FOGA 2 (1993) 187-202.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> def sphere(x):
    ...     return float(np.sum((x - 0.3) ** 2))
    >>> result = ar.IslandGA(max_evaluations=5000).minimize(sphere, [(-1, 1)] * 2, rng=0)
    >>> result.fun < 1e-3
    True
    """

    def __init__(self, *, max_seconds: float | None = None, **options: Any) -> None:
        self.max_seconds = (
            None if max_seconds is None else finite_scalar("max_seconds", max_seconds, low=0.0, unit="s")
        )
        if "crossovers" in options:
            options["crossovers"] = _texts("crossovers", options["crossovers"])
        for name, value in options.items():
            _check_option_type(name, value)
        #: Every option with its value in force.
        self.options = _core.island_options(options)

    def __repr__(self) -> str:
        return f"IslandGA(islands={self.options['islands']}, population={self.options['population']})"

    def minimize(
        self,
        fun: Callable[..., Any],
        bounds: Any,
        *,
        rng: int | np.random.Generator | None = None,
        workers: int | Callable[..., Any] | None = None,
        vectorized: bool = False,
        callback: Callable[[dict[str, Any]], bool | None] | None = None,
        x0: Any = None,
        progress: bool | None = None,
    ) -> OptimizeResult:
        """Minimize any Python function inside a box.

        The candidates of a generation are evaluated together, in one call from the core.

        Parameters
        ----------
        fun : callable
            ``fun(x) -> float`` for x (n,); with ``vectorized=True`` ``fun(X) -> (m,)`` for X (m, n).
        bounds : array_like, (n, 2)
            Lower and upper bound of each variable.
        rng : int or numpy.random.Generator, optional
            Same seed, same result.
        workers : int or map-like callable, optional
            More than one: a pool of that many processes evaluates ``fun`` (it must pickle). A callable is
            used as ``workers(fun, candidates)``, for example ``pool.map``. Not with ``vectorized``.
        vectorized : bool
            Whether ``fun`` takes all candidates at once.
        callback : callable, optional
            Called after each generation with a dict (``nit, nfev, fun, x, islands, migrations``); return
            True to stop.
        x0 : array_like, (n,) or (m, n), optional
            Guesses that join the initial populations.
        progress : bool, optional
            Show progress on standard error; by default on a terminal, after one second.

        Returns
        -------
        OptimizeResult
            Ctrl-C returns the best so far, with status ``'interrupted'``.

        Raises
        ------
        InvalidInputError
            Bounds out of order or not finite, a guess outside them.
        ObjectiveError
            ``fun`` returned something other than one number for each candidate.

        Examples
        --------
        >>> import numpy as np, antires_rs as ar
        >>> ga = ar.IslandGA(max_evaluations=4000)
        >>> ga.minimize(lambda X: np.abs(X).sum(axis=1), [(0, 1)] * 3, rng=1, vectorized=True).x
        array([0., 0., 0.])
        """
        box = check_bounds(bounds)
        if vectorized and workers is not None:
            reject("workers", workers, "None with vectorized=True", "The function takes all candidates.")
        with (
            _batch(fun, vectorized, workers) as batch,
            watched(callback, progress, self.options["max_evaluations"]) as watcher,
        ):
            raw = _core.minimize(
                batch,
                box[:, 0].copy(),
                box[:, 1].copy(),
                guesses(x0, len(box)),
                self.options,
                seed_of(rng),
                self.max_seconds,
                watcher,
            )
        return OptimizeResult._of(raw, self)


def seed_of(rng: int | np.random.Generator | None) -> int:
    """Master seed of a run: an int as it is, or one drawn from a Generator or the system.

    So the seed kept in a result, passed back as ``rng``, repeats the run.
    """
    if rng is not None and not isinstance(rng, np.random.Generator):
        return integer("rng", rng, low=0, high=2**63 - 1)
    return int(np.random.default_rng(rng).integers(0, 2**63, dtype=np.int64))


def thread_count(workers: int | None) -> int:
    """Threads to use: the given number, or the processors this process may run on."""
    if workers is not None:
        return integer("workers", workers, low=1, high=_MOST_WORKERS)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def check_bounds(bounds: Any) -> FloatArray:
    """Bounds as an (n, 2) array; order and finiteness are checked in the core, by gene."""
    wanted = "an array (n, 2) of lower and upper bounds, n >= 1"
    try:
        box = np.asarray(bounds, dtype=np.float64)
    except (TypeError, ValueError) as exc:
        reject(
            "bounds",
            f"{type(bounds).__name__} that does not convert ({exc})",
            wanted,
            "Write them as in [(0.0, 1.0), (0.9, 1.1)].",
        )
    if box.ndim != 2 or box.shape[1] != 2 or box.size == 0:
        reject("bounds", f"shape {box.shape}", wanted, "Write them as in [(0.0, 1.0), (0.9, 1.1)].")
    return box


def guesses(x0: Any, n: int) -> list[list[float]]:
    """Initial guesses as rows."""
    if x0 is None:
        return []
    rows = np.atleast_2d(real_array("x0", x0, ndim=None, wanted=f"an array ({n},) or (m, {n})"))
    if rows.ndim != 2 or rows.shape[1] != n:
        reject(
            "x0",
            f"shape {np.shape(x0)}",
            f"an array ({n},) or (m, {n})",
            "Give a value for each parameter, in the order of the bounds.",
        )
    return [[float(v) for v in row] for row in rows]


class _batch:
    """A function of (m, n) candidates made of the user's function, with its pool if it needs one."""

    def __init__(self, fun: Callable[..., Any], vectorized: bool, workers: Any) -> None:
        if not callable(fun):
            reject("fun", fun, "a callable", "Pass the function itself, without calling it.")
        self.fun, self.vectorized, self.pool = fun, vectorized, None
        self.seen_finite = False
        self.map: Callable[..., Any] = map
        if callable(workers):
            self.map = workers
        elif workers is not None and integer("workers", workers, low=1, high=_MOST_WORKERS) > 1:
            import multiprocessing

            self.pool = multiprocessing.get_context("spawn").Pool(workers)
            self.map = self.pool.map

    def __enter__(self) -> Callable[[FloatArray], FloatArray]:
        return self._evaluate

    def __exit__(self, *exc: object) -> None:
        if self.pool is not None:
            self.pool.terminate()

    def _evaluate(self, candidates: FloatArray) -> FloatArray:
        answer = self.fun(candidates) if self.vectorized else list(self.map(self.fun, candidates))
        wanted = f"{len(candidates)} real costs, one for each candidate"
        try:
            costs = np.asarray(answer)
            if np.iscomplexobj(costs):
                raise TypeError("complex costs")
            costs = costs.astype(np.float64)
        except (TypeError, ValueError) as exc:
            raise ObjectiveError(
                "fun", f"{type(answer).__name__} that is not numeric ({exc})", wanted, _RETURN
            ) from exc
        if costs.shape != (len(candidates),):
            raise ObjectiveError("fun", f"an array of shape {costs.shape}", wanted, _RETURN)
        # A cost that is not finite is the worst there is; a whole first generation of them is a mistake.
        self.seen_finite = self.seen_finite or bool(np.isfinite(costs).any())
        if not self.seen_finite:
            raise ObjectiveError(
                "fun",
                f"no finite cost for any of {len(candidates)} candidates",
                wanted,
                "Call the function at a point inside the bounds to see why.",
            )
        return costs


_RETURN = "Return a float for each candidate: an array (m,) of them with vectorized=True."
#: More than any machine has; a larger number is a slip.
_MOST_WORKERS = 1024
#: Largest count that the core can hold.
_MOST = 2**63 - 1
_INTEGERS = {
    "islands",
    "population",
    "patience",
    "cost_migrations",
    "polish_interval",
    "polish_evaluations",
    "max_evaluations",
    "max_generations",
}


def _check_option_type(name: str, value: Any) -> None:
    """Type of an option; its range is the core's to judge, and so is an unknown name."""
    if name in _INTEGERS:
        if not (name == "max_generations" and value is None):
            integer(name, value, low=0, high=_MOST)
    elif name == "agreement":
        _texts(name, [value])
    elif name == "polish":
        if value is not None and not isinstance(value, bool):
            reject(name, value, "True, False or None", "None lets the optimizer choose.")
    elif name != "crossovers" and name in _core.island_options({}):
        finite_scalar(name, value)


def _texts(name: str, value: Any) -> list[str]:
    """A list of texts."""
    texts = list(value) if isinstance(value, Iterable) and not isinstance(value, str) else [value]
    if not all(isinstance(text, str) for text in texts):
        reject(
            name,
            value,
            "text, or a list of texts where several are possible",
            "Put it in quotes; see the docstring for the names.",
        )
    return texts
