"""Damage that is not an element, a model wrong in its joints, a structure that warms: answers by class.

Structures of reference/outside_structures.py, none of them from the package's models; exact values with
1e-4 to 1e-3 of scatter, stated rightly. Each case is assessed against a baseline of one intact test, with the
nominal model. Counted for every structure and kind are

- alarms (damage declared where there is none) and "else": answers that something else has changed;
- right answers, of all and of those whose losses are above a90: the sets of elements are equal, for a crack
  its element or the neighbour on its side. Of a mass, a support, a joint, a moved sensor it is right that no
  candidate explains them, at a joint also to name elements that meet there; where the values show next to
  nothing, that nothing has changed; of a warmer structure that nothing has, or all values alike;
- 90 % intervals of the losses of right answers, and the median error of their severities; of single cracks
  the interval of the place, and the error of it, over the structure's length, that nine of ten stay below;
- answers that name elements wrongly with more than 0.99 (of them: beside the place), and "nothing" above 0.9
  where it is not right.

Then the probability of the best hypothesis against how often it is right, overall and by class.

    python -m benchmarks.outside_class                      # all, 25 intact, 25 single, 15 double, 10 others
    python -m benchmarks.outside_class --structures portal --kinds single joint --single 10 --others 10
    python -m benchmarks.outside_class --kinds temperature --environment temperature --others 20
    python -m benchmarks.outside_class --records --structures portal --kinds intact single double
    python -m benchmarks.outside_class --out after.json --against before.json   # case by case
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import json
import re
import sys
import time
import warnings
from itertools import pairwise
from pathlib import Path

import numpy as np

import antires_rs as ar
from benchmarks.study_tools import each, print_table
from reference.outside_cases import KINDS, OUTSIDE, case, kinds_of
from reference.outside_structures import STRUCTURES

#: Ends of the classes of stated probability.
STATED = (0.0, 0.5, 0.9, 0.99, 1.0 + 1e-9)
#: Places are printed with three digits, m.
_ROUNDED = 5e-4
#: Changes below it, in standard deviations of a difference, may be called nothing.
UNSEEN = 1.0
#: More hypotheses than these are not kept.
KEPT = 5
CLASSES = {
    "intact": ("intact",),
    "damage": ("single", "double"),
    "cracks": ("crack",),
    "outside": OUTSIDE,
    "temperature": ("temperature",),
}


def one_case(task):
    """Truth and answer."""
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    name, kind, number, seed, environment, records = task
    one = case(name, kind, number, seed, records=records)
    model, elements = one.structure.model, one.structure.elements
    row = {
        "structure": name,
        "kind": kind,
        "number": number,
        "seed": seed,
        "std": one.std,
        "values": [sum(map(len, each.values())) for each in (one.before, one.now)],
        "change_in_std": one.change_in_std,
        "truth": {e: loss for e, loss in sorted(one.losses.items())},
        "state": repr(one.state),
    }
    start = time.process_time()
    try:
        how = {"elements": elements, "environment": environment, "workers": 1}
        result = ar.assess_damage(model, one.now, baseline=one.before, **how)
        row |= answered(one, result)
    except ar.exceptions.InvalidInputError as exc:
        row |= REFUSED | {"refused": str(exc)}
    row["seconds"] = time.process_time() - start
    return json.loads(json.dumps(row))


#: An answer that the model is not that of the structure: never right.
REFUSED = {
    "damaged": [],
    "best": [],
    "best_probability": 0.0,
    "candidate": False,
    "unknown": True,
    "alike": False,
}
REFUSED |= {"place": [], "nothing": 0.0, "interval": {}, "a90": {}, "right": False, "touching": False}


def answered(one, result):
    """The answer and what is right about it."""
    best = result.hypotheses[0]
    alike = bool(best.unknown and result.assessment.moved_alike)
    named = set() if best.unknown else set(best.elements)
    return {
        "damaged": result.damaged,
        "best": sorted(named),
        "best_probability": float(best.probability),
        "candidate": best.candidate,
        "unknown": best.unknown,
        "kind_told": kind_of(best),
        "place_told": getattr(best, "place", ""),
        "alike": alike,
        "nothing": result.assessment.probability_of_nothing,
        "elsewhere": result.assessment.probability_elsewhere,
        "hypotheses": [
            {
                "elements": list(h.elements),
                "probability": float(h.probability),
                "severities": list(h.severities),
            }
            for h in list(result.hypotheses)[:KEPT]
        ],
        "severity": {e: result.severity[e] for e in result.damaged},
        "interval": {e: list(result.interval[e]) for e in result.damaged},
        "a90": {e: min(result.detectable[e], 9.9) for e in one.losses},
        "explained": result.assessment.explained,
        "right": is_right(one, best, alike),
        "place": place_of(one, best),
        "touching": bool(named) and named <= one.touching.union(*one.allowed),
    }


def place_of(one, best):
    """Of a single crack that was found: error of its place over the structure's length, and whether its
    interval holds it; else nothing."""
    if len(one.state.cracks) != 1 or getattr(best, "kind", "") != "crack" or len(best.elements) != 1:
        return []
    (crack,), frame = one.state.cracks, one.structure
    told, low, high = (
        float(x) for x in re.match(r"crack ([\d.e-]+) m \(([\d.e-]+) to ([\d.e-]+)\)", best.place).groups()
    )
    lengths = [frame._length(e) for e in frame.elements]
    at = crack.share * lengths[crack.element]
    (named,) = best.elements
    if named != crack.element:  # seen from the first node of the element that was named
        if named == frame.beside(crack.element, 1):
            at -= lengths[crack.element]
        elif named == frame.beside(crack.element, 0):
            at += lengths[named]
        else:
            return []
    return [abs(told - at) / sum(lengths), low - _ROUNDED <= at <= high + _ROUNDED]


def kind_of(best):
    """What a hypothesis says has changed; versions before 0.2 know elements and something else."""
    return getattr(best, "kind", "unknown" if best.unknown else "element" if best.elements else "")


def is_right(one, best, alike):
    """Whether the best hypothesis is what has happened."""
    named = set() if best.unknown else set(best.elements)
    if one.kind not in OUTSIDE:
        if not one.allowed:
            return not named and (not best.unknown or (alike and one.may_shift))
        groups = one.allowed
        return len(named) == len(groups) and named <= set().union(*groups) and all(named & g for g in groups)
    if not named:
        told = kind_of(best) in ("unknown", one.kind)
        return told if best.unknown else one.change_in_std < UNSEEN
    return named <= one.touching


def above_a90(row):
    """Whether nine of ten tests would show all of the losses."""
    return all(loss >= row["a90"].get(e, 0.0) for e, loss in row["truth"].items())


def intervals(rows):
    """(inside, error of severity) of the losses of right answers."""
    found = []
    for row in rows:
        for e, loss in row["truth"].items() if row["right"] else ():
            if e in row["interval"]:
                low, high = row["interval"][e]
                found.append((low <= loss <= high, abs(row["severity"][e] - loss)))
    return found


def named_wrong(row):
    """Whether elements are named without reserve that have not been damaged."""
    return bool(row["best"]) and row["candidate"] and not row["right"] and row["best_probability"] > 0.99


def line(label, rows):
    """One row of the table."""
    damaged = [row for row in rows if row["truth"]]
    seen, held = [row for row in damaged if above_a90(row)], intervals(rows)
    sure = [row for row in rows if named_wrong(row)]
    errors = f"{100 * np.median([error for _, error in held]):.1f}" if held else "-"
    places = [row["place"] for row in rows if row.get("place")]
    place_error = f"{100 * np.quantile([error for error, _ in places], 0.9):.1f}" if places else "-"
    return [
        label,
        len(rows),
        sum(bool(row["damaged"]) for row in rows if not row["truth"]),
        sum(not row["candidate"] and not row["alike"] and not row["truth"] for row in rows)
        + sum(row["unknown"] or not row["candidate"] for row in damaged),
        sum(row["right"] for row in rows),
        f"{sum(row['right'] for row in seen)}/{len(seen)}",
        f"{sum(inside for inside, _ in held)}/{len(held)}",
        errors,
        f"{sum(inside for _, inside in places)}/{len(places)}",
        place_error,
        f"{len(sure)} ({sum(row['touching'] for row in sure)})",
        sum(row["nothing"] > 0.9 and not row["right"] for row in rows),
        f"{np.mean([row['seconds'] for row in rows]):.2f}",
    ]


HEADER = [
    "",
    "n",
    "alarms",
    "else",
    "right",
    "above a90",
    "90 % hold",
    "error %",
    "place holds",
    "its 90 % error",
]
HEADER += ["wrong > 0.99", "missed > 0.9", "CPU s"]


def reliability(rows):
    """Stated and observed probability of the best hypothesis, by class."""
    groups = {"all": list(KINDS)} | CLASSES
    judges = {name for name, one in STRUCTURES.items() if not one.sets_limits}
    lines = []
    for label, kinds in groups.items():
        own = [row for row in rows if row["kind"] in kinds]
        lines += [(label, own), (f"{label}, judging three", [r for r in own if r["structure"] in judges])]
    for label, own in lines:
        cells = []
        for low, high in pairwise(STATED):
            within = [row for row in own if low < row["best_probability"] <= high]
            stated = np.mean([row["best_probability"] for row in within]) if within else 0.0
            right = np.mean([row["right"] for row in within]) if within else 0.0
            cells.append(f"{stated:.3f} -> {right:.2f} ({len(within)})" if within else "-")
        if own:
            wrong = sum(row["best_probability"] > 0.99 and not row["right"] for row in own)
            yield [label, *cells, f"{wrong}/{len(own)}", sum(map(named_wrong, own))]


def told(rows):
    """All tables."""
    parts = {kind: [row for row in rows if row["kind"] == kind] for kind in KINDS}
    warm = parts.pop("temperature")
    parts["warmer, intact"] = [row for row in warm if not row["truth"]]
    parts["warmer, damaged"] = [row for row in warm if row["truth"]]
    parts["single and double"] = parts["single"] + parts["double"]
    lines = []
    for name in [*STRUCTURES, "all"]:
        for label, part in parts.items():
            of = [row for row in part if name in (row["structure"], "all")]
            lines += [line(f"{name}, {label}", of)] if of else []
    print_table(HEADER, lines, False)
    print()
    bins = ["0 to 0.5", "0.5 to 0.9", "0.9 to 0.99", "above 0.99"]
    print_table(["stated -> observed", *bins, "wrong > 0.99", "elements"], list(reliability(rows)), False)


def differences(rows, before):
    """Cases whose answer is another one."""
    known = {(r["structure"], r["kind"], r["number"], r["seed"]): r for r in before}
    gained = lost = 0
    for row in rows:
        old = known.get((row["structure"], row["kind"], row["number"], row["seed"]))
        if old is None or (old["best"], old["unknown"]) == (row["best"], row["unknown"]):
            continue
        gained, lost = gained + (row["right"] > old["right"]), lost + (row["right"] < old["right"])
        answers = " -> ".join(
            f"{r['best'] or ('else' if r['unknown'] else 'nothing')} {r['best_probability']:.3f}"
            f"{'' if r['right'] else ' (wrong)'}"
            for r in (old, row)
        )
        yield f"{row['structure']}, {row['kind']} {row['number']}: {answers}; truth {row['truth']}"
    yield f"right that were not: {gained}; no longer right: {lost}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--structures", nargs="+", default=list(STRUCTURES), choices=list(STRUCTURES))
    parser.add_argument("--kinds", nargs="+", default=list(KINDS), choices=list(KINDS))
    parser.add_argument("--intact", type=int, default=25)
    parser.add_argument("--single", type=int, default=25)
    parser.add_argument("--double", type=int, default=15)
    parser.add_argument("--others", type=int, default=10, help="cases of each other kind")
    parser.add_argument("--environment", nargs="+", help="what is said to differ, as in assess_damage")
    parser.add_argument("--records", action="store_true", help="values identified from records")
    parser.add_argument("--seed0", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, help="file for the rows, as JSON")
    parser.add_argument("--read", type=Path, nargs="+", help="tables of such files, and no new cases")
    parser.add_argument("--against", type=Path, help="rows of another version, compared case by case")
    given = parser.parse_args()
    counts = {"intact": given.intact, "single": given.single, "double": given.double}
    # By number, so that a part of a run holds some of everything.
    tasks = [
        (name, kind, number, given.seed0, given.environment, given.records)
        for number in range(max(*counts.values(), given.others))
        for kind in given.kinds
        for name in given.structures
        if kind in kinds_of(STRUCTURES[name]) and number < counts.get(kind, given.others)
    ]
    rows = [row for path in given.read or () for row in json.loads(path.read_text())]
    for row in each(one_case, [] if given.read else tasks, given.workers):
        rows.append(row)
        if len(rows) % 25 == 0 or len(rows) == len(tasks):
            print(f"{len(rows)} of {len(tasks)}", file=sys.stderr, flush=True)
            if given.out:
                given.out.write_text(json.dumps(rows))
    told(rows)
    if given.against:
        print("\n" + "\n".join(differences(rows, json.loads(given.against.read_text()))))


if __name__ == "__main__":
    main()
