"""One description of a model: all that it takes to build it again, and nothing that can be changed."""

import numpy as np
import pytest

import antires_rs as ar
from tests.models.shared import same_matrices


def chain():
    return ar.MassSpringChain([1.0, 2.0, 1.5], [500.0, 400.0], ground_first_n_per_m=100.0)


def matrices():
    spring = np.array([[500.0, -500.0], [-500.0, 500.0]])
    return ar.MatrixModel(spring + np.eye(2), np.eye(2), stiffness_terms=[spring], mass_terms=[np.eye(2)])


def frame():
    pipe, bar = ar.Tube(0.03, 0.002, 2.1e11, 7850.0), ar.Rectangle(0.03, 0.01, 7e10, 2700.0)
    return ar.FrameModel(
        [(0.25 * i, 0.0) for i in range(5)],
        [(i, i + 1, "pipe" if i < 2 else "bar") for i in range(4)],
        {"pipe": pipe, "bar": bar},
        point_masses=[(4, 0.3, 0.001)],
        ground_springs=[(2, "v", 1e4)],
        node_springs=[(2, 4, 2e3)],
        fixed=[0],
    )


STEPS = {
    chain: [(ar.stiffness_factor([0, 2], bounds=(0.5, 2.0)), [1.1, 0.9]), (ar.stiffness_reduction(1), 0.4)],
    matrices: [(ar.mass_factor(0, bounds=(0.5, 2.0)), 1.2), (ar.stiffness_reduction(0), 0.4)],
    frame: [
        (
            [ar.thickness("pipe", bounds=(0.001, 0.003)), *ar.stiffness_factor([5], bounds=(0.5, 2.0))],
            [0.0015, 0.8],
        ),
        (ar.stiffness_reduction([0, 5]), [0.2, 0.5]),
    ],
}


@pytest.mark.parametrize("make", STEPS)
def test_a_model_is_built_from_its_description_alone(make):
    model = make()
    for parameters, values in STEPS[make]:
        model = model.with_parameters(parameters, values)
        again = type(model).from_description(model.description)
        same_matrices(again, model, within=0.0)
        assert again.description == model.description
        if isinstance(model, ar.FrameModel):
            assert again.node_springs == model.node_springs
            assert again.sections == model.sections
    assert len(model.description.applied) == 2
    assert model.description.recipe == make().description.recipe
    assert model.description != make().description
    # A call without the constructor's arguments leaves the first model as it was.
    same_matrices(make(), make().from_description(make().description), within=0.0)


def test_parameters_act_one_after_the_other():
    model = chain()
    for parameters, values in STEPS[chain]:
        model = model.with_parameters(parameters, values)
    wanted = ar.MassSpringChain([1.0, 2.0, 1.5], [550.0, 240.0], ground_first_n_per_m=90.0)
    np.testing.assert_allclose(model.stiffness(), wanted.stiffness(), rtol=1e-14)
    np.testing.assert_array_equal(model.mass(), wanted.mass())
    springs = frame().with_parameters(*STEPS[frame][0]).with_parameters(*STEPS[frame][1]).node_springs
    assert springs[0].stiffness_n_per_m == 2e3 * 0.8 * 0.5


def test_an_updating_applies_what_it_found():
    measured = ar.AntiresonanceSet(0, {0: 1.02 * chain().antiresonances(0, 0)})
    problem = ar.UpdatingProblem(
        chain(), ar.stiffness_reduction([0, 1]), measured, penalty=ar.DamagePenalty(snap=1e-3)
    )
    model = problem.model_at([0.3, 5e-4])
    (applied,) = model.description.applied
    assert applied.values.tolist() == [0.3, 0.0]  # snapped, as it is evaluated
    assert applied.parameters == problem.parameters
    same_matrices(model, chain().with_parameters(problem.parameters, [0.3, 0.0]), within=0.0)


@pytest.mark.parametrize("make", STEPS)
def test_nothing_of_it_can_be_changed(make):
    model = make()
    for name in ("description", "n_dof", "_core", "anything"):
        with pytest.raises(AttributeError):
            setattr(model, name, 1)
    with pytest.raises(AttributeError, match="is read-only"):
        model.note = "x"
    recipe = model.description.recipe
    with pytest.raises(AttributeError):
        recipe.masses_kg = None
    for value in vars(recipe).values():
        if isinstance(value, np.ndarray):
            with pytest.raises(ValueError, match="read-only"):
                value[...] = 0.0


def test_wrong_calls():
    with pytest.raises(ar.InvalidInputError, match="description: got .*MatrixRecipe.*ChainRecipe"):
        ar.MassSpringChain.from_description(matrices().description)
    with pytest.raises(ar.InvalidInputError, match="description: got 3"):
        ar.MassSpringChain.from_description(3)
    with pytest.raises(ar.InvalidInputError, match="values: got .* wanted an array \\(2,\\)"):
        chain().with_parameters(ar.stiffness_reduction([0, 1]), [0.1])
    with pytest.raises(ar.InvalidInputError, match="parameters: got 3"):
        chain().with_parameters(3, [0.1])
    with pytest.raises(ar.InvalidInputError, match="section 'pipe'"):
        chain().with_parameters(ar.thickness("pipe", bounds=(0.001, 0.002)), [0.001])
