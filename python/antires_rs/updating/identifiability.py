"""What the data tell about the parameters: at a solution, and before a test all over their bounds."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..exceptions import reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..models.structural_model import End, StructuralModel
from ..support.checks import BoolArray, FloatArray, finite_scalar, integer, members
from ..support.messages import some
from ..support.progress import one_blas_thread, patient, step
from ..support.values import Value
from ..views import Viewed
from .posterior import STEP_OF_SLOPES, UNSEEN, BoxResiduals, decided
from .problem import UpdatingProblem
from .targets import STEP, roots_of

_WEAK = 0.1  # standard deviation over the bounds' distance from which a value is hardly determined
_SHARE = 0.15  # a parameter takes part in an unseen direction from this share of it on


@dataclass(frozen=True, eq=False)
class Identifiability(Value):
    """Rank and null space of the residuals' Jacobian at a solution, scaled by the bounds."""

    names: tuple[str, ...]
    sensitivity: FloatArray  # change of the residuals over the range of each parameter, (n,)
    rank: int  # combinations of parameters that the data determine
    unseen: FloatArray  # orthonormal combinations that they do not, (n - rank, n)
    scale_unseen: bool  # whether a common scale is one of these
    #: Of each value to first order, by the scatter of the residuals, (n,); infinity where not determined, NaN
    #: where it cannot be said: a damage that rests at 0, or no more residuals than parameters.
    std: FloatArray
    weak: BoolArray  # whether it is above a tenth of the bounds' distance
    noun: str = "antiresonance"
    #: As ``std``, but for a common scale, where that alone is not seen: of ratios; None elsewhere.
    std_of_ratios: FloatArray | None = None

    @property
    def notes(self) -> list[str]:
        """Sentences for the reader; none when every parameter is determined."""
        notes = []
        if np.any(self.blind):
            names = self._named(self.blind)
            notes.append(f"Not seen by any measured {self.noun}: {names}. The value found is arbitrary.")
        mixed = len(self.names) - self.rank - int(self.blind.sum())
        if mixed > 0:
            part = (np.sqrt(np.sum(self.unseen**2, axis=0)) > _SHARE) & ~self.blind
            everyone = bool(np.all(part | self.blind))
            names = "all parameters that are seen" if everyone else self._named(part)
            open_ones = "One combination" if mixed == 1 else f"{mixed} combinations"
            why = f"no measured {self.noun} moves with them"
            if self.scale_unseen and mixed == 1:
                why = f"a common scale moves no {self.noun}, only ratios are known"
            elif self.scale_unseen:
                why += ", a common scale among them"
            told = f"({self.rank} of {len(self.names)} combinations are)"
            notes.append(f"{open_ones} of {names} cannot be told: {why} {told}.")
        if np.any(self.weak):
            names = self._named(self.weak, [f" (\u00b1 {std:.2g})" for std in self.std])
            said = f"Hardly determined, by the scatter of the residuals: {names}. What fits as well lies"
            notes.append(f"{said} within these standard deviations.")
        return notes

    @property
    def spreads(self) -> list[str]:
        """Of each value its standard deviation as a text; of values whose ratios are known, of these."""
        ratios = np.full(len(self.std), np.nan) if self.std_of_ratios is None else self.std_of_ratios
        said = []
        for std, ratio in zip(self.std, ratios, strict=True):
            of_ratio = (
                f"\u00b1 {ratio:.2g} but for a common scale" if np.isfinite(ratio) else "not determined"
            )
            said.append(of_ratio if np.isinf(std) else f"\u00b1 {std:.2g}")
        return said

    def _named(self, which: BoolArray, endings: Iterable[str] | None = None) -> str:
        labels = zip(self.names, endings or [""] * len(self.names), which, strict=True)
        return ", ".join(name + ending for name, ending, chosen in labels if chosen)

    @property
    def blind(self) -> BoolArray:
        """Whether nothing measured sees the parameter, (n,)."""
        return self.sensitivity <= UNSEEN


