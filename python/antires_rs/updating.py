"""Model updating with antiresonances, and damage assessment.

The objective (Meruane, J. Sound Vib. 332 (2013) 807-820, Eqs. 11-17, with the misprinted exponent
of Eq. 11 put right) is evaluated in the Rust core:

.. math:: J = \\sum \\left|\\frac{\\omega_A^2}{\\omega_E^2} - 1\\right|
          + \\gamma_1 \\sum \\beta_i + \\gamma_2 \\, \\mathrm{count}(\\beta_i > 0)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from . import _core
from ._progress import watched
from ._validation import FloatArray, choice, finite_scalar, integer, real_array, reject, shape_of
from .antiresonance_set import AntiresonanceSet
from .models import StructuralModel
from .optimizer import IslandGA, OptimizeResult, guesses, seed_of, thread_count
from .parameters import Parameter, core_parameters, parameter_name, stiffness_reduction
from .results import DamageResult, UpdateResult
from .weights import residual_weights

Misfit = Literal["absolute", "squared", "largest"]

__all__ = ["DamagePenalty", "UpdatingProblem", "assess_damage", "update"]


@dataclass(frozen=True)
class DamagePenalty:
    """Preference for few damaged elements: ``gamma1 * sum(beta) + gamma2 * count(beta > 0)``.

    Attributes
    ----------
    gamma1, gamma2 : float
        Weights, at least 0; the paper's are 0.1 each.
    snap : float
        Severities below it count as exactly 0, and are evaluated as 0; within [0, 1e-3]. 0 is the
        algorithm as printed.
    """

    gamma1: float = 0.1
    gamma2: float = 0.1
    snap: float = 1e-3

    def __post_init__(self) -> None:
        finite_scalar("gamma1", self.gamma1, low=0.0)
        finite_scalar("gamma2", self.gamma2, low=0.0)
        finite_scalar("snap", self.snap, low=0.0, high=1e-3)


class UpdatingProblem:
    """A model, what may change in it, and what was measured.

    Parameters
    ----------
    model : MassSpringChain, FrameModel or MatrixModel
        The nominal model. Measured dofs are its zero-based dofs.
    parameters : sequence of Parameter
        Unknowns, from :func:`stiffness_factor`, :func:`mass_factor`, :func:`stiffness_reduction`, and for
        frames :func:`thickness`, :func:`youngs_modulus`, :func:`angle` and the others; all mix.
    measured : AntiresonanceSet or sequence of AntiresonanceSet
        Measured antiresonances, one set for each position of the force; each value is paired, at every
        evaluation, with the model's nearest of the same response and force.
    objective : {'antiresonance'}
        What is compared with the measurement.
    misfit : {'absolute', 'squared', 'largest'}
        Sum of abs(e), the paper's, which a few wrong values do not move; sum of e**2, which shares out a
        contradiction that no model resolves; or the largest abs(e).
    penalty : DamagePenalty or (gamma1, gamma2), optional
        Applied to the stiffness reductions.
    weights : 'std' or array_like (m,), optional
        Factors on the residuals. 'std' takes them from the standard deviations of the measured values, with
        0.2 % for the error of the model, so that what is known badly counts less. Default: all one.

    Attributes
    ----------
    bounds : ndarray, (n, 2)
    names : list of str
    measured_hz : ndarray, (m,)
        Measured values, dof by dof.
    measured_dofs, measured_excitations : ndarray of int, (m,)
        Response and force of each.
    weights : ndarray, (m,), or None

    Raises
    ------
    InvalidInputError
        Dofs outside the model, no antiresonance, a parameter that changes nothing, bounds within which
        stiffness or mass becomes indefinite.

    Examples
    --------
    >>> import antires_rs as ar
    >>> chain = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 500.0])
    >>> measured = ar.AntiresonanceSet(0, {0: [1.6, 5.2], 1: [2.6]})
    >>> problem = ar.UpdatingProblem(chain, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), measured)
    >>> round(problem.cost([1.0, 1.0]), 3)
    0.216
    """

    def __init__(self, model: StructuralModel, parameters: Iterable[Parameter] | Parameter,
                 measured: AntiresonanceSet | Sequence[AntiresonanceSet], *,
                 objective: Literal["antiresonance"] = "antiresonance", misfit: Misfit = "absolute",
                 penalty: DamagePenalty | tuple[float, float] | None = None, weights: Any = None) -> None:
        if not isinstance(model, StructuralModel):
            reject("model", model, "a MassSpringChain, FrameModel or MatrixModel")
        self.parameters = _parameters(parameters)
        self.model, self.measured = model, _sets(measured)
        self.penalty = _penalty(penalty)
        choice("misfit", misfit, ("absolute", "squared", "largest"))
        self.misfit = misfit
        targets = [(self._model_dof("measured dof", dof), self._model_dof("excitation", each.excitation),
                    np.array(freq)) for each in self.measured for dof, freq in each.items()]
        counts = [len(freq) for _, _, freq in targets]
        self.measured_hz = np.concatenate([np.empty(0), *(freq for _, _, freq in targets)])
        self.measured_dofs = np.repeat([dof for dof, _, _ in targets], counts)
        self.measured_excitations = np.repeat([force for _, force, _ in targets], counts)
        self.weights = residual_weights(weights, self.measured, self.measured_hz)
        self.bounds = np.array([p.bounds for p in self.parameters], dtype=np.float64).reshape(-1, 2)
        parts = core_parameters(model, self.parameters)
        self._nominal = _core.nominal_values(model._core, parts)
        _core.check_bounds(model._core, parts, self.bounds[:, 0].copy(), self.bounds[:, 1].copy())
        self.names = [parameter_name(model, p) for p in self.parameters]
        self._core = _core.AntiresonanceObjective(
            model._core, parts, targets, misfit,
            (self.penalty.gamma1, self.penalty.gamma2) if self.penalty else None,
            self.penalty.snap if self.penalty else 0.0, self.weights)

    def _model_dof(self, name: str, label: Any) -> int:
        if isinstance(label, str):
            reject(name, repr(label), f"a zero-based dof of the model, 0..{self.model.n_dof - 1}",
                   "Name the channels by the model's dofs: Recording(..., dofs=[0, 1, ...]).")
        return integer(name, label, low=0, high=self.model.n_dof - 1)

    @property
    def nominal(self) -> FloatArray:
        """Parameter values of the model as it was given, (n,)."""
        return self._nominal.copy()

    def cost(self, x: Any) -> float:
        """Objective J at ``x`` (n,); finite for every x in bounds."""
        return self._core.cost(self._vector(x))

    def paired_hz(self, x: Any) -> FloatArray:
        """The model's antiresonance paired with each measured one at ``x``, (m,) Hz; NaN without one."""
        return self._core.pairs(self._core.repaired(self._vector(x)))

    def residuals(self, x: Any) -> FloatArray:
        """Signed residuals ``e = w_A**2 / w_E**2 - 1`` at ``x``, (m,); 1 where there is no partner."""
        paired = self.paired_hz(x)
        return np.where(np.isnan(paired), 1.0, (paired / self.measured_hz) ** 2 - 1.0)

    def evaluate_many(self, candidates: Any, workers: int | None = None) -> FloatArray:
        """Objective of each row of ``candidates`` (m, n), (m,), in parallel, the GIL released."""
        n = len(self.parameters)
        rows = real_array("candidates", candidates, ndim=2, wanted=f"an array (m, {n}), one candidate a row")
        if rows.shape[1] != n:
            reject("candidates", f"shape {rows.shape}", f"(m, {n})")
        return self._core.evaluate_many(rows, thread_count(workers))

    def model_at(self, x: Any) -> StructuralModel:
        """The model with parameters ``x`` applied."""
        return self.model._with_core(self._core.model_at(self._core.repaired(self._vector(x))),
                                     (self, self._vector(x).copy()))

    def _vector(self, x: Any) -> FloatArray:
        n = len(self.parameters)
        vector = real_array("x", x, ndim=1, wanted=f"an array ({n},), one value for each parameter")
        if vector.size != n:
            reject("x", f"{vector.size} values", f"{n}, one for each parameter")
        return vector

    def __repr__(self) -> str:
        return f"UpdatingProblem({len(self.parameters)} parameters, {self.measured_hz.size} antiresonances)"


