"""Measured modes as values: a natural frequency each, and where its shape lies beside a mode of the model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .measured_states import Values
from .mode_roots import ModeRoots
from .roots import Roots

__all__ = ["ModeValues"]

_HALF_LOG_TAU = 0.5 * float(np.log(2.0 * np.pi))
#: More than any price.
_NEVER = 1e12
#: In the scan: weight of an angle between shapes (rad) against ln f, and the farthest that counts.
_ANGLE, _FAR = 0.3, 0.2


@dataclass(frozen=True)
class ModeValues(Values):
    """Values of modes: of each its ln f, then the coordinates of its shape, which depend on its partner.

    ``log_f`` is 0 for coordinates. ``start``, ``group``, ``shape`` and ``setup`` are of each mode: its first
    value, the sensors, the unit shape there, and the number of the set.
    """

    start: NDArray[np.intp]
    group: NDArray[np.intp]
    shape: tuple[FloatArray, ...]

    @property
    def frequencies(self) -> FloatArray:
        """ln f of each mode."""
        return self.log_f[self.start]

    @property
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
        """Root of each value, the values as seen from there, and what those without one cost.

        Frequency and shape decide together, one to one within a test. A false mode has any shape.
        """
        from scipy.optimize import linear_sum_assignment

        assert isinstance(roots, ModeRoots)
        found, seen, lost = np.full(self.size, -1), self.log_f.copy(), 0.0
        if not roots.size:
            return found, seen, sum(alone + _any_shape(shape.size) for shape in self.shape)
        for test in np.unique(self.test[self.start]):
            modes = np.flatnonzero(self.test[self.start] == test)
            costs, views = zip(
                *(self._beside(int(mode), roots, place, sigma, wider) for mode in modes), strict=True
            )
            cost = np.array(costs) + price[:: roots.each]
            single = np.array([alone + _any_shape(self.shape[mode].size) for mode in modes])
            rows, columns = linear_sum_assignment(
                np.hstack([cost, np.where(np.eye(modes.size, dtype=bool), single, _NEVER)])
            )
            for row, column in zip(rows, columns, strict=True):
                if column >= cost.shape[1]:
                    lost += single[row]
                    continue
                own, group = self.own(modes[row]), int(self.group[modes[row]])
                at = column * roots.each
                found[own.start] = at
                if roots.mixed[column]:
                    lost += _any_shape(self.shape[modes[row]].size)
                    continue
                first = at + roots.first(group)
                many = own.stop - own.start - 1
                found[own.start + 1 : own.stop] = np.arange(first, first + many)
                seen[own.start + 1 : own.stop] = views[row][column]
        return found, seen, lost

    def _beside(
        self, mode: int, roots: ModeRoots, place: FloatArray, sigma: FloatArray, wider: float
    ) -> tuple[FloatArray, FloatArray]:
        """What it costs that a mode belongs to each of the model's, and its shape as seen from these."""
        own, group, each = self.own(mode), int(self.group[mode]), roots.each
        at = slice(roots.first(group), roots.first(group) + own.stop - own.start - 1)
        wide = np.hypot(wider * self.std[own.start], sigma[::each])
        apart = (self.log_f[own.start] - place[::each]) / wide
        cost = 0.5 * apart**2 + np.log(wide) + _HALF_LOG_TAU
        facing = roots.shapes[group] @ self.shape[mode]
        across = np.einsum("rij,i->rj", roots.bases[group], self.shape[mode])
        by_mode = roots.log_f.reshape(-1, each)[:, at]
        seen = by_mode + np.where(facing < 0.0, -1.0, 1.0)[:, None] * across
        wide = np.hypot(wider * self.std[own.start + 1 : own.stop], sigma.reshape(-1, each)[:, at])
        apart = (seen - place.reshape(-1, each)[:, at]) / wide
        shapes = np.sum(0.5 * apart**2 + np.log(wide) + _HALF_LOG_TAU, axis=1)
        return cost + np.where(roots.mixed, _any_shape(self.shape[mode].size), shapes), seen

    def unexplained(self, roots: Roots, place: FloatArray) -> float:
        """Sum of the distances of the modes from the nearest of the model, shapes considered."""
        assert isinstance(roots, ModeRoots)
        total, frequencies = 0.0, place[:: roots.each]
        for mode, group in enumerate(self.group):
            alike = np.clip(np.abs(roots.shapes[group] @ self.shape[mode]), 0.0, 1.0)
            angle = np.where(roots.mixed, 0.0, np.arccos(alike))
            apart = np.abs(self.frequencies[mode] - frequencies) + _ANGLE * angle
            total += float(np.minimum(apart, _FAR).min(initial=_FAR))
        return total

    @classmethod
    def of(cls, rows: Sequence[tuple[int, float, float, int, FloatArray, float]]) -> ModeValues:
        """From modes: test, ln f, its std, group, unit shape, std of its components."""
        sizes = [row[4].size for row in rows]
        start = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.intp) if rows else np.empty(0, int)
        many = int(sum(sizes))
        log_f, std, response = np.zeros(many), np.zeros(many), np.zeros(many, dtype=np.intp)
        for at, n, (_, ln, ln_std, group, _, shape_std) in zip(start, sizes, rows, strict=True):
            log_f[at], std[at] = ln, ln_std
            std[at + 1 : at + n], response[at + 1 : at + n] = shape_std, 1 + group
        return cls(
            response,
            log_f,
            std,
            np.repeat(np.array([row[0] for row in rows], dtype=np.intp), sizes),
            start,
            np.array([row[3] for row in rows], dtype=np.intp),
            tuple(row[4] for row in rows),
        )


def _any_shape(n: int) -> float:
    """Minus the log density of a shape that may be any: half the sphere in n dimensions."""
    from scipy.special import gammaln

    return float(0.5 * n * np.log(np.pi) - gammaln(0.5 * n))
