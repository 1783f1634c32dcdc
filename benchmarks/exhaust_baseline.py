"""The cracked exhaust against its baseline, its model never updated and updated, with and without element 30.

Records of ten minutes with 1 % noise of the tested structure, a finer frame with other properties than the
model, whose frequencies are up to 39 % off; "updated" is that model after 21 of its parameters were
updated on the baseline. Level 0 is a second record of the intact structure.

    python -m benchmarks.exhaust_baseline                 # seeds 0 to 2, five minutes on two cores
    python -m benchmarks.exhaust_baseline --seeds 10 --updated
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import time
import warnings
from itertools import product

import antires_rs as ar
from benchmarks.study_tools import each

NOISE = 0.01


def identified(case, level, rng):
    """Antiresonances of a record in the damage band."""
    record = case.experiment(level, noise=NOISE, rng=rng, progress=False)
    return ar.identify_antiresonances(
        record, excitation=case.excitation, band_hz=case.damage_band_hz, check="off", progress=False
    )


def rows(task):
    """A line for each model, level and list of candidates."""
    warnings.simplefilter("ignore")
    seed, updated = task
    case = ar.cases.exhaust()
    before = identified(case, 0, 100 * seed)
    now = {level: identified(case, level, 100 * seed + 5000 * (level == 0) + level) for level in (0, 1, 2)}
    models = {"never updated": case.model}
    if updated:
        problem = case.updating_problem(before, held_out=[], band_hz=case.damage_band_hz)
        models["updated"] = ar.update(problem, rng=seed, workers=1, progress=False).model
    lines = []
    for name, model in models.items():
        for level, without in product(now, (False, True)):
            elements = [e for e in case.candidates if not (without and e == case.cracked_element)]
            begun = time.process_time()
            result = ar.assess_damage(model, now[level], baseline=before, elements=elements, workers=1)
            cpu_s = time.process_time() - begun
            kind = "without 31" if without else "all 30"
            largest = max(result.probability.values())
            figures = f"{cpu_s:6.1f}  {largest:19.3f}  {result.headline}"
            lines.append(f"{seed:4d}  {name:13s}  {level:5d}  {kind:10s}  {figures}")
    return lines


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--updated", action="store_true", help="the updated model too")
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    print("seed  model          level  candidates   CPU s  largest probability  headline", flush=True)
    for lines in each(rows, [(seed, given.updated) for seed in range(given.seeds)], given.workers):
        print("\n".join(lines), flush=True)
