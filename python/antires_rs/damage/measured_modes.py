"""Two states of a structure measured by their modes: natural frequencies and shapes, side by side."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..exceptions import reject
from ..measured.modal_set import ModalSet
from ..support.checks import FloatArray
from .measured_states import ASSUMED_STD, LEAST_STD, Column, Roots, Values, same_data

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel


# -- Modes of the model as roots: a natural frequency each, and where its shape lies beside the intact one
#
# A shape u of unit length at n sensors is told by its n - 1 coordinates :math:`a = Q^T (u' - u)` in an
# orthonormal basis Q across it, which neither sign nor size touches. Along a change of the model the basis is
# turned with the shape, without rotation about it: its error has the same coordinates in both states.

#: Modes whose frequencies lie nearer together (ln f): the model does not tell how their shapes mix.
_MIXED = 1e-3
#: Weight of a difference in ln f against one of MAC; and the least likeness of what may be the same mode.
_BY_FREQUENCY, _ALIKE = 0.5, 0.1


@dataclass(frozen=True)
class ModeRoots(Roots):
    """Modes: of each ln f, then the coordinates of its shape beside the intact model's, in ``log_f``."""

    shapes: tuple[FloatArray, ...]  # of each group of sensors, unit length, (modes, n)
    bases: tuple[FloatArray, ...]  # across these, (modes, n, n - 1)
    mixed: NDArray[np.bool_]  # whether another mode is so near that the shape says nothing, (modes,)
    _has_shapes = True

    @property
    def each(self) -> int:
        """Roots that a mode has: its frequency and the coordinates of its shape."""
        return 1 + sum(int(basis.shape[2]) for basis in self.bases)

    @property
    def frequencies(self) -> FloatArray:
        """ln f of each mode."""
        return self.log_f[:: self.each]

    def coordinates(self, group: Any) -> slice:
        """Where those of a group are, among the roots of a mode."""
        sizes = [1, *(basis.shape[2] for basis in self.bases)]
        first = int(sum(sizes[: group + 1]))
        return slice(first, first + sizes[group + 1])

    def between(self, low: float, high: float) -> NDArray[np.bool_]:
        """Which belong to a mode between two ln f."""
        return np.repeat((self.frequencies > low) & (self.frequencies < high), self.each)

    def only(self, kept: NDArray[np.bool_]) -> ModeRoots:
        """Some of the modes; ``kept`` is by root."""
        modes, rest = kept[:: self.each], super().only(kept)
        assert isinstance(rest, ModeRoots)
        shapes, bases = (tuple(each[modes] for each in own) for own in (self.shapes, self.bases))
        return replace(rest, shapes=shapes, bases=bases, mixed=self.mixed[modes])

    def since(self, before: Roots) -> tuple[Roots, NDArray[np.intp]]:
        """These with their shapes turned from those of ``before``, and which root there each has been."""
        from scipy.optimize import linear_sum_assignment

        assert isinstance(before, ModeRoots)
        both = zip(self.shapes, before.shapes, strict=True)
        alike = np.mean([(own @ theirs.T) ** 2 for own, theirs in both], axis=0)  # MAC over all groups
        cost = 1.0 - alike + _BY_FREQUENCY * np.abs(self.frequencies[:, None] - before.frequencies)
        rows, columns = linear_sum_assignment(cost)
        same = alike[rows, columns] > _ALIKE
        was = np.full(self.frequencies.size, -1)
        was[rows[same]] = columns[same]
        place = self.log_f.reshape(was.size, self.each).copy()
        slopes = self.slopes.reshape(was.size, self.each, -1).copy() if len(self.slopes) else None
        old = np.flatnonzero(was >= 0)
        bases, faced = [], []
        for group, (shapes, basis) in enumerate(zip(self.shapes, self.bases, strict=True)):
            at = self.coordinates(group)
            known = before.shapes[group][was[old]]
            facing = np.ones(was.size)
            facing[old] = np.where(np.sum(known * shapes[old], axis=1) < 0.0, -1.0, 1.0)
            shapes = facing[:, None] * shapes
            turned = basis.copy()
            turned[old] = _turned(known, shapes[old], before.bases[group][was[old]])
            if slopes is not None:  # slopes are coordinates as well
                slopes[:, at] = facing[:, None, None] * (turned.transpose(0, 2, 1) @ (basis @ slopes[:, at]))
            place[:, at] = 0.0
            place[old, at] = -np.einsum("mij,mi->mj", turned[old], known)
            bases.append(turned)
            faced.append(shapes)
        identity = np.where(was[:, None] >= 0, was[:, None] * self.each + np.arange(self.each), -1)
        moved_slopes = self.slopes if slopes is None else slopes.reshape(self.slopes.shape)
        seen = replace(self, log_f=place.ravel(), slopes=moved_slopes)
        return replace(seen, shapes=tuple(faced), bases=tuple(bases)), identity.ravel()


