"""What the core leaves in doubt about antiresonances and modes, in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..support.validation import FloatArray
from ..support.warned import warn

__all__ = ["warn_doubts", "warn_modes_left_out"]

#: So many frequencies are named.
_NAMED = 4
#: Relative distance from which on a mode is above the highest one found.
_EDGE = 1e-6


def warn_doubts(
    dof: int,
    excitation: int | str,
    n_dof: int,
    values: Sequence[FloatArray],
    *,
    is_zero: bool,
    is_doubtful: bool,
) -> None:
    """Say whether H is zero, whether roots may be missing, and which (by their bounds) are not certain."""
    if is_zero:
        warn(
            "not_connected",
            f"response dof {dof} is not connected to excitation dof {excitation}: "
            "H is identically zero and has no antiresonance.",
        )
    if is_doubtful:
        warn(
            "hidden_by_rounding",
            f"response dof {dof}: rounding hides whether antiresonances of it are missing or double; "
            f"with {n_dof} dofs only other units or fewer digits between the stiffest and the "
            "softest part would tell.",
        )
    if len(values) == 2 and np.isinf(values[1]).any():
        open_hz = values[0][np.isinf(values[1])]
        named = ", ".join(f"{f:.6g}" for f in open_hz[:_NAMED])
        more = f" and {open_hz.size - _NAMED} more" if open_hz.size > _NAMED else ""
        warn(
            "uncertain_roots",
            f"response dof {dof}: {named}{more} Hz are not certain: too close to others to be told "
            "from them, or moved too far by the rounding of K and M.",
        )


def warn_modes_left_out(freq_hz: FloatArray, stiffness: Any, mass: Any, label: Callable[[int], str]) -> None:
    """Name dofs joined to no other whose modes are not among all modes found: too far above the lowest."""
    from scipy.sparse import csc_array

    k, m = csc_array(stiffness), csc_array(mass)
    joined = np.zeros(k.shape[0], dtype=bool)
    for matrix in (k.tocoo(), m.tocoo()):
        joined[matrix.row[(matrix.row != matrix.col) & (matrix.data != 0.0)]] = True
    own, of_mass = k.diagonal(), m.diagonal()
    alone = np.flatnonzero(~joined & (own > 0.0) & (of_mass > 0.0))
    hz = np.sqrt(own[alone] / of_mass[alone]) / (2.0 * np.pi)
    out = hz > (1.0 + _EDGE) * float(freq_hz.max(initial=0.0))
    if out.any():
        named = ", ".join(label(int(dof)) for dof in alone[out][:_NAMED])
        more = f" and {int(out.sum()) - _NAMED} more" if out.sum() > _NAMED else ""
        warn(
            "modes_left_out",
            f"modes at {named}{more}, from {hz[out].min():.6g} Hz on, are left out: they lie too far above "
            f"the lowest, {freq_hz[0]:.6g} Hz, for double precision. Models of these dofs alone have them.",
        )
