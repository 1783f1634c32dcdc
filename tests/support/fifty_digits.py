"""Signs of determinants of matrices as they are given, by 50 digits: the truth for stiff and graded ones."""

import mpmath
import numpy as np


def _sign(rows):
    """Sign of a determinant, its rows changed, by elimination with row exchanges."""
    n, sign = len(rows), 1
    for j in range(n):
        at = max(range(j, n), key=lambda i: abs(rows[i][j]))
        if at != j:
            rows[at], rows[j] = rows[j], rows[at]
            sign = -sign
        pivot = rows[j][j]
        if pivot == 0:
            return 0
        sign = sign if pivot > 0 else -sign
        right = [(c, rows[j][c]) for c in range(j + 1, n) if rows[j][c] != 0]
        for row in rows[j + 1 :]:
            if row[j] != 0:
                share = row[j] / pivot
                for c, value in right:
                    row[c] -= share * value
    return sign


def determinant_sign(k, m, hz, response=None, excitation=None, step=0.0):
    """Sign of det(K - x M) at (1 + step) of a frequency, without the row and column of its ends."""
    rows = [i for i in range(len(k)) if i != response]
    columns = [j for j in range(len(k)) if j != excitation]
    with mpmath.workdps(50):
        x = (2 * mpmath.pi * mpmath.mpf(float(hz)) * (1 + mpmath.mpf(step))) ** 2
        exact = mpmath.mpf
        return _sign([[exact(float(k[i, j])) - x * exact(float(m[i, j])) for j in columns] for i in rows])


def is_root(k, m, hz, ends=(None, None), within=1e-8):
    """Whether the determinant changes its sign within a relative distance of a frequency."""
    k, m = (np.asarray(a.toarray() if hasattr(a, "toarray") else a) for a in (k, m))
    below, above = (determinant_sign(k, m, hz, *ends, step) for step in (-within, within))
    return below * above < 0
