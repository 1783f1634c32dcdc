"""The island search on Python objectives: contract, not performance."""

from functools import partial

import numpy as np
import pytest

import antires_rs as ar
from tests.support.tolerances import SPHERE
from tests.support.worker_tasks import sphere, spheres

BOX = [(-1.0, 1.0)] * 3
SHORT = {"max_evaluations": 2000}


@pytest.mark.parametrize("islands", [1, 4, 6])
def test_finds_the_minimum_and_says_why_it_ended(islands):
    result = ar.IslandGA(islands=islands).minimize(sphere, BOX, rng=0)
    assert result.success
    assert result.status in (("stagnated",) if islands == 1 else ("agreed", "cost agreed"))
    assert result.populations.shape[0] == islands
    assert result.fun == sphere(result.x)
    if islands == 4:
        np.testing.assert_allclose(result.x, 0.3, atol=SPHERE)
        assert "agree" in result.message or "one solution" in result.message


def test_shapes_and_order_of_the_outcome():
    result = ar.IslandGA(islands=3, population=10, max_evaluations=1000).minimize(sphere, BOX, rng=2)
    assert result.populations.shape == (3, 10, 3)
    assert result.population_costs.shape == (3, 10)
    assert result.history.cost.shape == (result.nit + 1, 3)
    assert result.history.nfev.shape == (result.nit + 1,)
    assert np.all(np.diff(result.history.cost, axis=0) <= 0)
    assert np.all(np.diff(result.history.nfev.astype(int)) >= 0)
    assert result.history.nfev[-1] == result.nfev
    assert result.history.cost[-1].min() == result.fun
    costs = [[sphere(x) for x in island] for island in result.populations]
    np.testing.assert_array_equal(result.population_costs, costs)
    assert np.all((result.populations >= -1) & (result.populations <= 1))


def test_the_budget_of_evaluations_generations_and_time_is_never_exceeded():
    calls = []

    def counted(x):
        calls.append(1)
        return sphere(x)

    for budget in (1, 17, 160, 500):
        calls.clear()
        result = ar.IslandGA(max_evaluations=budget).minimize(counted, BOX, rng=0)
        assert result.nfev == len(calls) <= budget
        assert (result.status, result.success) == ("budget", False)
        assert "evaluations" in result.message
    for word, option in (("generations", {"max_generations": 5}), ("time", {"max_seconds": 0.0})):
        result = ar.IslandGA(**option).minimize(sphere, BOX, rng=0)
        assert (result.status, result.nit) == ("budget", option.get("max_generations", 0))
        assert word in result.message


def test_a_whole_generation_is_one_call():
    sizes = []

    def batch(candidates):
        sizes.append(len(candidates))
        return spheres(candidates)

    result = ar.IslandGA(**SHORT).minimize(batch, BOX, rng=0, vectorized=True)
    assert sizes[0] == 4 * 40
    assert sum(sizes) == result.nfev
    assert len(sizes) <= result.nit + 1


WRONG = [(lambda X: spheres(X)[:-1], r"shape \(159,\)"), (lambda X: X, r"shape \(160, 3\)")]
WRONG += [(lambda X: 1.0, r"shape \(\)"), (lambda X: ["a"] * len(X), "not numeric")]
WRONG += [(lambda X: None, r"shape \(\)|not numeric"), (lambda X: spheres(X) + 0j, "complex")]
WRONG += [(lambda X: np.full(len(X), np.nan), "no finite cost for any of 160 candidates")]


@pytest.mark.parametrize(("fun", "got"), WRONG)
def test_a_wrong_answer_of_the_objective_is_named(fun, got):
    with pytest.raises(ar.ObjectiveError, match=f"^fun: got .*{got}.*; wanted 160 real costs"):
        ar.IslandGA().minimize(fun, BOX, rng=0, vectorized=True)
    with pytest.raises(ar.ObjectiveError, match="^fun: got .*wanted 160 real costs"):
        ar.IslandGA().minimize(lambda x: x, BOX, rng=0)  # a vector for one candidate