def at_solution(problem: UpdatingProblem, x: FloatArray) -> Identifiability:
    """Rank and null space at ``x``, from central differences of the residuals."""
    low, high = problem.bounds.T
    width = np.where(high > low, high - low, 1.0)
    columns = []
    for h in np.diag(STEP_OF_SLOPES * width):
        # Straight from the core: a step below the snap threshold must not be snapped away.
        ahead, behind = (problem._targets.errors(problem._core, at) for at in (x + h, x - h))
        columns.append((ahead - behind) / (2.0 * STEP_OF_SLOPES))
    jacobian = np.stack(columns, axis=1)
    _, singular, rows = np.linalg.svd(jacobian, full_matrices=True)
    rank = int(np.count_nonzero(singular > UNSEEN))
    # All stiffness and mass up by the same fraction.
    scale = np.array([p.common_scale(value) for p, value in zip(problem.parameters, x, strict=True)]) / width
    length = np.linalg.norm(scale)
    scale_unseen = bool(length > 0 and np.linalg.norm(jacobian @ scale) <= UNSEEN * length)
    std, of_ratios = _standard_deviations(problem, x, jacobian) * width
    sensitivity = np.linalg.norm(jacobian, axis=0)
    blind = sensitivity <= UNSEEN
    alone = scale_unseen and len(x) - rank - int(blind.sum()) == 1
    weak = np.isfinite(std) & (std > _WEAK * width) & (sensitivity > UNSEEN)
    told = sensitivity, rank, rows[rank:], scale_unseen, std, weak
    ratios = np.where(blind, np.nan, of_ratios) if alone else None
    return Identifiability(tuple(problem.names), *told, problem.noun, ratios)


def _standard_deviations(problem: UpdatingProblem, x: FloatArray, jacobian: FloatArray) -> FloatArray:
    """Standard deviations over the bounds' distances: sigma times the rows of the pseudo-inverse.

    (2, n): infinite along what is not seen, and as if nothing moved along it.
    """
    std = np.full(len(x), np.nan)
    free = np.flatnonzero(~decided(problem, x) & (problem.bounds[:, 1] > problem.bounds[:, 0]))
    if free.size == 0:
        return np.stack([std, std])
    _, singular, rows = np.linalg.svd(jacobian[:, free], full_matrices=True)
    seen = np.append(singular, np.zeros(len(rows) - len(singular))) > UNSEEN
    residuals = problem.residuals(x)[: len(problem.measured_hz)]
    spare = residuals.size - int(seen.sum())
    if spare > 0:
        sigma = np.sqrt(np.sum(residuals**2) / spare)
        std[free] = sigma * np.sqrt(np.sum((rows[seen] / singular[seen[: len(singular)], None]) ** 2, axis=0))
    held = std.copy()
    std[free[np.any(np.abs(rows[~seen]) > _SHARE, axis=0)]] = np.inf
    return np.stack([std, held])


def smallest_visible(problem: UpdatingProblem) -> list[float]:
    """Smallest value of each stiffness reduction that the objective prefers to no damage, on exact data."""
    penalty = problem.penalty
    loss, element = (penalty.gamma1, penalty.gamma2) if penalty else (0.0, 0.0)
    moved = [problem.model_at(STEP * unit) for unit in np.eye(len(problem.parameters))]
    exact = problem._targets.exact(problem.model, problem.paired_hz(problem.nominal), moved)

    def gain(index: int, beta: float) -> float:
        """What the damage explains, less what it costs."""
        x = np.zeros(len(problem.parameters))
        x[index] = beta
        measured = exact(problem.model_at(x))
        if measured is None:
            return -1.0
        sets, weights = measured
        plain = type(problem)(problem.model, problem.parameters, sets, misfit=problem.misfit, weights=weights)
        return plain.cost(np.zeros_like(x)) - (loss * beta + element)

    visible = []
    for index, (_, high) in enumerate(problem.bounds):
        low, top = 0.0, float("inf")
        for beta in np.linspace(0.01, high, 40):
            if gain(index, beta) > 0:
                top = beta
                break
            low = beta
        while np.isfinite(top) and top - low > 1e-3:
            middle = 0.5 * (low + top)
            low, top = (low, middle) if gain(index, middle) > 0 else (middle, top)
        visible.append(float(top))
    return visible


