"""Supports and ties by stiff springs: right to 1e-6, or a warning that names the dofs; never silent."""

import warnings

import numpy as np
import pytest

import antires_rs as ar

EXPONENTS = range(9, 26)
SECTION = ar.Rectangle(0.03, 0.05, 2.1e11, 7850.0)


def cantilever(spring=None, n=12):
    nodes = [(0.25 * i, 0.0) for i in range(n + 1)]
    beams = [(i, i + 1) for i in range(n)]
    directions = ("u", "v", "theta")
    if spring is None:
        return ar.FrameModel(nodes, beams, SECTION, fixed=[(0, d) for d in directions])
    return ar.FrameModel(nodes, beams, SECTION, ground_springs=[(0, d, spring) for d in directions])


def chain(tie=None):
    """Five masses, the second and third joined; the same with four."""
    masses, springs = [1.0, 0.5, 0.7, 1.2, 0.8], [4e4, tie, 6e4, 5e4]
    if tie is None:
        masses, springs = [1.0, 1.2, 1.2, 0.8], [4e4, 6e4, 5e4]
    return ar.MassSpringChain(masses, springs, ground_first_n_per_m=3e4)


def first(model, count):
    dof = model.n_dof - 2
    return np.concatenate([model.modes(n_modes=count).freq_hz, model.antiresonances(dof, dof)[:count]])


def told(make):
    """A model, and whether it warned."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        made = make()
    return made, [str(each.message) for each in said]


@pytest.mark.parametrize("power", EXPONENTS)
@pytest.mark.parametrize("matrices", [False, True])
def test_a_cantilever_on_springs(power, matrices):
    """Against the same spring where rounding does no harm: from 1e13 on nothing changes any more."""
    exact = first(cantilever(10.0 ** min(power, 13)), 3)
    made, said = told(lambda: cantilever(10.0**power))
    if matrices:
        k, m = made.stiffness(), made.mass()
        made, said = told(lambda: ar.MatrixModel(k, m))
    if said:
        assert "rounding may take 1e-6" in said[0]
        assert ("dof 0" if matrices else "node 0") in said[0]
    else:
        np.testing.assert_allclose(first(made, 3), exact, rtol=1e-6)
    assert bool(said) == (power >= 17)


@pytest.mark.parametrize("power", EXPONENTS)
def test_masses_tied_by_a_spring(power):
    model, said = told(lambda: chain(10.0**power))
    if said:
        assert "mass 2" in said[0]
    else:
        # The spring itself moves frequencies by its share; from 1e12 on less than the limit.
        rtol = 1e-6 if power >= 12 else 2.0 * 1e5 / 10.0**power
        np.testing.assert_allclose(first(model, 3), first(chain(), 3), rtol=rtol)


def test_members_of_very_unlike_stiffness_are_no_penalties():
    sections = [ar.Rectangle(0.5, 0.8, 2.1e11, 7850.0), ar.Rectangle(0.004, 0.004, 3e9, 1200.0)]
    _, said = told(
        lambda: ar.FrameModel(
            [(0, 0), (1, 0), (9, 0)], [(0, 1), (1, 2)], sections, fixed=[(0, "u"), (0, "v"), (0, "theta")]
        )
    )
    assert not said
