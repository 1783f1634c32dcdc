"""A problem on few dofs, its matrices projected on a basis, and the search on such problems."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from .. import _core
from .._core import Model as CoreModel
from ..exceptions import NumericalError, reject
from ..models.matrices import Entries, as_sparse
from ..models.parameters import CoreParameter
from ..models.structural_model import StructuralModel
from ..optimize.island_ga import IslandGA, OptimizeResult
from ..support.checks import FloatArray, IntArray, finite_scalar, integer
from ..support.progress import one_blas_thread
from .problem import UpdatingProblem
from .targets import AntiresonanceTargets, Part, by_rows

# -- K(x) = K + sum (s_j(x) - 1) K_j with s_j the factor of one parameter, and so M: true of factors,
# reductions and values of groups that do not share a term; sections, angles and positions bend it.

_SCALES = ("stiffness_factor", "stiffness_reduction", "mass_factor", "group_value")


def _scaled(part: CoreParameter) -> list[tuple[bool, int]]:
    """Whether each term of a parameter is one of the mass, and the power of its factor."""
    quantity, terms, _, more = part
    return more[1] if more and isinstance(more[1], list) else [(quantity == "mass_factor", 1)] * len(terms)


def bent_by(problem: UpdatingProblem) -> str | None:
    """Why K and M are no sums in the parameters of a problem; None where they are."""
    taken: set[tuple[bool, int]] = set()
    for part in problem.model.description.core_parameters(problem.parameters):
        if part[0] not in _SCALES:
            return f"{part[0]!r} does not scale whole terms"
        for term, (mass, _) in zip(part[1], _scaled(part), strict=True):
            if (mass, term) in taken:
                return f"two parameters scale term {term}"
            taken.add((mass, term))
    return None


def matrices(core: CoreModel) -> tuple[Any, Any]:
    """K and M, sparse."""
    return as_sparse(core.stiffness()), as_sparse(core.mass())


_BAND = 1.25  # modes and roots are followed up to this multiple of the highest measured frequency
_DENSE = 256  # terms of more dofs stay sparse


class Term(NamedTuple):
    """The dofs that a term joins, and its matrix (d, d) there."""

    dofs: IntArray
    matrix: Any

    @classmethod
    def of(cls, *several: Any) -> Term:
        """The sum of terms in rows, columns and values."""
        from scipy.sparse import coo_array

        rows, columns, values = (np.concatenate(each) for each in zip(*several, strict=True))
        dofs = np.unique(np.concatenate([rows, columns])).astype(np.intp)
        at = np.searchsorted(dofs, rows), np.searchsorted(dofs, columns)
        matrix = coo_array((values, at), shape=(dofs.size, dofs.size))
        return cls(dofs, matrix.toarray() if dofs.size <= _DENSE else matrix.tocsr())

    def times(self, vectors: FloatArray) -> FloatArray:
        """The term times vectors (n, m), at its dofs."""
        return np.asarray(self.matrix @ vectors[self.dofs])

    def on(self, *vectors: FloatArray) -> FloatArray:
        """The term on a basis, given in blocks of its columns."""
        here = np.hstack([block[self.dofs] for block in vectors])
        return np.asarray(here.T @ (self.matrix @ here))


class Large:
    """A model of many dofs with parameters, and the responses that it is asked for."""

    def __init__(self, model: StructuralModel, parts: Sequence[Part], parameters: Any) -> None:
        self.core, self.parts = by_rows(model, parts)
        self._parameters = model.description.core_parameters(parameters)
        self.sensors = sorted({row for part in self.parts for row in part[0]})
        self.forces = sorted({row for part in self.parts for row in part[1]})
        #: Rows of sensors and forces, and the responses where these are the first dofs.
        self.rows = sorted({*self.sensors, *self.forces})
        place = {row: number for number, row in enumerate(self.rows)}
        self.reduced_parts = [
            ([place[i] for i in part[0]], [place[k] for k in part[1]], *part[2:]) for part in self.parts
        ]
        hz = np.concatenate([part[2] for part in parts])
        self.measured_hz = float(hz.min()), float(hz.max())
        self.limit_hz = _BAND * self.measured_hz[1]

    def at(self, x: FloatArray) -> CoreModel:
        """The full model at ``x``."""
        return self.core.at(self._parameters, np.ascontiguousarray(x))


class Moving(NamedTuple):
    """What a parameter moves of one matrix by one power: which, whether of the mass, the power, its slope."""

    parameter: int
    mass: bool
    power: int
    slope: float
    term: Term


class Affine(Large):
    """The sums of a problem, its parameters as :func:`bent_by` allows."""

    def __init__(self, problem: UpdatingProblem) -> None:
        assert isinstance(problem._targets, AntiresonanceTargets)
        super().__init__(problem.model, problem._targets.parts, problem.parameters)
        self.problem = problem
        self.stiffness, self.mass = matrices(self.core)
        every, self.moving = (self.core.stiffness_terms(), self.core.mass_terms()), list[Moving]()
        for nth, part in enumerate(self._parameters):
            alike: dict[tuple[bool, int], list[Any]] = {}
            for term, (mass, power) in zip(part[1], _scaled(part), strict=True):
                alike.setdefault((mass, power), []).append(every[mass][term])
            rate = 1.0 / part[3][0] if part[3] else 1.0
            self.moving += [Moving(nth, *how, rate * how[1], Term.of(*own)) for how, own in alike.items()]


# -- A basis that carries a model and its parameters' effect near one point, for antiresonances up to a limit
#
# With :math:`A = K + \sigma M`: the modes up to the limit; of every force and sensor the first Krylov vectors
# :math:`A^{-1} e`, :math:`A^{-1} M A^{-1} e`, ..., which stand for all higher modes; and the largest of what
# a parameter makes of these, :math:`A^{-1} K_j v`; all orthonormal in A. A root then errs by the product of
# the errors of both columns, that of the force and that of the sensor.
#
# References: Ericsson & Ruhe, Math. Comp. 35 (1980) 1251-1268; Balmes, Mech. Syst. Signal Process. 10 (1996)
# 381-394 (bases of a parametric family); Benner, Gugercin & Willcox, SIAM Review 57 (2015) 483-531.

_SHIFT = 0.1  # shift, as a share of the limit in omega squared: small keeps digits of the lowest modes
_MORE_OF_FORCE = 4  # vectors more than for a sensor: its error is a factor in that of all roots
_ROUNDING = 1e-7  # a direction this small beside the others is rounding
_PART = 0.2  # directions of one parameter are left out below this part of the least size
_AT_ONCE = 256  # so many right-hand sides are solved for at once


@dataclass(frozen=True)
class Basis:
    """Vectors (n, r), K + sigma M at the point and its factors, sigma, and the limit in omega squared."""

    vectors: FloatArray
    shifted: Any
    factors: Any
    sigma: float
    limit: float


def basis_at(
    affine: Affine, x: FloatArray, half_widths: FloatArray, depth: int, largest: tuple[int, float]
) -> Basis:
    """The basis at one point; ``largest`` are the most vectors that parameters make, and the least size."""
    size, least = largest
    basis, moving = point_basis(affine, x, depth)
    needed = moving.shape[1]
    if size < needed:
        why = f"the modes to {affine.limit_hz:.4g} Hz, the forces and the sensors alone take {needed}. Give "
        why += f"reduction=Reduction(size={2 * needed}) or more, or reduction=False."
        raise NumericalError(f"a reduced model of {size} vectors", why)
    own = basis.vectors[:, :size]
    moved = _moved(basis, affine, half_widths, moving, own, _PART * least)
    more = _beside(basis.shifted, own, moved, size - own.shape[1], least)
    return replace(basis, vectors=np.hstack([own, more]))


def point_basis(large: Large, x: FloatArray, depth: int) -> tuple[Basis, FloatArray]:
    """The basis at ``x`` without parameters, and the vectors that these move most, of unit size."""
    from scipy import sparse
    from scipy.sparse.linalg import splu

    core = large.at(x)
    stiffness, mass = matrices(core)
    limit = (2.0 * np.pi * large.limit_hz) ** 2
    sigma = _SHIFT * limit
    shifted = sparse.csc_matrix(stiffness + sigma * mass)
    symmetric: Any = {"permc_spec": "MMD_AT_PLUS_A", "options": {"SymmetricMode": True}}
    factors = splu(shifted, diag_pivot_thresh=0.0, **symmetric)
    freq_hz, shapes = core.modes(large.limit_hz, None)
    blocks = [np.asarray(shapes[:, freq_hz <= large.limit_hz])]
    moving = blocks[:1]
    for rows, count in ((large.sensors, depth), (large.forces, depth + _MORE_OF_FORCE)):
        loads = np.zeros((mass.shape[0], len(rows)))
        loads[rows, range(len(rows))] = 1.0
        for _ in range(count):
            blocks.append(factors.solve(loads))
            loads = np.asarray(mass @ blocks[-1])
        moving = [*moving, blocks[-count]]
    own = _orthonormal(shifted, np.hstack(blocks))
    return Basis(own, shifted, factors, sigma, limit), _units(shifted, np.hstack(moving))


def beside(shifted: Any, core: FloatArray, vectors: FloatArray, least: float) -> FloatArray:
    """The directions of ``vectors`` (n, m) of more than the least size beside an orthonormal core."""
    loads = np.asarray(shifted @ vectors)
    return _beside(shifted, core, _Moved(vectors, loads, core.T @ loads), vectors.shape[1], least)


def solved(factors: Any, loads: FloatArray) -> FloatArray:
    """A^-1 times many loads (n, m)."""
    parts = [factors.solve(loads[:, at : at + _AT_ONCE]) for at in range(0, loads.shape[1], _AT_ONCE)]
    return np.hstack(parts) if parts else loads


@dataclass(frozen=True)
class _Moved:
    """What parameters make of vectors: v = A^-1 l, l, and the part of v in the core, by columns."""

    vectors: FloatArray
    loads: FloatArray
    inside: FloatArray

    def principal(self, places: Any, least: float, most: int) -> tuple[_Moved, FloatArray]:
        """The largest combinations in what is outside of the core, and their sizes."""
        # What is kept is far above the digits that the difference loses.
        gram = self.vectors[places].T @ self.loads[places] - self.inside.T @ self.inside
        sizes, rotation = _principal(gram)
        kept = int(np.count_nonzero(sizes[:most] > least))
        turn = rotation[:, :kept]
        return _Moved(self.vectors @ turn, self.loads @ turn, self.inside @ turn), sizes[:kept]


def _moved(
    basis: Basis, affine: Affine, half_widths: FloatArray, of: FloatArray, core: FloatArray, least: float
) -> _Moved:
    """By all parameters, over half of their ranges: l = (dK + sigma dM) v."""
    found = []
    for each in (one for one in affine.moving if half_widths[one.parameter] > 0.0):
        change = half_widths[each.parameter] * each.slope * (basis.sigma if each.mass else 1.0)
        places = each.term.dofs
        held = change * each.term.times(of)
        loads = np.zeros(of.shape)
        loads[places] = held
        moved = _Moved(solved(basis.factors, loads), loads, core[places].T @ held)
        found.append(moved.principal(places, least, of.shape[1])[0])
    if not found:
        return _Moved(of[:, :0], of[:, :0], core[:0].T @ of[:0, :0])
    columns = [[each.vectors, each.loads, each.inside] for each in found]
    return _Moved(*(np.hstack(each) for each in zip(*columns, strict=True)))


def _units(shifted: Any, vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.sqrt(np.einsum("ij,ij->j", vectors, shifted @ vectors)))


def _orthonormal(shifted: Any, vectors: FloatArray) -> FloatArray:
    """A-orthonormal combinations of vectors, brought to unit size, without those that rounding makes."""
    vectors = _units(shifted, vectors)
    for floor in (_ROUNDING, 0.5):  # twice, for the digits
        sizes, rotation = _principal(vectors.T @ (shifted @ vectors))
        kept = sizes > floor
        vectors = np.asarray(vectors @ (rotation[:, kept] / sizes[kept]))
    return vectors


def _principal(gram: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sizes of the principal directions, descending, and the directions."""
    squares, rotation = np.linalg.eigh(0.5 * (gram + gram.T))
    return np.sqrt(np.maximum(squares[::-1], 0.0)), rotation[:, ::-1]


