"""What the data can tell about the parameters, and what they cannot.

Two questions. Which directions of the parameter space leave every measured antiresonance, or mode, where it
is (the null space of the residuals' Jacobian: the common scale of K and M, a mass that no
antiresonance sees)? And how small may a damage be before the penalties outweigh what it explains?
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..support.checks import FloatArray
from ..support.progress import step
from ..support.values import Value
from .problem import UpdatingProblem
from .residuals import BoxResiduals
from .targets import STEP, model_dof, roots_of

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel
    from .problem import UpdatingProblem

#: Step of the central differences, relative to the range of a parameter: the residuals carry
#: rounding of about 1e-13, so this leaves some 1e-8 of error.
_STEP = 1e-5
#: A direction whose residuals move less than this per unit of bound range is not seen.
_UNSEEN = 1e-5
#: A value whose standard deviation exceeds this share of the bounds' distance is hardly determined.
_WEAK = 0.1
#: A parameter takes part in an unseen direction from this share of it on.
_SHARE = 0.15


@dataclass(frozen=True, eq=False)
class Identifiability(Value):
    """Rank and null space of the residuals' Jacobian at a solution, scaled by the bounds.

    Attributes
    ----------
    names : tuple of str
        Parameters.
    sensitivity : ndarray, (n,)
        Norm of each parameter's column: change of the residuals over its bound range.
    rank : int
        Number of parameter combinations that the data determine.
    unseen : ndarray, (n - rank, n)
        Orthonormal combinations that they do not.
    scale_unseen : bool
        Whether scaling all parameters together is one of these.
    weak : ndarray of bool, (n,)
        Seen, but with a standard deviation above a tenth of the bounds' distance.
    std : ndarray, (n,)
        Standard deviation of each value to first order, from the scatter of the residuals, in the parameter's
        unit; infinity where it is not determined, NaN where it cannot be said: a damage that rests at 0, or
        no more residuals than parameters. Errors of the model count as far as they show in the residuals.
    noun : str
        What was measured.
    """

    names: tuple[str, ...]
    sensitivity: FloatArray
    rank: int
    unseen: FloatArray
    scale_unseen: bool
    std: FloatArray
    weak: NDArray[np.bool_]
    noun: str = "antiresonance"

    @property
    def notes(self) -> list[str]:
        """Sentences for the reader; none when every parameter is determined."""
        notes = []
        if np.any(self.blind):
            names = ", ".join(name for name, b in zip(self.names, self.blind, strict=True) if b)
            notes.append(f"Not seen by any measured {self.noun}: {names}. The value found is arbitrary.")
        mixed = len(self.names) - self.rank - int(self.blind.sum())
        if mixed > 0:
            share = np.sqrt(np.sum(self.unseen**2, axis=0))
            taking_part = (share > _SHARE) & ~self.blind
            everyone = bool(np.all(taking_part | self.blind))
            names = (
                "all parameters that are seen"
                if everyone
                else ", ".join(name for name, t in zip(self.names, taking_part, strict=True) if t)
            )
            combinations = "One combination" if mixed == 1 else f"{mixed} combinations"
            why = f"no measured {self.noun} moves with them"
            if self.scale_unseen and mixed == 1:
                why = f"a common scale moves no {self.noun}, only ratios are known"
            elif self.scale_unseen:
                why += ", a common scale among them"
            notes.append(
                f"{combinations} of {names} cannot be told: {why} "
                f"({self.rank} of {len(self.names)} combinations are)."
            )
        if np.any(self.weak):
            names = ", ".join(
                f"{name} (\u00b1 {std:.2g})"
                for name, std, weak in zip(self.names, self.std, self.weak, strict=True)
                if weak
            )
            notes.append(
                f"Hardly determined, by the scatter of the residuals: {names}. What fits as well "
                "lies within these standard deviations."
            )
        return notes

    @property
    def blind(self) -> NDArray[np.bool_]:
        """Whether nothing measured sees the parameter, (n,)."""
        return self.sensitivity <= _UNSEEN


def identifiability(problem: UpdatingProblem, x: FloatArray) -> Identifiability:
    """Rank and null space at ``x``, from central differences of the residuals."""
    low, high = problem.bounds.T
    width = np.where(high > low, high - low, 1.0)
    columns = []
    for j in range(len(x)):
        step = np.zeros(len(x))
        step[j] = _STEP * width[j]
        # Straight from the core: a step below the snap threshold must not be snapped away.
        change = problem._targets.change(problem._core, x - step, x + step) / (2.0 * _STEP)
        columns.append(np.where(np.isfinite(change), change, 0.0))
    jacobian = np.stack(columns, axis=1)
    _, singular, rows = np.linalg.svd(jacobian, full_matrices=True)
    rank = int(np.count_nonzero(singular > _UNSEEN))
    # All stiffness and mass up by the same fraction.
    scale = np.array([p.common_scale(value) for p, value in zip(problem.parameters, x, strict=True)]) / width
    length = np.linalg.norm(scale)
    scale_unseen = bool(length > 0 and np.linalg.norm(jacobian @ scale) <= _UNSEEN * length)
    std = _standard_deviations(problem, x, jacobian) * width
    sensitivity = np.linalg.norm(jacobian, axis=0)
    weak = np.isfinite(std) & (std > _WEAK * width) & (sensitivity > _UNSEEN)
    return Identifiability(
        tuple(problem.names), sensitivity, rank, rows[rank:], scale_unseen, std, weak, problem.noun
    )


def _standard_deviations(problem: UpdatingProblem, x: FloatArray, jacobian: FloatArray) -> FloatArray:
    """Standard deviations over the bounds' distances, (n,): sigma times the rows of the pseudo-inverse.

    ``sigma**2 = sum(e**2) / (m - rank)``. A damage at exactly 0 is decided, not estimated.
    """
    resting = np.array(
        [
            p.quantity == "stiffness_reduction" and value == 0.0 and problem.penalty is not None
            for p, value in zip(problem.parameters, x, strict=True)
        ]
    )
    std = np.full(len(x), np.nan)
    free = np.flatnonzero(~resting & (problem.bounds[:, 1] > problem.bounds[:, 0]))
    if free.size == 0:
        return std
    _, singular, rows = np.linalg.svd(jacobian[:, free], full_matrices=True)
    seen = np.append(singular, np.zeros(len(rows) - len(singular))) > _UNSEEN
    residuals = problem.residuals(x)[: len(problem.measured_hz)]
    spare = residuals.size - int(seen.sum())
    if spare > 0:
        sigma = np.sqrt(np.sum(residuals**2) / spare)
        std[free] = sigma * np.sqrt(np.sum((rows[seen] / singular[seen[: len(singular)], None]) ** 2, axis=0))
    std[free[np.any(np.abs(rows[~seen]) > _SHARE, axis=0)]] = np.inf
    return std


def smallest_visible(problem: UpdatingProblem) -> list[float]:
    """Smallest value of each stiffness reduction that the objective prefers to no damage.

    The structure is taken to be the nominal model with that one reduction, measured exactly at the
    same dofs and in the same band; how far each antiresonance counts is told by
    ``updating.steady_roots``. Infinity where no value up to the bound is preferred.
    """
    penalty = problem.penalty
    nominal_hz = problem.paired_hz(problem.nominal)
    moved = [problem.model_at(STEP * unit) for unit in np.eye(len(problem.parameters))]

    def gain(index: int, beta: float) -> float:
        """What the damage explains, less what it costs."""
        x = np.zeros(len(problem.parameters))
        x[index] = beta
        damaged = problem.model_at(x)
        exact = problem._targets.exact(damaged, problem.model, nominal_hz, moved)
        if exact is None:
            return -1.0
        sets, weights = exact
        plain = type(problem)(problem.model, problem.parameters, sets, misfit=problem.misfit, weights=weights)
        undamaged = plain.cost(np.zeros_like(x))
        loss, element = penalty.prices if penalty else (0.0, 0.0)
        return undamaged - (loss * beta + element)

    visible = []
    for index, (_, high) in enumerate(problem.bounds):
        grid = np.linspace(0.01, high, 40)
        first = next((i for i, beta in enumerate(grid) if gain(index, beta) > 0), None)
        if first is None:
            visible.append(float("inf"))
            continue
        low, top = (grid[first - 1] if first else 0.0), grid[first]
        while top - low > 1e-3:
            middle = 0.5 * (low + top)
            low, top = (low, middle) if gain(index, middle) > 0 else (middle, top)
        visible.append(float(top))
    return visible


# -- Combinations of parameters that the data do not tell, in words


#: Members of a combination have at least this share of its largest coefficient; so many are named.
_MEMBER, _NAMED = 0.3, 4
#: From this share of all parameters on, all of one sign, it is the common scale.
_COMMON = 0.7

#: Combinations with at least this share left are as good as not seen, and may be turned into simpler ones.
_UNSEEN_COMBINATIONS = 0.95


def combinations(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What is left of orthonormal combinations, (n,), the least told first, and these, (n, n), by row.

    ``covariance`` is in prior standard deviations. Combinations of which nothing is told are any basis of a
    space; they are turned to have few members each.
    """
    values, vectors = np.linalg.eigh(covariance)
    left, rows = np.sqrt(np.clip(values[::-1], 0.0, 1.0)), vectors[:, ::-1].T.copy()
    unseen = int(np.sum(left >= _UNSEEN_COMBINATIONS))
    if unseen > 1:
        rows[:unseen] = _varimax(rows[:unseen])
    return left, rows


