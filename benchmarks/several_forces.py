"""Several unknown forces on the eight-mass chain: what is found, how many act, the wrong number, and speed.

Found: records of 600 s (1 % damping) under uncorrelated white forces at two or three masses, against exact
roots by QZ (1 %); "known" are values that the same fit to exact spectra, with scatter about them, would
know to 0.5 %, "false" is of all found, "held" the 90 % intervals that hold. Number: records of 300 s, the
last force 20 dB below the others or not. Wrong: one place too many or too few is named; "confident" values
are not graded weak. Speed: 8 channels, 256 s, order 2 over order 1, the least of some runs.

    python -m benchmarks.several_forces                          # about an hour
    python -m benchmarks.several_forces --seeds 1 --only found
"""

from __future__ import annotations

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
import warnings

import numpy as np

import antires_rs as ar
from antires_rs.identification.lines import Lines, unit
from antires_rs.identification.minors import MinorsOfRecord, Subspaces, subspace
from antires_rs.identification.numerators import Influence
from antires_rs.identification.options import CallOptions, FitOptions, options_of
from antires_rs.identification.selection import likeliest_of
from antires_rs.signals.averaging import Averaging, average
from antires_rs.signals.spectra import Segments
from benchmarks.study_tools import MOST_JOBS, each, print_table
from reference.deleted_pencils import antiresonances_hz
from reference.several_forces import record_of, verdict

CHAIN = ar.cases.chain8().model
STIFFNESS, MASS = (np.asarray(matrix) for matrix in (CHAIN.stiffness(), CHAIN.mass()))
BAND, DAMPING = (3.0, 130.0), 0.01
PLACES = ((0, 4), (0, 7), (2, 6), (0, 3, 6))
NOISES = (0.0, 0.01, 0.05)
KNOWN, DRAWS, NEAR = (
    0.005,
    60,
    0.01,
)  # relative deviation; draws that tell it; distance of a root from an exact one


def identified(record, forces, check="off"):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ar.AntiresWarning)
        return ar.identify_antiresonances(record, excitation=list(forces), band_hz=BAND, check=check)


def known_of(record, forces, noise):
    """Exact values that the fit would know from exact spectra and scatter about them, by set of responses."""
    averages = average(record, BAND, Averaging())
    freq, rng = averages.spectra.freq_hz, np.random.default_rng(0)
    columns = np.stack([CHAIN.frf(list(range(8)), k, freq, damping_ratio=DAMPING) for k in forces], axis=-1)
    signal = columns.transpose(1, 0, 2)
    spread = np.linalg.norm(signal, axis=2)
    measured = np.einsum("fii->fi", averages.spectra.matrix).real
    signal *= np.sqrt(np.median(measured / spread**2, axis=0)).mean()
    power = (noise * record.responses.std(axis=1)) ** 2 / (0.5 * record.fs_hz) + 1e-9 * measured.mean(axis=0)
    signal /= np.sqrt(power)[:, None]

    def circular(*shape):
        return (rng.standard_normal(shape) + 1j * rng.standard_normal(shape)) * np.sqrt(0.5)

    x = signal @ circular(len(freq), len(forces), DRAWS) + circular(len(freq), 8, DRAWS)
    exact = signal.conj() @ signal.transpose(0, 2, 1) + np.eye(8)
    values, vectors = subspace(exact, np.ones(8))
    some = Subspaces(freq, values, vectors, Segments.of(x), len(forces))
    made = MinorsOfRecord(record, averages, len(forces))
    rows = made._rows
    size = np.sqrt(1.0 / some.noise)[:, None, None]
    own = some.minors(rows)
    moves = some.moves(rows, slice(None))
    moves -= moves.mean(axis=2, keepdims=True)
    segments = Segments.of(size * (own[..., None] + moves))
    ratio = DRAWS / averages.spectra.n_effective
    lines = Lines(freq, unit(own.T), 1.0 / some.noise, 0.0, segments, 1.0, ratio)
    best = likeliest_of(lines, options_of(CallOptions(), FitOptions()))
    influence = Influence(best, lines)
    known = {}
    for row, pair in enumerate(made.dofs):
        roots = best.fit.zeros(best.coefficients[:, row])
        roots = roots[roots.imag > 0.0]
        std = influence.standard_deviations(row, roots)
        hz = np.abs(roots) / (2 * np.pi)
        exact_hz = antiresonances_hz(STIFFNESS, MASS, list(pair), list(forces))
        known[pair] = []
        for value in (
            () if exact_hz is None else exact_hz[(exact_hz > BAND[0]) & (exact_hz < BAND[1])].tolist()
        ):
            at = int(np.argmin(np.abs(hz - value)))
            if abs(hz[at] / value - 1.0) <= NEAR and std[at] <= KNOWN * value:
                known[pair].append(value)
    return known


def found_of(task):
    """Counts of one record."""
    forces, noise, seed = task
    record = record_of(CHAIN, forces, 600.0, noise, seed)
    zeros = identified(record, forces)
    said = verdict(zeros, STIFFNESS, MASS, BAND)
    known = known_of(record, forces, noise)
    missed = {(pair, round(value, 6)) for pair, value in said.missed}
    lost = sum((pair, round(value, 6)) in missed for pair, own in known.items() for value in own)
    count = sum(map(len, known.values()))
    return said.there, said.found, count, count - lost, said.false, said.deviations


def study_found(seeds, jobs):
    rows = []
    for forces in PLACES:
        for noise in NOISES:
            told = list(each(found_of, [(forces, noise, seed) for seed in seeds], jobs))
            there, found, known, kept, false = (sum(one[k] for one in told) for k in range(5))
            off = np.concatenate([one[5] for one in told])
            rows.append(
                [", ".join(map(str, forces)), f"{100 * noise:g}", f"{found} of {there}", f"{kept} of {known}"]
                + [f"{100 * kept / max(known, 1):.1f}", f"{100 * false / max(found + false, 1):.1f}"]
                + [f"{100 * np.mean(np.abs(off) < 1.645):.0f}"]
            )
    return ["forces", "noise %", "found", "known found", "%", "false %", "held %"], rows


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


STUDIES = {"found": study_found, "number": study_number, "wrong": study_wrong, "speed": study_speed}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--jobs", type=int, default=MOST_JOBS)
    parser.add_argument("--only", nargs="+", choices=STUDIES, default=list(STUDIES))
    given = parser.parse_args()
    for name in given.only:
        print(f"\n{name}\n")
        print_table(*STUDIES[name](range(given.seeds), given.jobs), markdown=True)


if __name__ == "__main__":
    main()