def _beside(shifted: Any, core: FloatArray, moved: _Moved, room: int, least: float) -> FloatArray:
    """The largest directions of what moves out of the core."""
    largest, sizes = moved.principal(slice(None), least, room)
    found = (largest.vectors - core @ largest.inside) / sizes
    for _ in range(2):
        found = found - core @ (core.T @ (shifted @ found))
    return _orthonormal(shifted, found)


_INDEPENDENT = 1e-6  # measured dofs whose least motion apart is below this part of the largest move as one
_FARTHEST = 0.05  # a ratio of full to reduced frequency further from one than this is that of another root


class ReducedProblem:
    """The objective on a basis."""

    def __init__(self, affine: Affine, basis: Basis) -> None:
        self._affine = affine
        self.size, self._parts = basis.vectors.shape[1], affine.reduced_parts
        vectors, sides = basis.vectors, (list[FloatArray](), list[FloatArray]())
        own: list[list[tuple[int, tuple[bool, int]]]] = [[] for _ in affine.problem.parameters]
        for each in affine.moving:
            own[each.parameter].append((len(sides[each.mass]), (each.mass, each.power)))
            sides[each.mass].append(each.term.on(vectors))
        both = vectors.T @ (affine.stiffness @ vectors), vectors.T @ (affine.mass @ vectors)
        self._model = projected(coordinates(vectors[affine.rows]), *both, *sides)
        self._parameters = [
            (part[0], [nth for nth, _ in terms], False, part[3] and (part[3][0], [how for _, how in terms]))
            for part, terms in zip(affine._parameters, own, strict=True)
        ]
        self.ratio = np.ones(affine.problem.measured_hz.size)
        self.is_corrected = False
        self._plain = self.core = self._objective()

    def corrected(self, x: FloatArray, full_hz: FloatArray) -> ReducedProblem:
        """The same, its paired frequencies times what makes them those of the full model at ``x``."""
        new = copy(self)
        ratio = full_hz / self._plain.pairs(x)[0]
        new.ratio = np.where(np.abs(ratio - 1.0) < _FARTHEST, ratio, 1.0)
        new.core, new.is_corrected = new._objective(), True
        return new

    def paired_hz(self, x: FloatArray) -> FloatArray:
        """Frequency paired with each measured one, (m,) Hz; NaN without one."""
        return np.asarray(self.core.pairs(x)[0] * self.ratio)

    def _objective(self) -> _core.Objective:
        ratios = np.split(self.ratio, np.cumsum([part[2].size for part in self._parts])[:-1])
        parts = [(*part[:2], part[2] / r, *part[3:]) for part, r in zip(self._parts, ratios, strict=True)]
        weighing = self._affine.problem._weighing
        return _core.Objective.antiresonance(self._model, self._parameters, parts, *weighing)


