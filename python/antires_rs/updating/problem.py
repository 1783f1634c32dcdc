"""An updating problem: a model, what may change in it, what was measured, and whether it explains that."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, replace
from typing import Any, Literal, get_args

import numpy as np

from .. import _core
from .._core import __version__
from ..exceptions import NumericalError, reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.parameters import Parameter, check_far, parameter_name, parameter_tuple
from ..models.structural_model import StructuralModel, checked_model
from ..optimize.checkpoint import digest_of
from ..optimize.island_ga import thread_count
from ..support.checks import (
    BoolArray,
    FloatArray,
    IntArray,
    choice,
    finite_scalar,
    integer,
    real_array,
    shape_of,
)
from ..support.values import AroundCore, ReadOnly, frozen
from .targets import (
    AntiresonanceTargets,
    FrequencyTable,
    ModalTable,
    ModalTargets,
    Part,
    Targets,
    roots_of,
    targets_of,
)

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
        if not targets.hz.size:
            remedy = "Identify in another band, or at more dofs."
            reject("measured", f"no {targets.noun}", "at least one", remedy)
        chosen = model._by_number(chosen)
        bounds = np.array([p.bounds for p in chosen], dtype=np.float64).reshape(-1, 2)
        parts = model.description.core_parameters(chosen)
        nominal = _core.nominal_values(model._core, parts)
        _core.check_bounds(model._core, parts, bounds[:, 0].copy(), bounds[:, 1].copy())
        names = tuple(parameter_name(model, p) for p in chosen)
        check_far(chosen, names, nominal)
        factors = targets.weights(weights)
        counted = np.ones(targets.hz.size) if factors is None else factors
        if targets.noun == "mode":
            counted = np.tile(counted, 2)  # each has two residuals
        self._fill(model=model, parameters=chosen, misfit=misfit, bounds=frozen(bounds))
        self._fill(measured=targets.sets, noun=targets.noun, left_out=targets.left_out, _targets=targets)
        self._fill(measured_hz=frozen(targets.hz), _nominal=frozen(nominal), _names=names)
        dofs, forces = (frozen(getattr(targets, name, None)) for name in ("dofs", "excitations"))
        self._fill(measured_dofs=dofs, measured_excitations=forces, weights=frozen(factors))
        self._fill(penalty=penalty_of(penalty, counted, misfit))
        self._fill(_core=self._made_core())

    def _made_core(self) -> _core.Objective:
        parameters = self.model.description.core_parameters(self.parameters)
        return self._targets.core(self.model, parameters, *self._weighing)

    @property
    def _weighing(self) -> tuple[Misfit, tuple[float, float] | None, float, FloatArray | None]:
        """How the core weighs residuals and damage: misfit, prices, snap, weights."""
        penalty = self.penalty
        if penalty is None:
            return self.misfit, None, 0.0, self.weights
        return self.misfit, (penalty.gamma1, penalty.gamma2), penalty.snap, self.weights

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
        states = self._repaired(self._nominal), self._repaired(x)
        return self._targets.table(self._core, states, self.model_at)

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


# -- Whether a model explains what was measured at all: values and roots paired one to one in each response
#
# Where there are many roots each value has a near one even in a wrong model, so what counts is how many of
# both, values and roots between them, have a partner. A mistake of units would account for a model that does
# not explain the values: one ratio for all frequencies; exchanged matrices turn each root into its inverse.

Pairs = tuple[IntArray, FloatArray]  # response of each value, and ln f, ascending within each

_RATIOS: tuple[tuple[float, str], ...] = (  #: Measured over model, and which mistakes make it so.
    (math.tau, "are the frequencies in rad/s in place of Hz?"),
    (1.0 / math.tau, "were the frequencies divided by 2 pi once too often?"),
    (60.0, "are the frequencies in revolutions per minute in place of Hz?"),
    (1.0 / 60.0, "are the frequencies in Hz, and not in revolutions per minute?"),
    (1e-3, "are the frequencies in kHz in place of Hz? Or is the stiffness 1e6 times too large?"),
    (1e3, "is the stiffness 1e6 times too small (modulus in MPa for Pa, N/mm and tonnes), or lengths in mm?"),
    (math.sqrt(1e3), "is the stiffness 1000 times too small (N/mm for N/m, kPa for Pa), or the mass in g?"),
    (math.sqrt(1e-3), "is the mass 1000 times too small (tonnes for kg), or the stiffness 1000 too large?"),
    (math.sqrt(9806.65), "are the springs in kgf/mm in place of N/m?"),
    (math.sqrt(9.80665), "are forces in kgf in place of N, or weights given for masses?"),
    (1.0 / math.sqrt(9.80665), "were masses divided by 9.81 that were in kg already?"),
    (math.sqrt(180.0 / math.pi), "are rotational springs in N m per degree in place of radian?"),
    (math.sqrt(math.pi / 180.0), "are rotational springs in N m per radian, and were taken per degree?"),
    (math.sqrt(175.1268), "are the springs in lbf/in in place of N/m?"),
    (2.0, "is the sampling rate given twice the true one?"),
    (0.5, "is the sampling rate given half the true one?"),
)
_UNITS = (  #: What values of one of two tests may be in, over what they should be.
    (1e-3, "in kHz in place of Hz"),
    (math.tau, "in rad/s in place of Hz"),
    (60.0, "in revolutions per minute in place of Hz"),
)
#: Now over intact, and which mistakes with one of two tests make it so.
_BETWEEN: tuple[tuple[float, str], ...] = (
    *((ratio, f"are they {unit}?") for ratio, unit in _UNITS),
    *((1.0 / ratio, f"are those of the intact structure {unit}?") for ratio, unit in _UNITS),
    (2.0, "is their sampling rate given twice the true one?"),
    (0.5, "is their sampling rate given half the true one?"),
)
_SHARE, _BETTER = 0.7, 1.3  # so many of values and roots have a partner, so many more than without
#: Places where a force is looked for, fewer in a large model (sum of n_dof^3); shares alike; places named.
_MOST_PLACES, _MOST_WORK, _ALIKE, _NAMED = 60, 1e9, 0.05, 3
_THROUGHOUT = "is a modulus, a density (mass per length?), a section or a length wrong throughout?"
_ORDINARY = 0.1  # nearer to 1, in ln f, a ratio is an error of the model as any has, and what updating is for
MOST_DOFS, _LOWEST = 600, 40  # larger models take too long to be asked for more than so many modes


def hint_of(model: StructuralModel, targets: Targets) -> tuple[str, float]:
    """A mistake that would account for values that the model does not explain, '' if none is known, and by
    what factor it has made them too high; infinity where K and M were exchanged."""
    values = _values(targets) if isinstance(targets, AntiresonanceTargets) else _listed([targets.hz])
    highest, few = np.inf, None
    if model.n_dof > MOST_DOFS:  # the lowest roots of a large model tell as well
        few = _LOWEST + 2 * int(np.bincount(values[0]).max())
        try:
            highest = float(model.modes(few).freq_hz[-1])
        except NumericalError:  # what is wrong with such a model is told elsewhere
            return "", 1.0
    if isinstance(targets, AntiresonanceTargets):
        found = [np.empty(0)] * len(targets.parts)
        for force in set(targets.forces):
            own = [nth for nth, part in enumerate(targets.parts) if part[1] == force and part[2].size]
            zeros = roots_of(model, [targets.parts[nth][0] for nth in own], force, highest, False)
            for nth, freq in zip(own, zeros, strict=True):
                found[nth] = np.empty(0) if freq is None else freq
    else:
        found = [model.modes(few).freq_hz]
    roots = _listed(found)
    both = [number for number in np.unique(values[0]) if (roots[0] == number).any()]
    first = [values[1][values[0] == n].min() - roots[1][roots[0] == n].min() for n in both]
    free = float(np.median(first)) if first else 0.0
    guesses = [*_RATIOS, *([(math.exp(free), "")] if abs(free) >= _ORDINARY else [])]
    shares = [_share(values, roots, math.log(ratio)) for ratio, _ in guesses]
    best, plain = int(np.argmax(shares)), _share(values, roots, 0.0)
    order = len(roots[0]) - 1 - np.argsort(roots[0][::-1], kind="stable")
    turned = roots[0][order], -roots[1][order] - 2.0 * math.log(math.tau)
    if _share(values, turned, 0.0) >= max(_SHARE, shares[best], _BETTER * plain):
        return "Each root of the model is the inverse of a measured one: are K and M swapped?", math.inf
    if shares[best] < max(_SHARE, _BETTER * plain):
        return _other_force(model, targets, highest), 1.0
    ratio, why = guesses[best]
    what = f"All measured values are about {_said(ratio)} times those of the model: "
    return what + (why or _THROUGHOUT), ratio


def _other_force(model: StructuralModel, targets: Targets, highest_hz: float) -> str:
    """Where else a force explains the values of its sets far better; '' if nowhere."""
    if not isinstance(targets, AntiresonanceTargets):
        return ""
    for force in dict.fromkeys(targets.forces):
        parts = [part for part in targets.parts if part[1] == force and part[2].size]
        ends = list(dict.fromkeys(part[0] for part in parts))
        if isinstance(force, tuple) or not parts:
            continue
        places = list(dict.fromkeys([force, *ends, *model._sensor_dofs[:_MOST_PLACES]]))
        places = places[: int(_MOST_WORK / model.n_dof**3)]
        if len(places) < 2:  # nothing to compare
            continue
        values = _listed(part[2] for part in parts)
        limit = min(1.1 * max(part[2].max() for part in parts), highest_hz)
        shares: dict[Any, float] = {}
        for place in places:
            found = dict(zip(ends, roots_of(model, ends, place, limit, True), strict=True))
            roots = [found[part[0]] for part in parts]
            shares[place] = _share(values, _listed(np.empty(0) if one is None else one for one in roots), 0.0)
        best = sorted(shares, key=lambda place: -shares[place])
        better = [place for place in best if shares[place] >= max(_SHARE, _BETTER * shares[force])]
        near = [model.dof_label(place) for place in better if shares[place] > shares[best[0]] - _ALIKE]
        if near:
            named = " or ".join(near[:_NAMED])
            return f"With the force at {named} it would fit better than at {model.dof_label(force)}."
    return ""


def hint_between_states(intact: Pairs, now: Pairs) -> str:
    """A sentence, or '' where no ratio of the table makes the values of two tests agree."""
    shares = [_share(now, intact, math.log(ratio)) for ratio, _ in _BETWEEN]
    best = int(np.argmax(shares))
    if shares[best] < max(_SHARE, _BETTER * _share(now, intact, 0.0)):
        return ""
    ratio, why = _BETWEEN[best]
    return f"The values of now are about {_said(ratio)} times those of the intact structure: {why}"


def _said(ratio: float) -> str:
    """A ratio with three digits, without an exponent."""
    return f"{ratio:,.0f}" if ratio >= 100.0 else f"{ratio:.3g}"


def _share(values: Pairs, roots: Pairs, shift: float) -> float:
    """Share of values, and of roots between them, that have a partner one to one."""
    found = _paired(values, (roots[0], roots[1] + shift))
    return 2.0 * found.n_paired / max(found.n_values + found.n_roots, 1)


NEAR = 0.06  # largest difference in ln f of partners: right models after their search leave less (3 %)
#: Least share of values and roots with a partner. Right models: above 0.95; sets without a fifth of the
#: values: 0.89; models with a wrong unit, dof or force: below 0.7.
LEAST_SHARE = 0.75
LEAST_PAIRED = 0.85  # of the values: two sensors of ten exchanged leave 0.83, a tenth false 0.9
NOT_EXPLAINED = "The model does not explain the measurement: {}. {}Check {}."  # why, hint, what to check
_SAME_SHAPE = 0.5  # shapes of one mode agree so well at least


@dataclass(frozen=True)
class Explained:
    """How much of a measurement a model explains."""

    n_values: int
    n_roots: int  # of the model, between the lowest and the highest value of each response
    n_paired: int
    hint: str = ""  # a mistake that would account for it, in words
    scale: float = 1.0  # factor by which that has made the values too high
    common_loss: float = 0.0  # of all stiffnesses alike, where it explains more than losses of single ones
    left: float = 0.0  # largest difference of a frequency, where losses do not explain what is beyond errors

    @property
    def enough(self) -> bool:
        """Whether the model can be that of the tested structure."""
        paired = mostly_paired(self.n_paired, self.n_values, self.n_roots)
        return paired and few_alone(self.n_paired, self.n_values) and not self.common_loss

    @property
    def sentence(self) -> str:
        """That it cannot, why, and what to look at."""
        if not few_alone(self.n_paired, self.n_values):
            have = "has" if self.n_paired == 1 else "have"
            why = f"only {self.n_paired} of {self.n_values} values {have} a partner in it within"
            why += f" {100 * NEAR:.0f} %"
        elif not mostly_paired(self.n_paired, self.n_values, self.n_roots):
            why = f"it has {self.n_roots} roots where {self.n_values} values were measured"
        elif self.common_loss:
            why = f"every stiffness would have to be multiplied by {1.0 - self.common_loss:.2g}, as a "
            why += "modulus, section or unit that is wrong throughout would have it"
        else:
            why = "it takes the stiffness of most elements to come near the values"
        hint = f"{self.hint} " if self.hint else ""
        return NOT_EXPLAINED.format(why, hint, "its units, dofs, force and supports")


def few_alone(n_paired: int, n_values: int) -> bool:
    """Whether hardly a value is without a partner: one, or the share that may be false."""
    return n_values - n_paired <= max(1.0, (1.0 - LEAST_PAIRED) * n_values)


def mostly_paired(n_paired: int, n_values: int, n_roots: int) -> bool:
    """Whether so many pairs are enough; of a few values and roots one without a partner tells nothing."""
    return 2.0 * n_paired >= LEAST_SHARE * (n_values + n_roots - 1)


def explained(problem: UpdatingProblem, x: FloatArray, *, doubted: bool = False) -> Explained:
    """What the model at ``x`` explains; a hint is sought where that is too little, or ``doubted``."""
    targets = problem._targets
    if isinstance(targets, AntiresonanceTargets):
        target, hz, shown, _ = problem._core.states(np.ascontiguousarray(x)[None], False, 1)[0]
        seen = (shown >= 0.5) & (hz > 0.0)
        values, roots = _values(targets), (target[seen].astype(np.intp), np.log(hz[seen]))
        kept = shown_in_frfs(targets.parts, *roots)
        n_roots = roots_between(*values, roots[0][kept], roots[1][kept])
        found = replace(_paired(values, roots), n_roots=n_roots)
    else:
        near = np.abs(np.log(problem.paired_hz(x) / problem.measured_hz)) <= NEAR  # NaN without a partner
        alike = near & (problem.paired_mac(x) >= _SAME_SHAPE)
        found = Explained(near.size, near.size, int(alike.sum()))
    if found.enough and not doubted:
        return found
    hint, scale = hint_of(problem.model, targets)
    return replace(found, hint=hint, scale=scale)


#: Fewer values fit any scale by chance; and a factor (ln) that a usual mistake makes, or any. Smaller ones
#: may be found by chance for a model that is right on average, or learned.
_TELLING, _USUAL, _HOPELESS = 6, 0.65, math.log(4.0)


def refuse_other_units(problem: UpdatingProblem) -> None:
    """Refuse, before the work, a model wrong by so large a common factor that nothing can be learned."""
    hint, scale = "", 1.0
    if problem.model.n_dof > MOST_DOFS:  # what it explains takes longer to tell
        hint, scale = hint_of(problem.model, problem._targets)
    elif not (fit := explained(problem, problem.nominal)).enough:
        hint, scale = fit.hint, fit.scale
    least = _HOPELESS if _THROUGHOUT in hint else _USUAL
    if problem.measured_hz.size >= _TELLING and abs(math.log(scale)) > least:
        got, wanted = "one that does not explain the measurement", "a model of the tested structure"
        reject("model", got, wanted, f"{hint} Check units of the model and of the values.")


def _listed(frequencies: Iterable[FloatArray]) -> Pairs:
    logs = [np.sort(np.log(freq[freq > 0.0])) for freq in frequencies]
    number = np.repeat(np.arange(len(logs)), [each.size for each in logs]).astype(np.intp)
    return number, np.concatenate([np.empty(0), *logs])


def _values(targets: AntiresonanceTargets) -> Pairs:
    return _listed(part[2] for part in targets.parts)


def _paired(values: Pairs, roots: Pairs) -> Explained:
    """Values and roots aligned at least cost within each response."""
    # A pair further apart than NEAR costs more than both alone.
    std, alone, none = np.full(values[1].size, 0.5 * NEAR), 2.0, np.zeros(roots[1].size)
    partner = _core.associate(*values, std, *roots, none, alone, none)
    return Explained(values[1].size, roots_between(*values, *roots), int((partner >= 0).sum()))


#: Largest difference (ln f) of a root that several responses share: one of the whole structure.
_SHARED = 1e-7


def shown_in_frfs(parts: Sequence[Part], of_root: IntArray, roots: FloatArray) -> BoolArray:
    """Which roots, in ln f, must have a partner among values of unknown origin, (n,).

    A resonance that all responses of a set share cancels in their FRFs: it may have one.
    """
    kept = np.ones(roots.size, dtype=bool)
    for number in {part[4] for part in parts if part[3] is None}:
        rows = [of_root == i for i, part in enumerate(parts) if part[4] == number]
        for own in rows if len(rows) > 1 else []:
            apart = [np.abs(roots[own][:, None] - roots[at]).min(axis=1, initial=np.inf) for at in rows]
            kept[own] = np.max(apart, axis=0) > _SHARED
    return kept


def roots_between(response: IntArray, values: FloatArray, of_root: IntArray, roots: FloatArray) -> int:
    """How many roots there are from the lowest to the highest value of each response, in ln f."""
    between = 0
    for number in np.unique(response):
        own, there = values[response == number], roots[of_root == number]
        between += int(((there >= own.min() - NEAR) & (there <= own.max() + NEAR)).sum())
    return between
