"""Intervals of updated parameters: against quadrature, rejection and calibration, and in words."""

from functools import cache

import numpy as np
import pytest
from scipy.linalg import eigh

import antires_rs as ar
from antires_rs.updating import posterior
from antires_rs.updating.discrepancy import likely_errors
from antires_rs.updating.identifiability import combination_in_words, sensitivities
from reference.calibration import QUICK
from tests.support.snapshots import refusals

#: Quantiles of 2,000 independent draws: 0.05 of a distribution lies within 0.005 of its place (one sigma).
DRAWS = 2000


@cache
def springs(true=(550.0, 480.0), error=2e-3, scatter=0.0, seed=0, bounds=(0.8, 1.2)):
    rng = np.random.default_rng(seed)
    chain, sets = ar.MassSpringChain([2.0, 1.0, 1.0], list(true)), []
    for force in (0, 2):
        exact = chain.antiresonances([0, 1, 2], force)
        hz = {i: f * (1.0 + (error + scatter) * rng.standard_normal(f.size)) for i, f in enumerate(exact)}
        sets.append(ar.AntiresonanceSet(force, hz, std_hz={i: error * f for i, f in enumerate(exact)}))
    nominal = ar.MassSpringChain([2.0, 1.0, 1.0], [500.0, 500.0])
    return ar.update(ar.UpdatingProblem(nominal, ar.stiffness_factor([0, 1], bounds=bounds), sets), rng=0)


def noisy_chain8(perturbation, seed, error, stated):
    """The chain of eight with every mass and spring unknown, and the result of its search."""
    case, rng = ar.cases.chain8(perturbation=perturbation, rng=seed), np.random.default_rng(seed)
    hz = {i: f * (1.0 + error * rng.standard_normal(f.size)) for i, f in case.truth()["freq_hz"].items()}
    std = {i: error * f for i, f in hz.items()} if stated else None
    return case, ar.update(case.updating_problem(ar.AntiresonanceSet(0, hz, std_hz=std)), rng=1)


@pytest.fixture(scope="module")
def free_chain():
    """Mass 0 is unseen, the scale too."""
    return noisy_chain8(0.08, 5, 5e-4, stated=True)


@pytest.mark.parametrize("method", ["laplace", "ensemble"])
def test_two_springs_against_quadrature(method, monkeypatch):
    """The posterior on a grid, the errors of the model summed over, each value's own."""
    monkeypatch.setattr(posterior, "likely_errors", lambda *given: None)
    result = springs(error=1e-2)
    found = result.intervals(method, draws=DRAWS)
    grid = np.linspace(0.8, 1.2, 121)
    points = np.array([(a, b) for a in grid for b in grid])
    e = np.array([result.problem.residuals(x) for x in points])
    s = np.full(e.shape[1], 2e-2)
    tau = np.exp(np.linspace(np.log(0.2 * s[0]), np.log(0.3), 200))
    log = [np.log(0.5) - np.log(s).sum() - 0.5 * np.sum((e / s) ** 2, axis=1)]
    for t in tau:
        sigma = np.hypot(s, t)
        log.append(np.log(0.5 / tau.size) - np.log(sigma).sum() - 0.5 * np.sum((e / sigma) ** 2, axis=1))
    density = np.exp(np.array(log) - np.max(log)).sum(axis=0).reshape(121, 121)
    for column in range(2):
        mass = density.sum(axis=1 - column)
        marginal = (np.cumsum(mass) - 0.5 * mass) / mass.sum()
        draws = found.draws[:, column]
        below = np.interp(np.quantile(draws, [0.05, 0.25, 0.5, 0.75, 0.95]), grid, marginal)
        # Quantiles of the draws have a scatter of 0.011 at most; the tangent differs more at errors of 1 %.
        within = 0.033 if method == "ensemble" else 0.05
        np.testing.assert_allclose(below, [0.05, 0.25, 0.5, 0.75, 0.95], atol=within)


