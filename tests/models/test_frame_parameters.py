"""Parameters of frames: an updated model is the model built with these values, and a search finds them."""

import re

import numpy as np
import pytest

import antires_rs as ar
from antires_rs import exceptions
from tests.support.tolerances import FOUND_AGAIN, RIGID_FORCE, ROUNDING, SOFT_ZERO

E, RHO = 2.1e11, 7850.0
NODES = np.array([(0.0, 0.0), (0.5, 0.02), (1.0, 0.0), (1.5, 0.1), (1.9, 0.3), (1.2, 0.5)])
ELEMENTS = [(0, 1, "pipe"), (1, 2, "pipe"), (2, 3, "bend"), (3, 4, "bend"), (2, 5, "arm")]
BOUNDS = (0.8, 1.2)


def build(
    nodes=NODES, wall=0.0015, diameter=0.045, modulus=E, density=RHO, mass=1.5, inertia=0.01, hanger=2e3
):
    return ar.FrameModel(
        nodes,
        ELEMENTS,
        {
            "pipe": ar.Tube(0.038, wall, modulus, RHO),
            "bend": ar.Tube(diameter, 0.002, E, RHO),
            "arm": ar.Rectangle(0.02, 0.01, E, density),
        },
        point_masses=[ar.PointMass(3, mass, inertia), ar.PointMass(5, 0.7)],
        ground_springs=[
            ar.GroundSpring(0, "v", hanger),
            ar.GroundSpring(4, "v", hanger),
            ar.GroundSpring(1, "u", 800.0),
        ],
    )


MODEL = build()
SHAKER = MODEL.dof(1, "v")
SENSORS = [MODEL.dof(0, "v"), MODEL.dof(2, "v"), MODEL.dof(3, "v"), MODEL.dof(4, "u"), MODEL.dof(5, "v")]


def measured(model):
    return ar.AntiresonanceSet(
        SHAKER, dict(zip(SENSORS, model.antiresonances(SENSORS, SHAKER, f_max_hz=400.0), strict=True))
    )


MEASURED = measured(MODEL)


def same(a, b):
    for one, other in ((a.stiffness(), b.stiffness()), (a.mass(), b.mass())):
        assert abs(one - other).max() <= ROUNDING * abs(other).max()


def rotated(degrees, moving, pivot):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    nodes = NODES.copy()
    nodes[moving] = NODES[pivot] + (NODES[moving] - NODES[pivot]) @ np.array([[c, s], [-s, c]])
    return nodes


#: Parameter, a value of it, the model built with that value, its nominal value.
KINDS = {
    "youngs_modulus": (ar.youngs_modulus("pipe", bounds=(1e11, 3e11)), 1.9e11, {"modulus": 1.9e11}, E),
    "by index": (ar.youngs_modulus(0, bounds=(1e11, 3e11)), 1.9e11, {"modulus": 1.9e11}, E),
    "density": (ar.density("arm", bounds=(7e3, 9e3)), 8100.0, {"density": 8100.0}, RHO),
    "thickness": (ar.thickness("pipe", bounds=(0.001, 0.003)), 0.0021, {"wall": 0.0021}, 0.0015),
    "a factor": (ar.thickness("pipe", bounds=BOUNDS, relative=True), 1.1, {"wall": 1.1 * 0.0015}, 1.0),
    "diameter": (ar.diameter("bend", bounds=(0.04, 0.05)), 0.043, {"diameter": 0.043}, 0.045),
    "point_mass": (ar.point_mass(0, bounds=(1.0, 2.0)), 1.9, {"mass": 1.9}, 1.5),
    "inertia": (ar.inertia(0, bounds=(0.0, 0.1)), 0.03, {"inertia": 0.03}, 0.01),
    "support": (ar.support_stiffness([0, 1], bounds=(0.0, 9e3), together=True), 3e3, {"hanger": 3e3}, 2e3),
    "angle": (
        ar.angle([2, 3], pivot=2, bounds_deg=(-90, 90)),
        12.0,
        {"nodes": rotated(12.0, [3, 4], 2)},
        0.0,
    ),
    "inner angle": (
        ar.angle(1, 1, bounds_deg=(-90, 90)),
        -7.0,
        {"nodes": rotated(-7.0, [2, 3, 4, 5], 1)},
        0.0,
    ),
}


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_gives_the_model_built_with_the_value(kind):
    parameter, value, changed, nominal = KINDS[kind]
    problem = ar.UpdatingProblem(MODEL, parameter, MEASURED)
    assert problem.nominal.tolist() == [nominal]
    assert problem.cost(problem.nominal) == 0.0
    updated = problem.model_at([value])
    expected = build(**changed)
    same(updated, expected)
    np.testing.assert_allclose(updated.nodes_m, expected.nodes_m, atol=ROUNDING)
    assert problem.cost([value]) > 1e-6
    # The objective sees what the updated model shows.
    exact = ar.UpdatingProblem(MODEL, parameter, measured(expected))
    assert exact.cost([value]) < SOFT_ZERO * exact.measured_hz.size
    # The updated model is nominal in its new state.
    again = ar.UpdatingProblem(updated, parameter, MEASURED)
    if not parameter.relative and parameter.quantity != "angle":
        assert again.nominal.tolist() == [value]
    same(again.model_at(again.nominal), updated)


