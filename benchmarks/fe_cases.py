"""Structures calculated by finite-element codes: five damages of 10 to 50 % each, and five intact records.

Models and records are calculated by CalculiX and OpenSeesPy (examples/records_of_codes.py); each structure
differs from its model. One record of the intact structure is the baseline and updates the model. The three
worked cases were adjusted on the damages of the first set; sets by ``--fresh`` draw groups, losses and noise
anew, and nothing was adjusted on the girder and the box.

    python -m benchmarks.fe_cases                               # the three worked cases, some ten minutes
    python -m benchmarks.fe_cases --fresh 7                     # all five, other damages, losses and records
    python -m benchmarks.fe_cases --fresh 7 fe_girder fe_box
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import tempfile
import time
import warnings
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

import antires_rs as ar

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "examples")]
codes = importlib.import_module("records_of_codes")

LOSSES = (0.10, 0.20, 0.30, 0.40, 0.50)
DAMAGED = {
    "bolted_bracket": ("W1", "W3", "W2", "W4", "W1"),
    "ribbed_plate": ("R1", "R2", "R3", "R4", "R2"),
    "six_storey_frame": ("west_1", "east_5", "east_2", "west_4", "east_3"),
}
NEW = ("fe_girder", "fe_box")


def damages_of(name, case, fresh):
    """Groups and what is left of them."""
    if fresh is None:
        drawn = zip(DAMAGED[name], LOSSES, strict=True)
    else:
        rng = np.random.default_rng([fresh, *name.encode()])
        groups = rng.choice(case.CANDIDATES, 5, replace=len(case.CANDIDATES) < 5)
        drawn = zip(groups.tolist(), rng.uniform(0.1, 0.5, 5).round(3).tolist(), strict=True)
    return [{group: 1.0 - loss} for group, loss in drawn]


def main(argv):
    """Prints a row for each record, and the sums."""
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="*")
    parser.add_argument("--fresh", type=int)
    args = parser.parse_args(argv)
    names = args.names or (*DAMAGED, *(NEW if args.fresh is not None else ()))
    seeds = 0 if args.fresh is None else 1000 * (args.fresh + 1)
    warnings.simplefilter("ignore")
    first = alone = sized = false = of = 0
    for name in names:
        case, begun = importlib.import_module(name), time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            updated, dofs, intact = codes.prepared(case, Path(folder), seeds)
            for nth, damage in enumerate([*damages_of(name, case, args.fresh), *[{}] * 5], 1):
                now = codes.identified(case, dofs, case.record(Path(folder), damage, seeds + nth))
                found = ar.assess_damage(updated.model, now, baseline=intact, elements=case.CANDIDATES)
                if nth == 1:
                    found.report(Path(folder) / "report.html")
                    took = f"from input to report {time.perf_counter() - begun:.0f} s"
                    print(f"{name}: {updated.model.n_dof} dofs; {took}", flush=True)
                print(f"  {damage or 'intact'}: {found.headline}", flush=True)
                if not damage:
                    false += bool(found.assessment.declared)
                    continue
                ((group, left),) = damage.items()
                at = updated.model.element(group)
                low, high = found.interval[at]
                near = abs(found.severity[at] - 1.0 + left) <= 0.03 or low <= 1.0 - left <= high
                inside = "inside" if low <= 1.0 - left <= high else "outside"
                told = f"{100 * found.severity[at]:.1f} ({100 * low:.1f} to {100 * high:.1f}), {inside}"
                print(f"    {group} lost {100 * (1.0 - left):.1f}, told {told}", flush=True)
                first, alone = first + (found.damaged[:1] == [at]), alone + (found.damaged == [at])
                sized, of = sized + near, of + 1
    head = f"of {of} damages and {of} intact: group right {first}, named alone {alone}, severity {sized}"
    print(f"{head}, false alarms {false}")


if __name__ == "__main__":
    main(sys.argv[1:])