def test_what_a_model_lacks_moves_values_as_springs_and_masses_do():
    """Against finite differences; the mean of both families and of a factor on all."""
    problem = springs().problem
    chain, step, families = problem.model_at(problem.nominal), 1e-6, []
    k, m, zeros = chain.stiffness(), chain.mass(), problem.paired_hz(problem.nominal)

    def moved(stiffness, mass):
        other = ar.UpdatingProblem(ar.MatrixModel(stiffness, mass, stiffness_terms=[stiffness]),
                                   ar.stiffness_factor(0, bounds=(0.9, 1.1)), problem.measured)  # fmt: skip
        return (other.paired_hz([1.0]) / zeros) ** 2 - 1.0

    for kind in (0, 1):
        columns = []
        for dof in np.eye(3):
            more = step * [500.0, 1.0][kind] * np.outer(dof, dof)
            columns.append(moved(k + more * (kind == 0), m + more * (kind == 1)))
        columns = [own / np.sqrt(np.mean(own**2)) for own in columns if np.abs(own).max() > 1e-9]
        families.append(np.mean([np.outer(own, own) for own in columns], axis=0))
    wanted = np.mean([*families, np.ones((zeros.size, zeros.size))], axis=0)
    found = likely_errors(problem, problem.nominal, np.ones(zeros.size, dtype=bool))
    np.testing.assert_allclose(found, wanted, atol=1e-4)
    assert np.trace(found) == pytest.approx(zeros.size)


def held_chain(seed, far_hz=()):
    """Springs of a chain whose third mass has a spring to ground, and of response 1 values of nothing."""
    rng = np.random.default_rng(seed)
    true = rng.uniform(0.95, 1.05, 5)
    chain = ar.MassSpringChain([1.0, 1.5, 0.8, 1.2, 1.0, 0.9], [4e4, 3e4, 5e4, 4e4, 3e4])
    parameters = ar.stiffness_factor(range(5), bounds=(0.8, 1.2))
    tested = chain.with_parameters(parameters, true)
    held = tested.stiffness() + 600.0 * np.outer(np.eye(6)[2], np.eye(6)[2])
    zeros = ar.MatrixModel(held, tested.mass()).antiresonances(range(6), 0)
    hz = {i: f * (1.0 + 3e-4 * rng.standard_normal(f.size)) for i, f in enumerate(zeros)}
    hz[1] = np.append(hz[1], far_hz)
    measured = ar.AntiresonanceSet(0, hz, std_hz={i: 3e-4 * f for i, f in hz.items()})
    return ar.update(ar.UpdatingProblem(chain, parameters, measured), optimizer=QUICK, rng=seed), true


def test_intervals_hold_where_the_model_lacks_a_support():
    """Seeds that no limit was set on."""
    inside = []
    for seed in range(700, 706):
        found, true = held_chain(seed)
        told = found.intervals()
        inside += ((told.low <= true) & (true <= told.high)).tolist()
    assert np.mean(inside) > 0.85


def test_what_a_model_lacks_widens_what_least_squares_say_and_moves_nothing():
    """The covariance of least squares under errors that are correlated (White 1982)."""
    found, _ = held_chain(700)
    fit = posterior.fitted(found.problem, found.x)
    alone, alike = fit.alone, likely_errors(found.problem, found.x, fit.residuals.kept)
    np.testing.assert_array_equal(fit.u, alone.u)
    led = np.linalg.pinv(alone.weighted) / alone.sigma
    errors = np.diag(alone.residuals.stated**2) + fit.errors.tau[fit.middle] ** 2 * (
        alike + np.eye(len(alike))
    )
    np.testing.assert_allclose(posterior.variances(fit), np.diag(led @ errors @ led.T), rtol=1e-6)
    assert np.all(posterior.variances(fit) > posterior.variances(alone))


def test_where_no_parameter_is_seen_and_the_model_is_wrong_they_are_flat():
    case = ar.cases.chain8(perturbation=0.1, rng=3)
    hz = case.truth()["freq_hz"]
    zeros = ar.AntiresonanceSet(0, hz, std_hz={i: 1e-4 * f for i, f in hz.items()})
    problem = ar.UpdatingProblem(case.model, ar.mass_factor([0], bounds=(0.9, 1.1)), zeros)
    assert ar.update(problem, optimizer=QUICK, rng=0).intervals().words == ("flat",)


