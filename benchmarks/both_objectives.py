"""Antiresonances beside resonances with mode shapes: damage from the same identified record, as in Fig. 8.

The eight-mass chain, spring 4 at 55 %, one simulated record of 256 s with 1 % sensor noise for each seed. Out
of it antiresonances are identified without the force, modes from the FRFs with it, and modes from responses
alone; each goes to ``assess_damage`` with the same penalties, Eqs. 12 and 18 of V. Meruane, J. Sound Vib. 332
(2013) 807-820. Nothing exact enters.

    python -m benchmarks.both_objectives                        # five records
    python -m benchmarks.both_objectives --perturbation 0.02    # with a model that is not quite the structure

``--picture docs/images/both_objectives.png`` draws the bar chart of the first record; the one there is of the
second command.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import antires_rs as ar
from antires_rs.figures.canvas import picture
from benchmarks.study_tools import add_options, print_table

DAMAGED, NOISE = 4, 0.01
APPROACHES = ("antiresonances, no force", "modes from FRFs", "modes from responses, no force")


def identified(case, record):
    """What each approach makes of one record."""
    return (
        ar.identify_antiresonances(record, excitation=case.excitation, band_hz=case.band_hz),
        ar.identify_modes(record, band_hz=case.band_hz, route="frf"),
        ar.identify_modes(record, band_hz=case.band_hz, route="responses"),
    )


def one_record(task):
    """For each approach: values used, result, seconds of the search."""
    seed, noise, perturbation = task
    case = ar.cases.chain8(perturbation=perturbation, rng=seed)
    rows = []
    for measured in identified(case, case.experiment(level=1, noise=noise, rng=seed)):
        start = time.perf_counter()
        result = ar.assess_damage(
            case.model, measured, search=ar.SearchOptions(gamma1=0.1, gamma2=0.1), rng=seed
        )
        rows.append((result, time.perf_counter() - start))
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--noise", type=float, default=NOISE, help="of each sensor, as a fraction of its rms")
    parser.add_argument(
        "--perturbation",
        type=float,
        default=0.0,
        help="masses and springs of the structure differ from the model by up to this part",
    )
    parser.add_argument("--picture", type=Path, help="bar chart of the first record, as PNG")
    add_options(parser, first_seed=0, seeds=5)
    options = parser.parse_args()
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    tasks = [(seed, options.noise, options.perturbation) for seed in seeds]
    # Threads: a result holds a model of the core, which no other process could send back.
    with ThreadPoolExecutor(options.jobs) as pool:
        runs = list(pool.map(one_record, tasks))
    truth = ar.cases.chain8().truth(1)["severity"]

    rows = []
    for k, name in enumerate(APPROACHES):
        for seed, run in zip(seeds, runs, strict=True):
            result, seconds = run[k]
            false = {e: beta for e, beta in result.severity.items() if e != DAMAGED and beta > 0.0}
            table = result.table
            mac = f"{table.before_mac.min():.3f} / {table.after_mac.min():.3f}" if k else "-"
            error = 100 * (result.severity[DAMAGED] - truth[DAMAGED])
            rows.append(
                [
                    name,
                    seed,
                    table.measured_hz.size,
                    f"{100 * result.severity[DAMAGED]:.2f}",
                    f"{error:+.2f}",
                    f"{len(false)}, {100 * max(false.values(), default=0.0):.2f}",
                    f"{table.largest_before_percent:.2f} / {table.largest_after_percent:.2f}",
                    mac,
                    f"{result.fun:.4f}",
                    f"{result.nfev:,}",
                    f"{1e3 * seconds:.0f}",
                ]
            )
    print(
        f"chain8, spring 4 at {100 * truth[DAMAGED]:g} %, records with {100 * options.noise:g} % noise, "
        f"model off by up to {100 * options.perturbation:g} %\n"
    )
    print_table(
        [
            "approach",
            "seed",
            "values",
            "spring 4 (%)",
            "error",
            "false: count, largest (%)",
            "largest difference before/after (%)",
            "least MAC before/after",
            "J",
            "evaluations",
            "ms",
        ],
        rows,
        options.markdown,
    )
    print()
    for k, name in enumerate(APPROACHES):
        errors = [100 * abs(run[k][0].severity[DAMAGED] - truth[DAMAGED]) for run in runs]
        visible = np.array(list(runs[0][k][0].detectable.values()))
        print(
            f"{name}: largest error {max(errors):.2f} points; smallest visible damage of springs 0 to 6 "
            + ", ".join(f"{100 * v:.1f}" for v in visible)
            + " %"
        )
    if options.picture:

        def draw(axes):
            for ax, name, (result, _) in zip(axes, APPROACHES[:2], runs[0], strict=False):
                result.plot(ax=ax, truth=truth).set_title(name)

        options.picture.write_bytes(picture(draw, (7.0, 8.0), rows=2))
        print(f"picture of seed {seeds[0]}: {options.picture}", file=sys.stderr)


if __name__ == "__main__":
    main()
