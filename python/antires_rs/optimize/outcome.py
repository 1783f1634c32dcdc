"""What came out of a search, read-only."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any, Self

from ..support.checks import FloatArray
from ..support.values import FrozenDict, Value


@dataclass(frozen=True, eq=False)
class History(Value):
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


@dataclass(frozen=True, eq=False)
class OptimizeResult(Value):
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
        ``'interrupted'``, ``'callback'``, ``'collapsed'``, or in the ``result`` of an exception
        ``'objective error'``.
    message : str
        The status in a sentence.
    nfev : int
        Evaluations, as the budget counts them: costs and linearizations, one each.
    njev : int or None
        Linearizations among them: cost, residuals and all their slopes at one point. The polish asks for them
        of an :class:`UpdatingProblem`; a Python function has none. None in the file of an older version.
    nit : int
        Generations.
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
        """Exchanges between the islands. Bests that agree after none were found by each island alone.

        With a polish that may be one local search, made from each.
        """
        return len(self.history.migrations)

    @property
    def effort(self) -> str:
        """What the search took, in words."""
        slopes = f" ({self.njev:,} of them linearizations)" if self.njev else ""
        return f"{self.nfev:,} evaluations{slopes}, {self.nit} generations, {self.migrations} exchanges"

    @classmethod
    def _of(cls, raw: dict[str, Any], options: dict[str, Any]) -> Self:
        history = History(raw["history_nfev"], raw["history_cost"], raw["history_migrations"])
        names = (
            "x",
            "fun",
            "success",
            "status",
            "message",
            "nfev",
            "njev",
            "nit",
            "populations",
            "population_costs",
        )
        return cls(history=history, options=options, **{name: raw[name] for name in names})


def with_result(error: BaseException, result: OptimizeResult) -> BaseException:
    """An exception of the objective, with the best found before it as ``error.result``."""
    so_far = "this is the best found until then" if result.nfev else "nothing had been evaluated"
    text = f"The objective failed ({type(error).__name__}); {so_far}."
    kept = replace(result, status="objective error", message=text)
    with suppress(AttributeError):  # a class of exceptions with slots takes nothing
        error.result = kept  # type: ignore[attr-defined]
    if result.nfev:
        error.add_note(f"The best of {result.nfev:,} evaluations, {result.fun:.6g}, is kept: error.result")
    return error
