"""One door to all workers: the same results in order, losses, exceptions, and nothing left behind."""

import itertools
import multiprocessing
import os
import re
import subprocess
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from loky.process_executor import ShutdownExecutorError

import antires_rs as ar
from antires_rs.support.workers import Failed, Workers, in_order
from tests.support import worker_tasks as work
from tests.support.refusals import refused

SPAWN = multiprocessing.get_context("spawn")
SQUARES = [n * n for n in range(60)]


class SubmitOnly:
    """An executor of another make, which knows ``submit`` only."""

    def __init__(self, executor):
        self.executor = executor

    def submit(self, *args):
        return self.executor.submit(*args)


@pytest.mark.parametrize("workers", [None, 1, 2, "threads"], ids=str)
def test_results_come_in_order(workers):
    assert list(in_order(work.square, range(60), workers)) == SQUARES
    assert multiprocessing.active_children() == []


def test_executors_of_the_caller_stay_open():
    with ThreadPoolExecutor(2) as threads, ProcessPoolExecutor(2, SPAWN) as processes:
        for workers in (threads, processes, SubmitOnly(processes)):
            assert list(in_order(work.square, range(60), workers)) == SQUARES
        assert threads.submit(work.square, 3).result() == 9


#: Without a guard, the function in the program itself: as a file, from a pipe, and as a notebook does it.
PROGRAM = """
import antires_rs as ar
from antires_rs.support.workers import in_order
offset = 3
def moved(x):
    return x + offset
print(list(in_order(moved, range(4), 2)))
ga = ar.IslandGA(max_generations=1)
print(ga.minimize(lambda x: float(x[0] ** 2), [(-1, 1)], rng=0, workers=2).status)
"""


@pytest.mark.parametrize("how", ["a file", "stdin"])
def test_processes_need_no_guard_around_a_program(how, tmp_path):
    (tmp_path / "program.py").write_text(PROGRAM)
    command = [sys.executable, "-" if how == "stdin" else str(tmp_path / "program.py")]
    found = subprocess.run(command, input=PROGRAM, capture_output=True, text=True, timeout=60)
    assert (found.stdout, found.stderr) == ("[3, 4, 5, 6]\nbudget\n", "")


@pytest.mark.parametrize("workers", [None, 2])
def test_what_is_shared_comes_first(workers):
    assert list(in_order(work.scaled, range(3), workers, shared=7)) == [0, 7, 14]


def test_a_generator_is_read_a_little_ahead_only():
    read = []

    def tasks():
        for n in itertools.count():
            read.append(n)
            yield n

    results = in_order(work.nap, tasks(), "threads", seconds_a_chunk=0.02)
    assert list(itertools.islice(results, 10)) == list(range(10))
    results.close()
    assert len(read) < 10 + 40 * (os.cpu_count() or 1)


@pytest.mark.parametrize("workers", [None, 2, "threads"], ids=str)
def test_an_exception_is_raised_in_its_turn_with_the_number_of_its_task(workers):
    results = in_order(work.fails_at_seven, range(20), workers)
    assert list(itertools.islice(results, 7)) == list(range(7))
    with pytest.raises(ZeroDivisionError, match="seven") as caught:
        next(results)
    assert "This was task 7, counted from 0." in caught.value.__notes__
    given = list(in_order(work.fails_at_seven, range(9), workers, errors="return"))
    assert isinstance(given[7], Failed)
    assert isinstance(given[7].error, ZeroDivisionError)
    assert given[:7] == list(range(7))
    assert multiprocessing.active_children() == []


def test_no_process_is_left_whose_task_had_not_begun():
    """Cancelled before it began, a task stopped the thread of loky that ends the process."""
    workers = Workers(work.square, 2)
    results = workers.as_done(range(9))
    next(results)
    process = workers._executor._all[0]
    waiting = [process.submit(work.long_nap, 0) for _ in range(6)]  # loky hands over some
    workers._flying |= dict.fromkeys(waiting)
    workers.close()
    assert multiprocessing.active_children() == []
    assert all(isinstance(task.exception(0.0), ShutdownExecutorError) for task in waiting)


