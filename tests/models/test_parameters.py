"""Updating parameters: an updated model is the model built with these values, and a search finds them."""

from pathlib import Path

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.updating.identifiability import at_solution
from tests.models.shared import same_matrices
from tests.support.refusals import refused
from tests.support.snapshots import refusal, replay
from tests.support.tolerances import FOUND_AGAIN, ROUNDING, SOFT_ZERO

E, RHO = 2.1e11, 7850.0
NODES = np.array([(0.0, 0.0), (0.5, 0.02), (1.0, 0.0), (1.5, 0.1), (1.9, 0.3), (1.2, 0.5)])
ELEMENTS = [(0, 1, "pipe"), (1, 2, "pipe"), (2, 3, "bend"), (3, 4, "bend"), (2, 5, "arm")]
PAIRS = [pair[:2] for pair in ELEMENTS]
BOUNDS = (0.8, 1.2)
TURN, SHIFT = (-90, 90), (-0.1, 0.1)


def build(
    nodes=NODES, wall=0.0015, diameter=0.045, modulus=E, density=RHO, mass=1.5, inertia=0.01, hanger=2e3
):
    sections = {"pipe": ar.Tube(0.038, wall, modulus, RHO), "bend": ar.Tube(diameter, 0.002, E, RHO)}
    sections["arm"] = ar.Rectangle(0.02, 0.01, E, density)
    masses = [(3, mass, inertia), (5, 0.7)]
    springs = [(0, "v", hanger), (4, "v", hanger), (1, "u", 800.0)]
    return ar.FrameModel(nodes, ELEMENTS, sections, point_masses=masses, ground_springs=springs)


def bare(pairs=PAIRS):
    return ar.FrameModel(NODES, pairs, ar.Tube(0.038, 0.0015, E, RHO))


MODEL, LOOP = build(), bare([*PAIRS, (4, 5)])
CHAIN = ar.MassSpringChain(np.ones(18), np.full(17, 1e6))
SHAKER = MODEL.dof(1, "v")
SENSORS = [MODEL.dof(0, "v"), MODEL.dof(2, "v"), MODEL.dof(3, "v"), MODEL.dof(4, "u"), MODEL.dof(5, "v")]


def measured(model):
    zeros = model.antiresonances(SENSORS, SHAKER, f_max_hz=400.0)
    return ar.AntiresonanceSet(SHAKER, dict(zip(SENSORS, zeros, strict=True)))


MEASURED = measured(MODEL)


def rotated(degrees, moving, pivot):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    nodes = NODES.copy()
    nodes[moving] = NODES[pivot] + (NODES[moving] - NODES[pivot]) @ np.array([[c, s], [-s, c]])
    return nodes


def moved(nodes, by):
    new = NODES.copy()
    new[nodes] += by
    return {"nodes": new}


KINDS = [  #: Parameter, a value of it, the model built with that value, its nominal value.
    (ar.youngs_modulus("pipe", bounds=(1e11, 3e11)), 1.9e11, {"modulus": 1.9e11}, E),
    (ar.youngs_modulus(0, bounds=(1e11, 3e11)), 1.9e11, {"modulus": 1.9e11}, E),
    (ar.density("arm", bounds=(7e3, 9e3)), 8100.0, {"density": 8100.0}, RHO),
    (ar.thickness("pipe", bounds=(0.001, 0.003)), 0.0021, {"wall": 0.0021}, 0.0015),
    (ar.thickness("pipe", bounds=BOUNDS, relative=True), 1.1, {"wall": 1.1 * 0.0015}, 1.0),
    (ar.diameter("bend", bounds=(0.04, 0.05)), 0.043, {"diameter": 0.043}, 0.045),
    (ar.point_mass(0, bounds=(1.0, 2.0)), 1.9, {"mass": 1.9}, 1.5),
    (ar.inertia(0, bounds=(0.0, 0.1)), 0.03, {"inertia": 0.03}, 0.01),
    (ar.support_stiffness([0, 1], bounds=(0.0, 9e3), together=True), 3e3, {"hanger": 3e3}, 2e3),
    (ar.angle([2, 3], pivot=2, bounds_deg=TURN), 12.0, {"nodes": rotated(12.0, [3, 4], 2)}, 0.0),
    (ar.angle(1, 1, bounds_deg=TURN), -7.0, {"nodes": rotated(-7.0, [2, 3, 4, 5], 1)}, 0.0),
    (ar.length(2, pivot=2, bounds=BOUNDS), 1.1, moved([3, 4], [0.05, 0.01]), 1.0),
    (ar.length(2, pivot=3, bounds=BOUNDS), 1.1, moved([0, 1, 2, 5], [-0.05, -0.01]), 1.0),
    (ar.position([0, 5], "y", bounds_m=SHIFT, together=True), 0.05, moved([0, 5], [0.0, 0.05]), 0.0),
    (ar.position(0, (3.0, 4.0, 0.0), bounds_m=SHIFT), 0.05, moved(0, [0.03, 0.04]), 0.0),
]


