"""Springs so stiff that rounding takes what is beside them: supports and ties by penalties.

A dof whose stiffness is r times that of the others leaves them about 16 - log10(r) digits, in the sums of the
assembly already where it is a tie: a chain of five masses loses 1e-5 of its first frequency at r = 1e9, a
cantilever on springs all of it at 1e13.
"""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from ..exceptions import AntiresWarning

if TYPE_CHECKING:
    from .structural_model import StructuralModel

__all__ = ["warn_penalties"]

#: Stiffness of a dof over that of the middle one, from which on 1e-6 of a frequency may be lost.
_MOST = 1e8
#: So many dofs are named.
_NAMED = 6


def warn_penalties(model: StructuralModel, stiffness: object, remedy: str, *, stacklevel: int) -> None:
    """Name the dofs that are too stiff beside the others; ``stiffness`` is the model's, sparse or dense."""
    diagonal = np.abs(np.asarray(stiffness.diagonal(), dtype=np.float64))  # type: ignore[attr-defined]
    if not diagonal.any():
        return
    middle = float(np.median(diagonal[diagonal > 0.0]))
    stiff = np.flatnonzero(diagonal >= _MOST * middle)
    if not stiff.size:
        return
    named = ", ".join(model.dof_label(int(dof)) for dof in stiff[:_NAMED])
    more = f" and {stiff.size - _NAMED} more" if stiff.size > _NAMED else ""
    warnings.warn(
        f"stiffness: {named}{more} up to {diagonal.max() / middle:.1g} times as stiff as the middle dof: "
        f"rounding may take 1e-6 of the frequencies and more. {remedy}",
        AntiresWarning,
        stacklevel=stacklevel + 1,
    )
