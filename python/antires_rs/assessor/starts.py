"""Sets with one element more that are worth a look by the likelihood: all its severities tried."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..damage.search import Elements
from ..support.validation import FloatArray
from .tables import LEVELS

__all__ = ["Start", "starts"]

Start = tuple[Elements, FloatArray]

#: Sets of a scan that are refined, by the distances of the values and by their misfit; all single elements.
_BY_DISTANCE, _BY_MISFIT = 12, 14
#: Steps of the refinement, and sets so far below the likeliest (log-likelihood) that are given up.
_STEPS, _HOPELESS = 2, 25.0


def starts(
    test: _core.PreparedTest, parents: list[Start], count: int, known: set[Elements], most: int
) -> list[Start]:
    """At most so many sets of a parent and one of ``count`` elements, but for those known, the likeliest
    first; with severities (u) of theirs."""
    of_parent: list[NDArray[np.intp]] = []
    of_further: list[NDArray[np.intp]] = []
    scans: tuple[list[FloatArray], list[FloatArray]] = ([], [])
    for nth, (parent, u) in enumerate(parents):
        further = np.array([e for e in range(count) if e not in parent], dtype=np.intp)
        if further.size:
            scan_of = test.scan(list(parent), u.tolist(), further.tolist())
            of_parent.append(np.full(further.size, nth))
            of_further.append(further)
            for known_so_far, one in zip(scans, scan_of, strict=True):
                known_so_far.append(one)
    if not of_parent:
        return []
    parent_of, further_of = np.concatenate(of_parent), np.concatenate(of_further)
    chosen: dict[tuple[Elements, int], list[float]] = {}
    for scan, few in zip(scans, (_BY_DISTANCE, _BY_MISFIT if parents[0][0] else count), strict=True):
        left = np.concatenate(scan)
        level = np.argmin(left, axis=1)
        order = np.argsort(left[np.arange(level.size), level], kind="stable")
        for elements, at, u_of in _sets(parents, parent_of, further_of, level, order, few, known):
            chosen.setdefault((elements, at), u_of)
    best: dict[Elements, tuple[float, FloatArray]] = {}
    asked = [(list(elements), u_of) for (elements, _), u_of in chosen.items()]
    for (elements, _), (u_now, score) in zip(chosen, test.refine(asked, _STEPS), strict=True):
        if elements not in best or score < best[elements][0]:
            best[elements] = (score, np.array(u_now))
    likeliest = sorted(best, key=lambda s: best[s][0])[:most]
    return [(s, best[s][1]) for s in likeliest if best[s][0] < best[likeliest[0]][0] + _HOPELESS]


def _sets(
    parents: list[Start],
    parent_of: NDArray[np.intp],
    further_of: NDArray[np.intp],
    level: NDArray[np.intp],
    order: NDArray[np.intp],
    most: int,
    known: set[Elements],
) -> list[tuple[Elements, int, list[float]]]:
    """The first of a scan: elements, level of the new one, severities."""
    found: list[tuple[Elements, int, list[float]]] = []
    for nth in order.tolist():
        parent, u = parents[parent_of[nth]]
        u_new = float(LEVELS[level[nth]])
        joined = sorted([*zip(parent, u.tolist(), strict=True), (int(further_of[nth]), u_new)])
        elements = tuple(e for e, _ in joined)
        if elements not in known:
            found.append((elements, int(level[nth]), [x for _, x in joined]))
        if len(found) == most:
            break
    return found