def _varimax(rows: FloatArray) -> FloatArray:
    """The rows rotated among themselves so that their squares vary most (Kaiser, Psychometrika 23 (1958))."""
    turned = rows.copy()
    for _ in range(50):
        before = turned.copy()
        for a in range(len(rows)):
            for b in range(a + 1, len(rows)):
                u, v = turned[a] ** 2 - turned[b] ** 2, 2.0 * turned[a] * turned[b]
                n = rows.shape[1]
                angle = 0.25 * np.arctan2(
                    2.0 * (u @ v - u.sum() * v.sum() / n), u @ u - v @ v - (u.sum() ** 2 - v.sum() ** 2) / n
                )
                c, s = np.cos(angle), np.sin(angle)
                turned[[a, b]] = c * turned[a] + s * turned[b], c * turned[b] - s * turned[a]
        if np.allclose(before, turned, atol=1e-9):
            break
    return turned


def combination_in_words(names: Sequence[str], direction: FloatArray) -> str:
    """The end of "not told: ...", of a direction in which the data leave the parameters free, (n,)."""
    size = np.abs(direction)
    order = np.argsort(-size, kind="stable")
    members = [int(j) for j in order if size[j] >= _MEMBER * size[order[0]]]
    signs = np.sign(direction[members]) * np.sign(direction[members[0]])
    named = [names[j] for j in members]
    if len(members) == 1:
        return named[0]
    if len(members) >= max(3, _COMMON * len(names)) and np.all(signs > 0):
        return "a common scale of the parameters; their ratios are"
    if len(members) == 2:
        if signs[1] < 0:
            return f"{named[0]} against {named[1]}; both together are"
        return f"{named[0]} together with {named[1]}; their ratio is"
    up = [name for name, sign in zip(named, signs, strict=True) if sign > 0]
    down = [name for name, sign in zip(named, signs, strict=True) if sign < 0]
    if not down:
        return f"{_listed(up)} together"
    return f"{_listed(up)} against {_listed(down)}"


