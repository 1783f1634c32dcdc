"""The cracked exhaust against its baseline, its model never updated and updated, with and without element 30.

Records of ten minutes with 1 % noise of the tested structure, a finer frame with other properties than the
model, whose frequencies are up to 39 % off; "updated" is that model after 21 of its parameters were
updated on the baseline. Level 0 is a second record of the intact structure.

With ``--cracks``: exact values with 1e-4 to 1e-3 of scatter, stated rightly, a crack at a random place of a
random candidate, as flexible as a loss of 5 to 60 % of it; the model never updated.

    python -m benchmarks.exhaust_baseline                 # seeds 0 to 2, five minutes on two cores
    python -m benchmarks.exhaust_baseline --seeds 10 --updated
    python -m benchmarks.exhaust_baseline --cracks 10 --first 21
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import time
import warnings
from itertools import product
from unittest.mock import patch

import numpy as np

import antires_rs as ar
from antires_rs.cases import exhaust_truth
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


def exact(case, std, rng, crack=None):
    """Values of the tested structure in the damage band; of a crack its element, share of it, and loss."""
    geometry, (low, high) = exhaust_truth.geometry, case.damage_band_hz
    changed = {"USUAL": exhaust_truth.USUAL}
    if crack:
        element, share, loss = crack
        (first, second, name), nodes = geometry.beams()[element], exhaust_truth.true_nodes()
        length_m = float(np.linalg.norm(nodes[second] - nodes[first]))
        bending = geometry.SECTIONS[name][1] * exhaust_truth.MODULUS[name]
        bending *= exhaust_truth._inertia(float(exhaust_truth.walls_m()[element]))
        turns = loss / (1.0 - loss) * length_m / bending
        changed |= {"CRACKED_ELEMENT": element, "SOCKET_M": share * length_m, "BEHIND_WELD_M": 0.0}
        changed |= {"compliance": lambda level, errors: turns}
    with patch.multiple(exhaust_truth, **changed):
        level, usual = int(crack is not None), exhaust_truth.USUAL
        found = exhaust_truth.true_antiresonances(level, list(case.responses), high, usual)
    freq = {dof: f[(f > low) & (f < high)] for dof, f in found.items()}
    freq = {dof: np.sort(f * (1.0 + std * rng.standard_normal(f.size))) for dof, f in freq.items()}
    return ar.AntiresonanceSet(case.excitation, freq, std_hz={dof: std * f for dof, f in freq.items()})


def cracked(task):
    """A line for each crack."""
    warnings.simplefilter("ignore")
    case, rng = ar.cases.exhaust(), np.random.default_rng([*task, 404])
    crack = int(rng.choice(case.candidates)), float(rng.uniform(0.1, 0.9))
    loss, std = (float(np.exp(rng.uniform(*np.log(ends)))) for ends in ((0.05, 0.6), (1e-4, 1e-3)))
    now, before = exact(case, std, rng, (*crack, loss)), exact(case, std, rng)
    found = ar.assess_damage(case.model, now, baseline=before, elements=case.candidates, workers=1)
    best, a90 = found.hypotheses[0], min(found.detectable[crack[0]], 9.99)
    held = [found.interval[e][0] <= loss <= found.interval[e][1] for e in best.elements]
    told = f"{best.kind} {best.elements} {best.probability:.3f} {best.place} loss inside: {held}"
    return f"element {crack[0]} at {crack[1]:.2f}, {100 * loss:.1f} % (a90 {100 * a90:.1f} %): {told}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--updated", action="store_true", help="the updated model too")
    parser.add_argument("--cracks", type=int, default=0, help="so many cracks instead")
    parser.add_argument("--first", type=int, default=0, help="seed of the cracks")
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    if given.cracks:
        for line in each(cracked, [(given.first, nth) for nth in range(given.cracks)], given.workers):
            print(line, flush=True)
        raise SystemExit
    print("seed  model          level  candidates   CPU s  largest probability  headline", flush=True)
    for lines in each(rows, [(seed, given.updated) for seed in range(given.seeds)], given.workers):
        print("\n".join(lines), flush=True)
