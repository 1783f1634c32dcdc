"""Records of a few seconds against a baseline of two minutes: does damage that is not there come out?

Three structures of reference/outside_structures.py under the noise of one force, modes damped by 0.5 to
1.5 %, 2 % of noise in every channel. Each truth has an intact record of 120 s, the baseline, and for every
length a second intact record and one with the loss of one element, 10 to 60 %. Told for every length are

- false alarms of the intact records (damage declared), and those of more than 0.9;
- of the damaged ones: named rightly, wrongly, wrongly with more than 0.9, "cannot be told", nothing found;
- 90 % intervals of the losses of right answers that hold, and the most values that had no partner.

"Cannot be told" are answers that declare nothing, or whose first sentence says so: the data check called the
record unfit, or nothing is probable enough.

    python -m benchmarks.short_records                                    # 20 truths each; an hour
    python -m benchmarks.short_records --truths 4 --structures portal
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import json
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import scipy.linalg
from scipy.fft import irfft, next_fast_len, rfftfreq

import antires_rs as ar
from benchmarks.study_tools import each, print_table
from reference.outside_structures import STRUCTURES, State

JUDGED = ("elastic_beam", "portal", "truss")
LENGTHS_S, BASELINE_S = (5.0, 10.0, 20.0, 40.0), 120.0
#: Samples a cycle at the upper end of the band; the force has power up to this multiple of it.
RATE, FORCED = 4.0, 1.5
DAMPING, NOISE = (0.005, 0.015), 0.02
LOSS = (0.10, 0.60)


def recorded(structure, own, state, duration_s, damping, rng):
    """Accelerations of all sensors under white noise at the force."""
    one, (low, high) = structure.assembled(own, state), structure.band_hz
    square, shapes = scipy.linalg.eigh(one.stiffness, one.mass)
    omega = np.sqrt(np.maximum(square, 0.0))
    kept = omega < 2.0 * np.pi * RATE * high
    omega, shapes = omega[kept], shapes[:, kept]
    ratio = np.resize(damping, omega.size)
    fs_hz = RATE * high
    n = round(duration_s * fs_hz)
    n_long = next_fast_len(2 * n + round(fs_hz / (DAMPING[0] * low)))  # rung in, and not periodic
    freq = rfftfreq(n_long, 1.0 / fs_hz)
    force = (rng.standard_normal(freq.size) + 1j * rng.standard_normal(freq.size)) * (freq < FORCED * high)
    s = 2j * np.pi * freq
    modal = s**2 / (omega[:, None] ** 2 + 2.0 * ratio[:, None] * omega[:, None] * s + s**2)
    modal *= (shapes.T @ one.vector(structure.drive))[:, None] * force
    sensors = [structure.sensor(at, at == state.moved) for at in range(len(structure.dofs))]
    read = np.array([one.vector(weights) @ shapes for weights in sensors])
    x = np.array([irfft(row @ modal, n_long)[-n:] for row in read])
    x += NOISE * x.std(axis=1, keepdims=True) * rng.standard_normal(x.shape)
    return ar.Recording(x, fs_hz, dofs=structure.dofs)


def identified(structure, *how):
    """Its antiresonances."""
    record = recorded(structure, *how)
    return ar.identify_antiresonances(record, excitation=structure.force, band_hz=structure.band_hz)


def answers(task):
    """Rows of one truth: every length, intact and damaged."""
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    name, number, lengths, seed = task
    structure = STRUCTURES[name]
    rng = np.random.default_rng([seed, list(STRUCTURES).index(name), number])
    own, damping = structure.drawn(rng), rng.uniform(*DAMPING, 200)
    element, loss = int(rng.integers(structure.n_elements)), float(np.exp(rng.uniform(*np.log(LOSS))))
    before = identified(structure, own, State(), BASELINE_S, damping, rng)
    rows = []
    for length in lengths:
        for truth in ({}, {element: loss}):
            row = {"structure": name, "number": number, "length": length, "truth": truth}
            start = time.process_time()
            try:
                now = identified(structure, own, State(losses=truth), length, damping, rng)
                row |= answered(structure, before, now)
            except (ar.exceptions.UnsuitableDataError, ar.exceptions.InvalidInputError) as exc:
                row |= {"refused": str(exc), "damaged": [], "probability": 0.0, "told": "refused"}
            rows.append(row | {"seconds": time.process_time() - start})
    return json.loads(json.dumps(rows))


def answered(structure, before, now):
    """What an assessment says."""
    result = ar.assess_damage(
        structure.model, now, baseline=before, elements=structure.elements, workers=1, progress=False
    )
    best, found = result.hypotheses[0], result.assessment
    return {
        "damaged": sorted(result.damaged),
        "best": list(best.elements),
        "place": best.place,
        "probability": float(best.probability),
        "severity": {e: result.severity[e] for e in result.damaged},
        "interval": {e: list(result.interval[e]) for e in result.damaged},
        "values": [sum(map(len, before.values())), found.n_values, found.n_matched],
        "std": float(np.median(np.concatenate([now.std_hz[d] / now[d] for d in now]))),
        "findings": [f"{one.severity} {one.name}" for one in now.data_check.findings],
        "headline": result.headline,
    }


def told(row):
    """In a word."""
    if "refused" in row or not row["damaged"]:
        silent = "refused" in row or "annot be told" in row["headline"] or row["best"] == [-1]
        return "cannot be told" if silent else "nothing"
    if "annot be told" in row["headline"].split(". ")[0]:
        return "cannot be told"
    return "right" if row["damaged"] == [int(e) for e in row["truth"]] else "wrong"


def line(label, rows):
    """One row of the table."""
    intact, damaged = ([row for row in rows if bool(row["truth"]) is kind] for kind in (False, True))
    words = [told(row) for row in damaged]
    alarms = [row for row in intact if told(row) == "wrong"]
    held = [
        low <= loss <= high
        for row in damaged
        if told(row) == "right"
        for (e, loss) in row["truth"].items()
        for low, high in [row["interval"][e]]
    ]
    sure = sum(w == "wrong" and row["probability"] > 0.9 for row, w in zip(damaged, words, strict=True))
    return [
        label,
        len(intact),
        len(alarms),
        sum(row["probability"] > 0.9 for row in alarms),
        sum(told(row) == "cannot be told" for row in intact),
        len(damaged),
        words.count("right"),
        words.count("wrong"),
        sure,
        words.count("cannot be told"),
        words.count("nothing"),
        f"{sum(held)}/{len(held)}",
    ]


HEADER = ["", "intact", "alarms", "> 0.9", "untold", "damaged", "right", "wrong", "wrong > 0.9", "untold"]
HEADER += ["nothing", "90 % hold"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--structures", nargs="+", default=JUDGED, choices=list(STRUCTURES))
    parser.add_argument("--lengths", nargs="+", type=float, default=LENGTHS_S)
    parser.add_argument("--truths", type=int, default=20, help="of each structure")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, help="file for the rows, as JSON")
    parser.add_argument("--read", type=Path, nargs="+", help="tables of such files, and no new cases")
    given = parser.parse_args()
    tasks = [(s, n, given.lengths, given.seed) for n in range(given.truths) for s in given.structures]
    rows = [row for path in given.read or () for row in json.loads(path.read_text())]
    for part in each(answers, [] if given.read else tasks, given.workers):
        rows += part
        print(f"{len(rows)} of {2 * len(tasks) * len(given.lengths)}", file=sys.stderr, flush=True)
        if given.out:
            given.out.write_text(json.dumps(rows))
    lines = []
    for name in [*given.structures, "all"]:
        own = [row for row in rows if name in (row["structure"], "all")]
        lengths = sorted({row["length"] for row in own})
        lines += [line(f"{name}, {s:g} s", [r for r in own if r["length"] == s]) for s in lengths]
    print_table(HEADER, lines, False)


if __name__ == "__main__":
    main()
