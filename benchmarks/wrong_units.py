"""Wrong units, exchanged matrices, wrong dofs: does the first sentence say that the model explains nothing?

Sixteen mistakes with the models or values of ``reference/wrong_models.py``, with and without a baseline, and
right models (every term up to 2, 5 or 8 % off, intact or with one element 30 or 70 % weaker), which must keep
their headline. The package's limits were set on the structures ``SET_ON`` and are judged on ``JUDGED_ON``.

    python -m benchmarks.wrong_units                  # the mistakes, 3 minutes
    python -m benchmarks.wrong_units --right 20       # right models of 20 seeds, 10 minutes
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # before numpy: more threads make these small matrices slower

import argparse
import warnings
from itertools import product

import antires_rs as ar
from reference.wrong_models import JUDGED_ON, MISTAKES, ONLY_FRAMES, SET_ON

#: What the headline or the error has to say.
SAID = "does not explain the measurement"


def said(model, before, now, *, with_baseline):
    """The headline, or the error that takes its place."""
    options = {"baseline": before} if with_baseline else {"rng": 0}
    try:
        return ar.assess_damage(model, now, workers=1, **options).headline
    except ar.exceptions.InvalidInputError as error:
        return str(error)


def mistakes(structures, off=0.03):
    """A line for each mistake."""
    missed = count = hinted = 0
    for structure in structures:
        for name, wrong in MISTAKES.items():
            if name in ONLY_FRAMES and "chain" in structure.name:
                continue
            given = wrong(structure, *structure.states(0, off))
            for with_baseline in (True, False):
                line = said(*given, with_baseline=with_baseline)
                count += 1
                missed += SAID not in line
                hinted += "All measured values are about" in line or "swapped" in line
                kind = "baseline" if with_baseline else "one state"
                told = "yes" if SAID in line else "NO"
                print(f"{structure.name:16s} {name:34s} {kind:10s} {told:4s} {line[:120]}", flush=True)
    print(f"{count - missed} of {count} say so, {hinted} with the mistake\n")


def right(structures, seeds):
    """Right models whose headline is doubted all the same."""
    print("structure         model error  loss  with baseline  without")
    for structure, off, loss in product(structures, (0.02, 0.05, 0.08), (0.0, 0.3, 0.7)):
        doubted = [0, 0]
        elements = structure.build().default_elements
        for seed in range(1, seeds + 1):
            losses = {elements[seed % len(elements)]: loss} if loss else None
            before, now = structure.states(seed, off, losses)
            for place, with_baseline in enumerate((True, False)):
                line = said(structure.build(), before, now, with_baseline=with_baseline)
                doubted[place] += SAID in line
        figures = "   ".join(f"{each:3d} of {seeds}" for each in doubted)
        print(f"{structure.name:16s} {100 * off:10.0f} % {100 * loss:3.0f} %  {figures}", flush=True)


def main():
    """Print both tables."""
    warnings.simplefilter("ignore", ar.exceptions.AntiresWarning)
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--right", type=int, default=0, metavar="SEEDS", help="right models of so many seeds")
    seeds = parser.parse_args().right
    for title, structures in (("limits set on", SET_ON), ("judged on", JUDGED_ON)):
        print(f"{title}: {', '.join(each.name for each in structures)}")
        if seeds:
            right(structures, seeds)
        else:
            mistakes(structures)


if __name__ == "__main__":
    main()
