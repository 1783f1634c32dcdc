"""The simulators of reference/outside_structures.py: other routes find the same zeros, and what they lack."""

import numpy as np
import pytest
import scipy.linalg
from scipy.optimize import brentq

from reference.outside_cases import KINDS, OUTSIDE, STD, case, kinds_of
from reference.outside_structures import (
    STRUCTURES,
    Building,
    Cantilever,
    Crack,
    Grillage,
    Own,
    Pipe,
    Portal,
    State,
)


def nominal(structure):
    return Own(np.ones(structure.n_elements), np.ones(structure.n_elements), np.ones(12))


def changed(kind, **values):
    """A structure with other constants."""
    return type(kind.__name__, (kind,), values)()


def by_qz(one, read, drive, band_hz):
    """Zeros of the quadratic pencil with the rows of sensor and force deleted."""

    def deleted(matrix):
        return np.delete(np.delete(matrix, one.rows[drive], 0), one.rows[read], 1)

    k, m, c = map(deleted, (one.stiffness, one.mass, one.damping))
    zero, unit = np.zeros_like(k), np.eye(len(k))
    # In units of the middle of the band, so that QZ sees parts of one size.
    size = 2.0 * np.pi * np.mean(band_hz)
    scale = np.abs(k).max()
    a = np.block([[zero, unit], [-k / scale, -c * size / scale]])
    b = np.block([[unit, zero], [zero, m * size**2 / scale]])
    upper, lower = scipy.linalg.eig(a, b, right=False, homogeneous_eigvals=True)
    finite = np.abs(lower) > 1e-12 * np.abs(upper)
    s = size * upper[finite] / lower[finite]
    kept = (s.imag > 0.0) & (np.abs(s.real) <= (0.1 if c.any() else 1e-6) * np.abs(s))
    freq = np.sort(np.abs(s[kept])) / (2.0 * np.pi)
    return freq[(freq >= band_hz[0]) & (freq <= band_hz[1])]


@pytest.mark.parametrize("name", list(STRUCTURES))
def test_qz_of_the_deleted_pencil_finds_the_same_zeros(name):
    structure = STRUCTURES[name]
    rng = np.random.default_rng(5)
    one = structure.assembled(structure.drawn(rng), State(losses={2: 0.3}))
    (drive,) = structure.drive
    for position in range(0, len(structure.dofs), 3):
        weights = structure.sensor(position, False)
        (read,) = weights
        (found,) = one.antiresonances([weights], structure.drive, structure.band_hz, hidden=0.0)
        np.testing.assert_allclose(found, by_qz(one, read, drive, structure.band_hz), rtol=1e-6)


def exact_sign(structure, at_m, crack):
    """Of the response at a place to a force at the tip, by the exact solution of Timoshenko's equations.

    The state (w, psi, M, Q) is carried along by matrix exponentials: psi jumps by M / k in the hinge, Q by
    k w at the spring; clamped at one end, no moment at the other.
    """
    section = structure.section
    ei, shear, per_m = section.ei, section.shear, section.rho * section.area_m2
    rotary = section.rho * section.width_m * section.height_m**3 / 12.0
    length = 0.1
    hinge_at, spring_at = length * (crack.element + crack.share), length * structure.spring_at
    jumps = {hinge_at: np.eye(4), spring_at: np.eye(4)}
    jumps[hinge_at][1, 2] = 1.0 / section.hinge_n_m(length, crack.loss)
    jumps[spring_at][3, 0] = structure.spring * 3.0 * ei

    def determinant(freq):
        w2 = (2.0 * np.pi * freq) ** 2
        slope = np.zeros((4, 4))
        slope[0, 1], slope[0, 3] = 1.0, 1.0 / shear
        slope[1, 2] = 1.0 / ei
        slope[2, 1], slope[2, 3] = -rotary * w2, -1.0
        slope[3, 0] = -per_m * w2
        state, here, read = np.eye(4)[:, 2:], 0.0, None
        for place in sorted({hinge_at, spring_at, at_m, 1.0}):
            state = scipy.linalg.expm(slope * (place - here)) @ state
            state = jumps.get(place, np.eye(4)) @ state
            if place == at_m:
                read = state[0]
            here = place
        return np.linalg.det(np.stack([read, state[2]]))

    return determinant


