"""The worked cases of finite-element codes: five damages of 10 to 50 % each, and five intact records.

Models and records are calculated by CalculiX and OpenSeesPy (examples/records_of_codes.py); each structure
differs from its model. One record of the intact structure is the baseline and updates the model.

    python -m benchmarks.fe_cases                         # all three, some ten minutes
    python -m benchmarks.fe_cases ribbed_plate
"""

from __future__ import annotations

import importlib
import os
import sys
import tempfile
import time
import warnings
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import antires_rs as ar

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))
codes = importlib.import_module("records_of_codes")

LOSSES = (0.10, 0.20, 0.30, 0.40, 0.50)
DAMAGED = {
    "bolted_bracket": ("W1", "W3", "W2", "W4", "W1"),
    "ribbed_plate": ("R1", "R2", "R3", "R4", "R2"),
    "six_storey_frame": ("west_1", "east_5", "east_2", "west_4", "east_3"),
}


def main(names):
    """Prints a row for each record, and the sums."""
    warnings.simplefilter("ignore")
    first = alone = sized = false = of = 0
    for name in names:
        case, begun = importlib.import_module(name), time.perf_counter()
        with tempfile.TemporaryDirectory() as folder:
            updated, dofs, intact = codes.prepared(case, Path(folder))
            damages = [{group: 1.0 - loss} for group, loss in zip(DAMAGED[name], LOSSES, strict=True)]
            for seed, damage in enumerate([*damages, *[{}] * 5], 1):
                now = codes.identified(case, dofs, case.record(Path(folder), damage, seed))
                found = ar.assess_damage(updated.model, now, baseline=intact, elements=case.CANDIDATES)
                if seed == 1:
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
                first, alone = first + (found.damaged[:1] == [at]), alone + (found.damaged == [at])
                sized, of = sized + near, of + 1
    print(
        f"of {of} damages and {of} intact: group right {first}, named alone {alone}, severity {sized}, ",
        end="",
    )
    print(f"false alarms {false}")


if __name__ == "__main__":
    main(sys.argv[1:] or DAMAGED)
