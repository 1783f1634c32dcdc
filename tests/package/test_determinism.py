"""The same seed gives the same bytes, whatever the number of threads (row 9)."""

import numpy as np
import pytest

import antires_rs as ar
from tests.support.campaign import some_of

CASE = ar.cases.chain8()
#: Small enough for a test, large enough for migrations, the point where islands meet.
SEARCH = {"max_evaluations": 6000, "patience": 5, "improvement_tolerance": 0.02}


def everything(result):
    search, history = result.search, result.search.history
    arrays = search.x, history.nfev, history.cost, history.migrations
    arrays += search.populations, search.population_costs
    numbers = [search.fun.hex(), search.nfev, search.nit, search.status, search.message]
    return [np.ascontiguousarray(a).tobytes() for a in arrays] + numbers


@pytest.mark.parametrize("polish", [None, False])
@pytest.mark.parametrize("seed", some_of(range(5), kept=2))
def test_identical_bytes_for_1_2_3_and_8_threads(seed, polish):
    off = ar.cases.chain8(perturbation=0.08, rng=seed)
    problem = CASE.damage_problem() if seed % 2 else off.updating_problem()
    ga = ar.IslandGA(**SEARCH, polish=polish)
    first, *others = (ar.update(problem, optimizer=ga, rng=seed, workers=threads) for threads in (1, 2, 3, 8))
    # Polished, the islands find the one damage before they ever meet.
    assert (first.history.migrations.size > 0) != (polish is None and seed % 2 == 1)
    for other in others:
        assert everything(other) == everything(first)


def test_other_seeds_give_other_searches():
    problem = CASE.damage_problem()
    ga = ar.IslandGA(**SEARCH)
    assert len({everything(ar.update(problem, optimizer=ga, rng=seed))[4] for seed in range(5)}) == 5


def test_equal_generators_agree_and_the_seed_in_the_result_repeats_the_run():
    problem, ga = CASE.damage_problem(), ar.IslandGA(max_evaluations=1000)
    first, second = (ar.update(problem, optimizer=ga, rng=np.random.default_rng(4)) for _ in range(2))
    again = ar.update(problem, optimizer=ga, rng=first.seed)
    assert everything(second) == everything(first)
    assert everything(again) == everything(first)
    assert ar.update(problem, optimizer=ga, rng=4).seed == 4


def test_python_and_rust_searches_of_one_objective_agree():
    """The same candidates in the same order: without derivatives the search does not know who computes the
    cost. The nominal values are among the first in both: an updating gives nothing worse than these."""
    problem, ga = CASE.updating_problem(), ar.IslandGA(max_evaluations=2000, polish=False)
    inside = ar.update(problem, optimizer=ga, rng=6, x0=problem.nominal)
    outside = ga.minimize(problem.evaluate_many, problem.bounds, rng=6, vectorized=True, x0=problem.nominal)
    assert outside.x.tobytes() == inside.x.tobytes()
    assert outside.populations.tobytes() == inside.search.populations.tobytes()