def projected(
    change: FloatArray, k: FloatArray, m: FloatArray, of_k: Sequence[FloatArray], of_m: Sequence[FloatArray]
) -> CoreModel:
    """The core's model of matrices on a basis, and of their terms, in other coordinates."""

    def entries(matrix: FloatArray) -> Entries:
        small = change.T @ matrix @ change
        return Entries.of(0.5 * (small + small.T))

    sides = ([entries(each) for each in side] for side in (of_k, of_m))
    return _core.Model.from_matrices(change.shape[1], entries(k), entries(m), *sides)


def coordinates(rows: FloatArray) -> FloatArray:
    """T with ``rows @ T = [1 0]``: measured dofs first, then what moves none of them, orthonormal."""
    _, sizes, directions = np.linalg.svd(rows, full_matrices=True)
    if rows.shape[1] < rows.shape[0] or sizes[-1] < _INDEPENDENT * sizes[0]:
        raise NumericalError(
            "measured dofs as coordinates of a reduced model",
            "some of them move as one, or the basis has fewer vectors than there are. Use reduction=False.",
        )
    return np.hstack([np.linalg.pinv(rows), directions[sizes.size :].T])


# -- The search on reduced models: a basis where the search stands, a search on it, its answer on the full one
#
# After the first search, on the basis of the middle of the box, come descents within a trust region on bases
# made where the last one ended, their frequencies brought to those of the full model there (Alexandrov &
# Lewis, Optim. Eng. 2 (2001) 413-430), until both models agree. Unless that answer explains everything,
# others begin elsewhere until two agree.


