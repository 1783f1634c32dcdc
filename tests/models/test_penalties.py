"""Supports and ties by stiff springs: right to 1e-6, or a warning that names the dofs; never silent."""

import warnings

import numpy as np
import pytest
import scipy.linalg

import antires_rs as ar
from tests.support.fifty_digits import is_root

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
    assert bool(said) == (power >= 17)
    if matrices:
        made, said = told(lambda: ar.MatrixModel(made.stiffness(), made.mass()))
        assert not said
        assert ("taken out" in repr(made)) == (power >= 14)
    if said:
        assert "rounding may take 1e-6" in said[0]
        assert "node 0" in said[0]
    else:
        np.testing.assert_allclose(first(made, 3), exact, rtol=1e-6)


@pytest.mark.parametrize("power", EXPONENTS)
@pytest.mark.parametrize("matrices", [False, True])
def test_masses_tied_by_a_spring(power, matrices):
    model, said = told(lambda: chain(10.0**power))
    if matrices:
        model, said = told(lambda: ar.MatrixModel(model.stiffness(), model.mass()))
    assert bool(said) == (power >= (13 if matrices else 14))
    if said:
        assert ("dof 2" if matrices else "mass 1") in said[0]
    else:
        # The spring itself moves frequencies by its share; from 1e12 on less than the limit.
        rtol = 1e-6 if power >= 12 else 2.0 * 1e5 / 10.0**power
        np.testing.assert_allclose(first(model, 3), first(chain(), 3), rtol=rtol)


def tied_chain(power):
    """Thirty masses, two of the springs between them penalties."""
    rng = np.random.default_rng(1)
    springs = rng.uniform(3e4, 8e4, 29)
    springs[[12, 21]] = 10.0**power
    return ar.MassSpringChain(rng.uniform(0.5, 2.0, 30), springs, ground_first_n_per_m=3e4)


#: From 1e20 on rounding makes the stiffness of these chains indefinite: nothing is left that could be right.
@pytest.mark.parametrize("power", [*range(9, 20)])
@pytest.mark.parametrize(("make", "ends"), [(chain, (3, 1)), (tied_chain, (28, 1)), (cantilever, (34, 7))])
def test_the_lower_roots_of_matrices_as_given(power, make, ends):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        made = make(power if make is tied_chain else 10.0**power)
        k, m = made.stiffness(), made.mass()
        model = ar.MatrixModel(k, m)
    for hz in model.modes(n_modes=2).freq_hz[:2]:
        assert is_root(k, m, hz)
    for pair in ((ends[0], ends[0]), ends):
        roots = model.antiresonances(*pair)[:2]
        assert roots.size
        for hz in roots:
            assert is_root(k, m, hz, pair)


TUBE = ar.Tube(0.06, 0.01, 2.1e11, 7850.0)
DIRECTIONS = ("u", "v", "w", "rx", "ry", "rz")


