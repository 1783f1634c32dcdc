"""The objective of antiresonances against an independent one in numpy."""

import numpy as np
import pytest
import scipy.linalg

import antires_rs as ar
from tests.support.tolerances import COST

CASE = ar.cases.chain8()
RNG = np.random.default_rng(20)


def sub_chain_zeros(masses, springs, response):
    """Antiresonances of H_response,0 of a free chain: the masses beyond, clamped at the response."""
    beyond = np.asarray(masses)[response + 1 :]
    if beyond.size == 0:
        return np.empty(0)
    k = np.append(np.asarray(springs)[response:], 0.0)
    stiffness = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    return np.sqrt(scipy.linalg.eigvalsh(stiffness, np.diag(beyond))) / (2 * np.pi)


def reference_cost(masses, springs, measured, beta=(), gammas=(0.0, 0.0)):
    """Eqs. 11-17 in numpy: nearest in Hz, ties to the lower, in 1.5 times the measured band, 1 if alone."""
    limit = 1.5 * max(f for freq in measured.values() for f in freq)
    cost = 0.0
    for dof, freq in measured.items():
        zeros = sub_chain_zeros(masses, springs, dof)
        zeros = zeros[zeros <= limit]
        for f in freq:
            if zeros.size == 0:
                cost += 1.0
                continue
            nearest = zeros[np.argmin(np.abs(zeros - f))]  # the first of equals: the lower
            cost += abs(nearest**2 / f**2 - 1.0)
    return cost + gammas[0] * np.sum(beta) + gammas[1] * np.count_nonzero(np.asarray(beta) > 0)


def masses_and_springs():
    return np.diag(CASE.model.mass()), -np.diag(CASE.model.stiffness(), 1)


def test_the_updating_objective_is_the_independent_one():
    masses, springs = masses_and_springs()
    measured = {0: [10.0, 36.0, 80.0], 3: [21.0, 100.0], 6: [60.0], 7: [50.0]}
    problem = CASE.updating_problem(ar.AntiresonanceSet(0, measured))
    for x in RNG.uniform(0.9, 1.1, (50, 15)):
        wanted = reference_cost(masses * x[:8], springs * x[8:], measured)
        assert problem.cost(x) == pytest.approx(wanted, rel=COST)


def test_the_damage_objective_is_the_independent_one_with_its_penalties():
    masses, springs = masses_and_springs()
    measured = dict(CASE.exact(1))
    problem = ar.UpdatingProblem(
        CASE.model, ar.stiffness_reduction(range(7)), CASE.exact(1), penalty=(0.1, 0.3)
    )
    for beta in RNG.uniform(0.0, 0.99, (50, 7)) * (RNG.random((50, 7)) < 0.4):
        wanted = reference_cost(masses, springs * (1 - beta), measured, beta, (0.1, 0.3))
        assert problem.cost(beta) == pytest.approx(wanted, rel=COST)


def test_penalties_count_reductions_only_and_only_if_asked_for():
    parameters = [*ar.stiffness_reduction([4]), *ar.mass_factor([2], bounds=(0.5, 1.5))]
    exact = ar.AntiresonanceSet(0, dict(enumerate(CASE.model.antiresonances(range(8), 0))))
    plain = ar.UpdatingProblem(CASE.model, parameters, exact)
    penal = ar.UpdatingProblem(CASE.model, parameters, exact, penalty=ar.DamagePenalty(0.1, 0.2))
    for x, penalty in (([0.0, 1.3], 0.0), ([0.5, 1.3], 0.05 + 0.2)):
        assert penal.cost(x) - plain.cost(x) == pytest.approx(penalty, abs=COST)


def test_pairing_is_nearest_in_hz_with_ties_to_the_lower():
    """A tie needs two zeros whose middle has the same distance to both in floating point too."""
    zeros = CASE.model.antiresonances(range(8), 0)
    dof, low, high = next(
        (dof, a, b)
        for dof, freq in enumerate(zeros)
        for a, b in zip(freq[:-1], freq[1:], strict=True)
        if 0.5 * (a + b) - a == b - 0.5 * (a + b)
    )
    middle = 0.5 * (low + high)
    for value, partner in ((middle, low), (middle * (1 + 1e-9), high), (middle * (1 - 1e-9), low)):
        problem = CASE.updating_problem(ar.AntiresonanceSet(0, {dof: [value]}))
        assert problem.paired_hz(problem.nominal)[0] == partner


