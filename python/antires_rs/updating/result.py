"""Results of updating: numbers, tables, pictures, and what they do not tell."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, Self, cast

import numpy as np

from ..exceptions import reject
from ..measured.modal_set import ModalSet
from ..models.structural_model import StructuralModel
from ..optimize.island_ga import History, OptimizeResult, seed_of, thread_count
from ..support.checks import FloatArray, choice, finite_scalar, integer
from ..support.progress import one_blas_thread, patient
from ..support.values import FrozenDict, ReadOnly
from ..views import Viewed
from .identifiability import Identifiability, at_solution
from .posterior import Method, ParameterIntervals, ProfileLikelihood, fitted, intervals, profile
from .problem import Explained, UpdatingProblem, explained
from .reduced_model import ReductionReport
from .targets import FrequencyTable, ModalTable

#: What a result has of its search.
_OF_SEARCH = ("x", "fun", "success", "status", "message", "nfev", "njev", "nit", "migrations")
_ON_BOUND = 1e-6  # this near, as a share of the bounds' distance: a polish leaves some 1e-12
#: A largest difference that stays above half of what it was is not explained, unless it is that of an
#: identified value: below 1 % in all simulated records of the README's tables.
_EXPLAINED, _NOISE_PERCENT = 0.5, 1.0


class UpdateResult(ReadOnly, Viewed):
    """An updated model and how it came about. Read-only.

    Attributes
    ----------
    x, fun : ndarray, (n,), and float
        Parameter values, in the order of ``problem.names``, and the objective there.
    success, status, message, nfev, njev, nit, migrations, history
        Why and how the search ended; see :class:`OptimizeResult`.
    search, problem, seed : OptimizeResult, UpdatingProblem and int
        The search itself, with the final populations; what was asked; the master seed in force.
    reduction : ReductionReport or None
        What the reduced models came to that served the search; None if there were none, and in a file.
    options : mapping of str to value
        Options of the call by name, as they held, with the version ``antires_rs``.

    Examples
    --------
    >>> import antires_rs as ar
    >>> result = ar.update(ar.cases.chain8().damage_problem(), rng=0)
    >>> result.status, result.x.round(2)[3:6]
    ('agreed', array([0.  , 0.55, 0.  ]))
    """

    problem: UpdatingProblem
    search: OptimizeResult
    seed: int
    reduction: ReductionReport | None
    options: Mapping[str, Any]
    x: FloatArray
    fun: float
    success: bool
    status: str
    message: str
    nfev: int
    njev: int | None
    nit: int
    migrations: int

    def __init__(
        self,
        problem: UpdatingProblem,
        search: OptimizeResult,
        seed: int,
        reduction: ReductionReport | None = None,
        *,
        options: Mapping[str, Any] | None = None,
    ) -> None:
        self._fill(**{name: getattr(search, name) for name in _OF_SEARCH})
        self._fill(problem=problem, search=search, seed=seed, reduction=reduction)
        self._fill(options=FrozenDict(search.options if options is None else options))

    @property
    def history(self) -> History:
        """Best cost by generation and island."""
        return self.search.history

    @cached_property
    def model(self) -> StructuralModel:
        """The model with the parameters found."""
        return self.problem.model_at(self.x)

    @cached_property
    def table(self) -> FrequencyTable | ModalTable:
        """Measured, before and after, one row a measured antiresonance or mode."""
        return self.problem._table(self.x)

    def modes_beside(self, modes: ModalSet | Sequence[ModalSet]) -> ModalTable:
        """Measured modes beside those of the model before and after, whatever was fitted: a check of it.

        Paired as :class:`UpdatingProblem` pairs modes; their dofs are those of the model.

        Examples
        --------
        >>> import antires_rs as ar
        >>> case = ar.cases.chain8(perturbation=0.05, rng=3)
        >>> table = ar.update(case.updating_problem(), rng=0).modes_beside(case.exact_modes())
        >>> table.after_mode.astype(int).tolist(), bool(table.after_mac.min() > 0.999)
        ([1, 2, 3, 4, 5, 6, 7], True)
        """
        sets = (modes,) if isinstance(modes, ModalSet) else modes
        problem = UpdatingProblem(self.problem.model, self.problem.parameters, sets, objective="modal")
        return cast("ModalTable", problem._table(self.x))

    @cached_property
    def identifiability(self) -> Identifiability:
        """What the data can and cannot tell about the parameters, at the solution."""
        return at_solution(self.problem, self.x)

    @cached_property
    def _fit(self) -> Explained | None:
        """What the updated model explains; None after Ctrl-C."""
        return None if self.search.status == "interrupted" else explained(self.problem, self.x)

    @property
    def at_bound(self) -> list[str]:
        """Names of the parameters that the data pushed to a bound other than their nominal value."""
        low, high = self.problem.bounds.T
        near = _ON_BOUND * (high - low)
        nominal = self.problem.nominal
        at_low = (self.x <= low + near) & (abs(nominal - low) > near)
        at_high = (self.x >= high - near) & (abs(nominal - high) > near)
        on = (at_low | at_high) & (low < high)
        on &= ~self.identifiability.blind  # where an unseen parameter ends means nothing
        return [name for name, hit in zip(self.problem.names, on, strict=True) if hit]

    @property
    def notes(self) -> list[str]:
        """What a reader should know before trusting the numbers."""
        notes = [] if self.success else [f"The search did not finish: {self.message}"]
        fit = self._fit
        notes += [] if fit is None or fit.enough else [fit.sentence]
        notes += self.problem.left_out
        if self.reduction is not None:
            notes.append(self.reduction.note)
        alone = int(np.isnan(self.table.after_hz).sum())
        if alone:
            said = f"{alone} of {self.table.after_hz.size} measured {self.problem.noun}s have no partner"
            notes.append(f"{said}: the updated model has none there up to 1.5 times the highest measured.")
        before, after = self.table.largest_before_percent, self.table.largest_after_percent
        if after > max(_EXPLAINED * before, _NOISE_PERCENT):
            said = f"Hardly explained: the largest difference is {after:.2f} %, after {before:.2f} % before."
            cause = "What is wrong may have no parameter, or a dof may be another one"
            notes.append(f"{said} {cause}; doubt the values found.")
        if self.at_bound:
            notes.append(f"On a bound: {', '.join(self.at_bound)}. Widen the bounds or doubt the model.")
        return notes + self.identifiability.notes

    @cached_property
    def interval(self) -> dict[Any, tuple[float, float]]:
        """90 % interval of each parameter by name: the quick answer of :meth:`intervals`."""
        return self.intervals(progress=False).interval

    @cached_property
    def chi_square(self) -> float:
        """Reduced chi-square of the least-squares residuals by their stated errors; NaN where none are."""
        return fitted(self.problem, self.x).chi_square

    @patient("intervals")
    @one_blas_thread
    def intervals(
        self,
        method: Method = "laplace",
        *,
        level: float = 0.9,
        draws: int = 1000,
        rng: int | np.random.Generator | None = 0,
        workers: int | None = None,
        progress: bool | None = None,
    ) -> ParameterIntervals:
        """Intervals of the parameters, with draws of their posterior.

        Uniform within the bounds before the test; Gaussian errors with the ``std_hz`` of the measured values,
        and an error of the model that the residuals tell, alike for values that what the model lacks would
        move alike (of antiresonances, up to 600 dofs): it widens intervals and moves none. Where no errors
        are stated, one error of all is learned. Around the least-squares solution near ``x``. Of damage
        against a baseline a :class:`SeverityIntervals`: given the elements declared damaged, errors of the
        model considered.

        Parameters
        ----------
        method : {'laplace', 'ensemble'}
            Quick, with residuals linear around the solution; or sure, with the residuals that the model has:
            some ten thousand evaluations. Both stay in the valley that the search found.
        level, draws : float and int
            Probability of each interval, within [0.5, 0.999]; at least 50.
        rng, workers, progress
            As of :func:`update`; the threads are those of the ensemble.
        """
        choice("method", method, ("laplace", "ensemble"))
        finite_scalar("level", level, low=0.5, high=0.999)
        integer("draws", draws, low=50, high=1_000_000)
        return self._intervals(method, float(level), draws, seed_of(rng), thread_count(workers))

    def _intervals(self, *asked: Any) -> ParameterIntervals:
        return intervals(self.problem, self.x, *asked)

    @patient("profile")
    @one_blas_thread
    def profile(
        self, name: str, *, level: float = 0.9, points: int = 21, progress: bool | None = None
    ) -> ProfileLikelihood:
        """Profile likelihood of one parameter: the others are fitted again at ``points`` of its values.

        For parameters on a bound, and those that the data hardly tell; ``kind`` says whether both sides
        close. Of damage against a baseline the others of the set declared damaged are fitted, by the
        likelihood of the assessment; other elements, and unknown names, are an ``InvalidInputError``.
        """
        finite_scalar("level", level, low=0.5, high=0.999)
        integer("points", points, low=5, high=1001)
        if name not in self.problem.names:
            remedy = f"One of {', '.join(self.problem.names)}."
            reject("name", repr(name), "a parameter of the result", remedy)
        return self._profile(name, level, points)

    def _profile(self, *asked: Any) -> ProfileLikelihood:
        return profile(self.problem, self.x, *asked)

    def summary(self) -> str:
        """Parameters, frequencies and notes as text."""
        head = f"J = {self.fun:.6g} after {self.search.effort}: {self.status} ({self.message})"
        notes = [f"note: {note}" for note in self.notes]
        return "\n".join([head, "", *self._values(), "", str(self.table), *([""] if notes else []), *notes])

    def _values(self) -> list[str]:
        """A line a parameter; results of damage have others."""
        width = max(len(name) for name in self.problem.names)
        spreads = self.identifiability.spreads
        wide = max(10, *map(len, spreads))
        rows = zip(self.problem.names, self.x, spreads, self.problem.bounds, strict=True)
        return [f"{n:<{width}}  {x:#12.6g} {spread:<{wide}} [{a:g}, {b:g}]" for n, x, spread, (a, b) in rows]

    @property
    def std(self) -> FloatArray:
        """Standard deviation of each parameter to first order, (n,); see ``identifiability``."""
        return self.identifiability.std

    def plot(self, ax: Any = None) -> Any:
        """Differences of the frequencies before and after updating; see :mod:`antires_rs.figures`."""
        return self._view("plot")(self.table, ax=ax)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write problem, search and versions into one file ``*.npz``, whole or not at all; no pickle."""
        self._view("save")(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Read what :meth:`save` wrote, in this version or an older one; every float comes back bit for bit.

        Diagrams of the measured sets are not kept. A file that is damaged, of another kind or of a newer
        version is an ``UnsuitableDataError``; an objective that this version computes otherwise is warned of.
        """
        return cast("Self", cls._view("load")(path, cls))

    def report(self, path: str | os.PathLike[str], **options: Any) -> None:
        """Write one self-contained HTML file; ``options``: :func:`antires_rs.figures.report.write_report`."""
        self._view("report")(self, path, **options)

    def __repr__(self) -> str:
        closing = self.table._closing.replace(":", "")
        return f"{type(self).__name__}({self.status}, J = {self.fun:.4g}, {closing})"