LARGE, _MOST_PARAMETERS = 600, 60  # more dofs than these are reduced, with no more parameters


@dataclass(frozen=True)
class Reduction:
    """How a model is reduced while its parameters are sought.

    It is projected on modes, Krylov vectors of force and sensors, and what parameters make of these to first
    order, anew where the search arrives and corrected by the full model there, until both agree.

    Parameters
    ----------
    size, rounds : int, default 160 and 8
        Most vectors, at least as many as modes (to 1.25 times the highest measured frequency), forces and
        sensors; and most bases.
    least : float, default 0.05
        Directions by which parameters move the basis less, over half of their ranges, are left out.
    tolerance : float, default 1e-6
        Largest relative difference, at the answer, of a frequency of the reduced model from the full one's.

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
    n_dof, size, rounds, full_evaluations : int
        Dofs of the full model and of the last reduced one, bases made, evaluations of the full model.
    difference, agreed : float and bool
        Largest relative error of a frequency of the reduced model at the answer, corrected at the place
        before, and whether that is within the tolerance.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.ReductionReport(2220, 90, 2, 2e-9, True, 5).note.partition(":")[0]
    'Sought on a reduced model, 90 dofs for 2220, by 2 bases'
    """

    n_dof: int
    size: int
    rounds: int
    difference: float
    agreed: bool
    full_evaluations: int

    @property
    def note(self) -> str:
        """A sentence for the reader."""
        return self.note_with("Give reduction=Reduction(size=...) a larger size, or reduction=False.")

    def note_with(self, remedy: str) -> str:
        """The same, with what to do where the models differ."""
        bases = "a basis" if self.rounds == 1 else f"{self.rounds} bases"
        head = f"Sought on a reduced model, {self.size} dofs for {self.n_dof}, by {bases}: at the answer "
        if self.agreed:
            return f"{head}its antiresonances are those of the full model to {self.difference:.0e}."
        return f"{head}they still differ from the full model's by {self.difference:.0e}. {remedy}"


