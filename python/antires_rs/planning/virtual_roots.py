"""What a test could measure: the antiresonances of all candidate sensors for one force, with their slopes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..damage.association import align
from ..damage.roots import roots_at
from ..support.validation import FloatArray
from ..updating.model_dofs import antiresonance_objective
from .value_errors import ExpectedErrors

if TYPE_CHECKING:
    from ..models.parameter import Parameter
    from ..models.structural_model import StructuralModel

__all__ = ["VirtualRoots", "objective", "virtual_roots"]

#: Relative distance up to which roots of two responses are one, and from which on transmissibilities show
#: both in full; as in the core (update/sight.rs).
ONE, APART = 1e-6, 1e-3
#: What shows less of a root does not show it; as in :mod:`antires_rs.damage.roots`.
SEEN = 0.5
#: A change of 1 % that moves a root by more than 3 % does so for a moment only: two roots are about to merge.
_STEEPEST = 3.0
#: The core looks so far beyond the highest measured value.
_MARGIN = 1.5


@dataclass(frozen=True)
class VirtualRoots:
    """Roots in the band for one force.

    Attributes
    ----------
    sensor : (n,) number of the candidate.
    slopes : (n, p) d ln f / dp.
    std : (n,) relative standard deviation of a value.
    common : {root: (c,)} of roots that some candidates share: whether each of them shows it, 0 or 1.
    """

    sensor: NDArray[np.intp]
    slopes: FloatArray
    std: FloatArray
    common: dict[int, FloatArray]


def objective(
    model: StructuralModel,
    parameters: tuple[Parameter, ...],
    sensors: list[int],
    force: int,
    high_hz: float,
    sees: str | None,
) -> _core.Objective:
    """The core's objective of these responses, for its roots up to ``high_hz`` (and none of its values)."""
    parts = [(dof, force, np.array([high_hz / _MARGIN]), sees, 0) for dof in sensors]
    core = model.description.core_parameters(parameters)
    return antiresonance_objective(model, core, parts, "squared", None, 0.0, None)


def virtual_roots(
    model: StructuralModel,
    parameters: tuple[Parameter, ...],
    nominal: FloatArray,
    sensors: list[int],
    force: int,
    band_hz: tuple[float, float],
    sees: str,
    errors: ExpectedErrors,
    threads: int,
) -> VirtualRoots:
    """The roots of every candidate in the band, less those that are about to merge or vanish."""
    shown = "frf" if sees == "frf" else None
    core = objective(model, parameters, sensors, force, band_hz[1], shown)
    found = roots_at(core, nominal[None], slopes=True, threads=threads)[0]
    inside = (found.log_f >= np.log(max(band_hz[0], 1e-300))) & (found.log_f <= np.log(band_hz[1]))
    relative = found.slopes * np.where(nominal == 0.0, 1.0, nominal)
    inside &= np.abs(relative).max(axis=1, initial=0.0) < _STEEPEST
    sensor, log_f = found.response[inside], found.log_f[inside]
    own = [np.exp(log_f[sensor == nth]) for nth in range(len(sensors))]
    std = errors.of(model, sensors, force, own, band_hz[1])
    common = {} if sees == "frf" else _common([np.log(each) for each in own])
    return VirtualRoots(sensor, found.slopes[inside], np.concatenate([np.empty(0), *std]), common)


def _common(log_f: list[FloatArray]) -> dict[int, FloatArray]:
    """Whether each candidate shows the roots that not all others show in full."""
    starts = np.concatenate([[0], np.cumsum([own.size for own in log_f])])
    found: dict[int, FloatArray] = {}
    for nth, own in enumerate(log_f):
        for other, theirs in enumerate(log_f):
            if other == nth or not own.size or not theirs.size:
                continue
            apart = np.abs(own[:, None] - theirs)
            if apart.min() >= APART:
                continue
            # Each root has one counterpart at most.
            partner = align(apart, np.full(own.size, 0.5 * APART), np.full(theirs.size, 0.5 * APART))
            for root in np.flatnonzero(partner >= 0):
                share = (apart[root, partner[root]] - ONE) / (APART - ONE) >= SEEN
                row = found.setdefault(int(starts[nth] + root), np.ones(len(log_f)))
                row[other] = float(share)
    return found