def _listed(names: Sequence[str]) -> str:
    if len(names) > _NAMED:
        return f"{', '.join(names[:_NAMED])} and {len(names) - _NAMED} more"
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


# -- What a test of the structure with parameters x would measure exactly, and how that changes with them
#
# For questions that are asked before the test, or all over the bounds: the measured values are those of the
# model itself, at the same responses and in the same band, with more forces or sensors if asked for.


#: Below this share of the lowest measured frequency a root on its way to zero would count without bound.
_LOWEST = 0.5
#: Error of an entry of a shape over that of omega squared: ten times that of the frequency.
_SHAPES = 5.0
#: Roots are followed by their numbers to this multiple of the highest measured frequency.
_BEYOND = 2.0
#: A value that the model at x itself does not meet is paired with another.
_MET = 1e-6


def sensitivities(
    problem: UpdatingProblem, x: FloatArray, forces: tuple[int, ...] = (), sensors: tuple[int, ...] = ()
) -> FloatArray:
    """Change of what would be measured at ``x`` over the bounds' distances, (m, n), for the free parameters.

    Rows are of omega squared, relative, and of entries of shapes at unit length, a fifth of them for their
    error is larger. ``forces`` and ``sensors`` are dofs that the test would have beside its own.
    """
    model = problem.model_at(x)
    sets: list[ModalSet] | list[AntiresonanceSet] = (
        _modes(problem, model, sensors)
        if problem.noun == "mode"
        else _antiresonances(problem, model, forces, sensors)
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # on bounds far from nominal: said when the problem was made
        exact = UpdatingProblem(problem.model, problem.parameters, sets)
    residuals = BoxResiduals(exact, x)
    u = residuals.place(x)
    met = np.abs(residuals.at(u)) < _MET
    weight = np.where(residuals.kind == 1, 1.0 / _SHAPES, 1.0)
    return (weight[:, None] * residuals.jacobian(u))[met]


def _antiresonances(
    problem: UpdatingProblem, model: StructuralModel, forces: tuple[int, ...], sensors: tuple[int, ...]
) -> list[AntiresonanceSet]:
    """The roots of the model that have the numbers of the measured ones in the nominal model."""
    high, low = float(problem.measured_hz.max()), _LOWEST * float(problem.measured_hz.min())
    tests: list[tuple[int, dict[int, FloatArray] | None, list[int]]] = []
    for each in problem.measured:
        values = {model_dof(model, "measured dof", dof): each[dof] for dof in each}
        force = model_dof(model, "excitation", each.excitation)
        tests.append((force, values, [*values, *(dof for dof in sensors if dof not in values)]))
    tests += [(force, None, tests[0][2]) for force in forces]
    sees = problem.measured[0].sees
    sets = []
    for force, measured, dofs in tests:
        before = roots_of(problem.model, dofs, force, _BEYOND * high, sees != "frf")
        there = roots_of(model, dofs, force, _BEYOND * high, sees != "frf")
        found = {}
        for dof, was, now in zip(dofs, before, there, strict=True):
            was, now = (np.empty(0) if freq is None else freq for freq in (was, now))
            if measured is not None and dof in measured and was.size:
                number = np.unique([np.argmin(np.abs(was - value)) for value in measured[dof]]).astype(int)
            else:
                number = np.flatnonzero((was >= low) & (was <= high))
            freq = now[number[number < now.size]]
            found[dof] = freq[freq >= low]
        sets.append(AntiresonanceSet(force, found, sees=sees, channels=dofs))
    if not any(freq.size for each in sets for freq in each.values()):
        reject(
            "problem",
            f"no antiresonance up to {high:.4g} Hz at some parameters within the bounds",
            "antiresonances in the band",
            "Narrow the bounds, or take a wider band.",
        )
    return sets


def _modes(problem: UpdatingProblem, model: StructuralModel, sensors: tuple[int, ...]) -> list[ModalSet]:
    """The modes that have the numbers of those in the band of the nominal model."""
    high, low = 1.001 * float(problem.measured_hz.max()), _LOWEST * float(problem.measured_hz.min())
    nominal, modes = problem.model.modes().freq_hz, model.modes()
    flexible = np.flatnonzero((nominal > low) & (nominal < high))
    sets = []
    for each in problem.measured:
        dofs = [int(dof) for dof in each.dofs]
        dofs += [dof for dof in sensors if dof not in dofs]
        sets.append(ModalSet(modes.freq_hz[flexible], modes.shapes[flexible][:, dofs], dofs))
    return sets


# -- What would make parameters identifiable: one fixed, two taken as one, another force, another sensor


#: Cosine from which two columns of sensitivities count as one, all over the box.
_ALIKE = 0.99
#: A suggestion must take away this share of what is left open.
_WORTH = 0.2
#: Points at which candidates for forces and sensors are tried.
_TRIED = 4
#: A smallest singular value below it is that of a combination that is not seen at all.
_SEEN = 1e-3
#: Share of its prior standard deviation below which a combination counts as told.
TOLD = 0.3


def expected_covariance(jacobians: Sequence[FloatArray], noise: float) -> FloatArray:
    """Mean over the points of the posterior's covariance, in prior standard deviations, (n, n).

    A uniform prior of width 1 counts as a Gaussian of the same variance, 1/12.
    """
    n = jacobians[0].shape[1]
    found = [np.linalg.inv(np.eye(n) + j.T @ j / (12.0 * noise**2)) for j in jacobians]
    return np.asarray(np.mean(found, axis=0))


def suggestions(
    problem: UpdatingProblem,
    names: Sequence[str],
    points: FloatArray,
    jacobians: Sequence[FloatArray],
    noise: float,
    forces: Sequence[int],
    sensors: Sequence[int],
) -> list[str]:
    """Sentences, the most useful of each kind; none where every combination is told."""
    covariance = expected_covariance(jacobians, noise)
    said = _alike(names, jacobians)
    if np.linalg.eigvalsh(covariance)[-1] < TOLD**2:
        return said
    said = [*_fixed(names, covariance), *said]
    few, own = points[:_TRIED], jacobians[:_TRIED]
    now = _open(own, noise)
    for kind, candidates in (("force", forces), ("sensor", sensors)):
        best: tuple[float, int, list[FloatArray]] | None = None
        for dof in candidates:
            label = problem.model.dof_label(dof)
            step(f"{kind} at {label}")
            more = {"forces": (dof,)} if kind == "force" else {"sensors": (dof,)}
            tried = [sensitivities(problem, x, **more) for x in few]
            left = _open(tried, noise)
            if best is None or left < best[0]:
                best = left, dof, tried
        if best is not None and best[0] < (1.0 - _WORTH) * now:
            before, after = _told(own, noise), _told(best[2], noise)
            least = [float(np.median([_least(j, noise) for j in each])) for each in (own, best[2])]
            gain = ""
            if least[0] >= _SEEN:
                gain = f", smallest singular value {least[1]:.2g} instead of {least[0]:.2g}"
            said.append(
                f"A {kind} at {problem.model.dof_label(best[1])} as well: {after} of {len(names)} "
                f"combinations are told instead of {before}{gain}."
            )
    return said


def _fixed(names: Sequence[str], covariance: FloatArray) -> list[str]:
    """The parameter that, once known, leaves the fewest combinations open."""
    before = _count_open(covariance)
    best = (before, float(np.trace(covariance)), 0)
    for j, column in enumerate(covariance):
        left = covariance - np.outer(column, column) / covariance[j, j]
        best = min(best, (_count_open(left), float(np.trace(left)), j))
    if best[0] == before:
        return []
    stay = "none stays" if best[0] == 0 else "1 stays" if best[0] == 1 else f"{best[0]} stay"
    return [f"Fix {names[best[2]]} if it is known otherwise: of {before} open combinations {stay} open."]


def _count_open(covariance: FloatArray) -> int:
    return int(np.sum(np.linalg.eigvalsh(covariance) >= TOLD**2))


def _alike(names: Sequence[str], jacobians: Sequence[FloatArray]) -> list[str]:
    """Pairs whose columns are all but one, at nine of ten points."""
    cosines = []
    for jacobian in jacobians:
        length = np.linalg.norm(jacobian, axis=0)
        unit = jacobian / np.where(length > 0.0, length, 1.0)
        cosines.append(unit.T @ unit)
    usual = np.quantile(np.abs(cosines), 0.1, axis=0)
    pairs = np.argwhere(np.triu(usual, 1) > _ALIKE)
    noun = "One parameter for"
    return [
        f"{noun} {names[a]} and {names[b]}: they move the measured values alike (cosine {usual[a, b]:.3f})."
        for a, b in pairs[:4]
    ]


def _open(jacobians: Sequence[FloatArray], noise: float) -> float:
    """Variance that is left of all combinations together."""
    return float(np.trace(expected_covariance(jacobians, noise)))


def _told(jacobians: Sequence[FloatArray], noise: float) -> int:
    covariance = expected_covariance(jacobians, noise)
    return len(covariance) - _count_open(covariance)


def _least(jacobian: FloatArray, noise: float) -> float:
    """Smallest singular value over the errors, with a prior standard deviation as the unit."""
    values = np.linalg.svd(jacobian, compute_uv=False) / (noise * np.sqrt(12.0))
    return float(values[-1]) if values.size == jacobian.shape[1] else 0.0
