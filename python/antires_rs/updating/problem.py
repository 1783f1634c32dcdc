"""Model updating with antiresonances, or with resonances and mode shapes, and damage assessment.

The objective (Meruane, J. Sound Vib. 332 (2013) 807-820, Eqs. 11-17, with the misprinted exponent
of Eq. 11 put right) is evaluated in the Rust core:

.. math:: J = \\sum \\left|\\frac{\\omega_A^2}{\\omega_E^2} - 1\\right|
          + \\gamma_1 \\sum \\beta_i + \\gamma_2 \\, \\mathrm{count}(\\beta_i > 0)

For comparison, with resonances in place of antiresonances, Eq. 18 adds the shapes:
:math:`\\sum (1 - \\mathrm{MAC})^2`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.parameter import Parameter, parameter_tuple
from ..models.parameter_names import parameter_name, warn_far
from ..models.structural_model import StructuralModel
from ..optimize.arguments import thread_count
from ..support.pickling import AroundCore, ReadOnly, frozen
from ..support.validation import FloatArray, choice, real_array, reject
from ..support.values import frozen_or_none
from .penalty import DamagePenalty, Misfit, penalty_of
from .tables import FrequencyTable, ModalTable
from .targets import AntiresonanceTargets, ModalTargets, Targets, targets_of

Measured = AntiresonanceSet | ModalSet | Sequence[AntiresonanceSet] | Sequence[ModalSet]

__all__ = ["UpdatingProblem"]


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
        evaluation, with the model's nearest of the same response and force that the set can show, see
        ``AntiresonanceSet.sees``; halves of complex zeros are left out (``left_out``). Or modes, one set for
        all sensors that measured together, real or complex, at as many or few dofs as there were;
        rigid-body modes, at 0 Hz, are left out. For their pairing see Notes.
    objective : {'antiresonance', 'modal'}, optional
        What is compared with the measurement. Default: what was measured.
    misfit : {'absolute', 'squared', 'largest'}
        Sum of abs(e), the paper's, which a few wrong values do not move; sum of e**2, which shares out a
        contradiction that no model resolves; or the largest abs(e). Shapes always count by
        sum((1 - MAC)**2).
    penalty : DamagePenalty, 'scaled' or (gamma1, gamma2), optional
        Applied to the stiffness reductions. 'scaled', or None in place of a number, takes what
        :meth:`DamagePenalty.scaled` gives for these values and weights.
    weights : 'std' or array_like (m,), optional
        Factors on the residuals; for modes one each, on e and on 1 - MAC. 'std' takes them from the standard
        deviations of measured antiresonances, with 0.2 % for the error of the model, so that what is known
        badly counts less. Default: all one.

    Attributes
    ----------
    bounds : ndarray, (n, 2)
    names : list of str
    measured_hz : ndarray, (m,)
        Measured values, dof by dof.
    measured_dofs, measured_excitations : ndarray of int, (m,), or None
        Response and force of each; None for modes.
    noun : {'antiresonance', 'mode'}
        What was measured.
    weights : ndarray, (m,), or None
    penalty : DamagePenalty or None
        The numbers in force.
    left_out : tuple of str
        A sentence on each measured value that is not compared, and why.

    Raises
    ------
    InvalidInputError
        Dofs outside the model, nothing measured, a parameter that changes nothing, bounds within which
        stiffness or mass becomes indefinite.

    Notes
    -----
    The model is asked for antiresonances up to 1.5 times the highest measured frequency. A partner between
    1.49 and 1.5 times fades out, so that J does not jump where one leaves the band: e passes evenly to the
    abs(e) that there is without it, which is 1 where no other antiresonance is left.

    A measured mode is paired, at every evaluation, with the mode of the model that is least apart:
    ``abs(log(w_A**2 / w_E**2)) + (1 - MAC)**2`` decides, ties go to the lower, one mode of the model may
    serve several measured ones, and those up to 1.5 times the highest measured frequency are at choice. So
    the shapes decide among modes of like frequency, as where two have changed places; but they make up for
    a factor of 1.65 in frequency at most, so that no mode far away, and no rigid-body mode, takes a partner
    from a nearer one because the two look alike at a few sensors. For a repeated mode of the model the MAC
    is that of the most alike combination of its shapes. A measured mode without a partner counts 1 for its
    frequency and 1 for its shape.

    Examples
    --------
    >>> import antires_rs as ar
    >>> chain = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 500.0])
    >>> measured = ar.AntiresonanceSet(0, {0: [1.6, 5.2], 1: [2.6]})
    >>> problem = ar.UpdatingProblem(chain, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), measured)
    >>> round(problem.cost([1.0, 1.0]), 3)
    0.216
    >>> modes = ar.ModalSet([3.2, 5.2], [[1.0, 0.6, -0.8], [-0.5, 1.0, -0.25]], dofs=[0, 1, 2])
    >>> problem = ar.UpdatingProblem(chain, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), modes)
    >>> problem.paired_hz([1.0, 1.0]).round(2), problem.paired_mac([1.0, 1.0]).round(2)
    (array([3.02, 5.93]), array([0.95, 1.  ]))
    """

    model: StructuralModel
    parameters: tuple[Parameter, ...]
    measured: tuple[Any, ...]
    noun: str
    misfit: Misfit
    penalty: DamagePenalty | None
    bounds: FloatArray
    measured_hz: FloatArray
    measured_dofs: NDArray[np.intp] | None
    measured_excitations: NDArray[np.intp] | None
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
        if not isinstance(model, StructuralModel):
            reject(
                "model",
                model,
                "a MassSpringChain, FrameModel or MatrixModel",
                "Build the model as one of these first.",
            )
        chosen = parameter_tuple(parameters)
        if objective is not None:
            choice("objective", objective, ("antiresonance", "modal"))
        choice("misfit", misfit, ("absolute", "squared", "largest"))
        targets = targets_of(model, measured, objective)
        by_force = targets if isinstance(targets, AntiresonanceTargets) else None
        bounds = np.array([p.bounds for p in chosen], dtype=np.float64).reshape(-1, 2)
        parts = model.description.core_parameters(chosen)
        nominal = _core.nominal_values(model._core, parts)
        _core.check_bounds(model._core, parts, bounds[:, 0].copy(), bounds[:, 1].copy())
        names = tuple(parameter_name(model, p) for p in chosen)
        warn_far(chosen, names, nominal)
        factors = targets.weights(weights)
        counted = np.ones(targets.hz.size) if factors is None else factors
        if isinstance(targets, ModalTargets):
            counted = np.tile(counted, 2)  # a mode has two residuals
        self._fill(
            model=model,
            parameters=chosen,
            measured=targets.sets,
            noun=targets.noun,
            misfit=misfit,
            penalty=penalty_of(penalty, counted, misfit),
            bounds=frozen(bounds),
            measured_hz=frozen(targets.hz),
            measured_dofs=frozen_or_none(by_force and by_force.dofs),
            measured_excitations=frozen_or_none(by_force and by_force.excitations),
            weights=frozen_or_none(factors),
            left_out=targets.left_out,
            _targets=targets,
            _nominal=frozen(nominal),
            _names=names,
        )
        self._fill(_core=self._made_core())

    def _made_core(self) -> _core.Objective:
        prices = (self.penalty.gamma1, self.penalty.gamma2) if self.penalty else None
        return self._targets.core(
            self.model,
            self.model.description.core_parameters(self.parameters),
            self.misfit,
            prices,
            self.penalty.snap if self.penalty else 0.0,
            self.weights,
        )

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
        return self._targets.mac(self._core, self._repaired(x))

    def residuals(self, x: Any) -> FloatArray:
        """Signed residuals at ``x``, before any weights.

        ``e = w_A**2 / w_E**2 - 1``, (m,), and for modes after these the m of ``1 - MAC``; 1 where there is no
        partner.
        """
        return self._targets.residuals(self._core, self._repaired(x))

    def evaluate_many(self, candidates: Any, workers: int | None = None) -> FloatArray:
        """Objective of each row of ``candidates`` (m, n), (m,), in parallel, the GIL released."""
        n = len(self.parameters)
        rows = real_array("candidates", candidates, ndim=2, wanted=f"an array (m, {n}), one candidate a row")
        if rows.shape[1] != n:
            reject(
                "candidates",
                f"shape {rows.shape}",
                f"(m, {n})",
                "Give a row for each candidate, a column for each parameter.",
            )
        return self._core.evaluate_many(rows, thread_count(workers))

    def model_at(self, x: Any) -> StructuralModel:
        """The model with parameters ``x`` applied."""
        return self.model.with_parameters(self.parameters, self._repaired(x))

    def _repaired(self, x: Any) -> FloatArray:
        return self._core.repaired(self._vector(x))

    def _table(self, x: FloatArray) -> FrequencyTable | ModalTable:
        table: FrequencyTable | ModalTable = self._targets.table(
            self._core, self._repaired(self._nominal), self._repaired(x)
        )
        return table

    def _vector(self, x: Any) -> FloatArray:
        n = len(self.parameters)
        vector = real_array("x", x, ndim=1, wanted=f"an array ({n},), one value for each parameter")
        if vector.size != n:
            reject(
                "x",
                f"{vector.size} values",
                f"{n}, one for each parameter",
                "Give them in the order of the parameters; problem.names lists them.",
            )
        return vector

    def __repr__(self) -> str:
        return f"UpdatingProblem({len(self.parameters)} parameters, {self.measured_hz.size} {self.noun}s)"
