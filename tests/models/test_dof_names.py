"""Dofs by name: wherever a number is taken a name is, with the same answer."""

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.support.directions import point_of
from tests.models.shared import random_structure

NAMES = ["1204:Z", "1204:RX", "1205:Z", "1205:RX", "7:X", "hub"]


def named(**options):
    k, m, _ = random_structure(6, 6)
    terms = [np.diag(1e4 * (np.arange(6) == dof)) for dof in range(6)]
    return ar.MatrixModel(k, m, stiffness_terms=terms, dofs=NAMES, **options)


@pytest.mark.parametrize(
    "name", ["1205:Z", "1205+Z", "1205 UZ", "1205:3", "node 1205 w", "1205:+Z", " 1205:T3", "1205z"]
)
def test_a_node_and_a_direction_in_any_spelling(name):
    assert named().dof(name) == 2
    assert point_of(name) == (1205, 3)


def test_a_name_is_as_good_as_a_number():
    model = named()
    numbers, names = [0, 2, 5], ["1204:Z", "1205+Z", "hub"]
    for a, b in zip(model.antiresonances(numbers, 4), model.antiresonances(names, "7:X"), strict=True):
        np.testing.assert_array_equal(a, b)
    freq = [2.0, 20.0]
    np.testing.assert_array_equal(
        model.frf(numbers, 4, freq, damping_ratio=0.01), model.frf(names, "7:UX", freq, damping_ratio=0.01)
    )
    made = {"fs_hz": 200.0, "duration_s": 2.0, "damping_ratio": 0.01, "rng": 0}
    by_name = model.simulate(excitation="7:X", responses=names, **made).responses
    by_number = model.simulate(excitation=4, responses=numbers, **made).responses
    np.testing.assert_array_equal(by_name, by_number)
    assert [model.dof_label(dof) for dof in numbers] == ["1204:Z", "1205:Z", "hub"]


def sets(model, truth):
    """Of a force at 7:X: by numbers, and by names."""
    dofs, names = [0, 2, 4, 5], ["1204+Z", "1205 UZ", "7:X", "hub"]
    values = truth.antiresonances(dofs, 4)
    return (
        ar.AntiresonanceSet(4, dict(zip(dofs, values, strict=True)), sees="frf"),
        ar.AntiresonanceSet("7:X", dict(zip(names, values, strict=True)), sees="frf"),
    )


def test_updating_takes_sets_with_names():
    model = named()
    unknowns = ar.stiffness_factor([1, 2], bounds=(0.2, 2.0))
    truth = model.with_parameters(unknowns, [0.7, 1.3])
    by_number, by_name = (ar.UpdatingProblem(model, unknowns, each) for each in sets(model, truth))
    assert by_number.cost([1.0, 1.0]) == by_name.cost([1.0, 1.0]) > 0.0
    np.testing.assert_array_equal(by_number.measured_dofs, by_name.measured_dofs)
    results = [ar.update(each, rng=0, progress=False) for each in (by_number, by_name)]
    assert results[0].x.tobytes() == results[1].x.tobytes()
    np.testing.assert_allclose(results[1].x, [0.7, 1.3], rtol=1e-4)
    assert "1205:Z" in str(results[1].table)
    found = [ar.identifiability(each, points=8) for each in (by_number, by_name)]
    assert found[0].words == found[1].words
    freq_hz, shapes = truth.modes().freq_hz[:3], truth.modes().shapes[:3, [0, 2, 5]]
    costs = [
        ar.UpdatingProblem(model, unknowns, ar.ModalSet(freq_hz, shapes, dofs=dofs)).cost([1.0, 1.0])
        for dofs in ([0, 2, 5], ["1204:Z", "1205+Z", "hub"])
    ]
    assert costs[0] == costs[1] > 0.0


def test_damage_and_plans_take_names():
    model = named()
    damaged = model.with_parameters(ar.stiffness_reduction(1), 0.5)
    one, other = (
        ar.assess_damage(model, now, baseline=intact, rng=0).probability
        for intact, now in zip(sets(model, model), sets(model, damaged), strict=True)
    )
    assert one == other
    plans = [
        ar.plan_test(model, n_sensors=2, candidates=each, excitations=force, std=1e-3)
        for each, force in (([0, 2, 5], 4), (["1204:Z", "1205:Z", "hub"], "7:X"))
    ]
    assert plans[0].sensors == plans[1].sensors
    # Without candidates accelerometers are not put on rotations.
    assert {1, 3}.isdisjoint(model._sensor_dofs)


def test_an_unknown_name_is_told_with_those_near_it():
    model = named()
    with pytest.raises(ar.InvalidInputError, match=r"^response: got '1204:Y'; .*like '1204:Z', '1204:RX'"):
        model.antiresonances("1204:Y", 0)
    with pytest.raises(ar.InvalidInputError, match=r"excitation: got 'hubb'.*like 'hub'"):
        model.antiresonances(0, "hubb")
    with pytest.raises(ar.InvalidInputError, match=r"measured dof: got '12\+Z'"):
        ar.UpdatingProblem(
            model, ar.stiffness_factor([1], bounds=(0.5, 2.0)), ar.AntiresonanceSet(0, {"12+Z": [3.0]})
        )
    with pytest.raises(ar.InvalidInputError, match=r"constraints\[0\]: got '9:Z'"):
        named(constraints=[{"9:Z": 1.0, "hub": -1.0}])


def test_frames_and_chains_have_names_too():
    tube = ar.Tube(0.02, 0.005, 2.1e11, 7850.0)
    frame = ar.FrameModel([(0.0, 0.0), (0.5, 0.0), (1.0, 0.0)], [(0, 1), (1, 2)], tube, fixed=[0])
    tip = frame.dof(2, "v")
    for name in ("node 2 v", "2:v", "2:Y"):
        np.testing.assert_array_equal(
            frame.antiresonances(name, "1:v"), frame.antiresonances(tip, frame.dof(1, "v"))
        )
    chain = ar.MassSpringChain([1.0, 1.0], [500.0])
    np.testing.assert_array_equal(chain.antiresonances("mass 1", "mass 0"), chain.antiresonances(1, 0))


@pytest.mark.parametrize(
    ("dofs", "words"),
    [
        (["a", "b"], "2 names; wanted 6"),
        (["a", "b", "c", "d", "e", "a"], "'a' more than once"),
        ("1204:Z", "6 names, or a mapping"),
        ([1, 2, 3, 4, 5, 6], r"dofs\[0\]: got 1; wanted a text"),
        ({"a": 6}, r"dofs\['a'\]: got 6"),
        (["1:Z", "1 UZ", "2", "3", "4", "5"], "'1:Z' and '1 UZ', two spellings"),
    ],
)
def test_names_that_do_not_fit(dofs, words):
    k, m, _ = random_structure(6, 6)
    with pytest.raises(ar.InvalidInputError, match=words):
        ar.MatrixModel(k, m, dofs=dofs)


def test_a_map_of_a_file_names_rows(tmp_path):
    k, m, _ = random_structure(6, 3)
    file = tmp_path / "K.mapping"
    file.write_text("Matrix Eqn  Node  DOF\n 1 12 UY\n 2 12 UZ\n 3 14 ROTX\n")
    for dofs in (ar.io.read_dof_map(file), [(12, "+Y"), (12, 3), (14, "RX")], ["12:Y", "12:Z", "14:RX"]):
        model = ar.MatrixModel(k, m, dofs=dofs)
        assert [model.dof_label(dof) for dof in range(3)] == ["12:Y", "12:Z", "14:RX"]
    assert ar.read_matrices(k, m, dofs=file).dof("12 UZ") == 1
