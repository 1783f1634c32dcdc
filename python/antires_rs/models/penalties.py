"""Springs so stiff that rounding takes what is beside them: supports and ties by penalties.

A dof whose stiffness is r times that of the others leaves them about 16 - log10(r) digits: a chain of five
masses loses 1e-5 of its first frequency at r = 1e9, a cantilever on springs all of it at 1e13.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..support.checks import FloatArray
from ..support.messages import some, warn
from .matrices import Entries

# -- Parts of a structure that are held by next to nothing: all dofs tied together, on soft springs
#
# Scaled to a diagonal of ones, the stiffness of such a part has an eigenvalue :math:`\lambda` of 1e-8 and
# less, and none up to 1e8 times that. Rounding of the entries takes :math:`\epsilon / \lambda` of it; below
# some ulps the part is free. Whether it had supports shows by the size of the springs alone: those beyond
# what a material gives are ties.

#: Eigenvalue up to which rounding takes 2e-8 of it, its largest part of the next, and what may be rounding.
_SOFT, _GAP, _ROUNDING = 1e-8, 1e-8, 1e-14
#: Most dofs of a part whose eigenvalues are formed; of a larger one rows of springs are summed.
_MOST_SOFT_SUPPORTS = 300
_RIGID = 6  # most rigid motions of a part
_MOVED = 1e-3  # motion of each dof, over the largest, where all move
_EPS = float(np.finfo(np.float64).eps)
#: Stiffness that no part has in units in use: a metre of steel gives 2e11 N/m, 2e14 dyn/cm.
_NO_MATERIAL = 1e17


def softly_held(n: int, stiffness: Entries) -> list[tuple[NDArray[np.intp], float]]:
    """Dofs of each such part, and what rounding may take of its softest stiffness, relatively."""
    found = []
    for dofs, own, k in _parts(n, stiffness, 0.0):
        lost = _of_springs(own, k)
        if lost is None and dofs.size <= _MOST_SOFT_SUPPORTS:
            lost = _of_eigenvalues(own.toarray() / np.sqrt(np.outer(k, k)))
        if lost is not None:
            found.append((dofs, lost))
    return found


def free_by_ties(n: int, stiffness: Entries) -> list[tuple[NDArray[np.intp], float]]:
    """Dofs of each part of ties alone that nothing holds, and the support (N/m) below which it is lost."""
    found = []
    for dofs, own, k in _parts(n, stiffness, _NO_MATERIAL):
        ground = np.abs(np.asarray(own.sum(axis=1)).ravel())
        free = bool((ground <= np.diff(own.indptr) * _EPS * k).all())
        if not free and dofs.size <= _MOST_SOFT_SUPPORTS:  # rotations take part
            scaled = own.toarray() / np.sqrt(np.outer(k, k))
            free = float(np.linalg.eigvalsh(scaled)[0]) <= _ROUNDING * dofs.size**0.5
        if free:
            found.append((dofs, 0.5 * _EPS * float(k.max())))
    return found


def _parts(n: int, stiffness: Entries, least: float) -> Iterator[tuple[NDArray[np.intp], Any, FloatArray]]:
    """Dofs, matrix and its diagonal of each part of several dofs, all of them stiffer than ``least``."""
    from scipy.sparse.csgraph import connected_components

    k = stiffness.diagonal(n)
    if not (k > least).any():
        return
    matrix = stiffness.sparse(n)
    _, group = connected_components(matrix, directed=False)
    number = np.bincount(group)
    parts = np.split(np.argsort(group, kind="stable"), np.cumsum(number)[:-1])
    for dofs in (parts[each] for each in np.flatnonzero(number > 1)):
        if (k[dofs] > least).all():
            yield dofs, matrix[dofs][:, dofs], k[dofs]


def lost_beside(ground: float, springs: FloatArray) -> float | None:
    """What rounding may take of springs to ground (N/m, their sum) beside those between the masses."""
    if not springs.size or not 0.0 < ground <= _SOFT * float(springs.min()):
        return None
    return min(1.0, float(np.sqrt(springs.size)) * _EPS * float(springs.max()) / ground)


def _of_springs(own: Any, k: FloatArray) -> float | None:
    """Of springs alone: each row sums up to the spring to ground."""
    rows = own.tocoo()
    off = rows.row != rows.col
    if (rows.data[off] > 0.0).any():
        return None
    ground = np.asarray(own.sum(axis=1)).ravel()
    count = np.bincount(rows.row, minlength=k.size)
    held = np.where(np.abs(ground) > count * _EPS * k, ground, 0.0)
    return lost_beside(float(held.sum()), -rows.data[off])


def _of_eigenvalues(scaled: FloatArray) -> float | None:
    try:
        np.linalg.cholesky(scaled - _SOFT * np.eye(len(scaled)))
    except np.linalg.LinAlgError:
        pass
    else:
        return None  # the usual case, at a tenth of the cost
    lowest, shapes = np.linalg.eigh(scaled)
    for nth in range(min(_RIGID, len(scaled) - 1)):
        if _ROUNDING * len(scaled) ** 0.5 < lowest[nth] <= min(_SOFT, _GAP * lowest[nth + 1]):
            # Of a tie inside a structure only its own dofs move so.
            moved = np.linalg.norm(shapes[:, : nth + 1], axis=1)
            return min(1.0, _EPS / float(lowest[nth])) if moved.min() > _MOVED * moved.max() else None
    return None


# -- How stiff a dof is without the ties it is in
#
# Scaled to a diagonal of ones, :math:`|k_{ij}| / \sqrt{k_{ii} k_{jj}}`, dofs of a tie are joined by couplings
# of the order of one, and to its neighbours by 2e-3 and less. Where what is joined can move as a rigid body,
# these neighbours alone hold it. None of this depends on the units of a dof.

#: Part of its stiffness that a tie leaves, at most, and its largest scaled coupling to soft neighbours.
_LEFT = 1.0 / 3e5
_WEAK = float(np.sqrt(_LEFT))
#: Most dofs of one tie, and of one between two nodes, of which couplings below ``_ROUNDING`` count too: those
#: of others may be the rounding of an angle.
_MOST_TIED, _TWO_NODES = 300, 12


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
    tied = (outward > 0.0) & (number > 1) & (number <= _MOST_TIED)
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


# -- Warnings

_MOST = 3e7  # stiffness of a dof over that of the middle one, from which on 1e-6 of a frequency may be lost


def warn_penalties(label: Callable[[int], str], stiffness: Any, remedy: str) -> None:
    """Name the dofs that are too stiff beside the others."""
    n = stiffness.shape[0]
    entries = Entries.of(stiffness) if isinstance(stiffness, np.ndarray) else Entries.of_sparse(stiffness)
    diagonal = np.abs(entries.diagonal(n))
    if not diagonal.any():
        return
    middle = float(np.median(np.abs(without_ties(n, entries))[diagonal > 0.0]))
    stiff = np.flatnonzero(diagonal >= _MOST * middle)
    if stiff.size:
        said = f"stiffness: {_named(label, stiff)} up to {diagonal.max() / middle:.1g} times as stiff as the "
        said += f"middle dof: rounding may take 1e-6 of the frequencies and more. {remedy}"
        warn("stiff_penalties", said)
        return
    soft = softly_held(n, entries)
    for dofs, lost in soft:
        warn_softly_held(label, dofs, lost)
    for dofs, support in [] if soft else free_by_ties(n, entries):
        said = (
            f"stiffness: nothing holds {_named(label, dofs)}, and up to {diagonal[dofs].max():.1g} is more "
            f"than any part has: beside such ties supports softer than {support:.1g} are rounded away in the "
            "sums, and a free body is left. Give ties and rigid links as constraints=, without penalties."
        )
        warn("free_by_ties", said)


def warn_softly_held(label: Callable[[int], str], dofs: Any, lost: float) -> None:
    """Name the dofs that move as one on supports a hundred million times softer."""
    said = (
        f"stiffness: {_named(label, dofs)} move as one beside what holds them, and rounding in the assembly "
        f"may have changed that by {lost:.1g} of it, and the lowest frequencies with it. Give ties and rigid "
        "links as constraints=, without penalties, or one mass for what moves as one."
    )
    warn("softly_held", said)


def _named(label: Callable[[int], str], dofs: Any) -> str:
    return some((label(int(dof)) for dof in dofs), 6)