def test_one_model_value_may_serve_several_measured_ones():
    problem = CASE.updating_problem(ar.AntiresonanceSet(0, {0: [12.0, 12.1, 12.2]}))
    assert len(set(problem.paired_hz(problem.nominal))) == 1


def test_partners_are_sought_to_one_and_a_half_times_the_measured_band():
    """Dof 6 has one zero, at 58.5 Hz: within reach of 40 Hz, out of reach of 38 Hz."""
    zero = CASE.model.antiresonances(6, 0)[0]
    for top, reached in ((zero / 1.49, True), (zero / 1.51, False)):
        problem = CASE.updating_problem(ar.AntiresonanceSet(0, {6: [top]}))
        assert np.isfinite(problem.paired_hz(problem.nominal)[0]) == reached
        assert problem.cost(problem.nominal) == pytest.approx((zero / top) ** 2 - 1 if reached else 1.0)


def test_a_response_without_antiresonance_counts_one_for_each_measured_value():
    problem = CASE.updating_problem(ar.AntiresonanceSet(0, {7: [20.0, 50.0]}))
    assert problem.cost(problem.nominal) == 2.0
    np.testing.assert_array_equal(problem.residuals(problem.nominal), [1.0, 1.0])
    assert np.all(np.isnan(problem.paired_hz(problem.nominal)))


def test_residuals_are_signed_and_add_up_to_the_cost():
    problem = CASE.updating_problem(ar.AntiresonanceSet(0, {0: [12.0, 37.0], 6: [57.0]}))
    residuals = problem.residuals(problem.nominal)
    paired = problem.paired_hz(problem.nominal)
    np.testing.assert_allclose(residuals, (paired / problem.measured_hz) ** 2 - 1.0, rtol=COST)
    assert residuals.min() < 0 < residuals.max()
    assert np.abs(residuals).sum() == pytest.approx(problem.cost(problem.nominal), rel=COST)


@pytest.mark.parametrize(
    ("misfit", "norm"),
    [
        ("absolute", lambda e: np.abs(e).sum()),
        ("squared", lambda e: np.sum(e**2)),
        ("largest", lambda e: np.abs(e).max()),
    ],
)
def test_the_misfit_is_the_norm_that_was_asked_for(misfit, norm):
    measured = ar.AntiresonanceSet(0, {0: [12.0, 37.0], 3: [21.0], 7: [50.0]})
    problem = ar.UpdatingProblem(
        CASE.model, ar.stiffness_factor(range(7), bounds=(0.9, 1.1)), measured, misfit=misfit
    )
    for x in RNG.uniform(0.9, 1.1, (5, 7)):
        assert problem.cost(x) == pytest.approx(norm(problem.residuals(x)), rel=COST)


def test_negligible_severities_are_evaluated_as_exactly_zero():
    problem = CASE.damage_problem()
    x = np.array([0.0, 9e-4, 0, 0, 0.55, 0, 0])
    rounded = np.where(x < 1e-3, 0.0, x)
    assert problem.cost(x) == problem.cost(rounded)
    as_printed = ar.UpdatingProblem(
        CASE.model, ar.stiffness_reduction(range(7)), CASE.exact(1), penalty=ar.DamagePenalty(snap=0.0)
    )
    assert as_printed.cost(x) > as_printed.cost(rounded) + 0.1


def test_several_positions_of_the_force_add_up():
    other = ar.AntiresonanceSet(7, dict(enumerate(CASE.true_model().antiresonances(range(8), 7))))
    parameters = ar.stiffness_factor(range(7), bounds=(0.9, 1.1))
    x = RNG.uniform(0.9, 1.1, 7)
    alone = [ar.UpdatingProblem(CASE.model, parameters, s).residuals(x) for s in (CASE.exact(), other)]
    both = ar.UpdatingProblem(CASE.model, parameters, [CASE.exact(), other])
    wanted = sum(np.abs(r).sum() for r in alone)
    np.testing.assert_allclose(np.abs(both.residuals(x)).sum(), wanted, rtol=COST)
    assert set(both.measured_excitations) == {0, 7}
