"""Beams with shear and rotary inertia, against the exact solution of Timoshenko's equations."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

import antires_rs as ar
from tests.models.shared import same_matrices
from tests.support.refusals import assert_refused
from tests.support.tolerances import ROUNDING

E, RHO, NU = 2.1e11, 7850.0, 0.3
STEEL = (E, RHO, NU)
WIDTH, HEIGHT, LENGTH = 0.03, 0.08, 0.8
KAPPA = 10 * (1 + NU) / (12 + 11 * NU)
BAR = ar.Rectangle(WIDTH, HEIGHT, *STEEL, shear_coefficient="cowper")
CLAMPED, FREE, PINNED = (0, 1), (2, 3), (0, 2)  #: State at either end, (w, psi, M, Q): which entries vanish.


def exact_hz(left, right, count, area, inertia, kappa=KAPPA, length=LENGTH):
    """Frequencies of a Timoshenko beam, from the state (w, psi, M, Q) along it.

    w' = psi + Q / kGA, psi' = M / EI, M' = -Q - rho I om^2 psi, Q' = -rho A om^2 w: the state at the far end
    is expm(A L) times that at the near end, and what both supports leave has a solution where the 2 x 2
    determinant vanishes.
    """
    shear = kappa * E / (2 * (1 + NU)) * area

    def determinant(freq):
        w2 = (2 * np.pi * freq) ** 2
        slope = np.zeros((4, 4))
        slope[0, 1], slope[0, 3] = 1.0, 1.0 / shear
        slope[1, 2] = 1.0 / (E * inertia)
        slope[2, 1], slope[2, 3] = -RHO * inertia * w2, -1.0
        slope[3, 0] = -RHO * area * w2
        scale = np.array([1.0, 1.0 / length, E * inertia / length**2, E * inertia / length**3])
        along = expm(slope * scale / scale[:, None] * length)
        return np.linalg.det(along[np.ix_(right, np.setdiff1d(range(4), left))])

    grid = np.geomspace(20.0, 20e3, 800)
    changes = np.flatnonzero(np.diff(np.sign([determinant(f) for f in grid])))
    return np.array([brentq(determinant, *grid[at : at + 2], xtol=1e-12) for at in changes[:count]])


def beam(n, section, fixed=(), space=False, **options):
    nodes = np.zeros((n + 1, 3 if space else 2))
    nodes[:, 0] = np.linspace(0.0, LENGTH, n + 1)
    held = [(node, "u") for node in range(n + 1)]
    return ar.FrameModel(nodes, [(i, i + 1) for i in range(n)], section, fixed=[*held, *fixed], **options)


def elastic(model, count):
    freq = model.modes().freq_hz
    return freq[freq > 1.0][:count]


SUPPORTS = {"cantilever": (CLAMPED, FREE, lambda n: [(0, "v"), (0, "theta")])}
SUPPORTS |= {"free": (FREE, FREE, lambda n: []), "pinned": (PINNED, PINNED, lambda n: [(0, "v"), (n, "v")])}
SUPPORTS |= {"clamped and pinned": (CLAMPED, PINNED, lambda n: [(0, "v"), (0, "theta"), (n, "v")])}


@pytest.mark.parametrize("name", SUPPORTS)
def test_frequencies_converge_to_the_exact_ones(name):
    left, right, fixed = SUPPORTS[name]
    exact = exact_hz(left, right, 4, WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12)
    errors = np.array([elastic(beam(n, BAR, fixed(n)), 4) / exact - 1.0 for n in (8, 16, 32)])
    # A consistent mass is a Rayleigh quotient of the exact energies: never too low.
    assert errors.min() > -1e-9
    assert np.all(np.log2(errors[:-1] / errors[1:]) > 1.9)  # Elements short against the height: second order.
    assert errors[-1].max() < 1e-2
    # Without shear the same beam is far off: the test can fail.
    stiff = elastic(beam(32, ar.Rectangle(WIDTH, HEIGHT, *STEEL), fixed(32)), 4) / exact - 1.0
    assert np.all(stiff > [4e-3, 0.03, 0.06, 0.1])


def test_in_space_each_plane_has_its_own_inertia_and_coefficient():
    area, across, along = 1.2e-3, 4e-7, 9e-7
    shear = {"shear_coefficient": 0.8, "shear_coefficient_y": 0.4}
    section = ar.Section(area, along, E, RHO, inertia_y_m4=across, torsion_m4=1e-6, **shear)
    n = 40
    twist = [(node, "rx") for node in range(n + 1)]
    for held, inertia, kappa in (("vz", across, 0.4), ("wy", along, 0.8)):
        # The height points along z: bending in the plane x-z has the first inertia.
        plane = [(node, held[0]) for node in range(n + 1)] + [(node, "r" + held[1]) for node in range(n + 1)]
        other = "w" if held == "vz" else "v"
        clamp = [(0, other), (0, "ry" if other == "w" else "rz")]
        model = beam(n, section, [*twist, *plane, *clamp], space=True, orientation=[0.0, 1.0, 0.0])
        exact = exact_hz(CLAMPED, FREE, 3, area, inertia, kappa)
        np.testing.assert_allclose(elastic(model, 3), exact, rtol=6e-4)


@pytest.mark.parametrize(
    ("shape", "kappa"),
    [(ar.Tube(0.08, 0.04, *STEEL, shear_coefficient="cowper"), 6 * (1 + NU) / (7 + 6 * NU)), (BAR, KAPPA)],
)
def test_cowpers_coefficient_is_that_of_the_shape(shape, kappa):
    named, given = beam(3, shape), beam(3, replace(shape, shear_coefficient=kappa))
    same_matrices(named, given, within=10 * ROUNDING)
    assert named.sections[0] == shape  # and comes back as it was given
    thin, thick = (ar.Tube(0.08, wall, *STEEL, shear_coefficient="cowper") for wall in (0.004, 0.006))
    updated = beam(5, thin).with_parameters(ar.thickness(0, bounds=(0.002, 0.01)), [0.006])
    same_matrices(updated, beam(5, thick), within=0.0)


@pytest.mark.parametrize("coefficient", [0.0, -0.5, float("nan"), "mindlin", "cowper"])
def test_coefficients_that_are_none(coefficient):
    if coefficient == "cowper":  # of a section whose shape is not known
        section = ar.Section(1e-4, 8e-10, *STEEL[:2], shear_coefficient=coefficient)
    else:
        section = ar.Rectangle(WIDTH, HEIGHT, *STEEL, shear_coefficient=coefficient)
    assert_refused("sections[0].shear_coefficient", lambda: beam(2, section))
