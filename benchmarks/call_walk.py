"""Files and functions of the package that run in one call: how much of the house a reader meets.

    python -m benchmarks.call_walk          # three calls, counted by sys.setprofile
    python -m benchmarks.call_walk --list   # with their names

Functions are counted once, lambdas and comprehensions not at all; a call is made once before, so that what
runs at import alone does not count.
"""

from __future__ import annotations

import argparse
import sys
import threading
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import antires_rs as ar
from reference.small_records import OPTIONS, record
from reference.wrong_chains import NOMINAL, chain, measured, truth

PACKAGE = str(Path(ar.__file__).parent)


def walked(call: Callable[[], Any]) -> set[tuple[str, str]]:
    """(file, function) of the package that run in the second of two calls."""
    call()
    seen = set()

    def noticed(frame: Any, event: str, _: Any) -> None:
        code = frame.f_code
        if (
            event == "call"
            and code.co_filename.startswith(PACKAGE)
            and "<" not in code.co_qualname.split(".")[-1]
        ):
            seen.add((code.co_filename.removeprefix(PACKAGE + "/"), code.co_qualname))

    threading.setprofile(noticed)
    sys.setprofile(noticed)
    try:
        call()
    finally:
        sys.setprofile(None)
        threading.setprofile(None)  # type: ignore[arg-type]
    return seen


def calls() -> dict[str, Callable[[], Any]]:
    """The three calls of the README, small."""
    rec = record(3)
    rng, factors = truth(5)
    before, now = measured(chain(factors), rng), measured(chain(factors, np.eye(5)[2] * 0.3), rng)
    case = ar.cases.chain8()
    problem = case.damage_problem(case.exact(1))
    ga = ar.IslandGA(max_evaluations=500)
    return {
        "identification of a record": lambda: ar.identify_antiresonances(rec, **OPTIONS),
        "damage with a baseline": lambda: ar.assess_damage(NOMINAL, now, baseline=before, workers=1),
        "update": lambda: ar.update(problem, optimizer=ga, rng=1),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--list", action="store_true")
    args = parser.parse_args()
    warnings.simplefilter("ignore")
    for name, call in calls().items():
        seen = walked(call)
        files = sorted({file for file, _ in seen})
        print(f"{name}: {len(files)} files, {len(seen)} functions")
        if args.list:
            for file in files:
                print(f"  {file}: {', '.join(sorted(f for at, f in seen if at == file))}")


if __name__ == "__main__":
    main()
