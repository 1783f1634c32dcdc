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
    python -m benchmarks.short_records --errors                   # (value - zero) / stated error, by length
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
from scipy.fft import irfft, next_fast_len, rfftfreq

import antires_rs as ar
from benchmarks.study_tools import each, print_table
from reference.outside_records import DAMPING, damping_drawn, modes_of
from reference.outside_structures import STRUCTURES, State

JUDGED = ("elastic_beam", "portal", "truss")
LENGTHS_S, BASELINE_S = (5.0, 10.0, 20.0, 40.0), 120.0
#: The force has power up to this multiple of the band's end.
FORCED, NOISE = 1.5, 0.02
LOSS = (0.10, 0.60)


def recorded(modes, dofs, duration_s, rng):
    """Accelerations of all sensors under white noise at the force."""
    (low, high), fs_hz = modes.band_hz, modes.fs_hz
    n = round(duration_s * fs_hz)
    n_long = next_fast_len(2 * n + round(fs_hz / (DAMPING[0] * low)))  # rung in, and not periodic
    freq = rfftfreq(n_long, 1.0 / fs_hz)
    force = (rng.standard_normal(freq.size) + 1j * rng.standard_normal(freq.size)) * (freq < FORCED * high)
    x = np.array([irfft(row * force, n_long)[-n:] for row in modes.accelerance(freq)])
    x += NOISE * x.std(axis=1, keepdims=True) * rng.standard_normal(x.shape)
    return ar.Recording(x, fs_hz, dofs=dofs)


def identified(structure, own, state, duration_s, damping, rng):
    """Its antiresonances."""
    record = recorded(modes_of(structure, own, state, damping), structure.dofs, duration_s, rng)
    return ar.identify_antiresonances(record, excitation=structure.force, band_hz=structure.band_hz)


def answers(task):
    """Rows of one truth: every length, intact and damaged."""
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    name, number, lengths, seed = task
    structure = STRUCTURES[name]
    rng = np.random.default_rng([seed, list(STRUCTURES).index(name), number])
    own, damping = structure.drawn(rng), damping_drawn(rng)
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


#: A value further from the nearest zero than so many of the distances of the zeros is a false one.
_OTHER = 0.4


def errors_of(task):
    """Of each value: length, stated relative error, value less nearest zero over it, distance to the next."""
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    name, number, lengths, seed = task
    structure = STRUCTURES[name]
    rng = np.random.default_rng([seed, list(STRUCTURES).index(name), number, 1])
    own, damping = structure.drawn(rng), damping_drawn(rng)
    modes = modes_of(structure, own, State(), damping)
    rows = []
    for length in lengths:
        try:
            found = identified(structure, own, State(), length, damping, rng)
        except (ar.exceptions.UnsuitableDataError, ar.exceptions.InvalidInputError):
            continue
        for row, dof in enumerate(structure.dofs):
            zeros = np.sort(modes.zeros(row)[0])
            for value, std in zip(found.get(dof, []), found.std_hz.get(dof, []), strict=True):
                if zeros.size:
                    apart = np.sort(np.abs(zeros / value - 1.0))
                    nearest = zeros[np.argmin(np.abs(zeros / value - 1.0))]
                    gap = float(apart[1]) if zeros.size > 1 else 1.0
                    rows.append([name, length, std / value, (value - nearest) / std, gap])
    return rows


def errors_told(found, names):
    """Of values at a zero: standard deviation, robust and not, and how many are far out."""
    lines = []
    for name in [*names, "all"]:
        for length in sorted({row[1] for row in found}):
            own = np.array([row[2:] for row in found if row[1] == length and name in (row[0], "all")])
            own = own.reshape(-1, 3)
            z = own[np.abs(own[:, 1] * own[:, 0]) < _OTHER * own[:, 2], 1]
            if z.size:
                far = [f"{100.0 * np.mean(np.abs(z) > limit):.1f}" for limit in (1.645, 3.0, 5.0)]
                median = f"{100.0 * np.median(own[:, 0]):.3f}"
                width = f"{1.483 * np.median(np.abs(z)):.2f}"
                lines.append(
                    [f"{name}, {length:g} s", len(own), z.size, median, width, f"{z.std():.2f}", *far]
                )
    header = ["", "values", "at a zero", "stated %", "robust std of z", "std of z"]
    print_table([*header, "beyond 1.645, %", "beyond 3", "beyond 5"], lines, False)


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
    parser.add_argument("--errors", action="store_true", help="errors of the values, stated and true")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, help="file for the rows, as JSON")
    parser.add_argument("--read", type=Path, nargs="+", help="tables of such files, and no new cases")
    given = parser.parse_args()
    tasks = [(s, n, given.lengths, given.seed) for n in range(given.truths) for s in given.structures]
    if given.errors:
        found = [row for part in each(errors_of, tasks, given.workers) for row in part]
        if given.out:
            given.out.write_text(json.dumps(found))
        errors_told(found, given.structures)
        return
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
