"""Found and false antiresonances of the default rule and of the presets, on simulated records.

The eight-mass chain from noise-free to 10 % noise, and four structures that the rule was not made on at 5 %
noise (reference/structures.py); 1 % modal damping, 200 s at 512 Hz, unless a line says otherwise.

    python -m benchmarks.preset_tables                      # some ten minutes on two cores
    python -m benchmarks.preset_tables --only "1 %" --seeds 2
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import warnings

import numpy as np

import antires_rs as ar
from benchmarks.study_tools import Score, add_options, each, print_table, score_run
from reference.structures import STRUCTURES

PRESETS = (None, "paper", "strict", "sensitive")
#: Noise, damping and duration of the chain's records, by label.
CHAIN = {
    "chain8, no noise": (0.0, 0.01, 200.0),
    "chain8, 1 % noise": (0.01, 0.01, 200.0),
    "chain8, 5 % noise": (0.05, 0.01, 200.0),
    "chain8, 10 % noise": (0.10, 0.01, 200.0),
    "chain8, 5 % noise, 0.5 % damping, 60 s": (0.05, 0.005, 60.0),
}
OTHERS = [name for name in STRUCTURES if any(word in name for word in ("random", "frame"))]
OTHER_NOISE = 0.05


def one_run(task):
    """Matches by dof of every preset on one record."""
    label, seed = task
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    if label in CHAIN:
        case = ar.cases.chain8()
        noise, damping, duration = CHAIN[label]
        record = case.experiment(noise=noise, damping_ratio=damping, duration_s=duration, rng=seed)
        excitation, band, truth = case.excitation, (3.0, 130.0), case.truth()["freq_hz"]
    else:
        maker, sensors = STRUCTURES[label]
        structure = maker(seed)
        record = structure.record(noise=OTHER_NOISE, seed=seed, sensors=sensors)
        excitation, band, truth = structure.excitation, structure.band_hz, structure.truth()
    return [
        score_run(
            ar.identify_antiresonances(
                record, excitation=excitation, band_hz=band, preset=preset, check="off"
            ),
            truth,
        )
        for preset in PRESETS
    ]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", nargs="+", help="words that the line's label must contain one of")
    add_options(parser, first_seed=100, seeds=3)
    options = parser.parse_args()
    labels = [
        label
        for label in (*CHAIN, *OTHERS)
        if not options.only or any(word in label for word in options.only)
    ]
    seeds = range(options.first_seed, options.first_seed + options.seeds)
    results = each(one_run, [(label, seed) for label in labels for seed in seeds], options.jobs)
    rows = []
    for label in labels:
        runs = [next(results) for _ in seeds]
        scores = [Score(tuple(run[i] for run in runs)) for i in range(len(PRESETS))]
        counts = [f"{np.mean(s.found):.1f} / {np.mean(s.false):.1f}" for s in scores]
        rows.append([f"{label} ({np.mean(scores[0].true):.0f})", *counts])
    print(f"found (of all) / false a record; means of seeds {seeds[0]} to {seeds[-1]}\n")
    print_table(["record", *(repr(preset) for preset in PRESETS)], rows, options.markdown)


if __name__ == "__main__":
    main()
