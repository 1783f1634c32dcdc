"""Lengths and positions as parameters: what moves, by how much, and how the antiresonances follow."""

import re

import numpy as np
import pytest

import antires_rs as ar
from antires_rs import exceptions
from antires_rs.updating.identifiability import identifiability
from tests.support.tolerances import FOUND_AGAIN, ROUNDING

STEEL = (2.1e11, 7850.0)
NODES = np.array([(0.0, 0.0), (0.4, 0.0), (0.8, 0.0), (1.1, 0.3), (1.4, 0.6), (0.8, -0.5)])
PAIRS = [(0, 1), (1, 2), (2, 3), (3, 4), (2, 5)]


def frame(nodes=NODES, pairs=PAIRS, **options):
    return ar.FrameModel(nodes, pairs, ar.Tube(0.04, 0.002, *STEEL), **options)


def same(one, other):
    for a, b in ((one.stiffness(), other.stiffness()), (one.mass(), other.mass())):
        assert abs(a - b).max() <= 100 * ROUNDING * abs(b).max()


def test_a_length_moves_the_far_ends_and_all_beyond():
    longer = frame().with_parameters(ar.length([1, 2], pivot=1, bounds=(0.8, 1.2)), [1.1])
    nodes = NODES.copy()
    nodes[[2, 3, 4, 5]] += [0.04, 0.0]  # element 2, and the branch at its end
    nodes[[3, 4]] += [0.03, 0.03]  # element 3
    np.testing.assert_allclose(longer.nodes_m, nodes, atol=1e-15)
    same(longer, frame(nodes))
    # From the other end it is the near side that moves.
    back = frame().with_parameters(ar.length([1, 2], pivot=3, bounds=(0.8, 1.2)), [1.1])
    np.testing.assert_allclose(back.nodes_m, nodes - [0.07, 0.03], atol=1e-15)


def test_lengths_and_positions_act_in_their_order():
    parameters = [
        ar.angle([2, 3], 2, bounds_deg=(-90, 90)),
        ar.length(2, pivot=2, bounds=(0.5, 2.0)),
        ar.position([0, 5], "y", bounds_m=(-0.1, 0.1), together=True),
        ar.position(0, (3.0, 4.0, 0.0), bounds_m=(-0.1, 0.1)),
    ]
    moved = frame().with_parameters(parameters, [45.0, 2.0, 0.05, 0.05])
    # Elements 2 and 3 point up now; element 2 is twice as long.
    side = np.hypot(0.3, 0.3)
    nodes = [(0.03, 0.09), (0.4, 0.0), (0.8, 0.0), (0.8, 2 * side), (0.8, 3 * side), (0.8, -0.45)]
    np.testing.assert_allclose(moved.nodes_m, nodes, atol=1e-15)
    problem = ar.UpdatingProblem(frame(), parameters, ar.AntiresonanceSet(4, {4: [50.0]}))
    assert problem.nominal.tolist() == [0.0, 1.0, 0.0, 0.0]
    assert problem.names[1:] == [
        "length of element 2 from node 2",
        "position of node 0, node 5 along (0, 1, 0) (m)",
        "position of node 0 along (0.6, 0.8, 0) (m)",
    ]


def test_a_loop_moves_by_position_only():
    closed = frame(pairs=[*PAIRS, (4, 5)])
    with pytest.raises(exceptions.InvalidInputError, match=r"^elements: got a group in a loop"):
        closed.with_parameters(ar.length(3, pivot=3, bounds=(0.9, 1.1)), [1.05])
    # A loop that moves along as a whole is none of its business.
    shifted = closed.with_parameters(ar.length([0, 1], pivot=0, bounds=(0.9, 1.1)), [1.05])
    np.testing.assert_allclose(shifted.nodes_m[2:], NODES[2:] + [0.04, 0.0], atol=1e-15)
    moved = closed.with_parameters(ar.position(4, "x", bounds_m=(-0.1, 0.1)), [0.05])
    same(moved, frame(NODES + np.eye(6)[4][:, None] * [0.05, 0.0], [*PAIRS, (4, 5)]))


