r"""Rational fraction polynomials with a common denominator, fitted in orthogonal bases.

Model: Y_o(s) = N_o(s) / D(s) for every output o, numerators and denominator of one order, real
coefficients in s. The residual w_n (N_o - Y_o D) is linear in the coefficients. With the numerators on a
Forsythe basis for w^2 and the denominator on one for w^2 sum_o abs(Y_o)^2, all numerators are eliminated
at no cost and the denominator minimises d' G d, G = I - sum_o X_o' X_o (Richardson & Formenti 1982); leading
blocks of X_o serve every lower order. d = 0 is excluded in one of two ways: "low" sets the lowest coefficient
to one, and spurious poles go to the right half plane, where they are told from physical ones; "norm" takes
the eigenvector of the smallest eigenvalue of G, more accurate where it finds a pole. A monic denominator
would be wrong: a transmissibility can have a numerator of higher order than its denominator.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .. import _core
from ..exceptions import NumericalError, reject
from ..signals.frequency_response import check_freq
from ..support.checks import ComplexArray, FloatArray, complex_rows, frequency_band, integer, real_array

# -- Orthogonal polynomials on the imaginary axis, and the roots of their sums
#
# With x = f / f_max on the lines -x_n and x_n, weighted by w_n^2, the Forsythe polynomials p_k have the
# parity of k and obey x p_k = b_{k+1} p_{k+1} + b_k p_{k-1}, so that phi_k(s) = i^k p_k(x), s = i x, is a
# polynomial in s with real coefficients; half the lines serve. A sum of phi_k has its roots at the
# eigenvalues of a comrade matrix made of the b_k; power coefficients, whose condition passes 1e13 at order
# 40, are never formed.
#
# References: G. E. Forsythe, J. SIAM 5 (1957) 74-88; M. H. Richardson and D. L. Formenti, Proc. IMAC 1
# (1982) 167-181; S. Barnett, Linear Algebra Appl. 12 (1975) 165-178 (comrade matrix).

# A top coefficient this far below the largest carries rounding only; its root would be at infinity.
TOP_COEFFICIENT = 1e-13


@dataclass(frozen=True)
class Basis:
    """Forsythe polynomials: recurrence and values on the lines.

    ``b[0]`` is the norm of the constant, ``b[k]`` couples orders k - 1 and k; ``p`` is (n_lines, order + 1).
    """

    b: FloatArray
    p: FloatArray

    def at(self, s: ComplexArray, order: int) -> ComplexArray:
        """phi_0 ... phi_order at complex points s (in units of 2 pi f_max), shape (n_points, order + 1)."""
        return _core.forsythe_basis_at(np.asarray(s, dtype=np.complex128), self.b[: order + 1])


def forsythe_basis(x: FloatArray, weight: FloatArray, order: int) -> Basis:
    """Three-term recurrence on the half plane; ``weight`` multiplies squared values."""
    p = np.empty((order + 1, x.size))
    b = np.empty(order + 1)
    b[0] = np.sqrt(weight.sum())
    p[0] = 1.0 / b[0]
    for k in range(order):
        v = np.multiply(x, p[k], out=p[k + 1])
        if k:
            v -= b[k] * p[k - 1]
        b[k + 1] = np.sqrt(weight @ (v * v))
        v /= b[k + 1]
    return Basis(b, np.ascontiguousarray(p.T))


def roots(coefficients: FloatArray, b: FloatArray, near: ComplexArray | None = None) -> ComplexArray:
    """All roots in s / (2 pi f_max) of sum_k coefficients[k] phi_k.

    Eigenvalues, unless ``near`` are roots of a polynomial much like it, from which all can be refined at once
    (Ehrlich and Aberth).
    """
    if near is not None:
        kept = coefficients[: _order(coefficients) + 1]
        found = _core.refined_roots(kept, b[: kept.size], near)
        if found is not None:
            return found
    return comrade_roots(coefficients, b, below=-b)  # s phi_k = b_{k+1} phi_{k+1} - b_k phi_{k-1}


def _order(coefficients: FloatArray) -> int:
    """Index of the highest coefficient that carries more than rounding."""
    size = np.abs(coefficients)
    least = TOP_COEFFICIENT * size.max(initial=0.0)
    if size.size and size[-1] > least:
        return size.size - 1
    return int(np.flatnonzero(size > least)[-1]) if size.any() else 0


def comrade_roots(
    coefficients: FloatArray, b: FloatArray, *, below: FloatArray, middle: FloatArray | None = None
) -> ComplexArray:
    """All roots in x of sum_k coefficients[k] p_k, top coefficients that carry rounding only left out.

    The recurrence is x p_k = b_{k+1} p_{k+1} + middle_k p_k + below_k p_{k-1}.
    """
    order = _order(coefficients)
    if order == 0:
        return np.empty(0, dtype=np.complex128)
    comrade = np.diag(b[1:order], 1) + np.diag(below[1:order], -1)
    if middle is not None:
        comrade += np.diag(middle[:order])
    # At a root p_order follows from the lower ones.
    comrade[-1] -= b[order] * coefficients[:order] / coefficients[order]
    return np.asarray(np.linalg.eigvals(comrade), dtype=np.complex128)


# -- Where to start a rational fit: weights from a denominator guessed by eye
#
# The linear residual N - Y D carries the weight abs(D)^2 of a denominator that is not known yet. At high
# order it spans tens of decades, and the first fit is lost in rounding. Poles a third off bring 1e60 down to
# a few decades: so half as many pole pairs as the order are laid where the curve moves, at equal steps of
# the integral of abs(d log P / d f), P the power of all curves, each as wide as its distance from the next.

EVEN = 0.25  # share of the poles that is laid evenly, wherever the curve moves
MOST_EXPONENT = 300.0  # exponents beyond this would leave the range of floating point


def guessed_weights(freq_hz: FloatArray, power: FloatArray, order: int) -> FloatArray:
    """1 / abs(D)^2 of a guessed denominator of even order up to ``order``, one in the geometric mean."""
    if order < 2:
        return np.ones(freq_hz.size)
    count = order // 2
    moved = np.abs(np.diff(np.log(np.maximum(power, 1e-30 * power.max()))))
    share = np.diff(freq_hz) / (freq_hz[-1] - freq_hz[0])
    total = moved.sum()
    if total > 0.0:
        share = EVEN * share + (1.0 - EVEN) * moved / total
    climbed = np.concatenate([[0.0], np.cumsum(share)])
    hz = np.interp((np.arange(count) + 0.5) / count, climbed / climbed[-1], freq_hz)
    width = np.gradient(hz) if count > 1 else hz
    poles = 2 * np.pi * (-0.5 * width + 1j * hz)
    s = 2j * np.pi * freq_hz[:, None]
    exponent = -2.0 * (np.log(np.abs(s - poles)) + np.log(np.abs(s - poles.conj()))).sum(axis=1)
    exponent -= exponent.mean()
    return np.asarray(np.exp(np.clip(exponent, -MOST_EXPONENT, MOST_EXPONENT)), dtype=np.float64)


@dataclass(frozen=True)
class RootSet:
    """Roots of a polynomial in s, one of each conjugate pair, by ascending frequency.

    Attributes
    ----------
    s : (n,) complex
        rad/s, imaginary part not negative.
    freq_hz, damping_ratio : (n,)
        ``abs(s) / (2 pi)``; ``-Re(s) / abs(s)``, negative in the right half plane, +-1 for a real root.
    """

    s: ComplexArray
    freq_hz: FloatArray = field(init=False)
    damping_ratio: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        s = self.s[self.s.imag >= 0.0]
        s = s[np.argsort(np.abs(s), kind="stable")]
        size = np.abs(s)
        damping = np.divide(-s.real, size, out=np.zeros(s.size), where=size > 0)
        for name, value in (("s", s), ("freq_hz", size / (2 * np.pi)), ("damping_ratio", damping)):
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return int(self.s.size)


class CommonDenominator:
    """What fits of every order share once the numerators are eliminated.

    ``x``, (n_outputs, max_order + 1, max_order + 1), couples the bases of numerators and denominator.
    """

    x: FloatArray

    def numerators(self, coefficients: FloatArray) -> FloatArray:
        """Coefficients of every numerator, (n_outputs, order + 1)."""
        n1 = coefficients.size
        return self.x[:, :n1, :n1] @ coefficients

    def gram(self, order: int) -> FloatArray:
        """G of one order: the denominator minimises d' G d."""
        block = self.x[:, : order + 1, : order + 1].reshape(-1, order + 1)
        return np.eye(order + 1) - block.T @ block

    def denominator(self, gram: FloatArray) -> FloatArray:
        """Coefficients under the constraint "low"."""
        try:
            rest = np.linalg.solve(gram[1:, 1:], -gram[1:, 0])
        except np.linalg.LinAlgError:
            rest = np.linalg.lstsq(gram[1:, 1:], -gram[1:, 0], rcond=None)[0]
        return np.concatenate([[1.0], rest])


