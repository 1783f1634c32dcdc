"""How far a frequency is from the root of the assembled matrices, in 50 digits.

Newton's step for H_ik(x) = 0 from a root that is good to some digits is its error:
``-H / H'`` with ``H = e_i' u``, ``H' = w' M u``, ``(K - x M) u = e_k``, ``(K - x M) w = e_i``.
mpmath where it is installed, else the decimals of the standard library.
"""

from __future__ import annotations

import decimal
import math

import numpy as np
import scipy.linalg
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

try:
    import mpmath
except ImportError:
    mpmath = None

DIGITS = 50

#: Refinement of a solution: largest last step, relative, and most steps.
REFINED, REFINEMENTS = 1e-25, 60


def precise(value):
    """A double as a number of 50 digits, exactly."""
    if mpmath is None:
        decimal.getcontext().prec = DIGITS
        return decimal.Decimal(float(value))
    mpmath.mp.dps = DIGITS
    return mpmath.mpf(float(value))


class ExactPencil:
    """K and M in 50 digits, ordered to a band."""

    def __init__(self, k_mat, m_mat):
        k_mat, m_mat = (np.tril(a) + np.tril(a, -1).T for a in (k_mat, m_mat))
        self.order = reverse_cuthill_mckee(csr_array((k_mat != 0) | (m_mat != 0)), symmetric_mode=True)
        self.row = np.argsort(self.order)
        self.doubles = [a[np.ix_(self.order, self.order)] for a in (k_mat, m_mat)]
        rows, cols = np.nonzero((self.doubles[0] != 0) | (self.doubles[1] != 0))
        self.half = int(np.abs(rows - cols).max())
        self.places = list(zip(rows.tolist(), cols.tolist(), strict=True))
        self.entries = [tuple(precise(a[place]) for a in self.doubles) for place in self.places]
        wide = np.vectorize(precise, otypes=[object])
        self.k_mat, self.m_mat = (wide(a) for a in self.doubles)

    def _vectors(self, i, k, x):
        """u and w as columns: doubles first, then refined with residuals of 50 digits to the last 25."""
        n = len(self.k_mat)
        values = [k_entry - x * m_entry for k_entry, m_entry in self.entries]
        try:
            factors = scipy.linalg.lu_factor(self.doubles[0] - float(x) * self.doubles[1])
        except (scipy.linalg.LinAlgError, ValueError):
            return self._eliminated(i, k, x)
        columns = []
        for place in (k, i):
            solution, residual = [precise(0)] * n, [precise(0)] * n
            residual[place] = precise(1)
            for _ in range(REFINEMENTS):
                step = [precise(v) for v in scipy.linalg.lu_solve(factors, [float(r) for r in residual])]
                solution = [s + d for s, d in zip(solution, step, strict=True)]
                if max(abs(d) for d in step) <= precise(REFINED) * max(abs(s) for s in solution):
                    break
                residual = [precise(0)] * n
                residual[place] = precise(1)
                for (row, col), value in zip(self.places, values, strict=True):
                    residual[row] -= value * solution[col]
            else:
                return self._eliminated(i, k, x)
            columns.append(np.array(solution, dtype=object))
        return columns

    def _eliminated(self, i, k, x):
        """u and w by elimination without pivoting: 50 digits forgive it."""
        a, n = self.k_mat - x * self.m_mat, len(self.k_mat)
        columns = np.full((n, 2), precise(0), dtype=object)
        columns[k, 0] = columns[i, 1] = precise(1)
        factors = []
        for j in range(n):
            end = min(n, j + self.half + 1)
            factor = a[j + 1 : end, j] / a[j, j]
            factors.append(factor)
            a[j + 1 : end, j + 1 : end] -= np.outer(factor, a[j, j + 1 : end])
            columns[j + 1 : end] -= np.outer(factor, columns[j])
        for j in reversed(range(n)):
            columns[j] = columns[j] / a[j, j]
            if factors[j].size:
                below = columns[j + 1 : j + 1 + factors[j].size]
                columns[j] -= (factors[j][:, None] * below).sum(axis=0)
        return columns[:, 0], columns[:, 1]

    def error(self, response, excitation, freq_hz):
        """(relative error of a frequency, relative shift that one ulp in every entry of K and M makes).

        The shift is the root mean square over signs taken at random.
        """
        i, k = self.row[response], self.row[excitation]
        x = (2 * pi() * precise(freq_hz)) ** 2
        u, w = self._vectors(i, k, x)
        mass_u = np.array([(self.m_mat[j, lo:hi] * u[lo:hi]).sum() for j, lo, hi in self._windows()])
        slope = (w * mass_u).sum()
        size = max(abs(v) for v in u), max(abs(v) for v in w)
        uf, wf = (np.array([float(v / s) for v in c]) for c, s in zip((u, w), size, strict=True))
        k_mat, m_mat = self.doubles
        entries = [wf[:, None] * k_mat * uf, float(x) * wf[:, None] * m_mat * uf]
        moved = np.finfo(float).eps * math.sqrt(sum(float((e**2).sum()) for e in entries))
        ulp = moved / abs(float(slope / (size[0] * size[1]))) / float(x) / 2
        return float(u[i] / slope / x) / 2, ulp

    def root_near(self, response, excitation, freq_hz):
        """The root that Newton's steps reach from a frequency; None where they wander off."""
        for _ in range(8):
            step = self.error(response, excitation, freq_hz)[0]
            if not math.isfinite(step) or abs(step) > 0.3:
                return None
            freq_hz *= 1.0 - step
            if abs(step) < 1e-13:
                return freq_hz
        return None

    def driving_zeros(self, dof, low_hz, high_hz):
        """Number of roots of H_dd between two frequencies, cancelled ones too: Sylvester's law of inertia."""
        kept = np.flatnonzero(np.arange(len(self.k_mat)) != self.row[dof])
        low, high = (self._negative_pivots(kept, (2 * pi() * precise(f)) ** 2) for f in (low_hz, high_hz))
        return high - low

    def _negative_pivots(self, kept, x):
        a = (self.k_mat - x * self.m_mat)[np.ix_(kept, kept)]
        for j in range(len(a)):
            end = min(len(a), j + self.half + 1)
            a[j + 1 : end, j + 1 : end] -= np.outer(a[j + 1 : end, j] / a[j, j], a[j, j + 1 : end])
        return sum(a[j, j] < 0 for j in range(len(a)))

    def _windows(self):
        n = len(self.k_mat)
        return [(j, max(0, j - self.half), min(n, j + self.half + 1)) for j in range(n)]


def pi():
    """Pi in 50 digits."""
    if mpmath is None:
        decimal.getcontext().prec = DIGITS
        return decimal.Decimal("3.14159265358979323846264338327950288419716939937510582")
    mpmath.mp.dps = DIGITS
    return +mpmath.pi
