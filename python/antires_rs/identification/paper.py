r"""Sweeps for the antiresonances of one dof: all its transmissibilities, or the curve that the paper fits.

All T_pj = X_p / X_j have the poles sought. "joint" fits all T_pj with one denominator (complex, in s); "eq10"
the absolute value of Eq. 10, Y = sum_p abs(Re T_pj) + i sum_p abs(Im T_pj), and "eq10_squared"
(``preset="paper"``) its square, both real and in f^2. Near an antiresonance all T_pj are one resonance with
real factors, so that abs(Y)^2 is there that resonance's power, a rational function of f^2; abs(Y) is its
root, with branch points where the square has poles. Away from it both have a kink wherever a part changes
sign, which takes orders: they find less than the joint fit, and their errors are larger
(``benchmarks/paper_identification.py``).

Lines of "joint" are weighted by SNR / (1 + SNR / 1e4) / (1 + sum_p abs(T_pj)^2), over abs(D)^2 of a
denominator guessed at order 4: without the guess it finds 26.0 of 28 at 5 % noise, with it 27.6. Only
averaged records get it; the errors of given curves and single impacts are not white, and would be followed
where the response is weak. abs(Y)^2 is weighted by (1 + abs(Y)^2)^-1/2, and its root alike; this and the
orders were chosen on random chains and one with a spring to ground (reference/structures.py, seeds 100-104).

Source: V. Meruane, J. Sound Vib. 332 (2013) 807-820 (Eq. 10 and the sum).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..support.checks import ComplexArray, FloatArray
from .lines import Lines
from .options import OF_MAGNITUDES, FitOptions
from .rational_fit import CommonDenominator, NestedFit, comrade_roots, guessed_weights
from .stabilization import PoleSweep

# -- Real rational functions of frequency squared, for data without phase
#
# Squared magnitudes y(f) are real rational functions of z = f^2: each pole pair s, s* becomes the pair
# z = -s^2 / (2 pi)^2 and its conjugate, because D(s) D(-s) is even in s; order n in s is degree n in z. With
# z mapped to t in [-1, 1], sum_n w_n (N - y D)^2 is least on two real Forsythe bases (numerators on w,
# denominator on w y^2), whose recurrence has a middle term: t p_k = b_{k+1} p_{k+1} + a_k p_k + b_k p_{k-1}.
# The roots of D are the eigenvalues of a comrade matrix; a real one is no resonance and comes out with no
# frequency or no damping.
#
# References: G. E. Forsythe, J. SIAM 5 (1957) 74-88; S. Barnett, Linear Algebra Appl. 12 (1975) 165-178.

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


class PowerFit(CommonDenominator):
    """Real rational functions of f^2 for one curve, factored once for every order."""

    def __init__(self, freq_hz: FloatArray, power: FloatArray, weights: FloatArray, max_order: int) -> None:
        self.scale_hz = float(freq_hz[-1])
        z = freq_hz**2
        self.middle, self.half = 0.5 * (z[0] + z[-1]), 0.5 * (z[-1] - z[0])
        # Scaled, so that neither basis has to carry the data's unit.
        y = power / np.exp(np.mean(np.log(np.maximum(power, 1e-300))))
        self.values = y[None, :]
        weights = weights / weights.sum()
        t = (z - self.middle) / self.half
        self.numerator_basis = real_basis(t, weights, max_order)
        self.denominator_basis = real_basis(t, weights * y**2, max_order)
        above = np.ascontiguousarray((self.numerator_basis.p * weights[:, None]).T)
        self.x = (above @ (y[:, None] * self.denominator_basis.p))[None]

    def poles(self, coefficients: FloatArray) -> ComplexArray:
        """Roots of the denominator in rad/s: pairs in the left half plane, real roots of z as they come."""
        basis = self.denominator_basis
        t = comrade_roots(coefficients, basis.b, below=basis.b, middle=basis.a)
        z = self.middle + self.half * t
        s = 2j * np.pi * np.sqrt(z[z.imag >= 0.0])
        s = s[-s.real <= MAX_DAMPING * np.abs(s)]
        return np.concatenate([s, s[s.imag > 0.0].conj()])

    def peak_shares(self, d: FloatArray, s: ComplexArray) -> FloatArray:
        """The poles' own peaks in z, 2 abs(residue) / Im z, over the fitted curve at Re z."""
        t = (-((s / (2 * np.pi)) ** 2) - self.middle) / self.half
        step = 1e-6 * np.maximum(np.abs(t.imag), 1e-9)
        n = t.size
        points = np.concatenate([t, t.real + 0j, t + step, t - step])
        above = np.abs(self.numerator_basis.at(points[: 2 * n], d.size - 1) @ self.numerators(d)[0])
        below = self.denominator_basis.at(points, d.size - 1) @ d
        slope = np.abs(below[2 * n : 3 * n] - below[3 * n :]) / (2 * step)
        residue = above[:n] / np.maximum(slope, 1e-300)
        curve = above[n:] / np.maximum(np.abs(below[n : 2 * n]), 1e-300)
        return np.asarray(2.0 * residue / np.maximum(np.abs(t.imag) * curve, 1e-300))


class PowerSweep(PoleSweep):
    """Roots of the denominator in f^2, order by order, as poles in the left half plane."""

    nested: PowerFit  # type: ignore[assignment]  # it answers what the sweep asks of NestedFit

    def curves(self, order: int) -> tuple[ComplexArray, ComplexArray]:
        """Data and fit on the lines, (1, n_freq) each; squared magnitudes, scaled."""
        d = self._solution(order, False)
        above = self.nested.numerator_basis.p[:, : order + 1] @ self.nested.numerators(d).T
        below = self.nested.denominator_basis.p[:, : order + 1] @ d
        return self.nested.values + 0j, np.asarray(above.T / below + 0j)

    def _share(self, order: int, s: ComplexArray) -> FloatArray:
        """Of each root's own peak in the fitted power at its frequency."""
        return self.nested.peak_shares(self._solution(order, False), s)


# Order of the denominator guessed for the weights: the trend over the band, from which every order gains.
# Higher ones find more near the noise, and false ones with them.
GUESS_ORDER = 4
# Exponents of the absolute value of Eq. 10, and of 1 + its square in the weights: residuals of either are
# then weighed alike, since d(y^2) = 2 y dy.
_EQ10 = {"eq10": (1, 0.5), "eq10_squared": (2, -0.5)}


def sweep_of(
    lines: Lines, row: int, min_order: int, max_order: int, rule: FitOptions, formulation: str = "joint"
) -> tuple[PoleSweep, range, FloatArray]:
    """Sweep whose poles are the antiresonances of one row."""
    per_line = 1 if formulation in OF_MAGNITUDES else 2
    orders = rule.orders((min_order, max_order), lines.freq_hz.size, per_line=per_line)
    quotients, power = lines.quotients(row)
    if formulation in _EQ10:
        size = np.hypot(np.abs(quotients.real).sum(axis=0), np.abs(quotients.imag).sum(axis=0))
        exponent, weighted = _EQ10[formulation]
        power_fit = PowerFit(lines.freq_hz, size**exponent, (1.0 + size**2) ** weighted, orders[-1])
        return PowerSweep(power_fit), orders, size  # type: ignore[arg-type]
    guess = guessed_weights(lines.freq_hz, power, GUESS_ORDER if lines.segments is not None else 0)
    nested = NestedFit(lines.freq_hz, quotients, lines.capped_snr * guess / (1.0 + power), orders[-1])
    return PoleSweep(nested), orders, np.abs(quotients.sum(axis=0))