@pytest.mark.parametrize(("parameter", "value", "changed", "nominal"), KINDS)
def test_each_kind_gives_the_model_built_with_the_value(parameter, value, changed, nominal):
    problem = ar.UpdatingProblem(MODEL, parameter, MEASURED)
    assert problem.nominal.tolist() == [nominal]
    assert problem.cost(problem.nominal) == 0.0
    updated, expected = problem.model_at([value]), build(**changed)
    same_matrices(updated, expected)
    np.testing.assert_allclose(updated.nodes_m, expected.nodes_m, atol=ROUNDING)
    assert problem.cost([value]) > 1e-6
    exact = ar.UpdatingProblem(MODEL, parameter, measured(expected))
    assert exact.cost([value]) < SOFT_ZERO * exact.measured_hz.size
    again = ar.UpdatingProblem(updated, parameter, MEASURED)
    if parameter.nominal is None:
        assert again.nominal.tolist() == [value]
    same_matrices(again.model_at(again.nominal), updated)


def test_parameters_of_a_chain_change_what_they_say():
    masses, springs = np.array([1.0, 2.0, 3.0]), np.array([100.0, 200.0])
    model = ar.MassSpringChain(masses, springs, ground_last_n_per_m=50.0)
    parameters = [
        *ar.stiffness_factor([0], bounds=BOUNDS),
        *ar.mass_factor([1], bounds=BOUNDS),
        *ar.stiffness_reduction([1]),
        ar.stiffness_factor(3, bounds=BOUNDS),
        ar.stiffness_factor([0, 1], bounds=BOUNDS, together=True),
    ]
    problem = ar.UpdatingProblem(model, parameters[:4], ar.AntiresonanceSet(0, {0: [1.0]}))
    direct = ar.MassSpringChain(masses * [1, 0.9, 1], springs * [1.1, 0.75], ground_last_n_per_m=60.0)
    same_matrices(problem.model_at([1.1, 0.9, 0.25, 1.2]), direct)
    same_matrices(problem.model_at(problem.nominal), model, within=0.0)
    named = "stiffness of spring 0, mass 1, stiffness loss of spring 1, stiffness of last ground spring"
    assert ", ".join(problem.names) == named
    both = model.with_parameters(parameters[4], [1.2])
    same_matrices(both, ar.MassSpringChain(masses, 1.2 * springs, ground_last_n_per_m=50.0))


