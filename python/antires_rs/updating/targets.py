"""What was measured, as an updating problem sees it: antiresonances, or resonances with their shapes.

Each kind knows its sets, how the core's objective is made of them, how far the model moves what was measured,
and which exact measurement a damaged model would have given.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..exceptions import InvalidInputError, reject
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..support.checks import ComplexArray, FloatArray, real_array
from .steady_roots import followed, of_one_kind, roots_of, steady
from .tables import FrequencyTable, ModalTable

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel


# -- Weights of the residuals from the uncertainty of the measured values


# Relative error of omega^2 that a model has anyway: values known better than this get no more weight.
MODEL_ERROR = 2e-3


def residual_weights(
    weights: Any,
    sets: Sequence[AntiresonanceSet],
    measured_hz: FloatArray,
    kept: NDArray[np.bool_] | None = None,
) -> FloatArray | None:
    """Weight of every measured value, mean one; None for equal weights.

    "std" gives 1 / sqrt(s^2 + 0.002^2), scaled to mean one, where s = 2 std_hz / freq_hz is the deviation of
    the residual omega_A^2 / omega_E^2 - 1; a value whose deviation is not known counts like the median of
    those known. ``kept`` tells which values of the sets are compared; weights may be given for all of them.
    """
    if weights is None:
        return None
    if isinstance(weights, str):
        if weights != "std":
            reject(
                "weights",
                repr(weights),
                "None, 'std', or one number for each measured value",
                "Leave them out to count all values alike.",
            )
        std = np.concatenate([table.std_hz for each in sets for table in each.tables.values()])
        if not np.isfinite(std if kept is None else std[kept]).any():
            reject(
                "weights",
                "'std' for values without standard deviations",
                "sets with std_hz",
                "Identify an averaged record with formulation='numerators' (its default), or give std_hz.",
            )
        spread = 2.0 * (std if kept is None else std[kept]) / measured_hz
        spread = np.where(np.isfinite(spread), spread, np.nanmedian(spread))
        made = 1.0 / np.hypot(spread, MODEL_ERROR)
        return np.asarray(made / made.mean(), dtype=np.float64)
    wanted = f"{measured_hz.size} numbers of at least 0, one for each measured value"
    given = real_array("weights", weights, ndim=1, wanted=wanted)
    if kept is not None and given.size == kept.size:
        given = given[kept]
    if given.size != measured_hz.size or given.min() < 0.0 or not given.any():
        reject(
            "weights",
            f"{given.size} numbers from {given.min():g} to {given.max():g}",
            wanted,
            "Leave them out to count all values alike.",
        )
    return given


# -- Measured dofs as dofs of the model, and the core's objectives of them


#: Response, force, values (Hz), what the set can see, number of the set.
Part = tuple[int, int, FloatArray, str | None, int]


def model_dof(model: StructuralModel, name: str, label: Any) -> int:
    """A dof of the model that a measured set names, by its number or its name."""
    return model._dof(name, label)


def known_dof(model: StructuralModel, label: Any) -> int | None:
    """The same; None where it is no dof of the model."""
    try:
        return model._dof("dof", label)
    except InvalidInputError:
        return None


def antiresonance_objective(
    model: StructuralModel, parameters: Any, parts: Sequence[Part], *rest: Any
) -> _core.Objective:
    """The core's objective of responses, by their rows."""
    core, rows = model._core_for([dof for part in parts for dof in part[:2]])
    ends = zip(rows[::2], rows[1::2], strict=True)
    placed = [(*end, *part[2:]) for end, part in zip(ends, parts, strict=True)]
    return _core.Objective.antiresonance(core, parameters, placed, *rest)


# -- Measured antiresonances, as an updating problem sees them: those of the kind that the model has
#
# What a set was identified from (``sees``) decides which roots of the model may be partners; the core knows
# them by that name.


