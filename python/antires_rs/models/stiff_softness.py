r"""How stiff a dof is without the ties it is in.

Scaled to a diagonal of ones, :math:`|k_{ij}| / \sqrt{k_{ii} k_{jj}}`, dofs of a tie are joined by couplings
of the order of one, and to its neighbours by those that a penalty leaves, 2e-3 and less. Where what is
joined can move as a rigid body, these neighbours alone are what holds it. None of this depends on the units
of a dof, nor on how many of the dofs are soft.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import FloatArray
from .entries import Entries

__all__ = ["without_ties"]

#: Part of its stiffness that a tie leaves, at most.
_LEFT = 1.0 / 3e5
#: Largest scaled coupling of a tie to soft neighbours.
_WEAK = float(np.sqrt(_LEFT))
#: Couplings so small may be the rounding of an angle; they count for ties of two nodes only.
_ROUNDING = 1e-14
#: Most dofs of one tie, and of one between two nodes.
_MOST, _TWO_NODES = 300, 12


def without_ties(n: int, stiffness: Entries) -> FloatArray:
    """Diagonal of the stiffness (n,); of tied dofs twice their stiffest coupling to others, as in a chain."""
    from scipy.sparse.csgraph import connected_components

    k = stiffness.diagonal(n)
    size = np.sqrt(np.where(k > 0.0, k, 1.0))
    scaled = stiffness._replace(values=stiffness.values / size[stiffness.rows] / size[stiffness.columns])
    weak = np.abs(scaled.values) <= _WEAK
    if not weak.any():
        return k
    count, group = connected_components(scaled.those(~weak).sparse(n), directed=False)
    number, at = np.bincount(group), group[stiffness.rows]
    least = np.where(number[at] <= _TWO_NODES, 0.0, _ROUNDING)
    between = weak & (np.abs(scaled.values) > least) & (at != group[stiffness.columns])
    outward = np.zeros(count)
    np.maximum.at(outward, at[between], np.abs(stiffness.values[between]))
    tied = (outward > 0.0) & (number > 1) & (number <= _MOST)
    if not tied.any():
        return k
    place = np.empty(n, dtype=np.intp)  # of each dof in its group
    place[np.argsort(group, kind="stable")] = np.arange(n) - np.repeat(np.cumsum(number) - number, number)
    inside = scaled.those(tied[at] & (at == group[stiffness.columns]))
    held = group[inside.rows]
    for size_of in np.unique(number[tied]):
        these = np.flatnonzero(tied & (number == size_of))
        own, chosen = np.zeros((these.size, size_of, size_of)), number[held] == size_of
        part = inside.those(chosen)
        own[np.searchsorted(these, held[chosen]), place[part.rows], place[part.columns]] = part.values
        tied[these] = np.linalg.eigvalsh(own)[:, 0] <= _LEFT
    return np.where(tied[group], np.minimum(k, 2.0 * outward[group]), k)
