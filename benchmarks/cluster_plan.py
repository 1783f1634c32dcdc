"""A year of records on 1 to 512 workers, simulated: efficiency, load of the scheduler, where it breaks.

The rules are the package's own: chunks are given out, and given out again after losses, by the class that
does it in every run (``support/workers.py``). Only the clock is simulated. Measured first, on this
machine: the seconds of a few records of ``reference/year_of_tests.py``, and what a chunk costs scheduler and
caller, from rounds of empty tasks (on a Dask cluster of one process, where it is installed, else on processes
of our own). One queue serves hand-outs and answers; the network carries so many megabytes a second for all.

Two ways to run the campaign: ``files``, where a task is a path and workers read from a disk that all of them
share, and ``records``, where the caller sends every record. Workers are lost now and then, with what they
were doing, and are back after a minute. Run ``python -m benchmarks.cluster_plan --network 1000``.
"""

from __future__ import annotations

import argparse
import heapq
import importlib.util
import pickle
import time
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

import antires_rs as ar
from antires_rs.support.workers import AHEAD, Chunk, Dask, Schedule, in_order
from reference.year_of_tests import BAND_HZ, EXCITATION, hour_of_tests

WORKERS = (1, 2, 8, 16, 64, 128, 256, 512)
SAMPLE, ROUND = 8, 400
BACK_S = 60.0
#: What the package takes a chunk to cost the scheduler, whatever it does.
A_CHUNK_S = Dask.a_chunk_s


@dataclass(frozen=True)
class Costs:
    """Seconds of a task (drawn from those measured), of a chunk at the scheduler, and megabytes of a task."""

    task_s: np.ndarray
    chunk_s: float
    record_mb: float


def nothing(task: int) -> int:
    return task


def measured() -> Costs:
    """On this machine, in CPU seconds for the records and in seconds for the chunks."""
    seconds, size = [], 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for hour in range(-1, SAMPLE):  # the first call imports
            rec = hour_of_tests(max(hour, 0))[0]
            start = time.process_time()
            ar.identify_antiresonances(rec, excitation=EXCITATION, band_hz=BAND_HZ)
            seconds.append(time.process_time() - start)
            size = len(pickle.dumps(rec))
    return Costs(np.array(seconds[1:]), a_chunk(), size / 1e6)


def a_chunk() -> float:
    """Seconds of an empty chunk of one task, sent and answered, with one worker."""
    if importlib.util.find_spec("distributed") is None:
        return _rounds(2)
    from distributed import Client, LocalCluster

    options: dict[str, Any] = {"n_workers": 1, "threads_per_worker": 1, "dashboard_address": ":0"}
    with LocalCluster(**options) as cluster, Client(cluster) as client:
        return _rounds(client)


def _rounds(workers: Any) -> float:
    list(in_order(nothing, range(8), workers, seconds_a_chunk=0.0))
    start = time.perf_counter()
    list(in_order(nothing, range(ROUND), workers, seconds_a_chunk=0.0))
    return (time.perf_counter() - start) / ROUND


@dataclass(frozen=True)
class Outcome:
    """Of one simulated campaign."""

    hours: float
    efficiency: float
    scheduler: float
    network: float
    chunks: int
    lost: int


def campaign(
    costs: Costs, tasks: int, workers: int, sent: bool, network_mb_s: float, losses_an_hour: float, rng: Any
) -> Outcome:
    """Discrete events: (time, number, what, chunk); scheduler and network are queues of one."""
    schedule = Schedule(range(tasks), 1.0, 10, {}, None, A_CHUNK_S)
    work = rng.choice(costs.task_s, tasks)
    idle, busy_until, wire_until = workers, 0.0, 0.0
    scheduler = network = now = useful = 0.0
    events: list[tuple[float, int, str, Chunk | None]] = []
    number = chunks = lost = nth = 0
    while True:
        while idle:
            chunk = schedule.next(workers, AHEAD * workers + 2)
            if chunk is None:
                break
            idle, chunks, number = idle - 1, chunks + 1, number + 1
            # Half of a chunk's cost when it goes out, half when it comes back.
            busy_until = max(busy_until, now) + 0.5 * costs.chunk_s
            scheduler += 0.5 * costs.chunk_s
            carried = len(chunk.tasks) * costs.record_mb / network_mb_s
            wire_until = max(wire_until, busy_until if sent else now) + carried
            network += carried
            seconds = float(work[chunk.first : chunk.first + len(chunk.tasks)].sum())
            fails = rng.exponential(3600.0 / losses_an_hour) if losses_an_hour else np.inf
            begun = max(busy_until, wire_until)
            if fails < seconds:
                heapq.heappush(events, (begun + fails, number, "lost", chunk))
            else:
                useful += seconds
                heapq.heappush(events, (begun + seconds, number, "done", chunk))
        if not events:
            break
        now, _, what, chunk = heapq.heappop(events)
        if what == "back":
            idle += 1
            continue
        assert chunk is not None
        if what == "lost":
            lost += 1
            schedule.lost(chunk, "lost")
            number += 1
            heapq.heappush(events, (now + BACK_S, number, "back", None))
            continue
        busy_until = max(busy_until, now) + 0.5 * costs.chunk_s
        scheduler += 0.5 * costs.chunk_s
        seconds = float(work[chunk.first : chunk.first + len(chunk.tasks)].sum())
        schedule.done(chunk, [object()] * len(chunk.tasks), seconds)
        while nth in schedule.arrived:
            del schedule.arrived[nth]
            nth += 1
        idle += 1
    span = max(now, busy_until)
    assert nth == tasks, "a task was given up"
    return Outcome(span / 3600.0, useful / (workers * span), scheduler / span, network / span, chunks, lost)


def main() -> None:
    """The tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tasks", type=int, default=8760)
    parser.add_argument("--network", type=float, default=100.0, help="megabytes a second, 100 by default")
    parser.add_argument(
        "--losses", type=float, default=0.1, help="lost workers an hour for each, 0.1 by default"
    )
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    costs = measured()
    print(
        f"a record {costs.task_s.mean():.2f} CPU s ({costs.task_s.min():.2f} to {costs.task_s.max():.2f}), "
        f"{costs.record_mb:.2f} MB; a chunk {1e3 * costs.chunk_s:.1f} ms; {chosen.tasks} records"
    )
    alone = chosen.tasks * costs.task_s.mean() / 3600.0
    # One queue for all: with chunks of a second it is full at this number of workers.
    print(
        f"one worker: {alone:.2f} h; full: scheduler at {1.0 / costs.chunk_s:.0f} workers, network at "
        f"{chosen.network * costs.task_s.mean() / costs.record_mb:.0f}"
    )
    print("workers  task     hours  efficiency  scheduler  network  chunks  lost")
    for workers in WORKERS:
        for name, sent in (("files", False), ("records", True)):
            rng = np.random.default_rng([chosen.seed, workers])
            got = campaign(costs, chosen.tasks, workers, sent, chosen.network, chosen.losses, rng)
            shares = f"{got.efficiency:>10.0%}  {got.scheduler:>9.0%}  {got.network:>7.0%}"
            print(f"{workers:>7}  {name:<7}  {got.hours:>5.3f}  {shares}  {got.chunks:>6}  {got.lost:>4}")


if __name__ == "__main__":
    main()
