"""Updating parameters: what they are, what they do to K and M, what they refuse."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.tolerances import ROUNDING

BOUNDS = (0.8, 1.2)


def test_a_scalar_gives_one_parameter_and_a_sequence_a_list():
    assert ar.stiffness_factor(3, bounds=BOUNDS) == ar.Parameter("stiffness_factor", (3,), BOUNDS)
    several = ar.mass_factor(range(2), bounds=BOUNDS)
    assert several == [ar.Parameter("mass_factor", (0,), BOUNDS), ar.Parameter("mass_factor", (1,), BOUNDS)]
    assert ar.stiffness_reduction(np.array([4, 5]))[1].terms == (5,)
    together = ar.stiffness_reduction([4, 5], together=True)
    assert together.terms == (4, 5)
    assert together.bounds == (0.0, 0.99)


def test_nominal_values_leave_the_model_alone():
    assert ar.stiffness_reduction(0).nominal == 0.0
    assert ar.stiffness_factor(0, bounds=BOUNDS).nominal == 1.0
    case = ar.cases.chain8()
    problem = case.updating_problem()
    model = problem.model_at(problem.nominal)
    np.testing.assert_array_equal(model.stiffness(), case.model.stiffness())
    np.testing.assert_array_equal(model.mass(), case.model.mass())


def test_parameters_change_what_they_say():
    """Against a chain that is built directly with the changed values."""
    masses, springs = np.array([1.0, 2.0, 3.0]), np.array([100.0, 200.0])
    model = ar.MassSpringChain(masses, springs, ground_last_n_per_m=50.0)
    parameters = [
        *ar.stiffness_factor([0], bounds=BOUNDS),
        *ar.mass_factor([1], bounds=BOUNDS),
        *ar.stiffness_reduction([1]),
        ar.stiffness_factor(3, bounds=BOUNDS),
    ]
    problem = ar.UpdatingProblem(model, parameters, ar.AntiresonanceSet(0, {0: [1.0]}))
    changed = problem.model_at([1.1, 0.9, 0.25, 1.2])
    direct = ar.MassSpringChain(masses * [1, 0.9, 1], springs * [1.1, 0.75], ground_last_n_per_m=60.0)
    np.testing.assert_allclose(changed.stiffness(), direct.stiffness(), rtol=ROUNDING)
    np.testing.assert_allclose(changed.mass(), direct.mass(), rtol=ROUNDING)
    assert problem.names == [
        "stiffness of spring 0",
        "mass 1",
        "stiffness loss of spring 1",
        "stiffness of last ground spring",
    ]


def test_factors_on_one_element_multiply():
    model = ar.MassSpringChain([1.0, 1.0], [100.0])
    both = [ar.stiffness_factor(0, bounds=BOUNDS), ar.stiffness_reduction(0)]
    problem = ar.UpdatingProblem(model, both, ar.AntiresonanceSet(0, {0: [1.0]}))
    np.testing.assert_allclose(
        problem.model_at([1.2, 0.5]).stiffness(), 0.6 * model.stiffness(), rtol=ROUNDING
    )


def test_an_updated_model_is_a_nominal_model_of_its_own():
    """Its terms carry the change: a factor applied to it multiplies with the first."""
    model = ar.MassSpringChain([1.0, 1.0], [100.0])
    measured = ar.AntiresonanceSet(0, {0: [1.0]})
    factor = ar.stiffness_factor(0, bounds=BOUNDS)
    once = ar.UpdatingProblem(model, factor, measured).model_at([1.2])
    twice = ar.UpdatingProblem(once, factor, measured).model_at([1.2])
    np.testing.assert_allclose(twice.stiffness(), 1.44 * model.stiffness(), rtol=ROUNDING)


def test_one_parameter_for_several_elements_moves_them_together():
    model = ar.cases.chain8().model
    together = ar.stiffness_factor([0, 6], bounds=BOUNDS, together=True)
    problem = ar.UpdatingProblem(model, together, ar.AntiresonanceSet(0, {0: [12.0]}))
    changed = -np.diag(problem.model_at([1.2]).stiffness(), 1) / 56.7e3
    np.testing.assert_allclose(changed, [1.2, 1, 1, 1, 1, 1, 1.2], rtol=ROUNDING)
    assert problem.names == ["stiffness of spring 0, spring 6"]


@pytest.mark.parametrize(
    ("quantity", "terms", "bounds", "named"),
    [
        ("stifness_factor", (0,), BOUNDS, "quantity"),
        ("mass_factor", (-1,), BOUNDS, "terms"),
        ("mass_factor", (), BOUNDS, "terms"),
        ("mass_factor", (0.5,), BOUNDS, "terms"),
        ("mass_factor", (0,), (1.2, 0.8), "bounds"),
        ("mass_factor", (0,), (0.0, 0.8), "bounds"),
        ("stiffness_reduction", (0,), (0.0, 1.1), "bounds"),
    ],
)
def test_a_parameter_made_by_hand_is_checked_too(quantity, terms, bounds, named):
    with pytest.raises(ar.InvalidInputError, match=rf"^{named}.*got .*; wanted "):
        ar.Parameter(quantity, terms, bounds)
