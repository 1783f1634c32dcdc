"""The antiresonances at any severities of a few elements, from the tables."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..damage.view import Band, Foreseen
from ..support.validation import FloatArray
from .tables import LEVELS, Tables

__all__ = ["Interpolated", "Places"]

#: Change of a root that has just appeared, as the likelihood has it.
_NEW = 0.1
#: Standard deviation of a root that the model has lost and the structure may have, from its intact place.
_LOST = 0.1
#: Roots so far outside of the band (ln f) are not looked at.
_MARGIN = 0.3


@dataclass(frozen=True)
class _Between:
    """Where between two levels one severity lies: the level below, the nearer one, the share of the way."""

    below: int
    near: int
    share: float


@dataclass(frozen=True)
class Places:
    """Roots (r,) at severities u of some elements: ``place`` ln f in the measured structure, ``beside`` how
    far that is from the model's."""

    elements: tuple[int, ...]
    u: FloatArray
    between: tuple[_Between, ...]
    there: NDArray[np.bool_]
    place: FloatArray
    beside: FloatArray
    #: Slopes by all u (r, n), where they were computed.
    slopes: FloatArray | None = None


@dataclass(frozen=True)
class Interpolated:
    """Tables, read between their levels."""

    tables: Tables
    #: Variance of a root that has just appeared.
    tau2: float

    @cached_property
    def start(self) -> Places:
        """No damage."""
        t = self.tables
        return Places((), np.empty(0), (), t.there[0, 0], t.place[0, 0], t.beside[0, 0])

    @cached_property
    def of_response(self) -> dict[int, NDArray[np.intp]]:
        """Roots of each response."""
        return {int(r): np.flatnonzero(self.tables.response == r) for r in np.unique(self.tables.response)}

    @cached_property
    def by_response(self) -> dict[int, NDArray[np.float32]]:
        """Places (roots, n, levels) of each response, infinite where a root is not there."""
        place = np.where(self.tables.there, self.tables.place, np.inf).astype(np.float32)
        return {
            r: np.ascontiguousarray(np.moveaxis(place[:, :, own], 2, 0))
            for r, own in self.of_response.items()
        }

    def _one(self, e: int, u: float) -> Places:
        t = self.tables
        j = min(int(np.searchsorted(LEVELS, u, side="right")) - 1, LEVELS.size - 2)
        width = LEVELS[j + 1] - LEVELS[j]
        s = float((u - LEVELS[j]) / width)
        near = j + (s > 0.5)
        both = t.there[e, j] & t.there[e, j + 1]
        a, rise = t.place[e, j], t.place[e, j + 1] - t.place[e, j]
        r = 1.0 - s
        bend = r * t.by_own[e, j] - s * t.by_own[e, j + 1]
        place = np.where(
            both,
            a + s * s * (3.0 - 2.0 * s) * rise + s * r * width * bend,
            t.place[e, near] + t.by_own[e, near] * (u - LEVELS[near]),
        )
        beside = np.where(both, r * t.beside[e, j] + s * t.beside[e, j + 1], t.beside[e, near])
        return Places((e,), np.array([u]), (_Between(j, near, s),), t.there[e, near], place, beside)

    def places(self, elements: tuple[int, ...], u: FloatArray) -> Places:
        """The roots at severities u of some elements, the others undamaged."""
        if not elements:
            return self.start
        each = [self._one(e, float(x)) for e, x in zip(elements, u, strict=True)]
        if len(each) == 1:
            return each[0]
        start, t = self.start, self.tables
        place, beside, there = start.place, start.beside, each[0].there
        for one in each:
            place = place + (one.place - start.place)
            beside = beside + (one.beside - start.beside)
            there = there & one.there
        for one in each:  # a root that only one of them makes
            there = there | (one.there & ~t.old)
        common = np.zeros(place.size)
        for i, (a, ua) in enumerate(zip(elements, u, strict=True)):
            for k in range(i + 1, len(elements)):
                b, ub = elements[k], float(u[k])
                common += (self._slope(each[i], b) - t.slopes[0, 0, :, b]) * ub
                common += (self._slope(each[k], a) - t.slopes[0, 0, :, a]) * ua
                common -= self._mixed(a, b) * ua * ub
        between = tuple(one.between[0] for one in each)
        return Places(elements, np.asarray(u), between, there, place + np.where(t.old, common, 0.0), beside)

    def _slope(self, one: Places, by: int) -> FloatArray:
        """Slopes of the roots at one severity by another u."""
        t, e, at = self.tables, one.elements[0], one.between[0]
        low, high = t.slopes[e, at.below, :, by], t.slopes[e, at.below + 1, :, by]
        return np.asarray(low + at.share * (high - low), dtype=np.float64)

    def _mixed(self, a: int, b: int) -> FloatArray:
        """Second derivative of ln f by two u, at no damage."""
        t = self.tables
        first = (t.slopes[a, 1, :, b] - t.slopes[a, 0, :, b]) / LEVELS[1]
        second = (t.slopes[b, 1, :, a] - t.slopes[b, 0, :, a]) / LEVELS[1]
        return np.asarray(0.5 * (first + second), dtype=np.float64)

    def rows(self, table: NDArray[np.float32], at: Places, roots: NDArray[np.intp]) -> FloatArray:
        """Slopes or errors of some roots, from their table."""
        t = self.tables
        start = table[0, 0, roots]
        if not at.elements:
            return np.asarray(start, dtype=np.float64)
        total = None if len(at.elements) == 1 else start
        for e, way in zip(at.elements, at.between, strict=True):
            both = t.there[e, way.below, roots] & t.there[e, way.below + 1, roots]
            share = np.where(both, way.share, float(way.near - way.below)).astype(np.float32)[:, None]
            low = table[e, way.below, roots]
            own = low + share * (table[e, way.below + 1, roots] - low)
            total = own if total is None else total + (own - start)
        assert total is not None
        return np.asarray(total, dtype=np.float64)

    def columns(self, at: Places, roots: NDArray[np.intp]) -> FloatArray:
        """Slopes of some roots by the severities u of the elements themselves."""
        t = self.tables
        found = np.empty((roots.size, len(at.elements)))
        for nth, by in enumerate(at.elements):
            start = t.slopes[0, 0, roots, by]
            total = start.astype(np.float64)
            for e, way in zip(at.elements, at.between, strict=True):
                low, high = t.slopes[e, way.below, roots, by], t.slopes[e, way.below + 1, roots, by]
                total += low + np.float32(way.share) * (high - low) - start
            found[:, nth] = total
        return found

    def foreseen(self, at: Places, beta: FloatArray, band: Band, alike: float) -> Foreseen:
        """As the likelihood has them: roots that are there, those that the model has lost, ascending."""
        t = self.tables
        lost = t.seen & ~at.there
        place = np.where(lost, t.intact + self.start.beside, at.place)
        model = place - at.beside
        near = at.there & (model > band.low - _MARGIN) & (model < band.high + _MARGIN)
        shown = np.flatnonzero(near | lost)
        shown = shown[np.lexsort((place[shown], t.response[shown]))]
        gone, new = lost[shown], ~t.old[shown]
        errors = self.rows(t.errors, at, shown)
        slopes = self.rows(t.slopes, at, shown) if at.slopes is None else at.slopes[shown]
        slopes = slopes / (1.0 - beta)
        if gone.any():
            errors[gone], slopes[gone] = 0.0, 0.0
        spread = errors @ errors.T
        common = np.where(gone, 0.0, alike)
        spread += np.outer(common, common)
        spread[np.diag_indices(shown.size)] += np.where(gone, _LOST**2, np.where(new, self.tau2, 0.0))
        change = np.where(new, _NEW, model[shown] - t.intact[shown])
        return Foreseen(
            response=t.response[shown],
            place=place[shown],
            beside=np.where(gone, 0.0, at.beside[shown]),
            spread=spread,
            change=np.where(gone, 0.0, change),
            slopes=slopes,
            seen=t.seen[shown] & ~gone,
        )
