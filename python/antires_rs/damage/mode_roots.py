r"""Modes of the model as roots: a natural frequency each, and where its shape lies beside the intact one.

A shape u of unit length at the sensors is told by its coordinates in a basis Q of the directions across it,

.. math:: a = Q^T (u' - u), \qquad Q^T u = 0, \quad Q^T Q = I,

n - 1 numbers at n sensors, which neither sign nor size touches. Along a change of the model the basis is
turned with the shape, without any rotation about it, so that an error of a shape has the same coordinates in
both states.

The modes of another state are those that look most alike, one to one, with a little weight on the frequency:
modes that pass each other are followed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support.validation import FloatArray
from .roots import Roots

__all__ = ["ModeRoots", "ModeSource"]

#: Modes whose frequencies lie nearer together (ln f): the model does not tell how their shapes mix.
_MIXED = 1e-3
#: Weight of a difference in ln f against one of MAC; and the least likeness of what may be the same mode.
_BY_FREQUENCY, _ALIKE = 0.5, 0.1


@dataclass(frozen=True)
class ModeRoots(Roots):
    """Modes; ``log_f`` holds ln f, then the coordinates of the shape beside the intact model's, mode by mode.

    Attributes
    ----------
    shapes : of each group of sensors, (modes, n), unit length.
    bases : of each group, (modes, n, n - 1).
    mixed : (modes,) whether another mode is so near that the shape says nothing.
    """

    shapes: tuple[FloatArray, ...]
    bases: tuple[FloatArray, ...]
    mixed: NDArray[np.bool_]

    @property
    def each(self) -> int:
        """Roots that a mode has: its frequency and the coordinates of its shape."""
        return 1 + sum(int(basis.shape[2]) for basis in self.bases)

    @property
    def kind(self) -> NDArray[np.intp]:
        """0 of frequencies, 1 of shapes."""
        return (self.response > 0).astype(np.intp)

    @property
    def frequencies(self) -> FloatArray:
        """ln f of each mode."""
        return self.log_f[:: self.each]

    def first(self, group: int) -> int:
        """Where the coordinates of a group begin, among the roots of a mode."""
        return 1 + sum(int(basis.shape[2]) for basis in self.bases[:group])

    def between(self, low: float, high: float) -> NDArray[np.bool_]:
        """Which belong to a mode between two ln f."""
        inside = (self.frequencies > low) & (self.frequencies < high)
        return np.repeat(inside, self.each)

    def only(self, kept: NDArray[np.bool_]) -> ModeRoots:
        """Some of the modes; ``kept`` is by root."""
        modes = kept[:: self.each]
        return ModeRoots(
            self.response[kept],
            self.log_f[kept],
            self.slopes[kept] if len(self.slopes) else self.slopes,
            tuple(shapes[modes] for shapes in self.shapes),
            tuple(basis[modes] for basis in self.bases),
            self.mixed[modes],
        )

    def likeness(self, other: ModeRoots) -> FloatArray:
        """MAC with the modes of another state over all groups, (modes, its modes)."""
        alike = [(own @ theirs.T) ** 2 for own, theirs in zip(self.shapes, other.shapes, strict=True)]
        return np.asarray(np.mean(alike, axis=0))

    def since(self, before: Roots) -> tuple[Roots, NDArray[np.intp]]:
        """These with their shapes turned from those of ``before``, and which root there each has been."""
        from scipy.optimize import linear_sum_assignment

        assert isinstance(before, ModeRoots)
        alike = self.likeness(before)
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
            at = slice(self.first(group), self.first(group) + basis.shape[2])
            known = before.shapes[group][was[old]]
            facing = np.ones(was.size)
            facing[old] = np.where(np.sum(known * shapes[old], axis=1) < 0.0, -1.0, 1.0)
            shapes = facing[:, None] * shapes
            turned = basis.copy()
            turned[old] = _turned(known, shapes[old], before.bases[group][was[old]])
            if slopes is not None:  # slopes are coordinates as well
                moved = basis @ slopes[:, at]
                slopes[:, at] = facing[:, None, None] * (turned.transpose(0, 2, 1) @ moved)
            place[:, at] = 0.0
            place[old, at] = -np.einsum("mij,mi->mj", turned[old], known)
            bases.append(turned)
            faced.append(shapes)
        identity = np.where(was[:, None] >= 0, was[:, None] * self.each + np.arange(self.each), -1)
        found = ModeRoots(
            self.response,
            place.ravel(),
            self.slopes if slopes is None else slopes.reshape(self.slopes.shape),
            tuple(faced),
            tuple(bases),
            self.mixed,
        )
        return found, identity.ravel()


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
        shapes, bases, rows = [], [], [logs[:, None, :]]
        response = [0]
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
        joined = np.concatenate(rows, axis=1) if with_slopes else logs
        return ModeRoots(
            np.tile(np.array(response, dtype=np.intp), hz.size),
            places.ravel(),
            joined.reshape(hz.size * len(response), -1) if with_slopes else logs,
            tuple(shapes),
            tuple(bases),
            np.minimum(gap[:-1], gap[1:]) < _MIXED,
        )


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