def test_all_kinds_mix_with_terms_and_names_carry_units():
    terms = [*ar.stiffness_reduction([1, 4]), ar.stiffness_factor(5, bounds=BOUNDS)]
    terms += [ar.mass_factor(2, bounds=BOUNDS)]
    parameters = [*terms, *(KINDS[i][0] for i in (0, 2, 3, 5, 6, 7, 8, 9))]
    problem = ar.UpdatingProblem(MODEL, parameters, MEASURED, penalty=(0.1, 0.1))
    assert "; ".join(problem.names) == (
        "stiffness loss of element 1; stiffness loss of element 4; stiffness of ground spring 0 (node 0 v); "
        "mass of element 2; Young's modulus of pipe (Pa); density of arm (kg/m3); thickness of pipe (m); "
        "outer diameter of bend (m); mass 0 (node 3) (kg); inertia of mass 0 (node 3) (kg m2); "
        "stiffness of ground spring 0 (node 0 v), ground spring 1 (node 4 v) (N/m); "
        "angle of element 2, element 3 about node 2 (deg)"
    )
    x = problem.nominal
    x[:4], x[5], x[6], x[11] = [0.2, 0.1, 1.1, 0.9], 8000.0, 0.0012, 5.0
    updated = problem.model_at(x)
    assert updated.sections["arm"].density_kg_per_m3 == 8000.0
    assert updated.sections["pipe"].thickness_m == 0.0012
    assert updated.ground_springs[0].stiffness_n_per_m == pytest.approx(2200.0, rel=ROUNDING)
    rest = build(wall=0.0012, density=8000.0, nodes=rotated(5.0, [3, 4], 2))
    same_matrices(updated, rest.with_parameters(terms, x[:4]))
    grid = np.array([x, problem.nominal, x])
    np.testing.assert_array_equal(problem.evaluate_many(grid, workers=2), [problem.cost(row) for row in grid])
    assert MODEL.sections["pipe"].thickness_m == 0.0015  # the model itself is as it was


def test_moves_act_in_their_order_and_loops_move_as_a_whole():
    parameters = [
        ar.angle([2, 3], 2, bounds_deg=TURN),
        ar.length(2, pivot=2, bounds=(0.5, 2.0)),
        ar.position([0, 5], "y", bounds_m=SHIFT, together=True),
        ar.position(0, (3.0, 4.0, 0.0), bounds_m=SHIFT),
    ]
    found = MODEL.with_parameters(parameters, [45.0, 2.0, 0.05, 0.05])
    nodes = rotated(45.0, [3, 4], 2)
    nodes[[3, 4]] += nodes[3] - nodes[2]
    nodes[[0, 5], 1] += 0.05
    nodes[0] += [0.03, 0.04]
    np.testing.assert_allclose(found.nodes_m, nodes, atol=1e-15)
    assert ar.UpdatingProblem(MODEL, parameters, MEASURED).names[1:] == [
        "length of element 2 from node 2",
        "position of node 0, node 5 along (0, 1, 0) (m)",
        "position of node 0 along (0.6, 0.8, 0) (m)",
    ]
    longer = LOOP.with_parameters(ar.length([0], pivot=0, bounds=BOUNDS), [1.05])
    np.testing.assert_allclose(longer.nodes_m[1:], NODES[1:] + [0.025, 0.001], atol=1e-15)
    shifted = LOOP.with_parameters(ar.position(4, "x", bounds_m=SHIFT), [0.05])
    np.testing.assert_allclose(shifted.nodes_m, moved(4, [0.05, 0.0])["nodes"], atol=1e-15)


def test_parameters_act_one_after_the_other_and_the_description_tells_them():
    model = ar.MassSpringChain([1.0, 2.0, 1.5], [500.0, 400.0], ground_first_n_per_m=100.0)
    first, second = ar.stiffness_factor([0, 2], bounds=(0.5, 2.0)), ar.stiffness_reduction(1)
    changed = model.with_parameters(first, [1.1, 0.9]).with_parameters(second, 0.4)
    same_matrices(changed, ar.MassSpringChain([1.0, 2.0, 1.5], [550.0, 240.0], ground_first_n_per_m=90.0))
    assert len(changed.description.applied) == 2
    assert changed.description.recipe == model.description.recipe
    assert changed.description != model.description
    same_matrices(changed.from_description(model.description), model, within=0.0)
    hung = ar.FrameModel(NODES, ELEMENTS, MODEL.sections, node_springs=[(2, 4, 2e3)], fixed=[0])
    for unknown, value in ((ar.stiffness_factor(5, bounds=BOUNDS), 0.8), (ar.stiffness_reduction(5), 0.5)):
        hung = hung.with_parameters(unknown, value)
    assert hung.node_springs[0].stiffness_n_per_m == 2e3 * 0.8 * 0.5


