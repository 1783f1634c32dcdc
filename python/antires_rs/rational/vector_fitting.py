r"""Vector fitting with common poles: rational functions found by moving their poles.

Model: Y_o(s) = sum_k c_ok / (s - a_k) + d_o + s e_o for every output o, the poles a_k common. With poles a_k
given, sigma(s) = sum_k c_k / (s - a_k) + d is sought for which all sigma Y_o have these same poles; then the
zeros of sigma are better poles, and the step is repeated. The unknowns of the outputs are projected out one
output after the other, and of sigma only Re sum_n sigma(s_n) = n_freq is asked ("relaxed"). Poles that wander
into the right half plane are left there: mirrored, spurious ones would come back as sharp peaks.

References: B. Gustavsen and A. Semlyen, IEEE Trans. Power Delivery 14 (1999) 1052-1061; B. Gustavsen, ibid.
21 (2006) 1587-1592 (relaxed); D. Deschrijver, M. Mrozowski, T. Dhaene and D. De Zutter, IEEE Microw. Wirel.
Compon. Lett. 18 (2008) 383-385 (projection).
"""

from __future__ import annotations

import numpy as np

from ..support.validation import ComplexArray, FloatArray
from .dominance import share_of_curve

__all__ = ["vector_fitting"]

ITERATIONS = 12
#: Damping ratio of the starting poles, which lie evenly over the band.
START_DAMPING = 0.01
#: The constant of sigma is kept from vanishing: its poles would go to infinity.
LEAST_CONSTANT = 1e-8


def vector_fitting(
    freq_hz: FloatArray, values: ComplexArray, weights: FloatArray, n_poles: int
) -> tuple[ComplexArray, FloatArray]:
    """Poles of the outputs and how much of the curves each owns.

    Parameters
    ----------
    freq_hz : (n_freq,)
    values : (n_outputs, n_freq) complex
    weights : (n_freq,)
        Of squared residuals.
    n_poles : int
        Pairs of complex poles.

    Returns
    -------
    s : (n,) complex, rad/s
        One pole of each pair, on either side of the imaginary axis.
    dominance : (n,)
        Norm of its residues over ``abs(Re s)``, over the norm of the fitted curves at its frequency.

    Examples
    --------
    >>> import numpy as np
    >>> from antires_rs.rational.vector_fitting import vector_fitting
    >>> f = np.linspace(1.0, 20.0, 200)
    >>> y = 1.0 / (5**2 - f**2 + 0.1j * f) - 1.0 / (10**2 - f**2 + 0.2j * f)
    >>> s, dominance = vector_fitting(f, y[None, :], np.ones(200), 2)
    >>> np.sort(np.abs(s) / (2 * np.pi)).round(6).tolist(), dominance.round(1).tolist()
    ([5.0, 10.0], [1.0, 1.0])
    """
    s = 1j * freq_hz / freq_hz[-1]
    root = np.sqrt(weights / weights.sum())[:, None]
    low, high = freq_hz[0] / freq_hz[-1], 1.0
    start = low + (np.arange(n_poles) + 0.5) * (high - low) / n_poles
    poles = start * (-START_DAMPING + 1j)
    size = float(np.linalg.norm(root.T * values))
    for _ in range(ITERATIONS):
        phi = _fractions(s, poles)
        q = np.linalg.qr(_stack(root * _with_line(phi, s)))[0]
        one = root * np.hstack([phi, np.ones((s.size, 1))])
        blocks = []
        for value in values:
            rest = _stack(one * value[:, None])
            blocks.append(np.linalg.qr(rest - q @ (q.T @ rest), mode="r"))
        relaxed = np.append(phi.real.mean(axis=0), 1.0) * size
        rows = np.concatenate([*blocks, relaxed[None, :]])
        target = np.zeros(rows.shape[0])
        target[-1] = size
        solution = _scaled_lstsq(rows, target[:, None])[:, 0]
        poles = _zeros(poles, solution[:-1], float(solution[-1]))
    return poles * (2 * np.pi * freq_hz[-1]), _dominance(s, values, root, poles)


def _fractions(s: ComplexArray, poles: ComplexArray) -> ComplexArray:
    """Partial fractions with real coefficients: u + v and i (u - v) for each pair."""
    u, v = 1.0 / (s[:, None] - poles), 1.0 / (s[:, None] - poles.conj())
    out = np.empty((s.size, 2 * poles.size), dtype=np.complex128)
    out[:, 0::2], out[:, 1::2] = u + v, 1j * (u - v)
    return out


def _with_line(phi: ComplexArray, s: ComplexArray) -> ComplexArray:
    """The constant and the term in s, which stand for all poles far outside the band."""
    return np.hstack([phi, np.ones((s.size, 1)), s[:, None]])


def _stack(z: ComplexArray) -> FloatArray:
    return np.concatenate([z.real, z.imag])


def _scaled_lstsq(left: FloatArray, right: FloatArray) -> FloatArray:
    """Least squares with columns of unit norm, or their sizes would decide on the rank."""
    scale = np.maximum(np.linalg.norm(left, axis=0), 1e-300)
    return np.asarray(np.linalg.lstsq(left / scale, right, rcond=None)[0] / scale[:, None])


def _zeros(poles: ComplexArray, c: FloatArray, d: float) -> ComplexArray:
    """Zeros of sigma, one of each pair: eigenvalues of A - b c' / d."""
    d = float(np.copysign(max(abs(d), LEAST_CONSTANT), d))
    a = np.zeros((2 * poles.size, 2 * poles.size))
    even = np.arange(0, 2 * poles.size, 2)
    a[even, even] = a[even + 1, even + 1] = poles.real
    a[even, even + 1], a[even + 1, even] = poles.imag, -poles.imag
    b = np.zeros(2 * poles.size)
    b[even] = 2.0
    z = np.linalg.eigvals(a - np.outer(b, c) / d)
    upper, real = z[z.imag > 0.0], np.sort(z[z.imag == 0.0].real)
    # Two real poles become a pair with the same sum; they belong to no antiresonance anyway.
    pairs = 0.5 * (real[0::2] + real[1::2]) + 1j * np.maximum(0.5 * (real[1::2] - real[0::2]), 1e-3)
    return np.concatenate([upper, pairs])


def _dominance(s: ComplexArray, values: ComplexArray, root: FloatArray, poles: ComplexArray) -> FloatArray:
    """Residues from a last linear fit."""
    left = _stack(root * _with_line(_fractions(s, poles), s))
    x = _scaled_lstsq(left, _stack(root * values.T))
    residue = np.linalg.norm(x[0 : 2 * poles.size : 2] + 1j * x[1 : 2 * poles.size : 2], axis=1)
    at = np.asarray(1j * poles.imag)
    curve = np.linalg.norm(_with_line(_fractions(at, poles), at) @ x, axis=1)
    return share_of_curve(residue, poles.real, curve)