def two_cantilevers():
    """In space, three beams each, and the equations of a rigid link with a lever arm between their ends."""
    one = [(0.5 * i, 0.0, 0.0) for i in range(4)]
    other = [(0.5 * i, 0.3, 0.2 + 0.1 * i) for i in range(4)]
    beams = [(i, i + 1) for i in range(3)] + [(4 + i, 5 + i) for i in range(3)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # in two parts
        frame = ar.FrameModel(one + other, beams, TUBE, fixed=[0, 4])
    x, y, z = np.subtract(other[3], one[3])
    turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    equations = np.zeros((6, frame.n_dof))
    for row, direction in enumerate(DIRECTIONS):
        equations[row, frame.dof(7, direction)] = 1.0
        equations[row, frame.dof(3, direction)] = -1.0
    for row in range(3):
        for turn in range(3):
            equations[row, frame.dof(3, DIRECTIONS[3 + turn])] = -turned[row, turn]
    return frame, equations


@pytest.fixture(scope="module")
def linked():
    """The two, joined without penalties: matrices, equations, first modes and zeros."""
    frame, c = two_cantilevers()
    k, m = frame.stiffness().toarray(), frame.mass().toarray()
    tip = frame.dof(2, "w")
    exact = ar.MatrixModel(k, m, constraints=c)
    assert "6 of them taken out" in repr(exact)
    found = np.concatenate([exact.modes(n_modes=4).freq_hz, exact.antiresonances(tip, tip)[:4]])
    return k, m, c, tip, found


@pytest.mark.parametrize("power", EXPONENTS)
def test_a_rigid_link_with_a_lever_arm(linked, power):
    k, m, c, tip, exact = linked
    stiff = k + 10.0**power * (c.T @ c)
    stiff = 0.5 * (stiff + stiff.T)
    model, said = told(lambda: ar.MatrixModel(stiff, m))
    assert bool(said) == (power >= 15)
    if said:
        assert "rounding in the assembly" in said[0]
        assert "dof 1" in said[0]
        return
    found = np.concatenate([model.modes(n_modes=4).freq_hz, model.antiresonances(tip, tip)[:4]])
    # The link itself moves frequencies by its share.
    np.testing.assert_allclose(found, exact, rtol=max(1e-6, 1e6 / 10.0**power))


@pytest.mark.parametrize("power", [10, 13, 15, 17, 20])
def test_the_roots_of_rigid_links_as_given(linked, power):
    """Also where rounding has changed what is beside the link, and at a dof that was taken out."""
    k, m, c, tip, _ = linked
    stiff = k + 10.0**power * (c.T @ c)
    stiff = 0.5 * (stiff + stiff.T)
    model, _ = told(lambda: ar.MatrixModel(stiff, m))
    end = two_cantilevers()[0].dof(7, "v")
    for hz in model.modes(n_modes=2).freq_hz:
        assert is_root(stiff, m, hz)
    for pair in ((tip, tip), (end, tip)):
        for hz in model.antiresonances(*pair)[:2]:
            assert is_root(stiff, m, hz, pair)


def test_penalties_stay_out_while_parameters_change():
    """A penalty in a term, and a term beside it."""
    k, m = (np.asarray(a) for a in (chain().stiffness(), chain().mass()))
    k, m = scipy.linalg.block_diag(k, 0.0), scipy.linalg.block_diag(m, 0.6)
    tie, spring = np.zeros((5, 5)), np.zeros((5, 5))
    pair = np.array([[1.0, -1.0], [-1.0, 1.0]])
    tie[np.ix_([1, 4], [1, 4])] = 1e14 * pair
    spring[np.ix_([1, 2], [1, 2])] = 6e4 * pair
    model, said = told(lambda: ar.MatrixModel(k + tie, m, stiffness_terms=[spring, tie]))
    assert "taken out" in repr(model)
    assert "dof" in said[0]
    assert model.default_elements == [0]
    changed = model.with_parameters(ar.stiffness_factor(0, bounds=(0.5, 2.0)), 1.4)
    given = k + 0.4 * spring + tie
    for pair_ in [(0, 0), (0, 3), (4, 2)]:
        for hz in changed.antiresonances(*pair_)[:2]:
            assert is_root(given, m, hz, pair_)
    with pytest.raises(ar.InvalidInputError, match=r"stiffness term\(s\) \[1\], which are zero"):
        model.with_parameters(ar.stiffness_factor(1, bounds=(0.5, 2.0)), 0.8)


def test_members_of_very_unlike_stiffness_are_no_penalties():
    sections = [ar.Rectangle(0.5, 0.8, 2.1e11, 7850.0), ar.Rectangle(0.004, 0.004, 3e9, 1200.0)]
    _, said = told(
        lambda: ar.FrameModel(
            [(0, 0), (1, 0), (9, 0)], [(0, 1), (1, 2)], sections, fixed=[(0, "u"), (0, "v"), (0, "theta")]
        )
    )
    assert not said
