"""Penalties that grow with the data: the same data given three times leave elements and severities."""

from itertools import product

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.cases.chain8 import MASSES_KG, SPRINGS_N_PER_M
from tests.support.campaign import some_of
from tests.support.tolerances import GENE_AGREEMENT

CASE = ar.cases.chain8()
SPRINGS = ar.stiffness_reduction(range(7))
#: Mean difference in omega**2 that an element has to explain.
SHARE = 0.1 / 28


def off(rng, size, percent=3.0):
    return 1.0 + 0.01 * percent * rng.uniform(-1.0, 1.0, size)


def disturbed_chain(seed, damaged, loss):
    """The chain with every mass and spring off by up to 3 %, and one spring damaged."""
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
    """A plane frame of pipes, clamped at one end, force across its middle; stiffnesses off by up to 2 %."""
    nodes = [(0.0, 0.0), (0.4, 0.0), (0.8, 0.0), (1.1, 0.3), (1.1, 0.7), (0.6, 0.9)]
    model = ar.FrameModel(
        nodes, [(i, i + 1) for i in range(5)], ar.Tube(0.04, 2e-3, 210e9, 7850.0), fixed=[0]
    )
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
    assert any("gamma1 = 0.1 and gamma2 = 0.07 outweigh" in note for note in one.notes)


@pytest.mark.parametrize(("misfit", "grows"), [("absolute", 3.0), ("squared", 3.0), ("largest", 1.0)])
def test_the_whole_objective_grows_as_the_misfit_does(misfit, grows):
    _, measured = chain(1)
    given = {"misfit": misfit, "penalty": "scaled"}
    once, thrice = (ar.UpdatingProblem(CASE.model, SPRINGS, [measured] * n, **given) for n in (1, 3))
    rng = np.random.default_rng(0)
    for x in rng.uniform(0.0, 0.9, (5, 7)) * (rng.random((5, 7)) < 0.5):
        assert thrice.cost(x) == pytest.approx(grows * once.cost(x), rel=1e-12)
    # What it stands for: a difference of 0.36 % in every value.
    unit = {"absolute": 28 * SHARE, "squared": 28 * SHARE**2, "largest": SHARE}[misfit]
    assert once.penalty.gamma1 == pytest.approx(unit)


@pytest.mark.parametrize("weights", [0, [], [-1.0, 2.0], [0.0, 0.0], "std"])
def test_scaled_refuses_what_counts_nothing(weights):
    with pytest.raises(ar.InvalidInputError, match="weights"):
        ar.DamagePenalty.scaled(weights)
