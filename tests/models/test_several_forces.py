"""Antiresonances of order r: several responses and as many forces at once."""

from __future__ import annotations

import itertools
import warnings

import numpy as np
import pytest

import antires_rs as ar
from benchmarks.several_forces_model import KINDS, by_qz, random_model
from tests.support.refusals import refused
from tests.support.snapshots import refusals


@pytest.mark.parametrize("seed", [*range(40), 174])  # 174: far beyond the last resonance
def test_none_is_missed_and_none_invented(seed):
    rng = np.random.default_rng(seed)
    model = random_model(KINDS[seed % len(KINDS)], rng)
    r = 2 + seed // len(KINDS) % 2
    responses, forces = (tuple(rng.choice(model.n_dof, r, replace=False).tolist()) for _ in range(2))
    want = by_qz(model, responses, forces)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
        for method in ("modal", "pencil"):
            found = model.antiresonances(responses, forces, method=method, include_cancelled=True)
            np.testing.assert_allclose(found, want, rtol=1e-5)


def test_a_square_of_masses_has_coinciding_eigenvalues():
    """A 6 x 6 grid on springs to ground: modes of one frequency, among them pairs."""
    n = (6, 6)
    number = np.arange(36).reshape(n)
    k = 10.0 * np.eye(36)
    pairs = [
        *zip(number[:-1].flat, number[1:].flat, strict=True),
        *zip(number[:, :-1].flat, number[:, 1:].flat, strict=True),
    ]
    for i, j in pairs:
        k[[i, j], [i, j]] += 1e4
        k[[i, j], [j, i]] -= 1e4
    model = ar.MatrixModel(k, np.eye(36))
    for responses, forces in [((3, 17), (0, 8)), ((0, 35), (35, 0)), ((14, 3), (14, 6))]:
        shown = model.antiresonances(responses, forces)
        every = model.antiresonances(responses, forces, include_cancelled=True)
        assert every.size > shown.size
        assert np.all(np.min(np.abs(every[:, None] / shown - 1.0), axis=0) < 1e-9)
        np.testing.assert_allclose(every, by_qz(model, responses, forces), rtol=1e-4)


def test_bounds_hold_and_both_ways_agree_on_a_frame():
    case = ar.cases.exhaust()
    dofs, forces = case.responses, (case.excitation, case.responses[6])
    pairs = [(dofs[i], dofs[(i + 3) % 16]) for i in range(0, 16, 5)]
    quick = case.model.antiresonances(pairs, forces, f_max_hz=400.0)
    sure = case.model.antiresonances(pairs, forces, f_max_hz=400.0, bounds=True)
    for own, (hz, error) in zip(quick, sure, strict=True):
        assert own.size == hz.size > 2
        assert np.isfinite(error).all()
        assert np.all(np.abs(own - hz) <= error + 1e-8 * hz)


def test_order_does_not_matter_and_one_force_in_a_list_is_one_force():
    model = ar.cases.chain8().model
    one = model.antiresonances((1, 5), (0, 4))
    assert one.round(2).tolist() == [36.17, 58.52, 94.69, 101.36]
    for responses, forces in [((5, 1), (0, 4)), ((1, 5), (4, 0)), ((0, 4), (1, 5))]:
        np.testing.assert_allclose(model.antiresonances(responses, forces), one, rtol=1e-12)
    assert model.antiresonances([3], [0]).tolist() == model.antiresonances(3, 0).tolist()


def test_three_and_four_forces():
    model = ar.cases.chain8().model
    three = model.antiresonances((1, 3, 6), (0, 3, 6), include_cancelled=True)
    np.testing.assert_allclose(three, by_qz(model, (1, 3, 6), (0, 3, 6)), rtol=1e-9)
    four = model.antiresonances((0, 2, 4, 6), (0, 2, 4, 6), include_cancelled=True)
    assert four.size == 4


def test_forces_that_share_one_way_have_none():
    with pytest.warns(ar.exceptions.AntiresWarning, match="identically zero"):
        assert ar.cases.chain8().model.antiresonances((6, 7), (0, 1)).size == 0


MODEL = ar.cases.chain8().model


def test_what_is_refused():
    refusals(__file__, "wrong_forces.txt", globals())


