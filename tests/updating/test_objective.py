"""The objectives of antiresonances and of modes: against numpy, pairing and weights, and wrong input."""

from itertools import product

import numpy as np
import pytest
import scipy.linalg

import antires_rs as ar
from antires_rs.cases.chain8 import MASSES_KG, SPRINGS_N_PER_M
from tests.support.campaign import some_of
from tests.support.snapshots import refusals
from tests.support.tolerances import COST, GENE_AGREEMENT

CASE = ar.cases.chain8()
RNG = np.random.default_rng(20)
SPRINGS = ar.stiffness_reduction(range(7))
NORMS = {"absolute": lambda e: np.abs(e).sum(), "squared": lambda e: np.sum(e**2)}
NORMS["largest"] = lambda e: np.abs(e).max()


def zeros(freq_hz, force=0, **options):
    return ar.AntiresonanceSet(force, freq_hz, **options)


# ---- against numpy -----------------------------------------------------------------------------------
def sub_chain_zeros(masses, springs, response):
    """Antiresonances of H_response,0 of a free chain: the masses beyond, clamped at the response."""
    beyond = np.asarray(masses)[response + 1 :]
    if beyond.size == 0:
        return np.empty(0)
    k = np.append(np.asarray(springs)[response:], 0.0)
    stiffness = np.diag(k[:-1] + k[1:]) - np.diag(k[1:-1], 1) - np.diag(k[1:-1], -1)
    return np.sqrt(scipy.linalg.eigvalsh(stiffness, np.diag(beyond))) / (2 * np.pi)


def penalty_cost(beta, gammas):
    return gammas[0] * np.sum(beta) + gammas[1] * np.count_nonzero(np.asarray(beta) > 0)


def cost_of_zeros(masses, springs, measured):
    """Eqs. 11-17 in numpy: nearest in Hz, ties to the lower, in 1.5 times the measured band, 1 if alone."""
    limit = 1.5 * max(f for freq in measured.values() for f in freq)
    cost = 0.0
    for dof, freq in measured.items():
        found = sub_chain_zeros(masses, springs, dof)
        found = found[found <= limit]
        for f in freq:
            cost += abs(found[np.argmin(np.abs(found - f))] ** 2 / f**2 - 1.0) if found.size else 1.0
    return cost


def mac(phi, psi):
    return abs(np.vdot(phi, psi)) ** 2 / (np.vdot(phi, phi) * np.vdot(psi, psi)).real


def cost_of_modes(stiffness, mass, measured):
    """Eq. 18 in numpy, with the pairing as documented."""
    lam, shapes = scipy.linalg.eigh(stiffness, mass)
    limit = (1.5 * 2 * np.pi * measured.freq_hz.max()) ** 2
    flexible = [r for r in range(lam.size) if 1e-9 * lam[-1] < lam[r] <= limit]
    cost = 0.0
    for freq, shape in zip(measured.freq_hz, measured.shapes, strict=True):
        goal = (2 * np.pi * freq) ** 2
        unlike = [(1 - mac(shape, shapes[measured.dofs, r])) ** 2 for r in flexible]
        pairs = [(abs(np.log(lam[r] / goal)) + u, u, r) for r, u in zip(flexible, unlike, strict=True)]
        _, u, r = min(pairs, default=(0, 1.0, None))
        cost += u + (1.0 if r is None else abs(lam[r] / goal - 1.0))
    return cost


def disturbed(modes, dofs, error, rng):
    """A measurement of exact modes: complex, scaled and turned at will, noisy, at a few dofs."""
    shapes = modes.shapes[:, dofs] / np.abs(modes.shapes).max(axis=1, keepdims=True)
    noise = rng.standard_normal((2, *shapes.shape)) * error
    factor = rng.uniform(0.1, 10.0, len(modes)) * np.exp(2j * np.pi * rng.random(len(modes)))
    freq = modes.freq_hz * (1.0 + 0.2 * error * rng.standard_normal(len(modes)))
    return ar.ModalSet(freq, (shapes + noise[0] + 1j * noise[1]) * factor[:, None], dofs)


def test_the_objective_of_zeros_is_the_independent_one():
    masses, springs = np.diag(CASE.model.mass()), -np.diag(CASE.model.stiffness(), 1)
    measured = {0: [10.0, 36.0, 80.0], 3: [21.0, 100.0], 6: [60.0], 7: [50.0]}
    problem = CASE.updating_problem(zeros(measured))
    for x in RNG.uniform(0.9, 1.1, (50, 15)):
        wanted = cost_of_zeros(masses * x[:8], springs * x[8:], measured)
        assert problem.cost(x) == pytest.approx(wanted, rel=COST)
    problem = ar.UpdatingProblem(CASE.model, SPRINGS, CASE.exact(1), penalty=(0.1, 0.3))
    for beta in RNG.uniform(0.0, 0.99, (50, 7)) * (RNG.random((50, 7)) < 0.4):
        wanted = cost_of_zeros(masses, springs * (1 - beta), dict(CASE.exact(1)))
        assert problem.cost(beta) == pytest.approx(wanted + penalty_cost(beta, (0.1, 0.3)), rel=COST)