# -- What a test could tell about the parameters, wherever they are within their bounds: asked before the test

_NOISE = 1e-3  # relative error of a measured frequency where none is stated and none given
_MOST_TRIED = 12  # forces and sensors that are tried unless they are named


@dataclass(frozen=True, eq=False)
class BoxIdentifiability(Value, Viewed):
    """What a test tells about parameters all over their bounds. Print it.

    Attributes
    ----------
    names, noise, points : tuple of str, (n,), float, and ndarray, (p, n)
        Parameters that may move, relative standard deviation of the measured frequencies, and values of the
        parameters at which they were asked for.
    singular_values : ndarray, (p, n)
        Of the sensitivities over the errors, with a prior standard deviation as the unit of each parameter,
        falling: 1 is a combination that the test tells as well as the bounds do.
    left : ndarray, (n,)
        Standard deviation of each parameter after the test over that within the bounds, expected over the
        box: 1 where the test tells nothing.
    combinations, combinations_left : ndarray, (n, n) and (n,)
        Orthonormal combinations of the parameters (in logarithms where these are positive), the least told
        first, and what is left of each.
    words, suggestions : tuple of str
        What is not told, one for each combination with more than 0.3 left; and what would help: fix a
        parameter, take two as one, another force, another sensor.

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.identifiability(ar.cases.chain8().updating_problem(), points=4, forces=[], sensors=[]).told
    13
    """

    TOLD: ClassVar[float] = 0.3  # share of a standard deviation below which a combination counts as told

    names: tuple[str, ...]
    noise: float
    points: FloatArray
    singular_values: FloatArray
    left: FloatArray
    combinations: FloatArray
    combinations_left: FloatArray
    words: tuple[str, ...]
    suggestions: tuple[str, ...]

    @property
    def told(self) -> int:
        """Number of combinations that the test tells: with at most 0.3 of their standard deviation left."""
        return int(np.sum(self.combinations_left < self.TOLD))

    def plot(self, ax: Any = None) -> Any:
        """What is left of each parameter; see :func:`antires_rs.figures.plot_identifiability`."""
        return self._view("plot")(self, ax=ax)

    def __str__(self) -> str:
        width = max(map(len, self.names))
        lines = [
            f"{self.told} of {len(self.names)} combinations told at {100 * self.noise:g} % error "
            f"of the frequencies, {len(self.points)} points within the bounds",
            "",
            f"{'':<{width}}  left of its standard deviation",
            *(f"{n:<{width}}  {100 * left:5.1f} %" for n, left in zip(self.names, self.left, strict=True)),
            "",
            *(f"not told: {words}" for words in self.words),
            *(f"would help: {words}" for words in self.suggestions),
        ]
        return "\n".join(lines).rstrip()


