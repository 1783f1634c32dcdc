"""Which elements a scan looks at, where there are many: those that would explain most to first order.

The likelihood's slope and curvature along each severity are at hand from the sensitivities of one point. All
other elements stay judged by the linear model alone.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import FloatArray
from .view import View

__all__ = ["COARSE", "worth_a_scan"]

#: More elements than these are not all scanned; of one damage, and of a further one, so many are.
_MANY, _SCANNED = 60, (40, 16)
#: Severities of a scan for a further damage among many elements.
COARSE = np.array([0.05, 0.16, 0.4, 0.7, 0.93])


def worth_a_scan(view: View, elements: list[int], size: int) -> list[int] | None:
    """The elements to scan for a set of ``size``, ascending; None for all of them."""
    if len(elements) <= _MANY:
        return None
    gains: FloatArray = np.clip(view.gain, 0.0, None) ** 2 / np.maximum(np.diag(view.curvature), 1e-300)
    best = sorted(elements, key=lambda e: -gains[e])[: _SCANNED[min(size, len(_SCANNED)) - 1]]
    return sorted(best)