@dataclass(frozen=True)
class ModeSource:
    """The modes of a model at any state; ``groups`` are the sensors of each setup, in the core's order."""

    core: _core.Objective
    groups: tuple[NDArray[np.intp], ...]

    def roots(self, candidates: FloatArray, slopes: bool, threads: int) -> list[Roots]:
        """The modes at each row of ``candidates`` (m, n)."""
        found = self.core.modal_states(np.ascontiguousarray(candidates), slopes, threads)
        return [self._roots(*state, slopes) for state in found]

    def _roots(
        self, hz: FloatArray, at: FloatArray, logs: FloatArray, moves: FloatArray, with_slopes: bool
    ) -> ModeRoots:
        log_f = np.log(hz)
        gap = np.diff(log_f, prepend=-np.inf, append=np.inf)
        shapes, bases, rows, response = [], [], [logs[:, None, :]], [0]
        for number, own in enumerate(self.groups):
            size = np.linalg.norm(at[:, own], axis=1)
            size = np.where(size > 0.0, size, 1.0)  # at rest there, and never measured there
            unit = at[:, own] / size[:, None]
            basis = _across(unit)
            shapes.append(unit)
            bases.append(basis)
            response += [1 + number] * basis.shape[2]
            if with_slopes:
                rows.append(basis.transpose(0, 2, 1) @ (moves[:, own] / size[:, None, None]))
        places = np.zeros((hz.size, len(response)))
        places[:, 0] = log_f
        every = np.tile(np.array(response, dtype=np.intp), hz.size)
        joined = np.concatenate(rows, axis=1).reshape(every.size, -1) if with_slopes else logs
        mixed = np.minimum(gap[:-1], gap[1:]) < _MIXED
        return ModeRoots(every, places.ravel(), joined, tuple(shapes), tuple(bases), mixed)


def _across(unit: FloatArray) -> FloatArray:
    """An orthonormal basis (m, n, n - 1) of what is across each row (m, n)."""
    n = unit.shape[1]
    # The reflection that takes a coordinate axis to the shape takes the others across it.
    mirror = unit.copy()
    mirror[:, 0] += np.where(unit[:, 0] < 0.0, -1.0, 1.0)
    mirror /= np.linalg.norm(mirror, axis=1, keepdims=True)
    return np.asarray((np.eye(n) - 2.0 * mirror[:, :, None] * mirror[:, None, :])[:, :, 1:])


def _turned(old: FloatArray, new: FloatArray, basis: FloatArray) -> FloatArray:
    """Bases (m, n, n - 1) across old shapes, turned with these to the new ones in their common plane."""
    both = old + new
    part = np.einsum("mi,mij->mj", both, basis) / (1.0 + np.sum(old * new, axis=1))[:, None]
    return np.asarray(basis - both[:, :, None] * part[:, None, :])


# -- Measured modes as values: a natural frequency each, and where its shape lies beside a mode of the model

