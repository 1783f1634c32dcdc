r"""Which function of the transmissibilities is fitted.

For the antiresonances of dof j all T_pj = X_p / X_j have the poles sought. They can be fitted as

==============  ==========================================================================================
"joint"         all T_pj, one denominator (complex, in s)
"power"         all abs(T_pj)^2, one denominator (real, in f^2; no phase),
                :mod:`~antires_rs.identification.paper`
"eq10"          abs(Y) of Eq. 10, Y = sum_p abs(Re T_pj) + i sum_p abs(Im T_pj) (real, in f^2)
"eq10_squared"  abs(Y)^2 (real, in f^2); what ``preset="paper"`` takes
==============  ==========================================================================================

Measured on chain8 (28 antiresonances; 1 % damping, 200 s at 512 Hz, five seeds; found within 1 %, mean of the
runs / false values a run / largest relative error / median error), the last two by the paper's rule with
orders to 70:

==============  ==========================  ==========================  ==========================
formulation     no noise                    1 % noise                   5 % noise
==============  ==========================  ==========================  ==========================
"joint"         28.0 / 0.0 / 4e-05 / 5e-06  28.0 / 0.0 / 1e-03 / 1e-05  27.6 / 0.0 / 5e-03 / 5e-05
"power"         28.0 / 0.2 / 6e-05 / 7e-06  28.0 / 0.0 / 2e-03 / 2e-05  26.0 / 0.0 / 7e-03 / 9e-05
"eq10"          17.8 / 0.2 / 3e-03 / 1e-03  27.0 / 0.2 / 4e-03 / 7e-04  22.6 / 0.8 / 1e-02 / 1e-03
"eq10_squared"  27.0 / 0.2 / 1e-03 / 2e-04  27.4 / 0.6 / 4e-03 / 3e-04  24.6 / 1.0 / 6e-03 / 6e-04
==============  ==========================  ==========================  ==========================

So "joint" is the default of the four. "power" needs no phase; what it gives up is the test that spurious
poles fail in s, where they go to the right half plane.

The last two are what the paper fits: the absolute value of one curve. Near an antiresonance all T_pj are one
resonance with real factors, so that abs(Y)^2 is there that resonance's power, a rational function of f^2;
abs(Y) is its root, with branch points where the square has poles. Away from it both have a kink wherever a
part changes sign, sharp ones on curves without noise, which take orders: these two find less there than the
joint fit, and their errors are larger.

Lines of "joint" and "power" are weighted by SNR / (1 + SNR / 1e4) / (1 + sum_p abs(T_pj)^2), over abs(D)^2 of
a denominator guessed at order 4 (module ``first_guess``): without the guess "joint" finds 26.0 at 5 % noise,
"power" 24.6. Only averaged records get it; the errors of given curves and single impacts are not white, and
where the response is weak they would be followed. Those of Eq. 10 are weighted by (1 + abs(Y)^2)^-1/2 for the
square, and alike for the root; this and their orders were chosen on random chains and one with a spring
to ground (reference/structures.py, seeds 100 to 104).

Source: V. Meruane, J. Sound Vib. 332 (2013) 807-820 (Eq. 10 and the sum).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..support.checks import ComplexArray, FloatArray, choice
from .lines import Lines
from .options import FORMULATIONS, OF_MAGNITUDES, FitOptions
from .rational_fit import CommonDenominator, NestedFit, comrade_roots, guessed_weights, share_of_curve
from .stabilization import PoleSweep

# -- Real rational functions of frequency squared, for data without phase
#
# The squared magnitudes y_o(f) = abs(Y_o)^2 of curves with common poles, and any sum of them, are real
# rational functions of z = f^2: each pole pair s, s* of the curves becomes the pair z = -s^2 / (2 pi)^2 and
# its conjugate, because D(s) D(-s) is even in s. So order n in s is degree n in z. With z mapped to t in
# [-1, 1],
#
#     y_o(t) ~ N_o(t) / D(t),   sum_o sum_n w_n (N_o - y_o D)^2 -> min,
#
# on two real Forsythe bases (numerators on w, denominator on w sum_o y_o^2), whose recurrence on the real
# axis has a middle term, t p_k = b_{k+1} p_{k+1} + a_k p_k + b_k p_{k-1}. The roots of D are the
# eigenvalues of a comrade matrix; one root z of each pair gives s = 2 pi i sqrt(z) in the left half plane.
# A root that is real, z < 0 or z > 0, is no resonance and comes out with no frequency or no damping.
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


def real_roots(coefficients: FloatArray, basis: RealBasis) -> ComplexArray:
    """All roots in t of sum_k coefficients[k] p_k: real, or conjugate pairs."""
    return comrade_roots(coefficients, basis.b, below=basis.b, middle=basis.a)


class PowerFit(CommonDenominator):
    """The one factorisation behind every order of real rational functions of f^2 with common poles.

    Answers what ``NestedFit`` of ``rational_fit`` answers, so that the same sweep runs on it.
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


# Order of the denominator guessed for the weights: the trend over the band, from which every order gains.
# Higher ones find more near the noise, and false ones with them.
GUESS_ORDER = 4
#: Exponents of the absolute value of Eq. 10, and of 1 + its square in the weights: residuals of
#: either are then weighed alike, since d(y^2) = 2 y dy.
_EQ10 = {"eq10": (1, 0.5), "eq10_squared": (2, -0.5)}


def sweep_of(
    lines: Lines, row: int, min_order: int, max_order: int, rule: FitOptions, formulation: str = "joint"
) -> tuple[PoleSweep, range, FloatArray]:
    """Sweep whose poles are the antiresonances of one row."""
    choice("formulation", formulation, FORMULATIONS)
    per_line = 1 if formulation in OF_MAGNITUDES else 2
    orders = rule.orders((min_order, max_order), lines.freq_hz.size, per_line=per_line)
    quotients, power = lines.quotients(row)
    if formulation in _EQ10:
        size = np.hypot(np.abs(quotients.real).sum(axis=0), np.abs(quotients.imag).sum(axis=0))
        exponent, weighted = _EQ10[formulation]
        fit = PowerFit(lines.freq_hz, size[None, :] ** exponent, (1.0 + size**2) ** weighted, orders[-1])
        return PowerSweep(fit), orders, size
    weights = lines.capped_snr
    guess = guessed_weights(lines.freq_hz, power, GUESS_ORDER if lines.segments is not None else 0)
    if formulation == "power":
        # The denominator in f^2 is the square of that in s.
        squares = quotients.real**2 + quotients.imag**2
        fit = PowerFit(lines.freq_hz, squares, weights * guess**2 / (1.0 + power), orders[-1])
        return PowerSweep(fit), orders, power
    nested = NestedFit(lines.freq_hz, quotients, weights * guess / (1.0 + power), orders[-1])
    return PoleSweep(nested), orders, np.abs(quotients.sum(axis=0))
