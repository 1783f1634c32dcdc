"""What may move values without damage: conditions not known, or outside the baseline's range."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..support.validation import FloatArray
from .learned import Learned

__all__ = ["directions"]

#: Beyond the baseline's range a slope is known to so large a share.
_SLOPE = 0.3
#: Standard deviation of a condition that is not known, and of a shared factor, in units of the baseline's.
_UNKNOWN, _FACTOR = 2.0, 5.0


def directions(
    learned: Learned, conditions: Mapping[str, FloatArray], test: int, *, free: bool
) -> FloatArray:
    """Changes of all values of one standard deviation each, (m, k), in the logarithm.

    ``free`` lets the shared factors of the baseline go where they will: no condition tells what they follow.
    """
    columns = []
    for one in learned.basis.columns:
        value = float(conditions[one.name][test])
        if np.isnan(value):
            columns.append(
                learned.basis.slopes(learned.regression.coefficients, one.name, True) * _UNKNOWN * one.std
            )
            continue
        away = max(one.low - value, value - one.high, 0.0)
        if away > 0.0:
            slope = learned.basis.slopes(learned.regression.coefficients, one.name, value > one.high)
            unsure = _SLOPE * away + learned.attenuation[one.name] * abs(value - one.middle)
            columns.append(slope * unsure)
    if free:
        columns += list((_FACTOR * learned.factors * np.sqrt(learned.variance)[:, None]).T)
    return np.stack(columns, axis=1) if columns else np.empty((learned.variance.size, 0))
