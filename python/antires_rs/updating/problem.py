"""An updating problem: a model, what may change in it, what was measured, and what damage costs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass
from typing import Any, Literal, get_args

import numpy as np

from .. import _core
from .._core import __version__
from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.parameters import Parameter, parameter_name, parameter_tuple, warn_far
from ..models.structural_model import StructuralModel, checked_model
from ..optimize.checkpoint import digest_of
from ..optimize.island_ga import thread_count
from ..support.checks import FloatArray, IntArray, choice, finite_scalar, integer, real_array, shape_of
from ..support.values import AroundCore, ReadOnly, frozen, frozen_or_none
from .targets import FrequencyTable, ModalTable, ModalTargets, Targets, targets_of

Misfit = Literal["absolute", "squared", "largest"]

_PAPER, _PAPER_VALUES = 0.1, 28  # the paper's factors, and the number of antiresonances of its chain
_SNAP = 1e-3  # severities below it count as exactly 0


@dataclass(frozen=True)
class DamagePenalty:
    """Preference for few damaged elements: ``gamma1 * sum(beta) + gamma2 * count(beta > 0)``.

    Attributes
    ----------
    gamma1, gamma2 : float
        Weights, at least 0; the paper's are 0.1 each, whatever was measured. See also :meth:`scaled`.
    snap : float
        Severities below it are evaluated as 0; within [0, 1e-3]. 0 is the algorithm as printed.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.DamagePenalty(gamma1=0.05)
    DamagePenalty(gamma1=0.05, gamma2=0.1, snap=0.001)
    """

    gamma1: float = _PAPER
    gamma2: float = _PAPER
    snap: float = _SNAP

    def __post_init__(self) -> None:
        finite_scalar("gamma1", self.gamma1, low=0.0)
        finite_scalar("gamma2", self.gamma2, low=0.0)
        finite_scalar("snap", self.snap, low=0.0, high=1e-3)

    @property
    def prices(self) -> tuple[float, float]:
        """Of a unit of loss, and of each damaged element."""
        return self.gamma1, self.gamma2

    @property
    def text(self) -> str:
        """The prices by name."""
        return f"gamma1 = {self.gamma1:.3g} and gamma2 = {self.gamma2:.3g}"

    @classmethod
    def scaled(
        cls,
        weights: Any,
        misfit: Misfit = "absolute",
        *,
        gamma1: float | None = None,
        gamma2: float | None = None,
        snap: float = _SNAP,
    ) -> DamagePenalty:
        """Penalties that grow with the number of measured values and with their weights.

        Both are the misfit of a difference e = 0.1 / 28 = 0.36 % in every omega**2, which an element has to
        explain on average: ``sum(w) e`` for an absolute misfit, the paper's 0.1 on its chain of 28 values;
        ``sum(w**2) e**2`` for a squared one; ``max(w) e`` for the largest. A mode counts as two values.
        ``weights`` are theirs (m,), or their number; ``gamma1`` and ``gamma2`` are taken as given.

        Examples
        --------
        >>> import antires_rs as ar
        >>> ar.DamagePenalty.scaled([2.0, 0.5, 0.5, 1.0] * 7, gamma2=0.2)
        DamagePenalty(gamma1=0.1, gamma2=0.2, snap=0.001)
        """
        choice("misfit", misfit, get_args(Misfit))
        if shape_of(weights) == ():
            w = np.ones(integer("weights", weights, low=1))
        else:
            wanted = "a number of values, or the weight of each"
            w = real_array("weights", weights, ndim=1, wanted=wanted)
            if w.min() < 0.0 or not w.any():
                got = f"{w.size} numbers from {w.min():g} to {w.max():g}"
                reject("weights", got, f"{wanted}, at least 0", "Pass how many values are compared.")
        if misfit == "squared":
            unit = float(np.sum(w**2) * (_PAPER / _PAPER_VALUES) ** 2)
        else:
            unit = float((w.sum() if misfit == "absolute" else w.max()) * _PAPER / _PAPER_VALUES)
        return cls(unit if gamma1 is None else gamma1, unit if gamma2 is None else gamma2, snap)


def penalty_of(given: Any, weights: FloatArray, misfit: Misfit) -> DamagePenalty | None:
    """The penalty in force of what an UpdatingProblem was given; ``weights``, one for each residual."""
    if given is None or isinstance(given, DamagePenalty):
        return given
    if isinstance(given, str) and given == "scaled":
        given = (None, None)
    if shape_of(given) not in ((2,), (3,)):
        wanted = "a DamagePenalty, 'scaled', a pair (gamma1, gamma2) or None"
        reject("penalty", given, wanted, "Write it as in penalty=(0.1, 0.1).")
    gamma1, gamma2, snap = (*given, _SNAP)[:3]
    return DamagePenalty.scaled(weights, misfit, gamma1=gamma1, gamma2=gamma2, snap=snap)


Measured = AntiresonanceSet | ModalSet | Sequence[AntiresonanceSet] | Sequence[ModalSet]


class UpdatingProblem(AroundCore[_core.Objective], ReadOnly):
    """A model, what may change in it, and what was measured. Read-only.

    Parameters
    ----------
    model : MassSpringChain, FrameModel or MatrixModel
        The nominal model. Measured dofs are its zero-based dofs.
    parameters : sequence of Parameter
        Unknowns, from :func:`stiffness_factor`, :func:`mass_factor`, :func:`stiffness_reduction`, and for
        frames :func:`thickness`, :func:`youngs_modulus`, :func:`angle` and the others; all mix.
    measured : AntiresonanceSet, ModalSet, or several of one kind
        Measured antiresonances, one set for each position of the force; each value is paired, at every
        evaluation, with the model's nearest of the same response and force that the set can show (``sees``);
        halves of complex zeros are left out. Or modes, one set for all sensors that measured together, real
        or complex; rigid-body modes, at 0 Hz, are left out.
    objective : {'antiresonance', 'modal'}, optional
        What is compared with the measurement. Default: what was measured.
    misfit : {'absolute', 'squared', 'largest'}
        Sum of abs(e), the paper's, which a few wrong values do not move; sum of e**2, which shares out a
        contradiction that no model resolves; or the largest abs(e). Shapes always count by sum((1 - MAC)**2).
    penalty : DamagePenalty, 'scaled' or (gamma1, gamma2), optional
        Applied to the stiffness reductions. 'scaled', or None in place of a number, takes what
        :meth:`DamagePenalty.scaled` gives for these values and weights.
    weights : 'std' or array_like (m,), optional
        Factors on the residuals; for modes one each, on e and on 1 - MAC. 'std' takes them from the standard
        deviations of measured antiresonances, with 0.2 % for the error of the model. Default: all one.

    Attributes
    ----------
    bounds, names, noun : ndarray, (n, 2), list of str, and 'antiresonance' or 'mode'
    measured_hz, weights : ndarray, (m,)
        Measured values, dof by dof, and their factors, None where these are all one.
    measured_dofs, measured_excitations : ndarray of int, (m,), or None
        Response and force of each; None for modes.
    penalty, left_out : DamagePenalty or None, and tuple of str
        The numbers in force; a sentence on each measured value that is not compared, and why.

    Raises
    ------
    InvalidInputError
        Dofs outside the model, a parameter that changes nothing, bounds at which K or M becomes indefinite.

    Notes
    -----
    Partners are sought up to 1.5 times the highest measured frequency; from 1.49 times on they fade out, so
    that J does not jump. A measured mode is paired with the mode of least ``abs(log(w_A**2 / w_E**2)) + (1 -
    MAC)**2``, the lower of equals; one mode of the model may serve several. For a repeated mode the MAC is
    that of the most alike combination of its shapes. What has no partner counts 1, a mode twice.

    Examples
    --------
    >>> import antires_rs as ar
    >>> chain = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 500.0])
    >>> measured = ar.AntiresonanceSet(0, {0: [1.6, 5.2], 1: [2.6]})
    >>> problem = ar.UpdatingProblem(chain, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), measured)
    >>> problem.paired_hz([1.0, 1.0]).round(2)
    array([1.67, 5.37, 2.52])
    """

    model: StructuralModel
    parameters: tuple[Parameter, ...]
    measured: tuple[Any, ...]
    noun: str
    misfit: Misfit
    penalty: DamagePenalty | None
    bounds: FloatArray
    measured_hz: FloatArray
    measured_dofs: IntArray | None
    measured_excitations: IntArray | None
    weights: FloatArray | None
    left_out: tuple[str, ...]
    _targets: Targets
    _nominal: FloatArray
    _names: tuple[str, ...]

    def __init__(
        self,
        model: StructuralModel,
        parameters: Iterable[Parameter] | Parameter,
        measured: Measured,
        *,
        objective: Literal["antiresonance", "modal"] | None = None,
        misfit: Misfit = "absolute",
        penalty: DamagePenalty | Literal["scaled"] | tuple[float | None, ...] | None = None,
        weights: Any = None,
    ) -> None:
        chosen = parameter_tuple(parameters)
        if objective is not None:
            choice("objective", objective, ("antiresonance", "modal"))
        choice("misfit", misfit, get_args(Misfit))
        targets = targets_of(checked_model(model), measured, objective)
        bounds = np.array([p.bounds for p in chosen], dtype=np.float64).reshape(-1, 2)
        parts = model.description.core_parameters(chosen)
        nominal = _core.nominal_values(model._core, parts)
        _core.check_bounds(model._core, parts, bounds[:, 0].copy(), bounds[:, 1].copy())
        names = tuple(parameter_name(model, p) for p in chosen)
        warn_far(chosen, names, nominal)
        factors = targets.weights(weights)
        counted = np.ones(targets.hz.size) if factors is None else factors
        if targets.noun == "mode":
            counted = np.tile(counted, 2)  # each has two residuals
        self._fill(model=model, parameters=chosen, misfit=misfit, bounds=frozen(bounds))
        self._fill(measured=targets.sets, noun=targets.noun, left_out=targets.left_out, _targets=targets)
        self._fill(measured_hz=frozen(targets.hz), _nominal=frozen(nominal), _names=names)
        dofs, forces = (frozen_or_none(getattr(targets, name, None)) for name in ("dofs", "excitations"))
        self._fill(measured_dofs=dofs, measured_excitations=forces, weights=frozen_or_none(factors))
        self._fill(penalty=penalty_of(penalty, counted, misfit))
        self._fill(_core=self._made_core())

    def _made_core(self) -> _core.Objective:
        parameters = self.model.description.core_parameters(self.parameters)
        return self._targets.core(self.model, parameters, *self._weighing)

    @property
    def _weighing(self) -> tuple[Misfit, tuple[float, float] | None, float, FloatArray | None]:
        """How the core weighs residuals and damage: misfit, prices, snap, weights."""
        prices, snap = (None, 0.0) if self.penalty is None else (self.penalty.prices, self.penalty.snap)
        return self.misfit, prices, snap, self.weights

    @property
    def names(self) -> list[str]:
        """Parameters by name, in the order of ``x``."""
        return list(self._names)

    @property
    def objective(self) -> str:
        """What is compared: ``'antiresonance'`` or ``'modal'``."""
        return self._targets.objective

    @property
    def nominal(self) -> FloatArray:
        """Parameter values of the model as it was given, (n,)."""
        return self._nominal.copy()

    def cost(self, x: Any) -> float:
        """Objective J at ``x`` (n,); finite for every x in bounds."""
        return self._core.cost(self._vector(x))

    def paired_hz(self, x: Any) -> FloatArray:
        """The model's frequency paired with each measured one at ``x``, (m,) Hz; NaN without one."""
        return self._core.pairs(self._repaired(x))[0]

    def paired_mac(self, x: Any) -> FloatArray:
        """MAC of each measured mode with its partner at ``x``, (m,); NaN without one."""
        if not isinstance(self._targets, ModalTargets):
            reject("measured", "antiresonances", "modes, as a ModalSet", "Antiresonances have no shape.")
        return self._targets.pairs(self._core, self._repaired(x))[1]

    def residuals(self, x: Any) -> FloatArray:
        """Signed residuals at ``x``, before any weights.

        ``e = w_A**2 / w_E**2 - 1``, (m,), and for modes after these the m of ``1 - MAC``; 1 where there is no
        partner.
        """
        return self._targets.residuals(self._core, self._repaired(x))

    def evaluate_many(self, candidates: Any, workers: int | None = None) -> FloatArray:
        """Objective of each row of ``candidates`` (m, n), (m,), in parallel, the GIL released."""
        n = len(self.parameters)
        wanted = f"an array (m, {n}), one candidate a row"
        rows = real_array("candidates", candidates, ndim=2, wanted=wanted)
        if rows.shape[1] != n:
            reject("candidates", f"shape {rows.shape}", wanted, "Give a column for each parameter.")
        return self._core.evaluate_many(rows, thread_count(workers))

    def model_at(self, x: Any) -> StructuralModel:
        """The model with parameters ``x`` applied."""
        return self.model.with_parameters(self.parameters, self._repaired(x))

    def _repaired(self, x: Any) -> FloatArray:
        return self._core.repaired(self._vector(x))

    def _table(self, x: FloatArray) -> FrequencyTable | ModalTable:
        return self._targets.table(self._core, self._repaired(self._nominal), self._repaired(x))

    def _vector(self, x: Any) -> FloatArray:
        n = len(self.parameters)
        vector = real_array("x", x, ndim=1, wanted=f"an array ({n},), one value for each parameter")
        if vector.size != n:
            reject("x", f"{vector.size} values", f"{n}, one for each parameter", "See problem.names.")
        return vector

    def __repr__(self) -> str:
        return f"UpdatingProblem({len(self.parameters)} parameters, {self.measured_hz.size} {self.noun}s)"


def fingerprint(problem: UpdatingProblem, options: dict[str, Any], guesses: list[list[float]]) -> bytes:
    """32 bytes that tell this search from any other: model, parameters, data, objective and options."""
    # Inside the bounds every parameter, and all that it acts on, shows in the matrices; what else was
    # measured and how it is weighed shows in the residuals and the cost.
    low, high = problem.bounds.T
    points = (problem.nominal, low + 0.37 * (high - low))
    cores = [model._core for model in (problem.model, problem.model_at(points[1]))]
    matrices = [a.tobytes() for core in cores for matrix in (core.stiffness(), core.mass()) for a in matrix]
    parameters = problem.bounds.tobytes(), [astuple(p) for p in problem.parameters]
    weighing = problem.measured_hz.tobytes(), problem.misfit, problem.penalty
    answers = [problem.residuals(x).tobytes() for x in points] + [problem.cost(x).hex() for x in points]
    stated = __version__, problem.objective, *parameters, *weighing, sorted(options.items()), guesses
    return digest_of(*matrices, *stated, *answers)