class NestedFit(CommonDenominator):
    """The one factorisation behind every order up to ``max_order``; ``weights`` (n_freq,) are of squares."""

    def __init__(
        self, freq_hz: FloatArray, values: ComplexArray, weights: FloatArray, max_order: int
    ) -> None:
        self.scale_hz = float(freq_hz[-1])
        self.values = values
        self.weights = weights / weights.sum()
        self.max_order = max_order
        x = freq_hz / self.scale_hz
        power = np.sum(values.real**2 + values.imag**2, axis=0)
        self.numerator_basis = forsythe_basis(x, self.weights, max_order)
        self.denominator_basis = forsythe_basis(x, self.weights * power, max_order)
        self.x = self._couplings()

    def _couplings(self) -> FloatArray:
        """X_o[a, b] = Re sum_n w^2 conj(phi_a) Y_o psi_b, shape (n_outputs, order + 1, order + 1)."""
        m, n1 = self.values.shape[0], self.max_order + 1
        x = np.empty((m, n1, n1))
        # i^(b-a): equal parities see the real part of Y only, unequal ones the imaginary part only.
        for odd_a in (0, 1):
            left = np.ascontiguousarray((self.numerator_basis.p[:, odd_a::2] * self.weights[:, None]).T)
            for odd_b in (0, 1):
                right = self.denominator_basis.p[:, odd_b::2]
                part = self.values.real if odd_a == odd_b else self.values.imag
                for o in range(m):
                    x[o, odd_a::2, odd_b::2] = left @ (part[o][:, None] * right)
        index = np.arange(n1)
        # Re(i^m) z for even m, Re(i^m i) z for odd m.
        sign = np.array([1.0, -1.0, -1.0, 1.0])[(index[None, :] - index[:, None]) % 4]
        return np.asarray(x * sign, dtype=np.float64)

    def poles(self, coefficients: FloatArray) -> ComplexArray:
        """Roots of the denominator in rad/s."""
        return roots(coefficients, self.denominator_basis.b) * (2 * np.pi * self.scale_hz)

    def zeros(self, coefficients: FloatArray, output: int) -> ComplexArray:
        """Roots of one numerator in rad/s."""
        return roots(self.numerators(coefficients)[output], self.numerator_basis.b) * (
            2 * np.pi * self.scale_hz
        )

    def low_and_norm(self, order: int) -> FloatArray:
        """Both solutions of one order, (2, order + 1), by QR: normal equations would leave 1e-8."""
        n1 = order + 1
        root_w = np.sqrt(self.weights)[:, None]
        k = 1j ** np.arange(n1)
        phi = root_w * self.numerator_basis.p[:, :n1] * k
        psi = root_w * self.denominator_basis.p[:, :n1] * k
        rows = []
        for value, x in zip(self.values, self.x, strict=True):
            rest = value[:, None] * psi - phi @ x[:n1, :n1]
            rows += [rest.real, rest.imag]
        r = np.asarray(np.linalg.qr(np.concatenate(rows), mode="r"))
        low = np.linalg.lstsq(r[:, 1:], -r[:, 0], rcond=None)[0]
        return np.stack([np.concatenate([[1.0], low]), np.linalg.svd(r)[2][-1]])


