r"""Orthogonal polynomials on the imaginary axis, and the roots of their sums.

With x = f / f_max on the symmetric set of lines -x_n and x_n, weighted by w_n^2, the Forsythe polynomials
p_k have the parity of k and obey

    x p_k = b_{k+1} p_{k+1} + b_k p_{k-1},     sum_n w_n^2 p_i p_k = delta_ik  (over the half plane)

so that phi_k(s) = i^k p_k(x), s = i x, is a polynomial in s with real coefficients. Half the lines serve,
and no complex coefficient ever appears. A sum of phi_k has its roots at the eigenvalues of a comrade
matrix made of the b_k; power coefficients, whose condition passes 1e13 at order 40, are never formed.

References: G. E. Forsythe, J. SIAM 5 (1957) 74-88; M. H. Richardson and D. L. Formenti, Proc. IMAC 1
(1982) 167-181; S. Barnett, Linear Algebra Appl. 12 (1975) 165-178 (comrade matrix).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .. import _core
from ..support.checks import ComplexArray, FloatArray

# A top coefficient this far below the largest carries rounding only; its root would be at infinity.
TOP_COEFFICIENT = 1e-13


@dataclass(frozen=True)
class Basis:
    """Forsythe polynomials: recurrence and values on the lines.

    ``b[0]`` is the norm of the constant, ``b[k]`` couples orders k - 1 and k; ``p`` has shape
    (n_lines, order + 1).
    """

    b: FloatArray
    p: FloatArray

    @property
    def order(self) -> int:
        """Highest order."""
        return int(self.b.size) - 1

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
        v = x * p[k] - (b[k] * p[k - 1] if k else 0.0)
        b[k + 1] = np.sqrt(weight @ (v * v))
        p[k + 1] = v / b[k + 1]
    return Basis(b, np.ascontiguousarray(p.T))


def roots(coefficients: FloatArray, b: FloatArray, near: ComplexArray | None = None) -> ComplexArray:
    """All roots in s / (2 pi f_max) of sum_k coefficients[k] phi_k.

    ``near`` are roots of a polynomial much like it, as of the order before; from there all roots are refined
    at once (Ehrlich and Aberth). Where they do not all stand in the end, and without ``near``, they are
    eigenvalues.
    """
    if near is not None:
        kept = coefficients[: _order(coefficients) + 1]
        found = _core.refined_roots(kept, b[: kept.size], near)
        if found is not None:
            return found
    # s phi_k = b_{k+1} phi_{k+1} - b_k phi_{k-1}
    return comrade_roots(coefficients, b, below=-b)


def _order(coefficients: FloatArray) -> int:
    """Index of the highest coefficient that carries more than rounding."""
    size = np.abs(coefficients)
    return int(np.flatnonzero(size > TOP_COEFFICIENT * size.max(initial=0.0))[-1]) if size.any() else 0


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