class AntiresonanceTargets:
    """Antiresonances of one or several positions of the force."""

    noun, objective = "antiresonance", "antiresonance"

    def __init__(self, model: StructuralModel, sets: tuple[AntiresonanceSet, ...]) -> None:
        self.sets = sets
        self.forces = [model_dof(model, "excitation", s.excitation) for s in sets]
        self.dofs_of = [[model_dof(model, "measured dof", dof) for dof in s] for s in sets]
        self._channels = [_channels(model, s) for s in sets]
        kept, self.left_out = of_one_kind(model, sets, self.dofs_of, self.forces)
        self._steady: tuple[StructuralModel, list[Any]] | None = None
        self._kept = np.concatenate([np.empty(0, dtype=bool), *(mask for masks in kept for mask in masks)])
        self.parts: list[tuple[int, int, FloatArray, str | None, int]] = []
        #: Whether each part was identified from one curve, without averages that tell its scatter.
        self.single: list[bool] = []
        #: Standard deviations (Hz) of the values of each part.
        self.stds: list[FloatArray] = []
        for number, (s, dofs, force, masks) in enumerate(
            zip(sets, self.dofs_of, self.forces, kept, strict=True)
        ):
            values = dict(zip(dofs, (s[dof][mask] for dof, mask in zip(s, masks, strict=True)), strict=True))
            channels = self._channels[number]
            # Without all that measured together nothing is known to be shared.
            sees = None if s.sees == "transmissibility" and not channels else s.sees
            others = [dof for dof in channels if dof not in values] if sees == "transmissibility" else []
            self.parts += [(dof, force, np.array(freq), sees, number) for dof, freq in values.items()]
            self.parts += [(dof, force, np.empty(0), sees, number) for dof in others]
            std = [t.std_hz[mask] for t, mask in zip(s.tables.values(), masks, strict=True)]
            self.stds += [*std, *(np.empty(0) for _ in others)]
            self.single += [bool("share" in t.scores) for t in s.tables.values()] + [False] * len(others)
        counts = [len(freq) for _, _, freq, _, _ in self.parts]
        self.hz = np.concatenate([np.empty(0), *(part[2] for part in self.parts)])
        self.dofs = np.repeat([part[0] for part in self.parts], counts)
        self.excitations = np.repeat([part[1] for part in self.parts], counts)
        #: What the tables call the dofs: "mass 3", "node 3 v"; none where they are numbers only.
        labels = {dof: model.dof_label(dof) for part in self.parts for dof in part[:2]}
        self.names = {
            dof: label.removeprefix("node ") for dof, label in labels.items() if label != f"dof {dof}"
        }

    def weights(self, given: Any) -> FloatArray | None:
        """Factors on the residuals, one a measured antiresonance that is compared."""
        return residual_weights(given, self.sets, self.hz, self._kept)

    def core(self, *parts: Any) -> _core.Objective:
        """The core's objective."""
        model, parameters, *rest = parts
        return antiresonance_objective(model, parameters, self.parts, *rest)

    def residuals(self, core: _core.Objective, x: FloatArray) -> FloatArray:
        """Signed residuals e at ``x``; 1 without a partner."""
        found = core.residuals(x)
        assert found is not None  # an objective of antiresonances has them
        return found

    def table(self, core: _core.Objective, before: FloatArray, after: FloatArray) -> FrequencyTable:
        """Measured, before and after."""
        return FrequencyTable(
            self.dofs, self.excitations, self.hz, core.pairs(before)[0], core.pairs(after)[0], self.names
        )

    def change(self, core: _core.Objective, behind: FloatArray, ahead: FloatArray) -> FloatArray:
        """How what was measured differs between two parameter vectors."""
        return np.asarray((core.pairs(ahead)[0] ** 2 - core.pairs(behind)[0] ** 2) / self.hz**2)

    def exact(
        self,
        model: StructuralModel,
        nominal: StructuralModel,
        nominal_hz: FloatArray,
        moved: Sequence[StructuralModel],
    ) -> tuple[list[AntiresonanceSet], FloatArray | None] | None:
        """Antiresonances up to the highest measured one that can be followed from the nominal model."""
        band_hz = float(self.hz.max())
        if self._steady is None or self._steady[0] is not nominal:
            parts = zip(self.sets, self.dofs_of, self.forces, self._channels, strict=True)
            self._steady = (
                nominal,
                [
                    steady(nominal, moved, dofs, force, 1.5 * band_hz, s.sees, ch)
                    for s, dofs, force, ch in parts
                ],
            )
        found, weights = [], [np.empty(0)]
        for s, dofs, force, roots in zip(self.sets, self.dofs_of, self.forces, self._steady[1], strict=True):
            there = roots_of(model, dofs, force, band_hz, s.sees != "frf")
            # Below the band a root on its way to zero would differ without bound.
            there = [None if freq is None else freq[freq >= 0.5 * self.hz.min()] for freq in there]
            both = [followed(own, now) for own, now in zip(roots, there, strict=True)]
            columns = dict(zip(s, (freq for freq, _ in both), strict=True))
            found.append(AntiresonanceSet(s.excitation, columns, sees=s.sees, channels=s.channels))
            weights += [weight for _, weight in both]
        joined = np.concatenate(weights)
        return (found, joined) if joined.size else None


