"""Springs so stiff that rounding takes what is beside them: supports and ties by penalties.

A dof whose stiffness is r times that of the others leaves them about 16 - log10(r) digits, in the sums of the
assembly already where it is a tie: a chain of five masses loses 1e-5 of its first frequency at r = 1e9, a
cantilever on springs all of it at 1e13.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exceptions import AntiresWarning
from .entries import Entries
from .stiff_softness import without_ties

if TYPE_CHECKING:
    from .structural_model import StructuralModel

__all__ = ["warn_penalties", "warn_rounded"]

#: Stiffness of a dof over that of the middle one, from which on 1e-6 of a frequency may be lost.
_MOST = 1e8
#: Share of a stiffness that rounding may have taken without a word.
_LOST = 2e-8
#: So many dofs are named.
_NAMED = 6


def warn_penalties(
    model: StructuralModel, stiffness: Any, remedy: str, *, taken_out: Sequence[int] = (), stacklevel: int
) -> None:
    """Name the dofs that are too stiff beside the others, but for those ``taken_out`` of ``stiffness``."""
    entries = Entries.of(stiffness) if isinstance(stiffness, np.ndarray) else Entries.of_sparse(stiffness)
    diagonal = np.abs(entries.diagonal(model.n_dof))
    diagonal[list(taken_out)] = 0.0
    if not diagonal.any():
        return
    middle = float(np.median(np.abs(without_ties(model.n_dof, entries))[diagonal > 0.0]))
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


def warn_rounded(model: StructuralModel, rounded: Mapping[int, float], *, stacklevel: int) -> None:
    """Name the dofs beside penalties whose stiffness the assembly has rounded."""
    spoiled = sorted(dof for dof, share in rounded.items() if share >= _LOST)
    if not spoiled:
        return
    named = ", ".join(model.dof_label(dof) for dof in spoiled[:_NAMED])
    more = f" and {len(spoiled) - _NAMED} more" if len(spoiled) > _NAMED else ""
    warnings.warn(
        f"stiffness: penalties at {named}{more}: rounding in the assembly has changed the stiffness beside "
        f"them by up to {max(rounded.values()):.1g} of it, and frequencies with it. Give ties and rigid "
        "links as constraints=, without penalties.",
        AntiresWarning,
        stacklevel=stacklevel + 1,
    )
