r"""Real rational functions of frequency squared, for data without phase.

The squared magnitudes y_o(f) = abs(Y_o)^2 of curves with common poles, and any sum of them, are real rational
functions of z = f^2: each pole pair s, s* of the curves becomes the pair z = -s^2 / (2 pi)^2 and its
conjugate, because D(s) D(-s) is even in s. So order n in s is degree n in z. With z mapped to t in [-1, 1],

    y_o(t) ~ N_o(t) / D(t),   sum_o sum_n w_n (N_o - y_o D)^2 -> min,

on two real Forsythe bases (numerators on w, denominator on w sum_o y_o^2), whose recurrence on the real axis
has a middle term, t p_k = b_{k+1} p_{k+1} + a_k p_k + b_k p_{k-1}. The roots of D are the eigenvalues of a
comrade matrix; one root z of each pair gives s = 2 pi i sqrt(z) in the left half plane. A root that is real,
z < 0 or z > 0, is no resonance and comes out with no frequency or no damping.

References: G. E. Forsythe, J. SIAM 5 (1957) 74-88; S. Barnett, Linear Algebra Appl. 12 (1975) 165-178.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..order_sweep.diagram import PoleSweep
from ..rational.dominance import share_of_curve
from ..rational.fit import CommonDenominator
from ..rational.forsythe import comrade_roots
from ..support.validation import ComplexArray, FloatArray

__all__ = ["PowerFit", "PowerSweep", "RealBasis", "real_basis", "real_roots"]

# Without phase a wider hump is no evidence of a pole: all that ten orders agreed on beyond it was the
# curvature of a background (5 to 9 % damping, above the last resonance of a chain whose modes have 1 %).
MAX_DAMPING = 0.05


@dataclass(frozen=True)
class RealBasis:
    """Polynomials orthonormal on points of the real axis: recurrence and values on the lines.

    ``b[0]`` is the norm of the constant, ``b[k]`` couples orders k - 1 and k, ``a[k]`` is the middle term of
    order k; ``p`` has shape (n_lines, order + 1).
    """

    a: FloatArray
    b: FloatArray
    p: FloatArray

    def at(self, t: ComplexArray, order: int) -> ComplexArray:
        """p_0 ... p_order at complex points, shape (n_points, order + 1)."""
        out = np.empty((t.size, order + 1), dtype=np.complex128)
        out[:, 0] = 1.0 / self.b[0]
        for k in range(order):
            lower = self.b[k] * out[:, k - 1] if k else 0.0
            out[:, k + 1] = ((t - self.a[k]) * out[:, k] - lower) / self.b[k + 1]
        return out


def real_basis(t: FloatArray, weight: FloatArray, order: int) -> RealBasis:
    """Three-term recurrence on the real axis; ``weight`` multiplies squared values.

    Each new polynomial is made orthogonal to all before it once more. Lines evenly spaced in f lie unevenly
    in f^2, where the recurrence alone loses orthogonality from some 2 sqrt(n_lines) on.
    """
    p = np.empty((order + 1, t.size))
    a, b = np.zeros(order), np.empty(order + 1)
    b[0] = np.sqrt(weight.sum())
    p[0] = 1.0 / b[0]
    for k in range(order):
        v = t * p[k]
        a[k] = weight @ (v * p[k])
        v -= a[k] * p[k] + (b[k] * p[k - 1] if k else 0.0)
        v -= (p[: k + 1] @ (weight * v)) @ p[: k + 1]
        b[k + 1] = np.sqrt(weight @ (v * v))
        p[k + 1] = v / b[k + 1]
    return RealBasis(a, b, np.ascontiguousarray(p.T))


def real_roots(coefficients: FloatArray, basis: RealBasis) -> ComplexArray:
    """All roots in t of sum_k coefficients[k] p_k: real, or conjugate pairs."""
    return comrade_roots(coefficients, basis.b, below=basis.b, middle=basis.a)


class PowerFit(CommonDenominator):
    """The one factorisation behind every order of real rational functions of f^2 with common poles.

    Answers what ``NestedFit`` of :mod:`~antires_rs.rational.fit` answers, so that the same sweep runs on it.
    ``power`` is (n_outputs, n_freq), not negative; ``weights``, (n_freq,), multiply squared residuals of
    ``N - power D``.
    """

    def __init__(self, freq_hz: FloatArray, power: FloatArray, weights: FloatArray, max_order: int) -> None:
        self.scale_hz = float(freq_hz[-1])
        self.max_order = max_order
        z = freq_hz**2
        self.middle, self.half = 0.5 * (z[0] + z[-1]), 0.5 * (z[-1] - z[0])
        # Scaled, so that neither basis has to carry the data's unit.
        self.values = power / np.exp(np.mean(np.log(np.maximum(power.sum(axis=0), 1e-300))))
        self.weights = weights / weights.sum()
        t = (z - self.middle) / self.half
        self.numerator_basis = real_basis(t, self.weights, max_order)
        squares = np.sum(self.values**2, axis=0)
        self.denominator_basis = real_basis(t, self.weights * squares, max_order)
        above = np.ascontiguousarray((self.numerator_basis.p * self.weights[:, None]).T)
        self.x = np.array([above @ (y[:, None] * self.denominator_basis.p) for y in self.values])

    def poles(self, coefficients: FloatArray) -> ComplexArray:
        """Roots of the denominator in rad/s: pairs in the left half plane, real roots of z as they come."""
        z = self.middle + self.half * real_roots(coefficients, self.denominator_basis)
        s = 2j * np.pi * np.sqrt(z[z.imag >= 0.0])
        s = s[-s.real <= MAX_DAMPING * np.abs(s)]
        return np.concatenate([s, s[s.imag > 0.0].conj()])

    def peak_shares(self, d: FloatArray, s: ComplexArray) -> FloatArray:
        """The poles' own peaks in z, 2 norm(residues) / Im z, over the norm of the fitted curves at Re z."""
        t = (-((s / (2 * np.pi)) ** 2) - self.middle) / self.half
        step = 1e-6 * np.maximum(np.abs(t.imag), 1e-9)
        n, n1 = t.size, d.size
        points = np.concatenate([t, t.real + 0j, t + step, t - step])
        numerators = self.numerator_basis.at(points[: 2 * n], n1 - 1) @ (self.x[:, :n1, :n1] @ d).T
        above = np.linalg.norm(numerators, axis=1)
        below = self.denominator_basis.at(points, n1 - 1) @ d
        slope = np.abs(below[2 * n : 3 * n] - below[3 * n :]) / (2 * step)
        residue = above[:n] / np.maximum(slope, 1e-300)
        curve = above[n:] / np.maximum(np.abs(below[n : 2 * n]), 1e-300)
        return share_of_curve(2.0 * residue, t.imag, curve)


class PowerSweep(PoleSweep):
    """Roots of the denominator in f^2, order by order, as poles in the left half plane."""

    def __init__(self, fit: PowerFit) -> None:
        super().__init__(fit)  # type: ignore[arg-type]  # PowerFit answers what the sweep asks of NestedFit
        self.fit = fit

    def curves(self, order: int) -> tuple[ComplexArray, ComplexArray]:
        """Data and fit on the lines, (n_outputs, n_freq) each; squared magnitudes, scaled."""
        d = self._solution(order, False)
        above = self.fit.numerator_basis.p[:, : order + 1] @ (self.fit.x[:, : order + 1, : order + 1] @ d).T
        below = self.fit.denominator_basis.p[:, : order + 1] @ d
        return self.fit.values + 0j, np.asarray(above.T / below + 0j)

    def _share(self, order: int, s: ComplexArray) -> FloatArray:
        """Of each root's own peak in the fitted power at its frequency."""
        return self.fit.peak_shares(self._solution(order, False), s)
