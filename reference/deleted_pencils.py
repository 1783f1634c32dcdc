r"""Antiresonances of order r by QZ: roots of det(K - x M) with r rows and r columns deleted, x = (2 pi f)^2.

A minor of the receptances that is zero at every frequency, as of responses which one path alone connects to
the forces, has a singular pencil, of which QZ makes roots out of rounding: it is told by the determinant at
a few places against the product of the sizes of its rows (Hadamard). Nothing of antires_rs is used.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

#: Determinant over Hadamard's bound, at the best of some places, below which it is zero everywhere.
NOTHING = 1e-12
#: Roots with more of an imaginary part than this share of their size are complex.
REAL = 1e-6


def antiresonances_hz(stiffness, mass, responses, forces):
    """Frequencies in Hz of responses and forces of one number, ascending; None if the minor is zero."""
    k, m = (np.delete(np.delete(a, responses, 0), forces, 1) for a in (stiffness, mass))
    if not k.size:
        return np.empty(0)
    size = float(np.abs(k).max() / np.abs(m).max())
    places = size * np.random.default_rng(0).uniform(0.1, 4.0, 5)
    matrices = [k - x * m for x in places]
    if max(_share(one) for one in matrices) < NOTHING:
        return None
    x = scipy.linalg.eigvals(k, m)
    x = x[np.isfinite(x)]
    x = x[(np.abs(x.imag) < REAL * np.abs(x)) & (x.real > 1e-9 * size)].real
    return np.sort(np.sqrt(x)) / (2.0 * np.pi)


def _share(matrix):
    rows = np.linalg.norm(matrix, axis=1)
    return 0.0 if (rows == 0.0).any() else abs(np.linalg.det(matrix / rows[:, None]))
