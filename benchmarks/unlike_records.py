"""Records of one test that do not belong together: what ``records_differ`` names, and how often wrongly.

Four hits (reference/virtual_records.py), three of them at one place with the right channels, on chains of
3 to 8 masses and portal frames drawn at random, noise of 0.1 to 20 %, damping of 0.3 to 2 %. The fourth is a
repeat, has two channels exchanged or one turned round, was at another place, or on a structure of which one
element has lost 5 to 50 %. The limits were set on other hits.

    python -m benchmarks.unlike_records --seeds 40 --first-seed 1100
"""

from __future__ import annotations

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import warnings
from collections import Counter

import numpy as np
from scipy.sparse import csc_array

import antires_rs as ar
from benchmarks.study_tools import print_table
from reference.virtual_records import hit_record

LOSSES = (0.05, 0.2, 0.5)


def chain(rng):
    """Function from (element, loss) to the model, its sensors, elements, and the modes that a hit excites."""
    n = int(rng.integers(3, 9))
    masses, springs = rng.uniform(2.0, 5.0, n), rng.uniform(8e3, 16e3, n)

    def made(element=0, loss=0.0):
        own = springs * np.where(np.arange(n) == element, 1.0 - loss, 1.0)
        return ar.MassSpringChain(masses, own[1:], ground_first_n_per_m=own[0])

    return made, np.arange(n), n, n


def portal(rng):
    """The same."""
    height, width = rng.uniform(2.0, 4.0), rng.uniform(3.0, 6.0)
    nodes = [(0.0, height * i / 4) for i in range(5)] + [(width * i / 4, height) for i in range(1, 5)]
    nodes += [(width, height * (3 - i) / 4) for i in range(4)]
    beams = [(e, e + 1, f"s{e}") for e in range(len(nodes) - 1)]

    def made(element=0, loss=0.0):
        moduli = {name: 2.1e11 * (1.0 - loss * (e == element)) for e, _, name in beams}
        sections = {name: ar.Rectangle(0.06, 0.1, modulus, 7850.0) for name, modulus in moduli.items()}
        return ar.FrameModel(nodes, beams, sections, fixed=[0, len(nodes) - 1])

    intact = made()
    dofs = [intact.dof(i, "u") for i in range(2, 12)] + [intact.dof(i, "v") for i in (5, 6, 7)]
    return (
        made,
        np.sort(rng.choice(dofs, int(rng.integers(3, 9)), replace=False)),
        12,
        int(rng.integers(3, 7)),
    )


def fourth(structure, seed):
    """By what the fourth record is: what is said of it and the three others, and the channels changed."""
    rng = np.random.default_rng(seed)
    made, dofs, n_elements, n_modes = structure(rng)
    freq = made().modes().freq_hz[:n_modes]
    damping, noise = rng.choice([0.003, 0.01, 0.02]), rng.choice([0.001, 0.01, 0.05, 0.2])
    how = {"fs_hz": 2.6 * freq.max(), "damping_ratio": damping, "noise": noise, "pulse_s": 1.0 / freq.max()}
    how["duration_s"] = min(30.0, 8.0 / (damping * 2.0 * np.pi * freq.min()))
    here, there = rng.choice(dofs, 2, replace=False)
    a, b = sorted(rng.choice(len(dofs), 2, replace=False).tolist())

    def record(place=here, loss=0.0):
        model, own = made(int(rng.integers(n_elements)), loss), int(rng.integers(2**31))
        both = (csc_array(each).toarray() for each in (model.stiffness(), model.mass()))
        return ar.Recording(hit_record(*both, excitation=place, seed=own, **how)[0][dofs], how["fs_hz"])

    good = [record() for _ in range(3)]
    rows, signs = np.arange(len(dofs)), np.ones((len(dofs), 1))
    rows[[a, b]], signs[a] = (b, a), -1.0
    others = {"a repeat": record(), "another place": record(there)}
    others |= {f"{100 * loss:g} % lost": record(loss=loss) for loss in LOSSES}
    others["exchanged"] = ar.Recording(record().responses[rows], how["fs_hz"])
    others["turned round"] = ar.Recording(signs * record().responses, how["fs_hz"])
    band_hz = 0.6 * freq.min(), 1.05 * freq.max()
    for kind, other in others.items():
        check = ar.check_data([*good, other], band_hz=band_hz)
        yield kind, " ".join(one.text for one in check.named("records_differ")), (a, b)


def verdict(kind, text, changed):
    """What that is: nothing, the right change, another one, or a second place."""
    if not text:
        return "nothing"
    if "share one force place" in text:
        return "second place"
    right = {
        "exchanged": "Record 3: channels {} and {} look swapped",
        "turned round": "Record 3: channel {} looks turned",
    }
    return "right" if text.startswith(right.get(kind, "never").format(*changed)) else "another change"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--first-seed", type=int, default=1100)
    args = parser.parse_args()
    warnings.simplefilter("ignore", ar.AntiresWarning)
    rows, columns = [], ["right", "second place", "another change", "nothing"]
    for name, structure in (("chain", chain), ("portal", portal)):
        found = {}
        for seed in range(args.first_seed, args.first_seed + args.seeds):
            for kind, text, changed in fourth(structure, seed):
                found.setdefault(kind, Counter())[verdict(kind, text, changed)] += 1
        rows += [
            [f"{name}, {kind}", *(str(own[column]) for column in columns)] for kind, own in found.items()
        ]
    print_table(["the fourth of four hits", *columns], rows, markdown=True)


if __name__ == "__main__":
    main()
