"""Square structures, whose modes come in pairs of one frequency: every antiresonance, and none beside them.

A square membrane by finite differences has the modes sin(i x) sin(j y), so that its response is a sum of
partial fractions in closed form; modes that vanish at the point of the force have no part in it.
"""

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.optimize import brentq

import antires_rs as ar

STIFFNESS = 1e6


def membrane(m):
    """The model of m by m unit masses."""
    line = sp.diags_array([np.full(m, 2.0), np.full(m - 1, -1.0), np.full(m - 1, -1.0)], offsets=[0, 1, -1])
    one = sp.eye_array(m)
    return ar.MatrixModel(
        (STIFFNESS * (sp.kron(line, one) + sp.kron(one, line))).tocsc(), sp.eye_array(m * m)
    )


def exact_hz(m, row, column, limit_hz):
    """Roots of the driving-point response in closed form, to rounding."""
    step = np.arange(1, m + 1)
    own = STIFFNESS * (2.0 - 2.0 * np.cos(np.pi * step / (m + 1)))
    shape = np.sin(np.pi * np.outer(step, step) / (m + 1)) ** 2
    poles, parts = (own[:, None] + own).ravel(), np.outer(shape[:, row], shape[:, column]).ravel()
    order = np.argsort(poles)
    poles, parts = poles[order], parts[order]
    # One pole for each frequency, and none without a part.
    first = np.flatnonzero(np.diff(poles, prepend=-1.0) > 1e-9 * poles)
    poles, parts = poles[first], np.add.reduceat(parts, first)
    poles, parts = poles[parts > 1e-12], parts[parts > 1e-12]
    inside = poles[poles < 1.2 * (2 * np.pi * limit_hz) ** 2]
    ends = zip(inside[:-1] * (1 + 1e-12), inside[1:] * (1 - 1e-12), strict=True)
    roots = [brentq(lambda x: np.sum(parts / (poles - x)), low, high, rtol=1e-14) for low, high in ends]
    found = np.sqrt(roots) / (2 * np.pi)
    return found[found < limit_hz]


@pytest.mark.parametrize("m", [40, 55])
@pytest.mark.parametrize("place", ["diagonal", "anywhere"])
def test_every_antiresonance_of_a_square_membrane(m, place):
    model = membrane(m)
    row, column = (m // 3, m // 3) if place == "diagonal" else (m // 9, m // 2)
    at = row * m + column
    limit_hz = 150.0 * 40 / m
    found = model.antiresonances([at], at, f_max_hz=limit_hz)[0]
    exact = exact_hz(m, row, column, limit_hz)
    assert found.size == exact.size > 20
    np.testing.assert_allclose(found, exact, rtol=1e-9)
