"""Two states of a structure measured by their modes: natural frequencies and shapes, side by side."""

from __future__ import annotations

from collections.abc import Container, Hashable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..measured.modal_set import ModalSet
from ..support.validation import FloatArray, reject
from ..updating.model_dofs import model_dof
from .measured_states import ASSUMED_STD, LEAST_STD
from .mode_roots import ModeRoots, ModeSource
from .mode_values import ModeValues
from .roots import Roots
from .same_data import note_of_same_data, same_data

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["ASSUMED_SHAPE_STD", "ModeResponses", "measured_modes"]

#: Standard deviation of the components of a shape of unit length that states none, and the least.
ASSUMED_SHAPE_STD, _LEAST_SHAPE_STD = 5e-3, 2e-5

#: Dofs of the model, ascending.
Dofs = tuple[int, ...]


@dataclass(frozen=True)
class ModeResponses:
    """The sensors of all sets of modes."""

    groups: dict[Dofs, int]
    measured: tuple[ModalSet, ...]
    #: Of each set of now, the numbers of its flexible modes.
    numbers: tuple[NDArray[np.intp], ...]
    highest_hz: float
    left_out: tuple[str, ...]
    assumed: bool
    #: Sensors of each test of the intact structure.
    tests: tuple[int, ...]
    noun = "modes"

    def source(self, model: StructuralModel, parts: Any) -> ModeSource:
        """The model's modes, to be asked for."""
        own, rows = model._core_for([dof for group in self.groups for dof in group])
        left = iter(rows)
        groups = [[next(left) for _ in group] for group in self.groups]
        sensors = sorted({*rows})
        asked = [
            (np.array([self.highest_hz]), group, np.ones((1, len(group)), dtype=np.complex128))
            for group in groups
        ]
        core = _core.Objective.modal(own, parts, asked, "squared", None, 0.0, None)
        return ModeSource(core, tuple(np.searchsorted(sensors, group) for group in groups))

    def corrected(
        self, now: ModeValues, roots: Roots, partner: NDArray[np.intp], beside: FloatArray
    ) -> list[ModalSet]:
        """The sets of now without what is wrong in both states."""
        assert isinstance(roots, ModeRoots)
        sets, mode = [], 0
        for each, kept in zip(self.measured, self.numbers, strict=True):
            freq, shapes = [], []
            dofs: Dofs = ()
            for _ in kept:
                own, group = now.own(mode), int(now.group[mode])
                dofs = list(self.groups)[group]
                freq.append(float(np.exp(now.log_f[own.start] - beside[own.start])))
                shapes.append(now.shape[mode])
                if (partner[own] >= 0).all() and own.stop > own.start + 1:
                    at = int(partner[own.start]) // roots.each
                    facing = -1.0 if roots.shapes[group][at] @ shapes[-1] < 0.0 else 1.0
                    across = roots.bases[group][at] @ beside[own.start + 1 : own.stop]
                    shapes[-1] = facing * shapes[-1] - across
                mode += 1
            if freq:
                order = np.argsort(freq)
                told = [None if std is None else std[kept][order] for std in (each.std_hz, each.std_shapes)]
                sets.append(
                    ModalSet(
                        np.array(freq)[order],
                        np.array(shapes)[order],
                        dofs,
                        std_hz=told[0],
                        std_shapes=told[1],
                    )
                )
        return sets


def measured_modes(
    model: StructuralModel, baseline: Sequence[ModalSet], measured: Sequence[ModalSet]
) -> tuple[ModeResponses, ModeValues, ModeValues]:
    """The sensors of all sets, the intact modes and those of now.

    Raises
    ------
    InvalidInputError
        A set of now whose sensors no intact one has, dofs outside the model, a shape at rest, nothing
        measured.
    """
    listed = [[_dofs(model, each) for each in sets] for sets in (baseline, measured)]
    before, after = ([tuple(sorted(dofs)) for dofs in each] for each in listed)
    for each, dofs in zip(measured, after, strict=True):
        if before and dofs not in before:
            reject(
                "baseline",
                f"no set at the dofs {list(each.dofs)}",
                "sets of the intact structure with the same sensors as measured",
                "Test the intact structure with these sensors too, or keep the dofs that both tests have.",
            )
    groups = {dofs: nth for nth, dofs in enumerate(dict.fromkeys((*before, *after)))}
    both = (*baseline, *measured)
    highest = max((float(each.freq_hz.max(initial=0.0)) for each in both), default=0.0)
    if highest <= 0.0:
        reject("measured", "no mode", "at least one", "Identify in a wider band.")
    unstated = any(each.std_shapes is None for each in both)
    twice = [same_data([_columns(each) for each in sets]) for sets in (baseline, measured)]
    responses = ModeResponses(
        groups,
        tuple(measured),
        tuple(
            np.flatnonzero(each.freq_hz > 0.0) if nth not in twice[1] else np.empty(0, dtype=np.intp)
            for nth, each in enumerate(measured)
        ),
        highest,
        (
            *(
                [
                    "Components of shapes without standard deviation count as known to "
                    f"{100 * ASSUMED_SHAPE_STD:g} % of the shape's length."
                ]
                if unstated
                else []
            ),
            *note_of_same_data("baseline", twice[0]),
            *note_of_same_data("measured", twice[1]),
        ),
        any(each.std_hz is None for each in both),
        tuple(groups[dofs] for dofs in before),
    )
    return (
        responses,
        _values("baseline", baseline, listed[0], groups, twice[0]),
        _values("measured", measured, listed[1], groups, twice[1]),
    )


def _dofs(model: StructuralModel, each: ModalSet) -> Dofs:
    return tuple(model_dof(model, "measured dof", dof) for dof in each.dofs)


def _columns(each: ModalSet) -> dict[Hashable, tuple[FloatArray, FloatArray]]:
    """Frequencies and shapes, with the standard deviations of the frequencies, by the sensors."""
    std = np.full(each.freq_hz.size, np.nan) if each.std_hz is None else each.std_hz
    shapes = each.to_real().shapes
    return {each.dofs: (np.concatenate([each.freq_hz, shapes.ravel()]), std)}


def _values(
    name: str, sets: Sequence[ModalSet], dofs: list[Dofs], groups: dict[Dofs, int], twice: Container[int]
) -> ModeValues:
    rows = []
    for nth, each in enumerate(sets):
        if nth in twice:
            continue
        order = np.argsort(dofs[nth])
        shapes = each.to_real().shapes[:, order]
        for mode in np.flatnonzero(each.freq_hz > 0.0):
            size = float(np.linalg.norm(shapes[mode]))
            if size == 0.0:
                reject(name, f"mode {mode} at rest at every dof", "shapes that move", "Leave that mode out.")
            std = ASSUMED_STD if each.std_hz is None else each.std_hz[mode] / each.freq_hz[mode]
            of_shape = ASSUMED_SHAPE_STD if each.std_shapes is None else each.std_shapes[mode]
            rows.append(
                (
                    nth,
                    float(np.log(each.freq_hz[mode])),
                    max(float(std), LEAST_STD),
                    groups[tuple(sorted(dofs[nth]))],
                    np.asarray(shapes[mode] / size, dtype=np.float64),
                    max(float(of_shape), _LEAST_SHAPE_STD),
                )
            )
    return ModeValues.of(rows)
