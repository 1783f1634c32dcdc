"""Whether there is room for what only dense matrices can tell."""

from __future__ import annotations

import numpy as np

from ..exceptions import OutOfMemoryError

__all__ = ["check_room_for_all_modes"]

#: Dense matrices (n, n) that all modes take: K, M, a factor, the standard problem, its vectors, the shapes.
MATRICES = 6


def check_room_for_all_modes(n_dof: int) -> None:
    """Refuse all modes where the memory cannot hold their dense matrices; say how much they take."""
    try:
        np.empty(MATRICES * n_dof * n_dof)
    except MemoryError:
        raise OutOfMemoryError(
            f"all modes of {n_dof} dofs",
            8 * MATRICES * n_dof**2,
            "All modes need dense matrices. Ask for the modes up to f_max_hz, or for the lowest n_modes.",
        ) from None
