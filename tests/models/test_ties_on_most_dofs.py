"""Penalties on most dofs or on all: right to 1e-8 of the matrices as given, or a warning; never silent."""

import warnings

import numpy as np
import pytest

import antires_rs as ar

pytest.importorskip("flint", reason="python-flint is not installed: no exact roots to compare with")
pytest.importorskip("mpmath", reason="mpmath is not installed: no numbers of 50 digits")

from tests.models.test_penalty_torture import exact_hz

#: The rules were set on ties of 1e12, 1e15 and 1e20, and are judged on the others too.
POWERS = range(10, 21)


def assembled(n, springs, ground):
    k = np.zeros((n, n))
    for a, b, value in springs:
        k[a, a] += value
        k[b, b] += value
        k[a, b] -= value
        k[b, a] -= value
    for dof, value in ground:
        k[dof, dof] += value
    return k


def slabs(tie):
    """Four of three nodes, on columns: every dof is in a tie."""
    ties = [(3 * s + c, 3 * s + c + 1, tie) for s in range(4) for c in range(2)]
    columns = [(3 * s + c, 3 * s + c + 3, 1e7) for s in range(3) for c in range(3)]
    return assembled(12, ties + columns, [(c, 1e7) for c in range(3)]), 1e3 * np.eye(12)


def single_link(tie):
    """Three slabs of five nodes, of which one is on a column."""
    ties = [(5 * s + c, 5 * s + c + 1, tie) for s in range(3) for c in range(4)]
    return assembled(15, [*ties, (4, 5, 1e6), (9, 10, 1e6)], [(0, 1e6)]), 50.0 * np.eye(15)


def pairs(tie):
    return assembled(4, [(0, 1, tie), (1, 2, 1e4), (2, 3, tie)], [(0, 1e4)]), np.eye(4)


def three(tie):
    return assembled(3, [(0, 1, 1e4), (1, 2, tie)], [(0, 1e4)]), np.eye(3)


def most(tie):
    """Two pairs, and a mass between them."""
    springs = [(0, 1, tie), (1, 2, 1e4), (2, 3, 2e4), (3, 4, tie)]
    return assembled(5, springs, [(0, 1e4)]), np.diag([1.0, 2.0, 0.7, 1.0, 0.4])


@pytest.mark.parametrize("power", POWERS)
@pytest.mark.parametrize("make", [slabs, single_link, pairs, three, most])
def test_right_or_told(make, power):
    k, m = make(10.0**power)
    n = len(k)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        model = ar.MatrixModel(k, m)
    told = [str(each.message) for each in said]
    if told:
        assert "penalties at dof" in told[0]
        assert power >= 11
        return
    for pair in ((n - 1, n - 1), (0, n - 1)):
        _, wanted = exact_hz(k, m, *pair)
        found = model.antiresonances(*pair, include_cancelled=True)
        np.testing.assert_allclose(found, wanted, rtol=1e-8)


@pytest.mark.parametrize("make", [slabs, single_link, pairs, three, most])
def test_the_stiffest_are_told(make):
    with pytest.warns(ar.AntiresWarning, match="penalties at dof"):
        model = ar.MatrixModel(*make(1e20))
    assert "taken out" in repr(model)


@pytest.mark.parametrize("power", [14, 20])
def test_chains_of_pairs_are_told(power):
    with pytest.warns(ar.AntiresWarning, match="mass 0, mass 1, mass 2, mass 3 up to"):
        ar.MassSpringChain(np.ones(4), [10.0**power, 1e4, 10.0**power], ground_first_n_per_m=1e4)


def test_free_bars_turned_by_rounding_are_no_ties():
    """Along and across it couplings are those of an angle of 1e-16; nothing is stiff."""
    n = 20
    along = assembled(n, [(i, i + 1, 1e9) for i in range(n - 1)], [])
    across = assembled(n, [(i, i + 1, 1e6) for i in range(n - 1)], [])
    k = np.block([[along, 1e-16 * along], [1e-16 * along, across]])
    assert "taken out" not in repr(ar.MatrixModel(k, np.eye(2 * n)))