@patient("identifiability")
@one_blas_thread
def identifiability(
    problem: UpdatingProblem,
    *,
    noise: float | None = None,
    points: int = 32,
    forces: Sequence[int] | None = None,
    sensors: Sequence[int] | None = None,
    progress: bool | None = None,
) -> BoxIdentifiability:
    """What a test like this one tells about the parameters, wherever they are within the bounds.

    Before a test the measured set is a virtual one, made of the model itself; only its responses, forces and
    band are used. Sensitivities are those at the points of a Sobol sequence, always the same.

    Parameters
    ----------
    problem : UpdatingProblem
    noise : float, optional
        Relative standard deviation of the measured frequencies, that of entries of shapes is ten times as
        much. Default: the median of those stated, 0.1 % where none are.
    points : int
        Points within the bounds, at least 4; a power of two covers them evenly.
    forces, sensors, progress : sequence of int, and bool, optional
        Dofs to be tried beside those of the test, by default up to twelve of the responses as forces (for
        antiresonances only), and of the other dofs as sensors; ``progress`` as of :func:`~antires_rs.update`.

    Returns
    -------
    BoxIdentifiability

    Examples
    --------
    >>> import antires_rs as ar
    >>> ar.identifiability(ar.cases.chain8().updating_problem(), points=4, forces=[], sensors=[]).words[0]
    'mass 0'
    """
    from scipy.stats.qmc import Sobol

    if not isinstance(problem, UpdatingProblem):
        reject("problem", problem, "an UpdatingProblem", "Make one, with a measured or virtual set.")
    integer("points", points, low=4, high=4096)
    std = problem._targets.error_rows()[2]  # of omega squared
    std = std[np.isfinite(std) & (std > 0.0)]
    stated = float(0.5 * np.median(std)) if std.size else _NOISE
    taken = stated if noise is None else finite_scalar("noise", noise, low=1e-8, high=1.0)
    box = BoxResiduals(problem, problem.bounds.mean(axis=1))
    if box.free.size == 0:
        reject("problem", "no parameter that may move", "bounds with a distance", "Widen the bounds.")
    names = tuple(problem.names[j] for j in box.free)
    sobol = Sobol(box.free.size, seed=0).random_base2(int(np.ceil(np.log2(points))))
    x = box.vector(np.asarray(sobol[:points]))
    jacobians = []
    for nth, row in enumerate(x):
        step(f"point {nth + 1} of {points}")
        jacobians.append(sensitivities(problem, row))
    error = 2.0 * taken  # of omega squared, hence twice that of the frequency
    covariance = expected_covariance(jacobians, error)
    left, vectors = combinations(covariance)
    untold = vectors[left >= BoxIdentifiability.TOLD]
    words = [combination_in_words(names, direction) for direction in untold]
    helpful = _alike(names, jacobians)
    if np.linalg.eigvalsh(covariance)[-1] >= BoxIdentifiability.TOLD**2:
        tried = _candidates(problem, forces, sensors)
        helpful = [*_fixed(names, covariance), *helpful, *_further(problem, x, jacobians, error, tried)]
    seen = np.array([_singular_values(j, error) for j in jacobians])
    told = np.sqrt(np.clip(np.diag(covariance), 0.0, 1.0)), vectors, left, tuple(words), tuple(helpful)
    return BoxIdentifiability(names, taken, x[:, box.free], seen, *told)


def _candidates(
    problem: UpdatingProblem, forces: Sequence[int] | None, sensors: Sequence[int] | None
) -> dict[str, list[int]]:
    """Dofs to be tried as forces and as sensors, by what they are."""
    model, of_modes = problem.model, problem.noun == "mode"

    def dofs(name: str, labels: Any) -> list[int]:
        return [model._dof(name, label) for label in labels]

    def tried(name: str, given: Any, default: list[int]) -> list[int]:
        """Those named, or all of a few, or some of many, evenly."""
        some_of = np.linspace(0, len(default) - 1, min(len(default), _MOST_TRIED)).round().astype(int)
        return [default[i] for i in some_of] if given is None else dofs(name, given)

    measured = [s.dofs if of_modes else [d for key in s for d in _names(key)] for s in problem.measured]
    seen = {dof for own in measured for dof in dofs("measured dof", own)}
    found = {"sensor": tried("sensors", sensors, [d for d in model._sensor_dofs if d not in seen])}
    if of_modes:
        return found
    pushed = {*dofs("excitation", [d for s in problem.measured for d in _names(s.excitation)])}
    return {"force": tried("forces", forces, sorted(seen - pushed)), **found}


def _names(key: Any) -> list[Any]:
    """The dofs that a response or a force of a set names."""
    return list(key) if isinstance(key, tuple) else [key]


