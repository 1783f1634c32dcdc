"""A concrete building frame of 2,130 dofs, half of them without mass: antiresonances, objective, updating.

The matrices are those of ``reference.building_frames``: lumped masses, slabs made rigid by penalties. Twelve
accelerometers, force at the roof, all antiresonances to 20 Hz; the stiffness of twelve groups of members is
drawn between 0.7 and 1.3 of the nominal, and updated from searches that begin at random, without noise.

    python -m benchmarks.building_update              # two truths, three searches each
    python -m benchmarks.building_update --starts 100
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: one core is what is measured

import argparse
import time

import numpy as np

import antires_rs as ar
from reference.building_frames import building

F_MAX_HZ = 20.0


def timed(work):
    """What it gives, and CPU seconds."""
    begun = time.process_time()
    return work(), time.process_time() - begun


def test_of(made):
    """Dofs of twelve accelerometers, two corners and one inside column of four floors; of the force."""
    heads = made.heads
    sensors = [
        made.dof[int(heads[s, c]), d] for s in (1, 2, 3, 4) for c, d in ((0, "u"), (-1, "v"), (7, "u"))
    ]
    return sensors, made.dof[int(heads[-1, 0]), "u"]


def searched(problem, truth, seed):
    """One search: CPU seconds, largest error of a factor, what came out."""
    optimizer = ar.IslandGA(islands=1, population=12, max_generations=12)
    result, cpu_s = timed(
        lambda: ar.update(problem, optimizer=optimizer, rng=seed, workers=1, progress=False)
    )
    return cpu_s, float(np.abs(result.x - truth).max()), result


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--truths", type=int, default=2)
    parser.add_argument("--starts", type=int, default=3)
    given = parser.parse_args()
    made, cpu_s = timed(building)
    sensors, force = test_of(made)
    n, massless = made.stiffness.shape[0], int((made.mass.diagonal() == 0).sum())
    print(f"{n} dofs, {massless} without mass; meshed in {cpu_s:.1f} s")
    model, cpu_s = timed(lambda: ar.MatrixModel(made.stiffness, made.mass, stiffness_terms=made.terms))
    print(f"MatrixModel with 12 terms: {cpu_s:.3f} CPU s")
    _, cpu_s = timed(lambda: model.antiresonances(sensors[0], force, f_max_hz=F_MAX_HZ))
    print(f"one pair to {F_MAX_HZ:g} Hz: {cpu_s:.3f} CPU s")
    factors = ar.stiffness_factor(range(12), bounds=(0.6, 1.4))
    for nth in range(given.truths):
        rng = np.random.default_rng([14, nth])
        truth = rng.uniform(0.7, 1.3, 12)
        true = model.with_parameters(factors, truth)
        zeros = dict(zip(sensors, true.antiresonances(sensors, force, f_max_hz=F_MAX_HZ), strict=True))
        problem = ar.UpdatingProblem(model, factors, ar.AntiresonanceSet(force, zeros))
        values = sum(len(f) for f in zeros.values())
        _, cpu_s = timed(lambda: [problem.cost(x) for x in rng.uniform(0.7, 1.3, (5, 12))])  # noqa: B023
        print(f"truth {nth}: {values} antiresonances; objective {200.0 * cpu_s:.1f} ms a value", flush=True)
        for seed in range(given.starts):
            cpu_s, error, result = searched(problem, truth, seed)
            figures = f"{result.nfev} values, cost {result.fun:.2e}, largest error {error:.1e}"
            print(f"  search {seed}: {cpu_s:.1f} CPU s, {figures}", flush=True)
