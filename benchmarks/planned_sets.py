"""Does a planned test find more than random ones, and does damage of the loss that is promised come out?

Structures of reference/outside_structures.py, exact values with scatter that is stated rightly.

1. ``plan_test`` with four sensors against twenty random sets of four, the force where it is: after a test of
   the intact structure, the loss of every element that nine of ten tests would find (``detectable``). The
   loss that matters is the median over all sets and elements; counted are the elements that are found there,
   the random sets that find fewer, and those that have a larger mean ln of these losses.
2. With ``--found``, all sensors: damage of the loss that ``detectable`` says of two elements of each truth,
   and at 0.75 and 1.25 of it; whether ``assess_damage`` declares the element.

    python -m benchmarks.planned_sets                     # 3 truths a structure; some minutes
    python -m benchmarks.planned_sets --found --truths 6
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import warnings

import numpy as np

import antires_rs as ar
from benchmarks.study_tools import each, print_table
from reference.outside_cases import STD
from reference.outside_structures import STRUCTURES, State, measured

PLANNED_STD, SENSORS, RANDOM, MULTIPLES = 3e-4, 4, 20, (0.75, 1.0, 1.25)


def limits(structure, before, again):
    """Losses that nine of ten tests find, 1 where none does, of all elements."""
    found = ar.assess_damage(
        structure.model, again, baseline=before, elements=structure.elements, workers=1, progress=False
    )
    return np.minimum(list(found.detectable.values()), 1.0)


def seen_by(whole, sensors):
    """The part of a test that these sensors have."""
    freq = {dof: whole[dof] for dof in sensors}
    std = {dof: whole.std_hz[dof] for dof in sensors}
    return ar.AntiresonanceSet(whole.excitation, freq, std_hz=std, sees="transmissibility", channels=sensors)


def planned(task):
    """Losses found, (truths, elements), by the planned set and by random ones."""
    warnings.simplefilter("ignore")
    name, truths = task
    structure, rng = STRUCTURES[name], np.random.default_rng([5, SENSORS])
    plan = ar.plan_test(
        structure.model,
        structure.elements,
        n_sensors=SENSORS,
        candidates=list(structure.dofs),
        excitations=structure.force,
        band_hz=structure.band_hz,
        std=PLANNED_STD,
    )
    sets = [
        plan.sensors,
        *(tuple(rng.choice(structure.dofs, SENSORS, replace=False).tolist()) for _ in range(RANDOM)),
    ]
    found = np.ones((len(sets), truths, structure.n_elements))
    for number in range(truths):
        rng = np.random.default_rng([6, list(STRUCTURES).index(name), number])
        exact = structure.truth(structure.drawn(rng))
        whole = [measured(structure, exact, PLANNED_STD, rng) for _ in range(2)]
        for nth, sensors in enumerate(sets):
            try:
                found[nth, number] = limits(structure, *(seen_by(one, sensors) for one in whole))
            except ar.exceptions.InvalidInputError:  # the values are too few to be those of the model
                continue
    return name, sets, found


def told(name, sets, found):
    """One row of the first table."""
    matters = float(np.median(found))
    share, size = np.mean(found <= matters, axis=(1, 2)), np.mean(np.log(found), axis=(1, 2))
    ranks = f"{100 * share[0]:.0f} %", f"{100 * np.median(share[1:]):.0f} %", f"{100 * share[1:].max():.0f} %"
    fewer = f"{np.sum(share[1:] < share[0])} (+ {np.sum(share[1:] == share[0])})"
    return [name, f"{100 * matters:.1f}", *ranks, fewer, int(np.sum(size[1:] > size[0])), sets[0]]


def stated(task):
    """Multiple of the stated loss, and whether the element is among those declared."""
    warnings.simplefilter("ignore")
    name, number = task
    structure = STRUCTURES[name]
    rng = np.random.default_rng([88, list(STRUCTURES).index(name), number])
    own, std = structure.drawn(rng), float(np.exp(rng.uniform(*np.log(STD))))
    before, again = (measured(structure, structure.truth(own), std, rng) for _ in range(2))
    seen = limits(structure, before, again)
    some = np.flatnonzero(seen < 0.9)
    found = []
    for element in rng.choice(some, min(2, some.size), replace=False).tolist():
        for multiple in MULTIPLES:
            loss = min(multiple * seen[element], 0.95)
            now = measured(structure, structure.truth(own, State(losses={element: loss})), std, rng)
            result = ar.assess_damage(
                structure.model, now, baseline=before, elements=structure.elements, workers=1, progress=False
            )
            found.append((name, multiple, element in result.damaged))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    every = [name for name, one in STRUCTURES.items() if not one.cracks_alone]
    parser.add_argument("--structures", nargs="+", default=every, choices=every)
    parser.add_argument("--truths", type=int, default=3, help="of each structure")
    parser.add_argument("--found", action="store_true", help="damage of the loss that is promised")
    parser.add_argument("--first", type=int, default=0, help="number of the first truth of --found")
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    if given.found:
        numbers = range(given.first, given.first + given.truths)
        tasks = [(name, number) for number in numbers for name in given.structures]
        rows = [row for part in each(stated, tasks, given.workers) for row in part]
        lines = []
        for name in [*given.structures, "all"]:
            own = [[hit for n, m, hit in rows if m == times and name in (n, "all")] for times in MULTIPLES]
            lines.append([name, *(f"{sum(hits)} of {len(hits)}" for hits in own)])
        print_table(["found at times the stated loss", *MULTIPLES], lines, False)
        return
    head = [
        "",
        "loss that matters, %",
        "planned",
        "random",
        "best random",
        "find fewer",
        "larger losses",
        "set",
    ]
    tasks = [(name, given.truths) for name in given.structures]
    print_table(head, [told(*found) for found in each(planned, tasks, given.workers)], False)


if __name__ == "__main__":
    main()