@pytest.mark.parametrize("dofs", [list(range(8)), [6, 1], [3]])
def test_the_objective_of_modes_is_the_independent_one(dofs):
    measured = disturbed(CASE.exact_modes(1), dofs, 0.05, RNG)
    problem = ar.UpdatingProblem(CASE.model, SPRINGS, measured, penalty=(0.1, 0.3))
    betas = RNG.uniform(0.01, 0.99, (40, 7)) * (RNG.random((40, 7)) < 0.4)
    for beta in betas:
        model = problem.model_at(beta)
        wanted = cost_of_modes(np.asarray(model.stiffness()), np.asarray(model.mass()), measured)
        assert problem.cost(beta) == pytest.approx(wanted + penalty_cost(beta, (0.1, 0.3)), rel=COST)
    for workers in (1, 3):
        many = problem.evaluate_many(betas, workers=workers)
        np.testing.assert_array_equal(many, [problem.cost(b) for b in betas])


def test_a_frame_by_the_band_route_is_the_independent_one():
    nodes = [(0.0, 0.1 * i) for i in range(16)] + [(0.1 * i, 1.5) for i in range(1, 9)]
    beams = [(i, i + 1) for i in range(23)]
    model = ar.FrameModel(nodes, beams, ar.Tube(0.03, 0.002, 2.1e11, 7850.0), fixed=[0])
    dofs = [model.dof(node, "u") for node in (4, 9, 15)] + [model.dof(node, "v") for node in (18, 23)]
    parameters, damage = ar.stiffness_reduction(range(8)), np.where(np.arange(8) == 3, 0.6, 0.0)
    measured = disturbed(model.with_parameters(parameters, damage).modes(n_modes=6), dofs, 0.02, RNG)
    problem = ar.UpdatingProblem(model, parameters, measured)
    for beta in (damage, np.zeros(8), RNG.uniform(0.0, 0.9, 8)):
        there = problem.model_at(beta)
        wanted = cost_of_modes(there.stiffness().toarray(), there.mass().toarray(), measured)
        assert problem.cost(beta) == pytest.approx(wanted, rel=1e-7)


# ---- residuals, misfit, weights ----------------------------------------------------------------------
@pytest.mark.parametrize("misfit", NORMS)
@pytest.mark.parametrize("kind", ["zeros", "modes"])
def test_the_cost_is_the_norm_of_the_weighted_residuals(kind, misfit):
    if kind == "zeros":
        measured = zeros({0: [12.0, 37.0], 3: [21.0], 6: [57.0]})
    else:
        measured = disturbed(CASE.exact_modes(1), [0, 4, 7], 0.05, RNG)
    weights = RNG.uniform(0.2, 2.0, 4 if kind == "zeros" else 7)
    problem = ar.UpdatingProblem(CASE.model, SPRINGS, measured, misfit=misfit, weights=weights)
    for x in (np.zeros(7), RNG.uniform(0.0, 0.5, 7)):
        e = problem.residuals(x)
        e, shape = (e, np.zeros(4)) if kind == "zeros" else np.split(e, 2)
        np.testing.assert_allclose(e, (problem.paired_hz(x) / problem.measured_hz) ** 2 - 1.0, rtol=COST)
        assert kind == "modes" or x.any() or e.min() < 0 < e.max()
        wanted = NORMS[misfit](weights * e) + ((weights * shape) ** 2).sum()
        assert problem.cost(x) == pytest.approx(wanted, rel=COST)
        if kind == "modes":
            np.testing.assert_allclose(shape, 1.0 - problem.paired_mac(x), rtol=COST)


def test_several_sets_add_up():
    x, modes = RNG.uniform(0.0, 0.3, 7), CASE.exact_modes(1)
    ends = [zeros(dict(enumerate(CASE.true_model().antiresonances(range(8), f))), f) for f in (0, 7)]
    sensors = [
        ar.ModalSet(modes.freq_hz[:3], modes.shapes[:3][:, [0, 4]], [0, 4]),
        ar.ModalSet(modes.freq_hz[2:], modes.shapes[2:][:, [1, 6, 7]], [1, 6, 7]),
    ]
    for sets in (ends, sensors):
        alone = [ar.UpdatingProblem(CASE.model, SPRINGS, s).cost(x) for s in sets]
        assert ar.UpdatingProblem(CASE.model, SPRINGS, sets).cost(x) == pytest.approx(sum(alone), rel=COST)
    assert set(ar.UpdatingProblem(CASE.model, SPRINGS, ends).measured_excitations) == {0, 7}


