"""Roots of the deleted pencil without rounding: integers for the determinant, balls of 50 digits for roots.

``det(K_ik - x M_ik)`` of the doubles as given is a polynomial with rational coefficients. Rows, columns and x
are scaled by powers of two to integers, the determinant is formed at as many whole x as it has coefficients,
and the polynomial through them is the exact one. Its roots with their multiplicities are isolated by FLINT:
real ones are known to be real.
"""

from __future__ import annotations

from dataclasses import dataclass

import flint
import mpmath
import numpy as np

#: Binary digits of the roots: more than 50 decimal ones.
PRECISION = 200

#: Distance, relative, from a root at which its vectors are formed, and the binary digits for that.
BESIDE, WIDE = 2.0**-200, 1400

#: Places, relative to the largest scaled stiffness, at which a pencil is singular if it is everywhere.
SHIFTS = np.array([-1.7, -0.3, 0.37, 1.9])
#: Ratio of stiffness to mass at which dofs are scaled.
SIZE_UNIT = 1e4


@dataclass(frozen=True)
class Root:
    """One root in x, with its multiplicity; the imaginary part of complex ones is not zero."""

    x: mpmath.mpf
    imaginary: mpmath.mpf
    multiplicity: int


class ExactRoots:
    """The roots with a positive real part of one deleted pencil, ascending; ``is_zero``: all x are roots."""

    def __init__(self, k_mat, m_mat, i, k):
        self.a, self.b = (np.delete(np.delete(matrix, i, 0), k, 1) for matrix in (k_mat, m_mat))
        self.roots, self.is_zero = [], False
        if not self.a.size:
            return
        scaled = whole_numbers(self.a, self.b)
        polynomial = None if scaled is None else determinant(*scaled[:2])
        self.is_zero = polynomial is None or polynomial == 0
        if self.is_zero:
            return
        flint.ctx.prec = PRECISION
        mpmath.mp.prec = PRECISION
        for root, multiplicity in polynomial.complex_roots():
            x, imaginary = (mpmath.ldexp(number(part), scaled[2]) for part in (root.real, root.imag))
            if x > 0:
                self.roots.append(Root(x, imaginary, multiplicity))
        self.roots.sort(key=lambda r: r.x)

    def ulp(self, root):
        """How far, relatively, one ulp of random sign in each entry of K and M moves a simple root.

        Largest row sums of the unscaled matrices are no part of it: each entry counts by its own size.
        """
        flint.ctx.prec = WIDE
        mpmath.mp.prec = WIDE
        x = root.x * (1 + mpmath.mpf(BESIDE))
        at = flint.arb(mpmath.nstr(x, int(WIDE / 3.3)))
        n = len(self.a)
        rows = [
            [exact(a) - at * exact(b) for a, b in zip(*pair, strict=True)]
            for pair in zip(self.a, self.b, strict=True)
        ]
        shifted, load = flint.arb_mat(rows), flint.arb_mat([[flint.arb(1 + j % 3)] for j in range(n)])
        right, left = (
            [number(v) for v in s.entries()] for s in (shifted.solve(load), shifted.transpose().solve(load))
        )
        mpmath.mp.prec = PRECISION
        moved, slope = mpmath.mpf(0), mpmath.mpf(0)
        for r in range(n):
            for c in range(n):
                if self.a[r, c] or self.b[r, c]:
                    size = left[r] * right[c]
                    by_k, by_m = size * mpmath.mpf(self.a[r, c]), size * root.x * mpmath.mpf(self.b[r, c])
                    moved += by_k**2 + by_m**2
                    slope += by_m
        return float(mpmath.sqrt(moved) / abs(slope) * np.finfo(float).eps) if slope else np.inf


def is_singular(k_mat, m_mat):
    """Whether K - x M is singular for every x, but for rounding: a motion without stiffness and mass."""
    size = np.sqrt(np.abs(np.diag(k_mat)) / SIZE_UNIT + np.abs(np.diag(m_mat)))
    if not size.all():
        return True
    k_mat, m_mat = (a / np.outer(size, size) for a in (k_mat, m_mat))
    smallest = [np.linalg.svd(k_mat - x * m_mat)[1] for x in SHIFTS * np.abs(k_mat).max()]
    return all(s[-1] <= 10 * len(size) * np.finfo(float).eps * s[0] for s in smallest)


def exact(value):
    """A double as a ball of radius zero."""
    fraction, exponent = np.frexp(value)
    return flint.arb((int(fraction * 2**53), int(exponent) - 53))


def number(ball):
    """The middle of a ball of FLINT."""
    mantissa, exponent = ball.mid().man_exp()
    return mpmath.ldexp(mpmath.mpf(int(mantissa)), int(exponent))


def whole_numbers(a, b):
    """A and B 2**shift as whole numbers, rows and columns scaled by powers of two, and the shift of x."""
    n = len(a)
    with np.errstate(divide="ignore"):
        log_a, log_b = (np.log2(np.abs(m)) for m in (a, b))
    finite_a, finite_b = log_a[a != 0], log_b[b != 0]
    shift = int(round(np.median(finite_a) - np.median(finite_b))) if finite_a.size and finite_b.size else 0
    log = np.maximum(log_a, log_b + shift)
    row, column = np.zeros(n), np.zeros(n)
    for _ in range(6):
        row = -np.max(log + column, axis=1)
        if not np.all(np.isfinite(row)):
            return None
        column = -np.max(log + row[:, None], axis=0)
        if not np.all(np.isfinite(column)):
            return None
    row, column = (np.round(v).astype(int) for v in (row, column))

    def parts(m, by):
        return [[(*np.frexp(m[r, c]), row[r] + column[c] + by) for c in range(n)] for r in range(n)]

    split = [parts(a, 0), parts(b, shift)]
    lowest = min(int(e + s) - 53 for m in split for line in m for f, e, s in line if f)
    whole = [
        [[int(f * 2**53) << int(e + s - 53 - lowest) if f else 0 for f, e, s in line] for line in m]
        for m in split
    ]
    return *whole, shift


def determinant(a, b):
    """det(A - x B) of whole numbers, as a polynomial in x."""
    n = len(a)
    degree = sum(any(row) for row in b)
    points = list(range(-(degree // 2), degree - degree // 2 + 1))
    values = []
    for x in points:
        lines = [[p - x * q for p, q in zip(r, s, strict=True)] for r, s in zip(a, b, strict=True)]
        values.append(flint.fmpq(flint.fmpz_mat(n, n, [v for line in lines for v in line]).det()))
    # Newton's divided differences.
    for level in range(1, len(points)):
        for j in range(len(points) - 1, level - 1, -1):
            values[j] = (values[j] - values[j - 1]) / (points[j] - points[j - level])
    polynomial = flint.fmpq_poly([values[-1]])
    for j in range(len(points) - 2, -1, -1):
        polynomial = polynomial * flint.fmpq_poly([-points[j], 1]) + flint.fmpq_poly([values[j]])
    return polynomial.numer()
