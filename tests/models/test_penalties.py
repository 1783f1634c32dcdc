"""Supports and ties by stiff springs: right to 1e-6, or a warning that names the dofs; never silent."""

import warnings

import numpy as np
import pytest

import antires_rs as ar
from tests.support.fifty_digits import is_root

#: The limits were set on ties of 1e12, 1e15 and 1e20, and are judged on the others too.
EXPONENTS = range(9, 26)
SECTION = ar.Rectangle(0.03, 0.05, 2.1e11, 7850.0)
TUBE = ar.Tube(0.06, 0.01, 2.1e11, 7850.0)
DIRECTIONS = ("u", "v", "w", "rx", "ry", "rz")


def told(make):
    """A model, and what it warned."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        made = make()
    return made, [str(each.message) for each in said]


def cantilever(spring, n=12):
    nodes = [(0.25 * i, 0.0) for i in range(n + 1)]
    beams = [(i, i + 1) for i in range(n)]
    springs = [(0, d, spring) for d in ("u", "v", "theta")]
    return ar.FrameModel(nodes, beams, SECTION, ground_springs=springs)


def chain(tie):
    """Five masses, the second and third joined."""
    return ar.MassSpringChain([1.0, 0.5, 0.7, 1.2, 0.8], [4e4, tie, 6e4, 5e4], ground_first_n_per_m=3e4)


def tied_chain(tie):
    """Thirty masses, two of the springs between them penalties."""
    rng = np.random.default_rng(1)
    springs = rng.uniform(3e4, 8e4, 29)
    springs[[12, 21]] = tie
    return ar.MassSpringChain(rng.uniform(0.5, 2.0, 30), springs, ground_first_n_per_m=3e4)


@pytest.mark.parametrize("power", EXPONENTS)
@pytest.mark.parametrize("of_matrices", [False, True])
@pytest.mark.parametrize(
    ("make", "named", "ends", "told_from"),
    [
        (cantilever, ("node 0", "dof 0"), (34, 7), 16),
        (chain, ("mass 1", "dof 1"), (3, 1), 13),
        (tied_chain, ("mass 12", "dof 12"), (28, 1), 13),
    ],
)
def test_right_or_told_by_name(make, named, ends, told_from, of_matrices, power):
    model, said = told(lambda: make(10.0**power))
    k, m = model.stiffness(), model.mass()
    if of_matrices:
        model, said = told(lambda: ar.MatrixModel(k, m))
    assert len(said) == (power >= told_from)
    if said:
        assert named[of_matrices] in said[0]
        assert "rounding may take 1e-6" in said[0]
        assert not of_matrices or "constraints=" in said[0]
        return
    for hz in model.modes(n_modes=2).freq_hz[:2]:
        assert is_root(k, m, hz, within=1e-6)
    for pair in ((ends[0], ends[0]), ends):
        roots = model.antiresonances(*pair)[:2]
        assert roots.size
        for hz in roots:
            assert is_root(k, m, hz, pair, within=1e-6)


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


@pytest.mark.parametrize("power", EXPONENTS)
@pytest.mark.parametrize("make", [slabs, single_link, pairs, three, most])
def test_ties_on_most_dofs_are_right_or_told(make, power):
    k, m = make(10.0**power)
    model, said = told(lambda: ar.MatrixModel(k, m))
    assert power >= 11 or not said
    assert power < 16 or said
    if not said:
        n = len(k)
        for pair in ((n - 1, n - 1), (0, n - 1)):
            for hz in model.antiresonances(*pair)[:2]:
                assert is_root(k, m, hz, pair, within=1e-6)


def linked_cantilevers():
    """In space, three beams each, and the equations of a rigid link with a lever arm between their ends."""
    one = [(0.5 * i, 0.0, 0.0) for i in range(4)]
    other = [(0.5 * i, 0.3, 0.2 + 0.1 * i) for i in range(4)]
    beams = [(i, i + 1) for i in range(3)] + [(4 + i, 5 + i) for i in range(3)]
    frame, _ = told(lambda: ar.FrameModel(one + other, beams, TUBE, fixed=[0, 4]))  # in two parts
    x, y, z = np.subtract(other[3], one[3])
    turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    equations = np.zeros((6, frame.n_dof))
    for row, direction in enumerate(DIRECTIONS):
        equations[row, frame.dof(7, direction)] = 1.0
        equations[row, frame.dof(3, direction)] = -1.0
    for row in range(3):
        for turn in range(3):
            equations[row, frame.dof(3, DIRECTIONS[3 + turn])] = -turned[row, turn]
    return frame.stiffness().toarray(), frame.mass().toarray(), equations, frame.dof(2, "w")


@pytest.mark.parametrize("power", EXPONENTS)
def test_a_rigid_link_with_a_lever_arm(power):
    """By penalties it is right or told; by constraints= it is right without a word."""
    k, m, c, tip = linked_cantilevers()
    exact, said = told(lambda: ar.MatrixModel(k, m, constraints=c))
    assert not said
    assert "6 of them taken out" in repr(exact)
    stiff = k + 10.0**power * (c.T @ c)
    model, said = told(lambda: ar.MatrixModel(0.5 * (stiff + stiff.T), m))
    assert bool(said) == (power >= 15)
    if not said:
        found, wanted = (
            np.concatenate([one.modes(n_modes=4).freq_hz, one.antiresonances(tip, tip)[:4]])
            for one in (model, exact)
        )
        # The link itself moves frequencies by its share.
        np.testing.assert_allclose(found, wanted, rtol=max(1e-6, 1e6 / 10.0**power))


def test_free_bars_turned_by_rounding_are_no_ties():
    """Along and across it couplings are those of an angle of 1e-16; nothing is stiff."""
    n = 20
    along = assembled(n, [(i, i + 1, 1e9) for i in range(n - 1)], [])
    across = assembled(n, [(i, i + 1, 1e6) for i in range(n - 1)], [])
    _, said = told(
        lambda: ar.MatrixModel(np.block([[along, 1e-16 * along], [1e-16 * along, across]]), np.eye(2 * n))
    )
    assert not said


def test_members_of_very_unlike_stiffness_are_no_penalties():
    sections = [ar.Rectangle(0.5, 0.8, 2.1e11, 7850.0), ar.Rectangle(0.004, 0.004, 3e9, 1200.0)]
    fixed = [(0, "u"), (0, "v"), (0, "theta")]
    _, said = told(lambda: ar.FrameModel([(0, 0), (1, 0), (9, 0)], [(0, 1), (1, 2)], sections, fixed=fixed))
    assert not said
