"""Repeated tests of the eight-mass chain: impacts in files of their own, and what a comparison finds.

Impacts: tests of 20 impacts, one file each (16 s, 1 % damping, 1 % noise), against single impacts: found of
28, false, and the scatter from test to test over that of one impact: 1 / sqrt(20) = 0.22 if all is well.

Comparison: records of 256 s of the intact chain and of chains with 0.1 and 2 % less in spring 4 (1 % damping,
1 % noise). False alarms of the test of all: each intact record against the next, in a circle. Detection: each
intact record against a damaged one.

    python -m benchmarks.repeated_tests                          # about ten minutes
    python -m benchmarks.repeated_tests --tests 5 --records 20
"""

from __future__ import annotations

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import warnings

import numpy as np

import antires_rs as ar
from benchmarks.study_tools import MOST_JOBS, each
from reference.matching import match
from reference.virtual_records import chain8_matrices, hit_record, true_antiresonances

STIFFNESS, MASS = chain8_matrices()
TRUTH = {dof: true_antiresonances(STIFFNESS, MASS, dof, 0) for dof in range(8)}
BAND = (3.0, 130.0)
FS_HZ, DAMPING, NOISE = 512.0, 0.01, 0.01
IMPACTS, HIT_S = 20, 16.0
SPRING, LOSSES, RECORD_S = 4, (0.0, 0.001, 0.02), 256.0
ALPHA = 0.01


def of_impacts(seeds):
    """Values by true value, NaN where not found, and the number of false ones, of one test."""
    records = []
    for seed in seeds:
        responses, _ = hit_record(
            STIFFNESS, MASS, duration_s=HIT_S, noise=NOISE, damping_ratio=DAMPING, seed=seed
        )
        records.append(ar.Recording(responses, FS_HZ))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.AntiresWarning)
        found = ar.identify_antiresonances(records, excitation=0, band_hz=BAND)
    values, false = [], 0
    for dof, truth in TRUTH.items():
        matched = match(found[dof], truth)
        partner = {true: value for value, true in matched.pairs}
        values += [partner.get(true, np.nan) for true in truth.tolist()]
        false += len(matched.false)
    return values, false


def of_record(task):
    """Antiresonances of one record of a chain that has lost some of a spring."""
    loss, seed = task
    springs = np.full(7, 56.7e3)
    springs[SPRING] *= 1.0 - loss
    chain = ar.MassSpringChain(np.diag(MASS), springs)
    record = chain.simulate(
        excitation=0, fs_hz=FS_HZ, duration_s=RECORD_S, damping_ratio=DAMPING, noise=NOISE, rng=seed
    )
    return ar.identify_antiresonances(record, excitation=0, band_hz=BAND)


def impacts(tests, jobs):
    """The table of the first question."""
    several = [range(IMPACTS * i, IMPACTS * (i + 1)) for i in range(tests)]
    single = [[seed] for seed in range(100_000, 100_000 + 4 * tests)]
    rows = {}
    for name, seeds in ((f"{IMPACTS} impacts", several), ("1 impact", single)):
        results = list(each(of_impacts, seeds, jobs))
        values = np.array([one for one, _ in results])
        found = (~np.isnan(values)).sum(axis=1)
        rows[name] = values
        print(
            f"{name:>10}: {len(results)} tests, found {found.min()} to {found.max()} of {values.shape[1]}, "
            f"false {sum(false for _, false in results)} in all"
        )
    many, one = rows.values()
    known = (~np.isnan(one)).sum(axis=0) > 0.8 * len(one)
    ratio = np.nanstd(many[:, known], axis=0, ddof=1) / np.nanstd(one[:, known], axis=0, ddof=1)
    print(
        f"scatter of {IMPACTS} impacts over that of one, {known.sum()} values: root mean square "
        f"{np.sqrt(np.mean(ratio**2)):.3f}, median {np.median(ratio):.3f}; 1 / sqrt({IMPACTS}) = "
        f"{IMPACTS**-0.5:.3f}"
    )


def comparisons(records, jobs):
    """The table of the second question."""
    tasks = [(loss, 10_000 * i + seed) for i, loss in enumerate(LOSSES) for seed in range(records)]
    sets = list(each(of_record, tasks, jobs))
    intact = sets[:records]
    for i, loss in enumerate(LOSSES):
        other = sets[records * i : records * (i + 1)] if i else intact[1:] + intact[:1]
        compared = [ar.compare(a, b, alpha=ALPHA) for a, b in zip(intact, other, strict=True)]
        right = sum(
            len(c) == sum(map(len, TRUTH.values()))
            and all(np.all(np.abs(c.a_hz[c.dof == d] / TRUTH[d] - 1.0) < 0.01) for d in TRUTH)
            for c in compared
        )
        print(
            f"spring {SPRING} less {100 * loss:g} %: all 28 matched in {right} of {records}, different "
            f"at {100 * ALPHA:g} % false alarms in {sum(c.different for c in compared)}"
        )
    followed = ar.track(intact)
    print(f"intact records followed: {followed!r}, scatter between them {followed.std_between:.1e}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--tests", type=int, default=20, help="tests of 20 impacts; four times as many single"
    )
    parser.add_argument("--records", type=int, default=100, help="records of each state")
    parser.add_argument("--jobs", type=int, default=MOST_JOBS)
    options = parser.parse_args()
    if options.tests:
        impacts(options.tests, options.jobs)
    if options.records:
        comparisons(options.records, options.jobs)


if __name__ == "__main__":
    main()