def with_errors(**options):
    chain = ar.MassSpringChain([1.0, 1.0, 2.0], [500.0, 500.0])
    measured = zeros({0: [1.6, 5.2], 1: [2.6]}, std_hz={0: [0.1, 0.001], 1: [0.02]})
    return ar.UpdatingProblem(chain, ar.stiffness_factor([0, 1], bounds=(0.8, 1.2)), measured, **options)


def test_weights_from_the_uncertainty_of_the_values():
    problem = with_errors(weights="std")
    expected = 1.0 / np.hypot(2.0 * np.array([0.1, 0.001, 0.02]) / problem.measured_hz, 2e-3)
    np.testing.assert_allclose(problem.weights, expected / expected.mean(), rtol=1e-12)


def test_penalties_count_reductions_only_and_negligible_severities_are_zero():
    parameters = [*ar.stiffness_reduction([4]), *ar.mass_factor([2], bounds=(0.5, 1.5))]
    plain = ar.UpdatingProblem(CASE.model, parameters, CASE.exact(0))
    for snap, small in ((1e-3, 0.0), (0.0, 0.1 * 9e-4 + 0.2)):
        price = ar.DamagePenalty(0.1, 0.2, snap=snap)
        penal = ar.UpdatingProblem(CASE.model, parameters, CASE.exact(0), penalty=price)
        for x, penalty in (([0.0, 1.3], 0.0), ([0.5, 1.3], 0.05 + 0.2)):
            assert penal.cost(x) - plain.cost(x) == pytest.approx(penalty, abs=COST)
        evaluated = [0.0 if snap else 9e-4, 1.0]
        assert penal.cost([9e-4, 1.0]) == pytest.approx(plain.cost(evaluated) + small, abs=COST)


# ---- pairing -----------------------------------------------------------------------------------------
def test_a_repeated_mode_is_compared_by_its_space():
    term = np.diag([1.0, 1.0, 0.0])
    model = ar.MatrixModel(np.diag([400.0, 400.0, 900.0]), np.eye(3), stiffness_terms=[term])
    measured = ar.ModalSet([20.0 / (2 * np.pi)], [[0.8, -0.6j, 0.0]])
    problem = ar.UpdatingProblem(model, ar.stiffness_factor([0], bounds=(0.5, 2.0)), measured)
    assert problem.cost([1.0]) == pytest.approx(0.0, abs=1e-12)


def test_modes_without_a_partner_count_and_rigid_bodies_do_not():
    model = ar.MassSpringChain([1.0, 1.0], [500.0])
    measured = ar.ModalSet([5.0], [[1.0, -1.0]])
    problem = ar.UpdatingProblem(model, ar.stiffness_reduction([0], bounds=(0.0, 1.0)), measured)
    assert problem.cost([1.0]) == 2.0
    assert np.isnan([*problem.paired_hz([1.0]), *problem.paired_mac([1.0])]).all()
    np.testing.assert_array_equal(problem.residuals([1.0]), [1.0, 1.0])
    free = CASE.true_model(1).modes()
    assert free.freq_hz[0] == 0.0
    problem = CASE.damage_problem(free)
    np.testing.assert_array_equal(problem.measured_hz, free.freq_hz[1:])
    np.testing.assert_array_equal(ar.update(problem, rng=0).table.mode, range(1, 8))


# ---- wrong input -------------------------------------------------------------------------------------
def one_mode(freq_hz=20.0, shape=(1.0, -1.0), dofs=(0, 1)):
    return ar.ModalSet([freq_hz], [list(shape)], list(dofs))


def problem(measured, **options):
    return ar.UpdatingProblem(CASE.model, SPRINGS, measured, **options)


def test_measurements_weights_and_penalties_that_cannot_be():
    refusals(__file__, "wrong_problems.txt", globals())


def test_the_objective_must_be_that_of_the_measurement():
    kinds = {"modal": CASE.exact_modes(1), "antiresonance": CASE.exact(1)}
    for right, measured in kinds.items():
        assert ar.UpdatingProblem(CASE.model, SPRINGS, measured, objective=right).objective == right
        for wrong in (*(set(kinds) - {right}), "shapes"):
            with pytest.raises(ar.InvalidInputError, match="measured: got a|objective"):
                ar.UpdatingProblem(CASE.model, SPRINGS, measured, objective=wrong)
    problem = CASE.damage_problem(CASE.exact_modes(1))
    assert problem.measured_dofs is problem.measured_excitations is None
    assert "7 modes" in repr(problem)


# ---- Penalties that grow with the data: the same data given three times leave elements and severities
#: Mean difference in omega**2 that an element has to explain.
SHARE = 0.1 / 28