# ---- derivatives ---------------------------------------------------------------------------------------


def bending_matrices(lengths, area, inertia, shear, rotary):
    """K and M of clamped collinear elements in bending, (2 n, 2 n), also for complex lengths.

    A beam with shear by its flexibility and its shape functions, integrated by Gauss's rule: not the formulas
    of the core.
    """
    n = len(lengths)
    k_all, m_all = (np.zeros((2 * n + 2, 2 * n + 2), dtype=complex) for _ in range(2))
    points, weights = np.polynomial.legendre.leggauss(6)
    for i, length in enumerate(lengths):
        bend = STEEL[0] * inertia
        # Deflection v and rotation t at the tip under a force and a moment there.
        flexible = np.array(
            [
                [length**3 / (3 * bend) + length / shear, length**2 / (2 * bend)],
                [length**2 / (2 * bend), length / bend],
            ]
        )
        tip = np.linalg.inv(flexible)
        near = -np.array([[1.0, 0.0], [length, 1.0]]) @ tip
        stiffness = np.block([[-near @ np.array([[1.0, length], [0.0, 1.0]]), near], [near.T, tip]])
        mass = np.zeros((4, 4), dtype=complex)
        for point, weight in zip(points, weights, strict=True):
            x = 0.5 * length * (1.0 + point)
            # What the element does at x when its ends move: rigid part, and bent from the near end.
            part = np.array(
                [[x**3 / (3 * bend) + x / shear, x**2 / (2 * bend)], [x**2 / (2 * bend), x / bend]]
            )
            load = np.array([[1.0, 0.0], [length - x, 1.0]])
            ends = np.hstack([-np.array([[1.0, length], [0.0, 1.0]]), np.eye(2)])
            rigid = np.hstack([np.array([[1.0, x], [0.0, 1.0]]), np.zeros((2, 2))])
            shape = rigid + part @ load @ tip @ ends
            inertias = np.diag([STEEL[1] * area, rotary])
            mass += 0.5 * length * weight * shape.T @ inertias @ shape
        at = np.ix_(range(2 * i, 2 * i + 4), range(2 * i, 2 * i + 4))
        k_all[at] += stiffness
        m_all[at] += mass
    return k_all[2:, 2:], m_all[2:, 2:]


LENGTHS = np.array([0.3, 0.2, 0.25])
MOVES = {
    "a length": (ar.length([1], pivot=1, bounds=(0.8, 1.2)), 1.07, lambda p: np.array([0.3, 0.2 * p, 0.25])),
    "all lengths": (ar.length([0, 1, 2], pivot=0, bounds=(0.8, 1.2)), 0.94, lambda p: LENGTHS * p),
    "a position": (
        ar.position(1, "x", bounds_m=(-0.1, 0.1)),
        0.03,
        lambda p: np.array([0.3 + p, 0.2 - p, 0.25]),
    ),
}


