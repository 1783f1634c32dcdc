"""Probability of detection: predictions against whole assessments, bits, Ctrl-C, what is never found."""

import pickle
from concurrent.futures import Future

import numpy as np
import pytest

import antires_rs as ar
from antires_rs.planning import simulated_tests
from antires_rs.planning.detection_curves import fit_logit
from tests.support.campaign import some_of

#: Not among the structures of the study (benchmarks/detectability_study.py).
CHAIN = ar.MassSpringChain([0.9, 1.1, 0.8, 1.3, 1.0], [5e4, 6e4, 4.5e4, 7e4])
TEST = {"excitation": 0, "std": 5e-4, "rng": 4}


@pytest.mark.parametrize("n_tests", some_of([20, 40]))
def test_a_prediction_is_what_assessments_find(n_tests):
    predicted = ar.detectability(CHAIN, [2], **TEST)
    simulated = ar.detectability(CHAIN, [2], **TEST, method="simulated", n_tests=n_tests)
    # 40 tests tell a90 to about 14 %, 20 to about 20 %.
    assert simulated.a90[2] == pytest.approx(predicted.a90[2], rel=0.35)
    assert simulated.a50[2] < simulated.a90[2] <= simulated.a90_95[2]
    assert np.all(np.diff(predicted.pod[2]) >= 0.0)
    assert simulated.false_call_rate <= 0.04
    assert predicted.false_call_rate <= 0.02


def test_noise_a_worse_model_and_a_threshold_cost_detection():
    def worst(**options):
        return max(ar.detectability(CHAIN, [0, 3], **{**TEST, "n_tests": 4, **options}).a90.values())

    base = worst()
    assert worst(std=2e-3) > 2.5 * base
    # More false calls are allowed, so less is missed.
    assert worst(false_alarm_rate=0.3) < base


class Pickles:
    """An executor that sends its tasks as another process would get them."""

    def submit(self, *call):
        run, *args = pickle.loads(pickle.dumps(call))
        future = Future()
        future.set_result(run(*args))
        return future


def test_the_same_seed_gives_the_same_bits():
    runs = [ar.detectability(CHAIN, [1, 2], **TEST, n_tests=2, workers=n) for n in (1, 2)]
    for e in (1, 2):
        assert runs[0].pod[e].tobytes() == runs[1].pod[e].tobytes()
    options = {**TEST, "method": "simulated", "n_tests": 10, "severities": [0.003, 0.05]}
    one, two = (ar.detectability(CHAIN, [2], **options, workers=w) for w in (1, Pickles()))
    assert one.tests[2].tobytes() == two.tests[2].tobytes()
    assert one.a90 == two.a90
    assert one.tests[2][0, 0] == pytest.approx(0.003)
    assert one.tests[2][0, -1] == pytest.approx(0.05)


def test_ctrl_c_leaves_what_is_there(monkeypatch):
    count = 0

    def judged(test, task):
        nonlocal count
        count += 1
        if count > 31:
            raise KeyboardInterrupt
        return () if task.place is None else ((2,) if task.severity > 0.02 else ())

    monkeypatch.setattr(simulated_tests, "judged", judged)
    options = {**TEST, "method": "simulated", "n_tests": 40, "severities": [0.003, 0.2]}
    curves = ar.detectability(CHAIN, [2], **options)
    assert curves.interrupted
    assert curves.n_tests == 31
    assert 0.015 < curves.a90[2] < 0.03
    assert "stopped before the end" in str(curves)


def test_a_spring_under_the_force_is_never_found():
    held = ar.MassSpringChain([1.0, 1.1, 0.9], [5e4, 6e4], ground_first_n_per_m=3e4)
    curves = ar.detectability(held, [0, 1, 2], **TEST, n_tests=2)
    never = [e for e, a in curves.a90.items() if a == np.inf]
    assert [curves.names[e] for e in never] == ["first ground spring"]
    assert "never" in str(curves)
    assert min(a for a in curves.a90.values()) < 0.02


def test_values_known_very_well_leave_no_large_damage_unseen():
    """Between the severities of its grid the quick judge is linear, which errors of 1e-5 do not forgive."""
    chain = ar.MassSpringChain([1.1, 0.9, 1.0, 1.2, 0.8], [500.0, 450.0, 550.0, 480.0])
    severities = [0.001, 0.01, 0.1, 0.2, 0.3, 0.45]
    found = ar.detectability(chain, excitation=0, std=1e-5, severities=severities, n_tests=4, rng=3)
    for element in (1, 2, 3):
        assert found.pod[element].min() > 0.9, element


# -- Curves of detection: known ones are found again, with their bounds
def draw(rng, n, a90=0.05, slope=4.0):
    severity = np.geomspace(0.01, 0.3, n)
    share = 1.0 / (1.0 + np.exp(-np.log(9.0) - slope * np.log(severity / a90)))
    return severity, rng.uniform(size=n) < share


def test_a_known_curve_is_found_again():
    curve = fit_logit(*draw(np.random.default_rng(0), 4000))
    assert curve.a90 == pytest.approx(0.05, rel=0.06)
    assert curve.slope == pytest.approx(4.0, rel=0.06)
    assert curve.a50 == pytest.approx(0.05 * 9.0 ** (-1 / 4.0), rel=0.06)
    assert curve.at(np.array([curve.a90, curve.a50])) == pytest.approx([0.9, 0.5])


def test_the_bound_holds_in_95_of_100_studies():
    rng = np.random.default_rng(1)
    held = sum(fit_logit(*draw(rng, 60)).bound >= 0.05 for _ in range(150))
    assert 0.90 * 150 <= held <= 0.995 * 150


@pytest.mark.parametrize("hits", [0, 2])
def test_what_is_hardly_ever_found_is_never_found_surely(hits):
    severity = np.geomspace(0.01, 0.9, 40)
    found = np.zeros(40, dtype=bool)
    found[5 : 5 + hits] = True
    curve = fit_logit(severity, found)
    assert curve.a90 > 0.99
    assert curve.bound == np.inf
