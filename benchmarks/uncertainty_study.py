"""Do the standard deviations tell the truth? Coverage of 90 % intervals on the eight-mass chain.

Records of 200 s with 1 % damping, 1 % and 5 % noise. The truth is abs(s) / 2 pi of the damped zeros: the
roots of the numerators of the damped receptances. An interval is the identified value plus and minus 1.645
``std_hz``.

    python -m benchmarks.uncertainty_study               # 200 seeds, about ten minutes
    python -m benchmarks.uncertainty_study --seeds 20
"""

from __future__ import annotations

import argparse
import os
from concurrent.futures import ProcessPoolExecutor

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import antires_rs as ar

DAMPING, DURATION_S = 0.01, 200.0
LEVEL, QUANTILE = 0.90, 1.645
CLOSE = 0.01


def damped_zeros_hz(model, response, excitation):
    """abs(s) / 2 pi of the lightly damped zeros of H with modal damping, from the numerator polynomial."""
    modes = model.modes()
    w = 2 * np.pi * np.asarray(modes.freq_hz)
    w[0] = 0.0  # the rigid body of the free chain
    scale = w.max()
    factors = [np.array([1.0, 2 * DAMPING * wr / scale, (wr / scale) ** 2]) for wr in w]
    shapes = np.asarray(modes.shapes).reshape(len(w), -1)
    total = np.zeros(1)
    for r in range(len(w)):
        product = np.ones(1)
        for q in range(len(w)):
            product = product if q == r else np.polymul(product, factors[q])
        total = np.polyadd(total, shapes[r, response] * shapes[r, excitation] * product)
    s = np.roots(total)
    s = s[(s.imag > 0.0) & (np.abs(s.real) < 0.1 * np.abs(s))]
    return np.sort(np.abs(s) * scale / (2 * np.pi))


def one_record(job):
    """Rows (dof, error over standard deviation) of the values found, and the number not found."""
    noise, seed = job
    case = ar.cases.chain8()
    record = case.experiment(noise=noise, damping_ratio=DAMPING, duration_s=DURATION_S, rng=seed)
    found = ar.identify_antiresonances(record, excitation=case.excitation, band_hz=case.band_hz)
    rows, missed = [], 0
    for dof in case.responses:
        free = list(range(found[dof].size))
        for true in damped_zeros_hz(case.model, dof, case.excitation):
            if not case.band_hz[0] < true < case.band_hz[1]:
                continue
            near = min(free, key=lambda i: abs(found[dof][i] - true), default=None)
            if near is None or abs(found[dof][near] / true - 1.0) > CLOSE:
                missed += 1
                continue
            free.remove(near)
            rows.append((dof, (found[dof][near] - true) / found.std_hz[dof][near]))
    return noise, rows, missed


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--first-seed", type=int, default=200)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    jobs = [(noise, seed) for noise in (0.01, 0.05) for seed in seeds]
    with ProcessPoolExecutor(options.jobs) as pool:
        results = list(pool.map(one_record, jobs, chunksize=4))
    print(f"{options.seeds} records each; share of values whose {100 * LEVEL:.0f} % interval holds the truth")
    print("noise  pooled  bias/std  std of scores  missed  by dof")
    for noise in (0.01, 0.05):
        mine = [r for r in results if r[0] == noise]
        rows = np.array([row for _, found, _ in mine for row in found])
        inside = np.abs(rows[:, 1]) <= QUANTILE
        by_dof = "  ".join(f"{int(d)}: {inside[rows[:, 0] == d].mean():.3f}" for d in np.unique(rows[:, 0]))
        scores = rows[:, 1]
        print(
            f"{100 * noise:3.0f} %  {inside.mean():6.3f}  {scores.mean():8.2f}  {scores.std():13.2f}"
            f"  {sum(m for _, _, m in mine):6d}  {by_dof}"
        )


if __name__ == "__main__":
    main()
