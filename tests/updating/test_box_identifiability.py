"""What a test could tell, asked before it: against closed forms, finite differences, and what helps."""

import numpy as np
import pytest
from scipy.linalg import eigh

import antires_rs as ar
from antires_rs.updating.identifiability import combination_in_words, sensitivities
from tests.support.refusals import assert_refused


def virtual(model, dofs, force=0):
    return ar.AntiresonanceSet(force, dict(zip(dofs, model.antiresonances(dofs, force), strict=True)))


@pytest.fixture(scope="module")
def chain8():
    return ar.identifiability(ar.cases.chain8().updating_problem(), points=16, forces=[7], sensors=[])


def test_what_no_antiresonance_sees_is_named_all_over_the_box(chain8):
    """A force at mass 0: mass 0 and the common scale; known in closed form."""
    assert chain8.told == 13
    assert chain8.left[0] == pytest.approx(1.0, abs=1e-6)
    assert set(chain8.words) == {"mass 0", "a common scale of the parameters; their ratios are"}
    assert np.all(chain8.singular_values[:, 13:] < 1e-3)
    assert np.all(chain8.singular_values[:, 12] > 1.0)


def test_what_helps_does(chain8):
    """A force at mass 7 sees mass 0; the count that is promised is that of the test with both."""
    (force,) = [words for words in chain8.suggestions if words.startswith("A force at mass 7")]
    assert "14 of 15 combinations are told instead of 13" in force
    (fix,) = [words for words in chain8.suggestions if words.startswith("Fix")]
    assert "of 2 open combinations 1 stays open" in fix
    case = ar.cases.chain8()
    both = [virtual(case.model, range(8), force) for force in (0, 7)]
    problem = ar.UpdatingProblem(case.model, case.updating_problem().parameters, both)
    assert ar.identifiability(problem, points=16, forces=[], sensors=[]).told == 14


def test_sensitivities_are_those_of_the_structure_at_x():
    """The driving point's antiresonances are the resonances of what is left when its dof is held: eigh."""
    masses, springs = np.array([2.0, 1.0, 1.5]), np.array([500.0, 400.0])
    model = ar.MassSpringChain(masses, springs)
    problem = ar.UpdatingProblem(model, ar.stiffness_factor([0, 1], bounds=(0.8, 1.25)), virtual(model, [0]))
    x = np.array([0.9, 1.2])

    def squares(factors):
        k1, k2 = springs * factors
        held = np.array([[k1 + k2, -k2], [-k2, k2]])
        return eigh(held, np.diag(masses[1:]), eigvals_only=True)

    step = 1e-6
    slopes = [(squares(x + step * h) - squares(x - step * h)) / (2 * step) for h in np.eye(2)]
    # In logarithms of the factors, over the distance of the bounds.
    wanted = np.array(slopes).T / squares(x)[:, None] * x * np.log(1.25 / 0.8)
    np.testing.assert_allclose(sensitivities(problem, x), wanted, rtol=1e-5)


def test_two_parameters_with_one_effect_are_told_together():
    """Two springs in series with nothing measured between them; in parallel they would be the same term."""
    model = ar.MassSpringChain([1.0, 1e-6, 1.0], [500.0, 500.0], ground_first_n_per_m=300.0)
    hz = model.antiresonances(0, 0)[:1]  # of the two nearly massless springs, one mode
    problem = ar.UpdatingProblem(
        model, ar.stiffness_factor([0, 1], bounds=(0.8, 1.25)), ar.AntiresonanceSet(0, {0: hz})
    )
    found = ar.identifiability(problem, points=8, forces=[], sensors=[])
    assert found.told == 1
    (words,) = found.words
    assert "against" in words
    assert words.endswith("both together are")
    (one,) = [text for text in found.suggestions if text.startswith("One parameter for")]
    assert "stiffness of spring 0 and stiffness of spring 1" in one


def test_the_expected_width_is_that_of_the_intervals():
    """What is promised before the test against the spread of the posterior after it."""
    model = ar.MassSpringChain([1.0, 1.5, 0.8, 1.2], [4e4, 3e4, 5e4], ground_first_n_per_m=3e4)
    parameters, rng = ar.stiffness_factor([0, 1], bounds=(0.7, 1.3)), np.random.default_rng(11)
    before = ar.UpdatingProblem(model, parameters, [virtual(model, range(4), force) for force in (0, 3)])
    promised = ar.identifiability(before, noise=2e-3, forces=[], sensors=[])
    spread = []
    for seed in range(8):
        true = model.with_parameters(parameters, rng.uniform(0.75, 1.25, 2))
        zeros = []
        for force in (0, 3):
            exact = true.antiresonances(range(4), force)
            hz = {i: f * (1.0 + 2e-3 * rng.standard_normal(f.size)) for i, f in enumerate(exact)}
            zeros.append(ar.AntiresonanceSet(force, hz, std_hz={i: 2e-3 * f for i, f in hz.items()}))
        found = ar.update(ar.UpdatingProblem(model, parameters, zeros), rng=seed).intervals()
        spread.append((found.high - found.low) / 3.29)
    # Medians over truths: an error of the model may be suspected in some, which widens.
    ratio = np.median(spread, axis=0) / (promised.left * np.log(1.3 / 0.7) / np.sqrt(12.0))
    assert np.all((ratio > 0.7) & (ratio < 1.4))


def test_modes_and_the_same_answer_twice():
    case = ar.cases.chain8()
    problem = case.updating_problem(case.exact_modes())
    one, two = (ar.identifiability(problem, points=8) for _ in range(2))
    assert one == two
    assert one.words[0] == "a common scale of the parameters; their ratios are"
    assert not any("force" in words for words in one.suggestions)


def test_combinations_in_words():
    together, against = np.array([[0.7, 0.6, 0.0, 0.0], [0.7, -0.5, -0.4, 0.0]])
    assert combination_in_words("abcd", together) == "a together with b; their ratio is"
    assert combination_in_words("abcd", against) == "a against b and c"


def test_wrong_arguments_are_refused():
    problem = ar.cases.chain8().updating_problem()
    for argument, value in (("points", 1), ("noise", 0.0), ("problem", "problem")):
        assert_refused(argument, ar.identifiability, **({"problem": problem} | {argument: value}))
    assert_refused("forces[0]", ar.identifiability, problem, forces=[99])
