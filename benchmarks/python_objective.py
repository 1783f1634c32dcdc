"""A Python objective of 50 ms, 160 a generation, on two workers: speed, and what goes wrong.

    python -m benchmarks.python_objective [--dask]

Two kinds of 50 ms: ``waits`` sleeps, as a function does that runs another program; ``computes`` keeps one
processor busy, so that its gain is what the machine has free. That is measured beside it: ``at work`` is
the share of the time that the workers spent in the function, ``dearer`` how much more processor time each
evaluation took than alone (two processors that share a core or a memory are not twice as fast as one), and
``possible`` is the gain of two workers that never wait.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import antires_rs as ar

BOX = [(-1.0, 1.0)] * 4
SECONDS = 0.05
GENERATIONS = 4


def value(x):
    return float(np.sum((x - 0.3) ** 2))


def waits(x):
    time.sleep(SECONDS)
    return value(x)


def computes(x):
    total = 0.0
    for n in range(_loops()):
        total += n * 1e-9
    return value(x) + 0.0 * total


class Timed:
    """The function, each evaluation with its seconds of wall clock and of processor in a file."""

    def __init__(self, fun, folder):
        self.fun, self.folder = fun, folder

    def __call__(self, x):
        """The value of the function."""
        wall, cpu = time.perf_counter(), time.process_time()
        found = self.fun(x)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        with Path(self.folder, str(os.getpid())).open("a", encoding="ascii") as file:
            file.write(f"{wall} {cpu}\n")
        return found


_LOOPS = []


def _loops():
    """Turns of a loop that take 50 ms of processor time on this machine; the same in every process."""
    if not _LOOPS:
        _LOOPS.append(int(os.environ.get("ANTIRES_LOOPS", "1000000")))
    return _LOOPS[0]


class Trouble:
    """The function, but for its evaluation number ``at``, which raises or kills its worker."""

    def __init__(self, folder, at, kill):
        self.folder, self.at, self.kill = folder, at, kill

    def __call__(self, x):
        """The value, or trouble."""
        count = len(os.listdir(self.folder))
        Path(self.folder, f"{os.getpid()}-{time.monotonic_ns()}").touch()
        if count == self.at:
            if self.kill:
                os.kill(os.getpid(), signal.SIGKILL)
            raise ZeroDivisionError("in f")
        return waits(x)


def main():
    start = time.process_time()
    for n in range(1_000_000):
        n * 1e-9
    os.environ["ANTIRES_LOOPS"] = str(int(1e6 * SECONDS / (time.process_time() - start)))
    with_dask = "--dask" in sys.argv
    ga = ar.IslandGA(max_generations=GENERATIONS)
    from benchmarks import python_objective as named  # by its module, as workers find it

    for fun in (named.waits, named.computes):
        serial, alone, _, cpu_alone = timed(ga, fun, None)
        for name, workers in kinds(with_dask):
            with workers as given:
                seconds, found, in_f, cpu = timed(ga, fun, given)
            same = found.population_costs.tobytes() == alone.population_costs.tobytes()
            possible = f"   dearer {cpu / cpu_alone - 1:.0%}   possible {2 * cpu_alone / cpu:.2f} x"
            print(
                f"{fun.__name__:9}{name:11}{serial / seconds:5.2f} x of {serial:5.1f} s   same bits {same}   "
                f"at work {in_f / (2 * seconds):.0%}{possible if fun is named.computes else ''}",
                flush=True,
            )
    troubles()


class Plain:
    """A value for a with statement."""

    def __init__(self, value):
        self.value = value

    def __enter__(self):
        return self.value

    def __exit__(self, *_):
        pass


def kinds(with_dask):
    yield "processes", Plain(2)
    if with_dask:
        yield "Dask", cluster()


class cluster:
    """A Dask client with two processes of one thread."""

    def __enter__(self):
        from distributed import Client, LocalCluster

        self.cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0")
        self.client = Client(self.cluster)
        return self.client

    def __exit__(self, *_):
        self.client.close()
        self.cluster.close()


def timed(ga, fun, workers):
    """Seconds, what was found, and seconds of wall clock and of processor in the function."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        found = ga.minimize(named_timed(fun, folder), BOX, rng=0, workers=workers)
        seconds = time.perf_counter() - start
        spent = np.concatenate([np.loadtxt(file, ndmin=2) for file in Path(folder).iterdir()])
    return seconds, found, *spent.sum(axis=0)


def named_timed(fun, folder):
    """By its module, as workers find it."""
    from benchmarks import python_objective as named

    return named.Timed(fun, folder)


def troubles():
    whole = ar.IslandGA(max_generations=1).minimize(value, BOX, rng=0)
    with tempfile.TemporaryDirectory() as folder:
        found = ar.IslandGA(max_generations=1).minimize(Trouble(folder, 90, True), BOX, rng=0, workers=2)
        print(
            "worker killed: same bits", found.population_costs.tobytes() == whole.population_costs.tobytes()
        )
    with tempfile.TemporaryDirectory() as folder:
        try:
            ar.IslandGA().minimize(Trouble(folder, 90, False), BOX, rng=0, workers=2)
        except ZeroDivisionError as error:
            print(f"exception: kept {error.result.fun:.3g} of {error.result.nfev} evaluations")
    for seconds in (1.0, 3.0):
        start = time.perf_counter()
        found = ar.IslandGA(max_seconds=seconds).minimize(waits, BOX, rng=0, workers=2)
        over = time.perf_counter() - start - seconds
        print(f"max_seconds={seconds:g}: {over:.2f} s over, {found.nfev} evaluations, {found.status}")
    for after in (0.3, 1.0, 2.5, 6.0):
        interrupted(after)


def interrupted(after):
    code = (
        "import signal, antires_rs as ar\nfrom benchmarks.python_objective import *\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\nprint('go', flush=True)\n"
        "r = ar.IslandGA().minimize(waits, BOX, rng=0, workers=2)\nprint(r.status, r.nfev)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
        process.stdout.readline()
        time.sleep(after)
        start = time.perf_counter()
        process.send_signal(signal.SIGINT)
        said = process.communicate()[0].strip()
        print(
            f"Ctrl-C after {after:g} s: {said}, ended {time.perf_counter() - start:.2f} s later", flush=True
        )


if __name__ == "__main__":
    main()