# -- What a test of the structure with parameters x would measure exactly, and how that changes with them:
# values of the model itself, at the same responses and in the same band, with more forces or sensors if asked
# for

#: Roots are followed by their numbers between these multiples of the lowest and highest measured frequency:
#: one on its way to zero would count without bound.
_LOWEST, _BEYOND = 0.5, 2.0
_SHAPES = 5.0  # error of an entry of a shape over that of omega squared: ten times that of the frequency
_MET = 1e-6  # a value that the model at x itself does not meet is paired with another


def sensitivities(
    problem: UpdatingProblem, x: FloatArray, forces: tuple[int, ...] = (), sensors: tuple[int, ...] = ()
) -> FloatArray:
    """Change of what would be measured at ``x`` over the bounds' distances, (m, n); of shapes a fifth."""
    model = problem.model_at(x)
    of_modes = problem.noun == "mode"
    sets: Any = _modes(problem, model, sensors) if of_modes else _zeros(problem, model, forces, sensors)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # on bounds far from nominal: said when the problem was made
        exact = UpdatingProblem(problem.model, problem.parameters, sets)
    residuals = BoxResiduals(exact, x)
    u = residuals.place(x)
    met = np.abs(residuals.at(u)) < _MET
    weight = np.where(residuals.kind == 1, 1.0 / _SHAPES, 1.0)
    return (weight[:, None] * residuals.jacobian(u))[met]


def _zeros(
    problem: UpdatingProblem, model: StructuralModel, forces: tuple[int, ...], sensors: tuple[int, ...]
) -> list[AntiresonanceSet]:
    """The roots of the model that have the numbers of the measured ones in the nominal model."""
    high, low = float(problem.measured_hz.max()), _LOWEST * float(problem.measured_hz.min())
    tests: list[tuple[End, dict[End, FloatArray] | None, list[End]]] = []
    for each in problem.measured:
        values = {model._end("measured dof", dof): each[dof] for dof in each}
        force = model._end("excitation", each.excitation)
        tests.append((force, values, [*values, *_with_sensors(list(values), sensors)]))
    singly = sorted({dof for end in tests[0][2] for dof in members(end)})
    one_each = isinstance(tests[0][0], int)
    tests += [(force, None, tests[0][2] if one_each else [*singly]) for force in forces]
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
        channels = list(dict.fromkeys(dof for end in dofs for dof in members(end)))
        sets.append(AntiresonanceSet(force, found, sees=sees, channels=channels))
    if not any(freq.size for each in sets for freq in each.values()):
        got = f"no antiresonance up to {high:.4g} Hz at some parameters within the bounds"
        reject("problem", got, "antiresonances in the band", "Narrow the bounds, or take a wider band.")
    return sets


def _with_sensors(ends: list[End], sensors: tuple[int, ...]) -> list[End]:
    """The responses that further sensors give: of several forces, sets in which one takes a place."""
    if isinstance(ends[0], int):
        return [dof for dof in sensors if dof not in ends]
    more = ((dof, *members(end)[1:]) for dof in sensors for end in ends if dof not in members(end))
    return [*dict.fromkeys(tuple(sorted(end)) for end in more)]


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


def expected_covariance(jacobians: Sequence[FloatArray], noise: float) -> FloatArray:
    """Mean over the points of the posterior's covariance, in prior standard deviations, (n, n)."""
    found = [np.linalg.inv(np.eye(j.shape[1]) + j.T @ j / (12.0 * noise**2)) for j in jacobians]
    return np.asarray(np.mean(found, axis=0))


def _singular_values(jacobian: FloatArray, noise: float) -> FloatArray:
    """Over the errors, with a prior standard deviation as the unit of each parameter, falling, (n,)."""
    values = np.linalg.svd(jacobian, compute_uv=False) / (noise * np.sqrt(12.0))
    return np.append(values, np.zeros(jacobian.shape[1]))[: jacobian.shape[1]]


