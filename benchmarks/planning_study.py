"""Sensors chosen by exchange: against all sets of four; on the exhaust against its sixteen and random sixes.

1. Worth of the greedy set over that of the best of all sets, twelve candidates at most choose four, on random
   chains and on portals, grillages and rings whose members are 7 % apart.
2. The exhaust, 30 candidate elements, values known to 0.05 %, force where the case has it: six of its sixteen
   sensors by plan, all sixteen, and random sixes; information, and the losses that nine of ten tests show.
3. With ``--detection``: a90 of the cracked element by ``ar.detectability`` for these sets.

    python -m benchmarks.planning_study --detection      # some minutes
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse

import numpy as np

import antires_rs as ar
from benchmarks.study_tools import print_table
from reference.symmetric_structures import cases

SPREAD, STD, MODEL_ERROR = 0.07, 5e-4, 0.03
CRITERIA = ("determinant", "worst")
ELEMENTS, BAND_HZ, CRACKED = range(17, 47), (1.0, 260.0), 30


def random_chain(seed):
    """Eleven masses."""
    rng = np.random.default_rng([seed, 78])
    return ar.MassSpringChain(0.42 * rng.uniform(0.5, 1.5, 11), 56.7e3 * rng.uniform(0.5, 1.5, 10))


def structures():
    """Name, model, candidates, force, end of the band."""
    for seed in range(10, 16):
        yield f"random chain {seed}", random_chain(seed), list(range(11)), seed % 5, 200.0
    for case in cases():
        if case.kind != "chain" and len(case.sensors) > 5:
            yield (
                f"{case.kind}, {case.name}",
                case.build(SPREAD),
                list(case.sensors)[:12],
                case.excitation,
                (case.band_hz[1]),
            )


def against_all_sets():
    """Print how far greedy with exchange stays below the best of all sets."""
    rows = []
    for name, model, sensors, force, high in structures():
        row = [name, len(sensors)]
        for criterion in CRITERIA:
            options = {"n_sensors": 4, "candidates": sensors, "excitations": force, "criterion": criterion}
            ours, best = (
                ar.plan_test(model, **options, band_hz=(0.0, high), std=STD, search=search)
                for search in ("greedy", "exhaustive")
            )
            ratio = ours.value / best.value if np.isfinite(best.value) else 1.0
            row.append(f"{ratio:.4f}")
        rows.append(row)
    print_table(["structure", "candidates", "nats / best", "worst loss / best"], rows, markdown=False)


def exhaust_plans(n_random):
    """Print the sets of the exhaust, and return those to be judged further."""
    case = ar.cases.exhaust()
    rng = np.random.default_rng(0)
    options = {"band_hz": BAND_HZ, "excitations": case.excitation, "std": STD}

    def plan(sensors, n):
        return ar.plan_test(case.model, ELEMENTS, n_sensors=n, candidates=sensors, **options)

    all_of_them, six = plan(case.responses, 16), plan(case.responses, 6)
    free = plan(None, 6)
    draws = [plan(rng.choice(case.responses, 6, replace=False).tolist(), 6) for _ in range(n_random)]
    draws.sort(key=lambda one: one.value)
    middle = draws[len(draws) // 2]
    sets = {
        "the case's 16": all_of_them,
        "best 6 of them": six,
        "best 6 of all translations": free,
        f"random 6 of the 16, median of {n_random}": middle,
        f"random 6, best of {n_random}": draws[-1],
    }
    rows = [
        [name, one.n_values, f"{one.value:.1f}", f"{100 * np.median(list(one.detectable.values())):.1f}"]
        + [f"{100 * one.detectable[CRACKED]:.1f}"]
        for name, one in sets.items()
    ]
    print_table(["exhaust", "values", "nats", "median loss seen, %", "element 30, %"], rows, markdown=False)
    return case, sets


def detection(case, sets):
    """Print the probability of detection of the cracked element."""
    rows = []
    for name, plan in list(sets.items())[:4]:
        curves = ar.detectability(
            case.model,
            ELEMENTS,
            excitation=plan.excitation,
            sensors=sorted(plan.sensors),
            band_hz=BAND_HZ,
            std=STD,
            model_error=MODEL_ERROR,
            n_tests=3,
            rng=0,
        )
        seen = np.array(list(curves.a90.values()))
        rows.append(
            [
                name,
                f"{100 * curves.a90[CRACKED]:.1f}",
                f"{100 * np.median(seen):.1f}",
                int((seen < 0.1).sum()),
            ]
        )
    head = [
        "exhaust, 3 % model error",
        "a90 of element 30, %",
        "median a90, %",
        "elements of 30 with a90 < 10 %",
    ]
    print_table(head, rows, markdown=False)


def main():
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--random", type=int, default=41)
    parser.add_argument("--detection", action="store_true")
    chosen = parser.parse_args()
    against_all_sets()
    print()
    found = exhaust_plans(chosen.random)
    if chosen.detection:
        print()
        detection(*found)


if __name__ == "__main__":
    main()
