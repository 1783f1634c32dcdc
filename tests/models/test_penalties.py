"""Supports and ties by stiff springs: right to 1e-6, or a warning that names the dofs; never silent."""

import numpy as np
import pytest

import antires_rs as ar
from tests.models.shared import quietly, warned

flint = pytest.importorskip("flint", reason="python-flint is not installed: no exact determinants")

#: The limits were set on ties of 1e12, 1e15 and 1e20, and are judged on the others too.
EXPONENTS = range(9, 26)
SECTION = ar.Rectangle(0.03, 0.05, 2.1e11, 7850.0)
GROUND = 1e3


def assembled(n, springs, ground):
    """Stiffness of springs (dof, dof, N/m) and of those to ground (dof, N/m)."""
    k = np.zeros((n, n))
    for a, b, value in springs:
        k[[a, b], [a, b]] += value
        k[[a, b], [b, a]] -= value
    for dof, value in ground:
        k[dof, dof] += value
    return k


def row(n, spring):
    return [(i, i + 1, spring) for i in range(n - 1)]


def cantilever(spring, n=12):
    nodes = [(0.25 * i, 0.0) for i in range(n + 1)]
    springs = [(0, d, spring) for d in ("u", "v", "theta")]
    return ar.FrameModel(nodes, [(i, i + 1) for i in range(n)], SECTION, ground_springs=springs)


def chain(tie):
    return ar.MassSpringChain([1.0, 0.5, 0.7, 1.2, 0.8], [4e4, tie, 6e4, 5e4], ground_first_n_per_m=3e4)


def tied_chain(tie):
    rng = np.random.default_rng(1)
    springs = rng.uniform(3e4, 8e4, 29)
    springs[[12, 21]] = tie
    return ar.MassSpringChain(rng.uniform(0.5, 2.0, 30), springs, ground_first_n_per_m=3e4)


def is_root(k, m, hz, ends=(None, None), within=1e-6):
    """Whether det(K - x M), without the row and column of its ends, changes its sign: by 600 bits."""
    k, m = (np.asarray(a.toarray() if hasattr(a, "toarray") else a) for a in (k, m))
    rows, columns = ([i for i in range(len(k)) if i != end] for end in ends)
    flint.ctx.prec = 600

    def determinant(step):
        x = (2 * flint.arb.pi() * float(hz) * (1 + flint.arb(step))) ** 2
        entries = [[flint.arb(float(k[i, j])) - x * float(m[i, j]) for j in columns] for i in rows]
        return flint.arb_mat(entries).det()

    below, above = determinant(-within), determinant(within)
    return below * above < 0


def assert_roots(model, k, m, *ends):
    lowest = [(pair, hz) for pair in ends for hz in model.antiresonances(*pair)[:2]]
    assert lowest
    assert all(is_root(k, m, hz, pair) for pair, hz in lowest)


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
    model, said = warned(lambda: make(10.0**power))
    k, m = model.stiffness(), model.mass()
    if of_matrices:
        model, said = warned(lambda: ar.MatrixModel(k, m))
    assert len(said) == (power >= told_from)
    if said:
        assert named[of_matrices] in said[0]
        assert "rounding may take 1e-6" in said[0]
        assert not of_matrices or "constraints=" in said[0]
        return
    assert all(is_root(k, m, hz) for hz in model.modes(n_modes=2).freq_hz[:2])
    assert_roots(model, k, m, (ends[0], ends[0]), ends)


def slabs(tie):
    """Four of three nodes, on columns: every dof is in a tie."""
    ties = [(3 * s + c, 3 * s + c + 1, tie) for s in range(4) for c in range(2)]
    columns = [(3 * s + c, 3 * s + c + 3, 1e7) for s in range(3) for c in range(3)]
    return assembled(12, ties + columns, [(c, 1e7) for c in range(3)]), 1e3 * np.eye(12)


def pairs(tie):
    return assembled(4, [(0, 1, tie), (1, 2, 1e4), (2, 3, tie)], [(0, 1e4)]), np.eye(4)


@pytest.mark.parametrize("power", EXPONENTS)
@pytest.mark.parametrize("make", [slabs, pairs])
def test_ties_on_most_dofs_are_right_or_told(make, power):
    k, m = make(10.0**power)
    model, said = warned(lambda: ar.MatrixModel(k, m))
    assert power >= 11 or not said
    assert power < 16 or said
    if not said:
        assert_roots(model, k, m, (len(k) - 1, len(k) - 1), (0, len(k) - 1))


def turned_bar():
    """Along and across a free bar couplings are those of an angle of 1e-16."""
    along, across = (assembled(20, row(20, stiffness), []) for stiffness in (1e9, 1e6))
    ar.MatrixModel(np.block([[along, 1e-16 * along], [1e-16 * along, across]]), np.eye(40))