def test_a_result_that_does_not_travel_is_an_exception_of_its_task():
    (given,) = in_order(work.does_not_travel, [1], "processes", errors="return")
    assert "pickle" in str(given.error)


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_a_task_may_take_workers_along(tmp_path):
    assert list(in_order(work.kills, [(tmp_path, n, 4) for n in range(12)], 2)) == list(range(12))
    assert len(os.listdir(tmp_path)) == 4
    assert multiprocessing.active_children() == []
    with (
        ProcessPoolExecutor(2, SPAWN) as executor,
        pytest.raises(ar.InvalidInputError, match="ProcessPoolExecutor that is broken.*number of processes"),
    ):
        list(in_order(work.kills, [(tmp_path, n, 99) for n in range(12)], executor))


@pytest.mark.skipif(os.name != "posix", reason="needs SIGKILL")
def test_a_task_that_always_kills_is_given_up_alone(tmp_path):
    given = list(in_order(work.kills, [(tmp_path, n, 99) for n in range(8)], 2, losses=2, errors="return"))
    assert [n for n, one in enumerate(given) if isinstance(one, Failed)] == [5]
    error = given[5].error
    assert isinstance(error, ar.LostWorkerError)
    assert (error.task, error.losses, error.reason) == (5, 3, "exit code -9")
    assert "task 5 was given up: 3 workers" in str(error)


def test_processes_last_from_round_to_round_and_end_when_left_in_the_middle():
    with Workers(work.worker, 2, seconds_a_chunk=0.01) as workers:
        first, second = (set(workers.in_order(range(8))) for _ in range(2))
        assert first == second
        assert os.getpid() not in first
    assert multiprocessing.active_children() == []
    start = time.monotonic()
    workers = Workers(work.long_nap, 2)

    def enough():
        if time.monotonic() > start + 0.5:
            raise TimeoutError

    with pytest.raises(TimeoutError), workers:
        list(workers.as_done(range(4), poll=enough))
    assert time.monotonic() - start < 5.0
    assert multiprocessing.active_children() == []


def test_what_workers_cannot_be_is_said():
    for wrong in ("eight", 0, 2.5, True, 3000, object(), ProcessPoolExecutor, map):
        refused("^workers: got ", list, in_order(work.square, [1], wrong))
    refused("cannot be sent.*threads", list, in_order(threading.Lock().acquire, [1], 2))
    refused("tasks that cannot be sent", list, in_order(work.square, [threading.Lock()], 2))
    closed = ThreadPoolExecutor(1)
    closed.shutdown()
    refused("takes nothing", list, in_order(work.square, [1], closed))


def test_one_blas_thread_in_every_worker():
    pytest.importorskip("threadpoolctl")
    matrix = np.random.default_rng(0).normal(size=(300, 300))
    one, *others = (
        [each.tobytes() for each in in_order(np.linalg.inv, [matrix] * 3, workers)]
        for workers in (1, 2, "threads")
    )
    assert all(other == one for other in others)


def test_processes_inside_a_worker_of_joblib():
    joblib = pytest.importorskip("joblib")
    found = joblib.Parallel(n_jobs=2)(joblib.delayed(work.squares_by_two)(12) for _ in range(2))
    assert found == [SQUARES[:12]] * 2
    joblib.externals.loky.get_reusable_executor().shutdown()


# -- A Dask cluster that loses its scheduler


distributed = pytest.importorskip("distributed")


@pytest.mark.parametrize(
    ("scheduler", "said"), [("restarted", "all right"), ("gone", "Dask client .* call again")]
)
def test_a_run_goes_on_with_a_scheduler_that_comes_back_and_says_so_where_none_does(scheduler, said):
    command = [sys.executable, "-m", "tests.support.dask_scheduler", scheduler]
    found = subprocess.run(command, capture_output=True, text=True, timeout=150, check=True)
    assert re.search(said, found.stdout), found.stdout + found.stderr
