"""A Python objective on workers: the same bits, and the best so far whatever happens to it."""

import os
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

import antires_rs as ar
from tests.optimize.test_interrupt import after_sigint
from tests.support import worker_tasks as work
from tests.support.tolerances import INTERRUPT_S

BOX = [(-1.0, 1.0)] * 3
posix = pytest.mark.skipif(os.name != "posix", reason="signals as sent here are POSIX")

FIRST_GENERATION = """
import multiprocessing
from tests.support.worker_tasks import slow_sphere
threading.Timer({after}, lambda: print("under way", flush=True)).start()
result = endless.minimize(slow_sphere, [(-1, 1)] * 3, rng=0, workers={workers})
right = slow_sphere(result.x) == result.fun and multiprocessing.active_children() == []
print(result.status, result.nit, 0 < result.nfev < 160, right)
"""


def same(one, other):
    assert one.x.tobytes() == other.x.tobytes()
    assert one.history.cost.tobytes() == other.history.cost.tobytes()
    assert one.populations.tobytes() == other.populations.tobytes()
    assert one.population_costs.tobytes() == other.population_costs.tobytes()
    assert (one.fun, one.nfev, one.nit, one.status) == (other.fun, other.nfev, other.nit, other.status)


@pytest.mark.parametrize("workers", [None, 2], ids=str)
def test_an_exception_keeps_the_best_so_far(workers, tmp_path):
    with pytest.raises(ZeroDivisionError, match="in f") as caught:
        ar.IslandGA().minimize(work.Breaks(tmp_path, 300), BOX, rng=0, workers=workers)
    result = caught.value.result
    assert (result.status, result.success) == ("objective error", False)
    assert result.fun == work.sphere(result.x) < 1.0
    # The other worker ends what it has of the second generation, of 160 candidates.
    assert 160 <= result.nfev <= (320 if workers else 300)
    notes = "\n".join(caught.value.__notes__)
    assert "fun was at x = [" in notes
    assert "is kept: error.result" in notes


def test_a_wrong_answer_keeps_the_best_so_far():
    answers = iter([0.5] * 200 + ["a"] + [0.5] * 10**4)
    with pytest.raises(ar.ObjectiveError, match="not numeric") as caught:
        ar.IslandGA().minimize(lambda x: next(answers), BOX, rng=0)
    assert caught.value.result.fun == 0.5


@posix
def test_a_worker_that_dies_is_replaced(tmp_path):
    ga = ar.IslandGA(max_evaluations=400)
    found = ga.minimize(work.Breaks(tmp_path, 200, kill=True), BOX, rng=5, workers=2)
    same(found, ga.minimize(work.sphere, BOX, rng=5))


def test_the_same_bits_for_any_objective_and_workers():
    ga = ar.IslandGA(max_evaluations=600)
    one = ga.minimize(work.sphere, BOX, rng=5)
    same(one, ga.minimize(work.spheres, BOX, rng=5, vectorized=True))
    for workers in (1, 2, "threads"):
        same(one, ga.minimize(work.sphere, BOX, rng=5, workers=workers))
    with ThreadPoolExecutor(2) as pool:
        same(one, ga.minimize(work.sphere, BOX, rng=5, workers=pool))


@pytest.mark.parametrize("workers", [None, 2, "threads"], ids=str)
def test_a_time_limit_acts_in_the_first_generation(workers):
    start = time.monotonic()
    result = ar.IslandGA(max_seconds=1.0).minimize(work.slow_sphere, BOX, rng=0, workers=workers)
    assert time.monotonic() - start < 1.0 + INTERRUPT_S
    assert (result.status, result.nit) == ("budget", 0)
    assert "time" in result.message
    assert result.nfev < 160
    if result.nfev:  # processes may take longer to begin
        assert result.fun == work.slow_sphere(result.x)


@posix
def test_ctrl_c_acts_in_the_first_generation():
    """That of a terminal reaches workers too, which leave it to the caller."""
    calls = ((None, 0.5), (2, 3.0), (2, 3.0))
    told = after_sigint(*(FIRST_GENERATION.format(workers=n, after=s) for n, s in calls), to_group=(2,))
    for said, took in told:
        assert said == "interrupted 0 True True"
        assert took < INTERRUPT_S


def test_a_search_goes_on_from_its_checkpoint(tmp_path):
    ga = ar.IslandGA(max_evaluations=3000)
    whole = ga.minimize(work.sphere, BOX, rng=5)
    file, calls = tmp_path / "search.ckpt", []

    def breaks(x):
        calls.append(x)
        if len(calls) == 1500:
            raise ZeroDivisionError("in f")
        return work.sphere(x)

    with pytest.raises(ZeroDivisionError):
        ga.minimize(breaks, BOX, rng=5, checkpoint=file)
    before = len(calls)
    same(whole, ga.minimize(breaks, BOX, checkpoint=file))
    assert len(calls) - before < 1700
    with pytest.raises(ar.InvalidInputError, match="checkpoint: got search.ckpt, the search of another"):
        ga.minimize(work.sphere, [(0.0, 1.0)] * 3, checkpoint=file)