# -- Combinations of parameters that the data do not tell, in words

_MEMBER = 0.3  # members of a combination have at least this share of its largest coefficient
_COMMON = 0.7  # from this share of all parameters on, all of one sign, it is the common scale
_UNSEEN = 0.95  # combinations with so much left are not seen, and may be turned into simpler ones


def combinations(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """What is left of orthonormal combinations, (n,), the least told first, and these, (n, n), by row."""
    values, vectors = np.linalg.eigh(covariance)
    left, rows = np.sqrt(np.clip(values[::-1], 0.0, 1.0)), vectors[:, ::-1].T.copy()
    unseen = int(np.sum(left >= _UNSEEN))
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
                n, p, q = rows.shape[1], u.sum(), v.sum()
                angle = 0.25 * np.arctan2(2.0 * (u @ v - p * q / n), u @ u - v @ v - (p**2 - q**2) / n)
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
    if len(members) == 2 and signs[1] < 0:
        return f"{named[0]} against {named[1]}; both together are"
    if len(members) == 2:
        return f"{named[0]} together with {named[1]}; their ratio is"
    up, down = (some([name for name, at in zip(named, signs, strict=True) if at == sign]) for sign in (1, -1))
    return f"{up} against {down}" if down else f"{up} together"


# -- What would make parameters identifiable: one fixed, two taken as one, another force, another sensor

_ALIKE = 0.99  # cosine from which two columns of sensitivities count as one, all over the box
_WORTH = 0.2  # a suggestion must take away this share of what is left open
_TRIED = 4  # points at which candidates for forces and sensors are tried
_SEEN = 1e-3  # a smallest singular value below it is that of a combination that is not seen at all


def _further(
    problem: UpdatingProblem,
    points: FloatArray,
    jacobians: Sequence[FloatArray],
    noise: float,
    candidates: dict[str, list[int]],
) -> list[str]:
    """Which force and which sensor would tell most, one of each kind at most."""
    own, found = jacobians[:_TRIED], []
    now = expected_covariance(own, noise)
    for kind, dofs in candidates.items():
        tried = {}
        for dof in dofs:
            step(f"{kind} at {problem.model.dof_label(dof)}")
            with_it = [sensitivities(problem, x, **{f"{kind}s": (dof,)}) for x in points[:_TRIED]]
            tried[dof] = with_it, expected_covariance(with_it, noise)
        if not tried:
            continue
        best = min(tried, key=lambda dof: float(np.trace(tried[dof][1])))
        with_it, then = tried[best]
        if np.trace(then) >= (1.0 - _WORTH) * np.trace(now):
            continue
        before, after = (len(each) - _count_open(each) for each in (now, then))
        least, larger = (np.median([_singular_values(j, noise)[-1] for j in js]) for js in (own, with_it))
        gain = f", smallest singular value {larger:.2g} instead of {least:.2g}" if least >= _SEEN else ""
        told = f"{after} of {len(now)} combinations are told instead of {before}{gain}"
        found.append(f"A {kind} at {problem.model.dof_label(best)} as well: {told}.")
    return found


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
    return int(np.sum(np.linalg.eigvalsh(covariance) >= BoxIdentifiability.TOLD**2))


def _alike(names: Sequence[str], jacobians: Sequence[FloatArray]) -> list[str]:
    """Pairs whose columns are all but one, at nine of ten points."""
    cosines = []
    for jacobian in jacobians:
        length = np.linalg.norm(jacobian, axis=0)
        unit = jacobian / np.where(length > 0.0, length, 1.0)
        cosines.append(unit.T @ unit)
    usual = np.quantile(np.abs(cosines), 0.1, axis=0)
    pairs = np.argwhere(np.triu(usual, 1) > _ALIKE)
    found = [(names[a], names[b], f"(cosine {usual[a, b]:.3f})") for a, b in pairs[:4]]
    return [f"One parameter for {a} and {b}: they move the values alike {how}." for a, b, how in found]