def wanted_reduction(problem: UpdatingProblem, given: Any, checkpoint: Any) -> Reduction | None:
    """The reduction to use; None for the full model."""
    if given is False or given is None:
        return None
    if not isinstance(problem._targets, AntiresonanceTargets):
        unfit: str | None = "modes were measured"
    else:
        unfit = bent_by(problem) if checkpoint is None else "a checkpoint is asked for"
    if isinstance(given, str) and given == "auto":
        large = problem.model.n_dof > LARGE and len(problem.parameters) <= _MOST_PARAMETERS
        return Reduction() if large and unfit is None else None
    if given is not True and not isinstance(given, Reduction):
        reject("reduction", given, "'auto', True, False or a Reduction", "Leave it out: that is 'auto'.")
    if unfit is not None:
        reject("reduction", f"a reduced model, but {unfit}", "a problem that can be reduced", "Leave it out.")
    return Reduction() if given is True else given


_WIDE_TRUST, _LEAST_TRUST = 0.25, 1e-3  # half-widths of the trust region, as shares of the bounds' distance
_POOR, _GOOD = 0.25, 0.75  # parts of the promised fall of the cost below and above which it shrinks and grows
#: Krylov vectors of a sensor in the first basis and in others; part of the least size in the first.
_DEPTH, _DEPTH_THERE, _FINER = 2, 3, 0.4
#: Below this difference of full and reduced frequencies the basis stays, and is corrected, again where that
#: has left no more than the second part of it.
_CLOSE, _CORRECTS = 1e-4, 0.1
_WIDEST = 0.5  # largest share of the box that a basis around a place serves
_ATTEMPTS, _AT_ONE_PLACE = 4, 0.02  # most searches from elsewhere, until two end within this part of the box
#: A mean residual of nothing but rounding; else a search looks around its answer within this part of the box,
#: and goes on from a cost lower than this part of what it was.
_EXACT, _AROUND, _BETTER = 1e-6, 0.2, 0.95
_EQUAL = 1.001  # a cost above another by less than this factor is as good, where full and reduced model agree
_STOPPED = ("interrupted", "callback")  # what ends a search at once
_INTERRUPTED = ("interrupted", "Interrupted by the user; this is the best found until then.")
_NO_TIME = ("budget", "The time limit was reached before searches on reduced models agreed.")

#: Of objective, lower and upper bounds, where a polish begins, and options, None for the optimizer's own.
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
    """What the search found, its cost that of the full model, and how the reduced ones served."""
    search = _Search(problem, reduction, minimize, np.random.default_rng(seed), seconds_left)
    ended = None
    try:
        best = search.agreed(start)
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
        difference=best.difference,
        agreed=best.difference <= reduction.tolerance,
        full_evaluations=len(search.found),
    )
    nfev, njev = (sum(getattr(each, name) or 0 for each in search.found) for name in ("nfev", "njev"))
    found = replace(search.found[0], x=best.x, fun=best.cost, nfev=nfev, njev=njev)
    if ended is not None:
        found = replace(found, status=ended[0], message=ended[1], success=False)
    return found, report


