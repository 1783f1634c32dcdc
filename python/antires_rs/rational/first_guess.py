r"""Where to start a rational fit: weights from a denominator guessed by eye.

The linear residual N - Y D carries the weight abs(D)^2 of a denominator that is not known yet. Over a wide
band, or at high order, abs(D) spans tens of decades and the first fit is lost in rounding, whatever is
reweighted afterwards. A coarse guess is enough: poles a third off bring the span down from 1e60 to a few
decades. So half as many pole pairs as the order are laid where the curve moves, at equal steps of the
integral of abs(d log P / d f), P the power of all curves, each as wide as its distance from the next. Curves
that are rough with noise move evenly: then the guess is even, too.
"""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray

__all__ = ["guessed_poles", "guessed_weights"]

# Share of the poles that is laid evenly, wherever the curve moves.
EVEN = 0.25
# Exponents beyond this would leave the range of floating point.
MOST_EXPONENT = 300.0


def guessed_poles(freq_hz: FloatArray, power: FloatArray, count: int) -> ComplexArray:
    """``count`` poles in the upper left quarter of the plane, rad/s.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.rational.first_guess import guessed_poles
    >>> f = np.linspace(1.0, 100.0, 1000)
    >>> power = 1.0 / np.abs((3.0**2 - f**2 + 0.1j * f) * (9.0**2 - f**2 + 0.1j * f))**2
    >>> (guessed_poles(f, power, 4).imag / (2 * np.pi)).round().tolist()
    [3.0, 9.0, 24.0, 69.0]
    """
    size = np.maximum(power, 1e-30 * power.max())
    moved = np.abs(np.diff(np.log(size)))
    even = np.diff(freq_hz) / (freq_hz[-1] - freq_hz[0])
    total = moved.sum()
    share = even if total == 0.0 else EVEN * even + (1.0 - EVEN) * moved / total
    climbed = np.concatenate([[0.0], np.cumsum(share)])
    hz = np.interp((np.arange(count) + 0.5) / count, climbed / climbed[-1], freq_hz)
    width = np.gradient(hz) if count > 1 else hz
    return np.asarray(2 * np.pi * (-0.5 * width + 1j * hz), dtype=np.complex128)


def guessed_weights(freq_hz: FloatArray, power: FloatArray, order: int) -> FloatArray:
    """1 / abs(D)^2 of a guessed denominator of even order up to ``order``, one in the geometric mean."""
    if order < 2:
        return np.ones(freq_hz.size)
    poles = guessed_poles(freq_hz, power, order // 2)
    s = 2j * np.pi * freq_hz[:, None]
    exponent = -2.0 * (np.log(np.abs(s - poles)) + np.log(np.abs(s - poles.conj()))).sum(axis=1)
    exponent -= exponent.mean()
    return np.asarray(np.exp(np.clip(exponent, -MOST_EXPONENT, MOST_EXPONENT)), dtype=np.float64)