def test_an_updating_applies_what_it_found():
    measured = ar.AntiresonanceSet(0, {0: 1.02 * CHAIN.antiresonances(0, 0)})
    reductions = ar.stiffness_reduction([0, 1])
    problem = ar.UpdatingProblem(CHAIN, reductions, measured, penalty=ar.DamagePenalty(snap=1e-3))
    model = problem.model_at([0.3, 5e-4])
    (applied,) = model.description.applied
    assert applied.values.tolist() == [0.3, 0.0]  # snapped, as it is evaluated
    assert applied.parameters == problem.parameters
    same_matrices(model, CHAIN.with_parameters(problem.parameters, [0.3, 0.0]), within=0.0)


WALL, LUMP = ar.thickness("pipe", bounds=(0.001, 0.002)), ar.point_mass(0, bounds=(1.0, 2.5))
BEND, LONG = ar.angle([2, 3], 2, bounds_deg=(-15.0, 15.0)), ar.length(0, pivot=0, bounds=(0.9, 1.1))


BENT = {"wall": 0.0013, "mass": 1.8, "nodes": rotated(6.0, [3, 4], 2)}


@pytest.mark.parametrize(
    ("truth", "parameters", "values"),
    [(BENT, [WALL, LUMP, BEND], [0.0013, 1.8, 6.0])]
    + [(moved([1, 2, 3, 4, 5], [0.03, 0.0012]) | {"mass": 1.8}, [LONG, LUMP], [1.06, 1.8])],
)
def test_an_update_finds_values_again(truth, parameters, values):
    problem = ar.UpdatingProblem(MODEL, parameters, measured(build(**truth)))
    result = ar.update(problem, rng=0)
    width = np.ptp(problem.bounds, axis=1)
    np.testing.assert_allclose(result.x / width, values / width, atol=20 * FOUND_AGAIN)
    assert result.fun < 0.02 * problem.cost(problem.nominal)
    assert problem.names[0] in result.summary()


def problem(*parameters, model=MODEL):
    return lambda: ar.UpdatingProblem(model, parameters, MEASURED)


def parameter(terms, bounds=BOUNDS, quantity="mass_factor"):
    return lambda: ar.Parameter(quantity, terms, bounds)


THIN, SLIGHT, HEAVY = {"bounds": (0.001, 0.002)}, {"bounds_deg": (-5, 5)}, {"bounds": (7e3, 8e3)}
BOTH = [ar.thickness("bend", bounds=(0.001, 0.015)), ar.diameter("bend", bounds=(0.025, 0.05))]
X = {"bounds_m": SHIFT}


def test_ill_posed_parameters():
    replay(Path(__file__).with_name("wrong_parameters.txt"), lambda call: refusal(eval(call)))


def test_bounds_that_make_a_matrix_indefinite_are_refused():
    stiffness, spring = np.diag([2.0, 3.0]), np.array([[4.0, 0.0], [0.0, 0.0]])
    model = ar.MatrixModel(stiffness, np.eye(2), stiffness_terms=[spring], mass_terms=[3.0 * np.eye(2)])
    zeros = ar.AntiresonanceSet(0, {0: [0.25]})
    ar.UpdatingProblem(model, ar.stiffness_reduction(0, bounds=(0.0, 0.5)), zeros)
    for parameter, what in (
        (ar.stiffness_reduction(0, bounds=(0.0, 0.6)), "stiffness"),
        (ar.mass_factor(0, bounds=(0.5, 1.0)), "mass"),
    ):
        refused(f"^bounds: got .* {what}", ar.UpdatingProblem, model, parameter, zeros)


def test_a_turn_about_an_elements_own_axis_turns_its_section():
    nodes = [(0.1 * i, 0.0, 0.0) for i in range(13)]
    model = ar.FrameModel(nodes, [(i, i + 1) for i in range(12)], ar.Rectangle(0.01, 0.04, E, RHO), fixed=[0])
    sensors, force = [model.dof(7, "v"), model.dof(12, "v")], model.dof(12, "v")
    turn = ar.angle([6], 6, bounds_deg=(-60, 60), axis=(1, 0, 0))
    zeros = model.antiresonances(sensors, force, f_max_hz=900.0)
    of_sensors = dict(zip(sensors, zeros, strict=True))
    task = ar.UpdatingProblem(model, turn, ar.AntiresonanceSet(force, of_sensors, sees="frf"))
    turned = task.model_at([35.0]).antiresonances(sensors, force, f_max_hz=1e4)
    pairs = [(now, f) for now, before in zip(turned, zeros, strict=True) for f in before]
    nearest = [now[np.abs(now - f).argmin()] for now, f in pairs]
    np.testing.assert_allclose(task.paired_hz([35.0]), nearest, rtol=1e-8)
    assert task.cost([35.0]) > 0.1