def update(problem: UpdatingProblem, *, optimizer: IslandGA | None = None,
           rng: int | np.random.Generator | None = None, workers: int | None = None,
           callback: Callable[[dict[str, Any]], bool | None] | None = None, x0: Any = None,
           progress: bool | None = None) -> UpdateResult:
    """Find the parameters that bring the model's antiresonances to the measured ones.

    Parameters
    ----------
    problem : UpdatingProblem
    optimizer : IslandGA, optional
        Settings of the search.
    rng : int or numpy.random.Generator, optional
        Same seed, same bits, whatever the number of threads.
    workers : int, optional
        Threads; all processors by default.
    callback : callable, optional
        Called after each generation with a dict (``nit, nfev, fun, x, islands, migrations``); return True
        to stop.
    x0 : array_like, (n,) or (m, n), optional
        Guesses that join the initial populations.
    progress : bool, optional
        Show progress on standard error; by default on a terminal, after one second.

    Returns
    -------
    UpdateResult
        Also when a budget or Ctrl-C ended the run: the best so far, with a status that says so.

    Raises
    ------
    InvalidInputError
        Something that is not an UpdatingProblem, a guess outside the bounds.

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
        reject("problem", problem, "an UpdatingProblem")
    found, seed = _search(problem, optimizer, rng, workers, callback, x0, progress)
    return UpdateResult(problem, found, seed)


def assess_damage(model: StructuralModel, measured: AntiresonanceSet | Sequence[AntiresonanceSet], *,
                  elements: Any = None,
                  gamma1: float = 0.1, gamma2: float = 0.1, snap: float = 1e-3, weights: Any = None,
                  optimizer: IslandGA | None = None, rng: int | np.random.Generator | None = None,
                  workers: int | None = None,
                  callback: Callable[[dict[str, Any]], bool | None] | None = None, x0: Any = None,
                  progress: bool | None = None) -> DamageResult:
    """Locate and size damage: the stiffness loss of each element that explains the measurement.

    Parameters
    ----------
    model : MassSpringChain, FrameModel or MatrixModel
        The undamaged structure, best updated first on an undamaged measurement.
    measured : AntiresonanceSet or sequence of AntiresonanceSet
        Antiresonances of the structure as it is now, one set for each position of the force.
    elements : sequence of int, optional
        Candidate elements, zero-based. Default: all springs between masses, all beams,
        all stiffness terms.
    gamma1, gamma2 : float
        Penalties on the sum and the number of damages; small damage costs more than it explains, see
        ``DamageResult.detectable``.
    snap : float
        Severities below count as exactly 0; within [0, 1e-3], 0 for the algorithm as printed.
    weights : 'std' or array_like, optional
        As for :class:`UpdatingProblem`.
    optimizer, rng, workers, callback, x0, progress
        As in :func:`update`.

    Returns
    -------
    DamageResult
        ``.severity`` {element: beta}, ``.detectable`` {element: smallest visible beta}.

    Raises
    ------
    InvalidInputError
        An element outside the model or listed twice, measured dofs outside the model.

    Examples
    --------
    >>> import antires_rs as ar
    >>> intact = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 500.0, 500.0])
    >>> damaged = ar.MassSpringChain([1.0, 1.0, 1.0, 1.0], [500.0, 300.0, 500.0])
    >>> measured = ar.AntiresonanceSet(0, dict(enumerate(damaged.antiresonances([0, 1, 2, 3], 0))))
    >>> result = ar.assess_damage(intact, measured, rng=0)
    >>> {element: round(beta, 2) for element, beta in result.severity.items()}
    {0: 0.0, 1: 0.4, 2: 0.0}
    """
    if not isinstance(model, StructuralModel):
        reject("model", model, "a MassSpringChain, FrameModel or MatrixModel")
    chosen = model.default_elements if elements is None else (
        [elements] if shape_of(elements) == () else list(elements))
    if not chosen:
        reject("elements", "no candidate", "at least one stiffness term",
               "Give the MatrixModel its stiffness_terms.")
    penalty = DamagePenalty(gamma1, gamma2, snap)
    problem = UpdatingProblem(model, stiffness_reduction(chosen), measured, penalty=penalty, weights=weights)
    found, seed = _search(problem, optimizer, rng, workers, callback, x0, progress)
    return DamageResult(problem, found, seed)


def _search(problem: UpdatingProblem, optimizer: IslandGA | None, rng: Any, workers: int | None,
            callback: Callable[[dict[str, Any]], bool | None] | None, x0: Any,
            progress: bool | None) -> tuple[OptimizeResult, int]:
    ga = IslandGA() if optimizer is None else optimizer
    if not isinstance(ga, IslandGA):
        reject("optimizer", optimizer, "an IslandGA")
    seed = seed_of(rng)
    with watched(callback, progress, ga.options["max_evaluations"]) as watcher:
        raw = problem._core.minimize(
            problem.bounds[:, 0].copy(), problem.bounds[:, 1].copy(), guesses(x0, len(problem.parameters)),
            ga.options, seed, thread_count(workers), ga.max_seconds, watcher)
    return OptimizeResult._of(raw, ga), seed


def _sets(measured: Any) -> tuple[AntiresonanceSet, ...]:
    sets = (measured,) if isinstance(measured, AntiresonanceSet) else measured
    if not isinstance(sets, Sequence) or not sets or not all(isinstance(s, AntiresonanceSet) for s in sets):
        reject("measured", measured, "an AntiresonanceSet, or one for each position of the force")
    return tuple(sets)


def _parameters(parameters: Iterable[Parameter] | Parameter) -> tuple[Parameter, ...]:
    wanted = "Parameters, from stiffness_factor, mass_factor, stiffness_reduction and the like"
    if isinstance(parameters, Parameter):
        return (parameters,)
    try:
        chosen = tuple(parameters)
    except TypeError:
        reject("parameters", parameters, wanted)
    for i, parameter in enumerate(chosen):
        if not isinstance(parameter, Parameter):
            reject(f"parameters[{i}]", parameter, wanted, "Join lists with +, without nesting them.")
    return chosen


def _penalty(penalty: Any) -> DamagePenalty | None:
    if penalty is None or isinstance(penalty, DamagePenalty):
        return penalty
    if np.shape(penalty) != (2,):
        reject("penalty", penalty, "a DamagePenalty, a pair (gamma1, gamma2) or None")
    return DamagePenalty(*penalty)
