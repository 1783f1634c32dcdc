"""What all channels share is no property of one of them.

A root that all numerators have is a common factor, which cancels in every transmissibility. A value that all
of three or more responses have is the zero beside a mode that the force hardly excites.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .diagram import StabilizationDiagram
from .limits import COMMON, COMMON_DEPTH_DB, SHARED
from .table import ResponseTable

__all__ = ["shared", "without_common"]


def shared(values: Any, others: Sequence[Any], within: float = SHARED) -> NDArray[np.bool_]:
    """Whether all of two or more ``others`` have a member within this share of each value, (n,).

    Values may be roots in the complex plane or frequencies. One of ``others`` may be (n, m), with members
    of its own for each value.
    """
    if len(others) < 2:
        return np.zeros(values.size, dtype=bool)
    size = within * np.abs(values)
    every = np.ones(values.size, dtype=bool)
    for other in others:
        every &= np.abs(other - values[:, None]).min(axis=1, initial=np.inf) <= size
        if not every.any():
            break
    return every


def without_common(found: dict[Any, StabilizationDiagram]) -> dict[Any, StabilizationDiagram]:
    """Diagrams less the values that all of three or more dofs have, spread by no more than ``COMMON``.

    Where depths are known, a deep dip stays: what all share takes little of each curve.
    """
    if len(found) < 3:
        return found
    drop: dict[Any, set[int]] = {dof: set() for dof in found}
    values = [d.identified for d in found.values()]
    first, *others = values
    for value in first[shared(first, others, COMMON)]:
        nearest = [int(np.argmin(np.abs(each - value))) for each in values]
        same = [each[i] for each, i in zip(values, nearest, strict=True)]
        # A mode gives each channel one such value; two in one channel belong to two parts of the structure.
        once = all(np.sum(np.abs(each - value) <= COMMON * value) <= 1 for each in values)
        if once and max(same) - min(same) <= COMMON * value:
            for dof, i in zip(found, nearest, strict=True):
                if not _deep(found[dof].accepted, i):
                    drop[dof].add(i)
    return {
        dof: replace(d, accepted=d.accepted.take([i for i in range(d.identified.size) if i not in drop[dof]]))
        for dof, d in found.items()
    }


def _deep(table: ResponseTable, i: int) -> bool:
    """Whether an antiresonance of fits over windows has a deep dip."""
    if "depth_db" not in table.scores:
        return False
    return float(np.fmin(table.scores["depth_db"][i], table.scores["own_depth_db"][i])) >= COMMON_DEPTH_DB