def test_bounds_and_moduli_in_another_unit_are_refused_or_warned_of():
    task = problem(ar.youngs_modulus(0, bounds=(0.9, 1.1)))
    refused(
        r"^parameters\[0\]\.bounds: got \(0\.9, 1\.1\); wanted .* about the .* factors\. .*relative=True",
        task,
    )
    with pytest.warns(ar.AntiresWarning, match="Check their unit"):
        problem(ar.youngs_modulus(0, bounds=(190.0, 220.0)))()
    with pytest.warns(ar.AntiresWarning, match="softer than rubber"):
        ar.FrameModel([(0, 0), (1, 0)], [(0, 1)], ar.Tube(0.05, 0.002, 210.0, RHO))
    for grams_per_cm3 in (7.85, 2.7):
        with pytest.warns(ar.AntiresWarning, match=r"density_kg_per_m3: .* as light as foam.* 7850 kg/m3"):
            ar.FrameModel([(0, 0), (1, 0)], [(0, 1)], ar.Tube(0.05, 0.002, E, grams_per_cm3))


def test_parameters_of_every_kind_are_added():
    pipe, bend, lumps = (
        ar.youngs_modulus("pipe", bounds=(1.9e11, 2.2e11)),
        ar.thickness("bend", bounds=(0.001, 0.003)),
        ar.mass_factor([0, 1], bounds=(0.9, 1.1)),
    )
    assert pipe + bend == [pipe, bend]
    assert pipe + bend + lumps == [pipe, bend, *lumps] == pipe + ([bend] + lumps)
    assert lumps + pipe == [*lumps, pipe]
    refused("^parameters: got 4; wanted Parameters", lambda: pipe + 4)


@pytest.mark.parametrize("kappa", [None, 0.85])
@pytest.mark.parametrize(
    ("parameter", "at", "lengths_of"),
    [
        (ar.length([1], pivot=1, bounds=BOUNDS), 1.07, lambda p: [0.3, 0.2 * p, 0.25]),
        (ar.length([0, 1, 2], pivot=0, bounds=BOUNDS), 0.94, lambda p: [0.3 * p, 0.2 * p, 0.25 * p]),
        (ar.position(1, "x", bounds_m=SHIFT), 0.03, lambda p: [0.3 + p, 0.2 - p, 0.25]),
    ],
)
def test_sensitivities_to_lengths_are_those_of_frames_built_so(parameter, at, lengths_of, kappa):
    section = ar.Rectangle(0.02, 0.06, E, RHO, shear_coefficient=kappa)
    held = [(0, "v"), (0, "theta"), *((i, "u") for i in range(4))]

    def built(lengths):
        nodes = np.c_[np.r_[0.0, np.cumsum(lengths)], np.zeros(4)]
        return ar.FrameModel(nodes, [(0, 1), (1, 2), (2, 3)], section, fixed=held)

    def squares(value):
        return built(lengths_of(value)).antiresonances(2, 4)[:2] ** 2

    nominal = built([0.3, 0.2, 0.25])
    formed = nominal.with_parameters(parameter, [at])
    same_matrices(formed, built(lengths_of(at)))
    zeros = formed.antiresonances(2, 4)[:2]
    task = ar.UpdatingProblem(nominal, parameter, ar.AntiresonanceSet(4, {2: zeros}))
    step = 1e-5
    slopes = (squares(at + step) - squares(at - step)) / (2 * step) / zeros**2
    found = at_solution(task, [at]).sensitivity[0] / np.ptp(parameter.bounds)
    assert found == pytest.approx(np.linalg.norm(slopes), rel=1e-7)
