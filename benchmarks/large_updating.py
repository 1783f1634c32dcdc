"""Updating with 10 parameters and damage among 200 groups of elements, in models of 10,000 dofs.

The meshes are those of ``reference.meshes``. What is measured is of another structure than the model: the
stiffness of every group is off by some percent that no parameter knows, masses too, and frequencies have
noise. Twelve accelerometers, all antiresonances up to the thirtieth mode. Damage, 40 % of one group or none,
is assessed against a baseline that was measured on the same structure, intact, with noise of its own.

    python -m benchmarks.large_updating                                  # grillage, update and damage
    python -m benchmarks.large_updating --mesh lattice --dofs 10000 --only update
    python -m benchmarks.large_updating --mesh tower --only damage --seed 8 --intact
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: one core is what is measured

import argparse
import resource
import time

import numpy as np

import antires_rs as ar
from reference.grouped_meshes import grouped, measured, of_groups, with_groups
from reference.meshes import MESHES, frame

N_MODES, N_SENSORS = 30, 12
#: Standard deviations of what the model does not know: stiffness of groups, and mass.
OFF_STIFFNESS, OFF_MASS = 0.02, 0.01


def timed(work):
    """What it gives, wall and CPU seconds."""
    wall, cpu = time.perf_counter(), time.process_time()
    found = work()
    return found, time.perf_counter() - wall, time.process_time() - cpu


def said(what, wall_s, cpu_s, more=""):
    peak_gb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"{what}: {wall_s:.1f} s, {cpu_s:.1f} CPU s, peak {peak_gb:.2f} GB{more}", flush=True)


def main(given):
    mesh = MESHES[given.mesh](given.dofs)
    rng = np.random.default_rng([given.seed, given.dofs])
    model, wall_s, cpu_s = timed(lambda: frame(mesh))
    said(f"{given.mesh} {model.n_dof} dofs", wall_s, cpu_s)
    free = [n for n in range(len(mesh.nodes_m)) if n not in set(mesh.held)]
    nodes = rng.choice(free, N_SENSORS, replace=False)
    sensors = [model.dof(int(node), "uvw"[i % 3]) for i, node in enumerate(nodes)]
    force, limit_hz = sensors[2], float(model.modes(n_modes=N_MODES).freq_hz[-1])
    fine = grouped(mesh, 200)
    ones = np.ones(len(fine))
    unknown = [
        *of_groups(ar.stiffness_factor, fine, (0.1, 2.0)),
        *of_groups(ar.mass_factor, fine, (0.1, 2.0)),
    ]
    off = np.concatenate([OFF_STIFFNESS * rng.standard_normal(200), OFF_MASS * rng.standard_normal(200)])
    structure = model.with_parameters(unknown, np.concatenate([ones, ones]) + off)
    if given.only != "damage":
        coarse = of_groups(ar.stiffness_factor, grouped(mesh, 10), (0.7, 1.3))
        truth = rng.uniform(0.8, 1.2, 10)
        tested = structure.with_parameters(coarse, truth)
        found = measured(tested, sensors, force, limit_hz, rng)
        problem, wall_s, cpu_s = timed(lambda: ar.UpdatingProblem(model, coarse, found))
        said(f"problem, {problem.measured_hz.size} antiresonances to {limit_hz:.1f} Hz", wall_s, cpu_s)
        _, wall_s, cpu_s = timed(lambda: problem.cost(truth))
        said("one objective value", wall_s, cpu_s)
        result, wall_s, cpu_s = timed(
            lambda: ar.update(problem, optimizer=ar.IslandGA(max_generations=20), rng=0, progress=False)
        )
        told = result.reduction
        how = "" if told is None else f"; {told.rounds} bases, {told.size} dofs, to {told.difference:.0e}"
        said(f"update, {result.nfev} values", wall_s, cpu_s, how)
        print(f"largest error of a factor {np.abs(result.x - truth).max():.3f}, cost {result.fun:.3f}, "
              f"{problem.cost(truth):.3f} at the truth")  # fmt: skip
    if given.only != "update":
        hit = int(rng.integers(200))
        lost = ar.stiffness_reduction([int(e) for e in fine[hit]], together=True)
        later = structure if given.intact else structure.with_parameters(lost, 0.4)
        before, now = (measured(each, sensors, force, limit_hz, rng) for each in (structure, later))
        grouped_model = with_groups(mesh, model, fine)
        result, wall_s, cpu_s = timed(lambda: ar.assess_damage(grouped_model, now, baseline=before))
        told = result.reduction
        how = f"; {told.rounds} bases, {told.size} dofs, to {told.difference:.0e}"
        said(f"damage among 200 groups, {result.nfev} states", wall_s, cpu_s, how)
        print("intact" if given.intact else f"damaged: element {hit} by 40 %", result.headline, sep=". ")
        print("losses found:", {e: round(loss, 4) for e, loss in result.severity.items() if loss})


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mesh", choices=tuple(MESHES), default="grillage")
    parser.add_argument("--dofs", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--only", choices=("update", "damage"))
    parser.add_argument("--intact", action="store_true", help="no damage")
    main(parser.parse_args())