def _channels(model: StructuralModel, found: AntiresonanceSet) -> list[int]:
    """All responses that were measured together, none where one is no dof of the model."""
    channels = [known_dof(model, dof) for dof in found.channels]
    return [] if None in channels else [dof for dof in channels if dof is not None]


#: A shape smaller than this at the measured dofs, relative to its largest entry, cannot be measured there.
_AT_REST = 1e-9


class Targets(Protocol):
    """What both kinds offer."""

    noun: str
    objective: str
    sets: tuple[Any, ...]
    hz: FloatArray
    left_out: tuple[str, ...]

    def weights(self, given: Any) -> FloatArray | None:
        """Factors on the residuals, one a measured value."""

    def core(self, *parts: Any) -> _core.Objective:
        """The core's objective."""

    def residuals(self, core: _core.Objective, x: FloatArray) -> FloatArray:
        """Signed residuals at ``x``."""

    def table(self, core: _core.Objective, before: FloatArray, after: FloatArray) -> Any:
        """Measured, before and after."""

    def change(self, core: _core.Objective, behind: FloatArray, ahead: FloatArray) -> FloatArray:
        """How what was measured differs between two parameter vectors; NaN without a partner."""

    def exact(
        self,
        model: StructuralModel,
        nominal: StructuralModel,
        nominal_hz: FloatArray,
        moved: Sequence[StructuralModel],
    ) -> Any:
        """What a model would have given if measured exactly at the same dofs, with weights; None if nothing.

        ``nominal`` is the intact one with its partners, ``moved`` are others hardly different from it.
        """