def minors(model, forces, rng=None, std=3e-4, dofs=range(8)):
    """Values of all sets of responses, with errors."""
    ends = list(itertools.combinations(dofs, len(forces)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
        found = model.antiresonances(ends, forces, f_max_hz=130.0)
    hz = {end: own[own > 3.0] for end, own in zip(ends, found, strict=True)}
    if rng is not None:
        hz = {end: own * (1.0 + std * rng.standard_normal(own.size)) for end, own in hz.items()}
    stated = {end: std * own for end, own in hz.items()}
    return ar.AntiresonanceSet(forces, hz, std_hz=stated, sees="transmissibility", channels=dofs)


def test_slopes_are_those_of_differences():
    model, step = ar.cases.chain8().model, 1e-4
    parameters = ar.stiffness_factor(range(7), bounds=(0.5, 2.0)) + ar.mass_factor(
        range(8), bounds=(0.5, 2.0)
    )
    problem = ar.UpdatingProblem(model, parameters, [minors(model, (0, 4)), minors(model, (0, 2, 6))])
    x = np.random.default_rng(0).uniform(0.9, 1.1, len(parameters))
    core = problem._core
    _, hz, _, slopes = core.states(x[None], True, 1)[0]
    assert hz.size > 100
    for p in range(len(parameters)):
        rows = np.repeat(x[None], 4, axis=0)
        rows[:, p] += step * np.array([-2.0, -1.0, 1.0, 2.0])
        far_below, below, above, far_above = (state[1] for state in core.states(rows, False, 1))
        change = (8.0 * (above - below) - (far_above - far_below)) / (12.0 * step * hz)
        assert np.max(np.abs(change - slopes[:, p]) / np.abs(slopes).max(axis=1)) < 1e-6


def test_a_model_is_updated_from_two_unknown_forces_and_one_beside_them():
    rng, model = np.random.default_rng(3), ar.cases.chain8().model
    parameters = ar.stiffness_factor(range(7), bounds=(0.8, 1.2))
    truth = model.with_parameters(parameters, rng.uniform(0.9, 1.1, 7))
    for more in ([], [ar.AntiresonanceSet(0, dict(enumerate(truth.antiresonances(range(8), 0))))]):
        sets = [minors(truth, (0, 4), rng, std=1e-6, dofs=range(6)), *more]
        problem = ar.UpdatingProblem(model, parameters, sets)
        result = ar.update(problem, rng=0)
        assert result.table.largest_before_percent > 1.0 > 0.01 > result.table.largest_after_percent
        heading, first, *_ = str(result.table).splitlines()
        assert (heading.split()[:2], first.split()[:2]) == (["det", "H_IJ"], ["(I,", "J)"])
        assert "(mass 0, mass 1), (mass 0, mass 4)" in str(result.table)


def test_damage_is_found_between_two_tests_with_two_unknown_forces():
    rng, model = np.random.default_rng(5), ar.cases.chain8().model
    assessor = ar.Assessor(model, baseline=minors(model, (0, 4), rng), rng=0)
    damaged = model.with_parameters(ar.stiffness_reduction(4), 0.2)
    found = assessor.assess(minors(damaged, (0, 4), rng))
    assert found.damaged == [4]
    assert found.severity[4] == pytest.approx(0.2, abs=0.005)
    assert assessor.assess(minors(model, (4, 0), rng)).damaged == []
    refused("force", assessor.assess, minors(model, (0, 5), rng))


def test_a_plan_weighs_two_forces_at_once_against_one():
    model = ar.cases.chain8().model
    plan = ar.plan_test(model, n_sensors=4, excitations=[0, (0, 4)], std=5e-4)
    assert plan.excitation == (0, 4)
    assert "force at mass 0, mass 4" in str(plan)
    assert {*plan.excitations} == {0, (0, 4)}
    assert all(len(end) == 2 for end in plan.value_std)
    every = ar.plan_test(model, n_sensors=8, excitations=[(0, 4)], std=5e-4)
    assert every.value == pytest.approx(plan.value_of_all)


def test_of_pairs_of_places_the_one_is_planned_whose_tests_find_more():
    """Each spring with 2 % less, by simulated values; what is between two forces that meet is never found."""
    model, pairs = ar.cases.chain8().model, [(0, 7), (3, 4), (2, 6)]
    right = {}
    for pair in pairs:
        plan = ar.plan_test(model, n_sensors=4, excitations=[pair], std=5e-4)
        rng = np.random.default_rng(0)

        def test(structure, pair=pair, sensors=plan.sensors, rng=rng):
            return minors(structure, pair, rng, std=5e-4, dofs=sorted(sensors))

        assessor = ar.Assessor(model, baseline=[test(model)], rng=0)
        damaged = [model.with_parameters(ar.stiffness_reduction(spring), 0.02) for spring in range(7)]
        found = [assessor.assess([test(one)]).damaged for one in damaged]
        right[pair] = [spring for spring in range(7) if found[spring] == [spring]]
    best = ar.plan_test(model, n_sensors=4, excitations=pairs, std=5e-4)
    assert [*best.excitations] == [(2, 6), (0, 7), (3, 4)]
    assert right[2, 6] == [*range(7)]
    assert 3 not in right[3, 4]


def test_detectability_knows_two_forces():
    model = ar.cases.chain8().model
    how = {"excitation": (0, 4), "std": 5e-4, "n_tests": 2, "rng": 0}
    assert sorted(ar.detectability(model, [3, 4], sensors=[1, 3, 5, 6], **how).a90) == [3, 4]