_HALF_LOG_TAU = 0.5 * float(np.log(2.0 * np.pi))
_NEVER = 1e12  # more than any price
#: In the scan: weight of an angle between shapes (rad) against ln f, and the farthest that counts.
_ANGLE, _FAR = 0.3, 0.2


@dataclass(frozen=True)
class ModeValues(Values):
    """Of each mode its ln f, then 0 for the coordinates of its shape, which depend on its partner."""

    start: NDArray[np.intp]  # the first value of each mode
    group: NDArray[np.intp]  # its sensors
    shape: tuple[FloatArray, ...]  # its unit shape there
    _has_shapes = True

    @cached_property
    def plain(self) -> Values:
        """Frequencies alone."""
        at = self.start
        return Values(self.response[at], self.log_f[at], self.std[at], self.test[at])

    def times_measured(self, response: NDArray[np.intp]) -> FloatArray:
        """A mode moves the sensors of every test."""
        return np.full(response.size, float(self.tests.size))

    def own(self, mode: int) -> slice:
        """The values of a mode."""
        start = int(self.start[mode])
        return slice(start, start + self.shape[mode].size)

    def associated(
        self,
        roots: Roots,
        place: FloatArray,
        sigma: FloatArray,
        alone: float,
        price: FloatArray,
        wider: float = 1.0,
    ) -> tuple[NDArray[np.intp], FloatArray, float]:
        """As those of the base class, but that frequency and shape decide together, one to one within a test.
        A false mode has any shape."""
        from scipy.optimize import linear_sum_assignment

        assert isinstance(roots, ModeRoots)
        found, seen, lost = np.full(self.size, -1), self.log_f.copy(), 0.0
        any_shape = np.array([_any_shape(shape.size) for shape in self.shape])
        if not roots.size:
            return found, seen, float(np.sum(alone + any_shape))
        for test in np.unique(self.test[self.start]):
            modes = np.flatnonzero(self.test[self.start] == test)
            pairs = [self._beside(int(mode), roots, place, sigma, wider) for mode in modes]
            cost = np.array([own for own, _ in pairs]) + price[:: roots.each]
            single = alone + any_shape[modes]
            alone_too = np.where(np.eye(modes.size, dtype=bool), single, _NEVER)
            for row, column in zip(*linear_sum_assignment(np.hstack([cost, alone_too])), strict=True):
                if column >= cost.shape[1]:
                    lost += single[row]
                    continue
                own, at = self.own(modes[row]), column * roots.each
                found[own.start] = at
                if roots.mixed[column]:
                    lost += any_shape[modes[row]]
                    continue
                places = np.arange(roots.each)[roots.coordinates(self.group[modes[row]])]
                found[own.start + 1 : own.stop] = at + places
                seen[own.start + 1 : own.stop] = pairs[row][1][column]
        return found, seen, lost

    def _beside(
        self, mode: int, roots: ModeRoots, place: FloatArray, sigma: FloatArray, wider: float
    ) -> tuple[FloatArray, FloatArray]:
        """What it costs that a mode belongs to each of the model's, and its shape as seen from these."""
        own, group, shape = self.own(mode), self.group[mode], self.shape[mode]
        at = roots.coordinates(group)
        log_f, places, sigmas = (each.reshape(-1, roots.each) for each in (roots.log_f, place, sigma))

        def cost(value: Any, std: FloatArray, columns: Any) -> FloatArray:
            wide = np.hypot(wider * std, sigmas[:, columns])
            apart = (value - places[:, columns]) / wide
            return np.asarray(0.5 * apart**2 + np.log(wide) + _HALF_LOG_TAU)

        facing = np.where(roots.shapes[group] @ shape < 0.0, -1.0, 1.0)
        seen = log_f[:, at] + facing[:, None] * np.einsum("rij,i->rj", roots.bases[group], shape)
        of_shape = np.sum(cost(seen, self.std[own.start + 1 : own.stop], at), axis=1)
        of_frequency = cost(self.log_f[own.start], self.std[own.start], 0)
        return of_frequency + np.where(roots.mixed, _any_shape(shape.size), of_shape), seen

    def unexplained(self, roots: Roots, place: FloatArray) -> float:
        """Sum of the distances of the modes from the nearest of the model, shapes considered."""
        assert isinstance(roots, ModeRoots)
        total, frequencies = 0.0, place[:: roots.each]
        for mode, group in enumerate(self.group):
            alike = np.clip(np.abs(roots.shapes[group] @ self.shape[mode]), 0.0, 1.0)
            angle = np.where(roots.mixed, 0.0, np.arccos(alike))
            apart = np.abs(self.plain.log_f[mode] - frequencies) + _ANGLE * angle
            total += float(np.minimum(apart, _FAR).min(initial=_FAR))
        return total


