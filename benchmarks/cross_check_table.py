"""What the cross-check confirms of true and of random frequencies, by either method, on the eight-mass chain.

True: antiresonances identified within 1 % of a true one. Chance: frequencies drawn at random, 2 % or more
from any true one. Candidates: strong poles of the other method that were not identified. 1 % damping, 200 s.

    python -m benchmarks.cross_check_table
    python -m benchmarks.cross_check_table --noise 0.01 --seeds 1
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import time

import numpy as np

import antires_rs as ar
from antires_rs.identification.cross_check import METHODS, cross_check
from benchmarks.study_tools import add_options, each, print_table

BAND_HZ, TOL, APART, DRAWN = (3.0, 130.0), 0.01, 0.02, 100


def one_run(task):
    """By method: true ones confirmed, true ones, random ones confirmed, drawn, candidates, seconds."""
    noise, seed = task
    case = ar.cases.chain8()
    record = case.experiment(noise=noise, damping_ratio=0.01, duration_s=200.0, rng=seed)
    truth = case.truth()["freq_hz"]
    found = ar.identify_antiresonances(record, excitation=0, band_hz=BAND_HZ, check="off")
    rng = np.random.default_rng(seed)
    out = {}
    for method in METHODS:
        start = time.process_time()
        judged = cross_check(record, found, band_hz=BAND_HZ, method=method, tol=TOL)
        seconds = time.process_time() - start
        drawn = {dof: rng.uniform(*BAND_HZ, DRAWN) for dof in found}
        drawn = {
            dof: f[[not truth[dof].size or np.abs(truth[dof] / one - 1.0).min() >= APART for one in f]]
            for dof, f in drawn.items()
        }
        chance = cross_check(
            record,
            drawn,
            band_hz=BAND_HZ,
            method=method,
            tol=TOL,
            n_poles=max(12, 8 + max(f.size for f in found.values())),
        )
        true = {
            dof: np.array(
                [truth[dof].size > 0 and np.abs(truth[dof] / one - 1.0).min() < TOL for one in f], bool
            )
            for dof, f in judged.freq_hz.items()
        }
        out[method] = (
            sum(int(judged.confirmed[dof][true[dof]].sum()) for dof in found),
            sum(int(mask.sum()) for mask in true.values()),
            sum(int(ok.sum()) for ok in chance.confirmed.values()),
            sum(f.size for f in drawn.values()),
            sum(f.size for f in judged.candidates_hz.values()),
            seconds,
        )
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--noise", type=float, nargs="+", default=[0.0, 0.01, 0.05, 0.10])
    add_options(parser, first_seed=100, seeds=5)
    options = parser.parse_args()
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    results = each(one_run, [(noise, seed) for noise in options.noise for seed in seeds], options.jobs)
    rows = []
    for noise in options.noise:
        runs = [next(results) for _ in seeds]
        for method in METHODS:
            confirmed, true, hit, drawn, candidates, seconds = np.sum([run[method] for run in runs], axis=0)
            rows.append(
                [
                    f"{100 * noise:g} %, {method}",
                    f"{confirmed:.0f} of {true:.0f}",
                    f"{100 * hit / drawn:.1f} %",
                    f"{candidates / len(runs):.1f}",
                    f"{seconds / len(runs):.2f}",
                ]
            )
    print(f"means of seeds {seeds[0]} to {seeds[-1]}\n")
    print_table(
        ["noise, method", "true confirmed", "chance", "candidates a record", "CPU s"], rows, options.markdown
    )


if __name__ == "__main__":
    main()
