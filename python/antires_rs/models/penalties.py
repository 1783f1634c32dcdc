"""Springs so stiff that rounding takes what is beside them: supports and ties by penalties.

A dof whose stiffness is r times that of the others leaves them about 16 - log10(r) digits, in the sums of the
assembly already where it is a tie: a chain of five masses loses 1e-5 of its first frequency at r = 1e9, a
cantilever on springs all of it at 1e13.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..support.warned import warn
from .entries import Entries
from .soft_supports import free_by_ties, softly_held
from .stiff_softness import without_ties

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .structural_model import StructuralModel

    Dofs = Sequence[int] | NDArray[np.intp]

__all__ = ["warn_penalties", "warn_rounded", "warn_softly_held"]

#: Stiffness of a dof over that of the middle one, from which on 1e-6 of a frequency may be lost.
_MOST = 1e8
#: Share of a stiffness that rounding may have taken without a word.
_LOST = 2e-8
#: So many dofs are named.
_NAMED = 6


def warn_penalties(
    model: StructuralModel, stiffness: Any, remedy: str, *, taken_out: Sequence[int] = ()
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
        soft = softly_held(model.n_dof, entries)
        for dofs, lost in soft:
            warn_softly_held(model, dofs, lost)
        for dofs, support in [] if soft else free_by_ties(model.n_dof, entries):
            _warn_free(model, dofs, float(diagonal[dofs].max()), support)
        return
    warn(
        "stiff_penalties",
        f"stiffness: {_named(model, stiff)} up to {diagonal.max() / middle:.1g} times as stiff as the middle "
        f"dof: rounding may take 1e-6 of the frequencies and more. {remedy}",
    )


def warn_rounded(model: StructuralModel, rounded: Mapping[int, float]) -> None:
    """Name the dofs beside penalties whose stiffness the assembly has rounded."""
    spoiled = sorted(dof for dof, share in rounded.items() if share >= _LOST)
    if not spoiled:
        return
    warn(
        "rounded_penalties",
        f"stiffness: penalties at {_named(model, spoiled)}: rounding in the assembly has changed the "
        f"stiffness beside them by up to {max(rounded.values()):.1g} of it, and frequencies with it. "
        "Give ties and rigid links as constraints=, without penalties.",
    )


def warn_softly_held(model: StructuralModel, dofs: Dofs, lost: float) -> None:
    """Name the dofs that move as one on supports a hundred million times softer."""
    warn(
        "softly_held",
        f"stiffness: {_named(model, dofs)} move as one beside what holds them, and rounding in the "
        f"assembly may have changed that by {lost:.1g} of it, and the lowest frequencies with it. Give ties "
        "and rigid links as constraints=, without penalties, or one mass for what moves as one.",
    )


def _warn_free(model: StructuralModel, dofs: Dofs, largest: float, support: float) -> None:
    """Name the dofs whose ties may have rounded away what held them."""
    warn(
        "free_by_ties",
        f"stiffness: nothing holds {_named(model, dofs)}, and up to {largest:.1g} is more than any part has: "
        f"beside such ties supports softer than {support:.1g} are rounded away in the sums, and a free body "
        "is left. Give ties and rigid links as constraints=, without penalties.",
    )


def _named(model: StructuralModel, dofs: Dofs) -> str:
    """The first of them by name."""
    named = ", ".join(model.dof_label(int(dof)) for dof in dofs[:_NAMED])
    return f"{named} and {len(dofs) - _NAMED} more" if len(dofs) > _NAMED else named
