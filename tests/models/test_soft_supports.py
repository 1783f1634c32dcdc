"""All dofs tied together, on soft springs to ground: right or told."""

import warnings

import numpy as np
import pytest

import antires_rs as ar

GROUND = 1e3


def tied(n, tie):
    """Masses in a row tied to each other, each on a spring; and the frequency as of one body."""
    k = np.diag(GROUND * (1.0 + 0.1 * np.arange(n)))
    for i in range(n - 1):
        k[i : i + 2, i : i + 2] += tie * np.array([[1.0, -1.0], [-1.0, 1.0]])
    masses = np.arange(1.0, n + 1.0)
    return k, np.diag(masses), np.sqrt(GROUND * (1.0 + 0.05 * (n - 1)) * n / masses.sum()) / (2.0 * np.pi)


def told(make):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        made = make()
    return made, [str(each.message) for each in caught]


@pytest.mark.parametrize("n", [2, 5, 9, 30])
@pytest.mark.parametrize("power", range(11, 26))
def test_masses_tied_together_on_soft_springs(n, power):
    k, m, as_one_hz = tied(n, 10.0**power)
    model, words = told(lambda: ar.MatrixModel(k, m))
    freq_hz = model.modes(f_max_hz=100.0).freq_hz
    wrong = freq_hz.size == 0 or abs(freq_hz[0] / as_one_hz - 1.0) > 1e-6
    assert words or not wrong
    assert all("dof 0, dof 1" in each for each in words)
    assert all("move as one" in each or "nothing holds" in each for each in words)
    if power >= 13:
        assert words


def test_supports_that_ties_have_rounded_away_are_told_with_their_size():
    k, m, _ = tied(5, 1e20)
    assert not k.sum(axis=1).any()  # the supports are gone
    _, words = told(lambda: ar.MatrixModel(k, m))
    assert len(words) == 1
    assert "nothing holds dof 0, dof 1, dof 2, dof 3, dof 4" in words[0]
    assert "softer than 2e+04 are rounded away" in words[0]
    # Turned axes, as of members that are inclined.
    turn = np.kron(np.eye(5), np.linalg.qr(np.random.default_rng(3).normal(size=(2, 2)))[0])
    inclined = turn.T @ np.kron(k, np.diag([1.0, 0.5])) @ turn
    _, words = told(lambda: ar.MatrixModel(inclined, np.kron(m, np.eye(2))))
    assert any("nothing holds" in each or "move as one" in each for each in words)


def test_ties_that_are_held_and_free_bodies_are_not_told_as_free():
    ties, _, _ = tied(4, 1e20)
    held = ties + np.diag([1e20, 0.0, 0.0, 0.0])
    # Supports at a dof of its own, and through springs that stand apart from the ties in the sums.
    apart = np.zeros((6, 6))
    apart[:4, :4] = held
    apart[4:, 4:] = 1e3 * np.array([[2.0, -1.0], [-1.0, 2.0]])
    free = ar.MassSpringChain(np.ones(5), np.full(4, 1e6)).stiffness()
    for k in (held, apart, free, 1e9 * free):
        _, words = told(lambda k=k: ar.MatrixModel(k, np.eye(len(k))))
        assert not any("nothing holds" in each for each in words)


@pytest.mark.parametrize("power", [13, 17, 21, 25])
def test_a_chain_knows_its_springs(power):
    chain = [1.0, 2.0, 3.0], [10.0**power, 3.0 * 10.0**power]
    with pytest.warns(ar.AntiresWarning, match="mass 0, mass 1, mass 2 move as one"):
        ar.MassSpringChain(*chain, ground_first_n_per_m=GROUND)


def test_free_bodies_and_usual_supports_are_not_told():
    rng = np.random.default_rng(5)
    for scale in (1.0, 1e12):
        springs = scale * rng.uniform(1.0, 9.0, 11)
        ar.MassSpringChain(np.ones(12), springs)
        ar.MassSpringChain(np.ones(12), springs, ground_last_n_per_m=1e-6 * scale)
        free = ar.MassSpringChain(np.ones(12), springs).stiffness()
        ar.MatrixModel(free, np.eye(12))
        turned = np.linalg.qr(rng.normal(size=(12, 12)))[0]
        ar.MatrixModel(turned.T @ free @ turned, np.eye(12))


@pytest.mark.parametrize("of_mass", [False, True])
def test_modes_of_a_diagonal_pair_over_many_decades_are_right_or_told(of_mass):
    graded, ones = np.diag(10.0 ** np.arange(-12.0, 13.0)), np.eye(25)
    pair = (ones, graded) if of_mass else (graded, ones)
    exact = np.sort(np.sqrt(np.diag(pair[0]) / np.diag(pair[1]))) / (2.0 * np.pi)
    model, _ = told(lambda: ar.MatrixModel(*pair))
    modes, words = told(model.modes)
    np.testing.assert_allclose(modes.freq_hz, exact[: modes.freq_hz.size], rtol=1e-6)
    assert modes.freq_hz.size == 25 or ("are left out" in words[0] and "dof" in words[0])
    near = ar.MatrixModel(graded[9:16, 9:16], np.eye(7))
    modes, words = told(near.modes)
    assert modes.freq_hz.size == 7
    assert not words