def unlike_members():
    sections = [ar.Rectangle(0.5, 0.8, 2.1e11, 7850.0), ar.Rectangle(0.004, 0.004, 3e9, 1200.0)]
    ar.FrameModel([(0, 0), (1, 0), (9, 0)], [(0, 1), (1, 2)], sections, fixed=[0])


def free_bodies_and_usual_supports():
    rng = np.random.default_rng(5)
    for scale in (1.0, 1e12):
        springs = scale * rng.uniform(1.0, 9.0, 11)
        ar.MassSpringChain(np.ones(12), springs, ground_last_n_per_m=1e-6 * scale)
        free = ar.MassSpringChain(np.ones(12), springs).stiffness()
        ar.MatrixModel(free, np.eye(12))
        turned = np.linalg.qr(rng.normal(size=(12, 12)))[0]
        ar.MatrixModel(turned.T @ free @ turned, np.eye(12))


@pytest.mark.parametrize("make", [turned_bar, unlike_members, free_bodies_and_usual_supports])
def test_of_what_is_no_penalty_nothing_is_said(make):
    assert warned(make)[1] == []


# -- All dofs tied together, on soft springs to ground
def tied(n, tie):
    """Masses in a row tied to each other, each on a spring; and the frequency as of one body."""
    k = assembled(n, row(n, tie), [(i, GROUND * (1.0 + 0.1 * i)) for i in range(n)])
    masses = np.arange(1.0, n + 1.0)
    return k, np.diag(masses), np.sqrt(GROUND * (1.0 + 0.05 * (n - 1)) * n / masses.sum()) / (2.0 * np.pi)


@pytest.mark.parametrize("n", [2, 5, 9, 30])
@pytest.mark.parametrize("power", range(11, 26))
def test_masses_tied_together_on_soft_springs(n, power):
    k, m, as_one_hz = tied(n, 10.0**power)
    model, words = warned(lambda: ar.MatrixModel(k, m))
    freq_hz = model.modes(f_max_hz=100.0).freq_hz
    wrong = freq_hz.size == 0 or abs(freq_hz[0] / as_one_hz - 1.0) > 1e-6
    assert words or not wrong
    assert all("dof 0, dof 1" in each for each in words)
    assert all("move as one" in each or "nothing holds" in each for each in words)
    assert power < 13 or words


def test_supports_that_ties_have_rounded_away_are_told_with_their_size():
    k, m, _ = tied(5, 1e20)
    assert not k.sum(axis=1).any()  # the supports are gone
    _, (words,) = warned(lambda: ar.MatrixModel(k, m))
    assert "nothing holds dof 0, dof 1, dof 2, dof 3, dof 4" in words
    assert "softer than 2e+04 are rounded away" in words
    # Turned axes, as of members that are inclined.
    turn = np.kron(np.eye(5), np.linalg.qr(np.random.default_rng(3).normal(size=(2, 2)))[0])
    inclined = turn.T @ np.kron(k, np.diag([1.0, 0.5])) @ turn
    _, words = warned(lambda: ar.MatrixModel(inclined, np.kron(m, np.eye(2))))
    assert any("nothing holds" in each or "move as one" in each for each in words)


def test_ties_that_are_held_and_free_bodies_are_not_told_as_free():
    held = assembled(4, row(4, 1e20), [(0, 1e20)])
    # Supports through springs that stand apart from the ties in the sums.
    apart = assembled(6, [*row(4, 1e20), (4, 5, 1e3)], [(0, 1e20), (4, 1e3)])
    free = assembled(5, row(5, 1e6), [])
    for k in (held, apart, free, 1e9 * free):
        _, words = warned(lambda k=k: ar.MatrixModel(k, np.eye(len(k))))
        assert not any("nothing holds" in each for each in words)


@pytest.mark.parametrize("of_mass", [False, True])
def test_modes_of_a_diagonal_pair_over_many_decades_are_right_or_told(of_mass):
    graded, ones = np.diag(10.0 ** np.arange(-12.0, 13.0)), np.eye(25)
    pair = (ones, graded) if of_mass else (graded, ones)
    exact = np.sort(np.sqrt(np.diag(pair[0]) / np.diag(pair[1]))) / (2.0 * np.pi)
    modes, words = warned(quietly(ar.MatrixModel, *pair).modes)
    np.testing.assert_allclose(modes.freq_hz, exact[: modes.freq_hz.size], rtol=1e-6)
    assert modes.freq_hz.size == 25 or ("are left out" in words[0] and "dof" in words[0])
    modes, words = warned(ar.MatrixModel(graded[9:16, 9:16], np.eye(7)).modes)
    assert modes.freq_hz.size == 7
    assert not words
