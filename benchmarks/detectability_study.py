"""Is what a prediction says of the smallest damage found what whole assessments find?

On the eight-mass chain, a portal frame and a grillage (members 5 % apart, three of each candidates), values
known to 0.05 %, structures 3 % beside their models: a90 of every candidate as ``method="predicted"`` tells it
from 30 structures, and from simulated tests, each with a structure of its own and ``assess_damage`` with its
baseline, by a fitted curve.
The ratio of a structure is that of all its elements together: its tests as one, severities in units of the
predicted a90.

    python -m benchmarks.detectability_study                    # 60 tests an element; 10 to 20 minutes
    python -m benchmarks.detectability_study --tests 20 --only chain8
    python -m benchmarks.detectability_study --shares --tests 10 --only portal

With ``--shares`` no curve is fitted: all members are candidates, and the share of tests is told that find
losses of 0.8, 1.0 and 1.2 times the a90 predicted from ten structures.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import time

import numpy as np

import antires_rs as ar
from antires_rs.damage.options import DamagePrior, SearchOptions
from antires_rs.planning.detectability import _virtual_test
from antires_rs.planning.detection_curves import fit_logit
from antires_rs.planning.placement import ExpectedErrors, Layout
from antires_rs.planning.simulated_tests import Task, judged
from benchmarks.study_tools import print_table
from reference.symmetric_structures import cases

STD, MODEL_ERROR = 5e-4, 0.03
#: Members of frames differ by this share.
SPREAD = 0.05
FRAMES = {"portal": "2 storeys of 2, corner", "grillage": "3 x 3, 0.8 x 0.8 m, corners held"}
#: Simulated losses reach from this share of the smallest a50 to this multiple of the largest a90.
_RANGE = (0.5, 2.5)
#: Candidates of the frames; with all twelve the simulated tests take hours.
CANDIDATES = {"portal": (0, 4, 8), "grillage": (2, 5, 10)}


def structures():
    """Model and test by name."""
    case = ar.cases.chain8()
    yield "chain8", case.model, {"excitation": 0, "sensors": case.responses, "band_hz": case.band_hz}
    for kind, name in FRAMES.items():
        frame = next(one for one in cases() if one.kind == kind and one.name == name)
        test = {"excitation": frame.excitation, "sensors": frame.sensors, "band_hz": frame.band_hz}
        yield kind, frame.build(SPREAD), test | {"elements": CANDIDATES[kind]}


def both(model, test, tests, seed):
    """Predicted and simulated curves."""
    options = {**test, "std": STD, "model_error": MODEL_ERROR}
    predicted = ar.detectability(model, **options, rng=seed, n_tests=30)
    # Where the curves rise: between losses that nobody sees and those that all do a fit says little of a90.
    ends = [_RANGE[0] * min(predicted.a50.values()), min(_RANGE[1] * max(predicted.a90.values()), 0.9)]
    simulated = ar.detectability(
        model, **options, rng=seed + 1, method="simulated", n_tests=tests, severities=ends
    )
    return predicted, simulated


def pooled(predicted, simulated):
    """a90 of all elements together in units of the predicted one, with its upper 95 % bound."""
    known = [e for e in predicted.a90 if np.isfinite(predicted.a90[e])]
    units = np.concatenate([simulated.tests[e][0] / predicted.a90[e] for e in known])
    found = np.concatenate([simulated.tests[e][1] for e in known]) > 0.5
    curve = fit_logit(units, found, units.max())
    return curve.a90, curve.bound


def shares(model, test, tests, seed):
    """Found or not, of the tests at multiples of the predicted a90; every other element."""
    options = {key: value for key, value in test.items() if key != "elements"}
    a90 = ar.detectability(model, **options, std=STD, model_error=MODEL_ERROR, rng=seed, n_tests=10).a90
    elements = tuple(a90)
    force, sensors, band = (options[key] for key in ("excitation", "sensors", "band_hz"))
    layout = Layout(model, tuple(sensors), force, band, "transmissibility")
    virtual, _ = _virtual_test(layout, elements, ExpectedErrors(0.01, 200.0, 0.01, STD), MODEL_ERROR, 1)
    found = {multiple: [] for multiple in (0.8, 1.0, 1.2)}
    known = [place for place, e in enumerate(elements) if np.isfinite(a90[e])][::2]
    seeds = iter(np.random.SeedSequence(seed + 1).spawn(len(known) * len(found) * tests))
    for place in known:
        for multiple, hits in found.items():
            for _ in range(tests):
                loss = multiple * a90[elements[place]]
                task = Task(place, loss, DamagePrior(), SearchOptions().checked(), next(seeds), 1)
                hits.append(elements[place] in judged(virtual, task))
    return found


def main():
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tests", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", default="")
    parser.add_argument("--shares", action="store_true")
    chosen = parser.parse_args()
    summary = []
    for name, model, test in structures():
        if chosen.only not in name:
            continue
        start = time.perf_counter()
        if chosen.shares:
            found = shares(model, test, chosen.tests, chosen.seed)
            print(name, {multiple: f"{sum(hits):.0f} of {len(hits)}" for multiple, hits in found.items()})
            continue
        predicted, simulated = both(model, test, chosen.tests, chosen.seed)
        rows = [
            [predicted.names[e], *(f"{100 * a[e]:.2f}" for a in (predicted.a50, predicted.a90))]
            + [f"{100 * a[e]:.2f}" for a in (simulated.a50, simulated.a90, simulated.a90_95)]
            + [f"{simulated.a90[e] / predicted.a90[e]:.2f}"]
            for e in predicted.a90
        ]
        print(f"\n{name}: {simulated.n_tests} simulated tests")
        head = ["stiffness loss, %", "a50 predicted", "a90", "a50 simulated", "a90", "a90/95", "ratio of a90"]
        print_table(head, rows, markdown=False)
        ratio, bound = pooled(predicted, simulated)
        summary.append(
            [name, f"{ratio:.2f}", f"{bound:.2f}", f"{100 * predicted.false_call_rate:.2f}"]
            + [f"{100 * simulated.false_call_rate:.1f}", f"{time.perf_counter() - start:.0f}"]
        )
    if not summary:
        return
    print()
    head = [
        "structure",
        "a90 simulated / predicted",
        "upper 95 %",
        "false calls predicted, %",
        "simulated, %",
        "s",
    ]
    print_table(head, summary, markdown=False)


if __name__ == "__main__":
    main()
