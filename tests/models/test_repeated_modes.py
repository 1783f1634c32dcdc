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


def membrane(m, apart=0.0):
    """The model of m by m unit masses, along one side stiffer by the part `apart`."""
    line = sp.diags_array([np.full(m, 2.0), np.full(m - 1, -1.0), np.full(m - 1, -1.0)], offsets=[0, 1, -1])
    one = sp.eye_array(m)
    return ar.MatrixModel(
        (STIFFNESS * (sp.kron(line, one) + (1.0 + apart) * sp.kron(one, line))).tocsc(), sp.eye_array(m * m)
    )


def exact_hz(m, row, column, limit_hz, apart=0.0):
    """Roots of the driving-point response in closed form, to rounding."""
    step = np.arange(1, m + 1)
    own = STIFFNESS * (2.0 - 2.0 * np.cos(np.pi * step / (m + 1)))
    shape = np.sin(np.pi * np.outer(step, step) / (m + 1)) ** 2
    poles, parts = (
        (own[:, None] + (1.0 + apart) * own).ravel(),
        np.outer(shape[:, row], shape[:, column]).ravel(),
    )
    order = np.argsort(poles)
    poles, parts = poles[order], parts[order]
    # One pole for each frequency, and none without a part.
    first = np.flatnonzero(np.diff(poles, prepend=-1.0) > 1e-12 * poles)
    poles, parts = poles[first], np.add.reduceat(parts, first)
    poles, parts = poles[parts > 1e-12], parts[parts > 1e-12]
    inside = poles[poles < 3.0 * (2 * np.pi * limit_hz) ** 2]

    def root(low, high):
        # From the pole below on, so that two poles that nearly coincide keep their distance.
        gap = high - low
        share = brentq(lambda part: np.sum(parts / ((poles - low) - part * gap)), 1e-9, 1 - 1e-9, rtol=1e-14)
        return low + share * gap

    roots = [root(low, high) for low, high in zip(inside[:-1], inside[1:], strict=True)]
    found = np.sqrt(roots) / (2 * np.pi)
    return found[found < limit_hz]


def assert_every_root(model, m, place, limit_hz, apart=0.0):
    row, column = place
    at = row * m + column
    found = model.antiresonances([at], at, f_max_hz=limit_hz)[0]
    exact = exact_hz(m, row, column, limit_hz, apart)
    assert found.size == exact.size > 10
    np.testing.assert_allclose(found, exact, rtol=1e-9)


@pytest.mark.parametrize("m", [18, 25, 27, 33, 40, 55])
@pytest.mark.parametrize("place", ["diagonal", "anywhere", "corner"])
def test_every_antiresonance_of_a_square_membrane(m, place):
    places = {"diagonal": (m // 3, m // 3), "anywhere": (m // 9, m // 2), "corner": (0, m - 2)}
    model = membrane(m)
    for limit_hz in (90.0, 125.0, 150.0):
        assert_every_root(model, m, places[place], limit_hz * 40 / m)


@pytest.mark.parametrize("apart", [1e-4, 1e-6, 1e-7, 1e-8])
@pytest.mark.parametrize("m", [25, 33, 44])
def test_two_modes_that_nearly_coincide_keep_the_antiresonance_between_them(m, apart):
    model = membrane(m, apart)
    for place in ((m // 3, m // 3), (2, 5)):
        assert_every_root(model, m, place, 110.0 * 40 / m, apart)
