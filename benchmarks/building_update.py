"""A concrete frame of 2,220 dofs, half of them without mass: antiresonances, objective, updating.

The matrices are those of ``reference.concrete_test_frame``: two storeys, two bays, finely meshed; lumped
masses, slabs made rigid in their plane by penalties. Twelve accelerometers, force at a corner of the roof,
all antiresonances to 20 Hz. The stiffness of twelve groups of members is drawn between 0.7 and 1.3 of the
nominal and updated without noise, each search from a nominal model drawn in the same box. ``--kind building``
is ``reference.building_frames``: five storeys, 78 antiresonances a response: the hard case.

    python -m benchmarks.building_update                    # ten truths, ten starts each
    python -m benchmarks.building_update --kind building --truths 1 --starts 1
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: one core is what is measured

import argparse
import time

import numpy as np

import antires_rs as ar
from reference.building_frames import building
from reference.concrete_test_frame import concrete_test_frame

F_MAX_HZ, BOX = 20.0, (0.7, 1.3)
#: A factor within this of the truth is found.
FOUND = 1e-3


def timed(work):
    """What it gives, and CPU seconds."""
    begun = time.process_time()
    return work(), time.process_time() - begun


def sensors_of_frame(made):
    """Of both floors: along and across at a corner, across at the other end, vertical in three places."""
    sensors = []
    for nodes in made.floors:
        floor = np.reshape(nodes, (17, 7))
        places = ((0, 0, "u"), (0, 0, "v"), (-1, 0, "v"), (4, 0, "w"), (12, -1, "w"), (4, 3, "w"))
        sensors += [made.dof[int(floor[i, j]), d] for i, j, d in places]
    return sensors, made.dof[made.floors[1][0], "u"]


def sensors_of_building(made):
    """Two corners and one inside column of four floors."""
    places = ((0, "u"), (-1, "v"), (7, "u"))
    sensors = [made.dof[int(made.heads[s, c]), d] for s in range(4) for c, d in places]
    return sensors, made.dof[int(made.heads[-1, 0]), "u"]


KINDS = {"frame": (concrete_test_frame, sensors_of_frame), "building": (building, sensors_of_building)}


def begun_at(made, start, measured):
    """The problem whose nominal model is at ``start``: nothing else is known of the truth."""
    stiffness = made.stiffness + sum((s - 1.0) * term for s, term in zip(start, made.terms, strict=True))
    terms = [s * term for s, term in zip(start, made.terms, strict=True)]
    factors = [ar.stiffness_factor(i, bounds=(BOX[0] / s, BOX[1] / s)) for i, s in enumerate(start)]
    return ar.UpdatingProblem(ar.MatrixModel(stiffness, made.mass, stiffness_terms=terms), factors, measured)


def searched(made, truth, start, measured, reduction, seed):
    """CPU seconds, largest error of an identifiable factor, the number of these, what came out."""
    problem = begun_at(made, start, measured)
    optimizer = ar.IslandGA(islands=1, population=6, max_generations=2)
    result, cpu_s = timed(
        lambda: ar.update(
            problem, optimizer=optimizer, rng=seed, workers=1, progress=False, reduction=reduction
        )
    )
    told = np.isfinite(result.identifiability.std) & ~result.identifiability.blind
    error = np.abs(result.x * start - truth)[told]
    return cpu_s, float(error.max(initial=0.0)), int(told.sum()), result


def main(given):
    mesh, places = KINDS[given.kind]
    made, cpu_s = timed(mesh)
    sensors, force = places(made)
    n, massless = made.stiffness.shape[0], int((made.mass.diagonal() == 0).sum())
    print(f"{n} dofs, {massless} without mass; meshed in {cpu_s:.1f} s")
    model, cpu_s = timed(lambda: ar.MatrixModel(made.stiffness, made.mass, stiffness_terms=made.terms))
    print(f"MatrixModel with {len(made.terms)} terms: {cpu_s:.3f} CPU s")
    print(f"{model.modes(f_max_hz=F_MAX_HZ).freq_hz.size} modes to {F_MAX_HZ:g} Hz")
    _, cpu_s = timed(lambda: model.antiresonances(sensors[0], force, f_max_hz=F_MAX_HZ))
    print(f"one pair to {F_MAX_HZ:g} Hz: {cpu_s:.3f} CPU s")
    factors = ar.stiffness_factor(range(12), bounds=(0.6, 1.4))
    seconds, errors = [], []
    for nth in range(given.truths):
        rng = np.random.default_rng([given.first_seed, nth])
        truth = rng.uniform(*BOX, 12)
        true = model.with_parameters(factors, truth)
        zeros = dict(zip(sensors, true.antiresonances(sensors, force, f_max_hz=F_MAX_HZ), strict=True))
        measured = ar.AntiresonanceSet(force, zeros)
        problem = ar.UpdatingProblem(model, factors, measured)
        rows = rng.uniform(*BOX, (5, 12))
        _, cpu_s = timed(lambda: problem.evaluate_many(rows, workers=1))  # noqa: B023
        values = sum(len(f) for f in zeros.values())
        print(f"truth {nth}: {values} antiresonances; full objective {200.0 * cpu_s:.1f} ms", flush=True)
        for seed in range(given.starts):
            start = rng.uniform(*BOX, 12)
            cpu_s, error, told, result = searched(made, truth, start, measured, given.reduction, seed)
            seconds.append(cpu_s)
            errors.append(error)
            how = "full" if result.reduction is None else (
                f"{result.reduction.rounds} bases, {result.reduction.size} dofs, "
                f"to {result.reduction.difference:.0e}"
            )  # fmt: skip
            print(
                f"  start {seed}: {cpu_s:.2f} CPU s, {result.nfev} values, {how}; cost {result.fun:.1e}, "
                f"largest error of {told} factors {error:.1e}",
                flush=True,
            )
    found = sum(error <= FOUND for error in errors)
    print(
        f"{found} of {len(errors)} within {FOUND:g}; {np.mean(seconds):.2f} CPU s a start "
        f"(median {np.median(seconds):.2f}, longest {max(seconds):.2f})"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kind", choices=tuple(KINDS), default="frame")
    parser.add_argument("--truths", type=int, default=10)
    parser.add_argument("--starts", type=int, default=10)
    parser.add_argument("--first-seed", type=int, default=2026)
    parser.add_argument("--full", dest="reduction", action="store_const", const=False, default="auto")
    main(parser.parse_args())
