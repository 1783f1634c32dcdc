"""Intact symmetric structures with sensors on nodes of their modes: is damage reported, and could it be seen?

Thirty chains, rings, portal frames and grillages (reference/symmetric_structures.py). Each record, without
noise and with 1 % of each channel's rms, is simulated from K and M as matrices; antiresonances are identified
with the default settings and compared with the symmetric model. Counted are

- elements reported as damaged (there is none),
- the largest difference between a compared value and its partner,
- the largest ratio of ``detectable`` to that of a twin whose members differ by 1 per mille, with its own
  record (elements that neither sees below 30 % left out),
- values compared though a complex zero of the undamped structure is nearest to them in frequency and damping.

    python -m benchmarks.symmetric_structures                      # all, 0 and 1 % noise, with the twins
    python -m benchmarks.symmetric_structures --only ring --noise 0.01 --route frf --no-twins
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import sys
import time
import warnings

import numpy as np

import antires_rs as ar
from benchmarks.study_tools import each, print_table
from reference.symmetric_structures import DAMPING_RATIO, cases, true_zeros

#: The members of a twin differ by this share.
SPREAD = 0.001
#: A zero is complex from this damping ratio of the undamped structure on.
COMPLEX = 0.005
#: Twins are compared where damage below this is detectable; within this factor they agree.
LARGEST, AGREE = 0.3, 1.2


def assessed(case, model, *, noise, seed, route):
    """Identified and assessed with the model that is the truth."""
    found = case.identified(model, noise=noise, seed=seed, route=route)
    return ar.assess_damage(model, found, rng=0, workers=1)


def wrong_kinds(case, model, problem):
    """Compared values to which a complex zero is nearer than any real one, as (dof, Hz)."""
    wrong = []
    (found,) = problem.measured
    for dof, freq in zip(problem.measured_dofs.tolist(), problem.measured_hz, strict=True):
        at = int(np.argmin(np.abs(found[dof] - freq)))
        damping = found.tables[dof].damping_ratio[at]
        zeros = true_zeros(model, dof, case.excitation)
        part = zeros.imag / np.abs(zeros)
        apart = np.hypot(np.abs(zeros) / freq - 1.0, np.abs(np.abs(damping - DAMPING_RATIO) - part))
        if part[np.argmin(apart)] > COMPLEX:
            wrong.append((dof, float(freq)))
    return wrong


def one_run(task):
    """What is counted of one case."""
    number, noise, route, twins = task
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    case = cases()[number]
    start = time.perf_counter()
    model = case.build(0.0)
    result = assessed(case, model, noise=noise, seed=number, route=route)
    ratio = 1.0
    if twins:
        twin = assessed(case, case.build(SPREAD), noise=noise, seed=number, route=route)
        both = [
            (result.detectable[e], twin.detectable[e])
            for e in result.elements
            if min(result.detectable[e], twin.detectable[e]) <= LARGEST
        ]
        ratio = max((max(a, b) / min(a, b) for a, b in both), default=1.0)
    problem = result.problem
    return {
        "kind": case.kind,
        "name": case.name,
        "noise": noise,
        "compared": problem.measured_hz.size,
        "left out": len(problem.left_out),
        "damaged": result.damaged,
        "largest %": result.table.largest_before_percent,
        "least detectable": min(result.detectable.values()) if twins else float("nan"),
        "ratio": ratio,
        "wrong kind": wrong_kinds(case, model, problem),
        "seconds": time.perf_counter() - start,
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--noise", type=float, nargs="+", default=[0.0, 0.01])
    parser.add_argument("--only", nargs="+", help="words of which kind or name must contain one")
    parser.add_argument("--route", default="transmissibility", choices=("transmissibility", "frf"))
    parser.add_argument("--no-twins", dest="twins", action="store_false")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--markdown", action="store_true")
    options = parser.parse_args()
    chosen = [
        n
        for n, case in enumerate(cases())
        if not options.only or any(word in f"{case.kind} {case.name}" for word in options.only)
    ]
    tasks = [(n, noise, options.route, options.twins) for n in chosen for noise in options.noise]
    runs = []
    for run in each(one_run, tasks, options.jobs):
        runs.append(run)
        print(
            f"{run['kind']}, {run['name']}, {100 * run['noise']:g} %: {run['compared']} compared, "
            f"{run['left out']} left out, damaged {run['damaged']}, largest {run['largest %']:.2f} %, "
            f"least detectable {run['least detectable']:.3f}, twin {run['ratio']:.2f}, "
            f"wrong kind {run['wrong kind']}, {run['seconds']:.1f} s",
            file=sys.stderr,
            flush=True,
        )
    header = ["kind", "noise", "cases", "damage in", "values", "left out", "largest %", "twins", "wrong kind"]
    rows = []
    for kind in dict.fromkeys(run["kind"] for run in runs):
        for noise in options.noise:
            of = [run for run in runs if (run["kind"], run["noise"]) == (kind, noise)]
            agree = sum(run["ratio"] <= AGREE for run in of)
            rows.append(
                [
                    kind,
                    f"{100 * noise:g} %",
                    len(of),
                    sum(bool(run["damaged"]) for run in of),
                    sum(run["compared"] for run in of),
                    sum(run["left out"] for run in of),
                    f"{max(run['largest %'] for run in of):.2f}",
                    f"{agree} of {len(of)} agree" if options.twins else "-",
                    sum(len(run["wrong kind"]) for run in of),
                ]
            )
    print_table(header, rows, options.markdown)


if __name__ == "__main__":
    main()