def test_a_value_that_nothing_in_the_model_is_near_does_not_lead_the_fit():
    told, off = (held_chain(700, far)[0].intervals() for far in ((), (150.0,)))
    assert "Left out, without a partner near them in the model: 150 Hz." in off.notes
    np.testing.assert_allclose([off.low, off.high], [told.low, told.high], atol=2e-3)


def test_same_seed_same_bits(free_chain):
    _, result = free_chain
    one, two = (result.intervals("ensemble", draws=100, rng=3, workers=w) for w in (1, 2))
    assert one == two
    assert result.intervals(draws=100, rng=3) == result.intervals(draws=100, rng=3)
    assert not np.array_equal(one.draws, result.intervals("ensemble", draws=100, rng=4).draws)


def test_what_is_not_seen_gets_the_bounds_back(free_chain):
    case, result = free_chain
    found = result.intervals()
    assert found["mass 0"] == (0.9, 1.1)
    assert found.words[0] == "flat"
    others = found.words[1:]
    assert all(words.startswith(("one-sided", "two-sided, through the bounds of others")) for words in others)
    truth = case.truth()
    x = np.r_[truth["mass_factor"], truth["stiffness_factor"]]
    assert np.sum((found.low <= x) & (x <= found.high)) >= 13
    assert result.profile("mass 0", points=5).kind == "flat"
    assert any(result.profile("stiffness of spring 3", points=9).others_on_bound)
    ratio = found.draws[:, 5] / found.draws[:, 9]  # Ratios are known to about the errors of the values.
    assert ratio.std() < 0.01
    assert result.interval == result.intervals().interval


def test_the_model_error_is_told_and_widens(free_chain):
    clean, spoilt = springs(error=5e-4), springs(error=5e-4, scatter=5e-3, seed=3)
    assert clean.chi_square < 10.0 < spoilt.chi_square
    assert clean.intervals().model_error == 0.0
    assert spoilt.intervals().model_error > 2e-3
    assert np.all(spoilt.intervals().std > 3.0 * clean.intervals().std)
    _, result = free_chain
    assert 0.3 < result.chi_square < 2.5


def test_one_sided_at_the_bound_and_fixed_where_damage_was_decided_to_be_none():
    result = springs(error=2e-3, bounds=(0.8, 1.1))
    found = result.intervals()
    assert found.words[0] == "one-sided: its upper bound fits as well"
    assert found["stiffness of spring 0"][1] == 1.1
    held = result.profile("stiffness of spring 0")
    assert held.kind == "one-sided"
    assert held.high == 1.1
    assert held.rise.min() == 0.0
    case = ar.cases.chain8()
    found = ar.assess_damage(case.model, case.exact(1), rng=1).intervals()
    assert [words == "fixed" for words in found.words] == [True] * 4 + [False] + [True] * 2
    assert found.low[0] == found.high[0] == 0.0
    assert found.low[4] < 0.55 < found.high[4]


def test_a_profile_ends_where_the_refitted_sum_of_squares_says():
    from scipy.optimize import brentq, minimize_scalar

    result = springs(error=2e-3)
    held = result.profile("stiffness of spring 0", level=0.9)
    assert held.kind == "two-sided"

    def least(f, low, high):
        return minimize_scalar(f, bounds=(low, high), method="bounded", options={"xatol": 1e-10})

    def squares(a):
        return least(lambda b: np.sum((result.problem.residuals([a, b]) / 4e-3) ** 2), 0.8, 1.2).fun

    best, limit = least(squares, 1.05, 1.15), 1.6448536**2
    ends = (1.0, best.x), (best.x, 1.19)
    low, high = (brentq(lambda a: squares(a) - best.fun - limit, *between) for between in ends)
    # The ends are interpolated between points whose roots of the rise differ by a quarter of the limit's.
    assert held.high == pytest.approx(high, abs=0.02 * (high - low))
    assert held.low == pytest.approx(low, abs=0.02 * (high - low))


