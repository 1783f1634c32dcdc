"""What was measured, as an updating problem sees it: antiresonances, or resonances with their shapes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from itertools import islice
from typing import Any, TypeAlias

import numpy as np

from .. import _core
from ..exceptions import InvalidInputError, reject
from ..measured.antiresonance_set import AntiresonanceSet, number
from ..measured.modal_set import ModalSet
from ..measured.response_table import label_array
from ..models.structural_model import End, StructuralModel
from ..support.checks import BoolArray, ComplexArray, FloatArray, IntArray, label_text, members, real_array
from ..support.values import Value

# -- Measured frequencies beside those of a model, before and after updating


def signed(percent: float) -> str:
    """A difference with its sign; what rounds to nothing has none; a dash where there is no partner."""
    said = number(percent, 2, sign=True)
    return "0.00" if said in ("+0.00", "-0.00") else said


class _Differences:
    """What both tables say about their frequencies."""

    measured_hz: FloatArray
    before_hz: FloatArray
    after_hz: FloatArray
    corrected: bool

    @property
    def before_percent(self) -> FloatArray:
        """Difference of the nominal model, ``100 (f_A / f_E - 1)``, (m,)."""
        return 100.0 * (self.before_hz / self.measured_hz - 1.0)

    @property
    def after_percent(self) -> FloatArray:
        """The same of the updated model, (m,)."""
        return 100.0 * (self.after_hz / self.measured_hz - 1.0)

    @property
    def largest_before_percent(self) -> float:
        """Largest absolute difference before; NaN if nothing has a partner."""
        return float(np.fmax.reduce(np.abs(self.before_percent), initial=np.nan))

    @property
    def largest_after_percent(self) -> float:
        """Largest absolute difference after; NaN if nothing has a partner."""
        return float(np.fmax.reduce(np.abs(self.after_percent), initial=np.nan))

    @property
    def _what(self) -> str:
        return "corrected" if self.corrected else "measured"

    @property
    def _closing(self) -> str:
        """The largest differences, without numbers where nothing has a partner."""
        if not self.measured_hz.size:
            return "nothing was measured"
        both = {"before": self.largest_before_percent, "after": self.largest_after_percent}
        if np.isnan([*both.values()]).all():
            return "largest difference: none, no value has a partner in the model"
        said = [f"{'no partner' if x != x else f'{x:.2f} %'} {when}" for when, x in both.items()]
        return f"largest difference: {', '.join(said)}"

    def _text(self, head: list[str], labels: Sequence[str], *modes: tuple[FloatArray, FloatArray]) -> str:
        """The table in print; ``modes`` are numbers of partners and MAC of both states, where there are."""
        states = ((self.before_hz, self.before_percent), (self.after_hz, self.after_percent))
        lines = [*head]
        for row, label in enumerate(labels):
            line = f"{label} {self.measured_hz[row]:10.3f}"
            for state, (hz, percent) in enumerate(states):
                line += f"  {number(modes[state][0][row], 0):>4}" if modes else ""
                line += f"  {number(hz[row], 3):>10} {signed(percent[row]):>7}"
                line += f" {number(modes[state][1][row], 3):>6}" if modes else ""
            lines.append(line)
        return "\n".join([*lines, self._closing])


@dataclass(frozen=True, eq=False)
class FrequencyTable(_Differences, Value):
    """Measured antiresonances beside those of the model, before and after.

    Attributes
    ----------
    dof, excitation, dof_names : ndarray of int, (m,), and dict of int to str
        Response and force, zero-based, and their names, for models that have some ("mass 3"), shown in print.
        Of several forces at once the arrays hold tuples of dofs.
    corrected : bool
        Whether ``measured_hz`` are corrected by a baseline: without what the model lacks in both states.
    measured_hz, before_hz, after_hz : ndarray, (m,)
        Frequencies; NaN where the model has no partner.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> columns = [0, 1], [0, 0], [10.0, 20.0], [10.4, 19.0], [10.1, 20.0]
    >>> ar.FrequencyTable(*map(np.array, columns)).before_percent.round(2)
    array([ 4., -5.])
    """

    dof: FloatArray
    excitation: FloatArray
    measured_hz: FloatArray
    before_hz: FloatArray
    after_hz: FloatArray
    dof_names: dict[int, str] = field(default_factory=dict)
    corrected: bool = False

    def named(self, end: Any, otherwise: str = "{}", *, listed: bool = False) -> str:
        """A response or force by the names of its dofs; ``otherwise`` of what has none."""
        return label_text(end, lambda dof: self.dof_names.get(dof, otherwise.format(dof)), listed=listed)

    def __str__(self) -> str:
        ends = list(zip(self.dof.tolist(), self.excitation.tolist(), strict=True))
        several = any(isinstance(end, tuple) for pair in ends for end in pair)
        number = "{}" if several else "{:2d}"
        pairs = [", ".join(self.named(end, number, listed=True) for end in pair) for pair in ends]
        width = max([7, *map(len, pairs)])
        minor, of = ("det H_IJ", "(I, J)") if several else ("H_ik", "(i, k)")
        head = [
            f"{minor:>{width}}  {self._what:>9s}      before             after",
            f"{of:>{width}}         Hz          Hz       %          Hz       %",
        ]
        return self._text(head, [f"{pair:>{width}}" for pair in pairs])


@dataclass(frozen=True, eq=False)
class ModalTable(_Differences, Value):
    """Measured resonances and shapes beside those of the model, before and after.

    Attributes
    ----------
    mode : ndarray of int, (m,)
        Number of the mode among those measured together, from 0.
    measured_hz, before_hz, after_hz, before_mac, after_mac : ndarray, (m,)
        Resonances, and MAC of the measured shape with the partner's; NaN where the model has none.
    corrected : bool
        As of a :class:`FrequencyTable`.
    before_mode, after_mode : ndarray, (m,), or None
        Number of the partner among the modes of the model, from 0, rigid-body ones counted; NaN likewise.

    Examples
    --------
    >>> import antires_rs as ar
    >>> case = ar.cases.chain8(perturbation=0.05, rng=3)
    >>> bool((ar.update(case.updating_problem(case.exact_modes()), rng=0).table.after_mac > 0.99).all())
    True
    """

    mode: FloatArray
    measured_hz: FloatArray
    before_hz: FloatArray
    after_hz: FloatArray
    before_mac: FloatArray
    after_mac: FloatArray
    before_mode: FloatArray | None = None
    after_mode: FloatArray | None = None
    corrected: bool = field(default=False, kw_only=True)

    @property
    def partners(self) -> tuple[FloatArray, FloatArray]:
        """Numbers of the partners before and after, (m,) each, NaN where they are not known."""
        unknown = np.full(self.mode.shape, np.nan)
        before, after = (unknown if n is None else n for n in (self.before_mode, self.after_mode))
        return before, after

    def __str__(self) -> str:
        head = [
            f"mode  {self._what:>9s}      before                            after",
            "             Hz  mode          Hz       %    MAC  mode          Hz       %    MAC",
        ]
        both = zip(self.partners, (self.before_mac, self.after_mac), strict=True)
        return self._text(head, [f"{mode:4d}" for mode in self.mode], *both)


# -- Measured values that are no antiresonances: halves of complex zeros (see the page on theory)
#
# A value is left out, and named, if the nominal model has a complex zero nearer to it than any real root, its
# damping being nearer to a half of that than to the median of the set; or one so much nearer that damping
# need not tell; or if its damping is far from the median.

_LEAST_KNOWN = 4  # damping ratios whose median says what is usual
_LEAST, _MOST = 0.005, 0.15  # imaginary share: less is beside a double antiresonance, more is no dip
_REAL = 1e-6  # imaginary parts up to this share are rounding
_REACH = 0.10  # a model is right to this share in frequency
_CLEAR, _FAR = 0.01, 0.05  # a complex zero within the first, no real one within the second, tells by itself
_ODD, _ODD_TIMES = 0.02, 2.0  # differences from the median that no antiresonance has, absolute and times it
_MODES = 6.0  # modes up to this multiple of the band make the series
Series = Callable[[], tuple[FloatArray, FloatArray]]  # complex zeros, as below


@lru_cache(2)  # all responses and sets of a test ask for the same ones; of large models they take seconds
def _modes_of_series(model: StructuralModel, f_max_hz: float) -> ModalSet:
    first = model.modes(n_modes=1).freq_hz
    if first.size and first[0] > _MODES * f_max_hz:
        got = f"one whose first resonance is {first[0]:.3g} Hz"
        wanted = f"resonances near the values, up to {f_max_hz:.4g} Hz"
        reject("model", got, wanted, "Check its units: m, kg, N, Pa.")
    return model.modes(f_max_hz=_MODES * f_max_hz)


def complex_zeros(
    model: StructuralModel,
    response: End,
    excitation: End,
    f_max_hz: float,
    parts: tuple[float, float] = (_LEAST, _MOST),
) -> tuple[FloatArray, FloatArray]:
    """Complex zeros f (1 + j d) of an undamped response up to a frequency: f (Hz), and d within ``parts``."""
    from scipy.linalg import eigvals

    modes = _modes_of_series(model, f_max_hz)
    n, rows, columns = modes.freq_hz.size, members(response), members(excitation)
    # Eigenvalues x of the pencil [[L - x, phi_k], [phi_i', 0]], L being the diagonal of the eigenvalues, in
    # units of the band, so that the lowest are not lost in rounding.
    pencil, mass = np.zeros((n + len(rows), n + len(rows))), np.eye(n + len(rows))
    pencil[np.arange(n), np.arange(n)] = (modes.freq_hz / f_max_hz) ** 2
    shapes = modes.shapes.real / np.abs(modes.shapes).max(initial=1e-300)
    pencil[:n, n:], pencil[n:, :n] = shapes[:, columns], shapes[:, rows].T
    mass[n:, n:] = 0.0
    upper, lower = eigvals(pencil, mass, homogeneous_eigvals=True)
    finite = np.abs(lower) > 1e-12 * np.abs(upper)
    root = np.sqrt((upper[finite] / lower[finite]).astype(complex))
    freq = np.abs(root) * f_max_hz
    part = np.abs(root.imag) / np.abs(root)
    kept = (root.imag > 0.0) & (part > parts[0]) & (part <= parts[1]) & (freq <= f_max_hz)
    order = np.flatnonzero(kept)[np.argsort(freq[kept])]
    return freq[order], part[order]


def zeros_beside(
    model: StructuralModel, responses: Sequence[End], force: End, highest_hz: float
) -> list[tuple[FloatArray, Series]]:
    """Real zeros (Hz) of each response that values up to a frequency may be near, and its complex ones."""
    limit_hz = (1.0 + 2.0 * _REACH) * highest_hz
    found = roots_of(model, responses, force, limit_hz, True)
    series = [partial(complex_zeros, model, dof, force, limit_hz, (_REAL, _MOST)) for dof in responses]
    none = np.empty(0)
    return [(none if real is None else real, own) for real, own in zip(found, series, strict=True)]


def usual_damping(found: AntiresonanceSet) -> float | None:
    """The median damping ratio of a set; None where too few are known."""
    known = np.concatenate([np.empty(0), *(table.damping_ratio for table in found.tables.values())])
    known = known[np.isfinite(known)]
    return float(np.median(known)) if known.size >= _LEAST_KNOWN else None


def sorted_out(
    place: str, table: Any, usual: float, roots: FloatArray, series: Series, keep: BoolArray
) -> list[str]:
    """Sentences on the values that are no antiresonances, as ``keep`` then says; ``roots``: the real ones."""
    excess = np.abs(table.damping_ratio - usual)
    to_real = np.abs(table.freq_hz[:, None] - roots).min(axis=1, initial=np.inf)
    odd = ((excess > _LEAST / 2.0) | (to_real > _FAR * table.freq_hz)) & ~table.by_hand
    if not odd.any():
        return []
    zeros, notes = series(), []
    for at in np.flatnonzero(odd & np.isfinite(excess)):
        freq = float(table.freq_hz[at])
        if why := _complex(freq, float(excess[at]), usual, float(to_real[at]), *zeros):
            keep[at] = False
            damped = f"damped by {100 * table.damping_ratio[at]:.1f} % (usual: {100 * usual:.1f} %)"
            notes.append(f"Left out: {freq:.2f} Hz at {place}, {damped}: {why}.")
    return notes


def _complex(
    freq: float, excess: float, usual: float, to_real: float, hz: FloatArray, part: FloatArray
) -> str:
    """Why a value is not an antiresonance; nothing if it is one."""
    apart = np.abs(hz - freq)
    is_half = (apart <= min(to_real, _REACH * freq)) & (part >= _LEAST) & (excess > part / 2.0)
    is_half |= (apart <= _CLEAR * freq) & (to_real > _FAR * freq)
    near = np.flatnonzero(is_half)
    if near.size:
        at = near[np.argmin(apart[near])]
        return f"half of a complex zero, in the model {hz[at]:.2f} Hz (1 \u00b1 {part[at]:.3f}j)"
    if excess > max(_ODD, _ODD_TIMES * usual):
        return "half of a complex zero, or spurious; the model has real antiresonances only"
    return ""


# -- Roots of the intact model that a test shows, and how far they can be counted on
#
# The smallest visible damage follows from the antiresonances that both the intact and a damaged structure
# have. Not counted are those that the test does not show, nor new ones, made of zeros that were complex; less
# or not at all those that small differences between the members move far, damage or not.

#: Roots of all responses within this share are one, a hidden mode; and a root is one with a resonance in an
#: FRF.
_SHARED, _ON_POLE = 0.02, 0.005
STEP = 0.005  # loss of stiffness by which a root is tried
#: Sum of the sensitivities of omega squared up to which a root counts in full, and from which on it does not
#: count: by far most have 1 to 3, those of a broken symmetry, or all but double ones, 10 to 10000.
_ORDINARY, _UNSTEADY = 3.0, 6.0
_TWIN = 0.01  # intact roots are as good as one if they lie within this share
_COMPLEX = (1e-6, 0.3)  # shares of imaginary part of zeros that a small change may make antiresonances


def roots_of(
    model: StructuralModel, dofs: Sequence[End], force: End, limit_hz: float, cancelled: bool
) -> list[FloatArray | None]:
    """Roots of each response; None of one that does not respond at all."""
    core, rows = model._core_for([dof for end in (*dofs, force) for dof in members(end)])
    r = len(members(force))
    *responses, forces = (rows[at : at + r] for at in range(0, len(rows), r))
    found = core.antiresonances(responses, forces, limit_hz, "modal", cancelled, False)
    return [None if silent else freq for freq, _, silent, _ in found]


def steady(
    model: StructuralModel,
    moved: Sequence[StructuralModel],
    dofs: list[End],
    force: End,
    limit_hz: float,
    sees: Any,
    channels: list[End],
) -> list[tuple[FloatArray, FloatArray]]:
    """Roots of each response and their weights, 0 for those that do not count, complex ones among them."""
    listed = list(dict.fromkeys([*dofs, *channels]))
    every = {
        dof: None if freq is None else (freq, complex_zeros(model, dof, force, limit_hz, _COMPLEX)[0])
        for dof, freq in zip(listed, roots_of(model, listed, force, limit_hz, True), strict=True)
    }
    none = (np.empty(0), np.empty(0))
    own = [(every[dof] or none)[0] for dof in dofs]
    if sees == "transmissibility":  # shared also where theirs have just become complex
        all_of = {dof: None if both is None else np.concatenate(both) for dof, both in every.items()}
        others = [[all_of[other] for other in channels if other != dof] for dof in dofs]
        hidden = [shared_by_all(*each, _SHARED) for each in zip(own, others, strict=True)]
    else:  # where it is not known what was seen, nothing is hidden
        poles = model.modes(f_max_hz=1.1 * limit_hz).freq_hz if sees == "frf" else np.empty(0)
        hidden = [_near(freq, poles, _ON_POLE) for freq in own]
    change = [np.zeros(freq.size) for freq in own]
    for other in moved:
        for nth, freq in enumerate(roots_of(other, dofs, force, 1.1 * limit_hz, True)):
            if own[nth].size:
                now = np.full(1, np.inf) if freq is None or not freq.size else freq
                nearest = now[np.abs(own[nth][:, None] - now).argmin(axis=1)]
                change[nth] += np.abs((nearest / own[nth]) ** 2 - 1.0) / STEP
    found = []
    for dof, freq, unseen, total in zip(dofs, own, hidden, change, strict=True):
        weight = np.clip((_UNSTEADY - total) / (_UNSTEADY - _ORDINARY), 0.0, 1.0) * ~unseen
        rest = (every[dof] or none)[1]
        found.append((np.append(freq, rest), np.append(weight, np.zeros(rest.size))))
    return found


def followed(own: tuple[FloatArray, FloatArray], now: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Of the roots that are there now, those that an intact one has become, with its weight."""
    roots, weights = own
    if now is None or not now.size or not roots.size:
        return np.empty(0), np.empty(0)
    apart = np.abs(roots[:, None] - now)
    nearest = apart.min(axis=0) + _TWIN * now
    kept = np.zeros(now.size)
    for _ in range(min(apart.shape)):
        row, column = np.unravel_index(np.argmin(apart), apart.shape)
        kept[column] = weights[row] * (apart[row, column] <= nearest[column])
        apart[row], apart[:, column] = np.inf, np.inf
    return now[kept > 0.0], kept[kept > 0.0]


