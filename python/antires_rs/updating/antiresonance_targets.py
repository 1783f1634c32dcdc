"""Measured antiresonances, as an updating problem sees them: those of the kind that the model has.

What a set was identified from (``sees``) decides which roots of the model may be partners; the core knows
them by that name.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from ..measured.antiresonance_set import AntiresonanceSet
from ..support.validation import FloatArray
from .complex_zeros import of_one_kind
from .model_dofs import antiresonance_objective, known_dof, model_dof
from .steady_roots import followed, roots_of, steady
from .tables import FrequencyTable
from .weights import residual_weights

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["AntiresonanceTargets"]


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
