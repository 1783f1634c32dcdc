"""A planned test: what it promises, against an assessment; its forms and its print."""

import numpy as np
import pytest

import antires_rs as ar

CHAIN = ar.MassSpringChain([0.9, 1.1, 0.8, 1.3, 1.0, 0.7], [5e4, 6e4, 4.5e4, 7e4, 5.5e4])
STD = 4e-4


def exact(sensors, force):
    zeros = CHAIN.antiresonances(sensors, force)
    freq = dict(zip(sensors, zeros, strict=True))
    std = {dof: STD * f for dof, f in freq.items()}
    return ar.AntiresonanceSet(force, freq, std_hz=std, sees="transmissibility", channels=sensors)


def test_what_it_promises_is_what_an_assessment_tells_afterwards():
    plan = ar.plan_test(CHAIN, n_sensors=4, excitations=[0, 2], std=STD)
    sensors = sorted(plan.sensors)
    state = exact(sensors, plan.excitation)
    after = ar.assess_damage(CHAIN, state, baseline=state).detectable
    # The assessment also has the error of the model that the baseline leaves.
    for element, loss in plan.detectable.items():
        assert loss == pytest.approx(after[element], rel=0.25)
    assert plan.n_values == sum(len(state[dof]) for dof in state)


def test_no_random_set_is_better():
    plan = ar.plan_test(CHAIN, n_sensors=3, excitations=1, criterion="worst")
    rng = np.random.default_rng(0)
    for _ in range(12):
        chosen = rng.choice(6, 3, replace=False).tolist()
        other = ar.plan_test(CHAIN, n_sensors=3, candidates=chosen, excitations=1, criterion="worst")
        assert sorted(other.sensors) == sorted(chosen)
        assert other.value >= plan.value * (1.0 - 1e-9)
        assert other.value == max(other.detectable.values())


def test_the_search_through_all_sets_agrees():
    ours, best = (ar.plan_test(CHAIN, n_sensors=3, excitations=1, search=s) for s in ("greedy", "exhaustive"))
    assert sorted(ours.sensors) == sorted(best.sensors)
    assert ours.value == pytest.approx(best.value)


def test_the_best_force_is_first_and_more_sensors_tell_more():
    values = []
    for n in (2, 3, 4, 6):
        plan = ar.plan_test(CHAIN, n_sensors=n)
        ranked = list(plan.excitations.values())
        assert ranked == sorted(ranked, reverse=True)
        assert next(iter(plan.excitations)) == plan.excitation
        values.append(plan.value)
    assert values == sorted(values)
    assert values[-1] == plan.value_of_all


def test_of_parameters_it_tells_the_errors_that_are_left():
    unknowns = ar.mass_factor(range(6), bounds=(0.9, 1.1)) + ar.stiffness_factor(range(5), bounds=(0.9, 1.1))
    plan = ar.plan_test(CHAIN, unknowns, n_sensors=5, excitations=0)
    # The mass under the force moves no antiresonance; all others share one scale that nothing tells.
    assert plan.std["mass 0"] == pytest.approx(plan.std_before["mass 0"])
    assert max(plan.std[name] for name in plan.std if name != "mass 0") < 0.5 * plan.std_before["mass 0"]
    assert plan.detectable == {}
    assert "stiffness of spring 0" in str(plan)


def test_an_element_that_moves_nothing_is_never_seen():
    held = ar.MassSpringChain([1.0, 1.1, 0.9], [5e4, 6e4], ground_first_n_per_m=3e4)
    plan = ar.plan_test(held, [0, 1, 2], n_sensors=3, excitations=0)
    ground = next(e for e in (0, 1, 2) if plan.detectable[e] == np.inf)
    assert plan.names[ground] == "first ground spring"
    assert "never" in str(plan)
    assert plan.criterion == "determinant"


def test_frames_offer_their_translations_only():
    tube = ar.Tube(0.02, 0.002, 2.1e11, 7850.0)
    beam = ar.FrameModel([(0.2 * i, 0.0) for i in range(5)], [(i, i + 1) for i in range(4)], tube, fixed=[0])
    plan = ar.plan_test(beam, n_sensors=2, band_hz=(1.0, 800.0))
    assert all(not plan.labels[dof].endswith("theta") for dof in plan.labels)
    assert len(plan.labels) == 8


def test_threads_change_no_bit():
    one, two = (ar.plan_test(CHAIN, n_sensors=3, workers=n) for n in (1, 2))
    assert str(one) == str(two)
    assert one.std == two.std
    with pytest.raises(AttributeError, match="cannot assign"):
        one.value = 0.0


def test_it_says_which_errors_of_the_values_it_rests_on():
    bound = ar.plan_test(CHAIN, n_sensors=3, excitations=0)
    assert sorted(bound.value_std) == sorted(bound.sensors)
    assert sum(each.size for each in bound.value_std.values()) >= bound.n_values
    assert "Cramer-Rao bound for 1 % noise, 200 s and 1 % damping" in str(bound)
    noisier = ar.plan_test(CHAIN, n_sensors=6, excitations=0, noise=0.02)
    quieter = ar.plan_test(CHAIN, n_sensors=6, excitations=0)
    for dof, std in noisier.value_std.items():
        assert np.all(std >= quieter.value_std[dof])
    given = ar.plan_test(CHAIN, n_sensors=3, excitations=0, std=STD)
    assert all(np.all(each == STD) for each in given.value_std.values())
    assert "values known to 0.04 %: std as given" in str(given)
