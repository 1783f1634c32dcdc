"""Weights and standard deviations of what was found."""

import re

import numpy as np
import pytest

import antires_rs as ar

CASE = ar.cases.chain8()


def weighted_problem(**options):
    chain = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 500.0])
    measured = ar.AntiresonanceSet(0, {0: [1.6, 5.2], 1: [2.6]}, std_hz={0: [0.1, 0.001], 1: [0.02]})
    return ar.UpdatingProblem(chain, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), measured, **options)


@pytest.mark.parametrize(
    ("misfit", "norm"),
    [
        ("absolute", lambda e: np.abs(e).sum()),
        ("squared", lambda e: (e**2).sum()),
        ("largest", lambda e: np.abs(e).max()),
    ],
)
def test_weights_multiply_the_residuals(misfit, norm):
    x = [0.9, 1.1]
    given = np.array([0.5, 2.0, 0.0])
    problem = weighted_problem(misfit=misfit, weights=given)
    assert problem.cost(x) == pytest.approx(norm(given * problem.residuals(x)), rel=1e-12)


def test_weights_from_the_uncertainty_of_the_values():
    problem = weighted_problem(weights="std")
    expected = 1.0 / np.hypot(2.0 * np.array([0.1, 0.001, 0.02]) / problem.measured_hz, 2e-3)
    assert np.allclose(problem.weights, expected / expected.mean(), rtol=1e-12)
    x = [0.9, 1.1]
    assert problem.cost(x) == pytest.approx(np.abs(problem.weights * problem.residuals(x)).sum(), rel=1e-12)


@pytest.mark.parametrize("weights", ["variance", [1.0], [1.0, -1.0, 1.0], np.zeros(3), [np.nan, 1.0, 1.0]])
def test_weights_that_cannot_be(weights):
    with pytest.raises(ar.InvalidInputError, match="weights"):
        weighted_problem(weights=weights)


def test_std_weights_need_standard_deviations():
    chain = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 500.0])
    with pytest.raises(ar.InvalidInputError, match="std_hz"):
        ar.UpdatingProblem(
            chain,
            ar.stiffness_factor([0], bounds=(0.8, 1.2)),
            ar.AntiresonanceSet(0, {0: [1.6]}),
            weights="std",
        )


def test_standard_deviations_are_those_of_repeated_measurements():
    """Five springs of a chain held at one end, zeros with 0.3 % of noise: 40 updates scatter as foretold."""
    masses, springs, truth = np.ones(6), np.full(5, 500.0), np.array([1.05, 0.97, 1.02, 0.94, 1.01])
    model = ar.MassSpringChain(masses, springs, ground_first_n_per_m=300.0)
    parameters = ar.stiffness_factor(range(5), bounds=(0.8, 1.2))
    tested = ar.MassSpringChain(masses, springs * truth, ground_first_n_per_m=300.0)
    exact = dict(enumerate(tested.antiresonances(range(6), 0)))
    rng, scores = np.random.default_rng(7), []
    for _ in range(40):
        noisy = {
            dof: freq * (1 + 3e-3 * rng.standard_normal(freq.size))
            for dof, freq in exact.items()
            if freq.size
        }
        problem = ar.UpdatingProblem(model, parameters, ar.AntiresonanceSet(0, noisy), misfit="squared")
        result = ar.update(problem, rng=0)
        assert not result.identifiability.weak.any()
        scores.append((result.x - truth) / result.std)
    np.testing.assert_allclose(np.std(scores, axis=0), 1.0, atol=0.4)
    assert re.search(r"1\.0\d+ \u00b1 0\.0\d+ ", result.summary())


def test_what_nothing_tells_has_no_standard_deviation():
    chain = ar.MassSpringChain([2.0, 1.0, 1.0], [500.0, 400.0])
    zeros = ar.AntiresonanceSet(0, dict(enumerate(chain.antiresonances([0, 1, 2], 0))))
    # One response is dropped and all stiffness and mass may scale: only ratios are known.
    kinds = ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)) + ar.mass_factor([0, 1, 2], bounds=(0.8, 1.2))
    assert np.isinf(ar.update(ar.UpdatingProblem(chain, kinds, zeros), rng=0).std).all()
    damage = ar.assess_damage(chain, zeros, rng=0)
    assert np.isnan(damage.std).all()


def test_of_two_unknown_combinations_the_scale_is_one():
    """A chain on the ground, force at its end, whose mass is no parameter."""
    chain = ar.MassSpringChain([1.0] * 4, [500.0] * 3, ground_first_n_per_m=500.0)
    measured = ar.AntiresonanceSet(3, dict(enumerate(chain.antiresonances(range(4), 3))))
    every = ar.stiffness_factor(range(4), bounds=(0.9, 1.1)) + ar.mass_factor(range(3), bounds=(0.9, 1.1))
    result = ar.update(ar.UpdatingProblem(chain, every, measured), rng=0)
    assert result.identifiability.rank == 5
    assert result.notes == [
        "2 combinations of all parameters that are seen cannot be told: no measured "
        "antiresonance moves with them, a common scale among them (5 of 7 combinations "
        "are)."
    ]
    assert result.summary().count("not determined") == 7