def shared_by_all(freq: FloatArray, others: Iterable[FloatArray | None], within: float) -> BoolArray:
    """Which roots of a response all others that respond have, too; none without any."""
    shared = [_near(freq, own, within) for own in others if own is not None]
    return np.asarray(np.logical_and.reduce(shared or [np.zeros(freq.size, dtype=bool)]))


def _near(freq: FloatArray, others: FloatArray, within: float) -> BoolArray:
    apart = np.abs(freq[:, None] - others)
    return np.asarray(apart.min(axis=1, initial=np.inf) <= within * freq)


# -- Measured antiresonances, as an updating problem sees them: what a set was identified from (``sees``)
# decides which roots of the model may be partners

MODEL_ERROR = 2e-3  # of omega^2, which a model has anyway: values known better get no more weight
_ALIKE = "Leave them out to count all values alike."

Part = tuple[End, End, FloatArray, str | None, int]  # response, force, values (Hz), sees, number of the set
CorePart = tuple[list[int], list[int], FloatArray, str | None, int]
#: What a model would have given if measured exactly, with weights; None if nothing.
Exact = Callable[["StructuralModel"], tuple[list[Any], FloatArray | None] | None]


def by_rows(model: StructuralModel, parts: Sequence[Part]) -> tuple[_core.Model, list[CorePart]]:
    """The core's model in which all measured dofs are dofs, and the parts by its rows."""
    ends = [end for response, force, *_ in parts for end in (response, force)]
    core, rows = model._core_for([dof for end in ends for dof in members(end)])
    row = iter(rows)
    placed: list[CorePart] = []
    for response, force, hz, sees, of_set in parts:
        i = list(islice(row, len(members(response))))
        placed.append((i, list(islice(row, len(members(force)))), hz, sees, of_set))
    return core, placed