def test_all_kinds_mix_with_terms_and_names_carry_units():
    parameters = [
        *ar.stiffness_reduction([1, 4]),
        ar.stiffness_factor(5, bounds=BOUNDS),
        ar.mass_factor(2, bounds=BOUNDS),
        *(
            KINDS[k][0]
            for k in (
                "youngs_modulus",
                "density",
                "thickness",
                "diameter",
                "point_mass",
                "inertia",
                "support",
                "angle",
            )
        ),
    ]
    problem = ar.UpdatingProblem(MODEL, parameters, MEASURED, penalty=(0.1, 0.1))
    assert problem.names == [
        "stiffness loss of element 1",
        "stiffness loss of element 4",
        "stiffness of ground spring 0 (node 0 v)",
        "mass of element 2",
        "Young's modulus of pipe (Pa)",
        "density of arm (kg/m3)",
        "thickness of pipe (m)",
        "outer diameter of bend (m)",
        "mass 0 (node 3) (kg)",
        "inertia of mass 0 (node 3) (kg m2)",
        "stiffness of ground spring 0 (node 0 v), ground spring 1 (node 4 v) (N/m)",
        "angle of element 2, element 3 about node 2 (deg)",
    ]
    x = problem.nominal
    x[:4], x[5], x[6], x[11] = [0.2, 0.1, 1.1, 0.9], 8000.0, 0.0012, 5.0
    updated = problem.model_at(x)
    assert updated.sections["arm"].density_kg_per_m3 == 8000.0
    assert updated.sections["pipe"].thickness_m == 0.0012
    assert updated.ground_springs[0].stiffness_n_per_m == pytest.approx(2200.0, rel=ROUNDING)
    rest = build(wall=0.0012, density=8000.0, nodes=rotated(5.0, [3, 4], 2))
    terms = [
        *ar.stiffness_reduction([1, 4]),
        ar.stiffness_factor(5, bounds=BOUNDS),
        ar.mass_factor(2, bounds=BOUNDS),
    ]
    same(updated, ar.UpdatingProblem(rest, terms, MEASURED).model_at([0.2, 0.1, 1.1, 0.9]))
    # Cost and batch agree bit by bit, in any order.
    grid = np.array([x, problem.nominal, x])
    np.testing.assert_array_equal(problem.evaluate_many(grid, workers=2), [problem.cost(row) for row in grid])
    assert MODEL.sections["pipe"].thickness_m == 0.0015  # the model itself is as it was


@pytest.mark.parametrize("degrees", [3.0, 45.0, 90.0, 170.0])
def test_a_free_frame_stays_free_at_any_angle(degrees):
    free = ar.FrameModel(NODES, [pair[:2] for pair in ELEMENTS], ar.Tube(0.038, 0.0015, E, RHO))
    problem = ar.UpdatingProblem(
        free, [ar.angle([2], 2, bounds_deg=(-180, 180)), ar.angle([3], 3, bounds_deg=(-180, 180))], MEASURED
    )
    turned = problem.model_at([degrees, -0.5 * degrees])
    motions = np.zeros((free.n_dof, 3))
    for node, (x, y) in enumerate(turned.nodes_m):
        motions[3 * node : 3 * node + 3] = [[1, 0, -y], [0, 1, x], [0, 0, 1]]
    assert np.abs(turned.stiffness() @ motions).max() < RIGID_FORCE * abs(turned.stiffness()).max()
    assert np.count_nonzero(turned.modes().freq_hz < 1e-2) == 3


