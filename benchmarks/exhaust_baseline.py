"""The cracked exhaust against its baseline, on a model never updated, with and without the right candidate.

Records of ten minutes with 1 % noise of the tested structure, a finer frame with other properties than the
model, whose frequencies are up to 39 % off. Level 0 is a second record of the intact structure.

    python -m benchmarks.exhaust_baseline                 # seeds 0 to 2, some ten minutes
    python -m benchmarks.exhaust_baseline --seeds 10
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import time
import warnings

import antires_rs as ar

NOISE = 0.01


def identified(case, level, rng):
    """Antiresonances of a record in the damage band."""
    record = case.experiment(level, noise=NOISE, rng=rng, progress=False)
    return ar.identify_antiresonances(
        record, excitation=case.excitation, band_hz=case.damage_band_hz, check="off", progress=False
    )


def rows(seed):
    """A line for each level and list of candidates."""
    case = ar.cases.exhaust()
    before = identified(case, 0, 100 * seed)
    for level in (0, 1, 2):
        now = identified(case, level, 100 * seed + 5000 * (level == 0) + level)
        for without in (False, True):
            elements = [e for e in case.candidates if not (without and e == case.cracked_element)]
            begun = time.process_time()
            result = ar.assess_damage(case.model, now, baseline=before, elements=elements)
            yield seed, level, without, result, time.process_time() - begun


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    print("seed  level  candidates   CPU s  largest probability  headline")
    for seed in range(given.seeds):
        for _, level, without, result, cpu_s in rows(seed):
            kind = "without 31" if without else "all 30"
            largest = max(result.probability.values())
            print(f"{seed:4d}  {level:5d}  {kind:10s}  {cpu_s:6.1f}  {largest:19.3f}  {result.headline}")
