"""What the core leaves in doubt about the antiresonances of a response, in words."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from ..exceptions import AntiresWarning
from ..support.validation import FloatArray

__all__ = ["warn_doubts"]

#: So many frequencies are named.
_NAMED = 4


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
        _warn(
            f"response dof {dof} is not connected to excitation dof {excitation}: "
            "H is identically zero and has no antiresonance."
        )
    if is_doubtful:
        _warn(
            f"response dof {dof}: rounding hides whether antiresonances of it are missing or double; "
            f"with {n_dof} dofs only other units or fewer digits between the stiffest and the "
            "softest part would tell."
        )
    if len(values) == 2 and np.isinf(values[1]).any():
        open_hz = values[0][np.isinf(values[1])]
        named = ", ".join(f"{f:.6g}" for f in open_hz[:_NAMED])
        more = f" and {open_hz.size - _NAMED} more" if open_hz.size > _NAMED else ""
        _warn(
            f"response dof {dof}: {named}{more} Hz are not certain: too close to others to be told "
            "from them, or moved too far by the rounding of K and M."
        )


def _warn(text: str) -> None:
    warnings.warn(text, AntiresWarning, stacklevel=4)