def test_an_update_finds_wall_mass_and_angle_again():
    truth = build(wall=0.0013, mass=1.8, nodes=rotated(6.0, [3, 4], 2))
    parameters = [
        ar.thickness("pipe", bounds=(0.001, 0.002)),
        ar.point_mass(0, bounds=(1.0, 2.5)),
        ar.angle([2, 3], 2, bounds_deg=(-15.0, 15.0)),
    ]
    problem = ar.UpdatingProblem(MODEL, parameters, measured(truth))
    result = ar.update(problem, rng=0)
    width = np.ptp(problem.bounds, axis=1)
    np.testing.assert_allclose(result.x / width, np.array([0.0013, 1.8, 6.0]) / width, atol=20 * FOUND_AGAIN)
    assert result.fun < 0.02 * problem.cost(problem.nominal)
    assert "thickness of pipe (m)" in result.summary()


def test_damage_is_sought_in_all_beams_by_default():
    damaged = ar.UpdatingProblem(MODEL, ar.stiffness_reduction(3), MEASURED).model_at([0.6])
    result = ar.assess_damage(MODEL, measured(damaged), rng=0)
    assert result.elements == [0, 1, 2, 3, 4]
    assert result.damaged == [3]
    assert result.severity[3] == pytest.approx(0.6, abs=FOUND_AGAIN)


def problem(*parameters, model=MODEL):
    return lambda: ar.UpdatingProblem(model, parameters, MEASURED)


CHAIN = ar.MassSpringChain(np.ones(18), np.full(17, 1e6))
LOOP = ar.FrameModel(NODES, [*(pair[:2] for pair in ELEMENTS), (4, 5)], ar.Tube(0.038, 0.0015, E, RHO))
WRONG = {
    "element twice": ("elements", lambda: ar.stiffness_reduction([3, 3])),
    "section twice": ("sections", lambda: ar.thickness(["pipe", "pipe"], bounds=BOUNDS)),
    "section twice under two names": (
        "parameters",
        problem(ar.density("pipe", bounds=(7e3, 8e3)), ar.density(0, bounds=(7e3, 8e3))),
    ),
    "angle twice": ("parameters", problem(*[ar.angle(2, 2, bounds_deg=(0, 1))] * 2)),
    "unknown section": ("sections", problem(ar.density("rod", bounds=(7e3, 8e3)))),
    "section outside": ("parameters[0]", problem(ar.density(7, bounds=(7e3, 8e3)))),
    "rectangle's wall": ("parameters[0]", problem(ar.thickness("arm", bounds=(0.001, 0.002)))),
    "changes nothing": ("parameters[0]", problem(ar.inertia(1, bounds=BOUNDS, relative=True))),
    "one value for two": ("parameters[0]", problem(ar.point_mass([0, 1], bounds=(1, 2), together=True))),
    "wall beyond the radius": ("bounds", problem(ar.thickness("pipe", bounds=(0.001, 0.02)))),
    "wall and diameter": (
        "bounds",
        problem(ar.thickness("bend", bounds=(0.001, 0.015)), ar.diameter("bend", bounds=(0.025, 0.045))),
    ),
    "negative modulus": ("bounds[0]", lambda: ar.youngs_modulus(0, bounds=(-1.0, 2e11))),
    "zero factor": ("bounds[0]", lambda: ar.point_mass(0, bounds=(0.0, 2.0), relative=True)),
    "bounds out of order": ("bounds", lambda: ar.angle(2, 2, bounds_deg=(5.0, -5.0))),
    "negative term": ("sections", lambda: ar.thickness(-1, bounds=BOUNDS)),
    "a name for a mass": ("masses", lambda: ar.point_mass("lump", bounds=BOUNDS)),
    "pivot away": ("pivot", problem(ar.angle(3, 0, bounds_deg=(-5, 5)))),
    "pivot outside": ("pivot", problem(ar.angle(3, 60, bounds_deg=(-5, 5)))),
    "no pivot": ("pivot", lambda: ar.angle(3, None, bounds_deg=(-5, 5))),
    "out of the plane": ("parameters[0]", problem(ar.angle(3, 3, bounds_deg=(-5, 5), axis=(1, 0, 0)))),
    "no axis": ("axis", lambda: ar.angle(3, 3, bounds_deg=(-5, 5), axis=(0, 0, 0))),
    "a loop": ("elements", problem(ar.angle(2, 2, bounds_deg=(-5, 5)), model=LOOP)),
    "a chain's wall": ("parameters[0]", problem(ar.thickness(0, bounds=(0.001, 0.002)), model=CHAIN)),
    "a chain's section": ("parameters", problem(ar.thickness("pipe", bounds=(0.001, 0.002)), model=CHAIN)),
    "a chain's angle": ("parameters[0]", problem(ar.angle(0, 0, bounds_deg=(-5, 5)), model=CHAIN)),
}


