"""What was measured, as an updating problem sees it: antiresonances, or resonances with their shapes.

Each kind knows its sets, how the core's objective is made of them, how far the model moves what was measured,
and which exact measurement a damaged model would have given.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from .. import _core
from ..measured.antiresonance_set import AntiresonanceSet
from ..measured.modal_set import ModalSet
from ..support.validation import ComplexArray, FloatArray, reject
from .antiresonance_targets import AntiresonanceTargets
from .model_dofs import model_dof
from .tables import ModalTable
from .weights import residual_weights

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["AntiresonanceTargets", "ModalTargets", "Targets", "targets_of", "unit_shapes"]

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