def _any_shape(n: int) -> float:
    """Minus the log density of a shape that may be any: half the sphere in n dimensions."""
    from scipy.special import gammaln

    return float(0.5 * n * np.log(np.pi) - gammaln(0.5 * n))


#: Standard deviation of the components of a shape of unit length that states none, and the least.
ASSUMED_SHAPE_STD, _LEAST_SHAPE_STD = 5e-3, 2e-5

_Dofs = tuple[int, ...]  # dofs of the model, ascending


@dataclass(frozen=True)
class ModeResponses:
    """The sensors of all sets of modes."""

    groups: dict[_Dofs, int]
    measured: tuple[ModalSet, ...]
    numbers: tuple[NDArray[np.intp], ...]  #: Of each set of now, the numbers of its flexible modes.
    highest_hz: float
    left_out: tuple[str, ...]
    assumed: bool
    tests: tuple[int, ...]  #: Sensors of each test of the intact structure.
    noun = "modes"

    def source(self, model: StructuralModel, parts: Any) -> ModeSource:
        """The model's modes, to be asked for."""
        own, rows = model._core_for([dof for group in self.groups for dof in group])
        left, hz = iter(rows), np.array([self.highest_hz])
        groups = [[next(left) for _ in group] for group in self.groups]
        asked = [(hz, group, np.ones((1, len(group)), dtype=np.complex128)) for group in groups]
        core = _core.Objective.modal(own, parts, asked, "squared", None, 0.0, None)
        return ModeSource(core, tuple(np.searchsorted(sorted({*rows}), group) for group in groups))

    def corrected(
        self, now: ModeValues, roots: Roots, partner: NDArray[np.intp], beside: FloatArray
    ) -> list[ModalSet]:
        """The sets of now without what is wrong in both states."""
        assert isinstance(roots, ModeRoots)
        sets, modes = [], iter(range(now.start.size))
        for each, kept in zip(self.measured, self.numbers, strict=True):
            freq, shapes = [], []
            for _, mode in zip(kept, modes, strict=False):
                own, group, shape = now.own(mode), int(now.group[mode]), now.shape[mode]
                freq.append(float(np.exp(now.log_f[own.start] - beside[own.start])))
                if (partner[own] >= 0).all() and own.stop > own.start + 1:
                    at = int(partner[own.start]) // roots.each
                    facing = -1.0 if roots.shapes[group][at] @ shape < 0.0 else 1.0
                    shape = facing * shape - roots.bases[group][at] @ beside[own.start + 1 : own.stop]
                shapes.append(shape)
            if freq:
                order, dofs = np.argsort(freq), list(self.groups)[group]
                names = [name for name in ("std_hz", "std_shapes") if getattr(each, name) is not None]
                std = {name: getattr(each, name)[kept][order] for name in names}
                sets.append(ModalSet(np.array(freq)[order], np.array(shapes)[order], dofs, **std))
        return sets