@pytest.mark.parametrize("name", WRONG)
def test_ill_posed_parameters(name):
    argument, call = WRONG[name]
    with pytest.raises(exceptions.InvalidInputError, match=rf"^{re.escape(argument)}: got .*; wanted "):
        call()


def test_bounds_that_make_a_matrix_indefinite_are_refused():
    stiffness, spring = np.diag([2.0, 3.0]), np.array([[4.0, 0.0], [0.0, 0.0]])
    model = ar.MatrixModel(stiffness, np.eye(2), stiffness_terms=[spring], mass_terms=[3.0 * np.eye(2)])
    zeros = ar.AntiresonanceSet(0, {0: [0.25]})
    ar.UpdatingProblem(model, ar.stiffness_reduction(0, bounds=(0.0, 0.5)), zeros)
    for parameter, what in (
        (ar.stiffness_reduction(0, bounds=(0.0, 0.6)), "stiffness"),
        (ar.mass_factor(0, bounds=(0.5, 1.0)), "mass"),
    ):
        with pytest.raises(exceptions.InvalidInputError, match=f"^bounds: got .* {what}"):
            ar.UpdatingProblem(model, parameter, zeros)


def test_a_turn_about_an_elements_own_axis_turns_its_section():
    nodes = [(0.1 * i, 0.0, 0.0) for i in range(13)]
    model = ar.FrameModel(nodes, [(i, i + 1) for i in range(12)], ar.Rectangle(0.01, 0.04, E, RHO), fixed=[0])
    sensors, force = [model.dof(7, "v"), model.dof(12, "v")], model.dof(12, "v")
    turn = ar.angle([6], 6, bounds_deg=(-60, 60), axis=(1, 0, 0))
    zeros = dict(zip(sensors, model.antiresonances(sensors, force, f_max_hz=900.0), strict=True))
    task = ar.UpdatingProblem(model, turn, ar.AntiresonanceSet(force, zeros, sees="frf"))
    turned = task.model_at([35.0]).antiresonances(sensors, force, f_max_hz=1e4)
    nearest = [
        of_model[np.abs(of_model - f).argmin()]
        for of_model, values in zip(turned, zeros.values(), strict=True)
        for f in values
    ]
    np.testing.assert_allclose(task.paired_hz([35.0]), nearest, rtol=1e-8)
    assert task.cost([35.0]) > 0.1


def test_bounds_and_moduli_in_another_unit_are_warned_of():
    zeros = measured(MODEL)
    with pytest.warns(ar.AntiresWarning, match=r"far outside the bounds \(0\.9, 1\.1\)\. .*relative=True"):
        ar.UpdatingProblem(MODEL, ar.youngs_modulus(0, bounds=(0.9, 1.1)), zeros)
    with pytest.warns(ar.AntiresWarning, match="Check the unit of the bounds"):
        ar.UpdatingProblem(MODEL, ar.youngs_modulus(0, bounds=(190.0, 220.0)), zeros)
    with pytest.warns(ar.AntiresWarning, match="softer than rubber"):
        ar.FrameModel([(0, 0), (1, 0)], [(0, 1)], ar.Tube(0.05, 0.002, 210.0, RHO))
    with pytest.raises(exceptions.InvalidInputError, match="elements"):
        ar.FrameModel([(0, 0), (1, 0)], 5, ar.Tube(0.05, 0.002, E, RHO))
    with pytest.raises(exceptions.InvalidInputError, match=r"elements\[0\]"):
        ar.FrameModel([(0, 0), (1, 0)], [5, 6], ar.Tube(0.05, 0.002, E, RHO))
