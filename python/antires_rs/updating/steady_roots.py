"""Roots of the intact model that a test shows, and how far they can be counted on.

The smallest damage that can be seen is told from the antiresonances that the intact structure has and a
damaged one still has, elsewhere. Not counted are those that a test of that kind does not show: the ones of
all responses for transmissibilities, those on a resonance for FRFs, with a margin within which no test tells
two of them apart.

Others count less, since small differences between the members move them far, damage or not: where a symmetric
response is weak and hangs on these differences, or where two roots are one. Of an ordinary root the
sensitivities to all stiffnesses sum up to some one, for it goes with the common scale of K: a hundredth
everywhere moves omega squared by a hundredth. One with a larger sum counts by the inverse of it. Without this
any asymmetry, of a thousandth, would count for damage.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["STEP", "followed", "roots_of", "steady"]

#: Roots of all responses this close, in Hz, or root and resonance of an FRF, are not told apart by a test.
_HIDDEN = 0.005
#: Loss of stiffness by which a root is tried.
STEP = 0.005
#: Sum of the sensitivities of omega squared up to which a root counts in full. By far most roots of symmetric
#: chains, rings, frames and grillages have 1 to 3; those that a broken symmetry makes have 10 to 10000.
_ORDINARY = 3.0


def roots_of(
    model: StructuralModel, dofs: list[int], force: int, limit_hz: float, cancelled: bool
) -> list[FloatArray | None]:
    """Roots of each response; None of one that does not respond at all."""
    found = model._core.antiresonances(dofs, force, limit_hz, "modal", cancelled)
    return [None if silent else freq for freq, silent in found]


def steady(
    model: StructuralModel,
    moved: Sequence[StructuralModel],
    dofs: list[int],
    force: int,
    limit_hz: float,
    sees: Any,
    channels: list[int],
) -> list[tuple[FloatArray, FloatArray]]:
    """Roots of each response and their weights; ``moved``: the models with one stiffness less by ``STEP``."""
    own = [np.empty(0) if f is None else f for f in roots_of(model, dofs, force, limit_hz, True)]
    shown = [~mask for mask in _hidden(own, model, dofs, force, limit_hz, sees, channels)]
    change = [np.zeros(freq.size) for freq in own]
    for other in moved:
        for nth, freq in enumerate(roots_of(other, dofs, force, 1.1 * limit_hz, True)):
            if own[nth].size:
                now = np.full(1, np.inf) if freq is None or not freq.size else freq
                nearest = now[np.abs(own[nth][:, None] - now).argmin(axis=1)]
                change[nth] += np.abs((nearest / own[nth]) ** 2 - 1.0) / STEP
    return [
        (freq[seen], np.minimum(1.0, _ORDINARY / np.maximum(total[seen], _ORDINARY)))
        for freq, seen, total in zip(own, shown, change, strict=True)
    ]


def followed(own: tuple[FloatArray, FloatArray], now: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Of the roots that are there now, those nearest to the intact ones, one to one, with their weights."""
    roots, weights = own
    if now is None or not now.size or not roots.size:
        return np.empty(0), np.empty(0)
    apart = np.abs(np.log(roots[:, None] / now))
    kept = np.zeros(now.size)
    for _ in range(min(apart.shape)):
        row, column = np.unravel_index(np.argmin(apart), apart.shape)
        kept[column] = weights[row]
        apart[row], apart[:, column] = np.inf, np.inf
    return now[kept > 0.0], kept[kept > 0.0]


def _hidden(
    own: list[FloatArray],
    model: StructuralModel,
    dofs: list[int],
    force: int,
    limit_hz: float,
    sees: Any,
    channels: list[int],
) -> list[NDArray[np.bool_]]:
    """Which of the roots of each response a test of that kind does not show."""
    if sees == "frf":
        poles = model.modes(f_max_hz=1.1 * limit_hz).freq_hz
        return [_near(freq, poles) for freq in own]
    every: dict[int, FloatArray | None] = {}
    if sees == "transmissibility":
        every = dict(zip(channels, roots_of(model, channels, force, 1.1 * limit_hz, True), strict=True))
    found = []
    for dof, freq in zip(dofs, own, strict=True):
        others = [roots for other, roots in every.items() if other != dof and roots is not None]
        shared = [_near(freq, roots) for roots in others] or [np.zeros(freq.size, dtype=bool)]
        found.append(np.logical_and.reduce(shared))
    return found


def _near(freq: FloatArray, others: FloatArray) -> NDArray[np.bool_]:
    """Whether one of the others is too close to be told apart."""
    apart = np.abs(freq[:, None] - others)
    return np.asarray(apart.min(axis=1, initial=np.inf) <= _HIDDEN * freq)