@pytest.mark.parametrize("position", [2, 5, 7])
def test_a_cracked_cantilever_has_the_zeros_of_the_exact_solution(position):
    structure, crack = STRUCTURES["cantilever"], Crack(3, 0.3, 0.4)
    found = structure.truth(nominal(structure), State(cracks=(crack,)))[structure.dofs[position]]
    node, _ = structure.sensors[position]
    determinant = exact_sign(structure, 0.1 * node, crack)
    grid = np.geomspace(*structure.band_hz, 400)
    signs = np.sign([determinant(freq) for freq in grid])
    exact = np.array([brentq(determinant, *grid[at : at + 2]) for at in np.flatnonzero(np.diff(signs))])
    # Twenty cubic elements: (beta h)^4 / 1440 of the sixth mode.
    np.testing.assert_allclose(found, exact, rtol=4e-4)


def test_a_hinge_is_as_flexible_as_the_loss_it_stands_for():
    structure = changed(Cantilever, spring=0.0)

    def turned(state):
        one = structure.assembled(nominal(structure), state)
        moment = one.vector({(10, "theta"): 1.0})
        return moment @ np.linalg.solve(one.stiffness, moment)

    cracked = turned(State(cracks=(Crack(3, 0.3, 0.4),)))
    assert cracked == pytest.approx(turned(State(losses={3: 0.4})), rel=1e-9)
    assert cracked > 1.05 * turned(State())


#: By name: what must be changed for the truth to be its model, and by how much the lowest four resonances
#: differ at most then, and at least with what the model lacks.
LACKING = {
    "building": (
        changed(Building, base_n=(1e13, 1e16), base_c=(0.0, 0.0), of_mass=0.0, of_stiffness=0.0),
        1e-4,
        0.05,
    ),
    "portal": (changed(Portal, corner=1e6, foot=1e6), 0.01, 0.05),
    "cantilever": (changed(Cantilever, spring=0.0), 0.005, 0.1),
    "grillage": (changed(Grillage, corner_n_per_m=1e10, crossing_kg=0.0), 0.01, 0.015),
    "elastic_beam": (STRUCTURES["elastic_beam"], 0.005, 0.0),
    "truss": (STRUCTURES["truss"], 0.2, 0.03),
    "pipe": (changed(Pipe, flange=1e6), 0.025, 0.05),
}


@pytest.mark.parametrize("name", list(STRUCTURES))
def test_the_model_lacks_what_is_stated_and_nothing_else(name):
    structure = STRUCTURES[name]
    alike, most, least = LACKING[name]
    expected = structure.model.modes(4).freq_hz

    def off(one):
        return np.abs(one.assembled(nominal(one), State()).resonances_hz[:4] / expected - 1.0).max()

    assert off(alike) <= most
    assert off(structure) >= least
    off_by = structure.drawn(np.random.default_rng(0))
    assert 0.005 < off_by.stiffness.std() < 0.04
    assert 0.005 < off_by.mass.std() < 0.04


def test_a_warmer_beam_keeps_its_springs():
    structure = STRUCTURES["elastic_beam"]
    own = nominal(structure)
    cold, warm = (structure.assembled(own, State(warmer=(e, 0.0))).resonances_hz for e in (0.0, -0.03))
    # The lowest motions are those of the springs, the higher ones those of the beam.
    assert warm[0] / cold[0] - 1.0 == pytest.approx(0.0, abs=3e-3)
    assert warm[5] / cold[5] - 1.0 == pytest.approx(-0.015, abs=1e-3)


@pytest.mark.parametrize("name", list(STRUCTURES))
def test_cases_are_drawn_by_their_seed_and_say_what_is_right(name):
    structure = STRUCTURES[name]
    for kind in kinds_of(structure):
        one, again = case(name, kind, 1), case(name, kind, 1)
        assert one.state == again.state
        for dof in structure.dofs:
            np.testing.assert_array_equal(one.now[dof], again.now[dof])
            np.testing.assert_allclose(one.now.std_hz[dof], one.std * one.now[dof])
        assert STD[0] <= one.std <= STD[1]
        assert len(one.allowed) == {"single": 1, "double": 2, "crack": 1, "temperature": 1}.get(kind, 0)
        assert bool(one.change_in_std) == (kind != "intact")
        if kind in OUTSIDE:
            assert not one.losses


def test_a_crack_is_its_element_s_or_the_nearer_neighbour_s():
    found = case("cantilever", "crack", 0)
    (crack,), (allowed,) = found.state.cracks, found.allowed
    assert allowed <= {crack.element, crack.element + (1 if crack.share > 0.5 else -1)}
    assert crack.element in allowed
    assert set(KINDS) - set(kinds_of(STRUCTURES["truss"])) == {"crack"}