def antiresonance_objective(
    model: StructuralModel, parameters: Any, parts: Sequence[Part], *rest: Any
) -> _core.Objective:
    """The core's objective of responses."""
    core, placed = by_rows(model, parts)
    return _core.Objective.antiresonance(core, parameters, placed, *rest)


class AntiresonanceTargets:
    """Antiresonances of one or several positions of the force."""

    noun, objective = "antiresonance", "antiresonance"

    def __init__(self, model: StructuralModel, sets: tuple[AntiresonanceSet, ...]) -> None:
        self.sets = sets
        self.forces = [model._end("excitation", s.excitation) for s in sets]
        self.dofs_of = [[model._end("measured dof", dof) for dof in s] for s in sets]
        self._channels = [measured_together(model, s) for s in sets]
        self.parts: list[Part] = []
        self.single: list[bool] = []  # whether each is of one curve, without averages that tell its scatter
        self.stds: list[FloatArray] = []  # standard deviations (Hz) of their values
        self._kept = np.empty(0, dtype=bool)
        self.left_out: tuple[str, ...] = ()
        for nth in range(len(sets)):
            self._add(model, nth)
        counts = [len(part[2]) for part in self.parts]
        self.hz = np.concatenate([np.empty(0), *(part[2] for part in self.parts)])
        ends = ([part[side] for part in self.parts] for side in (0, 1))
        # Several dofs at once are an entry, not an axis.
        arrays = (np.array(e) if all(isinstance(end, int) for end in e) else label_array(e) for e in ends)
        self.dofs, self.excitations = (np.repeat(own, counts) for own in arrays)
        #: What the tables call the dofs: "mass 3", "node 3 v"; none where they are numbers only.
        named = {dof for i, k, *_ in self.parts for end in (i, k) for dof in members(end)}
        labels = {dof: model.dof_label(dof) for dof in sorted(named)}
        self.names = {d: own.removeprefix("node ") for d, own in labels.items() if own != f"dof {d}"}

    def _add(self, model: StructuralModel, number: int) -> None:
        """The parts of one set: its responses, and channels without values that decide what is shared."""
        found, dofs, force = self.sets[number], self.dofs_of[number], self.forces[number]
        channels, tables = self._channels[number], list(found.tables.values())
        masks = [np.ones(len(table), dtype=bool) for table in tables]
        usual = usual_damping(found)
        if usual is not None:
            zeros = zeros_beside(model, dofs, force, max(found[dof].max(initial=0.0) for dof in found))
            for dof, table, (real, series), keep in zip(dofs, tables, zeros, masks, strict=True):
                place = label_text(dof, model.dof_label)
                self.left_out += tuple(sorted_out(place, table, usual, real, series, keep))
        # Without all that measured together nothing is known to be shared.
        sees = None if found.sees == "transmissibility" and not channels else found.sees
        others = [dof for dof in channels if dof not in dofs] if sees == "transmissibility" else []
        values = [found[dof][mask] for dof, mask in zip(found, masks, strict=True)]
        none = [np.empty(0) for _ in others]
        both = zip([*dofs, *others], [*values, *none], strict=True)
        self.parts += [(dof, force, np.array(freq), sees, number) for dof, freq in both]
        self.stds += [*(t.std_hz[mask] for t, mask in zip(tables, masks, strict=True)), *none]
        self.single += [*("share" in table.scores for table in tables), *(False for _ in others)]
        self._kept = np.concatenate([self._kept, *masks])

    @property
    def relative_std(self) -> FloatArray:
        """Standard deviation of omega squared of each value, relative, (m,); NaN where none is stated."""
        return np.asarray(2.0 * np.concatenate([np.empty(0), *self.stds]) / self.hz)

    def weights(self, given: Any) -> FloatArray | None:
        """Factors on the residuals; from standard deviations their mean is one; None for equal ones."""
        if not (isinstance(given, str) and given == "std"):
            wanted = "None, 'std', or one number for each measured value"
            return _given_weights(given, self.hz.size, self._kept, wanted, _ALIKE)
        spread = self.relative_std
        if not np.isfinite(spread).any():
            remedy = "Identify an averaged record with formulation='numerators', or give std_hz."
            reject("weights", "'std' for values without standard deviations", "sets with std_hz", remedy)
        spread = np.where(np.isfinite(spread), spread, np.nanmedian(spread))
        made = 1.0 / np.hypot(spread, MODEL_ERROR)
        return np.asarray(made / made.mean(), dtype=np.float64)

    def core(self, model: StructuralModel, parameters: Any, *rest: Any) -> _core.Objective:
        """The core's objective."""
        return antiresonance_objective(model, parameters, self.parts, *rest)

    def residuals(self, core: _core.Objective, x: FloatArray) -> FloatArray:
        """Signed residuals e at ``x``; 1 without a partner."""
        found = core.residuals(x)
        assert found is not None  # an objective of antiresonances has them
        return found

    errors = residuals  # differences that a Gaussian likelihood is of, row by row

    def error_rows(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Measured value, kind (0 for frequencies, 1 for entries of shapes) and stated error of each row."""
        return np.arange(self.hz.size), np.zeros(self.hz.size, dtype=np.intp), self.relative_std

    def table(self, core: _core.Objective, x: Sequence[FloatArray], _: object) -> FrequencyTable:
        """Measured, before and after."""
        before, after = (core.pairs(at)[0] for at in x)
        return FrequencyTable(self.dofs, self.excitations, self.hz, before, after, self.names)

    def exact(self, nominal: StructuralModel, _: FloatArray, moved: Sequence[StructuralModel]) -> Exact:
        """Antiresonances up to the highest measured one that can be followed from the nominal model."""
        band_hz = float(self.hz.max())
        tests = list(zip(self.sets, self.dofs_of, self.forces, self._channels, strict=True))
        intact = [steady(nominal, moved, d, f, 1.5 * band_hz, s.sees, ch) for s, d, f, ch in tests]

        def measured(model: StructuralModel) -> tuple[list[Any], FloatArray | None] | None:
            found, weights = [], [np.empty(0)]
            for (s, dofs, force, _), roots in zip(tests, intact, strict=True):
                there = roots_of(model, dofs, force, band_hz, s.sees != "frf")
                # Below the band a root on its way to zero would differ without bound.
                there = [None if freq is None else freq[freq >= 0.5 * self.hz.min()] for freq in there]
                both = [followed(own, now) for own, now in zip(roots, there, strict=True)]
                columns = dict(zip(s, (freq for freq, _ in both), strict=True))
                found.append(AntiresonanceSet(s.excitation, columns, sees=s.sees, channels=s.channels))
                weights += [weight for _, weight in both]
            joined = np.concatenate(weights)
            return (found, joined) if joined.size else None

        return measured


def measured_together(model: StructuralModel, found: AntiresonanceSet) -> list[End]:
    """All responses that were measured together, none where one is no dof of the model.

    Of r forces every r channels are a response. What the keys of the set, and the sets of r channels next to
    each other, all share is taken for what all of them share.
    """
    try:
        dofs, r = [model._dof("dof", dof) for dof in found.channels], found.order
        if r == 1 or len(dofs) <= r:
            return [*dofs] if r == 1 else [model._end("dof", key) for key in found] if dofs else []
        keys = [tuple(sorted(model._dof("dof", dof) for dof in key)) for key in found]
        beside = [tuple(sorted((dofs * 2)[at : at + r])) for at in range(len(dofs))]
        known = {frozenset(key): model._end("dof", one) for key, one in zip(keys, found, strict=True)}
        return [known.get(frozenset(key), key) for key in dict.fromkeys([*keys, *beside])]
    except InvalidInputError:
        return []


def _given_weights(
    given: Any, count: int, kept: BoolArray | None, wanted: str, remedy: str
) -> FloatArray | None:
    """Weights as they were given, for the values compared or, by ``kept``, for all that were measured."""
    if given is None:
        return None
    if isinstance(given, str):
        reject("weights", repr(given), wanted, remedy)
    wanted = f"{count} numbers of at least 0, one for each measured value"
    found = real_array("weights", given, ndim=1, wanted=wanted)
    if kept is not None and found.size == kept.size:
        found = found[kept]
    if found.size != count or found.min() < 0.0 or not found.any():
        reject("weights", f"{found.size} numbers from {found.min():g} to {found.max():g}", wanted, _ALIKE)
    return found


_AT_REST = 1e-9  # smaller than this, relative to its largest entry, a shape cannot be measured at its dofs


class ModalTargets:
    """Resonances and shapes, of one or several sets of sensors. Rigid-body modes, at 0 Hz, are left out."""

    noun, objective = "mode", "modal"
    left_out: tuple[str, ...] = ()

    def __init__(self, model: StructuralModel, sets: tuple[ModalSet, ...]) -> None:
        self.sets = sets
        self._dofs = [[model._dof("measured dof", dof) for dof in each.dofs] for each in sets]
        rows = model._core_for([dof for dofs in self._dofs for dof in dofs])[1]
        ends = np.cumsum([0, *map(len, self._dofs)])
        #: Frequencies, rows of the core's matrices, and shapes of each set.
        self._parts: list[tuple[FloatArray, list[int], ComplexArray]] = []
        for each, a, b in zip(sets, ends[:-1], ends[1:], strict=True):
            flexible = each.freq_hz != 0.0
            shapes = np.ascontiguousarray(each.shapes[flexible], dtype=np.complex128)
            self._parts.append((each.freq_hz[flexible], rows[a:b], shapes))
        self.hz = np.concatenate([freq for freq, _, _ in self._parts])
        self.numbers = np.concatenate([np.flatnonzero(each.freq_hz != 0.0) for each in sets])

    def weights(self, given: Any) -> FloatArray | None:
        """Factors on the residuals, one a mode; None for equal ones."""
        wanted = "None, or one number for each measured mode"
        return _given_weights(given, self.hz.size, None, wanted, "A ModalSet has no standard deviations.")

    def core(self, model: StructuralModel, parameters: Any, *rest: Any) -> _core.Objective:
        """The core's objective."""
        core = model._core_for([dof for dofs in self._dofs for dof in dofs])[0]
        return _core.Objective.modal(core, parameters, self._parts, *rest)

    @staticmethod
    def pairs(core: _core.Objective, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Frequency, MAC and shape of the partners, NaN without one."""
        freq, shapes = core.pairs(x)
        assert shapes is not None  # a modal objective has them
        return freq, *shapes

    def residuals(self, core: _core.Objective, x: FloatArray) -> FloatArray:
        """The m of the frequencies, then the m of the shapes, 1 - MAC."""
        paired, mac, _ = self.pairs(core, x)
        both = np.concatenate([(paired / self.hz) ** 2 - 1.0, 1.0 - mac])
        return np.where(np.isnan(both), 1.0, both)

    def errors(self, core: _core.Objective, x: FloatArray) -> FloatArray:
        """As of antiresonances; of shapes at unit length, for 1 - MAC has no slope at a perfect fit."""
        paired, _, shapes = self.pairs(core, x)
        found = [np.where(np.isnan(paired), 1.0, (paired / self.hz) ** 2 - 1.0)]
        partners = iter(np.nan_to_num(shapes))
        for freq, rows, measured in self._parts:
            own = _unit(np.reshape(list(islice(partners, freq.size)), (freq.size, -1))[:, rows])
            # Along its longest real direction a measured shape has the phase that a mode of the model has.
            turned = np.exp(-0.5j * np.angle(np.sum(measured**2, axis=1, keepdims=True)))
            found.append(_apart(_unit((measured * turned).real), own))
        return np.concatenate(found)

    def error_rows(self) -> tuple[IntArray, IntArray, FloatArray]:
        """As of antiresonances; no errors are stated."""
        number = np.arange(self.hz.size)
        entries = np.repeat(number, [len(rows) for freq, rows, _ in self._parts for _ in freq])
        kind = np.repeat(np.arange(2), [number.size, entries.size])
        return np.append(number, entries), kind, np.full(kind.size, np.nan)

    def table(
        self, core: _core.Objective, x: Sequence[FloatArray], models: Callable[[FloatArray], StructuralModel]
    ) -> ModalTable:
        """Measured, before and after, with the numbers of the partners among the modes of ``models``."""
        (hz, mac, _), (hz_after, mac_after, _) = (self.pairs(core, at) for at in x)
        numbers = []
        for own, at in zip((hz, hz_after), x, strict=True):
            found = np.isfinite(own)
            number = np.full(own.size, np.nan)
            if found.any():
                there = models(at).modes(f_max_hz=1.01 * float(own[found].max())).freq_hz
                number[found] = np.argmin(np.abs(there - own[found][:, None]), axis=1)
            numbers.append(number)
        return ModalTable(self.numbers, self.hz, hz, hz_after, mac, mac_after, *numbers)

    def exact(self, nominal: StructuralModel, nominal_hz: FloatArray, _: Sequence[StructuralModel]) -> Exact:
        """The modes whose numbers are those of the nominal model's partners."""
        intact = nominal.modes()

        def measured(model: StructuralModel) -> tuple[list[Any], FloatArray | None] | None:
            modes, found, first = model.modes(), [], 0
            for (freq, _, _), dofs in zip(self._parts, self._dofs, strict=True):
                partners = nominal_hz[first : first + len(freq)]
                first += len(freq)
                near = np.abs(intact.freq_hz - partners[np.isfinite(partners)][:, None])
                numbers = np.unique(np.argmin(near, axis=1)).astype(int)
                shapes = modes.shapes[numbers]
                at = shapes[:, dofs]
                moving = np.linalg.norm(at, axis=1) > _AT_REST * np.abs(shapes).max(axis=1, initial=0.0)
                found.append(ModalSet(modes.freq_hz[numbers][moving], at[moving], dofs))
            return (found, None) if any(np.any(s.freq_hz > 0.0) for s in found) else None

        return measured


def _unit(shapes: FloatArray) -> FloatArray:
    """Shapes at unit length, a row each; zero stays zero."""
    size = np.linalg.norm(shapes, axis=1, keepdims=True)
    return np.asarray(shapes / np.where(size > 0.0, size, 1.0))


def _apart(one: FloatArray, other: FloatArray) -> FloatArray:
    """Differences of two sets of shapes, with the sign of the second in which they are least."""
    sign = np.where(np.sum(one * other, axis=1, keepdims=True) < 0.0, -1.0, 1.0)
    return np.asarray((sign * other - one).ravel())


Targets: TypeAlias = AntiresonanceTargets | ModalTargets


def sets_of(name: str, given: Any, *, modes: bool = True) -> tuple[Any, ...]:
    """One or several measured sets of one kind."""
    kinds = (AntiresonanceSet, ModalSet) if modes else (AntiresonanceSet,)
    sets = (given,) if isinstance(given, kinds) else given
    listed = isinstance(sets, Sequence) and len(sets) > 0
    if not (listed and any(all(isinstance(each, kind) for each in sets) for kind in kinds)):
        wanted = f"an AntiresonanceSet{' or a ModalSet' if modes else ''}, or several of one kind"
        remedy = "Identify it first, or build it from a table: AntiresonanceSet(0, {0: [12.2, 36.2]})."
        reject(name, given, wanted, remedy)
    return tuple(sets)


def targets_of(model: StructuralModel, measured: Any, objective: str | None) -> Targets:
    """The kind that the measured sets are, which must be the one asked for."""
    sets = sets_of("measured", measured)
    kind: Any = AntiresonanceTargets if isinstance(sets[0], AntiresonanceSet) else ModalTargets
    if objective is not None and objective != kind.objective:
        needed = "an AntiresonanceSet" if objective == "antiresonance" else "a ModalSet"
        remedy = "Leave objective out: the measured set tells it."
        reject("measured", f"a {type(sets[0]).__name__}", f"{needed} for objective={objective!r}", remedy)
    made: Targets = kind(model, sets)
    return made