class ModalTargets:
    """Resonances and shapes, of one or several sets of sensors. Rigid-body modes, at 0 Hz, are left out."""

    noun, objective = "mode", "modal"
    left_out: tuple[str, ...] = ()

    def __init__(self, model: StructuralModel, sets: tuple[ModalSet, ...]) -> None:
        self.sets = sets
        self._parts: list[tuple[FloatArray, list[int], ComplexArray]] = []
        for each in sets:
            dofs = [model_dof(model, "measured dof", dof) for dof in each.dofs]
            flexible = each.freq_hz != 0.0
            self._parts.append(
                (
                    each.freq_hz[flexible],
                    dofs,
                    np.ascontiguousarray(each.shapes[flexible], dtype=np.complex128),
                )
            )
        listed = [dofs for _, dofs, _ in self._parts]
        self._dofs = [dof for dofs in listed for dof in dofs]
        rows = model._core_for(self._dofs)[1]
        ends = np.cumsum([0, *map(len, listed)])
        #: Rows of the core's matrices.
        self._rows = [rows[a:b] for a, b in zip(ends[:-1], ends[1:], strict=True)]
        self.hz = np.concatenate([freq for freq, _, _ in self._parts])
        self.numbers = np.concatenate([np.flatnonzero(each.freq_hz != 0.0) for each in sets])

    def weights(self, given: Any) -> FloatArray | None:
        """Factors on the residuals, one a measured antiresonance or mode."""
        if isinstance(given, str):
            reject(
                "weights",
                repr(given),
                "None, or one number for each measured mode",
                "A ModalSet has no standard deviations.",
            )
        return residual_weights(given, (), self.hz)

    def core(self, *parts: Any) -> _core.Objective:
        """The core's objective."""
        model, parameters, *rest = parts
        placed = [
            (freq, rows, shapes) for (freq, _, shapes), rows in zip(self._parts, self._rows, strict=True)
        ]
        return _core.Objective.modal(model._core_for(self._dofs)[0], parameters, placed, *rest)

    @staticmethod
    def _pairs(core: _core.Objective, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        freq, shapes = core.pairs(x)
        assert shapes is not None  # a modal objective has them
        return freq, *shapes

    def mac(self, core: _core.Objective, x: FloatArray) -> FloatArray:
        """MAC of each measured mode with its partner, NaN without one."""
        return self._pairs(core, x)[1]

    def residuals(self, core: _core.Objective, x: FloatArray) -> FloatArray:
        """The m of the frequencies, then the m of the shapes, 1 - MAC."""
        paired, mac, _ = self._pairs(core, x)
        both = np.concatenate([(paired / self.hz) ** 2 - 1.0, 1.0 - mac])
        return np.where(np.isnan(both), 1.0, both)

    def table(self, core: _core.Objective, before: FloatArray, after: FloatArray) -> ModalTable:
        """Measured, before and after."""
        (hz, mac, _), (hz_after, mac_after, _) = self._pairs(core, before), self._pairs(core, after)
        return ModalTable(self.numbers, self.hz, hz, hz_after, mac, mac_after)

    def change(self, core: _core.Objective, behind: FloatArray, ahead: FloatArray) -> FloatArray:
        """Of the frequencies, then of the shapes at unit length: 1 - MAC has no slope at a perfect fit."""
        (f0, _, shapes0), (f1, _, shapes1) = self._pairs(core, behind), self._pairs(core, ahead)
        changes = [(f1**2 - f0**2) / self.hz**2]
        first = 0
        for (freq, _, _), own in zip(self._parts, self._rows, strict=True):
            rows = slice(first, first + len(freq))
            first += len(freq)
            u, v = (unit_shapes(shapes[rows][:, own]) for shapes in (shapes0, shapes1))
            sign = np.where(np.sum(u * v, axis=1, keepdims=True) < 0.0, -1.0, 1.0)
            changes.append((sign * v - u).ravel())
        return np.concatenate(changes)

    def exact(
        self,
        model: StructuralModel,
        nominal: StructuralModel,
        nominal_hz: FloatArray,
        moved: Sequence[StructuralModel],
    ) -> tuple[list[ModalSet], None] | None:
        """The modes whose numbers are those of the nominal model's partners."""
        modes, intact = model.modes(), nominal.modes()
        found, first = [], 0
        for freq, dofs, _ in self._parts:
            partners = nominal_hz[first : first + len(freq)]
            first += len(freq)
            near = np.abs(intact.freq_hz - partners[np.isfinite(partners)][:, None])
            numbers = np.unique(np.argmin(near, axis=1)).astype(int)
            shapes = modes.shapes[numbers]
            at = shapes[:, dofs]
            moving = np.linalg.norm(at, axis=1) > _AT_REST * np.abs(shapes).max(axis=1, initial=0.0)
            found.append(ModalSet(modes.freq_hz[numbers][moving], at[moving], dofs))
        return (found, None) if any(np.any(s.freq_hz > 0.0) for s in found) else None


def targets_of(model: StructuralModel, measured: Any, objective: str | None) -> Targets:
    """The kind that the measured sets are, which must be the one asked for."""
    sets = (measured,) if isinstance(measured, AntiresonanceSet | ModalSet) else measured
    if not isinstance(sets, Sequence) or not sets:
        reject(
            "measured",
            measured,
            "an AntiresonanceSet or a ModalSet, or several of one kind",
            "Identify it from a record, or build it from a table: AntiresonanceSet(0, {0: [12.2, 36.2]}).",
        )
    if all(isinstance(s, AntiresonanceSet) for s in sets):
        kind: Any = AntiresonanceTargets
    elif all(isinstance(s, ModalSet) for s in sets):
        kind = ModalTargets
    else:
        reject(
            "measured",
            measured,
            "an AntiresonanceSet or a ModalSet, or several of one kind",
            "Identify it from a record, or build it from a table: AntiresonanceSet(0, {0: [12.2, 36.2]}).",
        )
    if objective is not None and objective != kind.objective:
        needed = "an AntiresonanceSet" if objective == "antiresonance" else "a ModalSet"
        reject(
            "measured",
            f"a {type(sets[0]).__name__}",
            f"{needed} for objective={objective!r}",
            "Leave objective out: the measured set tells it.",
        )
    made: Targets = kind(model, tuple(sets))
    return made


def unit_shapes(shapes: FloatArray) -> FloatArray:
    """Shapes at unit length, a row each; zero stays zero."""
    size = np.linalg.norm(shapes, axis=1, keepdims=True)
    return np.asarray(shapes / np.where(size > 0.0, size, 1.0))