def measured_modes(
    model: StructuralModel, baseline: Sequence[ModalSet], measured: Sequence[ModalSet]
) -> tuple[ModeResponses, ModeValues, ModeValues]:
    """The sensors of all sets, the intact modes and those of now."""

    def dofs_of(each: ModalSet) -> _Dofs:
        return tuple(model._dof("measured dof", dof) for dof in each.dofs)

    listed = [[*map(dofs_of, baseline)], [*map(dofs_of, measured)]]
    before, after = ([tuple(sorted(dofs)) for dofs in each] for each in listed)
    for each, dofs in zip(measured, after, strict=True):
        if before and dofs not in before:
            got, wanted = f"no set at the dofs {list(each.dofs)}", "intact sets with the same sensors"
            remedy = "Test the intact structure with these too, or keep the dofs that both tests have."
            reject("baseline", got, wanted, remedy)
    groups = {dofs: nth for nth, dofs in enumerate(dict.fromkeys((*before, *after)))}
    both = (*baseline, *measured)
    highest = max((float(each.freq_hz.max(initial=0.0)) for each in both), default=0.0)
    if highest <= 0.0:
        reject("measured", "no mode", "at least one", "Identify in a wider band.")
    sides = {"baseline": baseline, "measured": measured}
    told = [same_data(name, [_column(each) for each in sets]) for name, sets in sides.items()]
    twice, notes = [repeats for repeats, _ in told], [note for _, own in told for note in own]
    if any(each.std_shapes is None for each in both):
        share = f"{100 * ASSUMED_SHAPE_STD:g} % of the shape's length"
        notes.insert(0, f"Components of shapes without standard deviation count as known to {share}.")
    flexible = [np.flatnonzero((s.freq_hz > 0.0) & (nth not in twice[1])) for nth, s in enumerate(measured)]
    assumed, tests = any(each.std_hz is None for each in both), tuple(groups[dofs] for dofs in before)
    responses = ModeResponses(groups, tuple(measured), tuple(flexible), highest, tuple(notes), assumed, tests)
    intact = _values("baseline", baseline, listed[0], groups, twice[0])
    return responses, intact, _values("measured", measured, listed[1], groups, twice[1])


def _column(each: ModalSet) -> dict[Any, Column]:
    """Frequencies and shapes, with the standard deviations of the frequencies, by the sensors."""
    std = np.full(each.freq_hz.size, np.nan) if each.std_hz is None else each.std_hz
    return {each.dofs: Column(np.concatenate([each.freq_hz, each.to_real().shapes.ravel()]), std)}


def _values(
    name: str, sets: Sequence[ModalSet], dofs: list[_Dofs], groups: dict[_Dofs, int], twice: Container[int]
) -> ModeValues:
    rows: list[tuple[Any, ...]] = []  # response, ln f, standard deviation, test
    start, group, shape = [], [], []
    for nth, each in enumerate(sets):
        if nth in twice:
            continue
        own = groups[tuple(sorted(dofs[nth]))]
        shapes = each.to_real().shapes[:, np.argsort(dofs[nth])]
        for mode in np.flatnonzero(each.freq_hz > 0.0):
            size = float(np.linalg.norm(shapes[mode]))
            if size == 0.0:
                reject(name, f"mode {mode} at rest at every dof", "shapes that move", "Leave that mode out.")
            of_hz = ASSUMED_STD if each.std_hz is None else each.std_hz[mode] / each.freq_hz[mode]
            of_shape = ASSUMED_SHAPE_STD if each.std_shapes is None else each.std_shapes[mode]
            start.append(len(rows))
            group.append(own)
            shape.append(np.asarray(shapes[mode] / size, dtype=np.float64))
            rows.append((0, np.log(each.freq_hz[mode]), max(float(of_hz), LEAST_STD), nth))
            rows += [(1 + own, 0.0, max(float(of_shape), _LEAST_SHAPE_STD), nth)] * (shapes.shape[1] - 1)
    response, log_f, std, test = np.array(rows, dtype=np.float64).reshape(-1, 4).T.copy()
    numbers: Any = {"start": np.array(start, dtype=np.intp), "group": np.array(group, dtype=np.intp)}
    kinds = response.astype(np.intp), log_f, std, test.astype(np.intp)
    return ModeValues(*kinds, **numbers, shape=tuple(shape))
