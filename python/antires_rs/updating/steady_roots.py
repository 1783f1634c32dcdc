"""Roots of the intact model that a test shows, and how far they can be counted on.

The smallest damage that can be seen is told from the antiresonances that the intact structure has and a
damaged one still has, elsewhere. Not counted are those that a test of that kind does not show: the ones of
all responses for transmissibilities, those on a resonance for FRFs, with a margin within which no test tells
two of them apart; nor new ones, made of zeros that were complex.

Others count less or not at all, since small differences between the members move them far, damage or not:
where a symmetric response is weak and hangs on these differences, or where two roots are all but one. The
sensitivities of an ordinary root to all stiffnesses add up to about one, for it goes with the common scale of
K: a hundredth everywhere moves omega squared by a hundredth. Without this any asymmetry, of a thousandth,
would pass for damage.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..support.validation import FloatArray
from .complex_zeros import complex_zeros

if TYPE_CHECKING:
    from ..models.structural_model import StructuralModel

__all__ = ["STEP", "followed", "roots_of", "steady"]

#: Roots of all responses within this share are taken for one: a hidden mode, with double roots beside it that
#: hardly any difference between the members splits by so much.
_SHARED = 0.02
#: A root this near to a resonance, in Hz, is not told from it in an FRF.
_ON_POLE = 0.005
#: Loss of stiffness by which a root is tried.
STEP = 0.005
#: Sum of the sensitivities of omega squared up to which a root counts in full, and from which on it does not
#: count. By far most roots of symmetric chains, rings, frames and grillages have 1 to 3, those that a broken
#: symmetry makes, or one that is all but double, 10 to 10000.
_ORDINARY, _UNSTEADY = 3.0, 6.0
#: Intact roots are as good as one if they lie within this share.
_TWIN = 0.01
#: Complex zeros with such shares of imaginary part may become antiresonances by a small change.
_COMPLEX = (1e-6, 0.3)


def roots_of(
    model: StructuralModel, dofs: list[int], force: int, limit_hz: float, cancelled: bool
) -> list[FloatArray | None]:
    """Roots of each response; None of one that does not respond at all."""
    core, rows = model._core_for([*dofs, force])
    found = core.antiresonances(rows[:-1], rows[-1], limit_hz, "modal", cancelled)
    return [None if silent else freq for freq, silent, _ in found]


def steady(
    model: StructuralModel,
    moved: Sequence[StructuralModel],
    dofs: list[int],
    force: int,
    limit_hz: float,
    sees: Any,
    channels: list[int],
) -> list[tuple[FloatArray, FloatArray]]:
    """Roots of each response and their weights, 0 for those that do not count, complex ones among them.

    ``moved`` are the models with one stiffness less by ``STEP``.
    """
    every = {
        dof: None if freq is None else (freq, complex_zeros(model, dof, force, limit_hz, _COMPLEX)[0])
        for dof, freq in _by_dof(model, {*dofs, *channels}, force, limit_hz).items()
    }
    none = (np.empty(0), np.empty(0))
    own = [(every[dof] or none)[0] for dof in dofs]
    hidden = (
        _hidden(dofs, every, channels)
        if sees == "transmissibility"
        else _on_poles(own, model, limit_hz, sees)
    )
    change = [np.zeros(freq.size) for freq in own]
    for other in moved:
        for nth, freq in enumerate(roots_of(other, dofs, force, 1.1 * limit_hz, True)):
            if own[nth].size:
                now = np.full(1, np.inf) if freq is None or not freq.size else freq
                nearest = now[np.abs(own[nth][:, None] - now).argmin(axis=1)]
                change[nth] += np.abs((nearest / own[nth]) ** 2 - 1.0) / STEP
    found = []
    for dof, freq, unseen, total in zip(dofs, own, hidden, change, strict=True):
        weight = np.clip((_UNSTEADY - total) / (_UNSTEADY - _ORDINARY), 0.0, 1.0) * ~unseen
        others = (every[dof] or none)[1]
        found.append((np.append(freq, others), np.append(weight, np.zeros(others.size))))
    return found


def followed(own: tuple[FloatArray, FloatArray], now: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Of the roots that are there now, those that an intact one has become, with its weight.

    The nearest pairs go first, one to one. One that is left to an intact root farther away than others is of
    unknown descent, and does not count.
    """
    roots, weights = own
    if now is None or not now.size or not roots.size:
        return np.empty(0), np.empty(0)
    apart = np.abs(roots[:, None] - now)
    nearest = apart.min(axis=0) + _TWIN * now
    kept = np.zeros(now.size)
    for _ in range(min(apart.shape)):
        row, column = np.unravel_index(np.argmin(apart), apart.shape)
        kept[column] = weights[row] * (apart[row, column] <= nearest[column])
        apart[row], apart[:, column] = np.inf, np.inf
    return now[kept > 0.0], kept[kept > 0.0]


def _by_dof(
    model: StructuralModel, dofs: set[int], force: int, limit_hz: float
) -> dict[int, FloatArray | None]:
    """All roots by response."""
    ordered = sorted(dofs)
    return dict(zip(ordered, roots_of(model, ordered, force, limit_hz, True), strict=True))


def _hidden(
    dofs: list[int], every: dict[int, tuple[FloatArray, FloatArray] | None], channels: list[int]
) -> list[NDArray[np.bool_]]:
    """Which roots of each response all others share, also where theirs have just become complex."""
    found = []
    for dof in dofs:
        freq = (every[dof] or (np.empty(0),))[0]
        others = [every[other] for other in channels if other != dof]
        shared = [_near(freq, np.concatenate(both), _SHARED) for both in others if both is not None]
        found.append(np.logical_and.reduce(shared or [np.zeros(freq.size, dtype=bool)]))
    return found


def _on_poles(
    own: list[FloatArray], model: StructuralModel, limit_hz: float, sees: Any
) -> list[NDArray[np.bool_]]:
    """Which roots an FRF does not show, for they lie on a resonance; where that is not known, none."""
    poles = model.modes(f_max_hz=1.1 * limit_hz).freq_hz if sees == "frf" else np.empty(0)
    return [_near(freq, poles, _ON_POLE) for freq in own]


def _near(freq: FloatArray, others: FloatArray, within: float) -> NDArray[np.bool_]:
    """Whether one of the others is this near."""
    apart = np.abs(freq[:, None] - others)
    return np.asarray(apart.min(axis=1, initial=np.inf) <= within * freq)
