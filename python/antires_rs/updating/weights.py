"""Weights of the residuals from the uncertainty of the measured values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..measured.antiresonance_set import AntiresonanceSet
from ..support.validation import FloatArray, real_array, reject

# Relative error of omega^2 that a model has anyway: values known better than this get no more weight.
MODEL_ERROR = 2e-3


def residual_weights(
    weights: Any,
    sets: Sequence[AntiresonanceSet],
    measured_hz: FloatArray,
    kept: NDArray[np.bool_] | None = None,
) -> FloatArray | None:
    """Weight of every measured value, mean one; None for equal weights.

    "std" gives 1 / sqrt(s^2 + 0.002^2), scaled to mean one, where s = 2 std_hz / freq_hz is the deviation of
    the residual omega_A^2 / omega_E^2 - 1; a value whose deviation is not known counts like the median of
    those known. ``kept`` tells which values of the sets are compared; weights may be given for all of them.
    """
    if weights is None:
        return None
    if isinstance(weights, str):
        if weights != "std":
            reject(
                "weights",
                repr(weights),
                "None, 'std', or one number for each measured value",
                "Leave them out to count all values alike.",
            )
        std = np.concatenate([table.std_hz for each in sets for table in each.tables.values()])
        if not np.isfinite(std if kept is None else std[kept]).any():
            reject(
                "weights",
                "'std' for values without standard deviations",
                "sets with std_hz",
                "Identify an averaged record with formulation='numerators' (its default), or give std_hz.",
            )
        spread = 2.0 * (std if kept is None else std[kept]) / measured_hz
        spread = np.where(np.isfinite(spread), spread, np.nanmedian(spread))
        made = 1.0 / np.hypot(spread, MODEL_ERROR)
        return np.asarray(made / made.mean(), dtype=np.float64)
    wanted = f"{measured_hz.size} numbers of at least 0, one for each measured value"
    given = real_array("weights", weights, ndim=1, wanted=wanted)
    if kept is not None and given.size == kept.size:
        given = given[kept]
    if given.size != measured_hz.size or given.min() < 0.0 or not given.any():
        reject(
            "weights",
            f"{given.size} numbers from {given.min():g} to {given.max():g}",
            wanted,
            "Leave them out to count all values alike.",
        )
    return given