@dataclass(frozen=True, repr=False)
class RationalFit:
    """A fitted rational function, one denominator for all outputs.

    Attributes
    ----------
    order : int
        Order of numerators and denominator.
    poles : RootSet
        Roots of the denominator.
    zeros : RootSet or tuple of RootSet
        Roots of the numerator; one set an output when the values were two-dimensional.
    residual : float
        Weighted rms of ``fit - values`` over the weighted rms of ``values``.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> f = np.linspace(1.0, 20.0, 400)
    >>> fit = ar.fit_rational(f, 1.0 / (10.0**2 - f**2 + 0.4j * f), 2)
    >>> fit.poles.freq_hz.round(6), abs(fit.evaluate([10.0])).round(6)
    (array([10.]), array([0.25]))
    """

    order: int
    poles: RootSet
    zeros: RootSet | tuple[RootSet, ...]
    residual: float
    _bases: tuple[Basis, Basis]
    _coefficients: tuple[FloatArray, FloatArray]
    _scale_hz: float
    _single: bool

    def evaluate(self, freq_hz: Any) -> ComplexArray:
        """Value of the fit at other frequencies.

        Parameters
        ----------
        freq_hz : array_like, (n,)

        Returns
        -------
        (n,) complex, or (n_outputs, n) where the fitted values had two dimensions.
        """
        freq = real_array("freq_hz", freq_hz, ndim=1, wanted="a real array (n,) in Hz")
        s = np.asarray(1j * freq / self._scale_hz, dtype=np.complex128)
        numerators, denominator = self._coefficients
        below = self._bases[1].at(s, self.order) @ denominator
        values = np.asarray((self._bases[0].at(s, self.order) @ numerators.T).T / below, dtype=np.complex128)
        return values[0] if self._single else values

    def __repr__(self) -> str:
        n_outputs = self._coefficients[0].shape[0]
        return (
            f"RationalFit(order {self.order}, {n_outputs} output{'s' if n_outputs > 1 else ''}, "
            f"{len(self.poles)} poles, relative residual {self.residual:.2g})"
        )