def test_errors_that_are_not_stated_are_learned_and_modes_have_intervals_too():
    _, result = noisy_chain8(0.05, 2, 1e-3, stated=False)
    found = result.intervals()
    assert np.isnan(found.chi_square)
    assert any("are stated" in note for note in found.notes)
    assert 1e-3 < found.model_error < 4e-3  # of omega squared, the truth is 2e-3
    assert f"{50 * found.model_error:.2g} %" in str(found)
    case = ar.cases.chain8(perturbation=0.05, rng=3)
    exact, rng = case.exact_modes(), np.random.default_rng(3)
    shapes = exact.shapes * (1.0 + 0.01 * rng.standard_normal(exact.shapes.shape))
    modes = ar.ModalSet(exact.freq_hz * (1.0 + 1e-3 * rng.standard_normal(7)), shapes, exact.dofs)
    parameters = ar.stiffness_factor(range(7), bounds=(0.9, 1.1))
    masses, nominal = np.diag(case.true_model().mass()), ar.cases.chain8().model.stiffness()[0, 0]
    known = ar.MassSpringChain(masses, np.full(7, nominal))
    result = ar.update(ar.UpdatingProblem(known, parameters, modes), rng=0)
    truth = np.diag(case.true_model().stiffness(), 1) / known.stiffness()[0, 1]
    found = result.intervals()
    assert np.sum((found.low <= truth) & (truth <= found.high)) >= 5
    assert np.all(found.std < 0.03)


# ---- What a test could tell, asked before it: against closed forms, finite differences, and what helps
def virtual(model, dofs, force=0):
    return ar.AntiresonanceSet(force, dict(zip(dofs, model.antiresonances(dofs, force), strict=True)))


@pytest.fixture(scope="module")
def chain8():
    return ar.identifiability(ar.cases.chain8().updating_problem(), points=16, forces=[7], sensors=[])


def test_what_no_antiresonance_sees_is_named_all_over_the_box(chain8):
    assert chain8.told == 13
    assert chain8.left[0] == pytest.approx(1.0, abs=1e-6)
    assert set(chain8.words) == {"mass 0", "a common scale of the parameters; their ratios are"}
    assert np.all(chain8.singular_values[:, 13:] < 1e-3)
    assert np.all(chain8.singular_values[:, 12] > 1.0)


def test_what_helps_does(chain8):
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
        return eigh(np.array([[k1 + k2, -k2], [-k2, k2]]), np.diag(masses[1:]), eigvals_only=True)

    step = 1e-6
    slopes = [(squares(x + step * h) - squares(x - step * h)) / (2 * step) for h in np.eye(2)]
    # In logarithms of the factors, over the distance of the bounds.
    wanted = np.array(slopes).T / squares(x)[:, None] * x * np.log(1.25 / 0.8)
    np.testing.assert_allclose(sensitivities(problem, x), wanted, rtol=1e-5)


def test_two_parameters_with_one_effect_are_told_together():
    model = ar.MassSpringChain([1.0, 1e-6, 1.0], [500.0, 500.0], ground_first_n_per_m=300.0)
    hz = model.antiresonances(0, 0)[:1]  # of the two nearly massless springs, one mode
    springs = ar.stiffness_factor([0, 1], bounds=(0.8, 1.25))
    problem = ar.UpdatingProblem(model, springs, ar.AntiresonanceSet(0, {0: hz}))
    found = ar.identifiability(problem, points=8, forces=[], sensors=[])
    assert found.told == 1
    (words,) = found.words
    assert "against" in words
    assert words.endswith("both together are")
    (one,) = [text for text in found.suggestions if text.startswith("One parameter for")]
    assert "stiffness of spring 0 and stiffness of spring 1" in one


def test_the_expected_width_is_that_of_the_intervals():
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
    assert combination_in_words("abcd", against) == "a against b, c"


def test_wrong_names_and_numbers_are_refused():
    asked = {"found": springs(), "problem": ar.cases.chain8().updating_problem()}
    refusals(__file__, "wrong_questions.txt", globals() | asked)
