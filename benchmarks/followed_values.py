"""Hits as somebody measures them, followed and watched: how often seen, false alarms, and what is detected.

Single hits on structures of reference/modal_structures.py with all that is wrong with measured ones
(reference/measured_reality.py): intact ones, the first half of them the baseline, and such with the stiffness
of one member 5 and 15 % lower. Everything by default: ``identify_series`` finds what to follow in the first
twenty. Beside each rate stands its prediction: T2 of the exact changes of the zeros over the scatter that the
baseline has, as if values were independent, at its share of the rate.

    python -m benchmarks.followed_values                                   # frame, some ten minutes
    python -m benchmarks.followed_values --structures frame truss --intact 200 --damaged 100
"""

from __future__ import annotations

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
import warnings
from unittest.mock import patch

import numpy as np
from scipy.stats import chi2, ncx2

import antires_rs as ar
from benchmarks.study_tools import print_table
from reference import modal_structures
from reference.measured_reality import MEASURED, hit
from reference.modal_structures import STRUCTURES
from reference.virtual_records import hit_record

LOSSES = (0.05, 0.15)
#: Members of a plane frame whose stiffness is lowered together: a column of the frame is of four.
MEMBERS = range(4)
RATE, OF_T2 = 0.01, 0.6


def state(name, loss):
    """A structure with some of its members softer."""
    made = modal_structures._plane_frame

    def softer(nodes, members):
        less = [1.0 - loss * (i in MEMBERS) for i in range(len(members))]
        return made(
            nodes, [(p, q, ea * f, ei * f, m) for f, (p, q, ea, ei, m) in zip(less, members, strict=True)]
        )

    with patch.object(modal_structures, "_plane_frame", softer):
        return STRUCTURES[name]()


def records(structure, first, count):
    made = (hit(structure, MEASURED, seed) for seed in range(first, first + count))
    return [ar.Recording(one.samples, one.fs_hz) for one in made]


def predicted(watched, intact, now):
    """Share of the tests of a state that T2 alone would tell."""
    scale = np.sqrt(np.median(watched.std_hz**2, axis=0))
    shift = np.zeros(watched.dof.size)
    for k, (dof, place) in enumerate(zip(watched.dof, np.median(watched.expected_hz, axis=0), strict=True)):
        was, there = intact.zeros(dof)[0], now.zeros(dof)[0]
        if was.size and there.size:
            own = was[np.argmin(np.abs(was - place))]
            shift[k] = there[np.argmin(np.abs(there - own))] - own
    limit = chi2.isf(OF_T2 * RATE, shift.size)
    return float(ncx2.sf(limit, shift.size, np.sum((shift / scale) ** 2)))


def study(name, intact, damaged):
    """Rows of the table of one structure."""
    states = [state(name, loss) for loss in (0.0, *LOSSES)]
    counts = (intact, damaged, damaged)
    tests = [
        one for s, count in zip(states, counts, strict=True) for one in records(s, 1000 * len(s.name), count)
    ]
    start = time.process_time()
    series = ar.identify_series(tests, excitation=states[0].driven, band_hz=states[0].band_hz)
    seconds = (time.process_time() - start) / len(tests)
    watched = ar.monitor(series, baseline=intact // 2)
    ends = np.cumsum([intact // 2, intact - intact // 2, damaged, damaged])
    rows = []
    for label, first, last, now in zip(
        ("baseline", "intact", *(f"{100 * loss:g} % lower" for loss in LOSSES)),
        [0, *ends[:-1]],
        ends,
        [None, None, *states[1:]],
        strict=True,
    ):
        part = slice(first, last)
        seen = np.mean(~np.isnan(watched.freq_hz[part]))
        told = "" if now is None else f"{predicted(watched, states[0], now):.0%}"
        judged = int(np.sum(~np.isnan(watched.statistic[part])))
        rows.append(
            [
                name,
                label,
                str(last - first),
                str(watched.dof.size),
                f"{seen:.1%}",
                str(judged),
                f"{np.sum(watched.alarm[part]) / max(judged, 1):.1%}",
                told,
                f"{seconds:.2f}",
            ]
        )
    return rows


def one_hit():
    """CPU seconds of a hit of 4 channels, 8 s at 500 Hz: searched, and followed."""
    chain = ar.MassSpringChain(
        [10.0, 9.0, 10.0, 8.0, 7.0], [4.5e5, 5e5, 4e5, 3.5e5], ground_first_n_per_m=5e5
    )
    matrices = np.asarray(chain.stiffness()), np.asarray(chain.mass())
    hits = [
        hit_record(*matrices, excitation=1, fs_hz=500.0, noise=0.02, seed=seed)[0][:4] for seed in range(6)
    ]
    tests = [ar.Recording(x, 500.0) for x in hits]
    known = ar.identify_antiresonances(tests, excitation=1, band_hz=(5, 70))
    taken = []
    for near in (None, known):
        ar.identify_antiresonances(tests[0], excitation=1, band_hz=(5, 70), near=near)
        start = time.process_time()
        for test in tests:
            ar.identify_antiresonances(test, excitation=1, band_hz=(5, 70), near=near)
        taken.append((time.process_time() - start) / len(tests))
    return (*taken, sum(map(len, known.values())))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--structures", nargs="+", choices=STRUCTURES, default=["frame"])
    parser.add_argument("--intact", type=int, default=200)
    parser.add_argument("--damaged", type=int, default=100)
    args = parser.parse_args()
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    searched, followed, count = one_hit()
    print(
        f"a hit of 4 channels, 8 s at 500 Hz: searched {searched:.3f} CPU s, "
        f"{count} values followed {followed:.3f}"
    )
    rows = [row for name in args.structures for row in study(name, args.intact, args.damaged)]
    print_table(
        ["structure", "state", "tests", "values", "seen", "judged", "alarm", "predicted", "CPU s a test"],
        rows,
        markdown=True,
    )


if __name__ == "__main__":
    main()