@pytest.mark.parametrize("kappa", [None, 0.85])
@pytest.mark.parametrize("name", MOVES)
def test_derivatives_against_a_complex_step(name, kappa):
    parameter, at, lengths_of = MOVES[name]
    width, height = 0.02, 0.06
    area, inertia = width * height, width * height**3 / 12
    shear = 1e300 if kappa is None else kappa * STEEL[0] / 2.6 * area
    rotary = 0.0 if kappa is None else STEEL[1] * inertia
    nodes = np.c_[np.r_[0.0, np.cumsum(LENGTHS)], np.zeros(4)]
    section = ar.Rectangle(width, height, *STEEL, shear_coefficient=kappa)
    held = [(0, "v"), (0, "theta"), *((i, "u") for i in range(4))]
    model = ar.FrameModel(nodes, [(0, 1), (1, 2), (2, 3)], section, fixed=held)
    formed = model.with_parameters(parameter, [at])
    k, m = bending_matrices(lengths_of(at), area, inertia, shear, rotary)
    np.testing.assert_allclose(formed.stiffness().toarray(), k.real, rtol=1e-10, atol=1e-10 * abs(k).max())
    np.testing.assert_allclose(formed.mass().toarray(), m.real, rtol=1e-10, atol=1e-10 * abs(m).max())

    response, force = 2, 4
    zeros = formed.antiresonances(response, force)[:2]
    target = ar.AntiresonanceSet(force, {response: zeros})
    problem = ar.UpdatingProblem(model, parameter, target)
    # Sensitivities are those of the squares, over the measured ones, times the width of the bounds.
    low, high = parameter.bounds
    seen = identifiability(problem, [at]).sensitivity[0] / (high - low)

    step = 1e-30
    k, m = bending_matrices(lengths_of(at + 1j * step), area, inertia, shear, rotary)
    k, m = (np.delete(np.delete(a, response, 0), force, 1) for a in (k, m))
    slopes = []
    for zero in (2 * np.pi * zeros) ** 2:
        pencil = k - zero * m
        left, _, right = np.linalg.svd(pencil.real)
        u, v = left[:, -1], right[-1]
        slopes.append((u @ pencil.imag @ v) / step / (u @ m.real @ v) / zero)
    # `identifiability` takes central differences over 1e-5 of the width: some 1e-8 of truncation.
    assert seen == pytest.approx(np.linalg.norm(slopes), rel=1e-7)


def test_an_update_finds_a_length_and_a_position_again():
    truth, sensors = [1.06, -0.04], [4, 7, 13, 16]
    parameters = [ar.length([0, 1], pivot=0, bounds=(0.9, 1.1)), ar.position(3, "y", bounds_m=(-0.1, 0.1))]
    nodes = NODES.copy()
    nodes[2:] += [0.06 * 0.8, 0.0]
    nodes[1] += [0.06 * 0.4, 0.0]
    nodes[3] += [0.0, -0.04]
    zeros = frame(nodes).antiresonances(sensors, 4, f_max_hz=400.0)
    measured = ar.AntiresonanceSet(4, dict(zip(sensors, zeros, strict=True)))
    result = ar.update(ar.UpdatingProblem(frame(), parameters, measured), rng=0)
    np.testing.assert_allclose(result.x, truth, atol=FOUND_AGAIN)


def problem(parameter, model=None):
    zeros = ar.AntiresonanceSet(4, {4: [50.0]})
    return lambda: ar.UpdatingProblem(model or frame(), [parameter], zeros)


WRONG = {
    "not positive": ("bounds[0]", lambda: ar.length(0, 0, bounds=(0.0, 1.0))),
    "no pivot": ("pivot", lambda: ar.length(0, None, bounds=(0.9, 1.1))),
    "pivot away": ("pivot", problem(ar.length(3, 0, bounds=(0.9, 1.1)))),
    "unknown axis": ("direction", lambda: ar.position(0, "r", bounds_m=(-0.1, 0.1))),
    "no direction": ("direction", lambda: ar.position(0, (0, 0, 0), bounds_m=(-0.1, 0.1))),
    "a node twice": ("nodes", lambda: ar.position([1, 1], "x", bounds_m=(-0.1, 0.1))),
    "node outside": ("parameters[0]", problem(ar.position(9, "x", bounds_m=(-0.1, 0.1)))),
    "out of the plane": ("parameters[0]", problem(ar.position(1, "z", bounds_m=(-0.1, 0.1)))),
    "onto the neighbour": ("bounds", problem(ar.position(1, "x", bounds_m=(-0.5, 0.1)))),
    "no frame": (
        "parameters[0]",
        problem(ar.position(1, "x", bounds_m=(-0.1, 0.1)), ar.MassSpringChain([1.0] * 6, [1e6] * 5)),
    ),
    "no frame's length": (
        "parameters[0]",
        problem(ar.length(1, 1, bounds=(0.9, 1.1)), ar.MassSpringChain([1.0] * 6, [1e6] * 5)),
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_moves_that_are_none(name):
    argument, call = WRONG[name]
    with pytest.raises(exceptions.InvalidInputError, match=rf"^{re.escape(argument)}: got .*; wanted "):
        call()
