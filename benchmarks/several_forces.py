"""Several unknown forces: what is found, how many act, the wrong number, and speed.

Found: the eight-mass chain, records of 600 s (1 % damping) under uncorrelated white forces at two or three
masses, against exact roots by QZ (1 %); "known" are values whose Cramer-Rao deviation is below 0.5 %
(reference/forces_bound.py), "false" is of all found, "held" the 90 % intervals that hold the value with its
damping. Others: the same for frame, truss and plate strip by their modes (reference/modal_structures.py), 1 %
of noise; a value at a zero with its damping is not false. Again: these structures as somebody measures them,
with a second shaker of equal strength; share of the values of one record that another has within 1 %. Number:
records of 300 s, the last force 20 dB below the others or not. Wrong: one place too many or too few is named;
"confident" values are not graded weak. Speed: 8 channels, 256 s, order 2 over order 1, the least of some
runs.

    python -m benchmarks.several_forces                          # about an hour
    python -m benchmarks.several_forces --seeds 1 --only found
    python -m benchmarks.several_forces --seeds 3 --only others again
"""

from __future__ import annotations

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
import warnings
from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np

import antires_rs as ar
from benchmarks.simulated_reality import again
from benchmarks.study_tools import MOST_JOBS, each, print_table
from reference.deleted_pencils import antiresonances_hz
from reference.forces_bound import Bound
from reference.measured_reality import MEASURED, ambient
from reference.modal_structures import STRUCTURES
from reference.several_forces import modal_record, modes_of, record_of, verdict_of

CHAIN = ar.cases.chain8().model
STIFFNESS, MASS = (np.asarray(matrix) for matrix in (CHAIN.stiffness(), CHAIN.mass()))
BAND, DAMPING = (3.0, 130.0), 0.01
PLACES = ((0, 4), (0, 7), (2, 6), (0, 3, 6))
NOISES = (0.0, 0.01, 0.05)
OTHERS = (("frame", (0, 3)), ("truss", (0, 3)), ("plate strip", (0, 3)))
DURATION_S = 600.0
KNOWN, REAL = 0.005, 1e-4  # relative deviation; damping of a root that is real


class Chain:
    """The eight-mass chain under some forces."""

    band_hz, n = BAND, 8

    def __init__(self, forces):
        self.forces, self.structure = forces, modes_of(CHAIN, DAMPING, BAND, 400.0)

    def record(self, noise, seed):
        """Of 600 s."""
        return record_of(CHAIN, self.forces, DURATION_S, noise, seed)

    def exact_hz(self, responses):
        """Roots without damping."""
        found = antiresonances_hz(STIFFNESS, MASS, list(responses), list(self.forces))
        return np.empty(0) if found is None else found

    damped_hz = None


class Modes:
    """A structure of modes under forces at some of its sensors."""

    def __init__(self, name, forces):
        self.forces, self.structure = forces, STRUCTURES[name]()
        self.band_hz, self.n = self.structure.band_hz, len(self.structure.sensors)

    def record(self, noise, seed):
        """Of 600 s."""
        return modal_record(self.structure, self.forces, DURATION_S, noise, seed)

    def exact_hz(self, responses):
        """Roots without damping."""
        still = replace(self.structure, damping=np.zeros(self.structure.freq_hz.size))
        freq, damping = still.zeros(list(responses), self.structure.sensors[list(self.forces)])
        return freq[np.abs(damping) < REAL]

    def damped_hz(self, responses):
        """Zeros with their damping."""
        return self.structure.zeros(list(responses), self.structure.sensors[list(self.forces)])[0]


def identified(record, forces, check="off", band_hz=BAND):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.AntiresWarning)
        return ar.identify_antiresonances(record, excitation=list(forces), band_hz=band_hz, check=check)


@cache
def known_of(name, forces, noise):
    """Exact values that a record tells to 0.5 % by the Cramer-Rao bound, and what they are with damping."""
    case = Modes(name, forces) if name else Chain(forces)
    bound, (low, high) = Bound(case.structure, forces, DURATION_S, noise), case.band_hz
    known = {}
    for rows in combinations(range(case.n), len(forces)):
        exact_hz = case.exact_hz(rows)
        exact_hz = exact_hz[(exact_hz > low) & (exact_hz < high)]
        known[rows] = exact_hz[bound.std_hz(rows, exact_hz) <= KNOWN * exact_hz].tolist()
    return known, bound.zeros


def found_of(task):
    """Counts of one record."""
    name, forces, noise, seed = task
    case = Modes(name, forces) if name else Chain(forces)
    record = case.record(noise, seed)
    zeros = identified(record, forces, band_hz=case.band_hz)
    known, held_of = known_of(name, forces, noise)
    said = verdict_of(zeros, case.exact_hz, case.band_hz, case.damped_hz, held_of)
    missed = {(pair, round(value, 6)) for pair, value in said.missed}
    lost = sum((pair, round(value, 6)) in missed for pair, own in known.items() for value in own)
    count = sum(map(len, known.values()))
    return said.there, said.found, count, count - lost, said.false, said.deviations


