"""Searches and pools under fork, spawn, forkserver, joblib and threads, twenty of each: all right, no hang.

    python -m benchmarks.fork_study [COUNT [KIND ...]]

Each child runs a native search, an identification and, where it may begin processes, a search of a Python
function on two of them; the answers are those of the parent, which has used them all before.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import sys
import time
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import antires_rs as ar


def value(x):
    return float(np.sum((x - 0.3) ** 2))


def digest(pools):
    """What a child finds, in a few letters."""
    case = ar.cases.chain8(perturbation=0.08, rng=1)
    searched = ar.update(
        case.updating_problem(), optimizer=ar.IslandGA(max_evaluations=400), rng=0, workers=2
    )
    record = case.experiment(0, rng=0, duration_s=20.0)
    warnings.simplefilter("ignore", ar.AntiresWarning)  # the record is short
    zeros = ar.identify_antiresonances(record, excitation=0, band_hz=(3, 130), max_order=24)
    ga = ar.IslandGA(max_evaluations=200)
    found = ga.minimize(value, [(-1, 1)] * 3, rng=0, workers=2 if pools else "threads")
    parts = searched.x.tobytes() + found.x.tobytes() + str(zeros).encode()
    return hashlib.sha256(parts).hexdigest()[:12]


def send(pipe, pools):
    pipe.send(digest(pools))


def child(kind):
    """The answer of one child, or what became of it."""
    context = multiprocessing.get_context(kind)
    ours, theirs = context.Pipe()
    process = context.Process(target=send, args=(theirs, True))
    process.start()
    theirs.close()
    try:
        return ours.recv() if ours.poll(120.0) else "hangs"
    except EOFError:
        return "died"
    finally:
        process.kill()
        process.join()


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    right = digest(True)
    asked = sys.argv[2:] or ["fork", "spawn", "forkserver", "threads", "joblib"]
    for kind in [kind for kind in asked if kind in multiprocessing.get_all_start_methods()]:
        start = time.perf_counter()
        report(kind, [child(kind) for _ in range(count)], right, start)
    if "threads" in asked:
        start = time.perf_counter()
        with ThreadPoolExecutor(8) as threads:
            report("threads", list(threads.map(digest, [True] * count)), right, start)
    if "joblib" in asked:
        joblib(count, right)


def joblib(count, right):
    """The same in workers of joblib."""
    try:
        from joblib import Parallel, delayed
    except ImportError:
        print("joblib    not installed")
        return
    # By its module: what joblib sends of the main program cannot be sent on.
    from benchmarks.fork_study import digest as named

    start = time.perf_counter()
    report("joblib", Parallel(n_jobs=2)(delayed(named)(True) for _ in range(count)), right, start)


def report(kind, found, right, start):
    good = sum(one == right for one in found)
    wrong = sorted(set(found) - {right})
    print(
        f"{kind:11}{good} of {len(found)} right   {time.perf_counter() - start:.0f} s   {wrong}", flush=True
    )


if __name__ == "__main__":
    main()
