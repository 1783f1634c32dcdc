"""Differences that a Gaussian likelihood is of, row by row, and the standard deviations stated for them.

Of antiresonances these are the residuals. Of modes they are the residuals of the frequencies and the
differences of shapes at unit length: 1 - MAC has no slope at a perfect fit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..support.validation import FloatArray
from .antiresonance_targets import AntiresonanceTargets
from .targets import ModalTargets, Targets, unit_shapes

__all__ = ["error_rows", "errors"]


def errors(targets: Targets, core: _core.Objective, x: FloatArray) -> FloatArray:
    """Differences at ``x``, (r,); a frequency without a partner counts 1."""
    if not isinstance(targets, ModalTargets):
        return targets.residuals(core, x)
    paired, _, shapes = targets._pairs(core, x)
    found = [np.where(np.isnan(paired), 1.0, (paired / targets.hz) ** 2 - 1.0)]
    first = 0
    for freq, dofs, measured in targets._parts:
        model = unit_shapes(np.nan_to_num(shapes[first : first + len(freq)][:, dofs]))
        first += len(freq)
        # Along its longest real direction a measured shape has the phase that a mode of the model has.
        turned = np.exp(-0.5j * np.angle(np.sum(measured**2, axis=1, keepdims=True)))
        seen = unit_shapes((measured * turned).real)
        sign = np.where(np.sum(seen * model, axis=1, keepdims=True) < 0.0, -1.0, 1.0)
        found.append((sign * model - seen).ravel())
    return np.concatenate(found)


def error_rows(targets: Targets) -> tuple[NDArray[np.intp], NDArray[np.intp], FloatArray]:
    """Measured value and kind of each row, (r,), and its stated standard deviation, NaN where there is none.

    The kind is 0 for frequencies and 1 for entries of shapes.
    """
    number = np.arange(targets.hz.size)
    if isinstance(targets, AntiresonanceTargets):
        tables = (table for each in targets.sets for table in each.tables.values())
        std = np.concatenate([np.empty(0), *(table.std_hz for table in tables)])
        return number, np.zeros(number.size, dtype=np.intp), 2.0 * std[targets._kept] / targets.hz
    assert isinstance(targets, ModalTargets)
    parts = targets._parts
    entries = np.repeat([len(dofs) for _, dofs, _ in parts], [len(freq) for freq, _, _ in parts])
    value = np.concatenate([number, np.repeat(number, entries)])
    kind = (np.arange(value.size) >= number.size).astype(np.intp)
    return value, kind, np.full(value.size, np.nan)