def test_guesses_are_kept():
    guess = [0.3, 0.3, 0.3]
    for x0 in (guess, [[0.9, 0.9, 0.9], guess]):
        result = ar.IslandGA(max_generations=0).minimize(sphere, BOX, rng=0, x0=x0)
        assert result.fun == 0.0
        np.testing.assert_array_equal(result.x, guess)


def searched(native, **options):
    if native:
        return ar.update(ar.cases.chain8().damage_problem(), rng=0, **options).search
    return ar.IslandGA().minimize(sphere, BOX, rng=0, **options)


@pytest.mark.parametrize("native", [False, True])
def test_the_callback_sees_the_state_and_can_stop(native):
    states = []

    def watch(state):
        states.append(state)
        return len(states) == 3

    result = searched(native, callback=watch)
    assert (result.status, result.success) == ("callback", False)
    assert len(states) == 3
    last = states[-1]
    assert set(last) == {"nit", "nfev", "fun", "x", "islands", "migrations"}
    assert (last["nit"], last["fun"]) == (result.nit, result.fun)
    assert [state for _, state in last["islands"]] == ["searching"] * 4


@pytest.mark.parametrize("where", ["fun", "callback", "native callback", "vectorized"])
def test_exceptions_of_the_user_come_out_unchanged(where):
    error = ZeroDivisionError("as it was raised")

    def fail(_):
        raise error

    if "callback" in where:
        call = partial(searched, "native" in where, callback=fail)
    else:
        call = partial(ar.IslandGA(**SHORT).minimize, fail, BOX, rng=0, vectorized=where == "vectorized")
    with pytest.raises(ZeroDivisionError) as caught:
        call()
    assert caught.value is error


def test_options_in_force_are_shown_and_the_algorithm_as_printed_is_one_call():
    options = ar.IslandGA(population=20, crossovers=("blend",)).options
    assert (options["population"], options["islands"], options["max_evaluations"]) == (20, 4, 200_000)
    assert options["crossovers"] == ["blend"]
    assert (options["polish"], options["polish_interval"], options["polish_evaluations"]) == (None, 10, 1000)
    assert ar.IslandGA().options["crossovers"] == ["arithmetic", "heuristic", "blend", "uniform"]
    assert repr(ar.IslandGA()) == "IslandGA(islands=4, population=40)"
    for wrong in ({"polish": "yes"}, {"polish_interval": 0}, {"crossovers": [3]}, {"agreement": 1}):
        with pytest.raises(ar.InvalidInputError, match=next(iter(wrong))):
            ar.IslandGA(**wrong)
    printed = {"polish": False, "improvement_tolerance": 0.0, "agreement": "genes", "gene_tolerance": 0.0}
    ga = ar.IslandGA.paper(max_evaluations=3000)
    assert {name: ga.options[name] for name in printed} == printed
    others = {name: value for name, value in ga.options.items() if name not in (*printed, "max_evaluations")}
    assert all(value == ar.IslandGA().options[name] for name, value in others.items())
    assert ga.minimize(sphere, BOX, rng=0).status in ("agreed", "budget")
    assert ar.IslandGA.paper(patience=7, polish=None).options["polish"] is None
    assert ar.IslandGA(polish=False).options["agreement"] == "genes-or-cost"


def test_a_polished_function_has_exact_zeros():
    def penalised(x):
        misfit = np.abs(x - np.array([0, 0, 0.55, 0, 0, 0, 0])).sum()
        return float(misfit + 0.1 * x.sum() + 0.1 * np.count_nonzero(x))

    result = ar.IslandGA(polish=True, max_evaluations=6000).minimize(penalised, [(0, 0.99)] * 7, rng=0)
    np.testing.assert_allclose(result.x, [0, 0, 0.55, 0, 0, 0, 0], atol=1e-5)
    assert np.count_nonzero(result.x) == 1