def prepare(
    freq_hz: Any, values: Any, order: int, band_hz: Any, weights: Any, order_name: str
) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Checked lines in the band: frequencies, values (n_outputs, n), weights of squared residuals."""
    freq = check_freq("freq_hz", freq_hz)
    wanted = f"a complex array ({freq.size},) or (n_outputs, {freq.size}), one column a frequency"
    array = complex_rows("values", values, freq.size, wanted=wanted)
    low, high = frequency_band(
        "band_hz",
        (freq[0], freq[-1]) if band_hz is None else band_hz,
        low_hz=float(freq[0]),
        high_hz=float(freq[-1]),
    )
    inside = (freq >= low) & (freq <= high)
    power = np.sum(np.abs(array) ** 2, axis=0)
    if not power[inside].any():
        got = "zeros only inside the band"
        reject("values", got, "at least one value that is not zero", "Check the channel, or the band.")
    if weights is None:
        # A line's weight falls where a transmissibility peaks: there its own reference is mostly noise.
        weight = 1.0 / (np.median(power[inside]) + power)
    else:
        wanted = f"a real array ({freq.size},) of positive weights, one a line"
        weight = real_array("weights", weights, ndim=1, wanted=wanted)
        if weight.size != freq.size or weight.min() < 0.0 or not weight[inside].any():
            got = f"an array of shape {weight.shape} from {weight.min():g} to {weight.max():g}"
            reject("weights", got, wanted, "Leave them out to count all lines alike.")
    n_lines = int(inside.sum())
    if n_lines <= order:
        got = f"{order} with {n_lines} lines in band_hz = ({low:g}, {high:g})"
        wanted = "fewer orders than lines"
        reject(order_name, got, wanted, "Widen the band, use longer segments, or lower the order.")
    return freq[inside], array[:, inside], weight[inside]


def fit_rational(
    freq_hz: Any,
    values: Any,
    order: int,
    *,
    band_hz: Sequence[float] | None = None,
    weights: Any | None = None,
    constraint: str = "low",
    reweightings: int = 2,
) -> RationalFit:
    """Fit rational functions with a common denominator to complex frequency data.

    Parameters
    ----------
    freq_hz : array_like, (n_freq,)
        Ascending, Hz.
    values : array_like, (n_freq,) or (n_outputs, n_freq)
        Complex data, e.g. FRFs or transmissibilities.
    order : int
        Order in s of numerators and denominator, at least 1; two for each resonance.
    band_hz : (low, high), optional
        Only lines inside are used. Default: all.
    weights : array_like, (n_freq,), optional
        Weights of squared residuals. Default ``1 / (median(P) + P)``, P the sum of ``abs(values)**2``.
    constraint : {"low", "norm"}
        What excludes the zero solution: lowest Forsythe coefficient of the denominator one, or unit norm.
    reweightings : int
        Repetitions with the weights over ``abs(D)**2`` of the fit before (C. K. Sanathanan and J. Koerner,
        IEEE Trans. Autom. Control 8 (1963) 56-58), so that the residual becomes that of the curve itself. One
        is enough for exact data: it takes the error of the poles at order 50 from 1e-2 to 1e-14.

    Returns
    -------
    RationalFit

    Raises
    ------
    InvalidInputError
        Wrong shapes, NaN, band outside the data, or no more lines than the order.
    NumericalError
        The data leave the fit undefined.

    Examples
    --------
    >>> import numpy as np, antires_rs as ar
    >>> f = np.linspace(1.0, 20.0, 400)
    >>> h = (7.0**2 - f**2 + 2j * 0.01 * 7.0 * f) / (10.0**2 - f**2 + 2j * 0.02 * 10.0 * f)
    >>> fit = ar.fit_rational(f, h, 2)
    >>> print(fit.poles.freq_hz.round(6), fit.poles.damping_ratio.round(6), fit.zeros.freq_hz.round(6))
    [10.] [0.02] [7.]
    """
    order = integer("order", order, low=1)
    if constraint not in ("low", "norm"):
        reject("constraint", constraint, "'low' or 'norm'", "Leave it out for 'low'.")
    single = np.ndim(values) == 1
    freq, array, weight = prepare(freq_hz, values, order, band_hz, weights, "order")
    first, fits = weight, []
    weight = first * guessed_weights(freq, np.sum(np.abs(array) ** 2, axis=0), order)
    for _ in range(integer("reweightings", reweightings, low=0) + 1):
        nested = NestedFit(freq, array, weight, order)
        try:
            d = nested.low_and_norm(order)[0 if constraint == "low" else 1]
        except np.linalg.LinAlgError as exc:
            raise NumericalError(
                f"the least-squares problem of order {order}",
                f"no convergence ({exc}); lower the order or narrow the band",
            ) from exc
        fits.append(_fit_of(nested, freq, d, first, single))
        terms = nested.denominator_basis.p * d
        # A line on a pole must not get all the weight there is: less than this is rounding.
        below = np.maximum(np.abs(terms @ 1j ** np.arange(order + 1)), 1e-15 * np.abs(terms).sum(axis=1))
        weight = first / below**2
    # Reweighting need not converge: where the last fit is much worse than an earlier one, that one counts.
    best = min(fits, key=lambda fit: fit.residual)
    return fits[-1] if fits[-1].residual <= 2.0 * best.residual else best


def _fit_of(
    nested: NestedFit, freq_hz: FloatArray, d: FloatArray, weight: FloatArray, single: bool
) -> RationalFit:
    """The fit with denominator coefficients ``d``, its residual taken with the user's own weight."""
    zeros = tuple(RootSet(nested.zeros(d, o)) for o in range(nested.values.shape[0]))
    bases = (nested.numerator_basis, nested.denominator_basis)
    coefficients = (nested.numerators(d), d)
    fit = RationalFit(
        len(d) - 1,
        RootSet(nested.poles(d)),
        zeros[0] if single else zeros,
        0.0,
        bases,
        coefficients,
        nested.scale_hz,
        single,
    )
    difference = np.atleast_2d(fit.evaluate(freq_hz)) - nested.values
    rms = np.sqrt((weight * np.abs(difference) ** 2).sum() / (weight * np.abs(nested.values) ** 2).sum())
    return replace(fit, residual=float(rms))


