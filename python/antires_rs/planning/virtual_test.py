"""Tests that were not made: a structure beside its model, intact and damaged, and values with errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..damage.factors import BOUNDS, factors_of
from ..damage.measured_states import Values
from ..damage.roots import Roots, follow, roots_at
from ..measured.antiresonance_set import AntiresonanceSet
from ..models.parameters import stiffness_reduction
from ..models.structural_model import StructuralModel
from ..support.validation import FloatArray
from .question import Sees
from .virtual_roots import objective

__all__ = ["VirtualTest", "along"]

#: Roots are followed so far beyond the band: damage may bring them in.
_MARGIN = 1.5


@dataclass(frozen=True)
class VirtualTest:
    """A kind of test: model, sensors and force, errors of values and of the model.

    ``std`` holds for every sensor ln f and relative standard deviation of the model's roots; a value between
    them has one between theirs. ``model_error`` is the standard deviation of the logarithm of every
    stiffness and mass of the structure about its model's.
    """

    model: StructuralModel
    elements: tuple[int, ...]
    sensors: tuple[int, ...]
    force: int
    band_hz: tuple[float, float]
    sees: Sees
    std: tuple[tuple[FloatArray, FloatArray], ...]
    model_error: float

    def __getstate__(self) -> dict[str, Any]:
        # Without the core's objective, which each process makes again.
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def numbers(self) -> list[int]:
        """Elements in the order of the core's parameters: candidates, then the others."""
        return [*self.elements, *(e for e in self.model._springs if e not in self.elements)]

    @cached_property
    def core(self) -> tuple[_core.Objective, int]:
        """Roots by all severities and all factors; and the number of factors."""
        factors = factors_of(self.model)
        parameters = (*stiffness_reduction(self.numbers), *factors)
        high = _MARGIN * self.band_hz[1]
        core = objective(self.model, parameters, list(self.sensors), self.force, high, self.sees)
        return core, len(factors)

    def truth(self, rng: np.random.Generator) -> FloatArray:
        """Factors of a structure."""
        return np.clip(np.exp(self.model_error * rng.standard_normal(self.core[1])), *BOUNDS)

    def roots(self, factors: FloatArray, damage: Sequence[tuple[int, float]], threads: int) -> list[Roots]:
        """Roots of the structure with each damage: place of the element among the candidates, severity."""
        rows = np.zeros((len(damage), len(self.numbers) + factors.size))
        rows[:, len(self.numbers) :] = factors
        for row, (place, severity) in zip(rows, damage, strict=True):
            row[place] = severity
        return roots_at(self.core[0], rows, slopes=False, threads=threads)

    def inside(self, roots: Roots) -> Any:
        """Which roots lie in the band, (n,) bool."""
        low = np.log(max(self.band_hz[0], 1e-300))
        return (roots.log_f >= low) & (roots.log_f <= np.log(self.band_hz[1]))

    def error_of(self, roots: Roots) -> FloatArray:
        """Relative standard deviation of a value of each root, (n,)."""
        std = np.empty(roots.size)
        every = np.concatenate([own for _, own in self.std])
        for nth, (log_f, own) in enumerate(self.std):
            mine = roots.response == nth
            std[mine] = np.interp(roots.log_f[mine], log_f, own) if own.size else np.median(every)
        return std

    def values(self, roots: Roots, rng: np.random.Generator) -> Values:
        """What a test gives of roots in its band."""
        kept = self.inside(roots)
        std = self.error_of(roots)[kept]
        log_f = roots.log_f[kept] + std * rng.standard_normal(std.size)
        return Values(roots.response[kept], log_f, std, np.zeros(std.size, dtype=np.intp))

    def measured(self, roots: Roots, rng: np.random.Generator) -> AntiresonanceSet:
        """The same as a set."""
        values = self.values(roots, rng)
        freq, std = {}, {}
        for nth, dof in enumerate(self.sensors):
            own = values.response == nth
            order = np.argsort(values.log_f[own])
            freq[dof] = np.exp(values.log_f[own][order])
            std[dof] = (values.std[own] * np.exp(values.log_f[own]))[order]
        return AntiresonanceSet(self.force, freq, std_hz=std, sees=self.sees, channels=list(self.sensors))


def along(intact: Roots, states: Sequence[Roots]) -> list[NDArray[np.intp]]:
    """Number of the intact root that each root of each state has been, -1 for new ones; step by step."""
    found = []
    before, identity = intact, np.arange(intact.size)
    for state in states:
        step = follow(before, state)
        identity = np.where(step >= 0, identity[step], -1)
        before = state
        found.append(identity)
    return found