def off(rng, size, percent=3.0):
    return 1.0 + 0.01 * percent * rng.uniform(-1.0, 1.0, size)


def disturbed_chain(seed, damaged, loss):
    rng = np.random.default_rng(seed)
    masses, springs = MASSES_KG * off(rng, 8), SPRINGS_N_PER_M * off(rng, 7)
    springs[damaged] *= 1.0 - loss
    return ar.MassSpringChain(masses, springs)


def chain(seed):
    tested = disturbed_chain(seed, 4, 0.2)
    return CASE.model, ar.AntiresonanceSet(0, dict(enumerate(tested.antiresonances(range(8), 0))))


def chain_modes(seed):
    modes = disturbed_chain(seed, 2, 0.3).modes()
    return CASE.model, ar.ModalSet(modes.freq_hz[1:], modes.shapes[1:])


def frame(seed):
    nodes = [(0.0, 0.0), (0.4, 0.0), (0.8, 0.0), (1.1, 0.3), (1.1, 0.7), (0.6, 0.9)]
    pipe = ar.Tube(0.04, 2e-3, 210e9, 7850.0)
    model = ar.FrameModel(nodes, [(i, i + 1) for i in range(5)], pipe, fixed=[0])
    force = model.dof(2, "v")
    sensors = [model.dof(node, name) for node, name in ((1, "v"), (3, "u"), (4, "u"), (5, "v"))]
    factors = off(np.random.default_rng(seed), 5, 2.0)
    factors[2] *= 0.5
    tested = model.with_parameters(ar.stiffness_factor(range(5), bounds=(0.05, 1.5)), factors)
    zeros = tested.antiresonances(sensors, force, f_max_hz=900.0)
    return model, ar.AntiresonanceSet(force, dict(zip(sensors, zeros, strict=True)))


@pytest.mark.parametrize(
    ("tested", "seed"),
    some_of(product((chain, chain_modes, frame), (0, 8, 9, 14)), [(chain, 14), (chain_modes, 8), (frame, 9)]),
)
def test_the_same_data_three_times_leave_the_answer(tested, seed):
    model, measured = tested(seed)
    once, thrice = (ar.assess_damage(model, [measured] * n, rng=0) for n in (1, 3))
    assert once.damaged == thrice.damaged
    assert once.damaged
    np.testing.assert_allclose(thrice.x, once.x, atol=GENE_AGREEMENT)
    assert thrice.fun == pytest.approx(3.0 * once.fun, rel=GENE_AGREEMENT)


def test_the_papers_penalties_do_not_grow_and_can_be_had():
    model, measured = chain(14)
    given = {"search": ar.SearchOptions(gamma1=0.1, gamma2=0.1), "rng": 0}
    once, thrice = (ar.assess_damage(model, [measured] * n, **given) for n in (1, 3))
    assert once.problem.penalty == thrice.problem.penalty == ar.DamagePenalty()
    assert once.damaged == [4]
    assert len(thrice.damaged) > 1  # three times the misfit, and false damage earns its price


@pytest.mark.parametrize("weights", [None, "std", "given"])
def test_the_numbers_in_force_go_with_values_and_weights(weights):
    zeros = dict(CASE.exact(1))
    errors = {dof: 0.001 * (1 + dof) * freq for dof, freq in zeros.items()}
    measured = ar.AntiresonanceSet(0, zeros, std_hz=errors)
    factors = np.linspace(0.1, 2.0, 28) if weights == "given" else weights
    problem = ar.assess_damage(CASE.model, measured, search=ar.SearchOptions(weights=factors), rng=0).problem
    counted = np.ones(28) if problem.weights is None else problem.weights
    assert problem.penalty.gamma1 == problem.penalty.gamma2 == pytest.approx(SHARE * counted.sum())
    if weights != "given":
        assert problem.penalty.gamma1 == pytest.approx(0.1)


def test_chain8_has_the_papers_numbers_to_the_bit():
    assert ar.assess_damage(CASE.model, CASE.exact(1), rng=0).problem.penalty == ar.DamagePenalty()
    assert ar.DamagePenalty.scaled(28) == ar.DamagePenalty()
    modal = ar.UpdatingProblem(CASE.model, SPRINGS, CASE.exact_modes(1), penalty="scaled")
    assert modal.penalty.gamma2 == pytest.approx(SHARE * 14)  # each of 7 counts as two values
    one = ar.assess_damage(CASE.model, CASE.exact(1), search=ar.SearchOptions(gamma2=0.07), rng=0)
    assert one.problem.penalty == ar.DamagePenalty(0.1, 0.07)
    assert any("(gamma1 = 0.1 and gamma2 = 0.07) hides damage this small" in note for note in one.notes)
