r"""Descent on values and roots put side by side, one to one and in order: leads near the answer from afar.

The objective pairs each measured value with the nearest root, anew at every x; from a start that is off by
a spacing of the roots it pulls some of them to the wrong neighbour. Here the values of each response are
aligned with the model's roots as a whole (``_core.associate``), with gaps on both sides, and
:math:`\sum |\ln f_A - \ln f_E|` is brought down by linear steps within the bounds (iteratively reweighted
least squares). What is found after a dozen solutions of the model is a start for the search, not an answer.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ..support.validation import FloatArray

__all__ = ["aligned_descent"]

#: Standard deviation of ln f in the alignment at the beginning, its decrease a step, and the least.
_STD, _SHRINK, _LEAST_STD = 0.1, 0.75, 0.02
#: Standard deviations at which a value, or a root, rather stays alone; of a root above the highest value.
_ALONE, _ALONE_ROOT, _ALONE_ABOVE = 3.0, 2.0, 0.3
#: Roots are followed up to this multiple of the highest value.
_BAND = 1.25
#: Trust region, as a share of the bounds' distance; most steps; a step that ends the descent.
_FIRST_TRUST, _TRUST, _STEPS, _SMALL_STEP = 0.35, 0.25, 12, 0.02
#: Reweightings of a step, and the weight of a step's own length.
_REWEIGHTINGS, _DAMPING = 3, 1e-3


def aligned_descent(
    core: _core.Objective, targets: list[tuple[int, FloatArray]], x: FloatArray, bounds: FloatArray
) -> FloatArray:
    """Where the descent ends that begins at ``x``; ``targets`` are number and values of each."""
    response = np.repeat([nth for nth, _ in targets], [freq.size for _, freq in targets]).astype(np.int64)
    measured = np.log(np.concatenate([np.sort(freq) for _, freq in targets]))
    low, high = bounds.T
    width = high - low
    std, trust = _STD, _FIRST_TRUST
    for nth in range(_STEPS):
        roots = _roots(core, x, float(np.exp(measured.max())))
        partner = _aligned(response, measured, std, roots)
        paired = partner >= 0
        if not paired.any():
            break
        apart = roots[1][partner[paired]] - measured[paired]
        room = (np.maximum((low - x) / width, -trust), np.minimum((high - x) / width, trust))
        step = _least_absolute(apart, roots[2][partner[paired]] * width, room)
        x = np.clip(x + step * width, low, high)
        std, trust = max(_LEAST_STD, _SHRINK * std), _FIRST_TRUST if nth < 4 else _TRUST
        if np.abs(step).max() < _SMALL_STEP:
            break
    return x


def _roots(
    core: _core.Objective, x: FloatArray, highest_hz: float
) -> tuple[NDArray[np.int64], FloatArray, FloatArray, NDArray[np.bool_]]:
    """Target, ln f and slopes of the roots that can be measured, and which lie above the highest value."""
    (target, freq_hz, shown, slopes, *_), *_ = core.states(x[None], True, 1, 0.0, _BAND * highest_hz)
    seen = shown > 0.5
    rows = np.reshape(slopes, (freq_hz.size, x.size))[seen]
    return target[seen].astype(np.int64), np.log(freq_hz[seen]), rows, freq_hz[seen] > highest_hz


def _aligned(response: NDArray[np.int64], measured: FloatArray, std: float, roots: Any) -> NDArray[np.intp]:
    """Root of each value, -1 without one."""
    target, log_f, _, above = roots
    price = 0.5 * np.log(2.0 * np.pi) + np.log(std) + 0.5 * _ALONE**2
    return _core.associate(
        response,
        measured,
        np.full(measured.size, std),
        target,
        log_f,
        np.full(log_f.size, 1e-6),
        float(price),
        np.where(above, 0.5 * _ALONE_ABOVE**2, 0.5 * _ALONE_ROOT**2),
    )


def _least_absolute(apart: FloatArray, slopes: FloatArray, room: tuple[FloatArray, FloatArray]) -> FloatArray:
    """The step d within ``room`` of least sum of abs(apart + slopes d)."""
    from scipy.optimize import lsq_linear

    n = slopes.shape[1]
    low, high = np.minimum(room[0], -1e-9), np.maximum(room[1], 1e-9)
    floor = max(1e-5, 0.3 * float(np.median(np.abs(apart))))
    step = np.zeros(n)
    for _ in range(_REWEIGHTINGS):
        weight = 1.0 / np.sqrt(np.maximum(np.abs(apart + slopes @ step), floor))
        rows = np.vstack([slopes * weight[:, None], _DAMPING * np.eye(n)])
        step = lsq_linear(rows, np.append(-apart * weight, np.zeros(n)), (low, high), method="bvls").x
    return np.asarray(step)
