"""Replays the main results and compares them with those kept in ``answers.json``.

    python -m tests.main_results.replay                      # all kinds, a table of what differs
    python -m tests.main_results.replay --kind searches --only chain8
    python -m tests.main_results.replay --record             # writes answers.json and files_0 anew
    python -m tests.main_results.replay --record --kind identifications --only "shake table"   # these alone
    python -m tests.main_results.replay --answers FILE       # recorded on this machine: to 1e-9

Searches are compared bit for bit, assessments by their hypotheses and to 1e-6 in probabilities and
severities, identifications by their values: to 1e-9 where the answers are of the same machine. Another
processor or BLAS rounds otherwise; from the one that ``answers.json`` is of, a second differed by 5e-7 in
frequencies, 1e-5 in damping ratios, and 7 % in the standard deviation of one value.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import inspect
import json
import sys
import time
from pathlib import Path
from typing import Any

import antires_rs as ar
from tests.main_results import files
from tests.main_results.cases import KINDS, answer

ANSWERS = Path(__file__).with_name("answers.json")
#: Largest relative difference of numbers; of identifications on the machine that recorded them.
LIMITS = {"searches": 0.0, "identifications": 1e-9, "assessments": 1e-6}
#: The same on other machines, by the name of what is compared.
ELSEWHERE = {"freq_hz": 5e-6, "damping_ratio": 1e-3, "std_hz": 0.2}


def differences(
    kept: Any, new: Any, limit: float, place: str = "", *, by_name: dict[str, float] | None = None
) -> list[str]:
    """Places where two answers differ by more than the limit, relative to 1 or to the larger number.

    ``by_name`` has limits of its own for what stands under these keys.
    """
    if isinstance(kept, dict) and isinstance(new, dict):
        parts = {key: (kept.get(key), new.get(key)) for key in sorted({*kept, *new})}
    elif isinstance(kept, list) and isinstance(new, list) and len(kept) == len(new):
        parts = dict(enumerate(zip(kept, new, strict=True)))
    else:
        parts = {}
    if parts:
        limits = {key: (by_name or {}).get(key, limit) for key in parts}
        inside = (differences(*parts[k], limits[k], f"{place}/{k}", by_name=by_name) for k in parts)
        return [line for lines in inside for line in lines]
    if isinstance(kept, float) and isinstance(new, float | int):
        if kept == new or kept != kept and new != new:
            return []
        # Of standard deviations and damping, the share of themselves; of probabilities, themselves.
        off = abs(kept - new) / (1.0 if limit == LIMITS["assessments"] else max(abs(kept), abs(new)))
        return [f"{place}: {kept!r} was, {new!r} is"] if not off <= limit else []
    return [] if kept == new else [f"{place}: {kept!r} was, {new!r} is"]


def compared(kind: str, kept: Any, case: Any, *, here: bool) -> list[str]:
    """What differs in one case; ``here``: the answers kept are of this machine."""
    now = json.loads(json.dumps(answer(case)))
    by_name = None if here or kind != "identifications" else ELSEWHERE
    return differences(kept, now, LIMITS[kind], by_name=by_name)


def replayed(kind: str, only: str = "", say: Any = None, answers: Path = ANSWERS) -> dict[str, list[str]]:
    """By case of a kind: what differs."""
    kept = json.loads(answers.read_text(encoding="utf-8"))[kind]
    result = {}
    for name, case in KINDS[kind]():
        if only in name:
            start = time.perf_counter()
            result[name] = compared(kind, kept[name], case, here=answers != ANSWERS)
            if say is not None:
                say(f"{kind}: {name}: {'same' if not result[name] else result[name][:3]} "
                    f"({time.perf_counter() - start:.1f} s)")  # fmt: skip
    return result


def names() -> dict[str, list[str]]:
    """Public names with the parameters of those that are called, and public attributes of classes."""
    found = {}
    for name in ar.__all__:
        thing = getattr(ar, name)
        if inspect.isclass(thing):
            found[name] = sorted(each for each in dir(thing) if not each.startswith("_"))
        elif inspect.isfunction(thing):
            found[name] = list(inspect.signature(thing).parameters)
        else:
            found[name] = []
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--record", action="store_true")
    parser.add_argument("--kind", choices=list(KINDS), nargs="*", default=list(KINDS))
    parser.add_argument("--only", default="")
    parser.add_argument("--answers", type=Path, default=ANSWERS)
    args = parser.parse_args()
    if args.record:
        kept: dict[str, Any] = {}
        if args.only or args.kind != list(KINDS):  # all others, and the files, stay as they are
            kept = json.loads(args.answers.read_text(encoding="utf-8"))
        else:
            files.write(files.FOLDER)
            kept = {"names": names(), "job_keys": files.job_keys(), "files": files.read(files.FOLDER)}
        for kind in args.kind:
            for name, case in KINDS[kind]():
                if args.only in name:
                    start = time.perf_counter()
                    kept.setdefault(kind, {})[name] = answer(case)
                    print(f"{kind}: {name} ({time.perf_counter() - start:.1f} s)", flush=True)
        args.answers.write_text(json.dumps(kept, indent=None) + "\n", encoding="utf-8")
        return 0
    bad = 0
    for kind in args.kind:
        found = replayed(kind, args.only, lambda line: print(line, flush=True), args.answers)
        bad += sum(bool(lines) for lines in found.values())
        print(f"{kind}: {len(found)} replayed, {sum(bool(lines) for lines in found.values())} differ")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())