# -- How much of a rational curve one of its poles owns


def dominance(
    above: tuple[Basis, FloatArray], below: tuple[Basis, FloatArray], s: ComplexArray
) -> FloatArray:
    """Norm of residues / abs(Re s), over the norm of above/below at i Im s.

    ``above`` are coefficients of one or more numerators, (n_outputs, order + 1), ``below`` those of the
    denominator, (order + 1,), or both for each root; ``s`` are roots of the latter in units of 2 pi f_max.
    """
    order = below[1].shape[-1] - 1
    step = 1e-6 * np.abs(s)  # central difference: error 1e-12 of a derivative that needs two digits
    points = np.stack([s + step, s - step, s, 1j * s.imag], axis=1)
    phi = below[0].at(points.ravel(), order).reshape(*points.shape, order + 1)
    denominator = (phi @ below[1][..., None])[..., 0]
    if above[0] is not below[0]:
        phi = above[0].at(points.ravel(), order).reshape(phi.shape)
    numerator = np.linalg.norm(phi[:, 2:] @ above[1].swapaxes(-1, -2), axis=2)
    slope = np.abs(denominator[:, 0] - denominator[:, 1]) / (2 * step)
    residue = numerator[:, 0] / np.maximum(slope, 1e-300)
    curve = numerator[:, 1] / np.maximum(np.abs(denominator[:, 3]), 1e-300)
    return np.asarray(residue / np.maximum(np.abs(s.real) * curve, 1e-300))


