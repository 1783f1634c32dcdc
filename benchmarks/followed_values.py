"""Hits as somebody measures them, followed and watched: how often seen, false alarms, and what is detected.

Single hits on structures of reference/modal_structures.py with all that is wrong with measured ones
(reference/measured_reality.py): intact ones, the first half of them the baseline, and such with the stiffness
of one member 5 and 15 % lower. Everything by default: ``identify_series`` finds what to follow in the first
twenty. Beside each rate stands its prediction: the same of intact tests after the baseline into which the
exact changes of the zeros are put, drawn at random. What is followed and is no zero stays where it is.

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

import antires_rs as ar
from antires_rs.measured.matching import KNOWN
from antires_rs.measured.response_table import ResponseTable
from benchmarks.simulated_reality import paired
from benchmarks.study_tools import print_table
from reference import modal_structures
from reference.measured_reality import MEASURED, hit
from reference.modal_structures import STRUCTURES
from reference.virtual_records import hit_record

LOSSES = (0.05, 0.15)
#: Members of a plane frame whose stiffness is lowered together: a column of the frame is of four.
MEMBERS = range(4)
NEAR = 0.05  # a value further from a zero than this part of its frequency is none
#: Draws of a prediction, and what nine of ten of them are between: one drift carries alarms of many tests.
DRAWS, BAND = 20, (0.05, 0.95)


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


def paired_zeros(was_hz, now_hz):
    """(was, now) of zeros, one to one, the closest first; what has no partner within ``NEAR`` is left out."""
    return [(was_hz[i], now_hz[k]) for i, k in paired(was_hz, now_hz, NEAR * now_hz)]


def moved(one, intact, now):
    """A set of the intact structure, followed, with the exact changes of the zeros; no zero, no change."""
    tables = {}
    for dof, table in one.tables.items():
        places = table.scores[KNOWN]
        changes = dict(paired_zeros(intact.zeros(dof)[0], now.zeros(dof)[0]))
        ratio = np.ones(places.size)
        for place, zero in paired_zeros(places[~np.isnan(places)], intact.zeros(dof)[0]):
            ratio[places == place] = changes.get(zero, zero) / zero
        columns = {name: getattr(table, name) for name in ("damping_ratio", "std_hz", "scores")}
        tables[dof] = ResponseTable(table.freq_hz * ratio, **columns)
    kept = {name: getattr(one, name) for name in ("left_out", "sees", "channels", "options")}
    return ar.AntiresonanceSet.from_tables(one.excitation, tables, **kept)


def predicted(sets, intact, damaged, states):
    """Alarms in each state, (n_draws, n_states), of intact tests drawn at random with its changes in them."""
    rng, after = np.random.default_rng(0), sets[intact // 2 : intact]
    alarms = []
    for _ in range(DRAWS):
        watched = ar.monitor(
            [
                *sets[:intact],
                *(
                    moved(after[i], states[0], now)
                    for now in states[1:]
                    for i in rng.integers(len(after), size=damaged)
                ),
            ],
            baseline=intact // 2,
        )
        alarms.append(watched.alarm[intact:].reshape(len(states) - 1, damaged).sum(axis=1))
    return np.array(alarms)


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
    draws = 100.0 / damaged * predicted(series.sets, intact, damaged, states)
    told = [
        f"{mean:.0f} % ({low:.0f} to {high:.0f} %)"
        for mean, low, high in zip(draws.mean(axis=0), *np.quantile(draws, BAND, axis=0), strict=True)
    ]
    ends = np.cumsum([intact // 2, intact - intact // 2, damaged, damaged])
    rows = []
    for label, first, last, own in zip(
        ("baseline", "intact", *(f"{100 * loss:g} % lower" for loss in LOSSES)),
        [0, *ends[:-1]],
        ends,
        ["", "", *told],
        strict=True,
    ):
        part = slice(first, last)
        seen = np.mean(~np.isnan(watched.freq_hz[part]))
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
                own,
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