def found_row(name, forces, noise, seeds, jobs):
    told = list(each(found_of, [(name, forces, noise, seed) for seed in seeds], jobs))
    there, found, known, kept, false = (sum(one[k] for one in told) for k in range(5))
    off = np.concatenate([one[5] for one in told])
    row = [f"{name} {', '.join(map(str, forces))}".strip(), f"{100 * noise:g}"]
    return [
        *row,
        f"{found} of {there}",
        f"{kept} of {known}",
        f"{100 * kept / max(known, 1):.1f}",
        f"{100 * false / max(found + false, 1):.1f}",
        f"{100 * np.mean(np.abs(off) < 1.645):.0f}",
    ]


FOUND = ["forces", "noise %", "found", "known found", "%", "false %", "held %"]


def study_found(seeds, jobs):
    return FOUND, [found_row("", forces, noise, seeds, jobs) for forces in PLACES for noise in NOISES]


def study_others(seeds, jobs):
    return FOUND, [found_row(name, forces, 0.01, seeds, jobs) for name, forces in OTHERS]


def measured_of(task):
    """What one record as somebody measures it gives, by set of responses."""
    name, forces, seed = task
    structure = STRUCTURES[name]()
    second = structure.sensors[forces[1]]
    # The simulator's force beside the shaker is the second one.
    level = replace(MEASURED, second_force=1.0)
    record = ambient(replace(structure, beside=np.vstack([structure.beside, second])), level, seed, 400.0)
    zeros = identified(ar.Recording(record.samples, record.fs_hz), forces, band_hz=structure.band_hz)
    return {pair: np.asarray(freq) for pair, freq in zeros.items()}


def study_again(seeds, jobs):
    rows = []
    for name, forces in OTHERS:
        sets = list(each(measured_of, [(name, forces, seed) for seed in seeds], jobs))
        every = sorted({pair for one in sets for pair in one})
        found, could = again([[one.get(pair, np.empty(0)) for pair in every] for one in sets])
        count = np.mean([sum(map(len, one.values())) for one in sets])
        rows.append([f"{name} {forces}", f"{count:.1f}", f"{found} of {could}", f"{100 * found / could:.1f}"])
    return ["as measured", "values", "again", "%"], rows


def number_of(task):
    forces, levels, noise, seed = task
    record = record_of(CHAIN, forces, 300.0, noise, seed, levels=levels)
    return ar.check_data(record, band_hz=BAND).n_forces == len(forces)


def study_number(seeds, jobs):
    rows = []
    for forces, levels in (
        ((0,), [1.0]),
        ((0, 4), [1.0, 1.0]),
        ((0, 4), [1.0, 0.1]),
        ((2, 6), [1.0, 0.1]),
        ((0, 3, 6), [1.0, 1.0, 0.1]),
        ((0, 3, 6), [1.0, 0.1, 0.1]),
    ):
        for noise in NOISES[1:]:
            right = list(each(number_of, [(forces, levels, noise, seed) for seed in seeds], jobs))
            rows.append([str(forces), str(levels), f"{100 * noise:g}", f"{sum(right)} of {len(right)}"])
    return ["forces", "amplitudes", "noise %", "number told"], rows


def wrong_of(task):
    acting, named, noise, seed = task
    record = record_of(CHAIN, acting, 200.0, noise, seed)
    try:
        zeros = identified(record, named, check="warn")
    except ar.UnsuitableDataError:
        return 0, True
    grades = [str(grade) for table in zeros.tables.values() for grade in table.scores["grade"]]
    told = not zeros.data_check.ok
    return sum(grade != "weak" for grade in grades), told


def study_wrong(seeds, jobs):
    rows = []
    for acting, named in (((0,), (0, 4)), ((0, 4), (0,)), ((0, 4), (0, 4, 6)), ((0, 3, 6), (0, 4))):
        for noise in NOISES[1:]:
            told = list(each(wrong_of, [(acting, named, noise, seed) for seed in seeds], jobs))
            rows.append(
                [str(acting), str(named), f"{100 * noise:g}", f"{sum(t for _, t in told)} of {len(told)}"]
            )
            rows[-1].append(str(sum(n for n, _ in told)))
    return ["acting", "named", "noise %", "told", "confident values"], rows


def study_speed(seeds, jobs):
    record = record_of(CHAIN, (0, 4), 256.0, 0.01, 0)
    rows, least = [], {}
    for forces in ((0,), (0, 4), (0, 3, 6)):
        taken = []
        for _ in seeds:
            start = time.process_time()
            identified(record, forces)
            taken.append(time.process_time() - start)
        least[forces] = min(taken)
        rows.append([str(forces), f"{least[forces]:.2f}", f"{least[forces] / least[(0,)]:.2f}"])
    return ["named", "s of CPU", "of order 1"], rows


STUDIES = {
    "found": study_found,
    "others": study_others,
    "again": study_again,
    "number": study_number,
    "wrong": study_wrong,
    "speed": study_speed,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first-seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=MOST_JOBS)
    parser.add_argument("--only", nargs="+", choices=STUDIES, default=list(STUDIES))
    given = parser.parse_args()
    seeds = range(given.first_seed, given.first_seed + given.seeds)
    for name in given.only:
        print(f"\n{name}\n")
        print_table(*STUDIES[name](seeds, given.jobs), markdown=True)


if __name__ == "__main__":
    main()