# -- Shapes from curves whose poles are known: least squares in the frequency domain (LSFD)
#
#     Y_o(f) = sum_r [ A_ro / (s - s_r) + conj(A_ro) / (s - conj(s_r)) ] + sum_m C_om s^m,      s = 2 pi i f
#
# The powers m = -2 ... 2 with real coefficients stand for what lies outside the band and for the quantity
# measured: s^2 / (s - s_r) of an accelerance is s + s_r plus the fraction of a receptance times s_r^2.
#
# Reference: W. Heylen, S. Lammens, P. Sas, Modal Analysis Theory and Testing, KU Leuven, 1997 (LSFD).

RESIDUAL_POWERS = (-2, -1, 0, 1, 2)


def residues(
    freq_hz: FloatArray, values: ComplexArray, weights: FloatArray, poles: ComplexArray
) -> ComplexArray:
    """Residues A of every pole in every curve."""
    s = 2j * np.pi * freq_hz
    top = np.abs(s).max()
    near, far = 1.0 / (s[:, None] - poles), 1.0 / (s[:, None] - poles.conj())
    columns = np.concatenate(
        [near + far, 1j * (near - far), np.stack([(s / top) ** m for m in RESIDUAL_POWERS], axis=1)], axis=1
    )
    root_w = np.sqrt(weights / weights.max())[:, None]
    solution = scaled_lstsq(stacked(columns * root_w), stacked(values.T * root_w))
    n = poles.size
    return np.asarray(solution[:n] + 1j * solution[n : 2 * n], dtype=np.complex128)


def stacked(z: ComplexArray) -> FloatArray:
    """Real parts over imaginary parts."""
    return np.concatenate([z.real, z.imag])


def scaled_lstsq(left: FloatArray, right: FloatArray) -> FloatArray:
    """Least squares with columns of unit norm: far residuals, light damping would decide on the rank."""
    size = np.maximum(np.linalg.norm(left, axis=0), 1e-300)
    return np.asarray(np.linalg.lstsq(left / size, right, rcond=None)[0] / size[:, None])