class _Answer:
    """A candidate on the full model, and the reduced one's cost there."""

    def __init__(
        self, problem: UpdatingProblem, reduced: ReducedProblem, x: FloatArray, promised: float
    ) -> None:
        self.x, self.reduced, self.promised = x, reduced, promised
        self.cost, self.full_hz = problem._core.cost_and_pairs(x)
        own_hz, alone = reduced.paired_hz(x), np.isnan(self.full_hz)
        apart = float(np.nanmax(np.abs(own_hz / self.full_hz - 1.0), initial=0.0))
        #: Largest relative difference of paired frequencies; infinity where only one has a partner.
        self.difference = apart if np.array_equal(np.isnan(own_hz), alone) else float("inf")
        residuals = np.where(alone, 1.0, (self.full_hz / problem.measured_hz) ** 2 - 1.0)
        self.unexplained = float(np.abs(residuals).mean())


@dataclass
class _Search:
    """Searches from one point after the other."""

    problem: UpdatingProblem
    reduction: Reduction
    minimize: Minimize
    rng: np.random.Generator
    seconds_left: Callable[[], float]
    found: list[OptimizeResult] = field(default_factory=list)
    best: _Answer | None = None
    bases: int = 0

    def __post_init__(self) -> None:
        # The smallest search there is around a polish, and one that polishes a few points.
        self._descent = IslandGA(islands=1, population=4, max_generations=1).options
        self._look = IslandGA(islands=3, population=6, max_generations=8, polish_interval=3).options
        self._affine = Affine(self.problem)

    @property
    def stopped(self) -> bool:
        """Whether somebody stopped the search, or its time is over."""
        return self.found[-1].status in _STOPPED or self.seconds_left() <= 0.0

    @cached_property
    def _whole(self) -> ReducedProblem:
        """For the whole box, around its middle, reductions at their nominal values."""
        problem, (low, high) = self.problem, self.problem.bounds.T
        reductions = np.array([p.quantity == "stiffness_reduction" for p in problem.parameters])
        middle = np.where(reductions, np.clip(problem.nominal, low, high), 0.5 * (low + high))
        return self._reduced(middle, 1.0, _DEPTH, _FINER)

    def run(self, start: FloatArray) -> _Answer:
        """The answer that a search from ``start`` ends at."""
        options = self._descent if self.found else None
        return self._settled(self._answer(self._whole, self._around(start, 1.0), start, options))

    def agreed(self, start: FloatArray) -> _Answer:
        """The answer from ``start``; unless it explains all, the best of it and others until two agree."""
        best = self.run(start)
        low, high = self.problem.bounds.T
        for _ in range(_ATTEMPTS):
            if best.unexplained <= _EXACT or self.stopped:
                return best
            other = self.run(self.rng.uniform(low, high))
            agreed = bool(np.all(np.abs(other.x - best.x) <= _AT_ONE_PLACE * (high - low)))
            if other.cost < best.cost:
                best = other
            if agreed:
                break
        if best.unexplained <= _EXACT or self.stopped:
            return best
        there = self._answer(best.reduced, self._around(best.x, _AROUND), best.x, self._look)
        return self._settled(there) if there.cost < _BETTER * best.cost else best

    def _settled(self, best: _Answer) -> _Answer:
        """Where descents from ``best`` end, full and reduced model in agreement."""
        trust, rounds, reduced, close = _WIDE_TRUST, 1, best.reduced, _CLOSE
        while trust >= _LEAST_TRUST and not self._agrees(best) and not self.stopped:
            if best.reduced is reduced:  # it has moved since the last basis or correction
                fresh = best.difference > close
                if fresh and rounds == self.reduction.rounds:
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
        return found.reduced.is_corrected and found.difference <= self.reduction.tolerance

    def _around(self, x: FloatArray, share: float) -> tuple[FloatArray, FloatArray]:
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
        self.found.append(self.minimize(reduced.core, *box, near, options))
        answer = _Answer(self.problem, reduced, self.found[-1].x, self.found[-1].fun)
        if self.best is None or answer.cost < self.best.cost:
            self.best = answer
        return answer

    def _reduced(
        self, x: FloatArray, share: float, depth: int = _DEPTH_THERE, finer: float = 1.0
    ) -> ReducedProblem:
        """For that share of the parameters' ranges around ``x``."""
        self.bases += 1
        half_widths = 0.5 * share * np.diff(self.problem.bounds)[:, 0]
        largest = self.reduction.size, finer * self.reduction.least
        return ReducedProblem(self._affine, basis_at(self._affine, x, half_widths, depth, largest))
