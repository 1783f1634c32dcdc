"""A local Dask cluster of 1, 2 and 4 processes: speed beside a serial run, and runs whose workers are killed.

    python -m benchmarks.cluster_study [RUNS [--only-kills]]

Tasks keep one processor busy. Efficiency is that of the wall clock, which other programs of the machine
lower; ``at work`` is the share of the workers' time in which they had a task, ``dearer`` how much more
processor time a task took than alone. In every run with kills, one task takes four workers along, and others
are killed from outside at random; the results must be those of the serial run, bit for bit.
"""

from __future__ import annotations

import contextlib
import logging
import os
import random
import signal
import sys
import tempfile
import threading
import time
from pathlib import Path

from antires_rs.support.workers import in_order

TASKS, DEADLY = 40, 17


def busy(n):
    """Some 0.1 s of one processor; the sum, and what it took by both clocks."""
    wall, cpu = time.perf_counter(), time.process_time()
    total = 0.0
    for k in range(2_000_000):
        total += (n + k) * 1e-9
    return total, time.perf_counter() - wall, time.process_time() - cpu


def sums(found):
    """What must be the same, and the seconds of all tasks by both clocks."""
    totals, wall, cpu = zip(*found, strict=True)
    return totals, sum(wall), sum(cpu)


def deadly(folder, n):
    """The same, but one task takes the first four workers along that begin it."""
    if n == DEADLY and len(os.listdir(folder)) < 4:
        Path(folder, str(time.monotonic_ns())).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return busy(n)


def cluster(count):
    from distributed import Client, LocalCluster

    return Client(LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=":0"))


@contextlib.contextmanager
def connected(count, replaced=False):
    """A cluster; one whose workers that do not come back by themselves are ``replaced``, as a queue does."""
    client = cluster(count)
    if replaced:
        client.cluster.adapt(minimum=count, maximum=count)
    try:
        yield client
    finally:
        client.close()
        client.cluster.close()


def kill_at_random(client, over, seed, count):
    """Kill a worker every few seconds, when both are there: a cluster may lose a worker that only begins."""
    rng = random.Random(seed)
    while not over.wait(rng.uniform(2.0, 6.0)):
        with contextlib.suppress(Exception):
            pids = list(client.run(os.getpid).values())
            if len(pids) == 2:
                os.kill(rng.choice(pids), signal.SIGKILL)
                count.append(1)


def main():
    from benchmarks import cluster_study as named  # by its module, as workers find it

    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    counts = () if "--only-kills" in sys.argv else (1, 2, 4)
    logging.disable(logging.ERROR)
    start = time.perf_counter()
    right, _, cpu_alone = sums(in_order(named.busy, range(TASKS)))
    serial = time.perf_counter() - start
    for count in counts:
        with connected(count) as client:
            list(in_order(named.busy, range(2 * count), client))
            start = time.perf_counter()
            found, wall, cpu = sums(in_order(named.busy, range(TASKS), client))
            seconds, same = time.perf_counter() - start, found == right
            share = serial / seconds / min(count, os.cpu_count() or 1)
            print(
                f"{count} processes: {seconds:.1f} s of {serial:.1f}, efficiency {share:.0%}, "
                f"at work {wall / count / seconds:.0%}, dearer {cpu / cpu_alone - 1:.0%}, same {same}",
                flush=True,
            )
    for run in range(runs):
        with tempfile.TemporaryDirectory() as folder, connected(2, replaced=True) as client:
            over = threading.Event()
            killed: list[int] = []
            killer = threading.Thread(target=kill_at_random, args=(client, over, run, killed))
            killer.start()
            start = time.perf_counter()
            same = sums(in_order(named.deadly, range(TASKS), client, shared=folder))[0] == right
            seconds = time.perf_counter() - start
            over.set()
            killer.join()
            print(
                f"run {run}: {len(os.listdir(folder))} deaths by the task, {len(killed)} from outside, "
                f"{seconds:.0f} s, same {same}",
                flush=True,
            )


if __name__ == "__main__":
    main()
